"""Playing conversations: passing of time, and the text of the first difference."""

import pytest

from axistwin import Bench
from axistwin.bench.talk.conversation import parse
from axistwin.bench.talk.player import Difference, play
from axistwin.core.errors import ProgramError


def said(bench: Bench, text: str) -> str:
    return str(play(parse(text, "a.talk"), bench) or "")


def test_an_answer_is_waited_for_and_not_a_nanosecond_longer(bench, if1):
    heard_ns = []
    if1.serial.subscribe_received(lambda byte, _: heard_ns.append(bench.now))
    assert said(bench, "> E\\r\n< C\\r\n") == "" and bench.now == heard_ns[-1]


def test_the_clock_tells_exactly_when(bench):
    bench.add("if1")
    assert said(bench, "+1.5\n> (\n< U\\r\n= clock 1.503229167\n") == ""


def test_an_answer_that_has_come_already_takes_no_time(bench, if1):
    end = bench.seconds + 1
    assert said(bench, f"> E\\r\n+1\n< C\\r\n= clock {end:.9f}\n") == ""


def test_another_answer_is_shown_whole_with_a_caret(bench, if1):
    difference = play(parse("; x\n> N\\r\n< 527\\r\n", "a.talk"), bench)
    assert isinstance(difference, Difference)
    assert (difference.line, difference.expected, difference.got) == (3, r"527\r", r"0\r")
    assert str(difference).splitlines() == [
        f"a.talk:3: at {difference.time_ns / 1e9:.9f} s the reply is different", r"  expected  527\r",
        r"  got       0\r", "            ^",
    ]  # fmt: skip


def test_no_answer_is_a_difference_after_some_patience(bench, if1):
    began = bench.seconds
    assert "the reply is incomplete after 3 s" in said(bench, "; patience: 3\n> X\\r\n< C\\r\n")
    assert bench.seconds == began + 3


def test_part_of_an_answer(bench, if1):
    shown = said(bench, "> N\\r\n< 0\\r\\n\n")
    assert "reply is incomplete" in shown and shown.splitlines()[-1] == "               ^"


def test_a_bare_mark_is_silence(bench, if1):
    assert said(bench, "> X100$\\r\n+0.5\n<\n") == "" and "unexpected reply" in said(bench, "> E\\r\n+0.5\n<\n")


def test_what_is_left_over_at_the_end_is_a_difference(bench, if1):
    shown = said(bench, "> E\\r\n+0.5\n")
    assert shown.startswith("a.talk:2: ") and "unexpected reply" in shown
    assert r"got       C\r" in shown


def test_the_last_line_of_the_host_is_sent(bench, if1):
    assert said(bench, "> X100@100$\\r\n> E\\r\n") == "" and not if1.serial.sending
    bench.run(1.5)
    assert if1.axes["X"].position == 100


def test_the_last_command_to_a_board_is_sent(bench):
    board = bench.add("1811")
    assert said(bench, "; model: 1811\n+1.5\n> 0C 01\n> 0C 02\n") == ""
    bench.run(0.1)
    assert not board.pins["output1"].level and not board.pins["output2"].level


@pytest.mark.parametrize(("line", "good"), [
    ("= X.position 100", True), ("= X.position 99", False), ("= X.pulses 100", True), ("= X.velocity 0", True),
    ("= Y.position 0", True), ("= output1 low", True), ("= output1 high", False), ("= input1 off", True),
    ("= dtr on", True), ("= limit_plus high", True)])  # fmt: skip
def test_assertions(bench, if1, line, good):
    assert (said(bench, f"> X100$\\r\n+1\n{line}\n") == "") is good


def test_a_number_is_compared_to_as_many_decimals_as_are_written(bench, if1):
    text = "> @503\\r\n> X1000Y$\\r\n+0.5\n= X.velocity {}\n> #\\r\n"
    assert said(bench, text.format("500")) == "" and "X.velocity is different" in said(bench, text.format("500.1"))


def test_a_wrong_value_is_shown(bench, if1):
    shown = said(bench, "> X100$\\r\n+1\n= X.position 1000\n")
    assert shown.splitlines()[1:] == ["  expected  1000", "  got       100", "               ^"]


def test_what_somebody_does_to_the_machine(bench, if1):
    assert said(bench, "! input1 high\n= input1 high\n! input1 release\n= input1 low\n") == ""
    assert said(bench, "! X.jam on\n> X100$\\r\n+1\n= X.pulses 100\n= X.position 0\n! X.jam off\n") == ""
    assert said(bench, "! power off\n> E\\r\n+1\n<\n! power on\n+1.5\n> (\n< U\\r\n") == ""


def test_the_hosts_lines_and_format(bench, if1):
    assert said(bench, "! dtr low\n! rts low\n> E\\r\n+1\n<\n! dtr high\n! rts high\n< C\\r\n") == ""
    assert said(bench, "! line 1200 7E1\n") == ""
    assert str(if1.serial.host.format) == "1200 7E1"


def test_an_encoder(bench):
    bench.add("if1", X={"encoder": {"counts_per_rev": 4000, "pulses_per_rev": 400}})
    assert said(bench, "! X.push 7\n= X.encoder 7\n") == ""


def test_several_controllers_are_told_apart_by_name(bench):
    bench.add("if1", "left")
    bench.add("if1", "right")
    assert said(bench, "+1.5\nleft: > (\nleft: < U\\r\nright: <\nright: ! input1 high\nleft: = input1 low\n") == ""
    with pytest.raises(
        ProgramError,
        match=r"a\.talk:1: missing controller name before `> E\\r`: expected one of left, right, e\.g\. `left: > E\\r`",
    ):
        said(bench, "> E\\r\n")


@pytest.mark.parametrize(("line", "words"), [
    ("! input9 high", "unknown name 'input9'"), ("! input1 up", "invalid level"),
    ("= X.place 3", "unknown name 'X.place'"), ("= X.position far", "not a number"),
    ("= X.position nan", "not a number"), ("= X.encoder 3", "no encoder"),
    ("! line fast", "invalid baud rate or character format"), ("middle: > E", "unknown controller 'middle'")
])  # fmt: skip
def test_what_the_bench_does_not_have_is_told_before_anything_is_done(bench, if1, line, words):
    began_ns = bench.now
    with pytest.raises(ProgramError, match=words) as caught:
        said(bench, f"> X100$\\r\n+5\n{line}\n")
    assert str(caught.value).startswith("a.talk:3: ") and bench.now == began_ns
    assert not if1.axes["X"].moving


def test_a_patience_that_is_no_number(bench, if1):
    with pytest.raises(ProgramError, match="invalid value 'long' of the header patience"):
        said(bench, "; patience: long\n")


def test_a_fault_that_cannot_begin_or_be_mended_any_more_is_told_with_its_line(bench, if1):
    with pytest.raises(ProgramError, match=r"^a\.talk:3: unknown fault 'jam': known faults are none$"):
        said(bench, "+1\n\n! mend jam\n")
    with pytest.raises(ProgramError, match=r"^a\.talk:1: the start time at=0\.5 is in the past: expected "):
        said(bench, "! fault lose 3 at=0.5\n")


def test_a_fault_whose_name_has_a_blank(bench, if1):
    said(bench, '! fault stuck input1 high name="a nut"\n= input1 high\n! mend "a nut"\n= input1 low\n')
    assert not any(fault.on for fault in bench.faults)
