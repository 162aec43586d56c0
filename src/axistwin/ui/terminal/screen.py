"""The screen of a terminal: `>` host, `<` controller; control characters are shown by name."""

import asyncio
import shutil
import textwrap
from collections.abc import Callable
from enum import Enum
from typing import TextIO

from axistwin.bench.codec import word

CR, LF = 0x0D, 0x0A
CLEAR = "\r\x1b[K"
DIM, NORMAL = "\x1b[2m", "\x1b[0m"
PROMPT, ANSWER = "> ", "< "
OVER_S, PAUSE_S = 0.03, 0.4
"""Seconds of silence after which an answer counts as finished: after a <CR> (a <LF> may follow), and after other
characters.
"""


class Line(Enum):
    """Content of the last line on the screen."""

    EMPTY = "nothing yet"
    PROMPT = "the prompt and unfinished input"
    ANSWER = "an unfinished answer"
    ENDED = "an answer with its terminator"


class Screen:
    """The screen of the terminal, written to `out`.  `person`: input comes from a keyboard, so a prompt is shown.

    `editor`: a line editor shows the prompt.  `glyphs` converts characters for a national terminal.
    """

    def __init__(
        self, out: TextIO, *, person: bool, colours: bool, editor: bool = False,
        glyphs: Callable[[str], str] = lambda text: text,
    ) -> None:  # fmt: skip
        self.out, self.person, self.colours, self._glyphs = out, person, colours, glyphs
        self._editor = editor
        self._line = Line.EMPTY
        self._timer: asyncio.TimerHandle | None = None

    def prompt(self) -> None:
        if self.person and not self._editor and self._line is Line.EMPTY:
            self._write(PROMPT)
            self._line = Line.PROMPT

    def typed(self, line: str) -> None:
        """Handle a line of input: a typed line is already visible, a line from a pipe is shown."""
        if self._editor:
            self._fresh()
            self._write(f"{PROMPT}{line}\n")
        elif self.person:
            self._line = Line.EMPTY  # The user's Enter key has moved the cursor to an empty line.
        else:
            self._fresh()
            self._write(f"{PROMPT}{line}\n")

    def show_sent(self, data: bytes) -> None:
        """Show data that the terminal sends automatically, e.g. during an initialisation."""
        self._fresh()
        self._write(PROMPT + "".join(map(self._word, data)) + "\n")

    def show(self, *lines: str) -> None:
        self._fresh()
        self._write("".join(f"{line}\n" for line in lines))
        self.prompt()

    def aside(self, *lines: str) -> None:
        """Show notes below the line that they explain."""
        if lines:
            shown = [piece for line in lines for piece in self._wrapped(line, "  ")]
            self.show(*(f"{DIM}{line}{NORMAL}" if self.colours else line for line in shown))

    def tell(self, *lines: str) -> None:
        """Show sentences, wrapped at blanks and with a hanging indent on a screen of a user."""
        self.show(*(piece for line in lines for piece in self._wrapped(line)))

    def _wrapped(self, line: str, indent: str = "") -> list[str]:
        width = shutil.get_terminal_size().columns - 1 if self.person else 0
        if len(indent + line) <= width or not self.person:
            return [indent + line]
        return textwrap.wrap(
            line, width, initial_indent=indent, subsequent_indent=f"{indent}  ", break_on_hyphens=False
        )  # fmt: skip

    def show_received(self, data: bytes) -> None:
        for byte in data:
            if self._line is Line.ENDED and byte != LF:
                self._fresh()
            if self._line not in (Line.ANSWER, Line.ENDED):
                self._fresh()
                self._write(ANSWER)
            self._write(self._word(byte))
            self._line = Line.ENDED if byte in (CR, LF) else Line.ANSWER
        self._again_after(OVER_S if self._line is Line.ENDED else PAUSE_S)

    def close(self) -> None:
        self._stop_timer()
        self._fresh()

    def _fresh(self) -> None:
        if self._line is Line.PROMPT:
            self._write(CLEAR)
        elif self._line is not Line.EMPTY:
            self._write("\n")
        self._line = Line.EMPTY

    def _again_after(self, seconds: float) -> None:
        self._stop_timer()
        self._timer = asyncio.get_running_loop().call_later(seconds, self._over)

    def _stop_timer(self) -> None:
        if self._timer is not None:
            self._timer.cancel()

    def _over(self) -> None:
        if self._line in (Line.ANSWER, Line.ENDED):
            self._fresh()
            self.prompt()

    def _word(self, byte: int) -> str:
        text = word(byte)
        text = self._glyphs(text) if len(text) == 1 else text
        return f"{DIM}{text}{NORMAL}" if self.colours and len(text) > 1 else text

    def _write(self, text: str) -> None:
        self.out.write(text)
        self.out.flush()
