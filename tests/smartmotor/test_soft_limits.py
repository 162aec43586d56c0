"""Software limits: section 3.2; they trip when the measured position is at or beyond the value (RULINGS 13)."""

import pytest

from .bits import BL, BM, BO, BP, BR
from .talking import UNIT, advance, ask, send, status_word


def test_soft_limits_are_disabled_and_zero_at_power_up(bench, motor):
    """3.2: "Software Limits are disabled by Default on Power-up"; SLP, SLN "Default value is 0"."""
    send(bench, motor, f"A={UNIT} V={UNIT} P=-100 G", 0.1)
    assert send(bench, motor, "RP PRINT(SLP,#13,SLN,#13)") == b"-100\r0\r0\r"


@pytest.mark.parametrize(("sign", "name"), [(1, "SLP"), (-1, "SLN")])
@pytest.mark.parametrize(("value", "reached"), [(21, 21), (22, 28), (28, 28), (300, 301), (1, 1), (2, 3)])
def test_a_soft_limit_trips_at_or_beyond_its_value(bench, motor, sign, name, value, reached):
    """RULINGS 13.  With A=1, V=7 positions are 1 3 6 10 15 21 28 35 …: the first at or beyond the value trips."""
    latched, now = (BR, BP) if sign > 0 else (BL, BM)
    send(bench, motor, f"SLP=10000 SLN=-10000 {name}={sign * value} SLE A={UNIT} V={sign * 7 * UNIT} MV G", 0.05)
    assert status_word(bench, motor) == BO + latched + now
    assert ask(bench, motor, "RMODE") == "B"
    assert motor.axes["shaft"].position == sign * reached
    assert motor.pins["brake"].level


def test_a_target_just_short_of_the_soft_limit_is_reached(bench, motor):
    """RULINGS 13: with a limit of 300, the target 299 is reached without a fault."""
    send(bench, motor, f"SLP=300 SLN=-300 SLE A={UNIT} V={UNIT} P=299 G", 0.1)
    assert (status_word(bench, motor), ask(bench, motor, "RP")) == (0, "299")
    send(bench, motor, "P=-299 G", 0.2)
    assert (status_word(bench, motor), ask(bench, motor, "RP")) == (0, "-299")
    send(bench, motor, "P=-300 G", 0.1)
    assert (status_word(bench, motor), ask(bench, motor, "RP")) == (BO + BL + BM, "-300")


def test_moving_off_a_soft_limit(bench, motor):
    """3.2 note 2: while the shaft is beyond the limit the flag is set again; within the limit it can be cleared."""
    send(bench, motor, f"SLP=100 SLN=-100 SLE A={UNIT} V={UNIT} P=150 G", 0.1)
    assert (status_word(bench, motor), ask(bench, motor, "RP")) == (BO + BR + BP, "100")
    send(bench, motor, "P=50 G", 0.1)
    assert ask(bench, motor, "RP") == "100"
    send(bench, motor, "Zr")
    assert status_word(bench, motor) == BO + BR + BP
    send(bench, motor, "P=50 G", 0.1)
    assert (status_word(bench, motor), ask(bench, motor, "RP")) == (BR, "50")
    send(bench, motor, "P=60 G", 0.1)
    assert ask(bench, motor, "RP") == "50"
    send(bench, motor, "Zr P=60 G", 0.1)
    assert (status_word(bench, motor), ask(bench, motor, "RP")) == (0, "60")


def test_values_are_changed_only_while_disabled(bench, motor):
    """3.2 note: "Software Limits must be disabled via the SLD command before their values are changed"."""
    send(bench, motor, "SLP=500 SLN=-500 SLE SLP=10 SLN=-10 PRINT(SLP,#13,SLN,#13)")
    assert send(bench, motor, "PRINT(SLP,#13,SLN,#13)") == b"500\r-500\r"
    send(bench, motor, "SLD SLP=10 SLN=-10")
    assert send(bench, motor, "PRINT(SLP,#13,SLN,#13)") == b"10\r-10\r"


def test_o_moves_the_measured_position_and_not_the_values(bench, motor):
    """3.2 note: "Their values are not affected by the command O=expression, but measured position is affected"."""
    send(bench, motor, "SLP=500 SLN=-500 SLE O=499")
    assert status_word(bench, motor) == BO
    send(bench, motor, "O=500")
    assert status_word(bench, motor) == BO + BR + BP
    assert send(bench, motor, "PRINT(SLP,#13,SLN,#13)") == b"500\r-500\r"
    send(bench, motor, "O=0")
    assert status_word(bench, motor) == BO + BR
    send(bench, motor, "ZS")
    assert status_word(bench, motor) == BO


def test_sle_with_both_values_zero_at_position_zero_trips_both(bench, motor):
    """RULINGS 13: a position equal to the value is at the limit; after SLD, ZS clears the flags."""
    send(bench, motor, "SLE")
    assert status_word(bench, motor) == BO + BR + BL + BP + BM
    send(bench, motor, "SLD")
    assert status_word(bench, motor) == BO + BR + BL
    send(bench, motor, "ZS")
    assert status_word(bench, motor) == BO


@pytest.mark.parametrize("name", ["SLP", "SLN"])
@pytest.mark.parametrize("value", [-(2**31), -1, 0, 1, 2**31 - 1])
def test_the_whole_range_of_a_soft_limit(bench, motor, name, value):
    """1.2: "Values must be between -2,147,483,648 to 2,147,483,647"; other values are refused."""
    assert send(bench, motor, f"{name}={value} PRINT({name},#13)") == f"{value}\r".encode()
    send(bench, motor, f"{name}=2147483648 {name}=-2147483649 {name}={2**31 - 1}+1")
    assert ask(bench, motor, f"PRINT({name},#13)") == str(value)


def test_a_pushed_shaft_reaches_the_limit_too(bench, motor):
    """3.2: "the CPU continuously monitors shaft position", also with the servo off."""
    send(bench, motor, "SLP=100 SLN=-100 SLE")
    motor.axes["shaft"].encoder.displace(100)
    advance(bench, 2)
    assert status_word(bench, motor) == BO + BR + BP
