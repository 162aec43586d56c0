"""Chapter 7: C1 and C2 at the same time, and the command that is in progress when they are called."""

import pytest

from axistwin import Bench
from axistwin.bench import Controller

from .scenarios import COUNTING, delays, trigger
from .scripts import play, scripts
from .talking import advance, ask, load, ready, run, values, wired

# Both at once


def moment_of_both(bench: Bench, motor: Controller, offset: int, **options) -> None:
    """Cause a fault and an edge at such times that, each alone, C1 would begin `offset` samples after C2."""
    to_c1, to_c2 = delays(**options)
    first, second, apart = ("G", "C", to_c2 - to_c1 + offset)
    if apart < 0:
        first, second, apart = "C", "G", -apart
    motor.pins[first].drive(first == "C")
    advance(bench, apart)
    motor.pins[second].drive(second == "C")


@pytest.mark.parametrize("debounce", [1, 2, 8])
def test_at_the_same_time_the_fault_takes_priority_and_c2_is_not_called(bench, debounce):
    """7.1, F=32, 1: "The fault takes priority and GOSUB2 will not be called", nor is it called after C1."""
    motor = wired(bench, debounce_samples=debounce)
    run(bench, motor, "F=96" + COUNTING)
    moment_of_both(bench, motor, 0, debounce_samples=debounce)
    advance(bench, 200)
    assert values(bench, motor, "ij") == [1, 0]
    motor.pins["G"].drive(True)
    advance(bench, 20)
    trigger(bench, motor)
    assert values(bench, motor, "ij") == [1, 1]


NESTED = """
UGI
WHILE 1
LOOP
END
C1
PRINT("<1")
WAIT=50
PRINT("1>")
RETURNF
C2
PRINT("<2")
n=0
WHILE n<20
n=n+1
LOOP
PRINT("2>")
RETURNI
"""


@pytest.mark.parametrize(("offset", "said"), [(5, b"<2<11>2>"), (-5, b"<1<22>1>")])
def test_each_may_interrupt_the_other(bench, offset, said):
    """7.1: a fault in C2 calls C1, which will "return to C2"; after an edge in C1 "a call to C2 will occur"."""
    motor = wired(bench)
    run(bench, motor, "F=96" + NESTED)
    moment_of_both(bench, motor, offset)
    advance(bench, 400)
    assert motor.serial.read() == said


def test_the_rest_of_c1_follows_when_pin_g_is_still_low(bench):
    """7.1, F=32, 3: after C2, "The Motor will enter back into C1 at the end of C2"."""
    motor = wired(bench)
    run(bench, motor, "F=96" + NESTED)
    motor.pins["C"].drive(True)
    advance(bench, 10)
    motor.pins["G"].drive(False)
    advance(bench, 500)
    assert motor.serial.read() == b"<1<22>1>"


GUARDED = """
UGI
WHILE 1
m=m+1
LOOP
END
C1
F=F&191
i=i+1
WAIT=100
i=i+1
F=96
RETURNF
C2
j=j+1
RETURNI
"""


@scripts({
    # Both at once
    '7.1, note: "F=F&191 (191+64=255)" as the first line of C1 inhibits C2; F=96 at the end of C1 allows C2 '
    "again":
    f"wired; run F=96{GUARDED}; C high; 20 samples; f=F Rf -> 32; trigger; i is 1; j is 0; 200 samples; i is 2; "
    "j is 0; trigger; i is 2; j is 1",
    # Commands in progress
    '4.1: "End program execution"; the statement after the WAIT is not executed':
    "run E=20 / A=65536 / V=65536 / MV / G / a=1 / WAIT=1000 / a=2 / END; jam; 50 samples; free; RBe -> 1; "
    "OFF ZS; 2000 samples; a is 1",
})  # fmt: skip
def test_interrupt_priority(script):
    play(script)


# Commands in progress


def test_wait_is_cut_short_by_c2(bench, motor):
    """7.1: G goes low less than 4000 samples after WAIT=8000 has begun: "the WAIT will be terminated"."""
    run(bench, motor, "F=64\nUGI\na=CLK\nWAIT=8000\nb=CLK\nEND\nC2\ng=CLK\nRETURNI\n")
    advance(bench, 3000)
    motor.pins["G"].drive(False)
    start = int(ask(bench, motor, "RCLK", 0))
    advance(bench, 50)
    _, to_c2 = delays()
    assert values(bench, motor, "g") == [start + to_c2]
    assert values(bench, motor, "b") == [start + to_c2 + 2]  # +2: g=CLK and RETURNI are executed before b=CLK
    advance(bench, 9000)
    assert values(bench, motor, "b") == [start + to_c2 + 2]


def test_twait_is_not_cut_short(bench, motor):
    """7.1: "All other valid commands will finish processing prior to the call": TWAIT waits for a 400 count move."""
    moving = "UGI\nA=65536\nV=65536\nP=400\nG\nTWAIT\nb=CLK\nEND\nC2\ng=CLK\nh=Bt\nRETURNI\n"
    run(bench, motor, "F=64\n" + moving)
    assert ask(bench, motor, "RBt", 0) == "1"
    motor.pins["G"].drive(False)
    advance(bench, 100)
    assert values(bench, motor, "g") == [0]
    advance(bench, 400)
    called, after, busy = values(bench, motor, "gbh")
    assert 0 < called < after and busy == 0


def test_a_long_print_is_completed_before_c2_is_called(tmp_path):
    """7.1: "Long PRINT commands will be completed prior to GOSUB2 call", also with edges during a PRINT at 9600 baud.

    The host receives whole lines only, and an answer for each of the 12 edges.
    """
    text = "The quick brown fox jumps over"
    program = f'UGI\nF=64\nWHILE 1\nPRINT("{text}",#13)\nLOOP\nEND\nC2\nPRINT("!",#13)\nRETURNI\n'
    first = Bench()
    load(first, ready(first, state=tmp_path), program)
    bench = Bench()
    motor = bench.add("smartmotor", state=tmp_path)
    bench.run(0.5)
    for _ in range(12):
        trigger(bench, motor, 300, 277)
    bench.run(0.1)
    lines = motor.serial.read().split(b"\r")
    assert set(lines[:-1]) == {text.encode(), b"!"} and lines.count(b"!") == 12
