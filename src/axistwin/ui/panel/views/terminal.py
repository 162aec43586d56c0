"""A terminal at an endpoint: the list of the conversation, and a field for a line to send."""

from collections.abc import Awaitable
from functools import partial

from nicegui import ui
from nicegui.elements.mixins.text_element import TextElement

from axistwin.bench import actions, endpoints
from axistwin.core.errors import ProgramError, UsageError
from axistwin.ui.conversation import notes
from axistwin.ui.conversation.conversation import Conversation
from axistwin.ui.conversation.first import HEAD, about, first_steps
from axistwin.ui.panel.context import Context, Refresh
from axistwin.ui.panel.drawings.entries import Entries
from axistwin.ui.panel.turns import breathe
from axistwin.ui.panel.views.asides import Asides
from axistwin.ui.panel.views.lessons import LessonCard
from axistwin.ui.teaching.tutor import own_command

TERMINATORS = {"usual": b"\r", "CR": b"\r", "LF": b"\n", "CR LF": b"\r\n", "space": b" ", "nothing": b""}
REMEMBERED = 100
SIGNS = r"\r \n \xNN are control characters"


def terminal(context: Context, name: str) -> Refresh:
    """Build the terminal of an endpoint: a controller, its second channel, or a line with several motors."""
    return _Terminal(context, name).refresh


class _Terminal:
    def __init__(self, context: Context, name: str) -> None:
        self._context, self._name = context, name
        self._whole = endpoints.at_a_bus(context.bench, name)
        self._talk = context.common(Conversation)
        known = self._talk.knows(name) and bool(context.bench[name].product.family)
        self._asides = Asides(context, name) if self._talk.knows(name) else None
        with ui.row().classes("terminal-head"):
            self._client = ui.label().classes("quiet").mark(f"client-{name}")
            lessons = LessonCard(context, name, self._asides) if known and self._asides is not None else None
            self._settings = _Settings(context, name, self._asides)
        self._lessons = lessons
        if lessons is not None:
            lessons.card()
        breathe()
        self._first = self._before_first_message()
        self._entries = Entries(self._talk.log, name, self._typed).classes("log terminal")
        self._entries.props(f'data-test="terminal {name}" aria-label="what is said at {name}"').mark(f"list-{name}")
        box = self._line()
        breathe()
        if self._asides is not None:
            with ui.row().classes("terminal-ask"):
                self._asides.buttons(box)
        self._show_first(True)

    def refresh(self) -> None:
        if self._lessons is not None:
            self._lessons.refresh()
        if self._asides is not None:
            self._talk.look_at_lesson(self._name)
        self._entries.send()
        self._show_first(not self._entries.spoken)
        connected = self._context.session.client(self._name)
        self._client.text = f"{connected} is connected" if connected else "No host is connected"
        self._settings.refresh()

    def _show_first(self, on: bool) -> None:
        on = on and self._first is not None
        if self._entries.visible is on:
            self._entries.set_visibility(not on)
        if self._first is not None and self._first.visible is not on:
            self._first.set_visibility(on)

    # Input

    def _typed(self, text: str) -> None:
        if self._whole:
            ui.notify("a board accepts whole commands only: type them in the line below", type="warning")
            return
        data = text.encode("latin-1", "replace")
        self._context.touch(lambda: self._context.session.say(self._name, data))

    def _line(self) -> ui.input:
        context, name = self._context, self._name
        history = context.person.lines.setdefault(name, [])
        with ui.row().classes("terminal-line"):
            hint = "Type a command, in hex or by its name" if self._whole else "Type a command"
            box = ui.input(placeholder=hint, autocomplete=history).props(f'dense outlined aria-label="say to {name}"')
            box.classes("grow").mark(f"say-{name}").props(f'data-test="say {name}"')
            if not self._whole:
                box.props["aria-description"] = SIGNS
                with box.add_slot("append"), ui.icon("help_outline", size="xs").props("aria-hidden=true"):
                    ui.tooltip(SIGNS).mark(f"signs-{name}")
            ending = ui.select(list(TERMINATORS), value=context.person.ending)
            ending.props('dense options-dense outlined aria-label="ended by"').set_visibility(not self._whole)
            send = partial(self._send, box, ending)
            box.on("keydown.enter", send)
            ui.button("Send", on_click=send).props("outline no-caps").mark(f"send-{name}")
        return box

    def _send(self, box: ui.input, ending: ui.select) -> Awaitable[None] | None:
        self._context.person.ending = ending.value
        line = str(box.value or "")
        command = own_command(line.strip()) if self._asides is not None else None
        if self._asides is None or command is None:
            self._context.touch(partial(self._say, box, line, ending.value))
            return None
        self._keep(box, line)
        return self._asides.obey(*command, typed=line.strip())

    def _say(self, box: ui.input, line: str, ending: str) -> None:
        explained = self._asides is not None and self._asides.on
        try:
            data = self._bytes(line, ending)
        except UsageError as error:
            if explained and isinstance(error.__cause__, ProgramError):
                self._talk.refused(self._name, line, error.__cause__)
            raise
        self._talk.say(self._name, data, explained=explained)
        self._keep(box, line)

    def _keep(self, box: ui.input, line: str) -> None:
        history = self._context.person.lines.setdefault(self._name, [])
        history[:] = [*(each for each in history if each != line), line][-REMEMBERED:]
        if box.value == line:
            box.value = ""

    def _bytes(self, text: str, ending: str) -> bytes:
        codec = endpoints.codec_at(self._context.bench, self._name)
        try:
            return codec.read(text) if self._whole else codec.read(text) + self._ending(ending)
        except ProgramError as error:
            raise UsageError(f"invalid text in column {error.column} of the line: {error.message}") from error

    def _ending(self, chosen: str) -> bytes:
        if chosen == "usual" and (controller := self._context.bench.controllers.get(self._name)) is not None:
            return controller.product.endings[0]
        return TERMINATORS[chosen]

    # Before the first message

    def _before_first_message(self) -> ui.element | None:
        if self._asides is None:
            return None
        controller = self._context.bench[self._name]
        with ui.element("section").classes("first").props('aria-label="first steps"') as box:
            ui.label(HEAD).classes("first-head").props("role=heading aria-level=2")
            ui.label(about(controller)).classes("quiet")
            with ui.element("ol"):
                for step in first_steps(controller):
                    with ui.element("li"), ui.element("div"):
                        ui.label(step.title).classes("first-title")
                        _sentence(step.words)
                        if step.initialises:
                            ui.button("Initialise", on_click=self._asides.initialise).props("outline no-caps")
            if self._lessons is not None:
                with ui.element("div").classes("or"):
                    ui.label("Six short lessons lead from the first command to a repeating sequence.")
                    begin = ui.button("Begin lesson 1", on_click=lambda: self._lessons and self._lessons.begin(1))
                    begin.props("outline no-caps").mark(f"begin-{self._name}")
        return box


def _sentence(words: str) -> None:
    """Build a sentence with lines to type."""
    with ui.element("p").classes("quiet"):
        for text, kind in notes.parts(words):
            TextElement(tag="code" if kind else "span", text=text)


class _Settings:
    """Break, DTR, RTS, the character format and the tutor, folded into one button."""

    def __init__(self, context: Context, name: str, asides: Asides | None) -> None:
        self._context, self._name, self._asides = context, name, asides
        self._port = None if endpoints.at_a_bus(context.bench, name) else context.bench.port(name)
        with ui.button().props("flat dense no-caps icon-right=arrow_drop_down").classes("quiet") as self._button:
            self._button.mark(f"settings-{name}").props(f'aria-label="settings of {name}"')
            with ui.menu().props("no-focus"), ui.column().classes("terminal-settings"):
                if self._port is not None:
                    self._at_a_port()
                if asides is not None:
                    asides.switch()

    def refresh(self) -> None:
        found = [] if self._port is None else self._lines()
        words = ", ".join([*found, *["tutor"] * (self._asides is not None and self._asides.on)]) or "settings"
        if self._button.text != words:
            self._button.text = words
            self._button.props["aria-label"] = f"{words}: settings of {self._name}"

    def _lines(self) -> list[str]:
        host = self._context.bench.port(self._name).host
        on = [line.upper() for line in ("dtr", "rts") if getattr(host, line)] if self._handshake else []
        return [str(host.format), *on]

    @property
    def _handshake(self) -> bool:
        return bool(self._context.bench.port(self._name).handshake)

    def _at_a_port(self) -> None:
        name, host = self._name, self._context.bench.port(self._name).host
        button = ui.button("Break", on_click=lambda: self._do("break", "0.25"))
        button.props("dense outline no-caps").mark(f"break-{name}")
        for line in ("dtr", "rts") if self._handshake else ():
            switch = ui.switch(line.upper(), value=getattr(host, line)).mark(f"{line}-{name}")
            switch.on_value_change(lambda e, line=line: self._do(line, actions.level_name(e.value)))
        box = ui.input("format", value=str(host.format)).props("dense outlined").mark(f"format-{name}")
        box.on("keydown.enter", lambda: self._do("line", box.value))

    def _do(self, target: str, value: str) -> None:
        self._context.touch(lambda: self._context.session.do(self._name, target, value))
