"""The driver of SmartMotors."""

import asyncio
from contextlib import suppress

import pytest

from axistwin import Bench
from axistwin.drivers import (
    AsyncController,
    DriverError,
    Pause,
    RefusedError,
    SilentError,
    WrongAnswerError,
    connect,
    make,
)
from axistwin.real.integrations import InnerPort, driver_inside

from ..told import raises


@pytest.fixture
def twin(ports):
    return ports.add("smartmotor")


@pytest.fixture
def motor(twin):
    with connect("smartmotor", "smartmotor") as controller:
        yield controller


def true_position(twin):
    return twin.axes["shaft"].position


def test_moves_end_at_the_exact_position(twin, motor):
    shaft = motor.axes["shaft"]
    shaft.move_to(400)
    shaft.move_to(-250)  # a new target during the motion
    assert shaft.wait(25).position == true_position(twin) == -250
    shaft.move_by(100)
    assert shaft.wait(25).position == -150
    shaft.set_position(7)
    assert shaft.position() == 7 and true_position(twin) == -150


def test_home_is_the_index(twin, motor):
    shaft = motor.axes["shaft"]
    shaft.move_to(500)
    shaft.wait(25)
    shaft.home(1)
    status = shaft.wait(25)
    assert status.position == true_position(twin) - 2500  # index marks are at 500, 2500 …
    shaft.home(1)
    shaft.stop()
    assert not shaft.wait(25).moving


def test_a_power_cut_between_the_check_and_the_move_is_noticed(twin, motor, monkeypatch):
    shaft = motor.axes["shaft"]
    set_profile = shaft.core._set_profile

    def after_a_power_cut():
        twin.power_cycle()
        yield Pause(0.1)
        yield from set_profile()

    monkeypatch.setattr(shaft.core, "_set_profile", after_a_power_cut)
    shaft.set_profile(acceleration=30_000)
    said = str(raises(RefusedError, "home the axis, or call set_position, then repeat the motion", shaft.move_to, 300))
    assert said.startswith("the position of shaft is lost, because the power of shaft was cut")
    assert shaft.status().lost and true_position(twin) == 0


def test_pins_programs_cams_and_streams(twin, motor):
    motor.outputs(A=True, B=False)
    assert motor.inputs()["A"] and not motor.inputs()["B"]
    raises(RefusedError, "the motor refused", motor.command, "KP175")
    motor.load("a=1\nb=2\nEND\n")
    assert motor.program().startswith("a=1\nb=2")
    motor.command("RUN")
    while motor.number("Rb") != 2:
        pass
    motor.stream([(0, 0), (256, 100), (512, 200), (512, 200)])
    while motor.axes["shaft"].status().moving:
        pass
    motor.cam([0, 100, 200, 300, 400, 300, 200, 100], 800)


def test_a_chain_gets_its_addresses(ports):
    left, right = (ports.add("smartmotor", name) for name in ("left", "right"))
    ports.chain(left, right, name="chain")
    with connect("chain", "smartmotor", addresses=[1, 2]) as line:
        line.axes["shaft1"].move_to(50)
        line.axes["shaft2"].move_to(-60)
        assert line.axes["shaft1"].wait(25).position == true_position(left) == 50
        assert line.axes["shaft2"].wait(25).position == true_position(right) == -60
        raises(RefusedError, "expected one of shaft1, shaft2", line.command, "RP", "shaft3")
        line.stream([(0, 50), (256, 60), (512, 70), (512, 70)], "shaft1")
        assert line.axes["shaft1"].wait(25).moving is False
        line.load("a=1\nEND\n", "shaft2")
        assert line.program("shaft2").startswith("a=1")


def test_a_program_that_is_not_stored_and_one_that_is_not_sent(ports):
    answers = {b"RSP": b"24576/476\r", b"RPW": b"0,128\r5\r", b"LOAD": b"\x06", b"RBk": b"1\r"}

    def answer(data):
        return next((found for request, found in answers.items() if request in data), b"")

    with connect(ports.answering(answer), "smartmotor") as motor:
        raises(RefusedError, "did not store the program", motor.load, "END")
        raises(SilentError, "did not send its complete program", motor.program)


@pytest.mark.parametrize(("answers", "error", "says"), [
    ([b""] * 3, SilentError, "no answer from shaft to RSP"),
    ([b"C\r"], WrongAnswerError, "expected a whole number|a sample period and a version"),
    ([b"24576/476\r", b"1,x\r5\r"], WrongAnswerError, "expected a whole number"),
    ([b"24576/476\r", b"1,1"], SilentError, "incomplete answer '1,1'"),
    ([b"RSP\r24576/476\r", b"RPW"], SilentError, "incomplete answer"),
    ([b"RSP\r24576/476\r", b"XXXXXXX"], WrongAnswerError, "check the line for noise")])  # fmt: skip
def test_garbage_raises_a_clear_error(ports, answers, error, says):
    left = iter(answers)
    with pytest.raises(error, match=says):
        connect(ports.answering(lambda _: next(left, b"")), "smartmotor", timeout=0.15)


def test_two_motors_on_an_rs485_line(ports):
    motors = [ports.add("smartmotor", f"m{number}") for number in (1, 2)]
    ports.run(0.3)
    for number, motor in enumerate(motors, 1):
        motor.serial.write(f"SADDR{number} OCHN(RS4,1,N,9600,1,8,C) ".encode())
    ports.run(0.3)
    ports.rs485(*motors, name="line")
    with connect("line", "smartmotor", addresses=[1, 2], rs485=True) as line:
        for name, target in (("shaft1", 200), ("shaft2", -300)):
            line.axes[name].move_to(target)
        assert [line.axes[name].wait(25).position for name in ("shaft1", "shaft2")] == [200, -300]
        assert list(map(true_position, motors)) == [200, -300]
        assert {name: status.position for name, status in line.statuses().items()} == {"shaft1": 200, "shaft2": -300}


class Interrupted(InnerPort):
    def __init__(self, bench, name, message, after):
        super().__init__(bench, name)
        self.motor, self.message, self.after = bench[name], message, after

    async def write(self, data):
        if data == self.message:
            self.message = b""
            await super().write(data[: self.after])
            await self.pause(0.02)
            self.motor.power_cycle()
            data = data[self.after :]
        await super().write(data)


async def move_with_a_power_cut(rs485, acceleration, message, after):
    """Return true if the driver notices that the power was cut while it sets the acceleration of a move."""
    bench = Bench()
    motor = bench.add("smartmotor")

    async def port():
        return Interrupted(bench, "smartmotor", message, after)

    shaft = AsyncController("", make("smartmotor", {"rs485": rs485}), opening=port).axes["shaft"]
    await shaft.move_to(100)
    await shaft.wait(25)
    shaft.set_profile(acceleration=acceleration)
    with suppress(DriverError):
        await shaft.move_to(200)
    lost = (await shaft.status()).lost
    assert motor.axes["shaft"].position == 100
    await shaft.set_position(100)
    shaft.set_profile(acceleration=50_000)
    await shaft.move_to(50)
    assert (await shaft.wait(25)).position == motor.axes["shaft"].position == 50
    return lost == "the power of shaft was cut"


@pytest.mark.parametrize("rs485", [False, True])
@pytest.mark.parametrize(("acceleration", "message"), [
    (30_000, b"A=A+40 RA\r"), (40_000, b"A=A+80 RA\r"), (15_000, b"A=A-20 RA\r")])  # fmt: skip
def test_a_power_cut_while_a_move_begins_is_noticed(rs485, acceleration, message):
    """The power is cut between the reading of the state and the move; the acceleration before it is 79 units."""
    for after in range(len(message) + 1):
        assert asyncio.run(move_with_a_power_cut(rs485, acceleration, message, after)), after


def test_accelerations_and_a_cut_line_leave_the_position():
    async def session():
        bench = Bench()
        motor = bench.add("smartmotor")
        driver = driver_inside(bench, "smartmotor", timeout=0.2)
        shaft = driver.axes["shaft"]
        for number, acceleration in enumerate((20_000, 40_000, 80_000, 7_000, 300), 1):
            shaft.set_profile(acceleration=acceleration)
            await shaft.move_to(10 * number)
            assert (await shaft.wait(25)).position == 10 * number
            shaft.core._setting = shaft.core._set_acceleration + 1  # as after a request that was not answered
            await driver.close()
            assert not (await shaft.status()).lost
        assert motor.axes["shaft"].position == 50

    asyncio.run(session())
