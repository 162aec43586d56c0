"""The menu of what is rarely used: moments, events, breakpoints, saving, users, colours and keys."""

import io
import zipfile
from collections.abc import Awaitable, Callable
from functools import partial

from nicegui import events, ui

from axistwin.bench import Bench, endpoints
from axistwin.core.errors import UsageError
from axistwin.core.numbers import NumberError, real, shortened
from axistwin.scenes.sessions.breaks import Break
from axistwin.ui.panel.context import Context, Refresh, together
from axistwin.ui.panel.turns import breathe
from axistwin.ui.panel.views.darkness import darkness
from axistwin.ui.panel.views.people import people

FLAT = "flat dense no-caps align=left"
FIELD = "dense outlined"
NAME = "more controls"


def more(context: Context, show_keys: Callable[[], object], without_room: Callable[[Context], Refresh]) -> Refresh:
    """Build the button and its menu; while somebody else drives, the button says who."""
    button = ui.button(icon="more_vert").props("flat dense no-caps").classes("more").mark("more")
    colours = darkness(context)  # Outside of the menu, whose contents a browser makes when it is opened.
    with button, ui.menu().props(f'no-focus role=dialog aria-label="{NAME}"').classes("pop more-menu"):
        shown = [without_room(context)]
        breathe()
        _moment(context)
        breathe()
        _until(context)
        breathe()
        shown.append(_breaks(context))
        breathe()
        live = ui.button("Live from here", icon="sensors", on_click=lambda: context.touch(context.session.forget_rest))
        live.props(FLAT).mark("forget").tooltip("end the replay and discard the rest of the recording")
        save = ui.button("Save the session", icon="save", on_click=lambda: _download(context)).props(FLAT).mark("save")
        save.tooltip("with the messages of all hosts, as a scene that repeats it")
        breathe()
        shown.append(people(context))
        ui.separator()
        colours()
        ui.button("Keys", icon="keyboard", on_click=show_keys).props(FLAT).mark("help")

    def refresh() -> None:
        button.text = told = "" if context.drives else f"{context.people.driver_name} drives"
        button.props["aria-label"] = f"{told}, {NAME}" if told else NAME

    return together(*shown, refresh)


def _moment(context: Context) -> None:
    box = ui.input("Go to a time, in seconds").props(f'{FIELD} aria-label="go to this moment"')
    box.mark("moment").on("keydown.enter", lambda: go_to(context, box.value))


def go_to(context: Context, moment: float | str) -> Awaitable[None] | None:
    return context.move(lambda: context.session.go_to(_seconds(moment)))


def _seconds(moment: float | str) -> float:
    try:
        return real(str(moment))
    except NumberError:
        raise UsageError(f"invalid time {shortened(str(moment))}: expected seconds, e.g. 1.5") from None


# Sentences


def _stems(bench: Bench) -> list[str]:
    found = []
    for name, controller in bench.controllers.items():
        found += [f"{name}.{axis} passes 0" for axis in controller.axes]
        found += [f"{name}.{pin} {verb}" for pin in controller.pins for verb in ("rises", "falls", "changes")]
        if controller.alarms is not None:
            found += [f"{name} raises {flag}" for flag in controller.alarms.names]
        found += [f"{name} runs 1"] if controller.programs else []
    for name in endpoints.names(bench):
        found += [f"{name} hears ", f"{name} says "]
    return found + [f"{fault} {verb}" for fault in bench.faults.names for verb in ("begins", "ends")]


def _until(context: Context) -> None:
    def run() -> None:
        context.touch(lambda: context.session.run_until(box.value.strip()))

    with ui.element("div").classes("with-button"):
        box = ui.input("Run until an event", autocomplete=_stems(context.bench)).on("keydown.enter", run)
        box.props(f'{FIELD} aria-label="run until"').classes("sentence").mark("until")
        box.tooltip("e.g. table.X passes 1000, table.output1 rises, or motor runs 12")
        ui.button("Until", on_click=run).props("outline dense no-caps").mark("run-until")


def _breaks(context: Context) -> Refresh:
    box = (
        ui.input("Breakpoint: stop whenever", autocomplete=_stems(context.bench)).classes("sentence").mark("new-break")
    )
    box.props(f'{FIELD} aria-label="stop whenever"')
    box.on("keydown.enter", lambda: context.touch(lambda: context.session.add_break(box.value.strip())))
    those = ui.element("div").classes("those-breaks").mark("those-breaks")
    shown: list[tuple[str, bool, int]] = []

    def refresh() -> None:
        nonlocal shown
        now = [(each.sentence, each.on, each.hits) for each in context.session.breaks]
        if now != shown:
            shown = now
            _list_breaks(context, those)

    return refresh


def _list_breaks(context: Context, those: ui.element) -> None:
    those.clear()
    with those:
        for each in context.session.breaks:
            with ui.row().classes("break"):
                ui.checkbox(each.sentence, value=each.on, on_change=partial(_switch, context, each)).props("dense")
                ui.label(f"{each.hits} times" if each.hits != 1 else "once").classes("quiet")
                ui.button(icon="delete", on_click=partial(_remove, context, each)).props(
                    'flat dense aria-label="remove"'
                )


def _switch(context: Context, each: Break, event: events.ValueChangeEventArguments[bool | None]) -> None:
    context.touch(lambda: setattr(each, "on", bool(event.value)), now=True)


def _remove(context: Context, each: Break) -> None:
    context.touch(lambda: context.session.remove_break(each), now=True)


# Saving


def _download(context: Context) -> None:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in context.session.save().items():
            archive.writestr(name, text)
    ui.download.content(packed.getvalue(), "session.zip")
