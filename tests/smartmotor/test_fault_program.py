"""Effects of faults on the program, C1 and RETURNF, the sample program (4.1, 4.3, 7.1)."""

from functools import partial

from . import talking
from .bits import BA, BE, BI, BL, BM, BO, BP, BR, BS
from .scripts import play, scripts
from .talking import UNIT, advance, ask, load, ready, send

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


@scripts({
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
    '4.1 item 4, limits: "Program execution continues to run, if F=32 is not issued. with F=32 it goes to C1"':
    [f"wired; load {WITH_C1.format(f=f)}; RUN; 0.1 s; C released; 33 samples; keep a; 20 samples; a grew; "
     f"c is {f // 32}"
     for f in (0, 1, 32, 33)],
    '4.1 item 4: "End program execution, if F=32 is not issued. If F=32 is issued, program goes to label "C1""':
    [f"load {WITH_C1.format(f=f)}; RUN {MOVE}; 0.1 s; keep a; 20 samples; a grew; jam; 110 samples; free; "
     "30 samples; "
     f"keep a; 20 samples; a {how}; c is {f // 32}"
     for f, how in ((0, "kept"), (1, "kept"), (32, "grew"), (33, "grew"))],
    "F=32 without a label C1: the motor stops at a fault and still answers":
    [f"wired; {program}RUN F=32 {MOVE}; 0.1 s; C released; 8 samples; W rop"
     for program in ("", "load F=32 / END; ", f"load {COUNTING}; ")],
    '7.1: "C1 will be called and return to C2"':
    f"wired; UGI; load F=96 / {COUNTING}C1 / c=b / RETURNF / C2 / WHILE b<400 / b=b+1 / LOOP / d=1 / RETURNI; RUN; "
    "0.1 s; G low; 0.05 s; C released; 0.5 s; c > 30; c < 120; Rb Rd RBs -> 400 1 0; keep a; 20 samples; a grew",
    "However C1 has ended, with RETURNF or END, a new fault calls it again (as 7.1 says of C2)":
    [f"wired; load F=32 / C9 / WHILE 1 / a=a+1 / LOOP / C1 / c=c+1 / {ending}; RUN; 0.05 s; "
     + "; ".join(
         f"C released; 0.05 s; c is {times}; keep a; 20 samples; a {how}; C low; ZS; 0.01 s" for times in (1, 2, 3)
     )
     for ending, how in (("RETURNF", "grew"), ("END", "kept"), ("STACK / GOTO9", "grew"), ("", "kept"))],
    "C1 is not called for the open limits of power-up, because F=32 is set after they were found":
    f"load {WITH_C1.format(f=32)}; power cycle; 0.5 s; keep a; 20 samples; a grew; c is 0",
})  # fmt: skip
def test_fault_program(script):
    play(script)


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
    assert first.startswith(b"POSTION ERROR= ") and 1000 < int(first[15:]) < 1020
    assert status_word(bench, motor) & (BE + BS) == 0


def test_the_sample_program_survives_a_jammed_motor(bench):
    """4.3: with a jammed motor the sample program causes no stack error, and it clears the fault."""
    motor = ready(bench, shaft={"motor": "frame23"})
    load(bench, motor, SAMPLE)
    send(bench, motor, "RUN", 0.5)
    motor.axes["shaft"].jam(True)
    assert send(bench, motor, "", 3.0).startswith(b"POSTION ERROR= 10")
    motor.axes["shaft"].jam(False)
    assert status_word(bench, motor) & BS == 0
    send(bench, motor, "ZS RUN", 4.0)
    assert ask(bench, motor, "RP") == "20000"
