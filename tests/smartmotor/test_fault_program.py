"""Effects of faults on the program, C1 and RETURNF, the sample program (4.1, 4.3, 7.1)."""

from functools import partial

import pytest

from axistwin import Bench
from axistwin.bench import Controller

from . import talking
from .bits import BA, BE, BI, BL, BM, BO, BP, BR, BS
from .playing import play, scripts
from .scenarios import jam, open_limit
from .talking import UNIT, advance, ask, load, ready, send, wired

status_word = partial(talking.status_word, ignored=BI | BA)
COUNTING = "WHILE 1\na=a+1\nLOOP\n"
WITH_C1 = "F={f}\n" + COUNTING + "C1\nc=c+1\nRETURNF\n"
MOVE = f"A={UNIT} V={10 * UNIT} MV G"
SAMPLE = """ZS          ' Reset all status bits
F=33        ' F=32+1 where F=32 goes to subroutine C1 on a fault
            ' F=1 Decelerate to a stop when limit is triggered
MP          ' Set to position control mode
A=8*25      ' Set acceleration
V=537*600   ' Set velocity
P=2000*10   ' Set position
G           ' Go
END         ' End of main program
C1          ' Fault handling subroutine
  IF Be==1  ' If position error exceeded,
    pp=@PE  ' Store real time position error into variable.
    GOSUB200
  Ze       ' Reset position error bit
  ENDIF
RETURNF    'Return to main program where fault was triggered.
C200
  PRINT("POSTION ERROR= ",pp,#13)
RETURN
"""


def counts(bench: Bench, motor: Controller) -> bool:
    """True if the program that counts `a` is running."""
    before = ask(bench, motor, "Ra")
    advance(bench, 20)
    return ask(bench, motor, "Ra") != before


@scripts(
    {
        '4.1: "during a motor protection fault the "RUN" command is inhibited"; LOAD is too (2.0 item 6)':
        [f"load a=a+1 / END; F={f} {MOVE}; 0.01 s; jam; 110 samples; free; Za RUN; 0.01 s; LOAD; Ra -> 0; "
         "Ze RUN; 0.01 s; Ra -> 1"
         for f in (0, 32)],
        "4.1 inhibits RUN for motor protection faults only; the sample code of 3.1 needs RUN":
        "load UCI / UDI / ZS / a=a+1 / END; UCP UDM; 0.001 s; W rlopm; RUN; 0.01 s; Ra -> 1; 0.001 s; W o",
        '1.2: "on a new occurrence of motor protection fault": C1 is called when Bp is set anew, not while it '
        "stays 1":
        f"wired; load {WITH_C1.format(f=32)}; C released; 3 samples; RUN; 0.1 s; Rc -> 0; Zr; 0.1 s; Rc -> 0; "
        "C low; ZS; 0.1 s; C released; 3 samples; 0.1 s; Rc -> 1; C low; ZS; 0.1 s; C released; 3 samples; 0.1 s; "
        "Rc -> 2; C low; ZS; 0.1 s; C released; 3 samples; 0.1 s; Rc -> 3",
        '7.1: "The fault takes priority and GOSUB2 will not be called"':
        f"wired debounce_samples=1; UGI; load F=96 / {COUNTING}C1 / c=c+1 / RETURNF / C2 / d=d+1 / RETURNI; RUN; "
        "0.1 s; C released; G low; 0.1 s; Rc Rd -> 1 0; G high; 0.1 s; G low; 0.1 s; Rc Rd -> 1 1",
        "4.3: the sample program, loaded as it is printed":
        f"with frame23; load {SAMPLE}; RUN; 3.0 s; W; RP -> 20000",
        "Two limits that open in the same sample call C1 once":
        f"wired; load {WITH_C1.format(f=32)}; RUN; 0.05 s; D released; C released; 3 samples; 0.1 s; Rc -> 1",
        "3.1 note 3: the sample code clears the boot fault; without this code the program runs but moves nothing":
        [f"load {clears}A={UNIT} / V={UNIT} / P=100 / G / a=7 / END; power cycle; 0.5 s; Ra -> 7; "
         f"RP -> {'100' if clears else '0'}; W {0 if clears else BO + BR + BL + BP + BM}"
         for clears in ('UCI\nUDI\nZS\n', "")],
        '4.3: "stores it program pointer in the stack … to return to program pointer", also from inside a '
        "subroutine":
        "wired; "
        "load F=32 / GOSUB5 / b=1 / END / C5 / WHILE a<500 / a=a+1 / LOOP / RETURN / C1 / c=a / GOSUB6 / RETURNF / "
        "C6 / d=7 / RETURN; RUN; 0.05 s; C released; 3 samples; 1.0 s; Ra Rb Rd RBs -> 500 1 7 0; c > 40; c < 110",
        '7.1: WAIT is truncated only "when GOSUB2 is called"':
        "wired; load F=32 / CLK=0 / WAIT=1000 / END / C1 / c=CLK / RETURNF; RUN; 0.1 s; C released; 3 samples; "
        "0.1 s; Rc -> 0; 0.1 s; c > 999; c < 1006",
    }
)  # fmt: skip
def test_fault_program(script):
    play(script)


@pytest.mark.parametrize(("f", "ends"), [(0, False), (1, False), (32, False), (33, False)])
def test_a_limit_does_not_end_the_program(bench, f, ends):
    """4.1 item 4, limits: "Program execution continues to run, if F=32 is not issued. with F=32 it goes to C1"."""
    motor = wired(bench)
    load(bench, motor, WITH_C1.format(f=f))
    send(bench, motor, "RUN", 0.1)
    open_limit(bench, motor)
    advance(bench, 30)
    assert counts(bench, motor) is not ends
    assert ask(bench, motor, "Rc") == str(f // 32)


@pytest.mark.parametrize(("f", "ends"), [(0, True), (1, True), (32, False), (33, False)])
def test_a_position_error_ends_the_program_or_calls_c1(bench, motor, f, ends):
    """4.1 item 4: "End program execution, if F=32 is not issued. If F=32 is issued, program goes to label "C1""."""
    load(bench, motor, WITH_C1.format(f=f))
    send(bench, motor, f"RUN {MOVE}", 0.1)
    assert counts(bench, motor)
    jam(bench, motor)
    advance(bench, 30)
    assert counts(bench, motor) is not ends
    assert ask(bench, motor, "Rc") == str(f // 32)


@pytest.mark.parametrize("program", ["", "F=32\nEND\n", COUNTING])
def test_f_32_without_a_label_c1(bench, program):
    """F=32 without a label C1: the motor stops at a fault and still answers."""
    motor = wired(bench)
    if program:
        load(bench, motor, program)
    send(bench, motor, f"RUN F=32 {MOVE}", 0.1)
    open_limit(bench, motor)
    advance(bench, 5)
    assert status_word(bench, motor) & ~BS == BO + BR + BP


def test_a_fault_inside_c2_calls_c1_and_returns_to_c2(bench):
    """7.1: "C1 will be called and return to C2"."""
    motor = wired(bench)
    send(bench, motor, "UGI")
    load(bench, motor, "F=96\n" + COUNTING + "C1\nc=b\nRETURNF\nC2\nWHILE b<400\nb=b+1\nLOOP\nd=1\nRETURNI\n")
    send(bench, motor, "RUN", 0.1)
    motor.pins["G"].drive(False)
    bench.run(0.05)
    open_limit(bench, motor)
    bench.run(0.5)
    assert 30 < int(ask(bench, motor, "Rc")) < 120
    assert send(bench, motor, "Rb Rd RBs") == b"400\r1\r0\r"
    assert counts(bench, motor)


def test_the_sample_program_tells_a_position_error(bench, motor):
    """4.3: after a jam the program prints the position error, above E=1000, and resets Be; the main program has ended.

    At V=537*600, 4.9 counts per sample, IF and pp=@PE are executed one and two samples after Be: pp is below 1020.
    """
    load(bench, motor, SAMPLE)
    send(bench, motor, "RUN", 0.5)
    motor.axes["shaft"].jam(True)
    said = b""
    while not said:
        advance(bench, 1)
        said = motor.serial.read()
    motor.axes["shaft"].jam(False)
    said += send(bench, motor, "", 3.0)
    first = said.split(b"\r")[0]
    assert first.startswith(b"POSTION ERROR= ")
    assert 1000 < int(first[15:]) < 1020
    assert status_word(bench, motor) & (BE + BS) == 0


def test_the_sample_program_survives_a_jammed_motor(bench):
    """4.3: with a jammed motor the sample program causes no stack error, and it clears the fault."""
    motor = ready(bench, shaft={"motor": "frame23"})
    load(bench, motor, SAMPLE)
    send(bench, motor, "RUN", 0.5)
    motor.axes["shaft"].jam(True)
    said = send(bench, motor, "", 3.0)
    assert said.startswith(b"POSTION ERROR= 10")
    motor.axes["shaft"].jam(False)
    assert status_word(bench, motor) & BS == 0
    send(bench, motor, "ZS RUN", 4.0)
    assert ask(bench, motor, "RP") == "20000"


@pytest.mark.parametrize(
    ("ending", "runs_on"), [("RETURNF", True), ("END", False), ("STACK\nGOTO9", True), ("", False)]
)
def test_c1_is_called_for_the_next_fault_however_it_ended(bench, ending, runs_on):
    """However C1 has ended, with RETURNF or END, a new fault calls it again (as 7.1 says of C2)."""
    motor = wired(bench)
    load(bench, motor, f"F=32\nC9\nWHILE 1\na=a+1\nLOOP\nC1\nc=c+1\n{ending}\n")
    send(bench, motor, "RUN", 0.05)
    for times in (1, 2, 3):
        open_limit(bench, motor)
        bench.run(0.05)
        assert ask(bench, motor, "Rc") == str(times)
        assert counts(bench, motor) is runs_on
        motor.pins["C"].drive(0.0)
        send(bench, motor, "ZS", 0.01)


def test_the_boot_fault_is_not_a_new_occurrence(bench, motor):
    """C1 is not called for the open limits of power-up, because F=32 is set after they were found."""
    load(bench, motor, WITH_C1.format(f=32))
    motor.power_cycle()
    bench.run(0.5)
    assert counts(bench, motor)
    assert ask(bench, motor, "Rc") == "0"
