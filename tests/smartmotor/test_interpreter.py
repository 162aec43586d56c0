"""The interpreter: program flow, one statement per sample (8 of the base language, ruling 14, chapter 7)."""

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from axistwin.controllers.smartmotor.kernel import jit, state
from axistwin.controllers.smartmotor.kernel.kernel import ALL_DONE

from .rig import Processor, Rig, Whole


def run(text, samples=1000, **keywords):
    return Processor(text, **keywords).run(samples)


def test_one_statement_per_sample():
    """Each statement takes one sample, LOOP too; labels, ENDIF, ENDS and comments take no time."""
    program = run("C5 a=1 ' comment\nWHILE a<3\n  a=a+1\nLOOP\nIF a==3 b=1 ENDIF\nEND")
    assert program.carried_out == [
        "a=1", "WHILE a<3", "a=a+1", "LOOP", "WHILE a<3", "a=a+1", "LOOP", "WHILE a<3", "IF a==3", "b=1", "END",
    ]  # fmt: skip
    assert (program["a"], program["b"]) == (3, 1) and program.i[state.PROGRAM] == state.STOPPED


def test_a_program_ends_at_its_end():
    program = run("a=1\nb=2")
    assert program.carried_out == ["a=1", "b=2", "(end)"] and program.i[state.PROGRAM] == state.STOPPED


BRANCHES = "IF a==1 b=1 ELSEIF a==2 b=2 ELSEIF a==3 b=3 ELSE b=4 ENDIF c=1 END"


@pytest.mark.parametrize(
    ("a", "expected"),
    [
        (1, ["IF a==1", "b=1", "ELSEIF a==2"]),  # the jump that leaves the branch
        (2, ["IF a==1", "ELSEIF a==2", "b=2", "ELSEIF a==3"]),
        (3, ["IF a==1", "ELSEIF a==2", "ELSEIF a==3", "b=3", "ELSE"]),
        (4, ["IF a==1", "ELSEIF a==2", "ELSEIF a==3", "b=4"]),
    ],
)
def test_if_elseif_else(a, expected):
    program = run(f"a={a} " + BRANCHES)
    assert program.carried_out == [f"a={a}", *expected, "c=1", "END"] and program["b"] == a


def test_blocks_within_blocks():
    program = run("WHILE a<4 IF a%2 WHILE b<a b=b+1 LOOP ELSE c=c+10 ENDIF a=a+1 LOOP")
    assert (program["a"], program["b"], program["c"]) == (4, 3, 20)


SWITCH = "SWITCH a CASE 1 b=1 BREAK CASE -2 b=2 CASE 3 c=3 BREAK DEFAULT b=9 ENDS d=1 END"


@pytest.mark.parametrize(
    ("a", "expected"),
    [
        (1, ["SWITCH a", "CASE 1", "b=1", "BREAK"]),
        (-2, ["SWITCH a", "CASE 1", "CASE -2", "b=2", "c=3", "BREAK"]),  # no BREAK: continue after CASE -2, in no time
        (3, ["SWITCH a", "CASE 1", "CASE -2", "CASE 3", "c=3", "BREAK"]),
        (7, ["SWITCH a", "CASE 1", "CASE -2", "CASE 3", "b=9"]),
    ],
)
def test_switch_tests_its_cases_in_order(a, expected):
    assert run(f"a={a} " + SWITCH).carried_out == [f"a={a}", *expected, "d=1", "END"]


def test_switch_without_a_match_and_without_default():
    assert run("SWITCH 5 CASE 1 a=1 CASE 2 a=2 ENDS b=1").carried_out[-2:] == ["b=1", "(end)"]
    assert run("SWITCH 5 ENDS b=1")["b"] == 1


def test_default_in_the_middle_is_tried_last():
    assert run("a=2 SWITCH a DEFAULT b=9 BREAK CASE 2 b=2 ENDS")["b"] == 2


def test_switches_within_switches():
    text = "SWITCH a CASE 0 SWITCH b CASE 0 c=1 BREAK CASE 1 c=2 ENDS d=1 BREAK CASE 1 d=2 ENDS"
    program = run(text)
    assert (program["c"], program["d"]) == (1, 1)


def test_a_switch_in_an_interrupt_does_not_disturb_the_one_interrupted():
    program = Processor("a=3 SWITCH a CASE 1 b=1 BREAK CASE 3 b=3 ENDS END C1 SWITCH 1 CASE 1 c=1 ENDS RETURNF")
    program.run(2)  # the SWITCH has been executed
    program.i[state.RETURNS] = program.i[state.PC] << 2 | state.CALL_FAULT
    program.i[state.DEPTH], program.i[state.PC] = 1, program.program.labels[1]
    program.run()
    assert (program["b"], program["c"]) == (3, 1)


def test_break_leaves_while():
    program = run("WHILE 1 a=a+1 IF a==5 BREAK ENDIF LOOP b=1")
    assert (program["a"], program["b"]) == (5, 1)


def test_goto_and_gosub():
    program = run("GOTO7 a=1 C7 GOSUB200 b=1 END C200 c=1 RETURN")
    assert program.carried_out == ["GOTO7", "GOSUB200", "c=1", "RETURN", "b=1", "END"]


def test_the_label_that_stands_first_counts():
    assert run("GOTO1 C1 a=1 END C1 a=2")["a"] == 1


def test_an_unknown_label_sets_bs_and_the_program_goes_on():
    program = run("GOSUB5 GOTO6 a=1")
    assert program.performed == ["GOSUB5", "GOTO6"] and program["a"] == 1


def test_ten_return_addresses_fit():
    """An eleventh GOSUB sets Bs and has no effect."""
    labels = "".join(f" C{n} a={n} GOSUB{n + 1} RETURN" for n in range(1, 12))
    program = run(f"GOSUB1 b=a END{labels} C12 a=12 RETURN")
    assert (program["a"], program.i[state.BS]) == (10, 1) and program["b"] == 10
    assert program.i[state.DEPTH] == 0


@pytest.mark.parametrize("word", ["RETURN", "RETURNF", "RETURNI"])
def test_a_return_without_a_call_sets_bs_and_ends_the_program(word):
    program = run(f"a=1 {word} a=2")
    assert (program["a"], program.i[state.BS], program.i[state.PROGRAM]) == (1, 1, state.STOPPED)


def test_stack_discards_the_return_addresses():
    """7, F=64: STACK should immediately be followed by GOTO."""
    program = run("GOSUB1 a=1 END C1 STACK GOTO2 C2 b=1 RETURN")
    assert (program["a"], program["b"], program.i[state.BS]) == (0, 1, 1)


@pytest.mark.parametrize(("word", "called"), [("RETURNI", 0), ("STACK", 0), ("END", 0), ("RETURN", 1), ("RETURNF", 1)])
def test_what_lets_c2_be_called_again(word, called):
    program = Processor(f"{word} a=1")
    program.i[state.C2_CALLED] = 1
    program.run(1)
    assert program.i[state.C2_CALLED] == called


def test_wait():
    """After WAIT=n the next statement is executed n samples later."""
    program = run("a=1 WAIT=3 a=2 WAIT=0 a=3 WAIT=-5 a=4")
    assert program.carried_out == ["a=1", "WAIT=3", None, None, "a=2", "WAIT=0", "a=3", "WAIT=-5", "a=4", "(end)"]


def test_twait_holds_the_program_while_bt():
    program = Processor("TWAIT a=1 TWAIT a=2 END")
    program.i[state.BT] = 1
    program.run(5)
    assert program["a"] == 0
    program.i[state.BT] = 0
    program.run()
    assert program.carried_out == [None, None, None, None, None, "a=1", "TWAIT", "a=2", "END"]


def test_an_abandoned_assignment_keeps_the_old_value():
    program = run("a=5 a=1/0 b=7 b=2147483647+b c=1")
    assert (program["a"], program["b"], program["c"], program.i[state.BD]) == (5, 7, 1, 1)


def test_a_condition_that_has_no_value_does_not_hold():
    program = run("IF 1/0 a=1 ELSE a=2 ENDIF WHILE aw[200] b=1 LOOP SWITCH 1/0 CASE 0 c=1 BREAK DEFAULT c=2 ENDS d=1")
    assert [program[letter] for letter in "abcd"] == [2, 0, 2, 1]
    assert (program.i[state.BD], program.i[state.BU]) == (1, 1)


def test_values_in_an_array_are_truncated():
    """8.2: a value stored in ab[] is truncated to 8 bits, in aw[] to 16 bits, signed."""
    program = run("ab[0]=200 ab[1]=-1 aw[1]=40000 al[1]=-5 b=ab[0] c=aw[1] d=al[0] e=ab[7] ab[204]=1 aw[-1]=1")
    assert [program[letter] for letter in "bcde"] == [200 - 256, 40000 - 65536, -0x38000000 + 0x00FF9C40, -5]
    assert program.i[state.BU] == 1


def test_a_row_of_values():
    """1.1: `aw[0] 0 100 500 700.` sets consecutive elements; a list of example 3 has 6 values."""
    program = run("aw[0] 0 700 1100 2200 3300 2200. a=aw[5] b=aw[2] c=1 al[49] -7 8 9. ab[c+1] 3.")
    assert (program["a"], program["b"], program.i[state.BU]) == (2200, 1100, 1)
    assert program.v[state.DOUBLES + 49] == -7 and program.v[state.DOUBLES + 50] == 8
    assert program.v[state.DOUBLES] == 0x03BC  # aw[1] was 700 = 02BCh


def test_values_from_outside_are_fetched_before_the_statement():
    program = Processor("a=GETCHR+1 WHILE AINA1>b b=b+1 LOOP aw[GETCHR]=5 END")
    program.fetched = lambda text: {"a=GETCHR+1": 65, "WHILE AINA1>b": 2}.get(text, 3)
    program.run()
    assert (program["a"], program["b"], program.v[state.DOUBLES + 1]) == (66, 2, 5)
    assert program.carried_out == [
        "a=GETCHR+1", *["WHILE AINA1>b", "b=b+1", "LOOP"] * 2, "WHILE AINA1>b", "aw[GETCHR]=5", "END",
    ]  # fmt: skip


def test_what_python_performs():
    program = run('UAI G V=4*65536 PRINT("a b",a,#13) KGON nonsense Ra a=1')
    assert program.performed == ["UAI", "G", "V=4*65536", 'PRINT("a b",a,#13)', "KGON", "nonsense", "Ra"]
    assert program["a"] == 1


WORDS = [
    "a=a+1", "b=a*3", "c=c-b", "aw[a]=b", "ab[3]=a", "d=al[0]", "IF a<3", "ELSEIF b>2", "ELSE", "ENDIF", "WHILE a<9",
    "LOOP",
    "SWITCH a", "CASE 1", "CASE 2", "DEFAULT", "BREAK", "ENDS", "GOSUB1", "GOTO2", "C1", "C2", "RETURN", "RETURNI",
    "STACK",
    "WAIT=2", "TWAIT", "END", "e=a/b", "G", "rubbish", "f=@PE+CLK", "g=I+W", "aw[0] 1 2 3.",
]  # fmt: skip
programs = st.lists(st.sampled_from(WORDS), max_size=40).map(" ".join)


@settings(max_examples=50)
@given(programs)
def test_any_program_runs_and_never_leaves_its_code(text):
    program = Processor(text).run(200)
    assert 0 <= program.i[state.PC] < len(program.code) and 0 <= program.i[state.DEPTH] <= 10
    assert all(-(1 << 31) <= value < 1 << 31 for value in program.v)


@pytest.mark.skipif(not jit.available(), reason="Numba is not installed")
@settings(suppress_health_check=[HealthCheck.too_slow], deadline=None, max_examples=25)
@given(programs)
def test_compiled_and_plain_are_the_same(text):
    plain, compiled = (Whole(Rig(None), text, compiled=choice) for choice in (False, True))
    assert plain.run(200) == compiled.run(200) and (plain.i, plain.v) == (compiled.i, compiled.v)


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("IF n=3 a=1 ELSE a=2 ENDIF", [2, 0, 0]),
        ("IF n=3 a=1 ELSEIF n=4 a=2 ELSEIF 1 a=3 ELSE a=4 ENDIF", [3, 0, 0]),
        ("IF a=1 ENDIF b=1", [0, 1, 0]),  # "a=1" after IF is not an expression
        ("IF 0 a=1 ELSEIF n= a=2 ENDIF b=1", [0, 1, 0]),
        ("WHILE n=3 a=1 LOOP b=1", [0, 1, 0]),
        ("SWITCH n=3 CASE 0 a=1 BREAK DEFAULT a=2 ENDS b=1", [2, 1, 0]),
        ("n=4 SWITCH n CASE n+0 a=1 BREAK CASE 4 b=1 BREAK DEFAULT c=1 ENDS", [0, 1, 0]),
        ("n=9 SWITCH n CASE 4 a=1 BREAK CASE n b=1 BREAK DEFAULT c=1 ENDS", [0, 0, 1]),
        ("SWITCH n CASE n+3 a=1 ENDS b=1", [0, 1, 0]),
    ],
)
@pytest.mark.parametrize("compiled", [
    False, pytest.param(True, marks=pytest.mark.skipif(not jit.available(), reason="Numba is not installed"))
])  # fmt: skip
def test_a_condition_that_is_not_an_expression_sets_bs_and_is_false(text, values, compiled):
    """Base 8: `IF n=3` is not a comparison, so the condition is false; the structure of the blocks is kept."""
    whole = Whole(Rig(None), text, compiled=compiled)
    assert set(whole.run(1000)) == {ALL_DONE} and list(whole.v[:3]) == values
    assert whole.i[state.BS] == 1


def test_a_case_that_is_no_constant_sets_bs_only_when_it_is_tested():
    program = run("SWITCH n CASE 0 a=1 BREAK CASE n+3 b=1 BREAK ENDS")
    assert (program["a"], program["b"], program.i[state.BS]) == (1, 0, 0)
