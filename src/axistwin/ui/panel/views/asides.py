"""Questions to the tutor and own commands in a terminal of the panel, e.g. `:why` and `:init`."""

from collections.abc import Awaitable
from functools import partial

from nicegui import ui

from axistwin.core.errors import UsageError
from axistwin.core.numbers import NumberError, real, shortened
from axistwin.scenes.sessions.buttons import initialise
from axistwin.ui.conversation.conversation import READY, Conversation
from axistwin.ui.panel.context import Context, complain

SETTING = "tutor"
COMMANDS = ":drive, :explain, :init, :next, :show, :store, :task, :wait and :why"
FLAT = "flat dense no-caps"


class Asides:
    """Questions of a user at one controller.  The answers stand in the list of the conversation."""

    def __init__(self, context: Context, name: str) -> None:
        self._context, self._name = context, name
        self._talk = context.common(Conversation)

    @property
    def on(self) -> bool:
        """True if typed lines are explained."""
        return bool(self._context.person.settings.get(SETTING, True))

    def switch(self) -> None:
        switch = ui.switch("tutor", value=self.on).mark(f"tutor-{self._name}")
        switch.tooltip("explain typed lines and answers")
        switch.on_value_change(lambda event: self._context.person.settings.update({SETTING: bool(event.value)}))

    def buttons(self, box: ui.input) -> None:
        """Build the buttons of the tutor; `box`: the field whose text *Explain* explains."""
        name = self._name
        init = ui.button("Initialise", on_click=self.initialise).props(FLAT).mark(f"init-{name}")
        init.tooltip("perform the dialogue that makes the controller ready")
        for text, question in (("Why does nothing move?", "why"), ("What next?", "next")):
            ui.button(text, on_click=partial(self.obey, question, "")).props(FLAT).mark(f"{question}-{name}")
        explain = ui.button("Explain", on_click=lambda: self.obey("explain", str(box.value or "")))
        explain.props(FLAT).mark(f"explain-{name}")
        explain.tooltip("what is typed below: a number, a command, a code or a terminal; or the last line")

    def obey(self, command: str, words: str, typed: str = "") -> Awaitable[None] | None:
        """Execute a command of the terminal itself, e.g. `:why`.  Errors are shown on the page."""
        context, name = self._context, self._name
        if self._talk.ask(name, command, words, typed):
            return None
        if typed:
            self._talk.log.ask(name, typed, ())
        match command:
            case "init":
                return self.initialise()
            case "drive":
                context.touch(partial(context.session.do, name, *words.partition(" ")[::2]))
            case "store":
                context.touch(partial(context.session.load, name, "typed.sms", f"{words}\n"))
            case "wait":
                return context.move(partial(self._wait, words))
            case _:
                complain(UsageError(f"unknown command :{command}: expected one of {COMMANDS}"))
        return None

    def initialise(self) -> Awaitable[None] | None:
        def done(needed: object) -> None:
            if needed is False:
                self._talk.log.ask(self._name, "Initialise", [READY])

        return self._context.move(partial(initialise, self._context.session, self._name), done)

    async def _wait(self, given_time: str) -> None:
        try:
            seconds = real(given_time)
        except NumberError:
            raise UsageError(f"invalid time {shortened(given_time)}: expected seconds, e.g. :wait 0.5") from None
        await self._context.session.advance_to(self._context.session.seconds + seconds)
