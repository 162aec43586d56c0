"""Decisions of docs/fidelity.md on the language and programs, not covered by a chapter's tests."""

from .scripts import play, scripts
from .talking import run, values
from .test_check import shown


@scripts({
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
    "8 of the base language specifies neither the flag nor the next step after an unknown label":
    [f"run a=1 / {word} / a=a+1 / END; a is 2; RBs -> 1" for word in ("GOSUB5", "GOTO5")],
    "C1 may end in RETURN or RETURNI: the program continues where it was, and the next fault calls C1 again":
    [f"wired; run F=32 / WHILE 1 / m=m+1 / LOOP / END / C1 / i=i+1 / {word}; "
     + "; ".join(f"C high; 20 samples; keep m; 6 samples; i is {n}; m grew by 2; C low; ZS; 0.01 s" for n in (1, 2))
     for word in ("RETURN", "RETURNI")],
    "Ruling 14: a statement of any kind takes a sample, so c=CLK, after b=CLK and four parameters, is 5 larger":
    "run b=CLK / A=1 / V=2 / P=3 / E=4 / c=CLK / END; c-b is 5",
    "4.1: a fault calls C1 or ends the program; with ten return addresses on the stack C1 cannot be called":
    f"run F=32 / GOSUB10 / END / {''.join(f'C{n} / GOSUB{n + 1} / RETURN / ' for n in range(10, 19))}"
    "C19 / WHILE 1 / m=m+1 / LOOP / RETURN / C1 / i=i+1 / RETURNF; E=20 A=65536 V=65536*4 MV G; jam; 50 samples; "
    "RBe RBs -> 1 1; keep m; 50 samples; m kept; i is 0",
    "Ruling 10: Be is set again in the sample of Ze, and calls C1 again after RETURNF, every three samples":
    "run F=33 / WHILE 1 / LOOP / END / C1 / i=i+1 / Ze / RETURNF; E=20 A=65536 V=65536*4 MV G A=1; jam; "
    "50 samples; "
    "keep i; 30 samples; i grew by 10; RBs -> 0",
})  # fmt: skip
def test_decisions_language(script):
    play(script)


def test_nested_switches_to_any_depth(bench, motor):
    """8 of the base language names four levels for later firmware; six nested SWITCHes keep their own values here."""
    inner = "a=a+1\n"
    for depth in range(6, 0, -1):
        inner = f"SWITCH {depth}\nCASE {depth}\n{inner}BREAK\nCASE 0\nb=9\nENDS\na=a+1\n"
    run(bench, motor, f"{inner}END\n")
    assert values(bench, motor, "ab") == [7, 0]
    assert [line.partition(": ")[2] for line in shown(f"{inner}END")] == ["more than 4 nested SWITCH"]
