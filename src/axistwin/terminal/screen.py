"""What a terminal shows: `>` the host says, `<` the controller says, as it comes, control characters in words."""

import asyncio
from collections.abc import Callable
from enum import Enum
from typing import TextIO

from axistwin.bench.control_characters import word

CR, LF = 0x0D, 0x0A
CLEAR = "\r\x1b[K"
DIM, NORMAL = "\x1b[2m", "\x1b[0m"
PROMPT, ANSWER = "> ", "< "
OVER_S, PAUSE_S = 0.03, 0.4
"""An answer is over so long after its <CR>, as a <LF> may follow, or after any other character."""


class Line(Enum):
    """What stands on the last line."""

    EMPTY = "nothing yet"
    PROMPT = "the prompt, and what somebody is typing"
    ANSWER = "an answer that goes on"
    ENDED = "an answer that has had its terminator"


class Screen:
    """Writes to `out`.  `person`: somebody sits there, so there is a prompt, and what is typed is shown already.

    `glyphs`: what a national terminal shows for characters.
    """

    def __init__(
        self, out: TextIO, *, person: bool, colours: bool, glyphs: Callable[[str], str] = lambda text: text
    ) -> None:
        self.out, self.person, self.colours, self._glyphs = out, person, colours, glyphs
        self._line = Line.EMPTY
        self._timer: asyncio.TimerHandle | None = None

    def prompt(self) -> None:
        """Ask for a line."""
        if self.person and self._line is Line.EMPTY:
            self._write(PROMPT)
            self._line = Line.PROMPT

    def typed(self, line: str) -> None:
        """A line has been typed, or has come through a pipe."""
        if self.person:
            self._line = Line.EMPTY  # Enter has ended it
        else:
            self._fresh()
            self._write(f"{PROMPT}{line}\n")

    def said(self, data: bytes) -> None:
        """The host has said something by itself."""
        self._fresh()
        self._write(PROMPT + "".join(map(self._word, data)) + "\n")

    def tell(self, *lines: str) -> None:
        """Lines of our own."""
        self._fresh()
        self._write("".join(f"{line}\n" for line in lines))
        self.prompt()

    def heard(self, data: bytes) -> None:
        """Characters from the controller."""
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
        """Leave a whole line behind."""
        self._stop_timer()
        self._fresh()

    def _fresh(self) -> None:
        """Go to the beginning of a line."""
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
