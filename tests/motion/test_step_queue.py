"""Pulse times as a queue of step commands."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin.sim.motion.profile import Profile, Segment
from axistwin.sim.motion.step_queue import MOST_INTERVAL, Steps, plan

MHZ, TOLERANCE = 16, 8.0  # the clock of an AVR; half a microsecond in its ticks


def executed(commands, last):
    """Return the ticks of all pulses, as a board executes the commands."""
    times = []
    for command in commands:
        assert 1 <= command.count < 1 << 16 and -(1 << 15) <= command.add < 1 << 15
        interval = command.interval
        for _ in range(command.count):
            assert 0 < interval <= MOST_INTERVAL
            last += interval
            interval += command.add
            times.append(last)
    return np.array(times, np.int64)


@settings(max_examples=50)
@given(
    st.lists(st.integers(50, 400_000), min_size=1, max_size=200),
    st.sampled_from([2.0, 8.0, 40.0]),
    st.integers(0, 1 << 33),
)
def test_each_pulse_is_within_the_tolerance(gaps, tolerance, last):
    wanted = last + np.cumsum(gaps).astype(float)
    assert np.abs(executed(plan(wanted, last, tolerance), last) - wanted).max() <= tolerance


@settings(max_examples=50)
@given(st.lists(st.tuples(st.integers(100, 60_000), st.integers(1, 300)), min_size=1, max_size=8), st.floats(0, 1000))
def test_profiles_of_any_rates(segments, offset):
    profile = Profile(Segment(Fraction(rate), Fraction(pulses, rate)) for rate, pulses in segments)
    times = np.empty(profile.pulses, np.int64)
    profile.fill_pulse_times(1, 100_000, times)
    wanted = (times + offset) * MHZ / 1000
    assert np.abs(executed(plan(wanted, 0, TOLERANCE), 0) - wanted).max() <= TOLERANCE


def possible(low, high):
    """Return all commands for pulses within these bounds, by trying each interval and each change of the interval."""
    return [
        (interval, add)
        for interval in range(1, max(high) + 1)
        for add in range(-max(high), max(high) + 1)
        if interval + add * (len(low) - 1) >= 1
        and all(a <= tick <= b for a, tick, b in zip(low, Steps(interval, len(low), add).times(0), high, strict=True))
    ]


@settings(max_examples=30, deadline=None)
@given(st.lists(st.integers(4, 12), min_size=1, max_size=4), st.sampled_from([0.0, 1.0, 3.0]))
def test_a_command_outputs_as_many_pulses_as_possible(gaps, tolerance):
    wanted = np.cumsum(gaps).astype(float)
    count = next(plan(wanted, 0, tolerance)).count
    for pulses in range(1, len(gaps) + 1):
        low, high = ([int(time + sign * tolerance) for time in wanted[:pulses]] for sign in (-1, 1))
        assert bool(possible(low, high)) is (pulses <= count)


def test_a_move_of_20_000_pulses_takes_at_most_150_commands():
    levels = [Fraction(rate) for rate in range(400, 4001, 200)]
    up = [Segment(rate, Fraction(1, 50)) for rate in levels]
    ramps = 2 * sum(rate / 50 for rate in levels)
    profile = Profile([*up, Segment(levels[-1], (20_000 - ramps) / 4000), *reversed(up)])
    times = np.empty(profile.pulses, np.int64)
    profile.fill_pulse_times(1, 100_000, times)
    wanted = times * MHZ / 1000
    commands = list(plan(wanted, 0, TOLERANCE))
    assert len(times) == 20_000
    assert np.abs(executed(commands, 0) - wanted).max() <= TOLERANCE and len(commands) <= 150


def test_a_command_knows_its_times():
    assert Steps(100, 3, -10).times(1000).tolist() == [1100, 1190, 1270] and Steps(100, 3, -10).ticks == 270


def test_times_between_two_ticks_without_tolerance():
    assert list(plan(np.array([10.5, 21.0]), 0, 0.2)) == [Steps(10, 1, 0), Steps(11, 1, 0)]


def test_a_pulse_before_the_last_one_is_refused():
    with pytest.raises(ValueError, match="interval of -92 ticks between two pulses: expected 1 to"):
        list(plan(np.array([900.0]), 1000, 8.0))
