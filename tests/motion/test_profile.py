"""Profiles against a plain reference in exact fractions, pulse by pulse."""

from fractions import Fraction
from math import floor

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin.sim.motion.profile import MOST_BLOCK, Profile, Segment

S = 10**9


def reference_pulses(segments, limit=10_000):
    """Return the exact time of each pulse in nanoseconds, calculated segment by segment."""
    times, begins, phase = [], Fraction(0), Fraction(0)
    for rate, seconds in segments:
        ends = None if seconds is None else phase + rate * seconds
        n = floor(phase) + 1
        while len(times) < limit and (ends is None or n <= ends):
            times.append(floor((begins + (n - phase) / rate) * S))
            n += 1
        if ends is None:
            break
        begins, phase = begins + seconds, ends
    return times


rates = st.builds(Fraction, st.integers(1, 4000), st.sampled_from([1, 2, 3, 4, 7]))
durations = st.builds(Fraction, st.integers(0, 50), st.sampled_from([1000, 999, 750, 128]))  # in total below `limit`
profiles = st.lists(st.builds(Segment, rates, durations), max_size=6)


@settings(max_examples=50, deadline=None)
@given(profiles)
def test_pulses_happen_at_their_exact_times(segments):
    profile, expected = Profile(segments), reference_pulses(segments)
    assert profile.pulses == len(expected)
    times = np.empty(len(expected), np.int64)
    profile.fill_pulse_times(1, 0, times)
    assert times.tolist() == expected == [profile.pulse_ns(n + 1) for n in range(len(expected))]


@settings(max_examples=50, deadline=None)
@given(profiles, st.integers(0, 2 * S))
def test_counting_agrees_with_the_pulse_times(segments, time_ns):
    assert Profile(segments).pulses_by(time_ns) == sum(at <= time_ns for at in reference_pulses(segments))


def test_a_constant_rate_is_arithmetic():
    """The n-th pulse of 300 pulses/s comes n * 10^9 // 300 nanoseconds after the start."""
    profile = Profile([Segment(Fraction(300), None)])
    assert [profile.pulse_ns(n) for n in (1, 2, 3, 1_000_000_000)] == [n * S // 300 for n in (1, 2, 3, 1_000_000_000)]


@pytest.mark.parametrize("rate", [
    Fraction(25, 4) * 1441, Fraction(100_000), Fraction(13_107_200, 3 * 16), Fraction(7, 3)])  # fmt: skip
def test_long_expansions_equal_the_arithmetic_at_every_seam(rate):
    profile = Profile([Segment(rate, None)])
    first, count = 123_456_789, 3 * MOST_BLOCK + 17
    times = np.empty(count, np.int64)
    profile.fill_pulse_times(first, 1_000, times)
    for k in (0, 1, 4095, 4096, MOST_BLOCK - 1, MOST_BLOCK, MOST_BLOCK + 1, 2 * MOST_BLOCK, count - 1):
        assert times[k] == (first + k) * S * rate.denominator // rate.numerator + 1_000


def test_a_cut_keeps_the_phase():
    """100 pulses/s are cut after 2.5 pulses; at 10 pulses/s the third pulse comes half a period, 50 ms, later."""
    profile = Profile([Segment(Fraction(100), None)]).cut(25_000_000, [Segment(Fraction(10), Fraction(1))])
    assert [profile.pulse_ns(n) for n in (1, 2, 3, 4)] == [10_000_000, 20_000_000, 75_000_000, 175_000_000]
    assert profile.pulses == 12


def test_a_scaled_profile_keeps_its_times_and_ends_on_its_count():
    profile = Profile([Segment(Fraction(400), Fraction(1, 10)), Segment(Fraction(1000), Fraction(96, 100))])
    slow = profile.scaled(Fraction(1, 4))
    assert (profile.pulses, slow.pulses) == (1000, 250)
    assert profile.end_ns == slow.end_ns == profile.pulse_ns(1000) == slow.pulse_ns(250)


def test_the_trend_says_where_the_rate_is_going():
    profile = Profile([Segment(Fraction(rate), Fraction(1)) for rate in (1, 2, 3, 2, 1)])
    assert [profile.trend(second * S) for second in range(6)] == [+1, +1, 0, -1, -1, 0]


def test_nothing_asked_gives_nothing():
    profile = Profile(())
    assert (profile.pulses, profile.end_ns, profile.pulses_by(0), profile.rate_at(0)) == (0, 0, 0, 0)
