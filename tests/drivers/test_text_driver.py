"""A driver made of texts, for controllers of others."""

from dataclasses import replace

import pytest

import axistwin
from axistwin import Bench
from axistwin.core.errors import UsageError
from axistwin.devices import Device, Lines, Option
from axistwin.drivers import DriverError, RefusedError, SilentError, TextDriver, WrongAnswerError, connect, make
from axistwin.drivers.if1 import IF1
from axistwin.drivers.steps import Read, Write
from axistwin.real.integrations import driver_inside

from ..devices.stages import Module, Stage
from ..told import raises

STAGE = TextDriver(
    move="{axis}PA{position}", stop="{axis}ST", position="{axis}TP", busy="{axis}MD", velocity="{axis}VA{velocity}",
    run="{axis}MV{direction:+d}", home="{axis}OR{direction}", define="{axis}DH{position}",
    axes={"1": None, "2": None}, ending=b"\r\n",
)  # fmt: skip


def said(steps, *answers: bytes) -> tuple[bytes, object]:
    """Return what a procedure sends, and its result."""
    sent, given, result = b"", iter(answers), None
    try:
        while True:
            match steps.send(result):
                case Write(data):
                    sent += data
                    result = None
                case Read():
                    result = next(given, b"")
    except StopIteration as end:
        return sent, end.value


@pytest.mark.parametrize(("act", "expected"), [
    (lambda axis: axis.move_to(-40), b"2PA-40\r"),
    (lambda axis: axis.stop(), b"2ST\r"),
    (lambda axis: axis.abort(), b"2ST\r"),  # it has no text of its own
    (lambda axis: axis.move_at(-5.0), b"2MV-1\r"),
    (lambda axis: axis.move_at(0), b"2ST\r"),
    (lambda axis: axis.home(1), b"2OR1\r"),
    (lambda axis: axis.set_position(7), b"2DH7\r"),
])  # fmt: skip
def test_each_act_is_one_line(act, expected):
    assert said(act(STAGE().axes["2"])) == (expected, None)


def test_the_velocity_is_sent_once_after_it_has_changed():
    axis = STAGE().axes["1"]
    axis.velocity = 250.0
    assert said(axis.move_to(1))[0] == b"1VA250\r1PA1\r"
    assert said(axis.move_to(2))[0] == b"1PA2\r"


def test_positions_are_in_the_units_of_the_controller():
    axis = replace(STAGE, counts=2000)().axes["1"]
    assert said(axis.move_to(500))[0] == b"1PA0.25\r"
    sent, status = said(axis.status(), b"0\r\n", b"0.125\r\n")
    assert (sent, status.position, status.setpoint, status.moving) == (b"1MD\r1TP\r", 250, 500, True)
    assert status.velocity == axis.velocity


def test_a_relative_move_begins_at_the_last_target_or_at_the_position():
    axis = STAGE().axes["1"]
    assert said(axis.move_by(10), b"30\r\n")[0] == b"1TP\r1PA40\r"
    assert said(axis.move_by(10))[0] == b"1PA50\r"


def test_an_axis_at_rest_elsewhere_has_missed_its_target():
    axis = STAGE().axes["1"]
    said(axis.move_to(50))
    assert "the target was not reached" in said(axis.status(), b"1\r\n", b"49\r\n")[1].missed
    assert said(axis.status(), b"1\r\n", b"50\r\n")[1].missed == ""


def test_an_echo_and_a_confirmation_are_taken_off_the_line():
    core = replace(STAGE, echo=True, confirmed=True)()
    assert said(core.axes["1"].move_to(5), b"1PA5\rOK\r\n")[0] == b"1PA5\r"
    assert said(core.axes["1"].asked("position"), b"1TP\r", b"5\r\n") == (b"1TP\r", 5.0)


def test_what_comes_first_is_told_to_each_axis_and_its_answers_are_dropped():
    core = replace(STAGE, begin="{axis}MO")()
    assert said(core.synchronise(), b"", b"OK\r\n", b"OK\r\n", b"", b"0\r\n")[0] == b"1MO\r2MO\r1TP\r"


class Addressed(Stage):
    model, framing = "addressed", Lines(b"\r", address="@{number}")
    options = Stage.options | {"number": Option(3, 1, 9)}


def test_lines_begin_with_the_address_of_the_device():
    core = make(Addressed, {})
    assert said(core.axes["1"].move_to(5))[0] == b"@31PA5\r"
    assert said(make(Addressed, {"address": "@7"}).axes["1"].move_to(5))[0] == b"@71PA5\r"
    bench = Bench()
    bench.add(Addressed, number=4)
    assert driver_inside(bench, "addressed").core.driver.address == "@4"


def test_a_device_may_have_a_protocol_core_of_its_own():
    made = make(type("Own", (Module,), {"model": "own", "driver": IF1}), {"start_stop": 200})
    assert isinstance(made, IF1) and list(made.axes) == ["X", "Y", "Z"]


def test_what_goes_wrong_says_what_to_do():
    axis = replace(STAGE, home="")().axes["1"]
    raises(RefusedError, "has no `home`: expected it in TextDriver(home=...)", said, axis.home(1))
    raises(
        WrongAnswerError,
        "has no number: expected one, so check the driver's `position`",
        said,
        axis.asked("position"),
        b"ERR\r\n",
    )
    raises(SilentError, "no answer to '1TP", said, axis.asked("position"))
    raises(UsageError, 'e.g. move="{axis}PA{position}"', TextDriver, "{axs}PA", "{axis}TP", "{axis}MD")
    raises(
        DriverError, "wrong does not say how a host moves it", connect, "x", type("W", (Device,), {"model": "wrong"})
    )
    text = type("W", (Module,), {"model": "wrong", "driver": STAGE})
    raises(DriverError, "speaks datagrams: expected functions that return bytes", connect, "x", text)
    raises(DriverError, "expected one of timeout", connect, "x", Stage, limits=True)
    bench = Bench()
    bench.add(Stage)
    raises(UsageError, "expected one of timeout", driver_inside, bench, "stage", limits=True)


KESTREL = TextDriver(
    move="G{axis},{position}", stop="R{axis},0", position="P{axis}", busy="Q", confirmed="OK",
    axes={"A": None, "B": None}, at_rest=lambda axis, status: not int(status) & {"A": 1, "B": 2}[axis],
)  # fmt: skip


def test_moves_that_are_acknowledged_answers_with_a_prefix_and_status_bits():
    axis = KESTREL().axes["B"]
    assert said(axis.move_to(-1250), b"OK\r") == (b"GB,-1250\r", None)
    for bits, moving in ((b"Q018\r", True), (b"Q017\r", False)):
        sent, status = said(axis.status(), bits, b"P-1250\r")
        assert (sent, status.position, status.moving) == (b"Q\rPB\r", -1250, moving)
    raises(RefusedError, "the answer to 'GB,5\\r' is 'E4': expected 'OK'", said, axis.move_to(5), b"E4\r")


def test_a_wrong_function_of_a_driver_is_one_line():
    raises(UsageError, "invalid value=5 of a driver: expected a function of the bytes", replace, KESTREL, value=5)
    for value, cause in (
        (lambda answer: answer["x"], "TypeError: byte indices must be"),
        (lambda answer: None, "TypeError: float() arg"),
        (lambda: 5, "TypeError: "), (lambda answer: float(answer), "ValueError: could not convert string to float"),
    ):  # fmt: skip
        axis = replace(KESTREL, value=value)().axes["A"]
        raises(
            WrongAnswerError,
            f"the answer 'P5' to 'PA\\r' has no number ({cause}",
            said,
            axis.asked("position"),
            b"P5\r",
        )
    axis = replace(KESTREL, at_rest=lambda axis, status: {}[axis])().axes["A"]
    raises(WrongAnswerError, "`at_rest` failed for axis A and 0 (KeyError: 'A')", said, axis.status(), b"Q000\r")


@pytest.mark.parametrize("kind", [Stage, Module])
def test_a_device_is_driven_at_a_port(kind):
    bench = Bench()
    machine = bench.add(kind)
    with axistwin.serve(bench, speed="manual") as twin:

        def host() -> tuple[float, float, list[str]]:
            with connect(twin.ports[kind.model], kind, timeout=5.0) as controller:
                axis = controller.axes["1"]
                axis.move_to(300)
                arrived = axis.wait(60).position
                axis.move_to(90_000)
                axis.stop()
                return arrived, axis.wait(60).position, list(controller.axes)

        arrived, stopped, axes = twin.call(host)
        assert (arrived, stopped, axes) == (300, machine.axes["1"].position, list(kind.axes))
        assert 300 <= stopped < 400  # it has stopped a few character times after its start
