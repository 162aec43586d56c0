"""A low supply voltage: UJA, and the reset of the processor (base 6; 2.0)."""

import pytest

from axistwin import Bench
from axistwin.core.errors import UsageError

from .scripts import play, scripts
from .talking import clear, ready, send

FRAME23 = {"motor": "frame23"}  # 48 V


def dip(bench, left, duration=None):
    bench.faults.add("supply_dip", "smartmotor", left=left, duration=duration)


@scripts({
    "A dip to 0.376 × 48 V = 18.05 V resets nothing; UJA reads it in 0.1 V":
    [f"with frame23; a=7 A=100 V=65536 MV G; dip {left} 0.01; PRINT(UJA,#13) -> {volts}; 0.05 s; "
     "Ra RBt PRINT(UJA,#13) -> 7 1 480"
     for left, volts in ((0.9, "432"), (0.5, "240"), (0.376, "180"))],
    "As at power-up, the program starts 200 ms after the supply has come back":
    'with frame23; load PRINT("up",#13) END; dip 0.2 0.05; 0.249 s; receives nothing; 0.01 s; receives up<CR>',
    "switch and supply are both needed":
    "with frame23; dip 0.2; power off; mend; RMODE; dip 0.2; power on; RMODE; 0.3 s; mend; RMODE -> B",
})  # fmt: skip
def test_supply(script):
    play(script)


def test_a_deeper_dip_resets_the_processor(bench):
    """A dip to 0.37 × 48 V = 17.76 V: no answers during the dip, then the state of power-up (2.0), variables 0."""
    motor = ready(bench, shaft=FRAME23)
    send(bench, motor, "a=7 A=1000 V=200000 MV G", 0.3)
    assert motor.axes["shaft"].moving
    dip(bench, 0.37, 0.02)
    assert send(bench, motor, "RMODE Ra", 0.015) == b"" and motor.pins["brake"].level
    assert motor.powered
    bench.run(0.5)
    assert send(bench, motor, "RMODE Ra RBo RW") == b"B\r0\r1\r1670\r"


def test_the_shaft_coasts_while_the_processor_is_in_reset(bench):
    """The windings are open, so the shaft coasts; after the reset the position is 0 wherever the shaft is."""
    motor = ready(bench, shaft=FRAME23)
    send(bench, motor, "A=1000 V=200000 MV G", 0.3)
    before = motor.axes["shaft"].position
    dip(bench, 0.1)
    bench.run(0.02)
    assert motor.axes["shaft"].position > before + 100
    bench.faults.mend("supply_dip")
    assert send(bench, motor, "O=0 RBo", 1.0) == b"1\r" and motor.axes["shaft"].position > before


def test_the_voltage_of_the_reset_is_an_option(bench):
    never = ready(bench, shaft=FRAME23, reset_below_v=0)
    send(bench, never, "a=7")
    dip(bench, 0.0, 0.1)
    bench.run(0.2)
    assert send(bench, never, "Ra") == b"7\r"
    other = Bench()
    early = clear(other, other.add("smartmotor", line="instant", shaft=FRAME23, reset_below_v=40))
    send(other, early, "a=7")
    dip(other, 0.8, 0.1)
    other.run(0.2)
    assert send(other, early, "Ra") == b"0\r"
    with pytest.raises(UsageError, match="reset_below_v"):
        other.add("smartmotor", name="third", reset_below_v=-1)


def test_it_says_why_it_is_silent(bench):
    motor = ready(bench, shaft=FRAME23)
    assert motor.hint == ""
    dip(bench, 0.2)
    assert motor.hint == "held in reset, as its supply is below 18 V: raise it, or lower the option reset_below_v"
    bench.faults.mend("supply_dip")
    assert motor.hint == ""


OPEN = (
    "in a limit fault, as pins C and D are not held low: give the shaft limits, or UCI UDI ZS at the top of the program"
)


def test_it_says_why_it_does_not_move(bench):
    """At power-up the limit switches are open; ZS clears each fault before the next one."""
    motor = bench.add("smartmotor", line="instant", shaft=FRAME23)
    motor.axes["shaft"].jam(True)
    for before, command, hint in (
        ("", "G", OPEN),
        ("UDI ZS", "UCI G", "a limit fault has not been cleared: ZS or Zr"),
        ("ZS E=5 A=65536 V=999999 MV G", "G", "a position error has not been cleared: free the shaft, then ZS or Ze"),
        (
            "ZS E=32000 THD=1 TH=10",
            "G",
            "an overheat fault has not been cleared: let it cool to 5 °C below TH, then ZS or Zh",
        ),
    ):
        send(bench, motor, before, 0.3)
        send(bench, motor, command)
        assert motor.hint == hint
