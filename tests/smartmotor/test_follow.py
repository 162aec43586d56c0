"""Base language 5: following an external encoder or a step source (MF, MS, MFR, MSR)."""

from fractions import Fraction
from math import floor

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench

from .playing import play, scripts
from .scenarios import turn_through, turn_to
from .talking import SAMPLE_NS, advance, ready, send, value


@scripts(
    {
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
    }
)  # fmt: skip
def test_follow(script):
    play(script)


def test_mf4_in_a_move_takes_over_at_once(bench, motor):
    """5: MF4 during a move follows at once, without a ramp from the old velocity."""
    send(bench, motor, "A=65536*5 V=65536*5 MV G", 0)
    advance(bench, 10)
    assert send(bench, motor, "MF4 RMODE", 0) == b"F\r"
    advance(bench, 1)
    here = motor.axes["shaft"].position
    assert here == 50
    assert turn_to(bench, motor, 7, 1) == 57


def test_leaving_follow_mode_for_a_velocity(bench, motor):
    """MV and G change the velocity from that of the master (3 counts per sample) to 5, with A=1."""
    send(bench, motor, "MF4 A=65536 V=5*65536", 0)
    motor.master.move(3000, 1000 * 245_760 / 1e9)
    advance(bench, 100)
    assert send(bench, motor, "RV MV G RMODE", 0) == b"196608\rV\r"
    at = motor.axes["shaft"].position
    found = []
    for _ in range(4):
        advance(bench)
        found.append(motor.axes["shaft"].position - at)
    assert found == [4, 9, 14, 19]


# Ratios


@pytest.mark.parametrize(
    ("mul", "div", "counts", "expected"),
    [
        (3, 2, [2, 100, 1000, -2000], [3, 150, 1500, -3000]),
        (1, 3, [3, 300, 300_000, 0, -3], [1, 100, 100_000, 0, -1]),
        (-1, 1, [5, -5], [-5, 5]),
        (1, -2, [100], [-50]),
        (-3, -4, [400], [300]),
        (0, 5, [1000], [0]),
        (32_767, 32_767, [1234], [1234]),
        (-32_768, 32_767, [32_767], [-32_768]),
    ],
)
@pytest.mark.parametrize("mode", ["MF4 {} MFR G", "MS0 {} MSR G"])
def test_the_ratio_is_mfmul_by_mfdiv(bench, motor, mul, div, counts, expected, mode):
    """5: the shaft moves by counts times MFMUL/MFDIV; both are signed 16-bit numbers."""
    send(bench, motor, mode.format(f"MFMUL={mul} MFDIV={div}") + "", 0)
    assert send(bench, motor, "RMODE RBs", 0) == b"X\r0\r"
    assert turn_through(bench, motor, counts, 500) == expected
    assert value(bench, motor, "CTR") == counts[-1]


# Pins A and B


def test_quadrature_on_the_pins_themselves(bench, motor):
    """12: the encoder's signals are wired to A and B; here forwards means that A changes before B."""
    quadrature(
        bench,
        motor,
        [(1, 0), (1, 1), (0, 1), (0, 0)] * 3 + [(0, 1), (1, 1), (1, 0), (0, 0)] * 3 + [(0, 1)],
        "MF4",
        [1] * 12 + [-1] * 13,
    )


@pytest.mark.parametrize(("mode", "edges"), [("MF1", 4), ("MF2", 2)])
def test_quadrature_counted_in_halves_and_quarters(bench, motor, mode, edges):
    for pin in "AB":
        motor.pins[pin].drive(False)
    advance(bench, 2)
    send(bench, motor, mode + "", 0)
    for a, b in [(1, 0), (1, 1), (0, 1), (0, 0)] * 5:
        motor.pins["A"].drive(bool(a))
        motor.pins["B"].drive(bool(b))
        advance(bench)
    assert abs(value(bench, motor, "CTR")) == 20 // edges


def quadrature(bench, motor, levels, mode, steps):
    for pin in "AB":
        motor.pins[pin].drive(False)
    advance(bench, 2)
    send(bench, motor, mode + "", 0)
    count = 0
    for (a, b), step in zip(levels, steps, strict=True):
        motor.pins["A"].drive(bool(a))
        motor.pins["B"].drive(bool(b))
        advance(bench, 3)
        count += step
        assert value(bench, motor, "CTR") == motor.axes["shaft"].position == count


def test_steps_and_direction_on_the_pins_themselves(bench, motor):
    """5: A is the step input, B the direction; only one of the two edges of A counts."""
    motor.pins["A"].drive(False)
    motor.pins["B"].drive(False)
    advance(bench, 2)
    send(bench, motor, "MS", 0)
    found = []
    for direction in (False, True):
        motor.pins["B"].drive(direction)
        for _ in range(10):
            motor.pins["A"].drive(True)
            advance(bench)
            motor.pins["A"].drive(False)
            advance(bench, 3)
        found.append(value(bench, motor, "CTR"))
    assert abs(found[0]) == 10
    assert found[1] == motor.axes["shaft"].position == 0


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
        assert levels(motor) == (a, b)
        assert (motor.pins["A"].volts, motor.pins["B"].analog) == (5.0 * a, 1023 * b)
        report = send(bench, motor, "RUA RUB RUAA RUBA RU")
        assert report == f"{a:d}\r{b:d}\r{1023 * a}\r{1023 * b}\r{124 + a + 2 * b}\r".encode()
    assert send(bench, motor, "RCTR") == b"%d\r" % (8 * sign)


def test_between_samples_the_bench_sees_the_level_of_now(bench, motor):
    motor.master.move(4, 0.4)
    seen = []
    for _ in range(4):
        bench.run(0.05)
        seen.append(levels(motor))
        bench.run(0.05)
    assert seen == [(True, True), (False, True), (False, False), (True, False)]
