"""Pulse trains: consecutive moves, and the limit of stored moves."""

from fractions import Fraction

import pytest

from axistwin.core.errors import UsageError
from axistwin.sim.motion.profile import Profile, Segment
from axistwin.sim.motion.train import Train

S = 10**9


def constant(rate, pulses):
    return Profile([Segment(Fraction(rate), Fraction(pulses, rate))])


def test_positions_add_up_over_strokes():
    train = Train()
    train.start(0, +1, constant(100, 10))
    train.start(S, -1, constant(100, 4))
    assert [train.move_at(t).position_at(t) for t in (0, S // 20, S, 2 * S)] == [0, 5, 10, 6]


def test_pulse_times_are_cut_to_the_span_asked_for():
    train = Train()
    train.start(0, +1, constant(100, 10))
    train.start(S, -1, constant(50, 4))
    assert train.pulse_times(80_000_000, S + 40_000_000).tolist() == [
        80_000_000, 90_000_000, 100_000_000, S + 20_000_000,
    ]  # fmt: skip


def test_a_stroke_that_begins_ends_the_one_before():
    train = Train()
    train.start(0, +1, Profile([Segment(Fraction(100), None)]))
    train.start(55_000_000, +1, constant(100, 1))
    assert train.move.position_at(S) == 6 and len(train.pulse_times(0, S)) == 6


def test_a_bounded_history_says_what_it_has_forgotten():
    train = Train(history=3)
    for second in range(5):
        train.start(second * S, +1, constant(100, 1))
    assert len(train.moves) == 3 and train.move.position_at(10 * S) == 5
    assert len(train.pulse_times(2 * S, 10 * S)) == 3
    with pytest.raises(UsageError, match=r"before 2 s are no longer stored: request later pulses, or .*history=6"):
        train.pulse_times(0, 10 * S)


def test_it_is_known_when_a_position_is_reached():
    stroke = Train().start(S, -1, constant(100, 10))
    assert stroke.reaches_ns(-3) == S + 30_000_000 and stroke.reaches_ns(-11) is None
    assert stroke.reaches_ns(1) is None
