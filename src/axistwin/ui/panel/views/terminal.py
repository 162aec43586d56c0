"""A terminal at an endpoint: a screen with the messages, and a field for a line to send."""

from collections.abc import Awaitable
from functools import partial

from nicegui import ui

from axistwin.bench import actions, endpoints
from axistwin.core.errors import ProgramError, UsageError
from axistwin.ui.panel.context import Context, Refresh
from axistwin.ui.panel.talk import Printer, Talk
from axistwin.ui.panel.views.asides import Asides
from axistwin.ui.panel.views.lessons import lessons
from axistwin.ui.teaching.commands import own_command
from axistwin.ui.teaching.lessons import COURSES

SCREEN = {
    "rows": 12, "cols": 100, "fontSize": 12, "convertEol": False, "disableStdin": False, "scrollback": 4000,
    "theme": {"background": "#10151c", "foreground": "#f0f3f7", "red": "#ff7b72"}, "screenReaderMode": True,
}  # fmt: skip
PASSED_ON = "(event) => event.key !== 'Tab'"
"""JavaScript that keeps the Tab key for the browser, to move the focus; all other keys are sent to the terminal."""
FITTED = (
    "new ResizeObserver(() => this.element.clientWidth && getElement({id})?.fit()).observe(this.element.parentElement)"
)
"""JavaScript that adapts the width of the terminal to its card."""
TERMINATORS = {"CR": b"\r", "LF": b"\n", "CR LF": b"\r\n", "space": b" ", "nothing": b""}
REMEMBERED = 100


def terminal(context: Context, name: str) -> Refresh:
    """Build the terminal of an endpoint: a controller, its second channel, or a line with several motors."""
    whole = endpoints.at_a_bus(context.bench, name)
    asides = Asides(context, name) if name in context.bench.controllers else None
    with ui.row().classes("terminal-head"):
        client = ui.label().classes("quiet").mark(f"client-{name}")
        taught = asides if name in context.bench.controllers and context.bench[name].product.family in COURSES else None
        show_lesson = lessons(context, name, taught) if taught is not None else lambda: None
    screen = ui.xterm(SCREEN, on_data=lambda event: _typed(context, name, event.data)).classes("terminal")
    screen.props(f'data-test="terminal {name}" aria-label="what is said at {name}"')
    screen.run_terminal_method(":attachCustomKeyEventHandler", f"({FITTED.format(id=screen.id)}, {PASSED_ON})")
    _line(context, name, whole, asides)
    with ui.row().classes("terminal-line"):
        if not whole:
            _buttons(context, name)
        if asides is not None:
            asides.buttons()
    show = _roll(context, name, screen, whole, asides)

    def refresh() -> None:
        show_lesson()
        show()
        connected = context.session.client(name)
        client.text = f"{connected} is connected" if connected else "no client is connected"

    return refresh


def _roll(context: Context, name: str, screen: ui.xterm, whole: bool, asides: Asides | None) -> Refresh:
    talk, generation, count = context.common(Talk), -1, 0
    printer = Printer(endpoints.codec_at(context.bench, name), whole)

    def show() -> None:
        nonlocal generation, count, printer
        if generation != talk.generation:
            generation, count = talk.generation, 0
            printer = Printer(endpoints.codec_at(context.bench, name), whole)
            screen.run_terminal_method("reset")
            screen.fit()
        count, said = talk.since(name, count)
        if said:
            screen.write(printer.text(said))
        if asides is not None and (lines := asides.text(said)):
            screen.write(lines)
            printer.end_line()

    return show


# Input


def _typed(context: Context, name: str, text: str) -> None:
    if endpoints.at_a_bus(context.bench, name):
        ui.notify("a board accepts whole commands only: type them in the line below", type="warning")
        return
    data = text.encode("latin-1", "replace")
    context.touch(lambda: context.session.say(name, data))


def _line(context: Context, name: str, whole: bool, asides: Asides | None) -> None:
    history = context.person.lines.setdefault(name, [])
    with ui.row().classes("terminal-line"):
        hint = "a command in hex or by its name" if whole else r"characters; \r \n \xNN for control characters"
        box = ui.input(placeholder=hint, autocomplete=history).props(f'dense outlined aria-label="say to {name}"')
        box.classes("grow").mark(f"say-{name}").props(f'data-test="say {name}"')
        ending = ui.select(list(TERMINATORS), value=context.person.ending).props('dense outlined aria-label="ended by"')
        ending.set_visibility(not whole)

        def send() -> Awaitable[None] | None:
            context.person.ending = ending.value
            line = str(box.value or "")
            command = own_command(line.strip()) if asides is not None else None
            if asides is None or command is None:
                context.touch(partial(say, line))
                return None
            asides.add([line.strip()])
            keep(line)
            return asides.obey(*command)

        def keep(line: str) -> None:
            history[:] = [*(each for each in history if each != line), line][-REMEMBERED:]
            if box.value == line:
                box.value = ""

        def say(line: str) -> None:
            data = _bytes(context, name, line, whole, ending.value)
            comments = asides.typing(data) if asides is not None else ()
            context.session.say(name, data)
            if asides is not None:
                asides.add(comments)
            keep(line)

        box.on("keydown.enter", send)
        ui.button("Send", on_click=send).props("dense no-caps").mark(f"send-{name}")


def _bytes(context: Context, name: str, text: str, whole: bool, ending: str) -> bytes:
    codec = endpoints.codec_at(context.bench, name)
    try:
        return codec.read(text) if whole else codec.read(text) + TERMINATORS[ending]
    except ProgramError as error:
        raise UsageError(f"invalid text in column {error.column} of the line: {error.message}") from None


# Buttons and fields for the break signal, DTR, RTS and the character format


def _buttons(context: Context, name: str) -> None:
    port = context.bench.port(name)
    with ui.row().classes("terminal-part"):
        button = ui.button("Break", on_click=lambda: _do(context, name, "break", "0.25"))
        button.props("dense outline no-caps").mark(f"break-{name}")
        if port.handshake:
            for line, on in (("dtr", port.host.dtr), ("rts", port.host.rts)):
                switch = ui.switch(line.upper(), value=on).mark(f"{line}-{name}")
                switch.on_value_change(lambda e, line=line: _do(context, name, line, actions.level_name(e.value)))
        box = ui.input("format", value=str(port.host.format)).props("dense outlined").mark(f"format-{name}")
        box.on("keydown.enter", lambda: _do(context, name, "line", box.value))


def _do(context: Context, name: str, target: str, value: str) -> None:
    context.touch(lambda: context.session.do(name, target, value))
