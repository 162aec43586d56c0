"""The external encoder at pins A and B: edges at constant speed, exactly."""

from fractions import Fraction
from typing import ClassVar

import pytest
from hypothesis import given
from hypothesis import strategies as st

from axistwin import Bench
from axistwin.core.errors import UsageError
from axistwin.plant.master import Master, Run
from axistwin.sim.clock import Clock
from axistwin.sim.signal import Signal

S = 10**9


@pytest.fixture
def clock():
    return Clock()


def test_it_counts_at_constant_speed_from_now_on(clock):
    master = Master(clock)
    clock.run_to(S)
    master.move(4000, 2)
    seen = []
    for time_ns in (S, S + 499_999, S + 500_000, 2 * S, 3 * S - 1, 3 * S, 9 * S):
        clock.run_to(time_ns)
        seen.append((master.count, master.moving))
    assert seen == [(0, True), (0, True), (1, True), (2000, True), (3999, True), (4000, False), (4000, False)]


@pytest.mark.parametrize(("counts", "at"), [(3, [0, 0, 1, 1, 2, 3]), (-3, [0, 0, -1, -1, -2, -3])])
def test_an_edge_comes_in_the_first_nanosecond_after_its_time_in_either_direction(counts, at):
    """Three edges in 10 ns are due at 3⅓, 6⅔ and 10 ns, and come at 4, 7 and 10 ns."""
    run = Run(100, 0, counts, 10)
    assert [run.at(100 + time_ns) for time_ns in (0, 3, 4, 6, 7, 10)] == at


@given(st.integers(-(10**9), 10**9), st.integers(1, 10**12), st.integers(0, 10**12))
def test_it_is_never_ahead_of_the_exact_count_and_less_than_one_behind(counts, duration_ns, time_ns):
    at = abs(Run(0, 0, counts, duration_ns).at(time_ns))
    exact = abs(counts) * min(time_ns, duration_ns)
    assert at * duration_ns <= exact < (at + 1) * duration_ns


def test_a_following_move_replaces_the_rest_of_the_one_before(clock):
    master, told = Master(clock), []
    master.before_change.subscribe(lambda: told.append(("before", master.count)))
    master.on_change.subscribe(lambda: told.append(("after", master.count)))
    master.move(1000, 1)
    clock.run_to(S // 4)
    master.move(-50, 0.5)
    clock.run_to(S)
    assert master.count == 200
    assert told == [("before", 0), ("after", 0), ("before", 250), ("after", 250)]


def test_at_once_and_to_a_stop(clock):
    master = Master(clock)
    master.move(17, 0)
    assert (master.count, master.moving) == (17, False)
    master.move(100, 1)
    clock.run_to(S // 2)
    master.stop()
    clock.run_to(2 * S)
    assert (master.count, master.moving) == (67, False)


def test_it_sits_on_a_shaft(clock):
    class Shaft:
        position = 300
        on_motion: ClassVar[Signal] = Signal()
        on_replan: ClassVar[Signal] = Signal()
        resting = False
        predictable = False
        follows = None

    master = Master(clock)
    master.move(7, 0)
    master.follow(Shaft)
    assert (master.count, master.moving) == (7, True)
    Shaft.position = 250
    assert master.count == -43
    master.stop()
    Shaft.position = 0
    assert (master.count, master.moving) == (-43, False)


@pytest.mark.parametrize("arguments", [(10, -1), (10, float("nan")), (10, float("inf")), (1.5, 1), (True, 1)])
def test_no_such_move(clock, arguments):
    with pytest.raises(UsageError, match=r"move\("):
        Master(clock).move(*arguments)


def test_its_ratio_is_told(clock):
    class Shaft:
        position = 0
        on_motion: ClassVar[Signal] = Signal()
        on_replan: ClassVar[Signal] = Signal()
        follows = None

    master = Master(clock)
    assert master.ratio == 1
    master.follow(Shaft, Fraction(2000, 400))
    assert master.ratio == 5


@pytest.mark.parametrize("counts", [10**30, -(10**18), 1.5, True])
def test_counts_that_no_encoder_has_are_refused(counts):
    motor = Bench().add("smartmotor")
    with pytest.raises(UsageError, match=r"^invalid number of counts in move\("):
        motor.master.move(counts, 1)
    with pytest.raises(UsageError, match=r"^invalid number of counts in displace\("):
        motor.axes["shaft"].encoder.displace(counts)


@pytest.mark.parametrize("ratio", [10**17, -1_000_001, float("nan"), float("inf")])
def test_a_ratio_that_no_gear_has_is_refused(ratio):
    bench = Bench()
    leader, follower = bench.add("smartmotor", "a"), bench.add("smartmotor", "b")
    with pytest.raises(UsageError, match=r"^invalid ratio .*: expected -1000000 to 1000000, e\.g\. 3/2$"):
        follower.master.follow(leader.axes["shaft"], ratio)
