"""Decisions of docs/fidelity.md on limits, faults, functions, the brake's pin, cam and host mode."""

import pytest

from axistwin import Bench
from axistwin.bench import Controller

from .bits import BE, BL, BM, BO, BP, BR, BT
from .playing import play, scripts
from .scenarios import points, position
from .talking import advance, ask, load, send, status_word

CRUISE = "A=65536 V=65536*10 MV G"  # one count per sample², ten counts per sample
COUNTING = "WHILE 1 a=a+1 LOOP "


def jam(bench: Bench, motor: Controller) -> None:
    """Jam the shaft: at 10 counts per sample the position error exceeds E=1000 in the 101st sample."""
    motor.axes["shaft"].jam(True)
    advance(bench, 101)


@scripts(
    {
        # F=2 and the limit switches
        '7.1: the shaft spins "in the opposite direction for any given mode"; 3.1: pin C is the positive limit. '
        "The pins belong to commanded directions: with F=2 a positive move reaches the switch on D, and does not "
        "stop there":
        [f"bare limits=-500,500; ZS F=2 MP A=65536 V=65536*10 P={target} G; 1.0 s; at {-target}; W {flags}"
         for target, flags in ((2000, BL + BM), (-2000, BR + BP))],
        # F=1 and a position error
        '4.1, item 1: "Turn off servo amplifier, if F=1 is not issued"':
        f"{CRUISE}; 0.01 s; jam; 110 samples; free; W eo",
        # Zl and Zr
        '3.1: "left limit (Port C)", "right limit (Port D)"; but its first line and table 4.1 exchange C and D':
        [f"C low; D low; UCP UDM ZS; 0.01 s; {pin} released; 2 samples; W {flags + BO}; {pin} low; 2 samples; "
         f"{leaves}; W {(flags & BR + BL) + BO}; {clears}; W o"
         for pin, flags, clears, leaves in (("C", BR + BP, "Zr", "Zl"), ("D", BL + BM, "Zl", "Zr"))],
        # What a fault inhibits
        '3.2, 4.1: G, MT, MF1, MF4, MS, S and X are inhibited; 5.2 adds MF2; 2.0, item 5: "No further shaft '
        'movement"':
        [f"bare; A=65536 V=65536 {command}; master 1000 in 0.01 s; 0.05 s; at 0; RMODE -> B"
         for command in ("MF2", "MFR G", "MSR G", "MV G", "BASE=8 SIZE=4 MC G")],
        '4.1: "during a motor protection fault the "RUN" command is inhibited"; GOSUB is not named, so it works':
        [f"load a=1 END C5 a=5 RETURN ; {CRUISE}; 0.01 s; jam; 110 samples; free; {command}; 0.01 s; "
         f"Ra -> {value}"
         for command, value in (("GOSUB5", "5"), ("GOTO5", "5"), ("RUN", "0"))],
        # The brake's pin
        '5.1, note 2: such commands "will change the function of the I/O pin G": pin G becomes the direction line':
        [f"UGO BRKG; G is high; {command}; 0.1 s; G is low; BRKRLS BRKENG; G is low"
         for command in ("RS4", "OCHN(RS4,0,N,9600,1,8,C)")],
        # Mode cam and host mode
        '6.1: PRINT(U) "to communication channel 0", PRINT1(U) to channel 1, RU "to current communication '
        'channel"':
        "OCHN(RS4,1,N,9600,1,8,C); 485 writes PRINT(U,UA,#13) PRINT1(1,#13) RU<SP>; 0.1 s; receives 1271<CR>; "
        "485 receives 1<CR>127<CR>",
        # F=32 without C1
        '7.1, F=4: "user program prints and report command"; 6.1: "To current communication channel" for a host':
        'OCHN(RS4,1,N,9600,1,8,C) F=4 UG; RP PRINT("x",#13) RUA -> 0 x 1; 0.1 s; 485 receives nothing; '
        "485 writes RUA<SP>; 0.1 s; 485 receives 1<CR>; receives nothing",
    }
)  # fmt: skip
def test_decisions_faults(script):
    play(script)


# F=2 and the limit switches


@pytest.mark.parametrize(("pin", "speed", "flags"), [("C", 10, BR + BP), ("D", -10, BL + BM)])
def test_with_f_2_each_pin_stops_the_direction_that_is_commanded(bench, motor, pin, speed, flags):
    """7.1, 3.1: pin C stops commanded positive moves with F=2 too, so a motor with exchanged switches is protected."""
    for name in "CD":
        motor.pins[name].drive(False)
    send(bench, motor, f"UCP UDM ZS F=2 A=65536 V={speed}*65536 MV G", 0.01)
    assert motor.axes["shaft"].velocity * speed < 0
    motor.pins[pin].release()
    advance(bench, 2)
    assert status_word(bench, motor, 0) == flags + BO
    assert motor.axes["shaft"].velocity == 0 or not motor.axes["shaft"].moving


# F=1 and a position error


@pytest.mark.parametrize("mtb", [True, False])
def test_f_1_decelerates_on_a_position_error_too(bench, motor, mtb):
    """4.1, motor protection fault, item 1: "If F=1 is issued, the controller decelerates to a stop"; 4.2, 7.1: limits.

    A=1 gives steps of 9 8 7 … 1 0 counts in ten samples with the servo on; then MTB, or holding if MTB is disabled.
    """
    send(bench, motor, f"{'' if mtb else 'BRKRLS OFF '}F=1 {CRUISE}", 0.01)
    jam(bench, motor)
    assert status_word(bench, motor, 0) == BE + BT
    speeds = []
    for _ in range(9):
        speeds.append(int(ask(bench, motor, "RV", 0)) // 65536)
        advance(bench, 1)
    assert speeds == sorted(speeds, reverse=True)
    assert speeds[0] >= 8
    advance(bench, 3)
    assert status_word(bench, motor, 0) == BE + (BO if mtb else 0)
    assert ask(bench, motor, "RMODE RV", 0).split("\r") == ["B" if mtb else "V", "0"]


# F=32 without C1


@pytest.mark.parametrize("f", [0, 32])
def test_f_32_without_c1_is_as_if_f_32_were_not_given(bench, motor, f):
    """4.1, item 4: "program goes to label C1": without C1 a position error ends the program, a limit does not."""
    for name in "CD":
        motor.pins[name].drive(False)
    load(bench, motor, f"F={f} {COUNTING}")
    send(bench, motor, f"UCP UDM ZS RUN {CRUISE}", 0.05)
    motor.pins["C"].release()
    advance(bench, 20)
    first = int(ask(bench, motor, "Ra", 0.05))
    assert int(ask(bench, motor, "Ra", 0)) > first
    motor.pins["C"].drive(False)
    send(bench, motor, f"ZS {CRUISE}", 0.05)
    jam(bench, motor)
    stood = ask(bench, motor, "Ra", 0.05)
    assert ask(bench, motor, "Ra RBs", 0).split("\r") == [stood, "0"]


# Mode cam and host mode


def test_a_negative_dwell_is_none(bench, motor):
    """9.1: a dwell is "the number of external encoder counts", "can be set to zero"; below zero it acts as zero."""
    send(bench, motor, "MF4 F=16 D=-50 BASE=80 SIZE=4 aw[0] 0 10 20 30 40. MC G")
    found = []
    for _ in range(12):
        motor.master.move(10, 0)
        advance(bench, 2)
        found.append(motor.axes["shaft"].position)
    assert found == [5, 10, 15, 20, 25, 30, 35, 40, 45, 50, 55, 60]


def test_a_position_without_a_clock_value_before_two_are_known_is_replaced(bench, motor):
    """10.1: times may be omitted "Having sent the first two times"; an earlier position without time is replaced."""
    send(bench, motor, "MD " + points((0, 0)) + position(999) + points((400, 100)) + "G", 0)
    advance(bench, 50)
    assert motor.axes["shaft"].position in range(190, 205)  # on the way to 400, not to 999
    assert ask(bench, motor, "RBs", 0) == "0"
