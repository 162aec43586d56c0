"""The stored program as a whole: invalid statements, labels, places, the manual's examples (4.3, 9)."""

import pytest

from axistwin.controllers.smartmotor.kernel import state
from axistwin.controllers.smartmotor.language.program import Program

from .rig import Processor

FAULT_HANDLING = """
ZS          ' all flags
F=33        ' C1 on a fault, decelerate
MP
A=8*25
V=537*600
P=2000*10
G
END
-----
C1
  IF Be==1
    pp=@PE
    GOSUB200
  Ze
  ENDIF
RETURNF
*****
C200
  PRINT("error ",pp,#13)
RETURN
*****
"""
"""A program as the sample of 4.3, with its rules between the parts."""


def broken(text):
    """Return text and message of each statement that sets Bs."""
    return [(s.text, s.problem.message) for s in Program.compile(text).statements if s.problem is not None]


def test_the_sample_of_4_3():
    program = Processor(FAULT_HANDLING).run()
    assert program.carried_out == ["ZS", "F=33", "MP", "A=8*25", "V=537*600", "P=2000*10", "G", "END"]
    assert set(program.program.labels) == {1, 200}


def test_its_fault_routine():
    program = Processor(FAULT_HANDLING)
    program.i[state.BE], program.i[state.COMMANDED] = 1, 1500 << 16
    program.i[state.PC] = program.program.labels[1]
    program.i[state.RETURNS], program.i[state.DEPTH] = -1 << 2 | state.CALL_FAULT, 1
    program.run()
    assert program["pp"] == 1500
    assert program.carried_out == [
        "IF Be==1", "pp=@PE", "GOSUB200", 'PRINT("error ",pp,#13)', "RETURN", "Ze", "RETURNF",
    ]  # fmt: skip
    assert program.i[state.PROGRAM] == state.STOPPED


def test_rules_between_parts_of_a_program_set_bs_when_they_are_reached():
    """The lines of dashes and stars in the manual's sample set Bs when they are reached, and not before."""
    assert [text for text, _ in broken(FAULT_HANDLING)] == ["-----", "*****", "*****"]
    assert Processor("***** a=1").run().performed == ["*****"]


def test_example_5_of_chapter_9():
    start = "b=10000 F=144 BASE=b SIZE=10 D=0 MC2 BASE=1 G "
    loop = "WHILE 1 IF UAI b=b+10 ENDIF IF UBI b=b-10 ENDIF BASE=b MC2 CI WAIT=4000 LOOP END"
    program = Processor(start + loop)
    program.i[state.PINS] = 1
    program.run(4000 + 40)
    assert program["b"] == 10020
    assert program.performed == [
        "F=144", "BASE=b", "SIZE=10", "D=0", "MC2", "BASE=1", "G", *["BASE=b", "MC2", "CI"] * 2,
    ]  # fmt: skip


@pytest.mark.parametrize(("text", "expected"), [
    ("IF a b=1", [("IF a", "IF: ENDIF is missing")]),
    ("WHILE a b=1 BREAK", [("WHILE a", "WHILE: LOOP is missing"), ("BREAK", "BREAK: LOOP is missing")]),
    ("ENDIF", [("ENDIF", "ENDIF: no IF before this statement")]),
    ("LOOP", [("LOOP", "LOOP: no WHILE before this statement")]),
    ("ELSE", [("ELSE", "ELSE: no IF before this statement")]),
    ("CASE 1", [("CASE 1", "CASE: no SWITCH before this statement")]),
    ("BREAK", [("BREAK", "BREAK: it leaves a SWITCH or a WHILE, and stands in none")]),
    (
        "IF a WHILE b ENDIF LOOP",
        [("IF a", "IF: ENDIF is missing"),
         ("ENDIF", "ENDIF: no open IF before this statement; WHILE b has not ended")],
    ),
    ("IF a ELSE ELSE ENDIF", [("ELSE", "ELSE: it stands behind ELSE")]),
    ("IF a ELSE ELSEIF b ENDIF", [("ELSEIF b", "ELSEIF: it stands behind ELSE")]),
    ("SWITCH a DEFAULT DEFAULT ENDS", [("DEFAULT", "DEFAULT: it stands behind DEFAULT")])])  # fmt: skip
def test_parts_of_blocks_without_the_others(text, expected):
    assert broken(text) == expected


def test_a_broken_block_is_passed_over():
    program = Processor("IF 0 a=1 WHILE 0 b=1 c=1").run()
    assert program.performed == ["IF 0", "WHILE 0"] and [program[letter] for letter in "abc"] == [1, 1, 1]


def test_places():
    program = Program.compile(b"a=1 b=2\r\n  ' note\r\n\tIF a\nc=1\rENDIF")
    assert [place[:2] for place in program.places] == [(1, 1), (1, 5), (3, 2), (4, 1), (5, 1)]


def test_an_empty_program():
    assert Program.compile(" ' nothing\n").statements == ()
    assert Processor("").run().carried_out == ["(end)"]


def test_the_largest_program():
    """A program of 32 KiB in nested blocks can be compiled."""
    text = "IF a\n" * 3000 + "b=1\n" + "ENDIF\n" * 3000
    assert (Processor("a=1\n" + text).run(5000)["b"], broken(text)) == (1, [])
