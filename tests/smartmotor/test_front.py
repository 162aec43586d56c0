"""Every lamp on the front of a SmartMotor, on and off as the manual defines it."""

import pytest

from axistwin import Bench

from ..fronts import lamps, shown
from .talking import UNIT, ask, bare, clear, load, ready, send

WORD, CHANNELS, MOTOR, PINS = "Status word W", "Channels", "Motor", "User pins"


def told(text, seconds=0.01):
    return lambda bench, motor: send(bench, motor, text, seconds)


def jammed(bench, motor):
    """Return a motor with a data sheet that drives against a jammed shaft."""
    motor.axes["shaft"].jam(True)
    send(bench, motor, "E=100 A=1000 V=400000 P=2000 G", 0.5)


def hot(bench, motor):
    motor.ambient = 75
    send(bench, motor, "THD=10", 0.1)


def broken_download(bench, motor):
    send(bench, motor, b"LOAD ")
    send(bench, motor, b"a=5\nb=6\n")
    motor.power_cycle()
    bench.run(0.5)


def wrong_parity(bench, motor):
    send(bench, motor, "OCHN(RS2,0,E,9600,1,8,C)", 0.1)
    motor.serial.host.parity = "O"
    send(bench, motor, "a=1", 0.1)


def line_break(bench, motor):
    motor.serial.send_break(0.01)
    bench.run(0.1)


def drive(pin, level):
    def act(bench, motor):
        motor.pins[pin].drive(level)
        bench.run(0.01)

    return act


SITUATIONS = {
    (WORD, "Bt"): told(f"A={UNIT} V={UNIT} P=5000 G"), (WORD, "Br"): told("UCP"), (WORD, "Bl"): told("UDM"),
    (WORD, "Bi"): told(f"A={UNIT} V={UNIT} P=600 G", 0.3), (WORD, "Bw"): told(f"A={UNIT} O=2147483643 V={UNIT} MV G"),
    (WORD, "Be"): jammed, (WORD, "Bh"): hot, (WORD, "Bx"): drive("index", True), (WORD, "Bp"): told("UCP"),
    (WORD, "Bm"): told("UDM"), (WORD, "Bd"): told("a=1/0"), (WORD, "Bu"): told("aw[102]=1"), (WORD, "Bs"): told("RQ"),
    (WORD, "Ba"): jammed, (WORD, "Bk"): broken_download, (CHANNELS, "Bb"): wrong_parity, (CHANNELS, "Bf"): line_break,
    (CHANNELS, "Bc"): told("a" * 200),
}  # fmt: skip
"""Situations that light a lamp which is dark on a motor without faults that is off."""
LIT_WHEN_OFF = {
    (WORD, "Bo"): told(f"A={UNIT} V={UNIT} P=10 G"),
    (MOTOR, "BRK"): told(f"A={UNIT} V={UNIT} P=10 G"),
    **{(PINS, pin): drive(pin, False) for pin in "ABCDEFG"},
}
"""Situations that put out a lamp which is lit there."""
NEEDS_REAL_LINE = wrong_parity, line_break
"""Situations of single bits, which need a line with character times."""


def motor_for(bench, situation):
    if situation in NEEDS_REAL_LINE:
        return clear(bench, bench.add("smartmotor"))
    return ready(bench, shaft={"motor": "frame23"}) if situation is jammed else ready(bench)


@pytest.mark.parametrize("lamp", SITUATIONS, ids=" ".join)
def test_a_lamp_is_lit_when_the_manual_says_so(bench, lamp):
    motor = motor_for(bench, SITUATIONS[lamp])
    assert shown(motor, *lamp) is False
    SITUATIONS[lamp](bench, motor)
    assert shown(motor, *lamp) is True


@pytest.mark.parametrize("lamp", LIT_WHEN_OFF, ids=" ".join)
def test_a_lamp_that_is_lit_when_it_is_off_goes_out(bench, motor, lamp):
    assert shown(motor, *lamp) is True
    LIT_WHEN_OFF[lamp](bench, motor)
    assert shown(motor, *lamp) is False


def test_there_is_no_lamp_without_a_situation():
    assert lamps(Bench().add("smartmotor")) == SITUATIONS.keys() | LIT_WHEN_OFF.keys()


def test_at_power_up_it_is_as_in_the_table_of_boot_up_defaults(bench):
    """2.0: at power-up both limits are asserted, MTB is active, and the brake is engaged."""
    motor = bare(bench)
    lit = [letter for group, letter in lamps(motor) if group == WORD and shown(motor, group, letter)]
    assert sorted(lit) == ["Bl", "Bm", "Bo", "Bp", "Br"]
    assert shown(motor, MOTOR, "MODE") == "B  mode torque brake" and shown(motor, MOTOR, "BRK") is True


@pytest.mark.parametrize(("text", "word"), [
    ("BRKRLS OFF", "O"), ("MTB", "B"), (f"A={UNIT} V=10 P=5000 G", "P"), (f"A={UNIT} V=10 D=5000 G", "R"),
    (f"A={UNIT} V=10 MV G", "V"), ("T=1 MT", "T"), ("MF4", "F"), ("MFMUL=1 MFDIV=2 MFR G", "X"), ("MS", "S")
])  # fmt: skip
def test_the_mode_by_its_letter(bench, motor, text, word):
    send(bench, motor, text, 0.01)
    assert ask(bench, motor, "RMODE") == word and str(shown(motor, MOTOR, "MODE")).split("  ")[0] == word


def test_readings_are_what_the_reports_say(bench):
    """The readings equal the reports, also in the middle of a block that is computed ahead."""
    motor = ready(bench, shaft={"motor": "frame23"})
    send(bench, motor, f"A=100 V={UNIT} P=3000 G", 0.3)
    for label, report in (("@P", "RP"), ("@PE", "RPE"), ("TEMP", "RTEMP")):
        assert shown(motor, MOTOR, label) == ask(bench, motor, report, 0)
    assert float(shown(motor, MOTOR, "@V")) == pytest.approx(int(ask(bench, motor, "RV", 0)) / UNIT, abs=0.001)
    assert float(shown(motor, MOTOR, "UIA")) == pytest.approx(int(ask(bench, motor, "PRINT(UIA,#13)", 0)) / 100)
    assert float(shown(motor, MOTOR, "UJA")) == pytest.approx(int(ask(bench, motor, "PRINT(UJA,#13)", 0)) / 10)


def test_a_mode_that_is_an_error(bench):
    """4.1: the mode is an error after a position error, if BRKRLS and OFF have disabled MTB."""
    motor = ready(bench, shaft={"motor": "frame23"})
    send(bench, motor, "BRKRLS OFF")
    jammed(bench, motor)
    assert shown(motor, MOTOR, "MODE") == "E  error"


def test_without_power_it_is_in_no_mode(bench, motor):
    """2.0: OFF is a mode of its own, which RMODE reports as O; without power there is none."""
    told = []
    motor.follow(["RMODE"], lambda times, which, values: told.extend(values))
    send(bench, motor, f"A={UNIT} V=10 P=5000 G")
    motor.power(False)
    bench.run(0.1)
    assert shown(motor, MOTOR, "MODE") == "no power"
    assert told[-1] == motor.registers["RMODE"].read(), "who follows it knows the same"
    assert [letter for group, letter in lamps(motor) if group in (WORD, CHANNELS) and shown(motor, group, letter)] == []


def test_reading_the_front_changes_nothing(bench):
    """A motor moves in the same way whether its lamps are read after every step or never."""
    ends = []
    for looks in (True, False):
        other = Bench()
        motor = ready(other, shaft={"motor": "frame23"})
        load(other, motor, "a=0\nWHILE a<50\na=a+1\nWAIT=20\nLOOP\nEND\n")
        send(other, motor, f"RUN A=100 V={UNIT} P=3000 G", 0)
        for _ in range(40):
            other.run(0.013)
            if looks:
                _ = [shown(motor, *lamp) for lamp in lamps(motor)]
        ends.append((send(other, motor, "Ra RP RPE RW RI"), motor.axes["shaft"].velocity))
    assert ends[0] == ends[1]
