"""Section 3: hardware limits, and moving off a limit after its acknowledgement (RULINGS 15)."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench
from axistwin.bench import Controller

from .bits import BL, BM, BO, BP, BR
from .scripts import play, scripts
from .talking import UNIT, advance, send, status_word

PINS = {"C": (BR, BP, +1, "Zr", "UCI"), "D": (BL, BM, -1, "Zl", "UDI")}
ACTS = [
    "+C", "-C", "+D", "-D", "ZS", "Zr", "Zl", "S", "X", "V=65536 G", "V=-65536 G", "D=9 MP G", "MV", "P=-99 G", "OFF",
]  # fmt: skip


def wired(bench: Bench, **options) -> Controller:
    """Return a motor with closed limit switches on C and D, without faults, half a second after power-up."""
    motor = bench.add("smartmotor", line="instant", **options)
    motor.pins["C"].drive(0.0)
    motor.pins["D"].drive(0.0)
    bench.run(0.5)
    assert send(bench, motor, "ZS RW") == b"128\r"
    return motor


def run_into(bench: Bench, motor: Controller, pin: str) -> int:
    """Move towards the switch on this pin at one count per sample until it opens; return the final position."""
    send(bench, motor, f"A={UNIT} V={PINS[pin][2] * UNIT} MV G", 0.01)
    motor.pins[pin].release()
    advance(bench, 2)
    return motor.axes["shaft"].position


@pytest.fixture
def motor(bench: Bench) -> Controller:
    return wired(bench)


def into(pin):
    """Return the acts that drive the motor into the switch on this pin, at one count per sample."""
    return f"wired; A={UNIT} V={PINS[pin][2] * UNIT} MV G; 0.01 s; {pin} released; 2 samples; mark"


@scripts({
    '3.1 note 3: "assign right limit to be used as standard user-input port": such a pin is not a limit':
    [f"wired; {role}; A={UNIT} V={sign * UNIT} MV G; 0.01 s; {pin} released; 2 samples; "
     f"W t; RU{pin} -> 1"
     for pin, (latched, now, sign, own, role) in PINS.items()],
    "Reference 12: UCP and UDM make open pins limits again, so the next sample sets the faults again":
    "UCP; 0.001 s; W rop; UDM; 0.001 s; W rlopm",
    '3.2 note 1: "The fault has to be cleared before", even if the switch has closed again':
    [f"wired; A={UNIT} V={sign * UNIT} MV G; 0.01 s; {pin} released; 2 samples; mark; {pin} low; "
     f"T=500 MP; master 1000 in 0.01 s; {command}; 0.1 s; W {BO + latched}; RMODE -> B; moved 0; "
     f"{own}; W o"
     for pin, (latched, now, sign, own, role) in PINS.items()
     for command in (
         "G", "MT", "MF1", "MF2", "MF4", "MS", "S", "X", "P=@P-100 G", "P=@P+100 G", "MV V=-V G",
     )],
    '3.1 note 1: "You can move in the opposite direction … but the Historical Limit Status bit must be '
    'cleared first". While the switch is open the flag reads 1 again at the next sample (RULINGS 15); with '
    "the switch closed it stays 0":
    [f"{into(pin)}; "
     f"MP D={-50 * sign} G; 0.1 s; moved 0; {clear if clear == 'ZS' else own}; 0.001 s; "
     f"W {BO + latched + now}; V={UNIT} D={-50 * sign} G; 0.1 s; "
     f"moved {-(50 * sign)}; W {latched + now}; {pin} low; 2 samples; "
     f"W {latched}; {own}; 0.001 s; W; D={10 * sign} G; 0.1 s; "
     f"moved {-(40 * sign)}"
     for pin, (latched, now, sign, own, role) in PINS.items() for clear in ("ZS", "own")],
    'RULINGS 15: "A move towards it is not, and needs a new acknowledgement"':
    [f"{into(pin)}; "
     f"{own} MP D={50 * sign} G; 0.1 s; moved 0; {own} D={-50 * sign} G; "
     f"0.1 s; moved {-(50 * sign)}"
     for pin, (latched, now, sign, own, role) in PINS.items()],
    "RULINGS 15: torque that is reversed towards the limit is a new fault, which needs a new acknowledgement":
    [f"{into(pin)}; "
     f"{own} {before.format(s=sign)}; 0.01 s; T={sign}*1000; 0.1 s; "
     f"W {BO + latched + now}"
     for pin, (latched, now, sign, own, role) in PINS.items() for before in ("MT", "T=-1*{s}*500 MT")],
    '1.1, 3.1: "directional only": at the end that the motor leaves, an open switch is flagged; the move '
    "continues":
    [f"wired; A={UNIT} V={UNIT} P={-200 * sign} MP G; 0.01 s; {pin} released; 0.1 s; "
     f"RP -> {-200 * sign}; W {latched + now}"
     for pin, (latched, now, sign, own, role) in PINS.items()],
    'RULINGS 15: "With both limits asserted there is no way out but wiring or UCI/UDI"':
    f"{into('C')}; D released; 2 samples; mark; "
    f"ZS V=65536 MV G; 0.05 s; W rlopm; moved 0; ZS V=-65536 MV G; 0.05 s; W rlopm; moved 0; "
    f"ZS MP D=5 G; 0.05 s; W rlopm; moved 0; ZS MP D=-5 G; 0.05 s; W rlopm; moved 0; "
    "UCI ZS V=65536 MP D=5 G; 0.05 s; moved 5",
    '3.2: "Turn off servo amplifier", "Apply dynamic brake, MTB", "engage static brake"; then the shaft is at '
    "rest":
    [f"wired; A={UNIT} V={sign * UNIT} MV G; 0.01 s; brake is low; "
     f"A={UNIT} V={sign * UNIT} MV G; 0.01 s; {pin} released; 2 samples; mark; "
     f"W {BO + latched + now}; RMODE -> B; brake is high; 20 steps of 0; moved 0"
     for pin, (latched, now, sign, own, role) in PINS.items()],
    "Zl does not acknowledge the right limit (that of Zr); nor do Ze, Zh and Zs":
    [f"{into(pin)}; "
     + "; ".join(f"{wrong} MP D={-50 * sign} G; 0.05 s; moved 0"
                 for wrong in ("Zl" if pin == "C" else "Zr", "Ze", "Zh", "Zs", "Zw"))
     for pin, (latched, now, sign, own, role) in PINS.items()],
    "Axis option limits=(minus, plus): a switch opens beyond each end; moves to both ends and back work":
    f"bare limits=-100,100; A={UNIT} V={UNIT} MV G; 0.1 s; at > 100; at < 104; W rop; Zr V=-{UNIT} G; 0.2 s; "
    "at > -104; at < -100; W rlom; ZS MP P=0 G; 0.1 s; RP -> 0; ZS; W",
    "3.2 note 1 inhibits G, MT, MF1, MF4, MS, S and X in a fault; OFF and MTB are allowed":
    [f"wired; A={UNIT} V=-{UNIT} MV G; 0.01 s; C released; 2 samples; {stop}; 0.001 s; W rop; still"
     for stop in ("OFF", "MTB")],
    '3.1: "active high asserted … Loss of ground potential results in limit fault", also of a motor at rest':
    [f"wired; {pin} {level}; 2 samples; W {BO + latched + now}; {pin} 0.8 V; 2 samples; W {BO + latched}"
     for pin, (latched, now, *_) in PINS.items() for level in ("released", "high", "5.0 V", "2.0 V")],
    "RULINGS 15, while following: motion away is allowed; if the master reverses, a few counts are a new fault":
    [f"{into(pin)}; {own} MF4; master {-200 * sign} in 0.05 s; 0.1 s; moved {-200 * sign}; mark; "
     f"master {200 * sign} in 0.05 s; 0.1 s; W {BO + latched + now}; moved {sign}"
     for pin, (latched, now, sign, own, _) in PINS.items()],
    '3.2 item 4, RULINGS 8: at a limit, "Program execution continues to run"':
    f"wired; load WHILE 1 / a=a+1 / LOOP; RUN; 0.01 s; A={UNIT} V={UNIT} MV G; 0.01 s; C released; 2 samples; "
    "W rop; "
    "keep a; 300 samples; a grew by 100",
})  # fmt: skip
def test_limits(script):
    play(script)


@pytest.mark.parametrize("pin", "CD")
@pytest.mark.parametrize("move", ["MV V={v} G", "MP P=@P+{v} G", "MP D={v} G", "V=-1*{v} MV G", "T={s}*500 MT"])
def test_every_kind_of_move_is_judged_by_its_direction(bench, motor, pin, move):
    """After an acknowledgement, moves away from the switch are accepted, moves towards it are refused."""
    _, _, sign, own, _ = PINS[pin]
    away, stood = motor.axes["shaft"], run_into(bench, motor, pin)
    backwards = -sign if "-1*" in move else sign
    send(bench, motor, f"V={UNIT} {own} " + move.format(v=backwards * UNIT, s=sign), 0.05)
    assert away.position == stood
    send(bench, motor, "OFF V=65536")
    send(bench, motor, f"{own} " + move.format(v=-backwards * UNIT, s=-sign), 0.05)
    assert (stood - away.position) * sign > 10


@pytest.mark.parametrize("pin", "CD")
@pytest.mark.parametrize("limit", ["hard", "soft"])
def test_a_reversed_trajectory_stops_at_the_limit(bench, motor, pin, limit):
    """The motion reverses from 10 counts per sample; meanwhile the switch opens, or SLE enables an exceeded limit."""
    latched, now, sign, *_ = PINS[pin]
    shaft = motor.axes["shaft"]
    send(bench, motor, f"A=6553 V={-10 * sign * UNIT} MV G", 0.1)
    send(bench, motor, f"V={10 * sign * UNIT} G", 0.005)
    if limit == "hard":
        motor.pins[pin].release()
    else:
        send(bench, motor, f"O=0 SLP={-5000 * (pin == 'C') or 9000} SLN={5000 * (pin == 'D') or -9000} SLE")
    turned = shaft.position * sign
    for _ in range(500):
        advance(bench, 1)
        turned = min(turned, shaft.position * sign)
    assert status_word(bench, motor) == BO + latched + now
    assert shaft.position * sign - turned <= 3


@settings(deadline=None, max_examples=25)
@given(st.lists(st.sampled_from(ACTS), max_size=20), st.sampled_from([UNIT, 6553, 655]), st.sampled_from([0, 1]))
def test_after_any_commands_the_shaft_never_moves_into_an_open_switch(acts, rate, f):
    """Safety: V/A samples (the time of a stop with F=1) after any command, no motion goes towards an open switch."""
    bench = Bench()
    motor = wired(bench)
    send(bench, motor, f"A={rate} V={UNIT} F={f} MV")
    shaft, opened = motor.axes["shaft"], set()
    for act in acts:
        if act[0] in "+-":
            pin = motor.pins[act[1]]
            pin.release() if act[0] == "+" else pin.drive(0.0)
            (opened.add if act[0] == "+" else opened.discard)(act[1])
        else:
            motor.serial.write(act.encode() + b" ")
        advance(bench, 5)
        if act[0] == "+":
            advance(bench, 3 * UNIT // rate)
        furthest = shaft.position
        for _ in range(5):
            advance(bench, 3)
            assert not ("C" in opened and shaft.position > furthest + 3)
            assert not ("D" in opened and shaft.position < furthest - 3)
    motor.serial.write(b"END OFF ZS ")
    assert send(bench, motor, "a=3 Ra") == b"3\r"


@pytest.mark.parametrize("pin", "CD")
def test_an_acknowledged_move_that_returns_is_stopped_at_its_reversal(bench, motor, pin):
    """RULINGS 15: with a lower A the shaft overshoots its target; the return towards the open switch is stopped."""
    latched, now, sign, own, _ = PINS[pin]
    shaft = motor.axes["shaft"]
    motor.pins[pin].release()
    advance(bench, 2)
    send(bench, motor, f"{own} A=3000 V={10 * UNIT} P={-5000 * sign} MP G", 0.1)
    target = shaft.position * sign - 5
    send(bench, motor, f"P={target * sign} G", 0.0)
    lowest = target
    for _ in range(1000):
        advance(bench, 1)
        lowest = min(lowest, shaft.position * sign)
    assert lowest < target - 100 and shaft.position * sign - lowest <= 3
    assert status_word(bench, motor) == BO + latched + now
