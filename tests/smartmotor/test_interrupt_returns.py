"""Chapter 7: returns from C1 and C2, and further calls of C2."""

from .scenarios import main_with
from .scripts import play, scripts

DEEP = "".join(f"C{n} / GOSUB{n + 1} / WHILE 1 / LOOP / RETURN / " for n in range(10, 19))


@scripts({
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
    + "; ".join(f"trigger; j is {count}; {'END RUN' if count % 2 else 'RUN'}; 30 samples"
                for count in range(1, 16)),
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
    "7.1: GOSUBs inside C2 return in the right order":
    'load UGI / F=64 / WHILE 1 / GOSUB10 / LOOP / END / C10 / PRINT("a") / WAIT=40 / PRINT("b") / RETURN / C2 / '
    'GOSUB11 / PRINT("y") / RETURNI / C11 / PRINT("x") / RETURN; RUN; 20 samples; G low; 30 samples; '
    'receives axyba',
    "7.1: a power cut, a total reset or a new program ends an uncompleted C2":
    [f"run {main_with('WHILE 1 / LOOP / RETURNI')}; trigger; j is 1; {again}; trigger; j is 1"
     for again in ("power cycle; 0.5 s", "Z; 0.5 s", f"run {main_with('WHILE 1 / LOOP / RETURNI')}; j=0")],
    "8 of the base language: the stack has ten places, so ten nested GOSUBs prevent C2 until the first RETURN":
    f"run F=64 / UGI / GOSUB10 / END / {DEEP}"
    "C19 / WHILE p==0 / m=m+1 / LOOP / RETURN / C2 / j=j+1 / RETURNI; trigger; j is 0; RBs -> 1; p=1; 20 samples; "
    "trigger; j is 1",
})  # fmt: skip
def test_interrupt_returns(script):
    play(script)
