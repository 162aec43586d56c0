"""A joystick at the inputs of a board: its pulses, direction and AT ZERO."""

import pytest

from axistwin.core.errors import UsageError
from axistwin.core.units import MS, US
from axistwin.plant.joystick import Joystick, JoystickInputs
from axistwin.sim.clock import Clock
from axistwin.sim.pins import Pin


@pytest.fixture
def stick():
    clock = Clock()
    pins = {name: Pin(clock, name, level=True) for name in ("zero", "step", "direction")}
    joystick = Joystick(clock, pins, JoystickInputs("zero", "step", "direction"))
    seen = []
    for pin in pins.values():
        pin.subscribe(lambda pin: seen.append((clock.now, pin.name, pin.level)))
    return clock, joystick, seen


def test_it_is_not_there_until_it_is_touched(stick):
    clock, _, seen = stick
    clock.run_to(100 * MS)
    assert seen == []


def test_pulses_at_the_rate_of_the_deflection_once_it_has_been_at_zero_long_enough(stick):
    """A deflection gives 1,000 pulses/s, half a millisecond high and low; AT ZERO stays active for 4 ms more."""
    clock, joystick, seen = stick
    joystick.deflect(1000)
    clock.run_to(6 * MS)
    assert seen == [
        (0, "step", False), (4 * MS, "zero", False), (4 * MS, "step", True), (4 * MS + 500 * US, "step", False),
        (5 * MS, "step", True), (5 * MS + 500 * US, "step", False), (6 * MS, "step", True),
    ]  # fmt: skip


def test_let_go_it_finishes_its_pulse_and_is_at_zero(stick):
    clock, joystick, seen = stick
    joystick.deflect(1000)
    clock.run_to(4 * MS + 100 * US)
    joystick.deflect(0)
    clock.run_to(50 * MS)
    assert seen[-2:] == [(4 * MS + 500 * US, "step", False), (5 * MS, "zero", True)]
    assert joystick.rate == 0


def test_the_direction_changes_only_between_four_milliseconds_at_zero(stick):
    """Appendix C: AT ZERO "must be active for at least four milliseconds before and four milliseconds after"."""
    clock, joystick, seen = stick
    joystick.deflect(1000)
    clock.run_to(4 * MS + 100 * US)
    joystick.deflect(-2000)
    clock.run_to(18 * MS)
    at = {(name, level): time for time, name, level in seen if name != "step"}
    turned = at["direction", False]
    assert at["zero", True] == 5 * MS and turned - at["zero", True] >= 4 * MS
    assert at["zero", False] - turned == 4 * MS
    pulses = [time for time, name, level in seen if name == "step" and level and time > turned]
    assert pulses[1] - pulses[0] == 500 * US


def test_another_rate_in_the_same_direction_needs_no_zero(stick):
    clock, joystick, seen = stick
    joystick.deflect(1000)
    clock.run_to(4 * MS + 100 * US)
    joystick.deflect(500)
    clock.run_to(8 * MS)
    assert [time for time, name, level in seen if name == "step" and level] == [4 * MS, 5 * MS, 7 * MS]
    assert [level for _, name, level in seen if name == "zero"] == [False]


@pytest.mark.parametrize("rate", [2_000_001, -3_000_000])
def test_it_is_no_faster_than_the_input_takes(stick, rate):
    """Appendix C: the input accepts a "repetition rate of 2 megahertz", so the joystick is not faster."""
    with pytest.raises(UsageError, match="expected -2000000 to 2000000 pulses per second"):
        stick[1].deflect(rate)
