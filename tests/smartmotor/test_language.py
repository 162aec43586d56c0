"""The command language: single commands and their ends (3 of the base language; 1.1, 1.3, 8.1 of the manual)."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin.controllers.smartmotor.commands import COMMANDS
from axistwin.controllers.smartmotor.language import lexer
from axistwin.controllers.smartmotor.language.expressions import Expression
from axistwin.controllers.smartmotor.language.forms import Accept
from axistwin.controllers.smartmotor.language.language import command, read


def told(text):
    """Return place and message of the error in a statement."""
    problem = read(text).problem
    return None if problem is None else (problem.position, problem.message)


@pytest.mark.parametrize(
    ("text", "code", "operands"),
    [
        ("G", "G", []),
        ("F", "F", []),
        ("F=33", "F=", [33]),
        ("A=8*25", "A=", [200]),  # 4.3
        ("GOSUB200", "GOSUBn", [200]),
        ("GOTO0", "GOTOn", [0]),
        ("C1", "Cn", [1]),
        ("SADDR12", "SADDRn", [12]),
        ("PID4", "PIDn", [4]),
        ("MF4", "MF4", []),
        ("MC2", "MC2", []),
        ("MS0", "MS0", []),
        ("ECHO_OFF1", "ECHO_OFF1", []),
        ("RUN?", "RUN?", []),
        ("!", "!", []),
        ("Zr", "Zr", []),
        ("UGO", "UGO", []),
        ("UG=0", "UG=", [0]),
        ("UG", "UG", []),
        ("RUGA", "RUGA", []),
        ("RBt", "RBt", []),
        ("a=5", "a…zzz=", [0, 5]),
        ("zzz=5", "a…zzz=", [77, 5]),
        ("CASE -3", "CASE", [-3]),
        ("CASE   2*2", "CASE", [4]),
        ("OCHN(RS4,0,N,9600,1,8,C)", "OCHN()", ["RS4,0,N,9600,1,8,C"]),
        ("VST(aa,3)", "VST()", ["aa", 3]),
        ("VLD(ab[n,1],3)", "VLD()", ["ab[n,1]", 3]),
        ("AOUTB,512", "AOUTp", ["B", 512]),
        ("DOUTH63,1", "DOUTp", ["H", 63, 1]),
        ('PRINT("a b,c",#13,7)', "PRINT()", ["a b,c", b"\r", 7]),
        ("PRINT1(#255)", "PRINT1()", [b"\xff"]),
        ("PRINTH(1)", "PRINTH()", [1]),
    ],
)
def test_a_command_is_recognised(text, code, operands):
    statement = read(text)
    assert statement.problem is None and statement.command.code == code
    given = (getattr(part, "name", part) for part in statement.operands)  # VST and VLD store the first variable
    assert [part.constant if isinstance(part, Expression) else part for part in given] == operands


@pytest.mark.parametrize("text", [
    "Ra", "Rzz", "Rab[a+1]", "Raw[0]", "Ral[ab[3]]", "RAINA1", "RDINH63", "RCHN0", "RS4", "RS"])  # fmt: skip
def test_reports_are_commands(text):
    assert read(text).problem is None


@pytest.mark.parametrize(
    "text",
    [
        "A100", "KP175", "a5", "zz-3",  # 8.1: the equal sign is required
        "ES400", "ES1000", "KGON", "KGOFF", "LIMH", "LIML", "LIMN", "MFRATIO", "MFRATIO=2", "RES=2000", "MD50",  # 1.3
        "g", "", "a", "A", "A=", "A==1", "a=b=c", "P = 3", "C1000", "GOSUB", "GOSUBa", "GOSUB5x", "GOSUB(5)",
        "GOTO-1", "PID",
        "SADDR121", "MC3", "MF3", "Bt", "RBq", "Rabc", "Rab[1]+2", "Ra+1", "RAINA5", "IF", "IF ", "IFa", "CASE a",
        "ELSE 1",
        "PRINT", "PRINT(", 'PRINT("abc', "PRINT()", "PRINT(1,)", "PRINT(#256)", "PRINT(#)", "PRINT(1)x", "PRINTI(1)",
        "VST(aa)",
        "AOUTI,1", "AOUTA", "DOUTA,1", "DOUTA64,1", "UAI=1", "UH=1", "aw[0]", "aw[0]1", "aw[0] 1 2", "aw[0] 1 x.",
        "ab[=1",
        "aw[0] 1.5.", "aw[0]=1 2.", "MTBX", "ba=1", "Q1", "\xe9=1", "a=\xb2", "A=1'",
    ],
)  # fmt: skip
def test_what_is_no_command(text):
    statement = read(text)
    assert statement.problem is not None and 0 <= statement.problem.position <= len(text)


@pytest.mark.parametrize(("text", "expected"), [
    ("A100", (0, "A100: an assignment needs its equal sign, A=100")),
    ("zz-3", (0, "zz-3: an assignment needs its equal sign, zz=-3")),
    ("KGON", (0, "KGON has been removed in firmware 4.76: KG acts whenever it is not 0: remove this command")),
    ("a=b+", (4, "a value is missing at the end of the expression: expected e.g. a+1")),
    ("a=b+A1", (4, "there is no variable A1: expected e.g. aa, al[0] or CLK")),
    ("a=A1+ZZ", (2, "there is no variable A1: expected e.g. aa, al[0] or CLK")),
    ("b=ABC", (2, "there is no variable ABC: expected e.g. aa, al[0] or CLK")),
    ("b=XX", (2, "there is no variable XX: expected e.g. xx")),
    ("a=(1+2", (6, "the closing ) is missing: expected e.g. (a+1)*2 or aw[5]")),
    ("VST(a,3", (7, "the closing ) is missing: expected VST(variable,number)")),
    ("GOSUB1000", (5, "1000 is out of range: expected label 0…999")),
    ("endif", (0, "unknown command endif: commands are upper case")),
    ("=5", (0, "=5: blanks around = are not allowed")),
    ("aw[0] 1 2", (9, "the list of values does not end with a period: expected e.g. 'aw[0] 1 2 3.'")),
    ("CASE a", (5, "the value of CASE must be a constant, e.g. CASE 1")),
    ("Bt", (0, "Bt is a value, not a command: RBt reports it"))])  # fmt: skip
def test_what_is_wrong_is_told_with_its_place(text, expected):
    assert told(text) == expected


def test_a_host_may_not_send_what_belongs_to_a_program():
    """8 of the base language: block commands are valid inside a program only, not from a host."""
    inside = [entry for entry in COMMANDS if Accept.HOST not in entry.accepted and Accept.REMOVED not in entry.accepted]
    assert [str(entry.code) for entry in inside] == [
        "Cn", "IF", "ELSEIF", "ELSE", "ENDIF", "WHILE", "LOOP", "SWITCH", "CASE", "DEFAULT", "BREAK", "ENDS", "RUN?",
        "WAIT=",
        "TWAIT", "!",
    ]  # fmt: skip
    assert all(command(text).problem for text in ("C5", "IF 1", "ELSE", "WAIT=100", "RUN?", "!"))
    assert not any(command(text).problem for text in ("RUN", "END", "GOSUB5", "RETURN", "STACK", "G"))


@pytest.mark.parametrize(("text", "expected"), [
    ("ZS MP P=1000 G", ["ZS", "MP", "P=1000", "G"]), ("Ze       ' Reset position error bit\nENDIF", ["Ze", "ENDIF"]),
    ("a=1'b\r\nb=2\rc=3\0d=4\n\n", ["a=1", "b=2", "c=3", "d=4"]), ("IF   Be==1  ' If", ["IF   Be==1"]),
    ("WHILE 1 IF UAI a=a+1 ENDIF LOOP", ["WHILE 1", "IF UAI", "a=a+1", "ENDIF", "LOOP"]),
    ("\tCASE\t3\tG", ["CASE\t3", "G"]), ("IF\na=1", ["IF", "a=1"]),
    ('PRINT("it\'s a b",pp,#13) G', ['PRINT("it\'s a b",pp,#13)', "G"]), ('PRINT("abc\nG', ['PRINT("abc', "G"]),
    ("aw[0] 0 700  1100.  ' three\nG", ["aw[0] 0 700  1100.", "G"]), ("aw[0] 1 2 .\nG", ["aw[0] 1 2 .", "G"]),
    ("aw[ab[1]] 1 2\n3. G", ["aw[ab[1]] 1 2", "3.", "G"]), ("aw[0]=1 aw[1]=2", ["aw[0]=1", "aw[1]=2"]), ("", []),
    (" ' nothing", [])])  # fmt: skip
def test_where_the_statements_of_a_program_end(text, expected):
    assert [text[begin:end] for begin, end in lexer.statements(text)] == expected


@settings(max_examples=50)
@given(st.text(alphabet=st.characters(max_codepoint=255), max_size=70))
def test_any_text_is_read(text):
    statement = read(text)
    assert (statement.command is None) <= (statement.problem is not None)
    edges = [place for span in lexer.statements(text) for place in span]
    assert edges == sorted(edges)


@given(st.sampled_from([str(entry.code) for entry in COMMANDS]), st.text(alphabet='()[]=a1,-#" .x', max_size=8))
def test_any_command_with_anything_behind_it_is_read(code, behind):
    read(code + behind)
    read(code.rstrip("n=()") + behind)


def test_an_unknown_name_before_an_equal_sign_is_blamed_for_its_name():
    """`=5` and `KP=` are parts of an assignment with blanks; in `FOO=` the message is about the name FOO."""
    assert read("FOO=").problem.rule.code == "SM101" and read("KP=").problem.rule.code == "SM112"
    assert read("=5").problem.rule.code == "SM104"
