"""Trapezoids between any two rates: a move of d at v with a takes d/v + v/a, and makes exactly d pulses."""

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from axistwin.core.units import S
from axistwin.sim.motion.profile import Profile
from axistwin.sim.motion.trapezoid import Limits, ramp


def limits(top, start, up, down=0):
    return Limits(*map(Fraction, (top, start, up, down)))


def to_distance(distance, rate=0, **figures):
    return Profile(limits(**figures).to_distance(Fraction(rate), Fraction(distance)))


PLAIN = {"top": 1000, "start": 0, "up": 10_000}


@pytest.mark.parametrize(("distance", "figures", "seconds"), [
    (5000, PLAIN, 5.1),                                           # 5000/1000 + 1000/10000
    (100, PLAIN, 0.2),                                            # d = v²/a: the ramps meet at 1000 pulses/s
    (25, PLAIN, 0.1),                                             # a triangle to √(25 · 10000) = 500: 2 · 500/10000
    (5000, PLAIN | {"down": 5000}, 5.15),                         # ramps 50 in 0.1 s, 100 in 0.2 s; 4850/1000
    (75, PLAIN | {"down": 5000}, 0.212132035),                    # to √(2·75·10000·5000/15000) = 707.1067812
    (5000, PLAIN | {"start": 200}, 5.064),                        # ramps 48 in 0.08 s each; 4904/1000
    (50, PLAIN | {"start": 1000}, 0.05),                          # no ramp
    (50, PLAIN | {"start": 3000}, 0.05),                          # the start rate is not above the velocity
    (1, PLAIN | {"up": 100}, 0.2),                                # to √(1 · 100) = 10
    (1, PLAIN, 0.02),                                             # to 100
    (1_000_000, PLAIN | {"top": 20_000, "up": 4000}, 55),         # 50 + 5
])  # fmt: skip
def test_the_times_of_moves_from_rest(distance, figures, seconds):
    move = to_distance(distance, **figures)
    assert move.pulses == distance
    assert 0 <= move.end_ns - round(seconds * S) <= 3  # rates are rounded down to thousandths


@pytest.mark.parametrize(("rate", "distance", "figures", "pulses", "seconds"), [
    (1000, 1050, PLAIN, 1050, 1.1),                               # 1000 at 1000, 50 of the ramp
    (1000, 50, PLAIN, 50, 0.1),                                   # only the ramp
    (1000, 49, PLAIN, 50, 0.1),                                   # too late to stop there
    (1000, -200, PLAIN, 50, 0.1),
    (2000, 2000, PLAIN, 2000, 2.0),                               # to 1000 in 0.1 s (150), 1800 at 1000, 50 in 0.1 s
    (500, 1000, PLAIN, 1000, 1.0625),                             # 37.5 in 0.05 s, 912.5 at 1000, 50 in 0.1 s
    (100, 1000, PLAIN | {"start": 300}, 1000, 1.049),             # at once 300: twice 45.5 in 0.07 s, 909 at 1000
])  # fmt: skip
def test_a_target_in_motion(rate, distance, figures, pulses, seconds):
    move = to_distance(distance, rate, **figures)
    assert (move.pulses, move.end_ns) == (pulses, pytest.approx(seconds * S, abs=3))


def test_a_ramp_has_the_area_of_the_line():
    levels = ramp(Fraction(0), Fraction(1000), Fraction(10_000))  # 0.1 s in stairs of 1 ms, 5, 15 … 995 pulses/s
    assert [levels[0].rate, levels[1].rate, levels[-1].rate] == [5, 15, 995]
    assert len(levels) == 100 and sum(level.rate * level.seconds for level in levels) == 50


def test_a_slow_ramp_has_at_most_251_stairs():
    levels = ramp(Fraction(30_000), Fraction(0), Fraction(7))
    assert len(levels) <= 251
    assert float(sum(level.seconds for level in levels)) == pytest.approx(30_000 / 7, abs=1e-8)


@pytest.mark.parametrize(("rate", "wanted", "start", "first", "last"), [
    (0, 1000, 0, 5, 1000), (0, 1000, 200, 205, 1000), (0, 100, 200, 100, 100), (1000, 400, 0, 995, 400),
])  # fmt: skip
def test_an_endless_motion(rate, wanted, start, first, last):
    segments = limits(**PLAIN | {"start": start}).to_rate(Fraction(rate), Fraction(wanted))
    assert (segments[0].rate, segments[-1]) == (first, (last, None))


def test_a_stop_ends_at_the_start_rate():
    stop = Profile(limits(**PLAIN | {"start": 200}).to_rate(Fraction(1000), Fraction(0)))
    assert (stop.pulses, stop.end_ns) == (48, 80_000_000)
    assert Profile(limits(**PLAIN | {"start": 200}).to_rate(Fraction(150), Fraction(0))).end_ns == 0


rates = st.integers(1, 5_000_000).map(lambda thousandths: Fraction(thousandths, 1000))


@given(rates, st.one_of(st.just(Fraction(0)), rates), rates, rates, st.integers(1, 10**6))
def test_a_move_makes_exactly_its_pulses(top, start, up, down, distance):
    move = Profile(Limits(top, start, up, down).to_distance(Fraction(0), Fraction(distance)))
    assert move.pulses == distance
    assert all(0 < segment.rate <= top for segment in move.segments)


@given(rates, rates, rates, rates, st.fractions(0, 10**5, max_denominator=1000), st.one_of(st.just(Fraction(0)), rates))
def test_a_change_in_motion_ends_at_the_distance_or_stops(top, up, down, rate, distance, start):
    move = Profile(Limits(top, start, up, down).to_distance(rate, distance))
    stop = Profile(Limits(top, start, up, down).to_rate(rate, Fraction(0)))
    assert move.pulses in {distance.__floor__(), stop.pulses}
    assert move.pulses == distance.__floor__() or distance < stop.pulses + 1
