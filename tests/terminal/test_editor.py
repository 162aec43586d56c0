"""The line editor of `axistwin term`, with keys from a pipe."""

import asyncio

import pytest
from prompt_toolkit.completion import CompleteEvent
from prompt_toolkit.document import Document
from prompt_toolkit.history import InMemoryHistory
from prompt_toolkit.input import create_pipe_input
from prompt_toolkit.output import DummyOutput

from axistwin import Bench
from axistwin.ui.teaching.tutor import Tutor
from axistwin.ui.terminal.editor import LineEditor, Words, history, meaning_of


def typed(keys: str) -> tuple[list[bytes | None], bool]:
    """Return the lines read for these keys, and True if the input was interrupted."""

    async def read() -> tuple[list[bytes | None], bool]:
        lines: asyncio.Queue = asyncio.Queue()
        with create_pipe_input() as source:
            source.send_text(keys)
            editor = LineEditor(None, InMemoryHistory(), source=source, target=DummyOutput())
            await editor.read(lines)
        return [lines.get_nowait() for _ in range(lines.qsize())], editor.interrupted

    return asyncio.run(read())


def test_lines_are_edited():
    assert typed("X100\x7f1$\r\x04") == ([b"X101$", None], False)
    assert typed("X1$\x1b[D0\r\x04") == ([b"X10$", None], False)


def test_an_interrupt_ends():
    assert typed("X\x03") == ([None], True)


def completed(model: str, text: str, *, asked: bool = False) -> list[str]:
    words = Words(Tutor(Bench().add(model)))
    return [found.text for found in words.get_completions(Document(text), CompleteEvent(completion_requested=asked))]


@pytest.mark.parametrize(("model", "text", "asked", "words"), [
    ("if1", ":ex", False, [":explain"]), ("if1", ":X100", False, []),
    ("1811", "go_r", False, ["go_relative", "go_relative_encoder"]), ("smartmotor", "A=100 RTE", False, ["RTEMP"]),
    ("smartmotor", "", False, [])])  # fmt: skip
def test_completions(model, text, asked, words):
    assert completed(model, text, asked=asked) == words


def test_single_characters_are_completed_on_request_only():
    assert completed("if1", "X100") == [] and {"X", "@", "$"} <= set(completed("if1", "X100", asked=True))


def test_the_hint_is_the_line_of_the_command_table():
    tutor = Tutor(Bench().add("if1"))
    assert meaning_of(tutor, "X100@").startswith("@  speed data")
    assert meaning_of(tutor, ":why") == "why nothing moves" and meaning_of(tutor, "") == ""


def test_a_history_that_cannot_be_kept(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    history("if1").append_string("X1$")
    assert list(history("if1").load_history_strings()) == ["X1$"]
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "file"))
    assert isinstance(history("if1"), InMemoryHistory)
