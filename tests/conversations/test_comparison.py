"""A recording compared with a twin, up to the end of the recording."""

import json

import click
import pytest
from click.testing import CliRunner

from axistwin import Bench
from axistwin.bench.talk.comparison import Comparison, compare, recorded_times
from axistwin.bench.talk.conversation import parse, write
from axistwin.bench.talk.recorder import recording
from axistwin.cli.program import axistwin
from axistwin.core.errors import ProgramError, UsageError
from axistwin.core.units import MS, S

from ..told import raises

READY = "+1.5\n> (\n< U\\r\n= clock 1.503229167\n> U61\\r\n+1.2\n"


def compared(text: str, model: str = "if1", **options) -> Comparison:
    bench = Bench()
    bench.add(model, **options)
    return compare(parse(text, model=model), bench)


def told(comparison: Comparison) -> list[tuple[str, str]]:
    return [(act.expected, act.got) for act in comparison.different]


def test_what_a_twin_has_said_it_says_again_at_the_same_time():
    bench = Bench()
    if1 = bench.add("if1")
    with recording(bench) as recorder:
        for words, seconds in (("", 1.5), ("(", 0.1), ("U61\r", 1.2), ("X1000$\r", 0.5), ("E\r", 3), ("N\r", 0.1)):
            if1.serial.write(words.encode())
            bench.run(seconds)
    comparison = compared(write(recorder.conversation()))
    assert comparison.different == () and (comparison.median_ns, comparison.worst.later_ns) == (0, 0)
    assert len(comparison.timed) == 3


def test_hardware_that_is_slower_is_measured_from_what_the_host_did_last():
    comparison = compared(READY + "> E\\r\n< C\\r\n= clock 2.728229167\n+1\n> N\\r\n< 0\\r\n= clock 3.738229167\n")
    first, second, third = comparison.acts
    assert (first.later_ns, second.later_ns) == (0, second.twin_ns - 25 * MS)
    assert second.twin_ns == 4_958_333  # one strobe and two characters later
    assert (second.hardware_ns, third.hardware_ns) == (25 * MS, 10 * MS) and comparison.worst is second
    assert (second.line, second.after) == (8, r"> E\r")


def test_an_answer_that_is_another_one_and_the_conversation_goes_on():
    comparison = compared(READY + "> N\\r\n< 17\\r\n> E\\r\n< C\\r\n")
    assert told(comparison) == [(r"17\r", r"0\r")] and comparison.acts[-1].same


def test_an_answer_that_does_not_come():
    comparison = compared(READY + "> E\\r\n< C\\r\n< C\\r\n> N\\r\n< 0\\r\n")
    assert told(comparison) == [(r"C\r", "")] and comparison.different[0].twin_ns is None


def test_words_before_the_answer_that_nobody_expected():
    assert told(compared(READY + "> E\\r\n> N\\r\n< 0\\r\n> K\\r\n< 0\\r\n")) == [(r"0\r", r"C\r0\r")]


def test_words_that_come_at_the_end():
    comparison = compared(READY + "> E\\r\n")
    assert told(comparison) == [("", r"C\r")] and comparison.different[0].line == 0


@pytest.mark.parametrize(("hardware_s", "same"), [(29, True), (28, True), (20, False)])
def test_the_twin_has_as_long_as_the_hardware_and_some_patience(hardware_s, same):
    """A sequence reports after 29 s; the twin's report may come later than the hardware's, by the patience."""
    text = READY + "> :P0,99:=29,1:%:$\\r\n" + f"< %\\r\n= clock {2.703229167 + hardware_s}\n"
    assert compared(text).acts[-1].same is same


def test_control_lines_are_compared():
    text = "! power off\n= dtr low\n= clock 0.05\n"
    assert [(act.expected, act.same) for act in compared("+1.5\n" + text).acts] == [("dtr low", True)]
    assert told(compared("+1.5\n= dtr low\n")) == [("dtr low", "")]


def test_a_twin_without_control_lines_minds_none():
    comparison = compared("; model: smartmotor\n+1\n! dtr low\n= dtr low\n> RP\\r\n< 0\\r\n", "smartmotor")
    assert comparison.different == ()


def test_boards_on_a_bus_are_compared_too():
    comparison = compared("; model: 1811\n+1.1\n> 83\n< 83 00 00 00 00 00 01\n", "1811")
    assert [act.same for act in comparison.acts] == [False]


def test_when_things_happened_in_the_recording():
    text = "+1\n> E\\r\n+0.5\n< C\\r\n= clock 2.25\n+1\n> E\\r\n< C\\r\n+1\n> E\\r\n"
    times = list(recorded_times(parse(text).acts))
    assert times == [S, S, 3 * S // 2, 9 * S // 4, 9 * S // 4, 13 * S // 4, 13 * S // 4, None, None, None]


# The command


@pytest.fixture
def replay(tmp_path):
    def replay(text, *arguments):
        (tmp_path / "a.talk").write_text(text)
        done = CliRunner().invoke(axistwin, ["replay", str(tmp_path / "a.talk"), *arguments], standalone_mode=False)
        if done.exception:
            raise done.exception
        return done.return_value, done.stdout

    return replay


def test_the_table(replay):
    code, shown = replay("; model: if1\n" + READY + "> N\\r\n< 17\\r\n= clock 2.709\n")
    assert code == 1
    assert shown.splitlines() == [
        "  line   hardware ms       twin ms   later by ms",
        r"     4         3.229         3.229         0.000  > (  < U\r",
        r"     9         5.771         4.958             -  > N\r  differs", r"      hardware  17\r",
        r"          twin  0\r", "                ^", "2 acts of the controller, 1 different in bytes",
        "the twin is later by 0.000 ms (median), at worst by 0.000 ms in line 4",
    ]  # fmt: skip


def test_brief_is_what_differs(replay):
    code, shown = replay(READY + "> E\\r\n< C\\r\n", "--model", "if1", "--brief")
    assert code == 0
    assert shown.startswith("2 acts of the controller, none different in bytes\n")


def test_json(replay):
    code, shown = replay(READY, "--model", "if1", "--json")
    (act,) = json.loads(shown)["acts"]
    assert (code, act["hardware"], act["twin"], act["later_ns"]) == (0, r"U\r", r"U\r", 0)


def test_how_long_it_has_been_on(replay):
    text = "> (\n< U\\r\n"
    assert replay("; on-for: 1.5\n" + text, "--model", "if1")[0] == 0
    assert replay(text, "--model", "if1", "--on-for", "1.5")[0] == 0 and replay(text, "--model", "if1")[0] == 1
    with pytest.raises(ProgramError, match="invalid value 'soon' of the header on-for: expected seconds"):
        replay("; on-for: soon\n" + text, "--model", "if1")


def test_it_must_be_said_what_answers(replay):
    raises(UsageError, "contains no model", replay, "> (\n")


# Kinds of recordings


def test_a_line_that_was_so_all_the_time_is_right():
    comparison = compared("+1.5\n= rts low\n= dtr high\n+1\n> (\n< U\\r\n= clock 2.51\n")
    assert comparison.different == () and [act.twin_ns for act in comparison.acts[:2]] == [None, None]


def test_a_pulse_that_the_recording_has_missed_is_no_change_that_it_has_seen():
    """RTS is on during a transmission only; a recording that samples RTS 100 times per second may miss it."""
    text = READY + "> E\\r\n< C\\r\n= clock 2.71\n+0.1\n> N\\r\n+0.002\n= rts high\n< 0\\r\n= clock 2.83\n= rts low\n"
    comparison = compared(text)
    assert comparison.different == () and next(act for act in comparison.acts if act.expected == "rts high").twin_ns > 0


@pytest.mark.parametrize("time", ["soon", "nan", "inf"])
def test_a_clock_that_is_none_is_told_with_its_line(time):
    with pytest.raises(ProgramError, match=rf"6: invalid time '{time}': expected seconds"):
        compared("+1.5\n> (\n< U\\r\n= clock 1.51\n+1\n= clock " + time + "\n")


@pytest.mark.parametrize("option", ["--on-for", "--patience"])
@pytest.mark.parametrize("seconds", ["nan", "inf", "1e300", "-1"])
def test_seconds_that_are_none(replay, option, seconds):
    raises(click.BadParameter, "", replay, READY, "--model", "if1", option, seconds)


@pytest.mark.parametrize(("recording", "model", "words"), [
    ("; model: if1\n; line: 9600 8N2\n" + READY, "1811", "1811: expected a controller on a serial line, e.g. if1"),
    ("; model: 1811\n> 50\n", "if2", "if2: expected a controller on a bus, e.g. 1811")])  # fmt: skip
def test_what_was_said_on_a_line_is_not_for_a_bus(replay, recording, model, words):
    with pytest.raises(UsageError, match=rf"a\.talk cannot run on {words}"):
        replay(recording, "--model", model)


def test_a_recording_of_one_model_may_be_replayed_as_another(replay):
    assert replay("; model: if1\n" + READY, "--model", "if2", "--brief")[0] == 0
