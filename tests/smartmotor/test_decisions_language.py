"""Decisions of docs/fidelity.md on the language and programs, not covered by a chapter's tests."""

import pytest

from .playing import play, scripts
from .talking import advance, ask, ready, run, send, values, wired
from .test_check import shown


@scripts(
    {
        "1.2 names RETURNF for C1 and RETURNI for C2; after a GOSUB they return too":
        [f"run GOSUB7 / b=1 / END / C7 / a=1 / {word}; a is 1; b is 1; RBs -> 0"
         for word in ("RETURN", "RETURNF", "RETURNI")],
        "3 of the base language: a block word and its expression need one space between them; otherwise Bs is set":
        [f"run {text} / c=1 / END; RBs -> 1"
         for text in ("IF(a==0) b=1 ENDIF", "WHILE(a==0) b=1 LOOP", "SWITCH(a) CASE 0 b=1 ENDS")],
        "8 of the base language: RUN starts from the top in any state of the program":
        "run a=a+1 / WAIT=30000 / END; a is 1; RUN; 0.01 s; a is 2",
        "Each sample executes statements, then the trajectory: G moves at once; the next statement reads the "
        "result":
        "run A=65536 / V=655360 / P=1000 / G / a=@P / b=@P / END; a is 1; b is 3",
        "9 of the base language marks them as uncertain; TEMP is the housing, at 25 °C":
        "RTEMP RAMPS RBASE RSIZE REPTR RADDR RBs -> 25 1023 0 0 0 0 0",
        "Ruling 11 reads ZI as Zl, RU{pin}JA as RU{pin}A, and RUE in the list of analog reports as RUEA":
        f"Zs {'ZI'} RBs -> 1; Zs {'RUEJA'} RBs -> 1; Zs Zl RUEA RUE RBs -> 1023 1 0",
        "Ruling 17 for C2: pin G calls C2 while no program runs; after RETURNI no program runs":
        "load F=64 / UGI / END / C2 / j=j+1 / RETURNI / j=9; RUN; 0.05 s; trigger; j is 1; trigger; j is 2",
        '7.1: pin G "is de-bounced"; the manual has no figure, and three samples are used':
        "run F=64 / UGI / WHILE 1 / LOOP / END / C2 / j=j+1 / RETURNI; G low; 1 sample; G high; 20 samples; "
        "j is 0; G low; 2 samples; G high; 20 samples; j is 0; G low; 3 samples; G high; 20 samples; j is 1",
    }
)  # fmt: skip
def test_decisions_language(script):
    play(script)


def test_an_unknown_label_sets_bs_and_the_next_statement_follows(bench):
    """8 of the base language specifies neither the flag nor the next step after an unknown label."""
    for word in ("GOSUB5", "GOTO5"):
        motor = ready(bench)
        run(bench, motor, f"a=1\n{word}\na=a+1\nEND\n")
        assert values(bench, motor, "a") == [2]
        assert ask(bench, motor, "RBs") == "1"


@pytest.mark.parametrize("word", ["RETURN", "RETURNI"])
def test_c1_may_be_left_by_another_return(bench, word):
    """C1 may end in RETURN or RETURNI: the program continues where it was, and the next fault calls C1 again."""
    motor = wired(bench)
    run(bench, motor, f"F=32\nWHILE 1\nm=m+1\nLOOP\nEND\nC1\ni=i+1\n{word}\n")
    for count in (1, 2):
        motor.pins["C"].drive(True)
        advance(bench, 20)
        before = values(bench, motor, "m")
        advance(bench, 6)
        assert values(bench, motor, "im") == [count, before[0] + 2]
        motor.pins["C"].drive(False)
        send(bench, motor, "ZS", 0.01)


def test_nested_switches_to_any_depth(bench, motor):
    """8 of the base language names four levels for later firmware; six nested SWITCHes keep their own values here."""
    inner = "a=a+1\n"
    for depth in range(6, 0, -1):
        inner = f"SWITCH {depth}\nCASE {depth}\n{inner}BREAK\nCASE 0\nb=9\nENDS\na=a+1\n"
    run(bench, motor, f"{inner}END\n")
    assert values(bench, motor, "ab") == [7, 0]
    assert [line.partition(": ")[2] for line in shown(f"{inner}END")] == ["more than 4 nested SWITCH"]


def test_a_statement_of_any_kind_takes_a_sample(bench, motor):
    """Ruling 14: a statement of any kind takes a sample, so c=CLK, after b=CLK and four parameters, is 5 larger."""
    run(bench, motor, "b=CLK\nA=1\nV=2\nP=3\nE=4\nc=CLK\nEND\n")
    begin, end = values(bench, motor, "bc")
    assert end - begin == 5


def test_a_motor_fault_with_a_full_stack_ends_the_program(bench):
    """4.1: a fault calls C1 or ends the program; with ten return addresses on the stack C1 cannot be called."""
    deep = "".join(f"C{10 + n}\nGOSUB{11 + n}\nRETURN\n" for n in range(9))
    motor = ready(bench)
    run(bench, motor, f"F=32\nGOSUB10\nEND\n{deep}C19\nWHILE 1\nm=m+1\nLOOP\nRETURN\nC1\ni=i+1\nRETURNF\n")
    send(bench, motor, "E=20 A=65536 V=65536*4 MV G", 0)
    motor.axes["shaft"].jam(True)
    advance(bench, 50)
    assert send(bench, motor, "RBe RBs", 0) == b"1\r1\r"
    before = values(bench, motor, "m")
    advance(bench, 50)
    assert values(bench, motor, "im") == [0, *before]


def test_a_persistent_position_error_is_a_new_fault_each_time_be_is_cleared(bench, motor):
    """Ruling 10: Be is set again in the sample of Ze, and calls C1 again after RETURNF, every three samples."""
    run(bench, motor, "F=33\nWHILE 1\nLOOP\nEND\nC1\ni=i+1\nZe\nRETURNF\n")
    send(bench, motor, "E=20 A=65536 V=65536*4 MV G A=1", 0)
    motor.axes["shaft"].jam(True)
    advance(bench, 50)
    before = values(bench, motor, "i")[0]
    advance(bench, 30)
    assert values(bench, motor, "i") == [before + 10]
    assert ask(bench, motor, "RBs", 0) == "0"
