"""Asides of the tutor in a terminal of the panel: explanations in grey after typed lines and their answers."""

import re
from collections.abc import Callable, Iterable, Sequence

from nicegui import ui

from axistwin.bench import Bench
from axistwin.bench.events import Received
from axistwin.panel.context import Context
from axistwin.panel.talk import DIM, NORMAL, Utterance
from axistwin.panel.turns import breathe
from axistwin.teaching import Tutor
from axistwin.units import S

ANSWERS_NS = 2 * S
"""Virtual time after a typed line in which received data are explained as its answer."""
SETTING = "tutor"
_drive = re.compile(r"(?:type {2}|! \w+ \w+ in a program, )?:drive (\w+) (\w+)(?: in a terminal)?")


def _in_the_panel(line: str) -> str:
    """Return a comment with the panel's controls instead of the terminal's command `:drive`."""
    return _drive.sub(lambda drive: "click power" if drive[1] == "power" else f"set {drive[1]} {drive[2]} (Pins)", line)


class Asides:
    """The tutor at one terminal, for the lines that this user types."""

    def __init__(self, context: Context, name: str) -> None:
        self._context, self._name = context, name
        self._made: tuple[Bench, Tutor] | None = None
        self._until_ns = -1
        self._lines: list[str] = []
        """Lines that are not yet on the screen."""

    @property
    def on(self) -> bool:
        """True if this user has not switched the tutor off."""
        return bool(self._context.person.settings.get(SETTING, True))

    def typing(self, data: bytes) -> Sequence[str]:
        """Return the comments on a line before it is sent."""
        if not self.on:
            return ()
        self._until_ns = self._context.bench.now + ANSWERS_NS
        return self._read(lambda: self._tutor.sending(data))

    def add(self, lines: Iterable[str]) -> None:
        """Add lines that are shown after the present messages."""
        self._lines += lines

    def text(self, said: Iterable[Utterance]) -> str:
        """Return the text to print after these messages: pending lines, and comments on answers to the typed line."""
        if self.on:
            for event in said:
                if isinstance(event, Received) and event.time_ns <= self._until_ns:
                    self._lines += self._tutor.received(event.data)
        lines, self._lines = [_in_the_panel(line) for line in self._lines], []
        return "".join(f"\r\n{DIM}             {line}{NORMAL}" for line in lines)

    def buttons(self) -> None:
        """Build the switch, and the buttons with questions to the tutor."""
        name = self._name
        switch = ui.switch("tutor", value=self.on).mark(f"tutor-{name}").tooltip("explain typed lines and answers")
        switch.on_value_change(lambda event: self._context.person.settings.update({SETTING: bool(event.value)}))
        breathe()
        for text, tip, ask in (
            ("Why?", "why nothing moves", lambda: self._tutor.why()),
            ("Next?", "what to type next", lambda: self._tutor.next()),
        ):
            button = ui.button(text, on_click=lambda ask=ask: self._answer(ask)).props("flat dense no-caps")
            button.mark(f"{text[:-1].lower()}-{name}").tooltip(tip)
        box = ui.input(placeholder="explain 1670").props(f'dense outlined aria-label="explain at {name}"')
        box.mark(f"explain-{name}").tooltip("meaning of a number, a command, a code or a terminal")
        box.on("keydown.enter", lambda: self._answer(lambda: self._tutor.explain(str(box.value or ""))))
        breathe()

    def _answer(self, ask: Callable[[], Sequence[str]]) -> None:
        self.add(self._read(ask))

    def _read(self, ask: Callable[[], Sequence[str]]) -> Sequence[str]:
        """Return the result of `ask`, which reads the state of the controller."""
        session = self._context.session
        return session.pacer.inspect(ask) if session.running else ask()

    @property
    def _tutor(self) -> Tutor:
        """The tutor of the present bench."""
        bench = self._context.bench
        if self._made is None or self._made[0] is not bench:
            self._made = bench, Tutor(bench[self._name])
        return self._made[1]
