"""The examples in `docs/conversations.md` and in the pages of the families have the documented results."""

import re
from pathlib import Path

import pytest

from axistwin import Bench
from axistwin.bench.programs import running
from axistwin.bench.programs.command_lines import read_command_lines, send_lines
from axistwin.bench.programs.hex_commands import command_strings, language_of, send_commands
from axistwin.bench.talk.conversation import parse
from axistwin.bench.talk.player import play
from axistwin.core.units import S

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "conversations.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w*)\n(.*?)^```$", PAGE, re.DOTALL | re.MULTILINE)
CONVERSATION, BOARD, DIFFERENCE, COMMAND_LINES, COMMANDS, SOURCE = (text for language, text in BLOCKS if not language)
RECORDING, PLAYING = (text for language, text in BLOCKS if language == "python")


def test_the_conversation_holds(bench):
    bench.add("if1")
    assert play(parse(CONVERSATION), bench) is None


def test_what_is_recorded_can_be_played(capsys, bench):
    exec(compile(RECORDING, "docs/conversations.md", "exec"), {})
    bench.add("if1")
    assert play(parse(capsys.readouterr().out), bench) is None


def test_the_program_plays_a_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("moves.talk").write_text(CONVERSATION)
    exec(compile(PLAYING, "docs/conversations.md", "exec"), {})


def test_the_command_lines_run():
    bench = Bench()
    if1 = bench.add("if1")
    assert send_lines(bench, read_command_lines(COMMAND_LINES), 60 * S) is None
    assert if1.axes["X"].pulse_times().size == 2000 and if1.axes["X"].position == 0


def test_the_conversation_with_a_board_holds(bench):
    bench.add("1811")
    assert play(parse(BOARD), bench) is None


def test_the_commands_run():
    bench = Bench()
    motor = bench.add("1811").axes["motor"]
    assert send_commands(bench, command_strings(COMMANDS, language_of("1811")), 60 * S) is None
    assert (motor.position, motor.pulse_times().size) == (0, 50_000)


def test_the_stored_program_runs(tmp_path, bench):
    motor = bench.add("smartmotor")
    (tmp_path / "p.sms").write_text(SOURCE)
    program = running.load(tmp_path / "p.sms")
    program.prepare(bench)
    assert program.perform(bench, None).note == ""
    assert (motor.serial.read(), motor.axes["shaft"].position) == (b"2000\r", 2000)


def test_a_difference_looks_like_this(bench):
    place, expected, got, caret = DIFFERENCE.splitlines()
    assert re.fullmatch(r"axistwin: moves\.talk:\d+: at \d+\.\d{9} s the reply is different", place)
    shown = str(play(parse("+1.5\n> (\n< V\\r\n", "moves.talk"), bench_with_if1()))
    assert [line[:12] for line in shown.splitlines()[1:]] == [expected[:12], got[:12], caret[:12]]


def bench_with_if1() -> Bench:
    bench = Bench()
    bench.add("if1")
    return bench


@pytest.mark.parametrize("page", sorted((DOCS / "families").glob("*.md")), ids=lambda page: page.stem)
def test_the_conversation_of_a_family_holds(bench, page):
    (text,) = re.findall(r"^```talk\n(.*?)^```$", page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
    conversation = parse(text)
    bench.add(conversation.headers["model"])
    assert play(conversation, bench) is None
