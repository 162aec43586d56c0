"""Asides of the tutor in a terminal of the panel: explanations in grey after typed lines and their answers."""

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
"""Virtual time after a typed line during which received data count as its answer."""
SETTING = "tutor"


class Asides:
    """The tutor's comments in one terminal, on the lines that one user types."""

    def __init__(self, context: Context, name: str) -> None:
        self._context, self._name = context, name
        self._made: tuple[Bench, Tutor] | None = None
        self._until_ns = -1
        self._lines: list[str] = []
        """Comments that are not on the screen yet."""

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
        """Add comments of the tutor, which are shown after the present messages."""
        self._lines += lines

    def text(self, said: Iterable[Utterance]) -> str:
        """Return the text to print after these messages: pending comments, and comments on answers."""
        if self.on:
            for event in said:
                if isinstance(event, Received) and event.time_ns <= self._until_ns:
                    self._lines += self._tutor.received(event.data)
        lines, self._lines = self._lines, []
        return "".join(f"\r\n{DIM}             {line}{NORMAL}" for line in lines)

    def buttons(self) -> None:
        """Build the tutor's switch, and the buttons that ask the tutor questions."""
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
        """Advance the session to the present time, and return the result of `ask`, which reads the controller."""
        session = self._context.session
        return session.pacer.inspect(ask) if session.running else ask()

    @property
    def _tutor(self) -> Tutor:
        """The tutor of the present bench."""
        bench = self._context.bench
        if self._made is None or self._made[0] is not bench:
            self._made = bench, Tutor(bench[self._name])
        return self._made[1]
