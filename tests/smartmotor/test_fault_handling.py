"""Fault handling: section 4, its tables, sequences and sample program."""

from functools import partial
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench

from . import talking
from .bits import BA, BE, BI, BO, BP, BR, BT
from .playing import play, scripts
from .scenarios import jam, open_limit
from .talking import SAMPLE_NS, UNIT, advance, ask, load, ready, send, steps, wired

status_word = partial(talking.status_word, ignored=BI | BA)
COUNTING = "WHILE 1\na=a+1\nLOOP\n"
WITH_C1 = "F={f}\n" + COUNTING + "C1\nc=c+1\nRETURNF\n"
MOVE = f"A={UNIT} V={10 * UNIT} MV G"


FAULTS = {"limit": (open_limit, BR + BP, "Zr"), "position error": (jam, BE, "Ze")}


@scripts(
    {
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
    }
)  # fmt: skip
def test_fault_handling(script):
    play(script)


@pytest.mark.parametrize("fault", FAULTS)
def test_the_sequence_of_a_fault(bench, fault):
    """4.1 items 1 to 3: the servo amplifier goes off, both brakes act, and table 4.1's bit is set and latched."""
    motor = wired(bench)
    cause, bits, clear = FAULTS[fault]
    send(bench, motor, MOVE, 0.1)
    cause(bench, motor)
    assert status_word(bench, motor) == BO + bits
    assert ask(bench, motor, "RMODE") == "B"
    assert motor.pins["brake"].level
    assert steps(bench, motor, 10) == [0] * 10
    motor.pins["C"].drive(0.0)
    advance(bench, 3)
    assert status_word(bench, motor) == BO + bits & ~BP
    send(bench, motor, clear)
    assert status_word(bench, motor) == BO


@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize(
    "command", ["G", "MT", "MF1", "MF2", "MF4", "MS", "S", "X", "MP P=0 G", "pin G", "T=900", "MV MP MV G"]
)
def test_what_is_inhibited_by_a_fault(bench, fault, command):
    """4.1 note: "no action occurs when these commands are received. The fault has to be cleared before"."""
    motor = wired(bench)
    cause, bits, clear = FAULTS[fault]
    send(bench, motor, MOVE, 0.1)
    cause(bench, motor)
    motor.pins["C"].drive(0.0)
    advance(bench, 3)
    stood = motor.axes["shaft"].position
    motor.master.move(3000, 0.01)
    motor.pins["G"].drive(command != "pin G")
    send(bench, motor, "" if command == "pin G" else command, 0.1)
    assert motor.axes["shaft"].position == stood
    assert status_word(bench, motor) == BO + bits & ~BP
    assert ask(bench, motor, "RMODE") == "B"
    send(bench, motor, f"{clear} MV G", 0.1)
    assert status_word(bench, motor) == BT
    assert motor.axes["shaft"].position > stood


@pytest.mark.parametrize(
    ("fault", "clear", "left"),
    [
        ("limit", "ZS", 0), ("limit", "Zr", 0), ("limit", "Zl", BR), ("limit", "Ze Zh Zs", BR),
        ("position error", "ZS", 0), ("position error", "Ze", 0), ("position error", "Zr Zl Zh", BE),
        ("position error", "G", BE),
    ],
)  # fmt: skip
def test_what_clears_a_fault(bench, fault, clear, left):
    """4.2: "reset by ZS or clear the fault bits individually by Zr, Zl, Ze, and Zh"."""
    motor = wired(bench)
    send(bench, motor, MOVE, 0.1)
    FAULTS[fault][0](bench, motor)
    motor.pins["C"].drive(0.0)
    advance(bench, 3)
    send(bench, motor, clear)
    assert status_word(bench, motor) == BO + left


@pytest.mark.parametrize("f", [1, 33])
@pytest.mark.parametrize("mtb", [True, False])
def test_f_1_decelerates_to_a_stop(bench, f, mtb):
    """Table 4.2: the motor stops at "A" in 9+8+…+1 = 45 counts, then MTB; with MTB disabled (BRKRLS, OFF) it holds."""
    motor = wired(bench)
    send(bench, motor, f"{'' if mtb else 'BRKRLS OFF '}F={f} {MOVE}", 0.1)
    motor.pins["C"].release()
    path = steps(bench, motor, 30)
    begin = path.index(9)
    assert path[:begin] == [10] * begin
    assert begin <= 2
    assert path[begin:] == [9, 8, 7, 6, 5, 4, 3, 2, 1] + [0] * (30 - begin - 9)
    assert status_word(bench, motor) == BR + BP + (BO if mtb else 0)
    assert motor.pins["brake"].level is mtb
    if mtb:
        assert ask(bench, motor, "RMODE") == "B"


def test_while_decelerating_the_servo_is_on_and_nothing_else_is_obeyed(bench):
    """Table 7.1: while decelerating "Bo will equal 0"; G, S and X are inhibited, and a new A has no effect."""
    motor = wired(bench)
    send(bench, motor, f"F=1 {MOVE}", 0.1)
    send(bench, motor, "A=6553", 0)
    open_limit(bench, motor)
    assert status_word(bench, motor) == BT + BR + BP
    assert not motor.pins["brake"].level
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
    assert error - 100 <= abs(int(ask(bench, motor, "Rb"))) <= error + 400
    assert ask(bench, motor, "RPE") == "0"
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


def test_a_load_turns_a_motor_that_has_no_power(bench):
    """Without power the load turns the shaft; at power-up the counts begin at 0."""
    motor = ready(bench, shaft={"motor": "frame23"})
    motor.power(False)
    motor.axes["shaft"].load(0.1)
    bench.run(0.2)
    turned = motor.axes["shaft"].position
    motor.axes["shaft"].load(0.0)
    bench.run(1.0)
    assert turned > 10
    motor.power(True)
    bench.run(0.5)
    assert ask(bench, motor, "RP") == "0"
