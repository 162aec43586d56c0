"""Software limits: section 3.2; they trip when the measured position is at or beyond the value (RULINGS 13)."""

import pytest

from axistwin import Bench
from axistwin.bench import Controller

from .talking import ask, ready, tell

SAMPLE_NS = 245_760
BR, BL, BI, BO, BP, BM = 2, 4, 8, 128, 512, 1024
UNIT = 65_536


def word(bench: Bench, motor: Controller) -> int:
    """RW without Bi: the index mark is no matter of this chapter."""
    return int(ask(bench, motor, "RW")) & ~BI


def samples(bench: Bench, number: int) -> None:
    """To the end of so many samples from now."""
    bench.clock.run_to((bench.now // SAMPLE_NS + number) * SAMPLE_NS)


def test_soft_limits_are_disabled_and_zero_at_power_up(bench):
    """3.2: "Software Limits are disabled by Default on Power-up"; SLP, SLN "Default value is 0"."""
    motor = ready(bench)
    tell(bench, motor, f"A={UNIT} V={UNIT} P=-100 G", 0.1)
    assert tell(bench, motor, "RP PRINT(SLP,#13,SLN,#13)") == b"-100\r0\r0\r"


@pytest.mark.parametrize(("sign", "name"), [(1, "SLP"), (-1, "SLN")])
@pytest.mark.parametrize(("value", "reached"), [(21, 21), (22, 28), (28, 28), (300, 301), (1, 1), (2, 3)])
def test_a_soft_limit_trips_at_or_beyond_its_value(bench, sign, name, value, reached):
    """RULINGS 13.  A=1, V=7: 1 3 6 10 15 21 28 35 …: the first of them at or beyond the value is where it stops."""
    motor = ready(bench)
    latched, now = (BR, BP) if sign > 0 else (BL, BM)
    tell(bench, motor, f"SLP=10000 SLN=-10000 {name}={sign * value} SLE A={UNIT} V={sign * 7 * UNIT} MV G", 0.05)
    assert word(bench, motor) == BO + latched + now
    assert ask(bench, motor, "RMODE") == "B"
    assert motor.axes["shaft"].position == sign * reached
    assert motor.pins["brake"].level


def test_a_target_just_short_of_the_soft_limit_is_reached(bench):
    """299 is not at or beyond 300; 300 is."""
    motor = ready(bench)
    tell(bench, motor, f"SLP=300 SLN=-300 SLE A={UNIT} V={UNIT} P=299 G", 0.1)
    assert (word(bench, motor), ask(bench, motor, "RP")) == (0, "299")
    tell(bench, motor, "P=-299 G", 0.2)
    assert (word(bench, motor), ask(bench, motor, "RP")) == (0, "-299")
    tell(bench, motor, "P=-300 G", 0.1)
    assert (word(bench, motor), ask(bench, motor, "RP")) == (BO + BL + BM, "-300")


def test_moving_off_a_soft_limit(bench):
    """3.2 note 2, as with a switch: the flag comes back while the shaft is beyond, and goes when it is inside."""
    motor = ready(bench)
    tell(bench, motor, f"SLP=100 SLN=-100 SLE A={UNIT} V={UNIT} P=150 G", 0.1)
    assert (word(bench, motor), ask(bench, motor, "RP")) == (BO + BR + BP, "100")
    tell(bench, motor, "P=50 G", 0.1)
    assert ask(bench, motor, "RP") == "100"
    tell(bench, motor, "Zr")
    assert word(bench, motor) == BO + BR + BP
    tell(bench, motor, "P=50 G", 0.1)
    assert (word(bench, motor), ask(bench, motor, "RP")) == (BR, "50")
    tell(bench, motor, "P=60 G", 0.1)
    assert ask(bench, motor, "RP") == "50"
    tell(bench, motor, "Zr P=60 G", 0.1)
    assert (word(bench, motor), ask(bench, motor, "RP")) == (0, "60")


def test_values_are_changed_only_while_disabled(bench):
    """3.2 note: "Software Limits must be disabled via the SLD command before their values are changed"."""
    motor = ready(bench)
    tell(bench, motor, "SLP=500 SLN=-500 SLE SLP=10 SLN=-10 PRINT(SLP,#13,SLN,#13)")
    assert tell(bench, motor, "PRINT(SLP,#13,SLN,#13)") == b"500\r-500\r"
    tell(bench, motor, "SLD SLP=10 SLN=-10")
    assert tell(bench, motor, "PRINT(SLP,#13,SLN,#13)") == b"10\r-10\r"


def test_o_moves_the_measured_position_and_not_the_values(bench):
    """3.2 note: "Their values are not affected by the command O=expression, but measured position is affected"."""
    motor = ready(bench)
    tell(bench, motor, "SLP=500 SLN=-500 SLE O=499")
    assert word(bench, motor) == BO
    tell(bench, motor, "O=500")
    assert word(bench, motor) == BO + BR + BP
    assert tell(bench, motor, "PRINT(SLP,#13,SLN,#13)") == b"500\r-500\r"
    tell(bench, motor, "O=0")
    assert word(bench, motor) == BO + BR
    tell(bench, motor, "ZS")
    assert word(bench, motor) == BO


def test_sle_with_both_values_zero_at_position_zero_trips_both(bench):
    """RULINGS 13: at the value is at the limit; SLD takes the conditions away, ZS the flags."""
    motor = ready(bench)
    tell(bench, motor, "SLE")
    assert word(bench, motor) == BO + BR + BL + BP + BM
    tell(bench, motor, "SLD")
    assert word(bench, motor) == BO + BR + BL
    tell(bench, motor, "ZS")
    assert word(bench, motor) == BO


@pytest.mark.parametrize("name", ["SLP", "SLN"])
@pytest.mark.parametrize("value", [-(2**31), -1, 0, 1, 2**31 - 1])
def test_the_whole_range_of_a_soft_limit(bench, name, value):
    """1.2: "Values must be between -2,147,483,648 to 2,147,483,647"; beyond them the old value stays."""
    motor = ready(bench)
    assert tell(bench, motor, f"{name}={value} PRINT({name},#13)") == f"{value}\r".encode()
    tell(bench, motor, f"{name}=2147483648 {name}=-2147483649 {name}={2**31 - 1}+1")
    assert ask(bench, motor, f"PRINT({name},#13)") == str(value)


def test_a_hand_that_pushes_the_shaft_reaches_the_limit_too(bench):
    """3.2: "the CPU continuously monitors shaft position", also with the servo off."""
    motor = ready(bench)
    tell(bench, motor, "SLP=100 SLN=-100 SLE")
    motor.axes["shaft"].encoder.displace(100)
    samples(bench, 2)
    assert word(bench, motor) == BO + BR + BP
