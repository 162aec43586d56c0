"""An emulated controller drives a simulated board: the board makes its pulses, and a stop corrects its position."""

from functools import partial

import numpy as np
import pytest

from axistwin import Bench
from axistwin.real.standin.driver import Driver
from axistwin.real.standin.events import Failed, Ready, Stopped
from axistwin.real.standin.wiring import AxisPins, BoardPin, InputPin, OutputPin, Wiring

from .metal import BLOCK, INPUT, LIMIT, OUTPUT, TICK_S, Metal, X, Y
from .small_board import SmallBoard

Z = AxisPins("table.Z", *map(BoardPin, ("P12", "P13", "P14")))


class Twin:
    def __init__(self, model="if1", axes=(X, Y, Z), inputs=(LIMIT, INPUT), outputs=(OUTPUT,), **options):
        self.metal = Metal(axes=axes, inputs=inputs, outputs=outputs)
        self.metal.start()
        self.bench, self.lines = Bench(), []
        self.controller = self.bench.add(model, "table", **options)
        self.driver = Driver(self.bench, [self.metal.board], self.lines.append)
        self._taken = 0
        self._take()
        self.driver.begin(self.metal.now)

    def _take(self):
        for event in self.metal.events[self._taken :]:
            self.driver.handle(self.metal.board, event)
        self._taken = len(self.metal.events)

    def run(self, seconds):
        def each(now):
            self.bench.run(TICK_S)
            self._take()
            if round(now / TICK_S) % BLOCK == 0:
                self.driver.collect()

        self.metal.run(seconds, each)

    def say(self, text, seconds=0.2):
        self.controller.serial.write(text)
        self.run(seconds)
        return self.controller.serial.read()

    def initialise(self):
        self.run(0.3 + self.controller.given.get("self_test_s", 1.3))
        self.say(b"(")
        self.say(b"U61\r", 1.3)


@pytest.fixture
def if1():
    twin = Twin(line="instant", self_test_s=0.1)
    twin.initialise()
    return twin


def test_a_controller_drives_three_axes(if1):
    if1.say(b"X+900Y-900Z @ 1500 $ \r", 1.5)
    if1.say(b"X-100 $ \r", 1.0)
    for axis, pin in (("X", 2), ("Y", 5), ("Z", 12)):
        virtual = if1.controller.axes[axis].pulse_times() / 1e9
        made = if1.metal.small.pulses[pin]
        assert len(made) == len(virtual)
        real = np.array([if1.metal.small.time_s(tick) for tick, _ in made])
        errors = (real - virtual - np.median(real - virtual)) * 1e6
        assert np.abs(errors).max() < 5, axis
        assert (
            sum(direction for _, direction in made) * (-1 if axis == "Y" else 1) == if1.controller.axes[axis].position
        )


def test_after_a_limit_the_controller_has_the_position_of_the_board(if1):
    if1.say(b"X2000 @ 1000 $ \r", 0.7)
    if1.metal.small.levels[8] = 0
    if1.run(1.0)
    made = len(if1.metal.small.pulses[2])
    assert 100 < made < 1000 and if1.controller.axes["X"].position == made
    assert if1.say(b"N\r") == b"%d\r" % made and if1.say(b"K\r") == b"64\r"
    assert if1.lines == [f"table.limit_plus stopped the motion: table.X at {made}, table.Y at 0, table.Z at 0"]
    if1.say(b"X-30 $ \r", 1.0)  # a move away from the switch
    assert if1.controller.axes["X"].position == made - 30


def test_after_a_stop_the_user_must_continue(if1):
    if1.say(b"X2000 @ 1000 $ \r", 0.7)
    assert not if1.driver.still
    if1.driver.stop("stopped by the user")
    if1.run(3.0)
    made = len(if1.metal.small.pulses[2])
    assert if1.lines == ["stopped: small: stopped by the user"]
    if1.driver.stop("end of the run")  # the positions at the end of a run that was stopped before
    if1.run(0.1)
    assert if1.driver.still and if1.driver.positions["table.X"] == made
    if1.say(b"X100 $ \r", 1.0)
    assert len(if1.metal.small.pulses[2]) == made
    if1.driver.go_on(if1.metal.now)
    if1.run(0.1)
    assert if1.controller.axes["X"].position == made and not if1.driver.still
    if1.say(b"X100 $ \r", 1.0)
    assert len(if1.metal.small.pulses[2]) == made + 100 and if1.controller.axes["X"].position == made + 100


def test_after_a_shutdown_of_the_board_the_user_must_continue(if1):
    if1.say(b"X500 $ \r", 2.0)
    if1.metal.small.do_emergency_stop = SmallBoard.do_emergency_stop.__get__(if1.metal.small)
    if1.metal.board.shut_down()
    if1.run(1.0)
    assert if1.lines == ["stopped: small: the board has stopped: Command request"]
    if1.driver.go_on(if1.metal.now)
    if1.run(2.0)
    if1.say(b"X-200 $ \r", 1.5)
    assert if1.controller.axes["X"].position == 300 and len(if1.metal.small.pulses[2]) == 700


class OtherBoard:
    def __init__(self, *axes):
        self.wiring, self.calls = Wiring("other", axes), []

    def __getattr__(self, name):
        return lambda *values: self.calls.append((name, *values))

    def stops(self):
        return [call for call in self.calls if call[0] == "stop"]


@pytest.mark.parametrize(("event", "reason"), [
    (Stopped("table.limit_plus stopped the motion", {"table.X": 7}, "table.limit_plus"), "limit_plus stopped"),
    (Stopped("late by 34 ms", {"table.X": 7}), "late by 34 ms"),
    (Failed("the board does not answer"), "the board does not answer")])  # fmt: skip
def test_axes_of_one_controller_on_two_boards_stop_together(event, reason):
    bench, first, second, third = Bench(), OtherBoard(X), OtherBoard(Y), OtherBoard(Z)
    bench.add("if1", "table")
    bench.add("if1", "third")
    third.wiring = Wiring("third", (AxisPins("third.X", X.step, X.direction),))
    driver = Driver(bench, [first, second, third], lambda line: None)
    for board, axes in ((first, {"table.X": 0}), (second, {"table.Y": 0}), (third, {"third.X": 0})):
        driver.handle(board, Ready(axes, {}))
    driver.begin(10.0)
    driver.handle(first, event)
    [(_, said, groups)] = second.stops()
    assert reason in said and groups == ("table",)
    assert not driver.still
    driver.handle(second, Stopped(said, {"table.Y": 3}))
    driver.handle(third, Stopped(said, {"third.X": 0}))
    assert driver.still is (type(event) is Stopped) and first.stops() == third.stops() == []
    assert (bench["table"].axes["Y"].position, driver.positions["table.Y"]) == (3, 3)
    driver.go_on(11.0)
    bench.run(0.1)
    driver.collect()
    bench.run(0.1)
    driver.handle(first, Ready({"table.X": 7}, {}))
    driver.collect()
    bench.run(0.1)
    driver.collect()
    assert ("resume", "table") in second.calls


def test_inputs_and_outputs(if1):
    assert not if1.controller.pins["input1"].level
    if1.metal.small.levels[9] = 0
    if1.run(0.1)
    assert if1.controller.pins["input1"].level
    if1.say(b"S1 $ \r", 0.05)
    assert if1.controller.pins["output1"].level
    if1.run(0.2)
    assert if1.metal.small.levels[10] == 1


def send(twin, *values, seconds):
    for value in values:
        twin.controller.bus.write(0, value)
    twin.controller.bus.write(1, 0x10)
    twin.run(seconds)


@pytest.fixture
def homing():
    """Return an 1811 with a home switch that the real motor closes between 500 and 700 pulses."""
    axis, home = AxisPins("table.motor", X.step, X.direction, X.enable), InputPin("table.home", BoardPin("P9"))
    limit = InputPin("table.cw_limit", BoardPin("P8", inverted=True), stops=+1, stops_at=True)
    twin = Twin("1811", (axis,), (home, limit), ())
    metal_run, made = twin.metal.run, twin.metal.small.pulses[2]
    position = counted = 0

    def run(seconds, each):
        def turn(now):
            nonlocal position, counted
            position += sum(direction for _, direction in made[counted:])
            counted = len(made)
            twin.metal.small.levels[9] = int(500 <= position < 700)
            each(now)

        metal_run(seconds, turn)

    twin.metal.run = run
    twin.run(1.2)
    send(twin, 0x31, 0, 0, *(2000).to_bytes(4, "big"), *(100_000).to_bytes(4, "big"), seconds=0.1)
    send(twin, 0x38, 1, 0, 5, 0, seconds=0.1)
    return twin


def test_homing_finds_the_switch_again_after_a_stop(homing):
    """The switch is detected a horizon and 20 ms late each time, so the home position is the same each time."""
    send(homing, 0x39, 0, seconds=6.0)
    found = net(homing)
    assert 690 < found < 740
    send(homing, 0x33, *(-1700 & 0xFFFF_FFFF).to_bytes(4, "big"), seconds=0.5)
    homing.driver.stop("stopped by the user")
    homing.run(3.0)
    assert found - 1700 < net(homing) < found
    homing.driver.go_on(homing.metal.now)
    homing.run(0.2)
    send(homing, 0x39, 0, seconds=7.0)
    assert abs(net(homing) - found) <= 2 and homing.controller.axes["motor"].position == net(homing)


def test_an_1811_drives_a_legacy_drive():
    limit = InputPin("table.cw_limit", BoardPin("P8", inverted=True), stops=+1, stops_at=True)
    axis = AxisPins("table.motor", X.step, X.direction, X.enable)
    twin = Twin("1811", (axis,), (limit,), (OutputPin("table.shutdown", OUTPUT.pin),))
    board, small = twin.controller, twin.metal.small
    twin.run(1.2)
    command = partial(send, twin)
    command(0x31, 0, 0, *(1000).to_bytes(4, "big"), *(100_000).to_bytes(4, "big"), seconds=0.1)
    command(0x33, *(1500).to_bytes(4, "big"), seconds=0.9)
    small.levels[8] = 0
    twin.run(0.5)
    made = len(small.pulses[2])
    assert 300 < made < 1500 and board.axes["motor"].position == made
    assert board._device._board.pulses.position == made
    command(0x12, seconds=0.3)  # shutdown
    assert board.pins["shutdown"].level == bool(small.levels[10])


@pytest.fixture
def smartmotor():
    """Return a SmartMotor whose encoder counts are the pulses of a drive with a step input."""
    limits = (
        InputPin("table.C", BoardPin("P8", inverted=True), stops=+1, stops_at=True),
        InputPin("table.D", BoardPin("P9", inverted=True), stops=-1, stops_at=True),
    )
    twin = Twin("smartmotor", (AxisPins("table.shaft", X.step, X.direction, X.enable),), limits, ())
    twin.say(b"ZS ")
    twin.run(1.5)
    return twin


def net(twin, pin=2):
    return sum(direction for _, direction in twin.metal.small.pulses[pin])


def test_a_servo_drives_a_drive_with_a_step_input(smartmotor):
    smartmotor.say(b"A=100 V=100000 P=2000 G ", 1.5)
    shaft = smartmotor.controller.axes["shaft"]
    smartmotor.run(0.2)
    assert (net(smartmotor), shaft.position) == (2000, 2000)
    smartmotor.say(b"P=-500 G ", 1.5)
    smartmotor.run(0.2)
    assert (net(smartmotor), shaft.position) == (-500, -500)


def test_a_servo_has_the_position_of_the_real_motor_after_a_limit(smartmotor):
    smartmotor.say(b"A=100 V=60000 P=20000 G ", 1.5)
    smartmotor.metal.small.levels[8] = 0
    smartmotor.run(0.5)
    made, shaft = net(smartmotor), smartmotor.controller.axes["shaft"]
    assert 100 < made < 20000 and shaft.position == made
    assert smartmotor.lines[0] == f"table.C stopped the motion: table.shaft at {made}"
    smartmotor.say(b"RPE ", 0.1)
    smartmotor.metal.small.levels[8] = 1
    smartmotor.say(b"ZS P=0 G ", 2.0)
    assert (net(smartmotor), shaft.position) == (0, 0)


def test_a_stopped_servo_waits_for_the_user(smartmotor):
    smartmotor.say(b"A=100 V=60000 P=20000 G ", 1.0)
    smartmotor.driver.stop("stopped by the user")
    smartmotor.run(1.0)
    made = net(smartmotor)
    assert smartmotor.controller.axes["shaft"].position == made
    assert smartmotor.say(b"RP\r", 0.2).strip() == b"%d" % made and 100 < made < 20000
    smartmotor.driver.go_on(smartmotor.metal.now)
    smartmotor.run(0.5)
    assert net(smartmotor) == made
    smartmotor.say(b"ZS P=0 G ", 2.0)
    assert (net(smartmotor), smartmotor.controller.axes["shaft"].position) == (0, 0)
