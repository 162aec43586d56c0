"""The checker of the IF1 and IF2: without a run, it finds what the interface would refuse."""

import re
import string

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench
from axistwin.bench import product
from axistwin.controllers.diagnostics import Diagnostic, Sent, Session

from .talking import ask, ready


def sent(text: str, initialised: bool) -> Session:
    """Return characters with line and column; `|` in the text is an end of line that is not sent."""
    places = [(line, column) for line, words in enumerate(text.split("|"), 1) for column in range(1, len(words) + 1)]
    characters = text.replace("|", "").encode("latin-1")
    return Session(tuple(Sent(byte, *place) for byte, place in zip(characters, places, strict=True)), initialised)


def check(*lines: str, model: str = "if1") -> list[Diagnostic]:
    """Return the diagnostics of command lines, each ended by <CR>."""
    return product(model).check([sent("|".join(f"{line}\r" for line in lines), True)])


def shown(*lines: str, model: str = "if1") -> list[str]:
    return [f"{d.line}:{d.column} {d.severity}: {d.message}" for d in check(*lines, model=model)]


@pytest.mark.parametrize("lines", [
    ("X 1000 @ 200 $", "X-$", "X+Y-$", "X @ 5000 G $", "#", "K", "F"), (">2", "@30000", "X100$", ">1", "@2000", "X$"),
    ("B-20", "X100B$", "S13R2$", "P4,20$", "H1L3X1000@200S3$"), (":S1:X400@100:Y:=5,2:R1:Z50:=24,1:$", ":$", "::$"),
    (":X@1000G:H1A:$", ":X@1000G:H3A=2,1:$", ":X100:P0,50:$"), (":Y400@200:%:Y-:$", "X100$", "%"),
    ("X2000/Y500@1000$", "XY1000/Z50@800$", "YZ/X$"), (">1<10^15@4800", "D5", "[", "K", "E", "]", "X100$"),
    ("", "   ", "x#", "rubbish#")])  # fmt: skip
def test_what_the_manual_allows_is_allowed(lines):
    assert shown(*lines) == []


WRONG = {
    ("x1000$",): "1:1 error: unknown character 'x': commands are upper case",
    ("X10?$",): "1:4 error: unknown character '?'",
    ("X100mm$",): "1:5 error: unknown characters 'mm'",
    ("S1X100$",): "1:3 error: X (X clock) cannot follow here: the order is H L, move, S R or P; H L A =",
    ("R1S2$",): "1:3 error: S (set output high) cannot follow here: the order is H L, move, S R or P; H L A =",
    ("S1P2$",): "1:3 error: P (pulse output) cannot follow here: the order is H L, move, S R or P; H L A =",
    ("H1$",): "1:1 error: H and L need a move in the same message, e.g. H1X100$",
    ("X$Y$",): "1:2 error: $ (index, run and sequence start) is not valid here",
    ("X100 E",): "1:6 error: E (busy) must be the only command in its message",
    ("B20",): "1:2 error: 20 belongs to no command: B (backlash) takes [signed distance -255…255 steps]",
    ("@",): "1:2 error: @ (speed data) needs speed 1…99999 steps/s",
    (">5",): "1:2 error: 5 is out of range: range 1…4",
    ("<41",): "1:2 error: 41 is out of range: start/stop speed 1…40 x 100 steps/s",
    ("^0",): "1:2 error: 0 is out of range: acceleration 1…500 x 1000 steps/s²",
    ("P4,100$",): "1:4 error: 100 is out of range: [length 1…99 x 10 ms]",
    ("H4X$",): "1:2 error: 4 is out of range: inputs 1…3",
    ("S6$",): "1:2 error: 6 is out of range: outputs 1…5",
    ("D26",): "1:2 error: 26 is out of range: delay 0…25 x 10 ms",
    ("X 1000000000$",): "1:3 error: 1000000000 is out of range: [distance 0…999999999 steps]",
    ("U61",): "1:1 error: U (RS232 format, ended by <CR>) is for initialisation only",
    (":" + "X:" * 64 + "$",): "1:128 error: 64 steps: a sequence has 63 at most",
    (":X100:=2,3:$",): "1:7 error: repeat from step 3: expected a step from 1 to 2",
    (":X100:=2:$",): "1:8 error: = (repeat) needs times 0…255 first step 1…63",
    (":X100:>2:$",): "1:7 error: > (select speed range) is not allowed in a sequence",
    (":^5X100:$",): "1:2 error: ^ (acceleration rate data) is not allowed in a sequence",
    (":X100",): "1:6 error: a sequence ends in :$",
    (":X100::Y:$",): "1:7 error: a step is missing between two colons",
    ("=2,1$",): "1:1 error: = (repeat) is not allowed in a direct message",
    ("@25001",): "1:1 error: speed 25001 is above 25000 steps/s, the maximum of range 1",
    (">4@4001",): "1:3 error: speed 4001 is above 4000 steps/s, the maximum of range 4",
    (">3", "@90000", ">2", "X100$"): "4:1 error: speed 90000 is above 50000 steps/s, the maximum of range 2 "
    "(speed from line 2, range from line 3)",
    (":X100@26000:$",): "1:6 error: speed 26000 is above 25000 steps/s, the maximum of range 1",
    (
        "@10001",
        "X200/Y100$",
    ): "2:1 error: in linear interpolation, speed 10001 is above 10000 steps/s (speed from line 1)",
    ("^4X200/Y100$",): "1:1 error: in linear interpolation, acceleration 4000 is below 5000 steps/s²",
    ("X65536/Y100$",): "1:1 error: in linear interpolation, major index 65536 is above 65535 steps",
    (">2", "X200/Y100$"): "2:1 error: in linear interpolation, speed range 2 is not 1 (range from line 1)",
    ("X200/Y300$",): "1:6 error: in linear interpolation, minor index 300 is longer than the major one, 200",
    (":X200/Y100:Z@12000:=1,1:$",): "1:2 error: in linear interpolation, speed 12000 is above 10000 steps/s",
    ("%",): "1:1 error: % gives control back to a sequence, but no sequence has given control to the host",
    ("X@500G$", "X$"): "2:1 warning: nothing moves: the distance is 0 (distance from line 1)",
    ("X1000G$",): "1:1 warning: G runs until stopped: the distance is not used and becomes 0",
    ("S2",): "1:2 warning: without $ at its end this message starts nothing",
    ("X-",): "1:2 warning: without $ at its end this message starts nothing",
    ("X8000@4000",): "1:10 warning: without $ this message starts no move, and no later message does",
    (
        "X8000", "$", "Y50", "S1$", "Y60",
    ): "5:3 warning: without $ this message starts no move, and no later message does",
    (":$",): "1:1 warning: no stored sequence to run again: expected a sequence before it, e.g. :X100:$",
    (":X100:=0,1:Y:$",): "1:12 warning: never reached: step 2 repeats for ever",
    (":X100:X@500G:Y5:$",): "1:14 warning: the run of step 2 continues, and the move of this step waits for its end: "
    "A stops the run",
    ("[", "X100$", "]"): "2:1 warning: ignored: locked in line 1, only status requests and ] are obeyed",
}  # fmt: skip


@pytest.mark.parametrize(("lines", "message"), WRONG.items(), ids=lambda value: value[-1][:30] if value else "")
def test_each_problem_is_reported_with_its_place(lines, message):
    assert shown(*lines) == [message]


def test_a_chapter_is_named():
    assert [d.chapter for d in check("@99999")] == ["Speed"]
    assert [d.chapter for d in check("X1/Y2$")] == ["Constraints in linear interpolation mode"]


def test_what_is_refused_is_not_kept():
    assert shown("@25001", "X100$") == ["1:1 error: speed 25001 is above 25000 steps/s, the maximum of range 1"]
    assert len(check("X70000/Y1$", "X/Y$")) == 2


def test_a_sequence_that_no_longer_fits_when_it_is_run_again():
    (said,) = shown(":X200/Y100:$", "^4", ":$")
    assert said.startswith("3:1 error: step 1: in linear interpolation, acceleration 4000 is below 5000 steps/s²")
    assert said.endswith("(acceleration from line 2)")


def test_the_initialisation_in_a_conversation():
    session = sent("E\r|(|U60\r|U|62\r|X100$\r|Y100$", initialised=False)
    said = [f"{d.line}:{d.column} {d.severity}: {d.message}" for d in product("if1").check([session])]
    assert said == [
        "1:1 warning: characters before ( are ignored, because the baud rate is unknown",
        "3:1 error: invalid data format 'U60': U or V, frame 1 to 8, parity 1 to 9; U ends in <CR>, V in <LF>",
        "7:1 warning: this message has no end: <CR> is missing",
    ]


def test_a_bracket_breaks_into_a_locked_interface():
    """Breaking in: `(` and the erase command or a data format, without a power cycle."""
    erased = sent("(|U61\r|[\r|X100$\r|(*|U61\r|X100$\r", initialised=False)
    assert [d.line for d in product("if1").check([erased])] == [4]
    still_locked = sent("(|U61\r|[\r|(|U60\r|U62\r|X100$\r", initialised=False)
    assert [d.line for d in product("if1").check([still_locked])] == [5, 7]


def test_an_interpolated_run_loses_both_index_lengths():
    """Run mode: "the data used in a previous index will be lost"."""
    assert shown("X2000/Y500@400G$", "#", "X$") == [
        "3:1 warning: nothing moves: the distance is 0 (distance from line 1)"
    ]
    assert [line[:3] for line in shown(":X200/Y50@400G:H1A:X/Y:$")] == ["1:2"]


def test_v_messages_end_in_lf_and_the_cr_before_it_is_nothing():
    session = sent("(|V61\r\n|X100\r$\r\n|x\n", initialised=False)
    assert [d.line for d in product("if1").check([session])] == [4]


def test_a_format_that_is_never_ended():
    assert [d.message for d in product("if1").check([sent("(V61\r", False)])] == ["the data format message has no end"]


def test_what_an_if2_keeps_locked_when_it_is_switched_off():
    first = sent(":X5@500:$\r|[\r", initialised=True)
    locked = sent("X1$\r|]\r|:$\r", initialised=False)
    assert [d.message for d in product("if2").check([first, locked])] == [
        "ignored: locked in line 2, only status requests and ] are obeyed"
    ]
    assert [d.message for d in product("if1").check([first, locked])] == [
        "characters before ( are ignored, because the baud rate is unknown"
    ]
    again = sent("(U62\rK\r", initialised=False)
    assert product("if2").check([first, again]) == []
    erased = sent("(*U61\r:$\r", initialised=False)
    assert [d.message for d in product("if2").check([first, erased])] == [
        "no stored sequence to run again: expected a sequence before it, e.g. :X100:$"
    ]


WORDS = st.sampled_from(
    [*"XYZG$@<>^BDPSRHL/:=A,+- EKq?123", "X100", "@500", "@30000", ">2", ">1", "^4", "^10", "X2000/Y500", "P1,5", "B-5"]
)
MESSAGE = st.lists(WORDS, max_size=6).map("".join)
DIRECT = MESSAGE.filter(lambda text: not text.replace(" ", "").startswith(":"))


@settings(max_examples=60)
@given(st.lists(st.tuples(DIRECT, st.booleans()), max_size=6))
def test_the_interface_refuses_what_the_checker_calls_an_error(messages):
    """The messages are checked in order, with the parameters that earlier messages have set."""
    lines = [text + "$" * start for text, start in messages]
    errors = {d.line for d in check(*lines) if d.severity == "error"}
    bench = Bench()
    if1 = ready(bench)
    for number, line in enumerate(lines, start=1):
        ask(bench, if1, line, seconds=1.3)
        ask(bench, if1, "#", seconds=5.0)
        refused = ask(bench, if1, "F") != b"0\r"
        assert refused is (number in errors), line


@settings(max_examples=60)
@given(st.lists(MESSAGE, max_size=5))
def test_the_interface_refuses_sequences_that_the_checker_calls_wrong(steps):
    line = f":{':'.join(steps)}:$"
    found = check(line)
    bench = Bench()
    if1 = ready(bench)
    ask(bench, if1, line, seconds=1.3)
    refused = ask(bench, if1, "F") != b"0\r"
    if not found:
        assert not refused
    if refused:
        assert any(d.severity == "error" for d in found)


@settings(max_examples=200)
@given(st.lists(st.text(string.printable + "\x00\x80\xff", max_size=30), max_size=4), st.booleans())
def test_any_text_is_survived(texts, initialised):
    found = product("if2").check([sent(text.replace("|", ""), initialised) for text in texts])
    assert found == sorted(set(found)) and all(re.fullmatch(r"[^\n\r]+", d.message) for d in found)
