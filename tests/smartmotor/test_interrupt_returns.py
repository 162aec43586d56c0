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
    }
)  # fmt: skip
def test_interrupt_returns(script):
    play(script)


# Re-entrance


def test_an_edge_during_c2_does_not_call_it_again(bench, motor):
    """7.1: C2 is not called again "until a prior GOSUB2 call has been completed by" RETURNI."""
    run(bench, motor, main_with("WHILE p==0\nLOOP\nRETURNI"))
    for _ in range(5):
        trigger(bench, motor)
        assert value(bench, motor, "j") == 1
    send(bench, motor, "p=1", 0)
    advance(bench, 50)
    assert value(bench, motor, "j") == 1
    send(bench, motor, "p=0", 0)
    trigger(bench, motor)
    assert value(bench, motor, "j") == 2


def test_return_instead_of_returni_leaves_c2_closed(bench, motor):
    """7.1: C2 needs "A return by RETURNI rather than RETURN"; after RETURN, C2 is not called again."""
    run(bench, motor, main_with("RETURN"))
    trigger(bench, motor)
    before = value(bench, motor, "m")
    trigger(bench, motor)
    trigger(bench, motor)
    assert value(bench, motor, "j") == 1
    assert value(bench, motor, "m") > before


def test_stack_and_goto_complete_c2(bench, motor):
    """7.1: "STACK (which should immediately be followed by GOTO)" completes C2, any number of times."""
    run(bench, motor, main_with("STACK\nGOTO9"))
    for count in range(1, 31):
        trigger(bench, motor)
        assert (value(bench, motor, "j"), value(bench, motor, "k")) == (count, count)
    assert ask(bench, motor, "RBs", 0) == "0"


def test_end_completes_c2(bench, motor):
    """7.1: "Or, END" completes C2; then RUN has to start the program again."""
    run(bench, motor, main_with("END"))
    trigger(bench, motor)
    before = value(bench, motor, "m")
    advance(bench, 100)
    assert (value(bench, motor, "j"), value(bench, motor, "m")) == (1, before)
    send(bench, motor, "RUN", 0)
    advance(bench, 30)
    trigger(bench, motor)
    assert value(bench, motor, "j") == 2


def test_a_hosts_end_and_run_complete_c2(bench, motor):
    """7.1: END from the host completes C2; 8 of the base language: RUN clears the return stack."""
    run(bench, motor, main_with("WHILE 1\nLOOP\nRETURNI"))
    for count in range(1, 16):
        trigger(bench, motor)
        assert value(bench, motor, "j") == count
        send(bench, motor, "END RUN" if count % 2 else "RUN", 0)
        advance(bench, 30)


def test_a_thousand_calls_do_not_overflow_the_stack(bench, motor):
    """7.1: "recursive loop overflowing the stack" is a risk; a thousand calls of C2 do not overflow it."""
    run(bench, motor, main_with("RETURNI"))
    for _ in range(1000):
        trigger(bench, motor, 4, 6)
    assert value(bench, motor, "j") == 1000
    assert ask(bench, motor, "RBs", 0) == "0"


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


def test_an_end_in_c1_ends_the_program(bench, motor):
    """4.1, 7.1: END in C1 ends the program."""
    motor.pins["C"].drive(False)
    send(bench, motor, "UCP ZS", 0.01)
    run(bench, motor, "F=32\nWHILE 1\nm=m+1\nLOOP\nEND\nC1\ni=i+1\nEND\n")
    motor.pins["C"].drive(True)
    advance(bench, 30)
    before = value(bench, motor, "m")
    advance(bench, 30)
    assert (value(bench, motor, "i"), value(bench, motor, "m")) == (1, before)


def test_without_a_label_the_motor_still_works(bench, motor):
    """With F=96 but no labels C1 and C2, the program continues and commands are answered."""
    motor.pins["C"].drive(False)
    send(bench, motor, "UCP ZS", 0.01)
    run(bench, motor, "F=96\nUGI\nWHILE 1\nm=m+1\nLOOP\nEND\n")
    motor.pins["C"].drive(True)
    trigger(bench, motor)
    assert ask(bench, motor, "RBp", 0) == "1"
    motor.pins["C"].drive(False)
    send(bench, motor, "ZS END m=5 RUN", 0)
    advance(bench, 40)
    assert value(bench, motor, "m") > 5


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


@pytest.mark.parametrize("statements", [1, 2, 3, 50])
def test_calls_with_more_statements_per_sample(bench, statements):
    """Ruling 14: with any number of statements per sample (option statements_per_sample), each edge is one call."""
    motor = ready(bench, statements_per_sample=statements)
    run(bench, motor, main_with("RETURNI"))
    for count in range(1, 8):
        trigger(bench, motor)
        assert value(bench, motor, "j") == count
