"""The line editor of a terminal: history, completion, a hint and a status line.

Drawn by prompt_toolkit; completions and hints come from the command table.
"""

from asyncio import Queue
from collections.abc import Iterable
from html import escape
from typing import TYPE_CHECKING

from prompt_toolkit import PromptSession
from prompt_toolkit.completion import CompleteEvent, Completer, Completion
from prompt_toolkit.document import Document
from prompt_toolkit.formatted_text import HTML
from prompt_toolkit.history import FileHistory, History, InMemoryHistory
from prompt_toolkit.input import Input
from prompt_toolkit.output import Output

from axistwin.core.errors import LinkError
from axistwin.core.storage import state_file
from axistwin.ui.teaching.tutor import Tutor
from axistwin.ui.terminal.commands import MEANINGS
from axistwin.ui.terminal.screen import PROMPT

if TYPE_CHECKING:
    from axistwin.ui.terminal.virtual import VirtualEnd

EVERY_S = 0.25  # Interval in seconds at which the status line is updated.
Lines = Queue[bytes | LinkError | None]


def history(model: str) -> History:
    """Return the history of typed lines for a model; without a writable file it lasts for one session only."""
    file = state_file(f"history-{model}")
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.touch()
    except OSError:
        return InMemoryHistory()
    return FileHistory(file)


class Words(Completer):
    """Completes what the user types: commands of the terminal, or commands of the controller."""

    def __init__(self, tutor: Tutor | None) -> None:
        self._words = [] if tutor is None else tutor.words()
        self._single = tutor is not None and tutor.guide.single_characters

    def get_completions(self, document: Document, complete_event: CompleteEvent) -> Iterable[Completion]:
        text = document.text_before_cursor
        if text.startswith(":") and (len(text) == 1 or text[1].islower()):
            found = ((f":{name}", meaning) for name, meaning in MEANINGS.items())
            yield from (
                Completion(word, -len(text), display_meta=meaning) for word, meaning in found if word.startswith(text)
            )
        elif complete_event.completion_requested or not self._single:
            begin = "" if self._single else text.rpartition(" ")[2]
            if begin or complete_event.completion_requested:
                yield from (
                    Completion(term.text, -len(begin), display_meta=f"{term.meaning}   {term.syntax}")
                    for term in self._words
                    if term.text.startswith(begin)
                )


class LineEditor:
    """Line editor that reads lines from the user until the end of the input."""

    def __init__(
        self, end: "VirtualEnd | None", kept: History, source: Input | None = None, target: Output | None = None
    ) -> None:
        self._end = end
        self.interrupted = False
        self._session: PromptSession[str] = PromptSession(
            PROMPT,
            history=kept,
            completer=Words(None if end is None else end.tutor),
            complete_while_typing=True,
            bottom_toolbar=None if end is None else self.status,
            refresh_interval=0 if end is None else EVERY_S,
            erase_when_done=True,  # Erase the typed line after Enter; the class `Screen` then prints the same line.
            input=source,
            output=target,
        )

    async def read(self, lines: Lines) -> None:
        """Queue each line that the user types, and None at the end of the input or after Ctrl-C."""
        try:
            while True:
                line = await self._session.prompt_async()
                lines.put_nowait(line.encode("utf-8", "replace"))
        except EOFError:
            lines.put_nowait(None)
        except KeyboardInterrupt:
            self.interrupted = True
            lines.put_nowait(None)

    def close(self) -> None:
        if self._session.app.is_running and not self._session.app.is_done:
            self._session.app.exit(exception=EOFError())

    def status(self) -> HTML:
        assert self._end is not None, "a port has no status line"
        hint = meaning_of(self._end.tutor, self._session.default_buffer.document.text_before_cursor)
        return HTML(f"{escape(self._end.status)}{f'   <b>{escape(hint)}</b>' if hint else ''}")


def meaning_of(tutor: Tutor, text: str) -> str:
    """Return the meaning of the command at the end of a text; "" for an unknown command."""
    if text.startswith(":") and (meaning := MEANINGS.get(text[1:].partition(" ")[0])):
        return meaning
    described = list(tutor.guide.command(text)) if text.strip() else []
    return described[-1] if described else ""
