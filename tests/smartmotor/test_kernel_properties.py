"""Properties of any run of the kernel: acceleration and speed stay within limits, and moves end at their targets."""

import itertools

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin.controllers.smartmotor.kernel import jit, state
from axistwin.controllers.smartmotor.kernel.interpreter import STACK, evaluate
from axistwin.controllers.smartmotor.kernel.kernel import ALL_DONE, TRAJECTORY

from .reference import inventing
from .reference.bridge import Kernel
from .reference.motor import ReferenceMotor
from .reference.program import Abandoned, Program, expression
from .reference.trajectory import Trajectory
from .test_kernel_reference import CHANCE, THOROUGH, Beside

SPEEDS = st.integers(-(2**24), 2**24)
RATES = st.one_of(st.integers(1, 500), st.integers(1, 2**22))
TARGETS = st.integers(-3000, 3000)
MOST = 400


def moving(mode, velocity, **values):
    """Return the kernel of an ideal motor during a move, at position 0."""
    motor = ReferenceMotor(Program("END"), values={"OBSERVE_INDEX": 0}, error_limit=2**31)
    motor.runner.state = "stopped"
    motor.trajectory = Trajectory(mode, 0, velocity, **values)
    motor.flags["Bt"] = 1
    return Kernel(motor, "END")


def course(kernel, most=MOST):
    """Return position and velocity in each sample until the move ends, in 1/65536 count."""
    i, done = kernel.i, [(0, kernel.i[state.VELOCITY])]
    while i[state.BT] and len(done) < most:
        before = i[state.COMMANDED]
        assert kernel.advance(1)[0] in (ALL_DONE, TRAJECTORY)
        done.append((i[state.COMMANDED], i[state.COMMANDED] - before))
    return done


def check_rate(places, rate):
    for (_, before), (_, after) in itertools.pairwise(places):
        assert abs(after - before) <= rate


@settings(max_examples=30, deadline=None)
@given(velocity=SPEEDS, top=st.integers(1, 2**24), rate=RATES, target=TARGETS)
def test_a_position_move_keeps_to_a_and_v_in_every_sample(velocity, top, rate, target):
    """4 of the base language: speed changes by at most A per sample, stays within V once below it, and is 0 at P."""
    kernel = moving("position", velocity, target=target, top=top, rate=rate)
    places = course(kernel)
    check_rate(places, rate)
    for (_, before), (_, after) in itertools.pairwise(places):
        assert abs(after) <= max(top, abs(before) - rate)
    if not kernel.i[state.BT]:
        assert places[-1][0] == target * 65536 and abs(places[-1][1]) <= rate


@settings(max_examples=20, deadline=None)
@given(top=st.integers(1, 2**24), rate=RATES, target=TARGETS)
def test_a_move_from_rest_never_turns_round(top, rate, target):
    places = course(moving("position", 0, target=target, top=top, rate=rate))
    assert all(velocity * target >= 0 for _, velocity in places)
    assert all(abs(place) <= abs(target) * 65536 for place, _ in places)


@settings(max_examples=40, deadline=None)
@given(velocity=SPEEDS, top=SPEEDS, rate=RATES)
def test_a_velocity_move_goes_straight_to_its_velocity(velocity, top, rate):
    """MV: the velocity changes by A per sample until it is V; from one sign to the other it passes through zero."""
    places = course(moving("velocity", velocity, top=top, rate=rate), 60)
    for n, (_, now) in enumerate(places):
        way = 1 if top >= velocity else -1
        assert now == way * min(way * velocity + n * rate, way * top)


@settings(max_examples=40, deadline=None)
@given(velocity=SPEEDS, rate=st.integers(2**16, 2**22))
def test_x_comes_to_a_stop_at_a(velocity, rate):
    places = course(moving("stop", velocity, rate=rate))
    for n, (_, now) in enumerate(places):
        assert abs(now) == max(abs(velocity) - n * rate, 0)
    assert places[-1][1] == 0


# Expressions


@THOROUGH
@given(random=CHANCE)
def test_expressions_have_the_value_of_the_reference_or_none(random):
    """7 of the base language: overflow and division by zero set Bd, an invalid index sets Bu; both give no value."""
    lines = [f"{random.choice('pq')}={inventing.expression(random, 4, fetches=True)}" for _ in range(30)]
    all_of_them = Beside(random, "\n".join(lines))
    while all_of_them.motor.runner.state == "running":
        all_of_them.run(1)
        for flag in "Bd", "Bu":
            all_of_them.motor.flags[flag] = 0
        all_of_them.happen()


@pytest.mark.parametrize(("text", "flag"), [
    ("2147483647+1", "Bd"), ("-2147483648-1", "Bd"), ("65536*32768", "Bd"), ("a/0", "Bd"), ("a%0", "Bd"),
    ("2^5", "Bd"), ("2^-1", "Bd"), ("al[51]", "Bu"), ("al[-1]", "Bu"), ("ab[204]", "Bu"), ("aw[102]", "Bu"),
    ("1/0+al[51]", "Bd"), ("al[51]+1/0", "Bu")])  # fmt: skip
def test_both_give_up_where_they_should(text, flag):
    motor = ReferenceMotor(Program(f"b={text}"), values={"OBSERVE_INDEX": 0})
    motor.memory["b"] = 5
    with pytest.raises(Abandoned) as reason:
        expression(text)(motor)
    assert reason.value.flag == flag
    kernel = Kernel(motor, f"b={text}")
    kernel.advance(3)
    assert (kernel.i[state.BD], kernel.i[state.BU]) == (flag == "Bd", flag == "Bu") and kernel.v[state.LETTERS + 1] == 5


@pytest.mark.skipif(not jit.available(), reason="Numba is not installed")
def test_the_stack_fits_the_longest_expression():
    """The parser limits the length of an expression so that the stack suffices; Numba does not check array bounds."""
    from axistwin.controllers.smartmotor.language.expressions import Malformed, Reader

    deep = "a+(" * 20 + "a" + ")" * 20
    code = Reader(deep).expression().code
    assert evaluate([0] * state.INTS, [1] * state.VARIABLES, [0] * STACK, code, 0) > 0
    with pytest.raises(Malformed):
        Reader(f"a+({deep})").expression()
