"""Fault handling: section 4, its tables, sequences and sample program."""

from functools import partial
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench

from . import talking
from .bits import BA, BE, BI, BO, BP, BR, BT
from .scenarios import open_limit
from .scripts import play, scripts
from .talking import SAMPLE_NS, UNIT, ask, load, ready, send, steps, wired

status_word = partial(talking.status_word, ignored=BI | BA)
COUNTING = "WHILE 1\na=a+1\nLOOP\n"
WITH_C1 = "F={f}\n" + COUNTING + "C1\nc=c+1\nRETURNF\n"
MOVE = f"A={UNIT} V={10 * UNIT} MV G"


LIMIT = "C released; 3 samples", BR + BP, BR, "Zr"
ERROR = "jam; 110 samples; free", BE, BE, "Ze"
"""What causes a fault, its flags, those that are latched, and the command that clears them."""


@scripts({
    "Reference 13: a fault needs |e| > E; E is 1000 at power-up":
    [f"jam; A={UNIT} V={UNIT} P={target} G; 0.5 s; W {BO + BE if trips else 0}; "
     f"RPE -> {0 if trips else target}"
     for target, trips in ((1000, False), (1001, True), (-1000, False), (-1001, True))],
    "E= takes effect at once: an error of E counts is allowed, one more is a fault":
    [f"E={error}; jam; A={UNIT} V={100 * UNIT} P={error} G; 0.5 s; W; P={error + 1} G; 0.1 s; W eo"
     for error in (0, 1, 10, 32000)],
    "With the servo off the motor counts the shaft's position; there is no commanded position, so no error "
    "results":
    "push 50000; 3 samples; RP RPE -> 50000 0; W o; G; W t",
    'Table 4.2, F=0: "the motor turns off servo amplifier"':
    f"wired; F=1 F=0 {MOVE}; 0.1 s; C released; 3 samples; 5 steps of 0; W rop",
    "Up to E=1000 counts the servo returns the shaft; beyond E the shaft stays there with a position error":
    [f"with frame23; G; 0.1 s; push {by}; 1.0 s; RP -> {by if trips else 0}; RBe -> {int(trips)}"
     for by, trips in ((1000, False), (1001, True), (-1000, False), (-1001, True), (5000, True))],
    '4.1 item 3: the brake signal is "external and/or internal"; 5.1: 5 V means engaged, 0 V released':
    [f"wired; {setup} {MOVE}; {signal} is low; C released; 3 samples; {signal} is high; Zr V=-{UNIT} G; "
     f"{signal} is low"
     for signal, setup in (("G", "UGO BRKG"), ("brake", "BRKI"), ("brake", "UGO BRKG"))],
    "4.1 items 1 to 3: the servo amplifier goes off, both brakes act, and table 4.1's bit is set and latched":
    [f"wired; {MOVE}; 0.1 s; {cause}; W {BO + bits}; RMODE -> B; brake is high; 10 steps of 0; C low; 3 samples; "
     f"W {BO + latched}; {clear}; W o"
     for cause, bits, latched, clear in (LIMIT, ERROR)],
    '4.1 note: "no action occurs when these commands are received. The fault has to be cleared before"':
    [f"wired; {MOVE}; 0.1 s; {cause}; C low; 3 samples; mark; master 3000 in 0.01 s; G high; {command}; 0.1 s; "
     f"moved 0; W {BO + latched}; RMODE -> B; {clear} MV G; 0.1 s; W t; 10 steps of 10"
     for cause, _, latched, clear in (LIMIT, ERROR)
     for command in (
         "G", "MT", "MF1", "MF2", "MF4", "MS", "S", "X", "MP P=0 G", "G low", "T=900", "MV MP MV G",
     )],
    '4.2: "reset by ZS or clear the fault bits individually by Zr, Zl, Ze, and Zh"':
    [f"wired; {MOVE}; 0.1 s; {fault[0]}; C low; 3 samples; {clear}; W {BO + left}"
     for fault, clear, left in (
         (LIMIT, "ZS", 0), (LIMIT, "Zr", 0), (LIMIT, "Zl", BR), (LIMIT, "Ze Zh Zs", BR), (ERROR, "ZS", 0),
         (ERROR, "Ze", 0), (ERROR, "Zr Zl Zh", BE), (ERROR, "G", BE),
     )],
    'Table 4.2: the motor stops at "A" in 9+8+…+1 = 45 counts, then MTB; with MTB disabled (BRKRLS, OFF) it holds':
    [f"wired; {disable}F={f} {MOVE}; 0.1 s; C released; steps 10 9 8 7 6 5 4 3 2 1 0; 20 steps of 0; "
     f"W {flags}; brake is {brake}; RMODE -> {letter}"
     for f in (1, 33)
     for disable, flags, brake, letter in (("", "rop", "high", "B"), ("BRKRLS OFF ", "rp", "low", "V"))],
    "Without power the load turns the shaft; at power-up the counts begin at 0":
    "with frame23; power off; torque 0.1; 0.2 s; at > 10; torque 0; 1 s; power on; 0.5 s; RP -> 0",
})  # fmt: skip
def test_fault_handling(script):
    play(script)


def test_while_decelerating_the_servo_is_on_and_nothing_else_is_obeyed(bench):
    """Table 7.1: while decelerating "Bo will equal 0"; G, S and X are inhibited, and a new A has no effect."""
    motor = wired(bench)
    send(bench, motor, f"F=1 {MOVE}", 0.1)
    send(bench, motor, "A=6553", 0)
    open_limit(bench, motor)
    assert status_word(bench, motor) == BT + BR + BP and not motor.pins["brake"].level
    send(bench, motor, "V=65536*50 G S X MT T=1000 MV G", 0.001)
    path = steps(bench, motor, 120)
    assert 80 < sum(step > 0 for step in path) < 95
    assert all(later - earlier in (-1, 0, 1) for earlier, later in pairwise(path))
    assert status_word(bench, motor) == BO + BR + BP


@pytest.mark.parametrize("what", ["jam", "load"])
@pytest.mark.parametrize("error", [100, 1000, 3000])
def test_a_motor_that_cannot_follow_trips_at_e(bench, what, error):
    """Table 4.1: "Position error exceeded error limit" ends the program and stops the motor; Ze and G move it."""
    motor = ready(bench, shaft={"motor": "frame23"})
    shaft = motor.axes["shaft"]
    load(bench, motor, "C10\nb=@PE\nGOTO10\n")
    send(bench, motor, f"E={error} A=50 V={2 * UNIT} MV G RUN", 1.0)
    assert status_word(bench, motor) == BT
    shaft.jam(True) if what == "jam" else shaft.load(-2.0)
    assert bench.run_until(lambda: motor.pins["brake"].level, 2.0)
    shaft.jam(True)
    assert status_word(bench, motor) == BO + BE
    assert error - 100 <= abs(int(ask(bench, motor, "Rb"))) <= error + 400 and ask(bench, motor, "RPE") == "0"
    shaft.jam(False)
    shaft.load(0.0)
    send(bench, motor, "Ze G", 1.0)
    assert status_word(bench, motor) == BT


@settings(deadline=None, max_examples=20)
@given(
    st.lists(
        st.one_of(
            st.sampled_from(
                ["C+", "C-", "D+", "D-", "jam", "G+", "G-", "cut", "ZS", "Ze", "G", "RUN", "END", "F=97", "F=0", "X"]
            ),
            st.sampled_from(
                ["BRKRLS", "OFF", "MTB", "MV", "MT", "T=500", "GOSUB1", "GOSUB2", "STACK", "RETURNF", "RETURNI", "Z"]
            ),
            st.binary(max_size=6)
            .map(lambda data: bytes(b & 0x7F for b in data).decode("ascii"))
            .filter(lambda text: "LOAD" not in text),  # LOAD stores all later characters as a program
        ),
        max_size=25,
    )
)
def test_any_order_of_faults_and_commands_is_handled(acts):
    """Any order causes no exception, endless loop or lost byte; the same run in one piece gives the same result."""
    ends = []
    for pieces in (1, 7):
        bench, jammed = Bench(), False
        motor = wired(bench)
        load(bench, motor, WITH_C1.format(f=97) + "C2\nb=b+1\nRETURNI\n")
        for act in acts:
            if act == "cut":
                motor.power_cycle()
            elif act == "jam":
                motor.axes["shaft"].jam(not jammed)
                jammed = not jammed
            elif act[:1] in ("C", "D", "G") and act[1:] in ("+", "-"):
                motor.pins[act[0]].release() if act[1] == "+" else motor.pins[act[0]].drive(0.0)
            else:
                motor.serial.write(act.encode() + b" ")
            for _ in range(pieces):
                bench.clock.run_to(bench.now + 7 * SAMPLE_NS // pieces)
        motor.serial.read()
        motor.serial.write(b"\r\r OFF END TALK WAKE ECHO_OFF ")
        bench.run(0.3)
        ends.append(send(bench, motor, "RW RP RMODE Ra Rb Rc"))
        assert send(bench, motor, "z=41 z=z+1 Rz").endswith(b"42\r")
    assert ends[0] == ends[1]


@pytest.mark.parametrize("cut", ["power off", "Z"])
def test_a_power_cut_leaves_the_shaft_turning_where_it_is(bench, cut):
    """The shaft turns 6 counts per sample, and a millisecond has 4 or 5 samples: at most 30 counts."""
    motor = ready(bench, shaft={"motor": "frame23"})
    shaft = motor.axes["shaft"]
    send(bench, motor, f"A=200 V={6 * UNIT} MV G", 1.0)
    path = [shaft.position]
    if cut == "Z":
        motor.serial.write(b"Z ")
    else:
        motor.power(False)
    for _ in range(100):
        bench.run(0.001)
        path.append(shaft.position)
    assert all(0 <= later - earlier <= 30 for earlier, later in pairwise(path))
    bench.run(2.0)
    stood = shaft.position
    motor.power(True)
    bench.run(1.0)
    assert shaft.position == stood
