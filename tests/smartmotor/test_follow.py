"""Base language 5: following an external encoder or a step source (MF, MS, MFR, MSR)."""

from fractions import Fraction
from math import floor

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench

from .scenarios import turn_to
from .scripts import play, scripts
from .talking import SAMPLE_NS, ready, send

QUADRATURE = ("A high; B low", "A high; B high", "A low; B high", "A low; B low")
TEN_STEPS = "; ".join(10 * ["A high; 1 sample; A low; 3 samples"])


@scripts({
    "5: MF1, MF2, MF4 count quadrature ×1, ×2, ×4, and MS counts steps; the shaft follows the counter 1:1":
    [f"{mode}; turn {100 * edges} 4000 0 -4000: 100 {4000 // edges} 0 {-4000 // edges}; "
     f"RCTR RBo RBs -> {-4000 // edges} 0 0"
     for mode, edges in (("MF1", 4), ("MF2", 2), ("MF4", 1), ("MS", 1))],
    "other commands leave the counter alone":
    [f"MF4; turn 1000; {mode}; 3 samples; CTR is 1000"
     for mode in ("MFR G", "MSR G", "MP", "MV", "MT", "O=5", "OFF")],
    "5: MF0 and MS0 set up pins A and B and zero the counter; the motion continues unchanged":
    [f"{mode}; turn 300: 0; RMODE RBo RCTR -> B 1 300; A=65536 V=65536 MV G; 3 samples; "
     f"{mode} RMODE RV -> V 65536"
     for mode in ("MF0", "MS0")],
    "MF4 after a move causes no jump and does not redefine the position":
    "A=65536*50 V=65536*50 P=500 G; 30 samples; MF4; 2 samples; at 500; turn -100: 400; RP -> 400",
    "S, OFF and MTB end following; CTR still counts":
    [f"MF4; turn 100; {word}; turn 500: 100; CTR is 500" for word in ("S", "OFF", "MTB")],
    # Ratios
    "16: MFMUL and MFDIV are 1":
    "MF4 MFR G; turn 77: 77",
    '5: "MFR must come after MFMUL and MFDIV"; the new ratio is in force after G':
    "MF4 MFMUL=2 MFR G; turn 100; MFMUL=5 G; turn 200: 400; MFR; turn 300: 600; G; turn 400: 1100",
    '5: "MFDIV=0 → error": following does not begin, and the motor executes further commands':
    "MFMUL=1 MFDIV=0 MFR G; turn 100: 0; RBs -> 1",
    # Pins A and B show the edges (base 12; 6.1, 6.2)
    "With an edge every 20 samples pin A changes every 40, and the program reads A at least every 5":
    "load WHILE CTR<400 IF UAI==b b=1-b a=a+1 ENDIF LOOP END; MF0 b=0 RUN; "
    f"master 400 in {400 * 20 * SAMPLE_NS / 1000000000.0} s; 3 s; Ra -> 200",
    '5: the command "zeroes CTR"':
    [f"turn 1000; CTR != 0; {mode}; CTR is 0; at 0" for mode in ("MF1", "MF2", "MF4", "MF0", "MS", "MS0")],
    # Ratios
    '5: "remainder carried, no drift": a thousand steps at ratio 2/7, forwards and backwards, lose nothing':
    "MFMUL=2 MFDIV=7 MFR G; "
    + "; ".join(f"turn {count} by 1" for count in range(1, 141))
    + "; at 40; "
    + "; ".join(f"turn {count} by 1" for count in range(139, -1, -1))
    + "; at 0",
    # Pins A and B show the edges (base 12; 6.1, 6.2)
    "without an encoder the pins are pulled up":
    "A is high; B is high; RU RUA RUB RUAA -> 127 1 1 1023",
    "A test lead or an output of the motor sets the level of the pin; the counter still counts edges (base "
    "12)":
    "master 2 in 0 s; A is low; B is low; A high; UB=1 UBO MF0; A is high; B is high; master 4 in 0 s; "
    "1 sample; RU RCTR -> 127 4; A released; UBI; A is low; B is low; RU -> 124",
    "of a step source b is the direction and a is low between steps":
    [f"MS0; master {steps} in 0.003 s; 0.01 s; A is low; B is {'high' if b else 'low'}; "
     f"RUA RUB RCTR -> 0 {int(b)} {steps}"
     for steps, b in ((3, True), (-3, False))],
    "the encoder turns while the motor has no power":
    "power off; master 1 in 0 s; A is low; B is high; power on; 0.001 s; RU RCTR -> 126 0",
    "5: MF4 during a move follows at once, without a ramp from the old velocity":
    "A=65536*5 V=65536*5 MV G; 10 samples; MF4 RMODE -> F; 1 sample; at 50; turn 7 by 1: 57",
    "MV and G change the velocity from that of the master (3 counts per sample) to 5, with A=1":
    "MF4 A=65536 V=5*65536; master 3000 in 1000 samples; 100 samples; mark; RV MV G RMODE -> 196608 V; "
    "onwards 4 9 14 19",
    "5: the shaft moves by counts times MFMUL/MFDIV; both are signed 16-bit numbers":
    [f"{mode} MFMUL={mul} MFDIV={div} {go} G; RMODE RBs -> X 0; turn {counts} by 500: {expected}; "
     f"CTR is {counts.split()[-1]}"
     for mode, go in (("MF4", "MFR"), ("MS0", "MSR"))
     for mul, div, counts, expected in (
         (3, 2, "2 100 1000 -2000", "3 150 1500 -3000"), (1, 3, "3 300 300000 0 -3", "1 100 100000 0 -1"),
         (-1, 1, "5 -5", "-5 5"), (1, -2, "100", "-50"), (-3, -4, "400", "300"), (0, 5, "1000", "0"),
         (32_767, 32_767, "1234", "1234"), (-32_768, 32_767, "32767", "-32768"),
     )],
    # Pins A and B
    "12: the encoder's signals are wired to A and B; here forwards means that A changes before B":
    "A low; B low; 2 samples; MF4; "
    + "; ".join(
        f"{QUADRATURE[(n - 1) % 4]}; 3 samples; CTR is {n}; at {n}" for n in (*range(1, 13), *range(11, -2, -1))
    ),
    "5, 12: MF1 counts every fourth edge, MF2 every second":
    [f"A low; B low; 2 samples; {mode}; "
     + "; ".join(f"{levels}; 1 sample" for levels in 5 * QUADRATURE)
     + f"; CTR is {counts}"
     for mode, counts in (("MF1", 5), ("MF2", 10))],
    "5: A is the step input, B the direction; only one of the two edges of A counts":
    f"A low; B low; 2 samples; MS; {TEN_STEPS}; CTR is -10; B high; {TEN_STEPS}; CTR is 0; at 0",
    "Between two samples the bench sees the present level":
    "master 4 in 0.4 s; 0.05 s; A is high; B is high; 0.1 s; A is low; B is high; 0.1 s; A is low; B is low; "
    "0.1 s; "
    "A is high; B is low",
})  # fmt: skip
def test_follow(script):
    play(script)


# Any ratio, any path


@settings(deadline=None, max_examples=15)
@given(
    mul=st.integers(-32_768, 32_767),
    div=st.integers(-32_768, 32_767).filter(bool),
    walk=st.lists(st.integers(-30_000, 30_000), min_size=1, max_size=6),
)
def test_any_ratio_never_drifts(mul, div, walk):
    """The shaft's position is the ratio times the master's, rounded down, after any path of the master."""
    bench = Bench()
    motor = ready(bench)
    send(bench, motor, f"E=32000 MF4 MFMUL={mul} MFDIV={div} MFR G", 0)
    for count in walk:
        position = turn_to(bench, motor, count, 1000)
        exact = Fraction(count * mul, div)
        assert position in (floor(exact), -floor(-exact))
    assert send(bench, motor, "RMODE RBs", 0) == b"X\r0\r"


# Pins A and B show the edges (base 12; 6.1, 6.2)


def levels(motor):
    return motor.pins["A"].level, motor.pins["B"].level


@pytest.mark.parametrize("sign", [1, -1])
def test_pins_a_and_b_show_the_quadrature_of_the_external_encoder(bench, motor, sign):
    """Forwards AB is 11, 01, 00, 10, backwards the reverse order; host, bench and voltage agree."""
    forwards = [(True, True), (False, True), (False, False), (True, False)]
    for count in range(9):
        a, b = forwards[sign * count % 4]
        motor.master.move(0 if count == 0 else sign, 0)
        assert levels(motor) == (a, b) and (motor.pins["A"].volts, motor.pins["B"].analog) == (5.0 * a, 1023 * b)
        report = send(bench, motor, "RUA RUB RUAA RUBA RU")
        assert report == f"{a:d}\r{b:d}\r{1023 * a}\r{1023 * b}\r{124 + a + 2 * b}\r".encode()
    assert send(bench, motor, "RCTR") == b"%d\r" % (8 * sign)
