"""What a message of a driver tells the user to do leads out: each test does it literally, then moves again."""

import ast
import asyncio
import socket
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest

import axistwin
import axistwin.drivers
from axistwin.drivers import (
    BusyError,
    PortError,
    PositionLostError,
    RefusedError,
    SilentError,
    StoppedError,
    WrongAnswerError,
    connect,
    connect_async,
)

from ..told import raises
from .devices import url_of
from .test_arrival import AXES, by_another_host


def moves(twin, axis, distance=50):
    """Move, and compare with the true position."""
    true = twin.axes[axis.name.rstrip("0123456789")]
    before = true.position
    axis.move_by(distance)
    axis.wait(60)
    assert true.position - before == distance
    return True


@contextmanager
def connected(ports, model, *, options=None, **driver_options):
    """Yield a controller, its driver and its first axis; at the end no fault is left, and the axis moves."""
    twin = ports.add(model, **(options or {}))
    with connect(model, model, **driver_options) as controller:
        axis = controller.axes[AXES[model]]
        axis.set_profile(velocity=2000)
        yield twin, controller, axis
        assert not axis.status().faults and moves(twin, axis)


def toggle(pin):
    pin.drive(not pin.level)


def fault(status, name):
    return next(found.remedy for found in status.faults if found.name == name)


def switches(model, *limits):
    return {AXES[model]: {"limits": limits or [-500, 500]}}


# Limits


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("model", ["if1", "smartmotor"])
def test_after_a_limit(ports, model, sign):
    remedy = {
        "if1": "call clear_faults and move away from the limit",
        "smartmotor": "call clear_faults, move away from the limit, then call clear_faults again",
    }[model]
    limits = {"limits": True} if model == "smartmotor" else {}
    with connected(ports, model, options=switches(model), **limits) as (twin, _, axis):
        for begin, target in ((axis.move_to, 5000), (axis.move_at, 900)):
            begin(sign * target)
            ports.run(10)
            for distance in (100, -100):
                raises(RefusedError, remedy, axis.move_by, distance)
            axis.clear_faults()
            assert moves(twin, axis, -sign * 300)
            if remedy.endswith("again"):
                axis.clear_faults()
            assert not axis.status().faults
            assert moves(twin, axis, sign * 20) and moves(twin, axis, -sign * 20)
        axis.move_to(0)
        axis.wait(60)


def test_a_stream_away_from_a_limit_arrives(ports):
    with connected(ports, "smartmotor", options=switches("smartmotor"), limits=True) as (_, motor, shaft):
        shaft.move_at(900)
        start = shaft.wait(60).position
        shaft.clear_faults()
        path = [(2560 * number, round(start) - 100 * number) for number in range(1, 5)]
        motor.stream([(0, start), *path, path[-1]])
        assert shaft.wait(60).position == start - 400
        shaft.clear_faults()


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("model", ["if1", "1811"])
def test_at_a_limit_that_is_active(ports, model, sign):
    with connected(ports, model, options=switches(model)) as (twin, _, axis):
        axis.move_to(sign * 5000)
        ports.run(10)
        status = axis.status()
        assert (status.limit_plus, status.limit_minus) == (sign > 0, sign < 0)
        assert status.position == twin.axes[axis.name].position
        if model == "1811":
            raises(StoppedError, "move in the other direction", axis.wait, 1)
        axis.clear_faults()
        raises(RefusedError, "limit is active: move in the other direction", axis.move_by, sign * 100)
        assert moves(twin, axis, -sign * 300) and moves(twin, axis, sign * 20)
        axis.move_to(0)
        axis.wait(60)


@pytest.mark.parametrize("model", AXES)
def test_with_both_limits_active(ports, model):
    pins = {"if1": ("limit_plus", "limit_minus"), "1811": ("cw_limit", "ccw_limit"), "smartmotor": "CD"}[model]
    with connected(ports, model, **({"limits": True} if model == "smartmotor" else {})) as (twin, _, axis):
        if model == "smartmotor":  # its pins are open
            assert {"positive limit", "negative limit"} <= {found.name for found in axis.status().faults}
        else:
            for pin in pins:
                toggle(twin.pins[pin])
        axis.clear_faults()
        says = "both limits are active: check the limit switches and their wiring, then call clear_faults"
        raises(RefusedError, says, axis.move_by, 50)
        for pin in pins:
            toggle(twin.pins[pin])
        axis.clear_faults()


def test_a_motor_without_switches(ports):
    with connected(ports, "smartmotor", limits=True) as (_, motor, shaft):
        raises(RefusedError, "; without switches, call command('UCI UDI') before", shaft.move_by, 50)
        motor.command("UCI UDI")
        shaft.clear_faults()


def test_the_limits_act_after_an_earlier_connection_without_them(ports):
    with connected(ports, "smartmotor", options=switches("smartmotor")):
        pass
    with connect("smartmotor", "smartmotor", limits=True) as motor:
        motor.axes["shaft"].move_to(5000)
        raises(StoppedError, "positive limit", motor.axes["shaft"].wait, 60)


# Faults of an IF1


@pytest.mark.parametrize("moving", [True, False])
def test_after_an_emergency_stop(ports, moving):
    with connected(ports, "if1") as (twin, _, x):
        if moving:
            x.move_at(900)
        twin.pins["estop"].drive(False)
        remedy = fault(x.wait(60), "emergency stop")
        assert remedy == "release the button, then call clear_faults"
        raises(RefusedError, remedy, x.move_by, 5)
        twin.pins["estop"].drive(True)
        x.clear_faults()


@pytest.mark.parametrize("moving", [True, False])
def test_after_a_drive_fault(ports, moving):
    with connected(ports, "if1") as (twin, _, x):
        if moving:
            x.move_to(5000)
        toggle(twin.pins["x_fault"])
        ports.run(1)
        status = x.status()
        assert fault(status, "drive fault") == "check the drive, then call clear_faults and set_position"
        assert ("drive fault" in status.lost) == moving
        with pytest.raises((RefusedError, PositionLostError), match=r"and set_position|, or call set_position"):
            x.move_by(5)
        toggle(twin.pins["x_fault"])
        x.clear_faults()
        x.set_position(0)


@pytest.mark.parametrize(("name", "remedy"), [
    ("PARITY", "check the line format, then call clear_faults"),
    ("FRAMING", "check the line format, then call clear_faults"),
    ("OVERRUN", "use the echo or a lower baud rate, then call clear_faults"),
    ("DATA", "check the command, then call clear_faults"),
    ("RANGE", "check the command and the speed range, then call clear_faults")])  # fmt: skip
def test_after_a_communication_fault(ports, name, remedy):
    """Such a fault inhibits no move: one that ends before it is seen is made, and known."""
    with connected(ports, "if1") as (twin, _, x):
        faults = twin._device._interface.faults
        faults.raise_line(type(faults.line)[name])
        assert [found.remedy for found in x.status().faults] == [remedy] and moves(twin, x, 1)
        x.clear_faults()


@pytest.mark.parametrize(("wrong", "right"), [("X10Q$", "X10$"), ("X10@99999$", "X10@999$")])
def test_after_a_message_that_the_interface_refuses(ports, wrong, right):
    with connected(ports, "if1") as (twin, if1, x):
        said = str(raises(RefusedError, "refused the message ", if1.begin, {"X": 1}, 10, 100, wrong))
        assert "check the command" in said
        x.clear_faults()
        if1.begin({"X": 1}, 10, 100, right)
        assert x.wait(60).position == twin.axes["X"].position == 10


# Faults of a SmartMotor


def test_after_a_position_wrap(ports):
    with connected(ports, "smartmotor") as (_, _, shaft):
        shaft.set_position(2**31 - 500)
        shaft.move_at(2000)
        ports.run(2)
        shaft.stop()
        assert fault(shaft.wait(60), "position wrap") == "call clear_faults and set_position"
        shaft.clear_faults()
        shaft.set_position(0)


def test_after_a_position_error(ports):
    with connected(ports, "smartmotor") as (twin, _, shaft):
        twin.axes["shaft"].jam(True)
        shaft.move_to(40_000)
        raises(StoppedError, "remove the load that blocks the shaft, then call clear_faults", shaft.wait, 60)
        twin.axes["shaft"].jam(False)
        shaft.clear_faults()


def test_after_overheat(ports):
    with connected(ports, "smartmotor") as (_, motor, shaft):
        motor.command("THD=100 TH=10")
        ports.run(1)
        raises(RefusedError, "let the motor cool down, then call clear_faults", shaft.move_to, 50)
        motor.command("TH=70")  # it is cool now
        shaft.clear_faults()


def test_after_over_current(ports):
    twin = ports.add("smartmotor", shaft={"motor": "frame23"})
    with connect("smartmotor", "smartmotor") as motor:
        shaft = motor.axes["shaft"]
        twin.axes["shaft"].jam(True)
        motor.command("E=32000 A=1000 V=400000 P=2000 G")
        ports.run(0.5)
        assert fault(shaft.status(), "over-current") == "check the load, then call clear_faults"
        shaft.abort()
        twin.axes["shaft"].jam(False)
        ports.run(1)
        shaft.set_position(0)
        shaft.clear_faults()
        shaft.set_profile(velocity=900)
        shaft.move_to(50)
        assert abs(shaft.wait(60).position - 50) < 20 and not shaft.status().faults


def test_after_a_broken_download(ports):
    twin = ports.add("smartmotor")
    for data in (b"UCI UDI ZS ", b"LOAD ", b"a=5\nb=6\n"):
        twin.serial.write(data)
        ports.run(0.2)
    twin.power_cycle()
    ports.run(1)
    with connect("smartmotor", "smartmotor") as motor:
        shaft = motor.axes["shaft"]
        assert fault(shaft.status(), "stored program") == "load the program again"
        motor.load("a=1\nEND\n")
        assert moves(twin, shaft) and not shaft.status().faults


# The position


@pytest.mark.parametrize("way", ["home", "set_position"])
@pytest.mark.parametrize(("model", "lost"), [
    ("if1", "the power of the IF1 was cut"), ("1811", "was reset"), ("smartmotor", "the power of shaft was cut")
])  # fmt: skip
def test_after_a_loss_of_the_position(ports, model, lost, way):
    options = {"1811": {"motor": {"home": [150, 5000]}}}.get(model)
    driver = {"if1": {"home_input": 1}, "1811": {"home_edge_ccw": True}}.get(model, {})
    with connected(ports, model, options=options, **driver) as (twin, _, axis):
        assert moves(twin, axis)
        twin.power_cycle()
        if model == "if1":  # which tells it so
            raises(SilentError, "check the power", axis.status)
        ports.run(2)
        with suppress(SilentError):
            axis.status()
        assert lost in axis.status().lost
        raises(PositionLostError, "home the axis, or call set_position", axis.position)
        raises(PositionLostError, "home the axis, or call set_position", axis.move_to, 5)
        if way == "set_position":
            axis.set_position(70)
        else:
            axis.home(1)
            ports.run(1)
            if model == "if1":
                twin.pins["input1"].drive(True)
            axis.wait(60)
        before = axis.position()
        assert moves(twin, axis) and axis.position() == before + 50


@pytest.mark.parametrize("model", ["if1", "1811"])
def test_a_position_is_set_at_rest(ports, model):
    with connected(ports, model) as (_, _, axis):
        axis.move_to(900)
        raises(BusyError, "the position can only be set at rest", axis.set_position, 0)
        axis.wait(60)
        axis.set_position(0)
        assert axis.position() == 0


@pytest.mark.parametrize("model", AXES)
def test_after_a_stop_by_another_host(ports, model):
    with connected(ports, model) as (twin, controller, axis):
        axis.move_to(4000)
        ports.run(0.5)
        by_another_host(controller, model)
        raises(StoppedError, "begin the motion again", axis.wait, 60)
        axis.move_to(4000)
        assert axis.wait(60).position == twin.axes[AXES[model]].position == 4000


# Motions in progress


@pytest.mark.parametrize("way", ["wait", "stop"])
@pytest.mark.parametrize(("model", "remedy"), [
    ("if1", "wait for the end of the motion, or stop the axes"),
    ("1811", "wait for the end of the motion, or stop the motor")])  # fmt: skip
def test_a_motion_in_progress(ports, model, remedy, way):
    with connected(ports, model) as (_, controller, axis):
        y = controller.axes.get("Y")
        others = {
            "if1": lambda: [
                (y.move_to, 5), (y.move_by, 5), (y.move_at, 5), (controller.move_together, {"Y": 5, "Z": 5}),
                (controller.sequence, ["Y5"]),
            ],
            "1811": lambda: [(axis.move_to, 0), (axis.move_by, 5), (axis.home, 1),
                             (controller.define_sequence, 1, [bytes([0x33, 0, 0, 0, 9])])],
        }[model]()  # fmt: skip
        for other, *given in others:
            axis.move_by(4000)
            raises(SilentError, "still moving after 0.1 s: stop it, or wait longer", axis.wait, 0.1)
            raises(BusyError, remedy, other, *given)
            if way == "stop":
                axis.stop()
            axis.wait(60)
            other(*given)
            axis.stop()
            axis.wait(60)
            for each in controller.axes.values():
                each.set_position(0)


# Home


def test_at_the_home_switch(ports):
    with connected(ports, "if1", home_input=1) as (twin, _, x):
        twin.pins["input1"].drive(True)
        raises(RefusedError, "is already high: move the axis away from the home switch", x.home, 1)
        assert moves(twin, x, -50)
        twin.pins["input1"].drive(False)  # away from it
        x.home(1)
        twin.pins["input1"].drive(True)
        assert x.wait(60).position == 0


def test_after_a_search_for_home_that_failed(ports):
    twin = ports.add("1811", motor={"home": [150, 5000], "limits": [-300, 300]})
    wire = ports.faults.add("stuck", "1811.home", level="low")
    with connect("1811", "1811", home_edge_ccw=True) as board:
        motor = board.axes["motor"]
        motor.set_profile(velocity=2000, acceleration=100_000)
        motor.home(1)
        remedy = "home not found: check the home switch and home_definition, then call clear_faults"
        assert raises(StoppedError, remedy, motor.wait, 60).status.position == twin.axes["motor"].position
        wire.mend()
        motor.clear_faults()
        assert not motor.status().faults
        motor.home(-1)
        assert motor.wait(60).position == 0 and moves(twin, motor, -50)


# A board that does not go on


@pytest.mark.parametrize("out", ["reset", "power_cycle"])
@pytest.mark.parametrize("again", [False, True])
def test_after_a_failure_of_the_board(ports, again, out):
    """The program may also have been started after the failure."""
    remedy = "call reset, or switch its power off and on; the position is then lost"
    twin = ports.add("1811")
    board = connect("1811", "1811")
    board.command(0xFF)  # the test function ends in the Fail state after 10 s
    assert ports.run_until(lambda: twin.bus.read(1) & 0x20, 25)
    if again:
        board.close()
        board = connect("1811", "1811")
    with board:
        motor = board.axes["motor"]
        assert fault(motor.status(), "board failure") == remedy
        if not again:
            raises(RefusedError, remedy, motor.move_to, 5)
            raises(RefusedError, remedy, board.command, 0x70)
        board.reset() if out == "reset" else twin.power_cycle()
        assert again or motor.status().lost
        motor.set_position(0)
        assert moves(twin, motor) and not motor.status().faults


class Hung:
    """A port at a board that hangs until it is reset; `status` is its status byte."""

    def __init__(self, ports, port, status):
        self._ports, self._port, self._status, self._answers = ports, port, status, b""

    def write(self, data):
        for line in data.decode().splitlines(keepends=True):
            if line.startswith("w 1 20"):
                self._status = None
            if self._status is None:
                self._port.write(line.encode())
            elif line.startswith("r"):
                self._answers += b" ".join([self._status] * int([*line.split(), "1"][2])) + b"\n"
            elif line.strip():
                self._answers += b"ok\n"

    def read(self, timeout):
        if self._answers or self._status is not None:
            data, self._answers = self._answers, b""
            self._ports.sleep(0.0005 if data else timeout)
            return data
        return self._port.read(timeout)

    def close(self):
        self._port.close()


@pytest.mark.parametrize(("status", "says"), [(b"00", "is not ready"), (b"10", "does not answer the command 01h")])
def test_after_a_board_that_hangs(ports, monkeypatch, status, says):
    with connected(ports, "1811") as (_, board, motor):
        monkeypatch.setattr(board, "_port", Hung(ports, board._port, status))
        raises(SilentError, "", motor.status)
        with pytest.raises(SilentError, match=rf"{says}.*: call reset, or switch its power off and on"):
            motor.status()
        board.reset()
        motor.set_position(0)


def test_after_a_request_without_its_conditions(ports):
    with connected(ports, "1811") as (_, board, motor):
        # 91h: "the parameters of a defined move"
        raises(SilentError, "check the conditions for this request in the board's manual", board.request, 0x91, 50)
        motor.move_at(100)
        motor.stop()
        motor.wait(60)
        assert any(board.request(0x91, 50))  # `move_at` has defined it


def test_after_a_stream_that_came_too_late(ports):
    ports.access_s = 5e-3
    with connected(ports, "1811") as (_, board, motor):
        remedy = "expected a larger update_ms, i.e. a longer time for each velocity"
        said = str(raises(RefusedError, remedy, board.stream_times, 2, 4, 1, [100] * 5_000 + [0]))
        assert "the next velocities arrived at the board too late" in said
        assert not motor.wait(25).moving
        board.stream_times(100, 4, 1, [100] * 400 + [0])
        motor.wait(600)


# The line


def spoiled(controller, monkeypatch, request, answer, *, times=1):
    port, left = controller._port, [answer] * times
    read, write = port.read, port.write

    def write_spoiled(data):
        write(data)
        if request in data and left:
            spoil.append(left.pop())

    spoil = []

    def read_spoiled(timeout):
        data = read(timeout)
        return spoil.pop() if spoil and data else data

    monkeypatch.setattr(port, "write", write_spoiled)
    monkeypatch.setattr(port, "read", read_spoiled)


@pytest.mark.parametrize(("model", "request_", "answer", "says"), [
    ("if1", b"K", b"Q", "check the line for noise"), ("if1", b"K", b"K\r\n" + b"9" * 5000, "check"),
    ("1811", b"r", b"zz\n", "expected 1 hex bytes"), ("smartmotor", b"RPW", b"x,y\r", "expected a whole number"),
    ("smartmotor", b"RPW", b"X" * 5000, "check that the controller is connected to this port")])  # fmt: skip
def test_after_noise(ports, monkeypatch, model, request_, answer, says):
    with connected(ports, model) as (_, controller, axis):
        spoiled(controller, monkeypatch, request_, answer)
        raises(WrongAnswerError, says, axis.status)


AT_THE_LINE = (
    "check the line for noise or a second host", "check the power, the cable and the line format",
    "check the board's power and the address of the bus socket (bus://)",
    "check the port, the cable and the baud rate, and the motor's power and address",
)  # fmt: skip
"""Work at the line, which the tests of noise and of the power do."""


@pytest.mark.parametrize("model", ["if1", "smartmotor"])
def test_after_a_power_that_was_off(ports, model):
    with connected(ports, model) as (twin, _, axis):
        twin.power(False)
        raises((SilentError, WrongAnswerError), "power", axis.status)
        twin.power(True)
        ports.run(2)
        axis.set_position(0)


def test_after_a_program_that_is_locked(ports):
    with connected(ports, "smartmotor") as (_, motor, _):
        motor.load("a=1\nEND\n")
        motor.command("LOCKP")
        remedy = "check the cable, and check whether the command LOCKP has locked the program"
        raises(SilentError, remedy, motor.program)
        motor.load("b=1\nEND\n")  # a new program is not locked
        assert motor.program().startswith("b=1")


def arrives(motor):
    motor.axes["shaft"].move_to(40)
    return motor.axes["shaft"].wait(60).position == 40


def test_after_a_server_that_was_not_there():
    with socket.create_server(("127.0.0.1", 0)) as held:
        port = held.getsockname()[1]
    url = f"tcp://127.0.0.1:{port}"
    raises(PortError, "start the server, and check the address", connect, url, "smartmotor")
    scene = {"controller": [{"model": "smartmotor", "ports": [url]}]}
    with axistwin.serve(scene, speed=5.0, fixed_ports=True), connect(url, "smartmotor") as motor:
        assert arrives(motor)


def test_after_a_wrong_name():
    remedy = "check the name of the port, the cable and your permissions"
    raises(PortError, remedy, connect, "/dev/nothing", "smartmotor")
    with axistwin.serve("smartmotor", speed=5.0, scheme="pty") as twin, connect(url_of(twin), "smartmotor") as motor:
        assert arrives(motor)


@pytest.mark.parametrize("asynchronous", [False, True])
def test_after_a_port_that_was_disconnected(asynchronous):
    async def session(url):
        async with await connect_async(url, "smartmotor") as motor:
            motor._port._writer.transport.get_extra_info("socket").shutdown(socket.SHUT_RDWR)
            with pytest.raises(PortError, match=r"check that the server is still running, then try again|disconn"):
                await motor.axes["shaft"].status()
            await motor.axes["shaft"].move_to(40)
            assert (await motor.axes["shaft"].wait(60)).position == 40

    with axistwin.serve("smartmotor", speed=5.0) as twin:
        if asynchronous:
            asyncio.run(session(url_of(twin)))
            return
        with connect(url_of(twin), "smartmotor") as motor:
            motor._port._port._socket.shutdown(socket.SHUT_RDWR)
            raises(PortError, "the driver opens the port again for the next command", motor.axes["shaft"].status)
            assert arrives(motor)


# Completeness


def written(node):
    """Return the text of a string in the source, with * for each value."""
    match node:
        case ast.Constant(value=str()):
            return node.value
        case ast.JoinedStr():
            return "".join(map(written, node.values))
    return "*"


def remedies():
    folder = Path(axistwin.drivers.__file__).parent
    for path in [*folder.glob("*.py"), folder.parent / "ophyd.py"]:
        for node in ast.walk(ast.parse(path.read_text())):
            match node:
                case ast.Call(func=ast.Name(id="Fault"), args=[_, remedy]):
                    yield written(remedy)
                case ast.Call(func=ast.Name(id=name), args=[message, *_]) if name.endswith("Error"):
                    if ": expected" not in (text := written(message)):
                        yield text.rpartition(": ")[2]
                case ast.Assign(targets=[ast.Name(id="remedy")], value=ast.Constant() as remedy):
                    yield remedy.value


def test_each_remedy_is_followed_by_a_test():
    """*expected …* says what to give instead, as `test_bad_values.py` tests; * is the remedy of a fault."""
    here = "".join(path.read_text(encoding="utf-8") for path in Path(__file__).parent.glob("test_*.py"))
    assert [text for text in remedies() if not text.startswith("*") and text not in here] == []
