"""Chapter 7: which roles of pin G call C2, and interrupts in any order."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench

from .scenarios import main_with
from .scripts import play, scripts
from .talking import SAMPLE_NS, advance, ready, run, send, value


@scripts({
    # UG, UGI, UGO, BRKG
    '7.1, F=64 1: "GOSUB2 triggered with concurrent "Go" on input pin G high to low edge transition"':
    f"run {main_with('RETURNI').replace('UGI', 'UG / A=65536 / V=65536 / P=100')}; G low; 300 samples; G high; "
    "20 samples; j is 1; at 100",
    '4.1, note: "G-synchronization function on I/O pin G is inhibited"; but F=64 "operates independently" of '
    "it":
    f"C low; UCP ZS; 0.01 s; run {main_with('RETURNI').replace('UGI', 'UG / A=65536 / V=65536 / P=100')}; "
    "C high; 20 samples; G low; 300 samples; G high; 20 samples; j is 1; at 0; RBo -> 1",
    "7.1, F=64 2: after UGI, an edge on pin G calls C2 and starts no move":
    f"run {main_with('RETURNI').replace('UGI', 'UGI / A=65536 / V=65536 / P=100')}; G low; 300 samples; G high; "
    "20 samples; j is 1; at 0",
    '7.1, F=64 3: "GOSUB2 triggered on UG=0 (when Port G goes from High to Low)"':
    f"run {main_with('RETURNI').replace('UGI', 'UG=1 / UGO')}; j is 0; UG=0; 20 samples; j is 1; UG=1; "
    "20 samples; j is 1; UG=0; 20 samples; j is 2; UG=1; 20 samples; j is 2; UG=0; 20 samples; j is 3; UG=1; "
    "20 samples; j is 3",
    '5.1 note 3: with BRKG and BRKSRV, pin G rises at a fault; "If F=32 is issued, C1 will also be called"':
    "run F=32 / UGO / BRKG / E=50 / MV / A=65536 / V=65536 / G / WHILE 1 / LOOP / END / C1 / i=i+1 / RETURNF; "
    "G is low; jam; 200 samples; i is 1; G is high",
})  # fmt: skip
def test_interrupt_roles(script):
    play(script)


# UG, UGI, UGO, BRKG


def test_a_program_triggers_itself(bench, motor):
    """7.1, F=64 3: UG=0 in the program calls C2 during the next WAIT, and so ends the WAIT early."""
    run(bench, motor, "UG=1\nUGO\nF=64\nWAIT=20\nUG=0\nWAIT=9000\nb=CLK\nEND\nC2\ng=CLK\nRETURNI\n")
    assert 0 < value(bench, motor, "g") < value(bench, motor, "b")


@pytest.mark.parametrize("mode", ["BRKSRV", "BRKTRJ"])
def test_brkg_calls_c2_when_the_brake_is_released(bench, motor, mode):
    """7.1, F=64 3a: "C2 will be called anytime port G goes low due to brake control"; 5.1 note 4."""
    run(bench, motor, main_with("RETURNI").replace("UGI", f"UGO\nBRKG\n{mode}\nA=65536\nV=65536\nD=50"))
    assert value(bench, motor, "j") == 0
    for count in (1, 2, 3):
        send(bench, motor, "G", 0)
        advance(bench, 100)
        assert value(bench, motor, "j") == count
        send(bench, motor, "OFF", 0)
        advance(bench, 50)
        assert value(bench, motor, "j") == count


# Any order of events


ACTS = """
G0 G1 C0 C1 D0 D1 ZS F=96 F=0 F=64 F=32 F=F&191 RUN END STACK RETURNI RETURNF RETURN GOSUB1 GOSUB2 GOTO2 UG UGI UGO
UG=0 UG=1 BRKG BRKI BRKTRJ G OFF UCI UCP Z WAIT=9 F=-1 F=255 F=256 F=2147483647
"""
PROGRAM = """
UGI
F=96
A=65536
V=65536
D=30
WHILE 1
G
WAIT=10
GOSUB5
LOOP
END
C5
m=m+1
RETURN
C1
F=F&191
i=i+1
WAIT=5
ZS
F=96
RETURNF
C2
j=j+1
GOSUB5
RETURNI
"""


def played(acts: list[tuple[str, int]], pieces: int) -> tuple[bytes, int, int]:
    """Execute actions, each followed by a number of nanoseconds, in one or more pieces; return the result."""
    bench = Bench()
    motor = ready(bench)
    motor.pins["C"].drive(False)
    motor.pins["D"].drive(False)
    run(bench, motor, PROGRAM)
    heard = b""
    for act, ns in acts:
        if act[1:] in {"0", "1"}:
            motor.pins[act[0]].drive(act[1] == "1")
        else:
            motor.serial.write(act.encode() + b" ")
        start = bench.now
        for piece in range(1, pieces + 1):
            bench.clock.run_to(start + ns * piece // pieces)
        heard += motor.serial.read()
    motor.serial.write(b"END RW Ri Rj Rm RP RCLK ")
    bench.run(0.01)
    return heard + motor.serial.read(), motor.axes["shaft"].position, bench.now


GAPS = st.sampled_from([0, 1, SAMPLE_NS - 1, SAMPLE_NS, SAMPLE_NS + 1, 2 * SAMPLE_NS]) | st.integers(0, 12_000_000)


@settings(deadline=None, max_examples=25)
@given(acts=st.lists(st.tuples(st.sampled_from(ACTS.split()), GAPS), max_size=30))
def test_any_order_of_edges_faults_and_commands_is_repeatable(acts):
    """The same actions, repeated and in pieces, give the same bytes and counts at the same times."""
    first = played(acts, 1)
    assert first[0].count(b"\r") == 6 and played(acts, 1) == first
    assert played(acts, 7) == first
