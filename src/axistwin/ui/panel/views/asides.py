"""Asides of the tutor in a terminal of the panel: explanations in grey after typed lines and their answers."""

from collections.abc import Awaitable, Callable, Iterable, Sequence
from functools import partial

from nicegui import ui

from axistwin.bench import Bench
from axistwin.bench.events import Received
from axistwin.core.errors import UsageError
from axistwin.core.numbers import NumberError, real, shortened
from axistwin.core.units import S
from axistwin.scenes.reasons.remedies import ByHand
from axistwin.scenes.sessions.buttons import initialise
from axistwin.ui.panel.context import Context, complain
from axistwin.ui.panel.lessons import Lessons
from axistwin.ui.panel.talk import DIM, NORMAL, Utterance
from axistwin.ui.panel.turns import breathe
from axistwin.ui.teaching.tutor import Tutor

ANSWERS_NS = 2 * S  # Virtual time after a typed line during which received data count as its answer.
SETTING = "tutor"
COMMANDS = ":drive, :explain, :init, :next, :show, :store, :task, :wait and :why"
NO_LESSON = "no lesson has begun: select one with the button Lessons"


class Asides:
    """Explains the commands that a user types at a terminal in the web page."""

    def __init__(self, context: Context, name: str) -> None:
        self._context, self._name = context, name
        self._made: tuple[Bench, Tutor] | None = None
        self._until_ns = -1
        self._lines: list[str] = []  # Comments that are not on the screen yet.

    @property
    def on(self) -> bool:
        return bool(self._context.person.settings.get(SETTING, True))

    def typing(self, data: bytes) -> Sequence[str]:
        if not self.on:
            return ()
        self._until_ns = self._context.bench.now + ANSWERS_NS
        return self._read(lambda: self._tutor.sending(data))

    def add(self, lines: Iterable[str]) -> None:
        """Add comments of the tutor, which are shown after the present messages."""
        self._lines += lines

    def text(self, said: Iterable[Utterance]) -> str:
        """Return the tutor's new comments as text for the terminal.  `said`: the new messages at the terminal."""
        if self.on:
            for event in said:
                if isinstance(event, Received) and event.time_ns <= self._until_ns:
                    self._lines += self._tutor.received(event.data)
        lines, self._lines = self._lines, []
        return "".join(f"\r\n{DIM}             {line}{NORMAL}" for line in lines)

    def buttons(self) -> None:
        name = self._name
        switch = ui.switch("tutor", value=self.on).mark(f"tutor-{name}").tooltip("explain typed lines and answers")
        switch.on_value_change(lambda event: self._context.person.settings.update({SETTING: bool(event.value)}))
        breathe()
        init = ui.button("Initialise", on_click=self._initialise).props("flat dense no-caps").mark(f"init-{name}")
        init.tooltip("perform the dialogue that makes the controller ready")
        for text, tip in (("Why?", "why nothing moves"), ("Next?", "what to type next")):
            button = ui.button(text, on_click=partial(self.obey, text[:-1].lower(), "")).props("flat dense no-caps")
            button.mark(f"{text[:-1].lower()}-{name}").tooltip(tip)
        box = ui.input(placeholder="explain 1670").props(f'dense outlined aria-label="explain at {name}"')
        box.mark(f"explain-{name}").tooltip("meaning of a number, a command, a code or a terminal")
        box.on("keydown.enter", lambda: self.obey("explain", str(box.value or "")))
        breathe()

    def obey(self, command: str, words: str) -> Awaitable[None] | None:
        """Execute a command of the terminal itself, e.g. `:why`.  Errors are shown on the page."""
        context, name = self._context, self._name
        match command:
            case "why" | "next":
                self.add(self._read(getattr(self._tutor, command)))
            case "explain":
                self.add(self._read(lambda: self._tutor.explain(words)))
            case "task":
                self.add([NO_LESSON if (found := context.common(Lessons).of(name)) is None else found[1].task])
            case "show":
                self.show_solution()
            case "init":
                return self._initialise()
            case "drive":
                context.touch(partial(context.session.do, name, *words.partition(" ")[::2]))
            case "store":
                context.touch(partial(context.session.load, name, "typed.sms", f"{words}\n"))
            case "wait":
                return context.move(partial(self._wait, words))
            case _:
                complain(UsageError(f"unknown command :{command}: expected one of {COMMANDS}"))
        return None

    def show_solution(self) -> None:
        found = self._context.common(Lessons).of(self._name)
        self.add([f"type  {line}" for line in found[1].solution] if found is not None else [NO_LESSON])

    def _initialise(self) -> Awaitable[None] | None:
        context = self._context

        def done(needed: object) -> None:
            if needed is False:
                self.add(["the controller is ready: no initialisation is needed"])

        return context.move(partial(initialise, context.session, self._name), done)

    async def _wait(self, given_time: str) -> None:
        try:
            seconds = real(given_time)
        except NumberError:
            raise UsageError(f"invalid time {shortened(given_time)}: expected seconds, e.g. :wait 0.5") from None
        await self._context.session.advance_to(self._context.session.seconds + seconds)

    def _read(self, ask: Callable[[], Sequence[str]]) -> Sequence[str]:
        return self._context.session.inspect(ask)

    @property
    def _tutor(self) -> Tutor:
        bench = self._context.bench
        if self._made is None or self._made[0] is not bench:
            self._made = bench, Tutor(bench[self._name], ByHand(self._context.session.operator, self._name))
        return self._made[1]
