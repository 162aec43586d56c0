"""Software limits: section 3.2; they trip when the measured position is at or beyond the value (RULINGS 13)."""

import pytest

from .bits import BL, BM, BO, BP, BR
from .scripts import play, scripts
from .talking import UNIT, ask, send, status_word


@scripts({
    '3.2: "Software Limits are disabled by Default on Power-up"; SLP, SLN "Default value is 0"':
    f"A={UNIT} V={UNIT} P=-100 G; 0.1 s; RP PRINT(SLP,#13,SLN,#13) -> -100 0 0",
    "RULINGS 13: with a limit of 300, the target 299 is reached without a fault":
    f"SLP=300 SLN=-300 SLE A={UNIT} V={UNIT} P=299 G; 0.1 s; W; RP -> 299; P=-299 G; 0.2 s; W; RP -> -299; "
    "P=-300 G; 0.1 s; W lom; RP -> -300",
    "3.2 note 2: while the shaft is beyond the limit the flag is set again; within the limit it can be "
    "cleared":
    f"SLP=100 SLN=-100 SLE A={UNIT} V={UNIT} P=150 G; 0.1 s; W rop; RP -> 100; 0.001 s; P=50 G; 0.1 s; "
    "RP -> 100; 0.001 s; Zr; 0.001 s; W rop; P=50 G; 0.1 s; W r; RP -> 50; 0.001 s; P=60 G; 0.1 s; RP -> 50; "
    "0.001 s; Zr P=60 G; 0.1 s; W; RP -> 60; 0.001 s",
    '3.2 note: "Software Limits must be disabled via the SLD command before their values are changed"':
    "SLP=500 SLN=-500 SLE SLP=10 SLN=-10 PRINT(SLP,#13,SLN,#13) -> *; PRINT(SLP,#13,SLN,#13) -> 500 -500; "
    "SLD SLP=10 SLN=-10 -> *; PRINT(SLP,#13,SLN,#13) -> 10 -10",
    '3.2 note: "Their values are not affected by the command O=expression, but measured position is affected"':
    "SLP=500 SLN=-500 SLE O=499; 0.001 s; W o; O=500; 0.001 s; W rop; PRINT(SLP,#13,SLN,#13) -> 500 -500; "
    "0.001 s; O=0; 0.001 s; W ro; ZS; 0.001 s; W o",
    "RULINGS 13: a position equal to the value is at the limit; after SLD, ZS clears the flags":
    "SLE; 0.001 s; W rlopm; SLD; 0.001 s; W rlo; ZS; 0.001 s; W o",
    '1.2: "Values must be between -2,147,483,648 to 2,147,483,647"; other values are refused':
    [f"{name}={value} PRINT({name},#13) -> {value}; "
     f"{name}=2147483648 {name}=-2147483649 {name}={2 ** 31 - 1}+1; PRINT({name},#13) -> {value}"
     for name in ("SLP", "SLN") for value in (-2 ** 31, -1, 0, 1, 2 ** 31 - 1)],
    '3.2: "the CPU continuously monitors shaft position", also with the servo off':
    "SLP=100 SLN=-100 SLE; push 100; 2 samples; W rop",
})  # fmt: skip
def test_soft_limits(script):
    play(script)


@pytest.mark.parametrize(("sign", "name"), [(1, "SLP"), (-1, "SLN")])
@pytest.mark.parametrize(("value", "reached"), [(21, 21), (22, 28), (28, 28), (300, 301), (1, 1), (2, 3)])
def test_a_soft_limit_trips_at_or_beyond_its_value(bench, motor, sign, name, value, reached):
    """RULINGS 13.  With A=1, V=7 positions are 1 3 6 10 15 21 28 35 …: the first at or beyond the value trips."""
    latched, now = (BR, BP) if sign > 0 else (BL, BM)
    send(bench, motor, f"SLP=10000 SLN=-10000 {name}={sign * value} SLE A={UNIT} V={sign * 7 * UNIT} MV G", 0.05)
    assert status_word(bench, motor) == BO + latched + now and ask(bench, motor, "RMODE") == "B"
    assert motor.axes["shaft"].position == sign * reached and motor.pins["brake"].level
