"""The examples in `docs/traces.md` have the results that the page shows."""

import re
import shlex
from pathlib import Path

import pytest

from axistwin import __version__
from axistwin.cli.program import main

PAGE = (Path(__file__).parents[2] / "docs" / "traces.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w*)\n(.*?)^```$", PAGE, re.DOTALL | re.MULTILINE)
(PROGRAM,) = (text for language, text in BLOCKS if language == "python")
(CSV,) = (text for language, text in BLOCKS if language == "csv")
SESSIONS = [text for language, text in BLOCKS if language == "console"]


@pytest.fixture
def directory(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for program in (PROGRAM, PROGRAM.replace("moves.csv", "others.csv").replace("X3@", "X4@")):
        exec(compile(program, "docs/traces.md", "exec"), {})
    return tmp_path


def test_the_trace_is_the_one_that_is_shown(directory):
    assert (directory / "moves.csv").read_text() == re.sub(r"axistwin: [\d.]+", f"axistwin: {__version__}", CSV)


@pytest.mark.parametrize("session", SESSIONS)
def test_the_commands_say_what_is_shown(directory, session, capsys):
    line, _, shown = session.partition("\n")
    with pytest.raises(SystemExit):
        main(shlex.split(line)[2:])
    said = capsys.readouterr()
    assert said.out + said.err == shown
