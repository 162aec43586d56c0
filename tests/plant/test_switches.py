"""Switches change on the exact pulse that crosses their edge."""

from fractions import Fraction

from axistwin.plant.stepper import StepperAxis
from axistwin.plant.switches import PositionSwitch, in_series
from axistwin.sim.clock import Clock
from axistwin.sim.motion.profile import Profile, Segment
from axistwin.sim.pins import Pin

S = 10**9
PERIOD = 10_000_000


def watched(clock, *ends):
    """Return pins in series with switches (axis, first, last), and a list of their changes as (time, level)."""
    pin, seen = Pin(clock, "home"), []
    in_series([PositionSwitch(*end) for end in ends], pin)
    pin.subscribe(lambda pin: seen.append((clock.now, pin.level)))
    return pin, seen


def go(axis, pulses, direction=+1):
    axis.start(Profile([Segment(Fraction(100), Fraction(pulses, 100))]), direction)


def test_a_home_switch_is_high_from_its_first_to_its_last_position():
    """100 pulses/s: position 10 is reached after 100 ms, position 13 after 130 ms."""
    clock = Clock()
    axis = StepperAxis(clock, "X")
    pin, seen = watched(clock, (axis, 10, 12))
    assert pin.level is False
    go(axis, 50)
    clock.run_to(S)
    assert seen == [(10 * PERIOD, True), (13 * PERIOD, False)]
    go(axis, 50, -1)  # from 50 down: 12 is reached after 38 pulses, 9 after 41
    clock.run_to(2 * S)
    assert seen[2:] == [(S + 38 * PERIOD, True), (S + 41 * PERIOD, False)]


def test_switches_in_series_open_together():
    clock = Clock()
    x, y = StepperAxis(clock, "X"), StepperAxis(clock, "Y")
    pin, seen = watched(clock, (x, None, 5), (y, None, 8))
    assert pin.level is True
    go(x, 10)
    go(y, 10)
    clock.run_to(S)
    assert seen == [(6 * PERIOD, False)]
    go(x, 10, -1)
    clock.run_to(2 * S)
    assert len(seen) == 1  # Y's switch is still open
    go(y, 10, -1)
    clock.run_to(3 * S)
    assert seen[1:] == [(2 * S + 2 * PERIOD, True)]


def test_a_change_of_course_is_followed():
    clock = Clock()
    axis = StepperAxis(clock, "X")
    _, seen = watched(clock, (axis, None, 20))
    go(axis, 50)
    clock.run_to(15 * PERIOD)
    axis.halt()
    clock.run_to(S)
    assert seen == []


def test_a_jammed_axis_does_not_reach_its_switch():
    clock = Clock()
    axis = StepperAxis(clock, "X")
    _, seen = watched(clock, (axis, None, 20))
    go(axis, 50)
    clock.run_to(15 * PERIOD)
    axis.jam(True)
    clock.run_to(S)
    assert seen == []
    axis.jam(False)
    go(axis, 10)
    clock.run_to(2 * S)
    assert seen == [(S + 6 * PERIOD, False)]
