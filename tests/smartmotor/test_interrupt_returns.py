"""Chapter 7: returns from C1 and C2, and further calls of C2."""

import pytest

from .playing import play, scripts
from .scenarios import main_with, trigger
from .talking import advance, ask, load, ready, run, send, value


@scripts(
    {
        # Re-entrance
        '7.1: "a new input trigger occurrence will not trigger a GOSUB2 until a prior GOSUB2 call has been '
        'completed"':
        "run UGI / F=64 / GOSUB2 / WHILE 1 / LOOP / END / C2 / j=j+1 / WHILE p==0 / LOOP / RETURNI; trigger; "
        "j is 1; p=1; 50 samples; trigger; j is 2",
        "7.1: STACK completes C2 anywhere in the program":
        "run UGI / F=64 / C5 / IF s==1 / s=0 / STACK / GOTO5 / ENDIF / GOTO5 / END / C2 / j=j+1 / RETURN; trigger; "
        "trigger; j is 1; s=1; 30 samples; trigger; j is 2",
        # Which return
        "Without an interrupt or a GOSUB to return from, the motor still answers after the return":
        [f"run a=1 / {word} / b=1 / END; a is 1; RP -> 0; {word}; RP -> 0"
         for word in ("RETURNF", "RETURNI", "RETURN")],
        "1.2: a host may send GOSUBn for a handler: the subroutine is run, and then the motor is idle again":
        [f"load END / C{1 if word == 'RETURNF' else 2} / a=a+1 / {word} / b=b+1 / END; "
         f"GOSUB{1 if word == 'RETURNF' else 2}; 0.01 s; a is 1"
         for word in ("RETURNF", "RETURNI")],
        # Re-entrance
        '7.1: C2 is not called again "until a prior GOSUB2 call has been completed by" RETURNI':
        f"run {main_with('WHILE p==0 / LOOP / RETURNI')}; "
        + "; ".join("trigger; j is 1" for _ in range(5))
        + "; p=1; 50 samples; j is 1; p=0; trigger; j is 2",
        '7.1: C2 needs "A return by RETURNI rather than RETURN"; after RETURN, C2 is not called again':
        f"run {main_with('RETURN')}; trigger; keep m; trigger; trigger; j is 1; m grew",
        '7.1: "STACK (which should immediately be followed by GOTO)" completes C2, any number of times':
        f"run {main_with('STACK / GOTO9')}; "
        + "; ".join(f"trigger; j is {count}; k is {count}" for count in range(1, 31))
        + "; RBs -> 0",
        '7.1: "Or, END" completes C2; then RUN has to start the program again':
        f"run {main_with('END')}; trigger; keep m; 100 samples; j is 1; m kept; RUN; 30 samples; trigger; j is 2",
        "7.1: END from the host completes C2; 8 of the base language: RUN clears the return stack":
        f"run {main_with('WHILE 1 / LOOP / RETURNI')}; "
        + "; ".join(
            f"trigger; j is {count}; {'END RUN' if count % 2 else 'RUN'}; 30 samples"
            for count in range(1, 16)
        ),
        '7.1: "recursive loop overflowing the stack" is a risk; a thousand calls of C2 do not overflow it':
        f"run {main_with('RETURNI')}; "
        + "; ".join("G low; 4 samples; G high; 6 samples" for _ in range(1000))
        + "; j is 1000; RBs -> 0",
        # Which return
        "4.1, 7.1: END in C1 ends the program":
        "C low; UCP ZS; 0.01 s; run F=32 / WHILE 1 / m=m+1 / LOOP / END / C1 / i=i+1 / END; C high; 30 samples; "
        "keep m; 30 samples; i is 1; m kept",
        "With F=96 but no labels C1 and C2, the program continues and commands are answered":
        "C low; UCP ZS; 0.01 s; run F=96 / UGI / WHILE 1 / m=m+1 / LOOP / END; C high; trigger; RBp -> 1; C low; "
        "ZS END m=5 RUN; 40 samples; m > 5",
        "Ruling 14: with any number of statements per sample (option statements_per_sample), each edge is one "
        "call":
        [f"with statements_per_sample={statements}; run {main_with('RETURNI')}; "
         + "; ".join(f"trigger; j is {count}" for count in range(1, 8))
         for statements in (1, 2, 3, 50)],
    }
)  # fmt: skip
def test_interrupt_returns(script):
    play(script)


# Re-entrance


def test_subroutines_within_subroutines_within_c2(bench):
    """7.1: GOSUBs inside C2 return in the right order."""
    program = """
UGI
F=64
WHILE 1
GOSUB10
LOOP
END
C10
PRINT("a")
WAIT=40
PRINT("b")
RETURN
C2
GOSUB11
PRINT("y")
RETURNI
C11
PRINT("x")
RETURN
"""
    motor = ready(bench)
    load(bench, motor, program.strip() + "\n")
    send(bench, motor, "RUN", 0)
    advance(bench, 20)
    motor.pins["G"].drive(False)
    advance(bench, 60)
    assert motor.serial.read().startswith(b"axyba")


# Which return


@pytest.mark.parametrize("again", ["power_cycle", "Z", "LOAD"])
def test_c2_is_open_again_after_a_new_start_in_its_middle(bench, again):
    """7.1: a power cut, a total reset or a new program ends an uncompleted C2."""
    program = main_with("WHILE 1\nLOOP\nRETURNI")
    motor = ready(bench)
    run(bench, motor, program)
    trigger(bench, motor)
    assert value(bench, motor, "j") == 1
    if again == "power_cycle":
        motor.power_cycle()
        bench.run(0.5)
    elif again == "Z":
        send(bench, motor, "Z", 0.5)
    else:
        run(bench, motor, program)
        send(bench, motor, "j=0", 0)
    trigger(bench, motor)
    assert value(bench, motor, "j") == 1


def test_a_full_stack_prevents_only_one_call(bench):
    """8 of the base language: the stack has ten places, so ten nested GOSUBs prevent C2 until the first RETURN."""
    deep = "".join(f"C{10 + n}\nGOSUB{11 + n}\nWHILE 1\nLOOP\nRETURN\n" for n in range(9))
    last = "C19\nWHILE p==0\nm=m+1\nLOOP\nRETURN\n"
    motor = ready(bench)
    run(bench, motor, f"F=64\nUGI\nGOSUB10\nEND\n{deep}{last}C2\nj=j+1\nRETURNI\n")
    trigger(bench, motor)
    assert (value(bench, motor, "j"), ask(bench, motor, "RBs", 0)) == (0, "1")
    send(bench, motor, "p=1", 0)
    advance(bench, 20)
    trigger(bench, motor)
    assert value(bench, motor, "j") == 1
