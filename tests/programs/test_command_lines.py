"""Command lines of an IF1."""

from pathlib import Path

import pytest

from axistwin import Bench
from axistwin.bench import Do, Say, Wait
from axistwin.bench.programs.command_lines import read_command_lines, send_lines
from axistwin.bench.programs.running import Outcome, load
from axistwin.core.errors import ProgramError, UsageError
from axistwin.core.units import S
from axistwin.scenes.reports.run_record import RunRecord, recording_run

from ..told import raises


def run(tmp_path: Path, text: str, until_s: float | None = None, **options) -> tuple[RunRecord, Outcome]:
    file = tmp_path / "a.if1"
    file.write_text(text)
    bench = Bench()
    bench.add("if1", **options)
    with recording_run(bench) as record:
        outcome = load(file).perform(bench, None if until_s is None else int(until_s * S))
    return record, outcome


def heard(record: RunRecord) -> list[bytes]:
    return [bytes(message.data) for message in record.said if not message.by_host]


def test_lines_and_comments():
    acts = list(read_command_lines("; title\n\nX 1000 $ ; go\n+2.5\n! input1 high\n"))
    assert acts == [Say(b"X 1000 $"), Wait(2_500_000_000), Do("input1", "high")]
    assert [act.line for act in acts] == [3, 4, 5]


def test_columns_are_kept():
    assert next(read_command_lines("  X1$")) == Say(b"  X1$")


def test_a_character_that_is_not_ascii_is_refused():
    raises(ProgramError, "a.if1:2:5: 'é'", list, read_command_lines("X1$\nX10 é", "a.if1"))


def test_each_line_is_sent_when_the_previous_line_is_finished(tmp_path):
    record, outcome = run(tmp_path, "X1000$\nY500$\nN\n")
    assert heard(record) == [b"U\r", b"500\r"]
    axes = record.bench["if1"].axes
    assert (axes["X"].position, axes["Y"].position) == (1000, 500) and outcome == Outcome()


def test_a_delay_is_waited_for(tmp_path):
    record, _ = run(tmp_path, "P1,50$\nX10$\n")
    low = next(c for c in record.changes if c.pin == "output1" and not c.level)
    assert next(u for u in record.said if u.data.startswith(b"X")).time_ns >= low.time_ns


def test_a_pause_lets_a_run_continue(tmp_path):
    record, _ = run(tmp_path, "X@1000G$\n+2\n#\nN\n")
    assert 1900 < record.bench["if1"].axes["X"].position < 2100 and record.bench["if1"].axes["X"].velocity == 0


def test_a_run_does_not_delay_later_lines(tmp_path):
    record, outcome = run(tmp_path, "X@1000G$\nS1$\nK\n", until_s=10)
    assert record.bench.seconds == 10 and record.bench["if1"].axes["X"].velocity == 1000
    assert outcome == Outcome()


def test_an_action_closes_a_switch(tmp_path):
    record, _ = run(tmp_path, "H1X100$\n! input1 high\nE\n")
    assert heard(record)[-1] == b"C\r" and record.bench["if1"].axes["X"].position == 100


def test_an_endless_program_ends_at_the_given_time(tmp_path):
    record, outcome = run(tmp_path, ":X400:=0,1:$\n", until_s=60)
    assert record.bench.seconds == 60 and outcome == Outcome()
    assert heard(record) == [b"U\r"]


def test_an_endless_sequence_is_stopped_after_a_pause(tmp_path):
    record, outcome = run(tmp_path, ":X400:=0,1:$\n+10\n#\nE\n")
    assert heard(record)[-1] == b"C\r" and outcome == Outcome()


def test_lines_longer_than_the_buffer_wait_for_dtr(tmp_path):
    record, _ = run(tmp_path, "".join(f"X{n}$\n" for n in range(100, 110)))
    assert record.bench["if1"].axes["X"].position == sum(range(100, 110))
    long = ":" + ":".join(f"X{n}" for n in range(1, 40)) + ":$"
    record, _ = run(tmp_path, f"^10\n+0.1\n{long}\nF\n")  # sent during the ramp calculation, when nothing is read
    assert record.bench["if1"].axes["X"].position == sum(range(1, 40)) and heard(record)[-1] == b"0\r"


@pytest.mark.parametrize("line", ["110 8N2", "300 7E1", "1200 7O2", "2400 8N1", "9600 8E1", "4800 8O2", "instant"])
def test_the_data_format_is_that_of_the_host(tmp_path, line):
    record, _ = run(tmp_path, "X100$\nN\n", line=line)
    assert heard(record)[-1] == b"100\r"


def test_an_unsupported_data_format_is_refused(tmp_path):
    raises(UsageError, "9600 8M2", run, tmp_path, "X100$\n", line="9600 8M2")


def test_an_interface_that_does_not_answer(tmp_path):
    bench = Bench()
    bench.add("if1").serial.host.dtr = False
    raises(ProgramError, "does not answer", send_lines, bench, [], 60 * S, "a.if1")


def test_command_lines_are_for_one_interface(tmp_path, bench):
    bench.add("if1")
    bench.add("if2")
    raises(ProgramError, "the simulation has 2 controllers of the type IF1 or IF2, but an", send_lines, bench, [], S)


def test_an_unknown_terminal_is_refused_before_the_first_line(tmp_path):
    raises(ProgramError, "a.if1:2: unknown name 'input7'", run, tmp_path, "X100$\n! input7 high\n")


def test_a_program_of_unknown_kind(tmp_path):
    raises(UsageError, "expected .talk (conversation), .if1 (command lines)", load, tmp_path / "a.txt")


def test_requests_and_switches_after_a_pause_do_not_wait(tmp_path):
    # The sequence is endless.  K has bit 1 in motion; after the input has gone low, step 1 of the next round waits.
    lines = "! input1 high\n:H1X400@1000:X-400:=0,1:$\n+12\nE\nK\n! input1 low\n+6\nK\n"
    record, _ = run(tmp_path, lines)
    busy, moving, waiting = heard(record)[-3:]
    assert busy == b"E\r" and int(moving) & 1 and not int(waiting) & 1
    assert record.bench["if1"].axes["X"].position == 0


BUSY = "line 2 and later lines were not sent, because an earlier line is not finished at"
SOONER = "write +SECONDS above line 2 to send line 2 at a given time"


LONGER = "run longer with --for SECONDS, e.g. --for 6"


@pytest.mark.parametrize(
    ("text", "until_s", "end_s", "position", "note"),
    [
        (":X400:=0,1:$\nE\n", None, 3600, None,
         f"{BUSY} 3600 s: {SOONER}: stopped after 3600 s, set another time with --for SECONDS"),
        ("X10$\n+100\nX10$\n", 20, 20, 10, f"{BUSY} 20 s: {SOONER}"),
        ("XYG$\n", None, None, None, "X and Y still running: run longer with --for SECONDS"),
        ("X1$\n", 1, None, 0, f"no line was sent, as the interface is ready only at 2.70667 s: {LONGER}"),
    ],
    ids=["an endless sequence", "a pause beyond the end", "axes still move", "the end before the initialisation"],
)  # fmt: skip
def test_notes_about_an_incomplete_run(tmp_path, text, until_s, end_s, position, note):
    record, outcome = run(tmp_path, text, until_s)
    assert outcome.note == note
    assert end_s is None or record.bench.seconds == end_s
    assert position is None or record.bench["if1"].axes["X"].position == position
