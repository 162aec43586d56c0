"""The checker: errors of programs and conversations on 4.76, and changes of meaning since older firmware."""

import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench
from axistwin.bench import product
from axistwin.bench.programs import stored_programs
from axistwin.controllers.diagnostics import Sent, Session
from axistwin.controllers.smartmotor.checker.program import check
from axistwin.controllers.smartmotor.commands import COMMANDS
from axistwin.controllers.smartmotor.language import class5
from axistwin.scenes.diagnostics import fix
from axistwin.scenes.diagnostics.checking import diagnose_text

from .test_program import FAULT_HANDLING


def session(text: str, stored: bool) -> Session:
    """Return the characters of a session with their places; lines end in CR."""
    lines = enumerate(text.split("\n"), 1)
    sent = [
        Sent(b, number, column) for number, line in lines for column, b in enumerate(line.encode("latin-1") + b"\r", 1)
    ]
    return Session(tuple(sent), stored=stored)


def shown(text: str, stored: bool = True) -> list[str]:
    return [f"{d.line}:{d.column} {d.severity}: {d.message}" for d in check([session(text, stored)])]


WIRED = "UCI UDI ZS "
CAM = WIRED + "BASE=8000 SIZE=4 aw[0] 0 1 2 3 0. MC G "


@pytest.mark.parametrize("text", [
    "", " ' nothing but a comment", WIRED + "MP A=8*25 V=537*600 P=2000*10 G TWAIT END", "UCP UDM MV V=100 A=5 G",
    "WHILE 1 IF UAI a=a+1 ELSEIF UBI a=a-1 ELSE a=0 ENDIF LOOP", "END C5 a=1 RETURN", "GOSUB5 END C5 a=1 RETURN",
    "a=1 GOTO5 C7 b=1 END C5 GOTO7", "RUN? a=1 END", "F=96 END C1 Ze RETURNF C2 a=1 RETURNI",
    "F=64 WHILE 1 LOOP C2 STACK GOTO9 C9 END", "SWITCH a CASE 1 BREAK DEFAULT b=1 ENDS END", CAM,
    CAM + "F=16 D=100 MC2 CI WHILE 1 D=D+1 MC2 CI WAIT=100 LOOP", "SLD SLN=-100 SLP=100 SLE", "UGO BRKG BRKTRJ",
    "F=33 IF Be a=1 ENDIF END C1 Ze RETURNF"])  # fmt: skip
def test_nothing_is_said_about_what_is_right(text):
    assert shown(text) == []


def test_the_sample_of_4_3_has_rules_that_are_no_comments():
    assert [line.split(":", 2)[0] + line.split(" ")[1] for line in shown(FAULT_HANDLING)] == [
        "8warning:",  # it clears faults, but says nothing about the pins of the limits
        "10error:",
        "18error:",
        "22error:",
    ]
    assert shown("-----") == ["1:1 error: ----- is neither a command nor a comment: a comment begins with '"]


WRONG = {
    # syntax
    "a=1\n  b=2+": "2:7 error: a value is missing at the end of the expression: expected e.g. a+1",
    "A100": "1:1 error: A100: an assignment needs its equal sign, A=100",
    "g=5 endif": "1:5 error: unknown command endif: commands are upper case",
    "a = 1": "1:1 error: a is a value, not a command: Ra reports it",
    # commands removed
    "KGON": "1:1 error: KGON has been removed in firmware 4.76: KG acts whenever it is not 0: remove this command",
    "MFRATIO": "1:1 error: MFRATIO has been removed in firmware 4.76: write e.g. MFMUL=1 MFDIV=2 MFR",
    # words of Class 5
    "PT=100": "1:1 error: PT= is a word of Class 5, which sets Bs here: 4.76 uses P=100",
    "PRT=a+1": "1:1 error: PRT= is a word of Class 5, which sets Bs here: 4.76 uses D=a+1",
    "VT=5": (
        "1:1 error: VT= is a word of Class 5, which sets Bs here: 4.76 uses V=5 "
        "(its value is for 8000 samples/s, 4.76 has 4069)"
    ),
    "DT=5": (
        "1:1 error: DT= is a word of Class 5, which sets Bs here: 4.76 uses A=5 "
        "(one acceleration for both ramps; its value is for 8000 samples/s, 4.76 has 4069)"
    ),
    "EIGN(2)": "1:1 error: EIGN(2) is a word of Class 5, which sets Bs here: 4.76 uses UCI",
    "EIGN(W,0)": "1:1 error: EIGN(W,0) is a word of Class 5, which sets Bs here: 4.76 uses UCI UDI",
    "MV(1)": "1:1 error: MV(1) is a word of Class 5, which sets Bs here: 4.76 uses MV",
    "OUT(1)=a": (
        "1:1 error: OUT(1)= is a word of Class 5, which sets Bs here: 4.76 uses UB=a (UBO makes the pin an output)"
    ),
    "a=PA": "1:3 error: PA is a word of Class 5, which sets Bs here: 4.76 uses @P",
    # blocks
    "IF a": "1:1 error: IF: ENDIF is missing",
    "a=1 LOOP": "1:5 error: LOOP: no WHILE before this statement",
    # values
    "E=40000": "1:3 error: 40000 is out of range: expected error 0…32000 counts",
    "F=256": "1:3 error: 256 is out of range: expected functions 0…255",
    "a=aw[102]": "1:6 error: there is no aw[102]: aw[0] to aw[101]",
    "ab[204]=1": "1:4 error: there is no ab[204]: ab[0] to ab[203]",
    "al[49] 1 2 3.": "1:4 error: there is no al[51]: al[0] to al[50]",
    "a=b/0": "1:1 error: this divides by 0: Bd is set and the statement has no effect",
    "a=3000000000": (
        "1:1 error: a number does not fit 32 bits (-2147483648 to 2147483647): "
        "Bd is set and the statement has no effect"
    ),
    # flow
    "GOTO5": "1:1 error: there is no label C5",
    "C5 a=1\nC5": "2:1 error: label C5 is already defined in line 1",
    "GOSUB5 C5 a=1 RETURN": "1:15 warning: RETURN is reached without a GOSUB: it sets Bs and ends the program",
    "END a=1": "1:5 warning: this is never reached",
    "WHILE 1 LOOP a=1": "1:14 warning: this is never reached",
    "GOSUB5 END C5 GOSUB5 RETURN": "1:15 warning: C5 calls itself: each call uses one of 10 return addresses",
    "F=32 END C1 RETURN": "1:13 warning: C1 is called by a fault (F=32) and returns with RETURNF",
    "F=64 END C2 RETURN": (
        "1:13 warning: C2 is called by pin G (F=64) and returns with RETURNI: C2 would not be called again"
    ),
    "GOSUB7 END C7 RETURNF": "1:15 warning: RETURNF belongs to C1, but C1 does not reach this statement",
    "F=32 END": "1:1 warning: F=32 calls C1, which does not exist",
    "C5 STACK a=1 END": "1:4 warning: STACK should be followed by GOTO at once",
    # cam
    WIRED + "BASE=800 SIZE=3 MC G": "1:28 warning: SIZE=3: a cam needs 4 to 101 intervals, but the motor accepts fewer",
    WIRED + "BASE=800 SIZE=0 MC G": "1:28 error: SIZE=0: a cam table has at least one interval",
    WIRED + "BASE=800 SIZE=102 MC": "1:26 error: 102 is out of range: expected highest index 0…101",
    WIRED + "BASE=0 SIZE=5 MC": "1:26 error: BASE=0: a cam cycle has a positive length",
    WIRED + "BASE=4 SIZE=4 MC": "1:26 warning: BASE=4: the master must move less than a quarter of BASE in a sample",
    WIRED + "BASE=9 SIZE=10 MC": "1:27 error: BASE=9 is less than SIZE=10",
    WIRED + "MC BASE=9 SIZE=5": "1:12 warning: BASE= has not been assigned yet: MCn uses the present value",
    CAM.replace("SIZE=4", "SIZE=5"): "1:46 warning: the table is shorter than SIZE=5: aw[5] is not set",
    CAM.replace("MC", "D=50 MC"): "1:46 warning: D=50 is not a dwell: a dwell needs F=16 or F=128",
    CAM + "CI D=5": "1:54 warning: this makes the CI in line 1 invalid unless its zero point has passed",
    CAM + "BASE=9000 CI": (
        "1:61 warning: BASE= was assigned after the last MCn: without a new MCn before CI it has no effect"
    ),
    # changed meanings since older firmware
    "MP G": (
        "1:4 warning: limits are active high since 4.76: unless normally closed switches pull C and D to ground "
        "nothing moves; UCI UDI ZS at the top makes them ordinary inputs"
    ),
    "UCI UDI G": (
        "1:9 warning: the limit faults of power-up are not cleared: ZS (or Zr and Zl) is missing behind UCI and UDI"
    ),
    "F=2": (
        "1:1 warning: F=2 reverses the shaft's direction since 4.76; before, it let scan errors be sent to the host"
    ),
    "IF Be a=1 ENDIF": (
        "1:1 warning: when Be becomes 1 the program ends since 4.76; F=32 and label C1 let the program continue"
    ),
    "SLE SLN=5": "1:5 error: software limits are enabled in line 1: SLD before their values are changed",
    "BRKG": "1:1 warning: UGO must be given before BRKG",
    "UGO BRKG\na=UG": "2:1 warning: the brake uses pin G since line 1",
}  # fmt: skip


@pytest.mark.parametrize("text", WRONG)
def test_what_is_wrong_is_shown_with_its_place(text):
    assert WRONG[text] in shown(text)


@pytest.mark.parametrize("pin", ["C", "G"])
def test_only_what_changes_the_pin_of_the_brake_is_warned_of(pin):
    """5.1 note 2 lists UGI, UG=<value>, <variable>=UG, UCI, UC=<value> and <variable>=UC; reports only read the pin."""
    brake = f"UCI UDI ZS U{pin}O BRK{pin}\n"
    for harmless in (
        f"PRINT(U{pin})",
        f"RU{pin}",
        f"IF U{pin}I==1\nENDIF",
        f"a=U{pin}A",
        "a=U",
        f"ab[U{pin}]=1",
        f"A=U{pin}",
    ):
        assert shown(brake + harmless) == [], harmless
    for disturbing in (f"a=U{pin}", f"a=U{pin}I", f"a=1+U{pin}", f"aw[3]=U{pin}", f"U{pin}I", f"U{pin}=1"):
        assert shown(brake + disturbing) == [f"2:1 warning: the brake uses pin {pin} since line 1"], disturbing


def test_eleven_returns_are_too_many():
    labels = "".join(f" C{n} GOSUB{n + 1} RETURN" for n in range(3, 12))
    assert shown(f"GOSUB3 END{labels} C12 RETURN") == []
    text = f"F=96 GOSUB3 END C1 RETURNF C2 RETURNI{labels} C12 RETURN"
    assert shown(text) == ["1:6 error: this may need 12 return addresses: the stack holds 10"]


def test_a_program_that_does_not_fit():
    """15 of the base language: a program of more than 32 KiB does not fit."""
    assert shown("a=1 \n" * 9000)[-1].endswith("error: this program has 36000 bytes: the motor stores 32768")


def test_what_a_host_sends():
    assert shown("UCI UDI ZS A=8*25\nRP g=-1 GOSUB4", stored=False) == []
    assert shown("ZS KGON A100\naw[0] 1 2 3. WHILE", stored=False) == [
        "1:4 error: KGON has been removed in firmware 4.76: KG acts whenever it is not 0: remove this command",
        "1:9 error: A100: an assignment needs its equal sign, A=100",
        "2:19 error: a value is missing at the end of the expression: expected e.g. a+1",
    ]
    assert shown("WAIT=5", stored=False) == ["1:1 error: WAIT= is valid only in a program"]
    assert shown("x" * 70, stored=False) == ["1:1 error: this command is longer than 64 characters: Bc is set"]


def test_addresses_and_records_of_host_mode_are_no_commands():
    assert shown("\x81ZS \xfa\0\0\x10\0\rG", stored=False) == []


def test_the_program_that_a_host_loads():
    assert shown("ZS LOAD GOTO5\nEND\xff\xff RP", stored=False) == ["1:9 error: there is no label C5"]


def test_a_command_that_is_never_ended():
    found = check([Session(tuple(Sent(byte, 1, column) for column, byte in enumerate(b"RP\rRV", 1)))])
    assert [(d.column, d.message) for d in found] == [(4, "this command has no end: a space or <CR> is missing")]


CLASS5 = {
    "PT=PA+100": "P=@P+100", "PRT=a+1": "D=a+1", "EL=5": "E=5", "VT=5": "V=5", "ADT=5": "A=5", "AT=5": "A=5",
    "PTS(100;1,200;2)": "P=100", "PRTS(a;1,b;2)": "D=a", "PTS()": "e.g. P=1000", "PRTSS()": "e.g. D=1000",
    "VTS=5": "V=5", "ADTS=5": "A=5", "GS": "G", "TSWAIT": "TWAIT", "GOSUB(10)": "GOSUB10", "GOTO(10)": "GOTO10",
    "GOSUB(a)": "e.g. SWITCH a CASE 1 GOSUB1 BREAK ENDS", "G:3": 'PRINT(#131,"G ")', "PT:3=5": 'PRINT(#131,"P=5 ")',
    "RPA:120": 'PRINT(#248,"RP ")', "G:a": 'e.g. PRINT(#129,"G ")', "G:121": 'e.g. PRINT(#129,"G ")',
    "EIGN(0)": "UAI", "EIGN(2)": "UCI", "EIGN(3)": "UDI", "EIGN(W,0)": "UCI UDI", "EIGN(9)": "e.g. UCI",
    "EILP": "UCP", "EILN": "UDM", "EISM(6)": "UG", "EOBK(6)": "BRKG", "EOBK(-1)": "BRKI", "EOBK(2)": "BRKC",
    "EOBK(0)": "e.g. BRKI",
    "OUT(1)=a": "UB=a", "OUT(9)=1": "e.g. UG=1", "OS(3)": "UD=1", "OR(3)": "UD=0", "OS(9)": "e.g. UG=1",
    "RIN(4)": "RUE", "RIN(W,0)": "RU", "RINA(V1,3)": "RUDA", "RINA(A,9)": "e.g. RUAA",
    "RPA": "RP", "RPC": "RP", "RPT": "PRINT(P,#13)", "RPRT": "RD", "RVT": "PRINT(V,#13)", "RAT": "RA", "REA": "RPE",
    "REL": "RE", "RTRQ": "RT", "RVA": "RV", "RCTR(0)": "RCTR", "RTMR(0)": "RCLK", "RW(3)": "RW", "RB(0,6)": "RBe",
    "RB(2,14)": "e.g. RBt", "G(0)": "G", "OFF(1)": "OFF", "MFR(1)": "MFR", "MFA(100)": "e.g. MFMUL=1 MFDIV=1 MFR",
    "CTE(1)": "e.g. SIZE=4 BASE=4000 aw[0] 0 1 2 1 0.", "OSH(0)=5": "O=@P+(5)", "O(0)=5": "O=5", "MINV(0)": "F=0",
    "MINV(1)": "F=2", 'PRINT0(PA,"PA")': 'PRINT(@P,"PA")', "ECHO0": "ECHO",
    "EITR(0)": "e.g. F=96", "FSA(1,2)": "e.g. F=0",
    "Z(0,2)": "e.g. ZS", "BAUD(0)=9600": "BAUD9600", "BAUD(0)=115200": "e.g. BAUD38400", "ADDR=2": "SADDR2",
    "ADDR=CADDR": "e.g. SADDR1", "TMR(0,1000)": "e.g. CLK=0", "SRAND=4": "e.g. a=CLK", "af[0]=5": "al[0]=5",
    "MDE": "", "SLM(1)": "", "CADDR=3": "", "VL=5": "",
}  # fmt: skip
VALUES5 = {
    "PA": "@P", "PC": "@P", "EA": "@PE", "VA": "@V", "PT": "P", "PRT": "D", "VT": "V", "AT": "A", "AC": "A", "EL": "E",
    "TRQ": "T", "CTR(1)": "CTR", "CTR(0)": "@P", "INA(V1,3)": "UDA", "INA(A,9)": "e.g. UAA", "IN(2)": "UC",
    "IN(W,0)": "e.g. UA", "B(0,1)": "Bo", "B(0,2)": "Bt", "B(0,15)": "Bm", "B(3,1)": "e.g. Bt", "W(0)": "e.g. Bt",
    "RAND": "CLK", "RANDOM": "CLK", "TMR(0)": "CLK", "ABS(PA-5)": "(@P-5)*(((@P-5)>0)-((@P-5)<0))", "CADDR": "ADDR",
    "SQRT(a)": "e.g. al[0]", "af[1]": "e.g. al[0]", "PA:3": 'e.g. PRINT(#129,"RP ")', "b:3": 'e.g. PRINT(#129,"RP ")',
}  # fmt: skip


def refusals(text):
    """Return the errors of a program that has the labels of the hints."""
    return [line for line in shown(f"{text} END C1 RETURNF C2 RETURNI C10 RETURN") if " error: " in line]


@pytest.mark.parametrize("text", CLASS5)
def test_what_4_76_has_for_a_word_of_class_5_is_accepted(text):
    (error,), here = refusals(text), CLASS5[text]
    assert f"4.76 uses {here}" in error if here else "4.76 has nothing like it, so remove it" in error
    assert refusals(here.removeprefix(class5.EXAMPLE)) == []


@pytest.mark.parametrize("text", VALUES5)
def test_what_4_76_has_for_a_value_of_class_5_is_accepted(text):
    (error,), here = refusals(f"IF {text} ENDIF"), VALUES5[text]
    assert f"4.76 uses {here}" in error
    here = here.removeprefix(class5.EXAMPLE)
    assert refusals(here if here.startswith("PRINT") else f"IF {here} ENDIF") == []


def test_every_word_of_class_5_has_a_row_here():
    for table, rows in ((class5.COMMANDS, CLASS5), (class5.VALUES, VALUES5)):
        left = [
            each.form
            for each in table
            if not any(re.fullmatch(each.form, x) for text in rows for x in (text, text[:2]))
        ]
        assert left == []


@pytest.mark.parametrize(("text", "written", "printed"), [
    ("1RP", r"\x81RP", 'PRINT(#129,"RP ")'), ("0ZS", r"\x80ZS", 'PRINT(#128,"ZS ")'),
    ("12A=100", r"\x8CA=100", 'PRINT(#140,"A=100 ")')])  # fmt: skip
def test_an_address_is_one_byte(text, written, printed):
    """Communications: "128 + address"; what the message says is accepted, and --fix writes it."""
    said = f"is one byte before the command: in a conversation write {written}, in a program {printed}"
    assert said in shown(text)[0] and said in shown(f"{text} ", stored=False)[0]
    assert refusals(printed) == []
    talk, made = f"> {text}\\r\n", product("smartmotor")
    fixed, done, left = fix.fix_text(talk, lambda each: diagnose_text(each, ".talk", made))
    assert (fixed, [each.code for each in done], left) == (f"> {written}\\r\n", ["SM120"], [])


@pytest.mark.parametrize("text", ["121RP", "1FOO", "1", "1a"])
def test_what_is_no_command_behind_digits_is_no_address(text):
    assert not any("one byte" in line for line in shown(text))


def test_no_command_of_4_76_is_taken_for_one_of_class_5():
    assert [c.code for c in COMMANDS if class5.find(str(c.code), class5.COMMANDS) is not None] == []


@settings(max_examples=50)
@given(st.text(alphabet=st.characters(max_codepoint=255), max_size=80), st.booleans())
def test_any_text_can_be_checked(text, stored):
    shown(text, stored)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("F=32 UCI UDI MP G END C1 ZS RETURNF", True),
        ("F=32 UCI UDI MP G END C1 GOSUB5 RETURNF C5 UCI UDI ZS RETURN", True),
        ("F=64 UCI UDI MP G END C2 ZS RETURNI", True),
        ("F=32 UCI UDI ZS MP G END C1 ZS RETURNF", False),
        ("F=32 UCI UDI GOSUB5 MP G END C1 GOSUB5 RETURNF C5 ZS RETURN", False),
        ("UCI UDI MP G END C1 ZS RETURN", True),  # only a host can call this subroutine, and G comes before it
        ("END C1 UCI UDI ZS RETURN C2 MP G RETURN", False),  # a host calls both
    ],
)
def test_a_zs_that_only_a_fault_reaches_does_not_clear_the_faults_from_switching_on(text, said):
    """SM402, 3.1: C1 is called "on a new occurrence" (1.2), so ZS in C1 does not clear the faults of power-up."""
    assert any("the limit faults of power-up are not cleared" in line for line in shown(text)) is said


BEFORE = (
    "", "ZS", "SLE ZS", "UCI UDI", "ZS UCI UDI", "Zr Zl", "UCI ZS", "UDI ZS", "UCI UDI Zr", "UCI UDI Zl", "UCI UDI ZS",
    "UCI UDI Zr Zl", "UCO ZS UDO", "UDO UCO ZS", "GOSUB7", "GOTO7", "IF 0 UCI UDI ZS ENDIF", "F=32",
)  # fmt: skip
AFTER = "TWAIT UCI UDI ZS END C1 UCI UDI ZS RETURNF C5 UCI UDI ZS RETURN C7 UCI ZS UDI RETURN"


@pytest.mark.parametrize("move", ["A=100 V=100000 P=500 G", "A=100 V=100000 P=-500 G", "T=500 MT"])
@pytest.mark.parametrize("before", BEFORE)
def test_the_check_warns_of_every_limit_fault_that_a_run_meets(before, move):
    """SM401 and SM402, 3.1: "the pin must be released or reassigned first", and ZS clears after that."""
    text, bench = f"{before} {move} {AFTER}", Bench()
    motor = bench.add("smartmotor")
    bench.run(0.5)
    stored_programs.store(stored_programs.as_sent(f"{text}\n"), "a.sms", motor)
    bench.run(0.05)
    motor.serial.write(b"RUN\r")
    refused = bench.run_until(lambda: bool(motor.hint), 0.1)
    warned = any("limits are active high" in line or "limit faults of power-up" in line for line in shown(text))
    assert warned or not refused
    assert warned is not (before in ("UCI UDI ZS", "UCI UDI Zr Zl", "UDO UCO ZS", "GOTO7"))


@pytest.mark.parametrize("text", ["MP G", "UCI MP G", "UDO MP G", "ZS UCI UDI G", "GOTO5 UCI UDI ZS C5 MT END"])
def test_who_writes_what_the_check_says_about_limits_is_rid_of_it(text):
    for _ in range(3):
        found = [d for d in check([session(text, stored=True)]) if d.code in ("SM401", "SM402")]
        text = fix.apply(text, [edit for each in found for edit in each.fix.edits])
    assert found == []
    assert "UCI" in text or "UCO" in text
