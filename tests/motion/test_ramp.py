"""Ramps in steps, by the manual's figures: range 1, start/stop 400, 10,000 steps/s²."""

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin.sim.motion.ramp import Ramp

MS = 10**6


def ramp(top, start=400, increment=100, interval=Fraction(1, 100)):
    return Ramp(Fraction(start), Fraction(top), Fraction(increment), interval)


def levels(profile):
    return [(int(s.rate), s.rate * s.seconds) for s in profile.segments]


def test_six_levels_of_ten_milliseconds_take_39_pulses():
    """The levels 400, 500, ... 900 of 10 ms each have 4 + 5 + 6 + 7 + 8 + 9 pulses."""
    table = ramp(1000)
    assert [int(level) for level in table.levels] == [400, 500, 600, 700, 800, 900] and table.pulses[-1] == 39


def test_a_long_index_goes_up_along_and_down():
    profile = ramp(1000).index(1000)
    up = [(400, 4), (500, 5), (600, 6), (700, 7), (800, 8), (900, 9)]
    assert levels(profile) == [*up, (1000, 922), *reversed(up)] and profile.pulses == 1000
    assert profile.end_ns == 2 * 60 * MS + 922 * MS


def test_a_short_index_has_a_small_plateau_on_the_next_level():
    """Of 70 pulses, the levels 400 to 800, up and down, take 60; the other ten run at 900."""
    profile = ramp(1000).index(70)
    up = [(400, 4), (500, 5), (600, 6), (700, 7), (800, 8)]
    assert levels(profile) == [*up, (900, 10), *reversed(up)]


def test_an_index_of_twice_the_ramp_never_reaches_the_speed():
    assert max(rate for rate, _ in levels(ramp(1000).index(78))) == 900


def test_an_index_shorter_than_the_lowest_levels_runs_at_the_start_speed():
    assert levels(ramp(1000).index(7)) == [(400, 7)]


def test_the_last_rise_may_be_smaller():
    assert [int(level) for level in ramp(1050).levels] == [400, 500, 600, 700, 800, 900, 1000]


@pytest.mark.parametrize("top", [400, 200])
def test_at_or_below_the_start_speed_there_is_no_ramp(top):
    assert levels(ramp(top).index(10)) == [(top, 10)]


def test_a_deceleration_begins_at_once_with_the_next_lower_level():
    assert [int(s.rate) for s in ramp(1000).down_from(Fraction(1000))] == [900, 800, 700, 600, 500, 400]
    assert [int(s.rate) for s in ramp(1000).down_from(Fraction(600))] == [500, 400]
    assert ramp(1000).down_from(Fraction(400)) == ()


@settings(max_examples=50, deadline=None)
@given(st.integers(1, 40), st.integers(1, 25_000), st.integers(1, 500), st.integers(0, 100_000))
def test_pulses_are_the_distance_and_the_profile_is_symmetrical(start, top, acceleration, distance):
    profile = ramp(top, start * 100, 100, Fraction(100, acceleration * 1000)).index(distance)
    segments = profile.segments
    assert profile.pulses == distance and sum((s.rate * s.seconds for s in segments), Fraction(0)) == distance
    assert [s.rate for s in segments] == [s.rate for s in reversed(segments)]
    assert all(s.rate <= max(top, 1) for s in segments)
