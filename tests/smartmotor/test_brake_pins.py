"""Sections 5.1 and 1.2: the pins of the brake's signal when they change their function, or lose the signal."""

import pytest

from .talking import ask, ready, tell

PINS = [("BRKC", "C"), ("BRKG", "G")]
HOLD = "MP D=0 G"


def changes(pin):
    """The levels that the pin takes from now on."""
    seen = []
    pin.subscribe(lambda changed: seen.append(changed.level))
    return seen


def test_a_limit_role_takes_the_pin_from_the_brake(bench):
    """5.1: "These commands will change the function of the I/O pin C": UCP as UCI does; UCO is a plain output then."""
    motor = ready(bench)
    tell(bench, motor, "UC=0 UCO BRKC")
    assert motor.pins["C"].volts == 5.0
    tell(bench, motor, "UCP", 0.01)
    assert ask(bench, motor, "RBp") == "1"  # nothing is wired to the limit
    tell(bench, motor, "UCO ZS", 0.01)
    assert motor.pins["C"].volts == 0.0
    tell(bench, motor, "BRKC")
    assert motor.pins["C"].volts == 5.0


@pytest.mark.parametrize(("brake", "name"), PINS)
def test_an_output_given_again_or_late_shows_the_signal_at_once(bench, brake, name):
    """5.1: "The I/O pin is set to 5 Vdc when brake engaged": no moment at 0 V when UGO (UCO) is given once more."""
    motor = ready(bench)
    pin = motor.pins[name]
    tell(bench, motor, f"U{name}=0 {brake} U{name}O")
    assert pin.volts == 5.0
    seen = changes(pin)
    tell(bench, motor, f"U{name}O")
    assert seen == []
    tell(bench, motor, HOLD)
    assert seen == [False]
    tell(bench, motor, f"U{name}=1 {brake} OFF U{name}O {HOLD}")
    assert seen == [False, True, False, True, False]  # UG=1, BRKG, OFF, G


@pytest.mark.parametrize(("brake", "name"), PINS)
@pytest.mark.parametrize("engaged", [True, False])
def test_the_pin_that_loses_the_signal_keeps_its_level(bench, brake, name, engaged):
    """1.2: "BRKG, BRKC, and BRKI are mutually exclusive"; the brake on the pin does not move when it is left."""
    motor = ready(bench)
    tell(bench, motor, f"U{name}={0 if engaged else 1} U{name}O {brake}" + ("" if engaged else f" {HOLD}"))
    seen = changes(motor.pins[name])
    tell(bench, motor, "BRKI BRKENG BRKRLS BRKSRV")
    assert (motor.pins[name].level, seen) == (engaged, [])
    tell(bench, motor, f"U{name}O")
    assert motor.pins[name].level is not engaged  # what the latch holds
