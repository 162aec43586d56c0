"""Values that a driver refuses with an error of its own, before it sends anything."""

import asyncio
from math import inf, nan

import pytest

from axistwin import Bench
from axistwin.drivers import DriverError, RefusedError, Scale, connect, make
from axistwin.real.integrations import driver_inside

from ..bad_values import BAD, NOT_NUMBERS, TABLE
from ..told import raises

AXES = {"if1": "X", "1811": "motor", "smartmotor": "shaft"}
EVERY = [*TABLE, *((function, value) for function in BAD for value in NOT_NUMBERS)]
PROFILE = {"speed": "velocity", "acceleration": "acceleration"}


def give(axis, function, value):
    if function in PROFILE:
        return axis.set_profile(**{PROFILE[function]: value})
    return getattr(axis, function)(value)


def what_is_wrong(act, sent):
    """Return why `act` is not refused in one line before anything is sent; "" if it is."""
    sent.clear()
    try:
        act()
    except RefusedError as error:
        return "" if "expected" in str(error) and "\n" not in str(error) and not sent else f"{error} {sent}"
    except (DriverError, TypeError, ValueError, ArithmeticError, AttributeError) as error:
        return repr(error)
    return "accepted"


def without_none_of_a_profile():
    """Return the values; None of `set_profile` keeps the present value."""
    return [(function, value) for function, value in EVERY if value is not None or function not in PROFILE]


@pytest.mark.parametrize("model", AXES)
@pytest.mark.parametrize("counts_per_unit", [1, -100])
def test_bad_values_are_refused_and_nothing_is_sent(ports, monkeypatch, model, counts_per_unit):
    ports.add(model)
    with connect(model, model, **({"home_input": 1} if model == "if1" else {})) as controller:
        axis, sent, accepted = controller.axes[AXES[model]], [], []
        axis.scale = Scale(counts_per_unit, "mm")
        monkeypatch.setattr(controller._port, "write", sent.append)
        before = (axis.core.velocity, axis.core.acceleration, axis.core.target)
        for function, value in without_none_of_a_profile():
            if fault := what_is_wrong(lambda function=function, value=value: give(axis, function, value), sent):
                accepted.append((function, value, fault))
        assert accepted == []
        assert (axis.core.velocity, axis.core.acceleration, axis.core.target) == before


@pytest.mark.parametrize("model", AXES)
def test_bad_values_in_asyncio(model):
    async def session():
        bench = Bench()
        bench.add(model)
        driver = driver_inside(bench, model, **({"home_input": 1} if model == "if1" else {}))
        axis, accepted = driver.axes[AXES[model]], []
        await axis.position()
        began = bench.now
        for function, value in without_none_of_a_profile():
            try:
                if (coroutine := give(axis, function, value)) is not None:
                    await coroutine
            except RefusedError:
                continue
            accepted.append((function, value))
        assert accepted == [] and bench.now == began

    asyncio.run(session())


RAW = {
    "if1": [
        ("outputs", ([6],)), ("outputs", ([0],)), ("outputs", (["1"],)), ("outputs", ([], [True])), ("outputs", (5,)),
        ("move_together", ({"X": nan},)), ("move_together", ({"X": 10**9},)), ("move_together", ({"W": 5},)),
        ("move_together", ({},)), ("message", ("Xé",)), ("message", (5,)),
        ("sequence", (["Xé"],)), ("sequence", ([5],)), ("sequence", ("X5",)),
    ],
    "1811": [
        ("command", (256,)), ("command", (-1,)), ("command", (1, 300)), ("command", ("1",)), ("request", (None,)),
        ("define_sequence", (16, [])), ("define_sequence", (0, [])), ("define_sequence", (1, [b""])),
        ("define_sequence", (1, ["x"])), ("closed_loop", ((70_000, 1), 25_000, 0)), ("closed_loop", ((1, 1), 2**31, 0)),
        ("closed_loop", ((1, 1), 25_000, nan)), ("closed_loop", (4, 25_000, 0)), ("closed_loop", ((4,), 25_000, 0)),
        ("stream_times", (70_000, 1, 1, [1, 0])), ("stream_times", (20, 1, 1, [nan, 0])),
        ("stream_times", (0, 1, 1, [1, 0])), ("stream_times", (20, 256, 1, [1, 0])),
        ("stream_times", (20, 1, 1, ["x", 0])),
    ],
    "smartmotor": [("command", ("é",)), ("command", (5,)), ("number", ("RP\u2212",)), ("load", ("é",)), ("load", (5,)),
                   ("cam", (["x"], 800)), ("cam", ([2**31], 800)), ("cam", ([], 800)), ("cam", ([0, 1], nan)),
                   ("stream", ([(0, 2**31)],)), ("stream", ([(-1, 0)],)), ("stream", ([(0, nan)],)), ("stream", ([5],)),
                   ("stream", ([(1, 2, 3)],)), ("command", ("RP", "shaft9")), ("inputs", ("shaft9",))],
}  # fmt: skip


@pytest.mark.parametrize("model", RAW)
def test_bad_arguments_of_a_family_are_refused_and_nothing_is_sent(ports, monkeypatch, model):
    ports.add(model)
    with connect(model, model) as controller:
        sent, accepted = [], []
        monkeypatch.setattr(controller._port, "write", sent.append)
        for function, arguments in RAW[model]:
            act = getattr(controller, function)
            if fault := what_is_wrong(lambda act=act, arguments=arguments: act(*arguments), sent):
                accepted.append((function, arguments, fault))
        assert accepted == []


@pytest.mark.parametrize(("model", "options"), [
    ("if1", {"timeout": nan}), ("1811", {"timeout": 0}), ("smartmotor", {"timeout": "1"}),
    ("if1", {"timeout": inf}),
    ("if1", {"start_stop": "400"}), ("if1", {"start_stop": 0}), ("if1", {"speed_range": "1"}),
    ("if1", {"home_input": []}), ("smartmotor", {"addresses": "12"}), ("smartmotor", {"addresses": [1.5]}),
    ("smartmotor", {"addresses": 3}), ("smartmotor", {"addresses": [1, 1]}), ("1811", {"home_percent": nan}),
    ("1811", {"home_percent": "10"}), ("1811", {"marker_bit": []})])  # fmt: skip
def test_bad_options(model, options):
    raises(DriverError, "expected", make, model, options)


@pytest.mark.parametrize("counts", [0, nan, inf, True, "400", None])
def test_bad_scales(counts):
    raises(RefusedError, "expected a number", Scale, counts)


@pytest.mark.parametrize(("timeout", "poll"), [(nan, 0.02), ("5", 0.02), (5, nan), (5, -1), (5, None)])
def test_bad_times_of_a_wait(ports, timeout, poll):
    ports.add("if1")
    with connect("if1", "if1") as if1, pytest.raises(RefusedError, match="expected"):
        if1.axes["X"].wait(timeout, poll)
