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

from .devices import url_of
from .test_arrival import by_another_host

AXES = {"if1": "X", "1811": "motor", "smartmotor": "shaft"}
FOLLOWED = set()
"""Remedies that a test of this file follows."""


def follows(*remedies):
    FOLLOWED.update(remedies)
    return lambda test: test


def moves(twin, axis, distance=50):
    """Move, and compare with the true position."""
    before, name = twin.axes[axis.name.rstrip("0123456789")].position, axis.name.rstrip("0123456789")
    axis.move_by(distance)
    axis.wait(60)
    assert twin.axes[name].position - before == distance
    return True


@contextmanager
def connected(ports, model, *, options=None, **driver_options):
    twin = ports.add(model, **(options or {}))
    with connect(model, model, **driver_options) as controller:
        axis = controller.axes[AXES[model]]
        axis.set_profile(velocity=2000)
        yield twin, controller, axis


def fault(status, name):
    """Return the remedy of the fault `name`."""
    return next(found.remedy for found in status.faults if found.name == name)


# Limits


@follows(
    "call clear_faults and move away from the limit",
    "call clear_faults, move away from the limit, then call clear_faults again",
)
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("model", ["if1", "smartmotor"])
def test_after_a_limit(ports, model, sign):
    limits = {"limits": True} if model == "smartmotor" else {}
    with connected(ports, model, options={AXES[model]: {"limits": [-500, 500]}}, **limits) as (twin, _, axis):
        for begin in (lambda: axis.move_to(sign * 5000), lambda: axis.move_at(sign * 900)):
            begin()
            ports.run(10)
            remedy = axis.status().faults[0].remedy
            with pytest.raises(RefusedError, match=remedy):  # both directions
                axis.move_by(sign * 100)
            with pytest.raises(RefusedError, match=remedy):
                axis.move_by(-sign * 100)
            axis.clear_faults()
            assert moves(twin, axis, -sign * 300)
            if remedy.endswith("again"):
                axis.clear_faults()
            assert not axis.status().faults
            assert moves(twin, axis, sign * 20) and moves(twin, axis, -sign * 20)


def test_a_stream_away_from_a_limit_arrives(ports):
    with connected(ports, "smartmotor", options={"shaft": {"limits": [-500, 500]}}, limits=True) as (_, motor, shaft):
        shaft.move_at(900)
        start = shaft.wait(60).position
        shaft.clear_faults()
        path = [(2560 * number, round(start) - 100 * number) for number in range(1, 5)]
        motor.stream([(0, start), *path, path[-1]])
        assert shaft.wait(60).position == start - 400


@follows("move in the other direction")
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("model", ["if1", "1811"])
def test_at_a_limit_that_is_active(ports, model, sign):
    with connected(ports, model, options={AXES[model]: {"limits": [-500, 500]}}) as (twin, _, axis):
        axis.move_to(sign * 5000)
        ports.run(10)
        if model == "1811":
            with pytest.raises(StoppedError, match="move in the other direction"):
                axis.wait(1)
        axis.clear_faults()
        with pytest.raises(RefusedError, match=r"limit is active: move in the other direction"):
            axis.move_by(sign * 100)
        assert moves(twin, axis, -sign * 300)
        assert moves(twin, axis, sign * 20)


@follows(
    "check the limit switches and their wiring, then call clear_faults",
    "*; without switches, call command('UCI UDI') before",
)
@pytest.mark.parametrize("model", AXES)
def test_with_both_limits_active(ports, model):
    plus, minus = {"if1": ("limit_plus", "limit_minus"), "1811": ("cw_limit", "ccw_limit"), "smartmotor": "CD"}[model]
    with connected(ports, model, **({"limits": True} if model == "smartmotor" else {})) as (twin, _, axis):
        levels = {pin: twin.pins[pin].level for pin in (plus, minus)}
        if model != "smartmotor":  # its pins are open
            for pin in levels:
                twin.pins[pin].drive(not levels[pin])
        axis.clear_faults()
        says = "both limits are active: check the limit switches and their wiring, then call clear_faults"
        with pytest.raises(RefusedError, match=says):
            axis.move_by(50)
        for pin in levels:
            twin.pins[pin].drive(levels[pin] if model != "smartmotor" else not levels[pin])
        axis.clear_faults()
        assert moves(twin, axis) and not axis.status().faults


def test_a_motor_without_switches(ports):
    with connected(ports, "smartmotor", limits=True) as (twin, motor, shaft):
        with pytest.raises(RefusedError, match=r"; without switches, call command\('UCI UDI'\) before"):
            shaft.move_by(50)
        motor.command("UCI UDI")
        shaft.clear_faults()
        assert moves(twin, shaft) and not shaft.status().faults


def test_the_limits_act_after_an_earlier_connection_without_them(ports):
    with connected(ports, "smartmotor", options={"shaft": {"limits": [-500, 500]}}) as (twin, _, shaft):
        assert moves(twin, shaft)
    with connect("smartmotor", "smartmotor", limits=True) as motor:
        motor.axes["shaft"].move_to(5000)
        with pytest.raises(StoppedError, match="positive limit"):
            motor.axes["shaft"].wait(60)


# Faults of an IF1


@follows("release the button, then call clear_faults")
def test_after_an_emergency_stop(ports):
    with connected(ports, "if1") as (twin, _, x):
        x.move_at(900)
        twin.pins["estop"].drive(False)
        status = x.wait(60)
        with pytest.raises(RefusedError, match=fault(status, "emergency stop")):
            x.move_by(5)
        twin.pins["estop"].drive(True)
        x.clear_faults()
        assert moves(twin, x) and not x.status().faults


@follows("check the drive, then call clear_faults and set_position")
@pytest.mark.parametrize("moving", [True, False])
def test_after_a_drive_fault(ports, moving):
    with connected(ports, "if1") as (twin, _, x):
        if moving:
            x.move_to(5000)
        twin.pins["x_fault"].drive(not twin.pins["x_fault"].level)
        ports.run(1)
        remedy = fault(x.status(), "drive fault")
        with pytest.raises((RefusedError, PositionLostError), match=f"{remedy}|home the axis, or call set_position"):
            x.move_by(5)
        twin.pins["x_fault"].drive(not twin.pins["x_fault"].level)
        x.clear_faults()
        x.set_position(0)
        assert moves(twin, x) and not x.status().faults


@follows(
    "check the line format, then call clear_faults",
    "use the echo or a lower baud rate, then call clear_faults",
    "check the command, then call clear_faults",
    "check the command and the speed range, then call clear_faults",
)
@pytest.mark.parametrize("name", ["PARITY", "OVERRUN", "FRAMING", "DATA", "RANGE"])
def test_after_a_communication_fault(ports, name):
    """Such a fault inhibits no move: one that ends before it is seen is made, and known."""
    with connected(ports, "if1") as (twin, _, x):
        faults = twin._device._interface.faults
        faults.raise_line(type(faults.line)[name])
        assert x.status().faults
        assert moves(twin, x, 1)
        x.clear_faults()
        assert moves(twin, x) and not x.status().faults


@follows("check the command, then call clear_faults", "check the command and the speed range, then call clear_faults")
@pytest.mark.parametrize(("wrong", "right"), [("X10Q$", "X10$"), ("X10@99999$", "X10@999$")])
def test_after_a_message_that_the_interface_refuses(ports, wrong, right):
    with connected(ports, "if1") as (twin, if1, x):
        with pytest.raises(RefusedError, match=r"refused the message .*check the command"):
            if1.begin({"X": 1}, 10, 100, wrong)
        x.clear_faults()
        if1.begin({"X": 1}, 10, 100, right)
        assert x.wait(60).position == twin.axes["X"].position == 10
        assert moves(twin, x)


# Faults of a SmartMotor


@follows("call clear_faults and set_position")
def test_after_a_position_wrap(ports):
    with connected(ports, "smartmotor") as (twin, _, shaft):
        shaft.set_position(2**31 - 500)
        shaft.move_at(2000)
        ports.run(2)
        shaft.stop()
        remedy = fault(shaft.wait(60), "position wrap")
        assert remedy == "call clear_faults and set_position"
        shaft.clear_faults()
        shaft.set_position(0)
        assert moves(twin, shaft) and not shaft.status().faults


@follows("remove the load that blocks the shaft, then call clear_faults")
def test_after_a_position_error(ports):
    with connected(ports, "smartmotor") as (twin, _, shaft):
        twin.axes["shaft"].jam(True)
        shaft.move_to(40_000)
        with pytest.raises(StoppedError, match="remove the load that blocks the shaft, then call clear_faults"):
            shaft.wait(60)
        twin.axes["shaft"].jam(False)
        shaft.clear_faults()
        assert moves(twin, shaft) and not shaft.status().faults


@follows("let the motor cool down, then call clear_faults")
def test_after_overheat(ports):
    with connected(ports, "smartmotor") as (twin, motor, shaft):
        motor.command("THD=100 TH=10")
        ports.run(1)
        with pytest.raises(RefusedError, match="let the motor cool down, then call clear_faults"):
            shaft.move_to(50)
        motor.command("TH=70")  # it is cool now
        shaft.clear_faults()
        assert moves(twin, shaft) and not shaft.status().faults


@follows("check the load, then call clear_faults")
def test_after_over_current(ports):
    with connected(ports, "smartmotor", options={"shaft": {"motor": "frame23"}}) as (twin, motor, shaft):
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


@follows("load the program again")
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


@follows("home the axis, or call set_position", "home the axis, or call set_position, then repeat the motion")
@pytest.mark.parametrize("way", ["home", "set_position"])
@pytest.mark.parametrize("model", AXES)
def test_after_a_loss_of_the_position(ports, model, way):
    options = {"1811": {"motor": {"home": [150, 5000]}}}.get(model)
    driver = {"if1": {"home_input": 1}, "1811": {"home_edge_ccw": True}}.get(model, {})
    with connected(ports, model, options=options, **driver) as (twin, _, axis):
        twin.power_cycle()
        ports.run(2)
        with suppress(SilentError):  # how an IF1 tells it
            axis.status()
        with pytest.raises(PositionLostError, match="home the axis, or call set_position"):
            axis.position()
        with pytest.raises(PositionLostError, match="home the axis, or call set_position"):
            axis.move_to(5)
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


@follows("the position can only be set at rest")
@pytest.mark.parametrize("model", ["if1", "1811"])
def test_a_position_is_set_at_rest(ports, model):
    with connected(ports, model) as (twin, _, axis):
        axis.move_to(900)
        with pytest.raises(BusyError, match="the position can only be set at rest"):
            axis.set_position(0)
        axis.wait(60)
        axis.set_position(0)
        assert axis.position() == 0 and moves(twin, axis)


@follows("begin the motion again")
@pytest.mark.parametrize("model", AXES)
def test_after_a_stop_by_another_host(ports, model):
    with connected(ports, model) as (twin, controller, axis):
        axis.move_to(4000)
        ports.run(0.5)
        by_another_host(controller, model)
        with pytest.raises(StoppedError, match="begin the motion again"):
            axis.wait(60)
        axis.move_to(4000)
        assert axis.wait(60).position == twin.axes[AXES[model]].position == 4000


# Motions in progress


@follows(
    "wait for the end of the motion, or stop the motor",
    "wait for the end of the motion, or stop the axes",
    "stop it, or wait longer",
)
@pytest.mark.parametrize("way", ["wait", "stop"])
@pytest.mark.parametrize("model", ["if1", "1811"])
def test_a_motion_in_progress(ports, model, way):
    with connected(ports, model) as (twin, controller, axis):
        others = {
            "if1": [
                lambda: controller.axes["Y"].move_to(5), lambda: controller.axes["Y"].move_by(5),
                lambda: controller.axes["Y"].move_at(5), lambda: controller.move_together({"Y": 5, "Z": 5}),
                lambda: controller.sequence(["Y5"]),
            ],
            "1811": [
                lambda: axis.move_to(0), lambda: axis.move_by(5), lambda: axis.home(1),
                lambda: controller.define_sequence(1, [bytes([0x33, 0, 0, 0, 9])]),
            ],
        }[model]  # fmt: skip
        for other in others:
            axis.move_by(4000)
            with pytest.raises(SilentError, match=r"still moving after 0\.1 s: stop it, or wait longer"):
                axis.wait(0.1)
            with pytest.raises(BusyError, match="wait for the end of the motion, or stop"):
                other()
            if way == "stop":
                axis.stop()
            axis.wait(60)
            other()
            axis.stop()
            axis.wait(60)
            for each in controller.axes.values():
                each.set_position(0)
        assert moves(twin, axis)


# Home


@follows("move the axis away from the home switch")
def test_at_the_home_switch(ports):
    with connected(ports, "if1", home_input=1) as (twin, _, x):
        twin.pins["input1"].drive(True)
        with pytest.raises(RefusedError, match="is already high: move the axis away from the home switch"):
            x.home(1)
        assert moves(twin, x, -50)
        twin.pins["input1"].drive(False)  # away from it
        x.home(1)
        twin.pins["input1"].drive(True)
        assert x.wait(60).position == 0 and moves(twin, x)


@follows("check the home switch and home_definition, then call clear_faults")
def test_after_a_search_for_home_that_failed(ports):
    twin = ports.add("1811", motor={"home": [150, 5000], "limits": [-300, 300]})
    wire = ports.faults.add("stuck", "1811.home", level="low")
    with connect("1811", "1811", home_edge_ccw=True) as board:
        motor = board.axes["motor"]
        motor.set_profile(velocity=2000, acceleration=100_000)
        motor.home(1)
        with pytest.raises(StoppedError, match="check the home switch and home_definition, then call clear_faults"):
            motor.wait(60)
        wire.mend()
        motor.clear_faults()
        assert not motor.status().faults
        motor.home(-1)
        assert motor.wait(60).position == 0
        assert moves(twin, motor, -50)


# A board that does not go on


@follows("call reset, or switch its power off and on; the position is then lost")
@pytest.mark.parametrize(
    "out", [lambda board, twin: board.reset(), lambda board, twin: twin.power_cycle()], ids=["reset", "power"]
)
@pytest.mark.parametrize("again", [False, True])
def test_after_a_failure_of_the_board(ports, again, out):
    """The program may also have been started after the failure."""
    with connected(ports, "1811") as (twin, board, motor):
        board.command(0xFF)
        assert ports.run_until(lambda: twin.bus.read(1) & 0x20, 25)
        if not again:
            assert (
                fault(motor.status(), "board failure")
                == "call reset, or switch its power off and on; the position is then lost"
            )
            with pytest.raises(
                RefusedError, match="call reset, or switch its power off and on; the position is then lost"
            ):
                motor.move_to(5)
            out(board, twin)
            assert motor.status().lost
            motor.set_position(0)
            assert moves(twin, motor)
    if again:
        with connect("1811", "1811") as board:
            motor = board.axes["motor"]
            assert (
                fault(motor.status(), "board failure")
                == "call reset, or switch its power off and on; the position is then lost"
            )
            out(board, twin)
            motor.set_position(0)
            assert moves(twin, motor)


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


@follows("call reset, or switch its power off and on")
@pytest.mark.parametrize(("status", "says"), [(b"00", "is not ready"), (b"10", "does not answer the command 01h")])
def test_after_a_board_that_hangs(ports, monkeypatch, status, says):
    with connected(ports, "1811") as (twin, board, motor):
        monkeypatch.setattr(board, "_port", Hung(ports, board._port, status))
        with pytest.raises(SilentError):
            motor.status()
        with pytest.raises(SilentError, match=rf"{says}.*: call reset, or switch its power off and on"):
            motor.status()
        board.reset()
        motor.set_position(0)
        assert moves(twin, motor)


@follows("check the conditions for this request in the board's manual")
def test_after_a_request_without_its_conditions(ports):
    with connected(ports, "1811") as (twin, board, motor):
        with pytest.raises(SilentError, match="check the conditions for this request in the board's manual"):
            board.request(0x91, 50)  # 91h: "the parameters of a defined move"
        motor.move_at(100)
        motor.stop()
        motor.wait(60)
        assert any(board.request(0x91, 50))  # `move_at` has defined it
        assert moves(twin, motor)


@follows("expected a larger update_ms, i.e. a longer time for each velocity")
def test_after_a_stream_that_came_too_late(ports):
    ports.access_s = 5e-3
    with connected(ports, "1811") as (twin, board, motor):
        with pytest.raises(RefusedError, match=r"expected a larger update_ms, i.e. a longer time for each velocity"):
            board.stream_times(2, 4, 1, [100] * 5_000 + [0])
        board.stream_times(100, 4, 1, [100] * 400 + [0])
        motor.wait(600)
        assert moves(twin, motor)


# The line


def spoiled(controller, monkeypatch, request, answer, *, times=1):
    """Replace the answer to `request` on the controller's port."""
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


@follows(
    "check the line for noise",
    "check the line for noise or a second host",
    "check the power, the cable and the line format",
    "check the board's power and the address of the bus socket (bus://)",
    "check that the controller is connected to this port",
    "check the port, the cable and the baud rate, and the motor's power and address",
)
@pytest.mark.parametrize(
    ("model", "options", "request_", "answer", "error", "says"),
    [("if1", {}, b"K", b"Q", WrongAnswerError, "check the line for noise"),
     ("if1", {}, b"K", b"K\r\n" + b"9" * 5000, WrongAnswerError, "check"),
     ("1811", {}, b"r", b"zz\n", WrongAnswerError, "expected 1 hex bytes"),
     ("smartmotor", {}, b"RPW", b"X" * 5000, WrongAnswerError, "check that the controller is connected to this port"),
     ("smartmotor", {}, b"RPW", b"x,y\r", WrongAnswerError, "expected a whole number")],
)  # fmt: skip
def test_after_noise(ports, monkeypatch, model, options, request_, answer, error, says):
    with connected(ports, model, **options) as (twin, controller, axis):
        spoiled(controller, monkeypatch, request_, answer)
        with pytest.raises(error, match=says):
            axis.status()
        assert moves(twin, axis)


@pytest.mark.parametrize("model", ["if1", "smartmotor"])
def test_after_a_power_that_was_off(ports, model):
    with connected(ports, model) as (twin, _, axis):
        twin.power(False)
        with pytest.raises((SilentError, WrongAnswerError)) as silent:
            axis.status()
        assert "power" in str(silent.value)
        twin.power(True)
        ports.run(2)
        axis.set_position(0)
        assert moves(twin, axis)


@follows("check the cable, and check whether the command LOCKP has locked the program")
def test_after_a_program_that_is_locked(ports):
    with connected(ports, "smartmotor") as (twin, motor, shaft):
        motor.load("a=1\nEND\n")
        motor.command("LOCKP")
        with pytest.raises(SilentError, match="check whether the command LOCKP has locked the program"):
            motor.program()
        motor.load("b=1\nEND\n")  # a new program is not locked
        assert motor.program().startswith("b=1") and moves(twin, shaft)


@follows("start the server, and check the address")
def test_after_a_server_that_was_not_there():
    with socket.create_server(("127.0.0.1", 0)) as held:
        port = held.getsockname()[1]
    url = f"tcp://127.0.0.1:{port}"
    with pytest.raises(PortError, match="start the server, and check the address"):
        connect(url, "smartmotor")
    scene = {"controller": [{"model": "smartmotor", "ports": [url]}]}
    with axistwin.serve(scene, speed=5.0, fixed_ports=True), connect(url, "smartmotor") as motor:
        motor.axes["shaft"].move_to(40)
        assert motor.axes["shaft"].wait(60).position == 40


@follows("check the name of the port, the cable and your permissions")
def test_after_a_wrong_name():
    with pytest.raises(PortError, match="check the name of the port, the cable and your permissions"):
        connect("/dev/nothing", "smartmotor")
    with axistwin.serve("smartmotor", speed=5.0, scheme="pty") as twin, connect(url_of(twin), "smartmotor") as motor:
        motor.axes["shaft"].move_to(40)
        assert motor.axes["shaft"].wait(60).position == 40


@follows(
    "the driver opens the port again for the next command", "check that the server is still running, then try again"
)
@pytest.mark.parametrize("asynchronous", [False, True])
def test_after_a_port_that_was_disconnected(asynchronous):
    with axistwin.serve("smartmotor", speed=5.0) as twin:
        url = url_of(twin)

        if not asynchronous:
            with connect(url, "smartmotor") as motor:
                motor._port._port._socket.shutdown(socket.SHUT_RDWR)
                with pytest.raises(PortError, match="the driver opens the port again for the next command"):
                    motor.axes["shaft"].status()
                motor.axes["shaft"].move_to(40)
                assert motor.axes["shaft"].wait(60).position == 40
            return

        async def session():
            async with await connect_async(url, "smartmotor") as motor:
                motor._port._writer.transport.get_extra_info("socket").shutdown(socket.SHUT_RDWR)
                with pytest.raises(PortError, match=r"check that the server is still running, then try again|disconn"):
                    await motor.axes["shaft"].status()
                await motor.axes["shaft"].move_to(40)
                assert (await motor.axes["shaft"].wait(60)).position == 40

        asyncio.run(session())


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
    """Yield the remedies in the sources of the drivers."""
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
    assert {text for text in remedies() if not text.startswith("*")} <= FOLLOWED
