"""Chapter 6, and 12 of the base language: the seven user pins as a host and a program read and set them."""

from itertools import product

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from axistwin import AxistwinError, Bench

from .scripts import play, scripts
from .talking import ask, ready, send

PINS = "ABCDEFG"
OPEN = "OCHN(RS4,1,N,9600,1,8,C)"


@scripts({
    # U
    '6.1: "state of all 7 I/O pins", also of limit inputs and the go input':
    f"bare; C low; G low; RU RUC RUD RUG -> {127 - 4 - 64} 0 1 0",
    '1.2, RU{pin}: "input or output"':
    f"{' '.join((f'U{name}={0 >> bit & 1} U{name}O' for bit, name in enumerate(PINS)))}; RU -> 0; "
    f"{' '.join((f'U{name}={127 >> bit & 1} U{name}O' for bit, name in enumerate(PINS)))}; RU -> 127; "
    f"{' '.join((f'U{name}={76 >> bit & 1} U{name}O' for bit, name in enumerate(PINS)))}; RU -> 76",
    "6.1, PRINT1(U): prints to the RS485 channel, for which pins E and F are used":
    f"{OPEN}; D low; PRINT1(U&15,#13); 0.1 s; 485 receives 7<CR>",
    "`read()` gives everything the host has received":
    f'{OPEN}; PRINT1("abc"); 0.1 s; 485 receives abc',
    "6.1: with IF and WHILE a program counts the samples during which a button is pressed":
    "load WHILE U&1 / LOOP / IF U&2 / PRINT(U&3,#13) / ELSE / RUB / ENDIF / END; RUN; 0.1 s; receives nothing; "
    "A low; 0.1 s; receives 2<CR>",
    # Analog values
    "6.3: 1 V, 2 V and 4 V read as 1023 × 1/5, 2/5 and 4/5, to the nearest whole number":
    "load a=UAA+0 / b=UBA*2 / c=UEA/2 / PRINT(a,#32,b,#32,c,#13) / END; A 1.0 V; B 2.0 V; E 4.0 V; "
    "RUN => 205 818 409<CR> in 0.1 s",
    # Directions, latches, roles
    "12: UxO and UxI set the direction, Ux= the latch; the latch is kept while the pin is an input":
    [f"U{name}=1 U{name}O; {name} is 5.0 V; U{name}=0; {name} is 0.0 V; U{name}I; {name} is 5.0 V; "
     f"U{name}O; {name} is 0.0 V; U{name}=-4 U{name}I; {name} is high; {name} low; RU{name} RBs -> 0 0"
     for name in PINS],
    "3.1: limits are active high; ordinary inputs have no effect on motion":
    [f"{name} low; {role}; 0.01 s; {flags} -> 0 0; {name} high; 0.01 s; {flags} -> 1 1; U{name}I ZS; "
     f"0.01 s; {flags} -> 0 0"
     for name, role, flags in (("C", "UCP", "RBp RBr"), ("D", "UDM", "RBm RBl"))],
    "12: after reading pin G by RUG, U or UG, it is still the go input":
    "A=65536 V=65536 P=50 RUG a=U a=UG a=UGI RUGA -> *; G low; 0.1 s; at 50",
    "10 of the base language: Bx is the real-time level of the index input, which is not part of U":
    [f"index {'high' if level else 'low'}; 0.001 s; RBx RU -> {int(level)} 127" for level in (True, False)],
    '5 of the base language: "UAI/UAO/UBI/UBO do not stop the counter from counting"':
    "MF0; master 100 in 0.05 s; UAI UBI; 0.1 s; RCTR -> 100",
    # U
    "6.1: U is right for all 128 combinations of the pins":
    "; ".join(f"pins {word}; RU -> {word}" for word in range(128)),
    '6.1: "U can be operated by logical and mathematical operations"; the pins are set to 90 = 64+16+8+2':
    [f"pins 90; a={expression} Ra -> {value}"
     for expression, value in (
         ("U", 90), ("U&64", 64), ("U&1", 0), ("U|1", 91), ("U*2+1", 181), ("U!|127", 37), ("127-U", 37),
         ("U==90", 1),
     )],
    "6.1: <variable>=U; a later change of a pin does not change the variable":
    "pins 90; a=U zz=U ab[3]=U aw[5]=U al[9]=U; pins 0; Ra Rzz Rab[3] Raw[5] Ral[9] RU -> 90 90 90 90 90 0",
    "6.1, PRINT(U): prints the value of U without a CR":
    'pins 90; PRINT(U) => 90; PRINT(U,#13) -> 90; PRINT("U=",U," ",U&8,#13) => U=90 8<CR>',
    # Digital levels
    '6.2: "1 is 2.0 volts or higher and 0 is 0.8 volts or lower", in each report and expression':
    [f"{name} {volts} V; RU{name} a=U{name}I Ra b=U{name} Rb c=U>>0 -> {level} {level} {level}"
     for name in PINS for volts, level in ((0.0, 0), (0.5, 0), (0.8, 0), (2.0, 1), (2.4, 1), (5.0, 1))],
    "12 of the base language: 5 kΩ pull a released pin up to +5 V":
    "; ".join(f"{name} low; {name} released; {name} is high; {name} is 5.0 V" for name in PINS)
    + "; RU -> 127",
    # Analog values
    "6.3: an output reads its own 0 or 5 V":
    "; ".join(f"U{name}=0 U{name}O RU{name}A U{name}=1 RU{name}A -> 0 1023" for name in PINS),
    # Directions, latches, roles
    "12: after a power cut pins are inputs with latches 0, pins C and D are limits, and G is the go input":
    "UCO UC=1 UGO UG=1 UAO UA=1; power off; 0.01 s; power on; 0.3 s; RU RBr RBl -> 127 1 1; clear; "
    "UAO UCO UGO; A is low; C is low; G is low",
    "6.1, 6.2: reports of single pins agree with U, in words where each bit is once high and once low":
    [f"pins {word}; RUA RUB RUC RUD RUE RUF RUG -> {answers}"
     for word, answers in (
         (0b1010101, "1 0 1 0 1 0 1"), (0b0101010, "0 1 0 1 0 1 0"), (0b1110000, "0 0 0 0 1 1 1"),
         (0b0001111, "1 1 1 1 0 0 0"),
     )],
    '6.1: "To current communication channel"; 6.2: "the active RS232 or RS485 channel"':
    [f"{OPEN}; {said}{word} => *<CR>; {other}receives nothing"
     for said, other in (("", "485 "), ("485: ", "")) for word in ("RU", "RUA", "RUAA", "RUD")],
    "Assigning U or an analog value, or naming an eighth pin, is a syntax error":
    [f"{text}; RBs -> 1"
     for text in ("U=5", "RUH", "RUU", "RUAB", "RU1", "UHI", "UAX", "UAA=5", "UAI=1", "Rua", "U")],
    "Host commands are executed on arrival (ruling 14)":
    "UBO; watch B; UB=1; 1 sample; UB=0; B went high @0 low @1",
    "Ruling 14, one statement per sample: after UA=1 pin A is high for one sample; after UA=0, low for three":
    "load UAO / WHILE 1 / UA=1 / UA=0 / LOOP / END; 1 sample; watch A; RUN; 12 samples; "
    "A went low @1 high @3 low @4 high @7 low @8 high @11 low @12",
})  # fmt: skip
def test_inputs_outputs(script):
    play(script)


# Digital levels


def test_between_the_thresholds_it_is_one_or_the_other_and_all_agree(bench, motor):
    """6.2 does not define the level between 0.8 V and 2.0 V; all reports agree on 0 or 1."""
    for tenths in range(9, 20):
        motor.pins["A"].drive(tenths / 10)
        first, second, word = send(bench, motor, "RUA a=UAI Ra a=U&1 Ra").split()
        assert first == second == word and first in {b"0", b"1"}


# Analog values


@given(millivolts=st.integers(0, 5000), name=st.sampled_from(PINS))
@settings(deadline=None, max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_analog_values_are_proportional(bench, motor, millivolts, name):
    """6.3: ten bits; the value is within one step of 1023 × volts / 5."""
    motor.pins[name].drive(millivolts / 1000)
    assert abs(int(ask(bench, motor, f"RU{name}A", 0)) - 1023 * millivolts / 5000) <= 1


@pytest.mark.parametrize("volts", [-3.0, 12.0, float("nan"), float("inf")])
def test_a_voltage_beyond_the_range_is_refused(bench, motor, volts):
    """6.3: the range is 0 to 5 V; another voltage is an error of the user, and the pin does not change."""
    motor.pins["B"].drive(2.5)
    with pytest.raises(AxistwinError):
        motor.pins["B"].drive(volts)
    assert ask(bench, motor, "RUBA") in {"511", "512"}


# Directions, latches, roles


def test_outputs_are_independent(bench, motor):
    """Each of the 128 combinations of the seven outputs is right on every pin."""
    send(bench, motor, " ".join(f"U{name}O" for name in PINS))
    for levels in list(product([0, 1], repeat=7))[::5]:
        send(bench, motor, " ".join(f"U{name}={level}" for name, level in zip(PINS, levels, strict=True)), 0)
        assert [motor.pins[name].level for name in PINS] == [bool(level) for level in levels]


WORDS = [f"U{pin}{rest}" for pin in "ABCDEFGH" for rest in ("I", "O", "=0", "=1", "=-1", "=U", "A", "P", "M", "")]
WORDS += [f"RU{pin}{rest}" for pin in ["", *PINS] for rest in ("", "A", "I")] + ["BRKC", "BRKG", "BRKI", "RS4", OPEN]


@settings(deadline=None, max_examples=30)
@given(words=st.lists(st.sampled_from(WORDS) | st.text("UABCGIO=R01()\x00\x7f ", max_size=8), max_size=25))
def test_any_pin_commands_leave_the_motor_operable(words):
    """After any commands the motor executes the next one, and a repeated run gives the same answers."""

    def answer() -> bytes:
        bench = Bench()
        motor = ready(bench)
        return send(bench, motor, " ".join(words), 0.05) + b"|" + send(bench, motor, "RU RCLK")

    first = answer()
    assert first.split(b"|")[-1].count(b"\r") == 2 and answer() == first
