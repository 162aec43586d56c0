"""Pulse times of many moves at once, against the times of each move by itself."""

import tracemalloc
from fractions import Fraction

import numpy as np
import pytest

from axistwin.sim.motion import expansion
from axistwin.sim.motion.profile import Profile, Segment
from axistwin.sim.motion.ramp import Ramp
from axistwin.sim.motion.train import Train

RAMP = Ramp(Fraction(400), Fraction(10_000), Fraction(100), Fraction(1, 100))


def cut(elapsed_ns):
    """Return a move that was stopped at an odd nanosecond: its common denominators are large."""
    profile = RAMP.run()
    return profile.cut(elapsed_ns, RAMP.down_from(profile.rate_at(elapsed_ns)))


def fine(distance):
    """Return a move whose rates have a large denominator, as quantised ramps have."""
    unit = Fraction(13_107_200, 3 * (1 << 16))
    return Profile([Segment(unit * n, Fraction(1, 500)) for n in range(1, distance)], phase=Fraction(1, 7))


PROFILES = {
    "ramps": [RAMP.index(distance) for distance in range(1, 400, 7)],
    "stopped": [cut(30_000_001 + 7_777_777 * n) for n in range(20)],
    "fine": [fine(n) for n in range(2, 40)],
    "finest": [Profile([Segment(Fraction(10**9 + n, 10**6 + 3), Fraction(1, 50))]) for n in range(9)],
    "repeated": [RAMP.index(distance) for distance in (250, 900, 250, 250, 900, 41, 250)],
    "with dwells": [
        Profile(
            [
                Segment(Fraction(700), Fraction(1, 3)),
                Segment(Fraction(0), Fraction(2)),
                Segment(Fraction(1, 3), Fraction(9)),
            ]
        ),
        Profile(()),
    ]
    * 2,
    "long": [
        Profile([Segment(Fraction(10_000), Fraction(1, 2)), Segment(Fraction(36_025, 4), Fraction(3))]),
        RAMP.index(20_000),
    ],
    "all kinds": [RAMP.index(5), cut(99_999_999), fine(5), RAMP.index(5), Profile(()), RAMP.index(20_000)],
}


def expected_times(moves):
    """Return the exact times of all moves in Python's integers."""
    return [start + profile.pulse_ns(n + 1) for start, profile in moves for n in range(profile.pulses)]


@pytest.mark.parametrize("segments", [1 << 14, 100])
@pytest.mark.parametrize("kind", PROFILES)
def test_times_of_many_moves_are_those_of_each_move(kind, segments, monkeypatch):
    monkeypatch.setattr(expansion, "SEGMENTS", segments)
    monkeypatch.setattr(expansion, "PIECE", 300)
    moves = [(1_000_000_007 * k, profile) for k, profile in enumerate(PROFILES[kind])]
    expected = expected_times(moves)
    times = np.full(len(expected), -1)
    expansion.expand(moves, times)
    assert times.tolist() == expected


@pytest.mark.parametrize(("kind", "method"), [("ramps", "arrays"), ("stopped", "integers"), ("finest", "one_by_one")])
def test_each_method_is_in_use(kind, method):
    assert expansion._method(PROFILES[kind][-1]) is getattr(expansion, f"_by_{method}", expansion._one_by_one)


def test_a_part_of_a_history_begins_and_ends_within_moves():
    train, now = Train(), 0
    for distance in (100, 300, 100, 500, 700):
        profile = RAMP.index(distance)
        train.start(now, +1, profile)
        now += profile.end_ns + 5_000_000
    times = train.pulse_times(0, now)
    assert len(times) == 1700
    for first, last in ((50, 60), (50, 350), (0, 450), (399, 1100), (1000, 1699)):
        assert train.pulse_times(int(times[first]), int(times[last])).tolist() == times[first:last].tolist()


def test_memory_is_at_most_three_times_the_result():
    train, now = Train(), 0
    for k in range(600):
        profile = RAMP._index(1000 + k)
        train.start(now, +1, profile)
        now += profile.end_ns
    train.pulse_times(0, now + 1)  # the first call imports
    tracemalloc.start()
    times = train.pulse_times(0, now + 1)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert len(times) == 779_700 and peak <= 3 * times.nbytes
