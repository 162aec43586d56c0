"""Keyboard shortcuts that control virtual time, and a help dialog that lists all keys."""

from collections.abc import Callable

from nicegui import events, ui

from axistwin.ui.panel.turns import breathe

KEYS = {
    " ": "run or pause", "e": "step to the next event", "c": "step to the next character",
    "s": "step to the next statement", "m": "step to the next move", "+": "faster", "-": "slower", "?": "this help",
}  # fmt: skip
ELSEWHERE = {
    "Tab, Shift-Tab": "move the focus to the next or previous control", "Enter": "send the typed text",
    "arrows": "move the slider, joystick, program line or oscilloscope that has the focus; the timeline by 1 s, with "
    "Shift by 10 s",
}  # fmt: skip


def keys(press: Callable[[str, object], object]) -> Callable[[], object]:
    """Build the help dialog, and return its opener; other keys call `press(key, shown)` with the Run button's text."""
    with ui.dialog().mark("keys") as dialog, ui.card():
        ui.label("Keys").classes("title")
        for key, what in (KEYS | ELSEWHERE).items():
            breathe()
            with ui.row():
                ui.label("space" if key == " " else key).classes("key")
                ui.label(what)
        ui.button("Close", on_click=dialog.close).props("outline dense no-caps")

    def pressed(event: events.GenericEventArguments) -> object:
        told = event.args if isinstance(event.args, dict) else {}
        key = told.get("key")
        if key == "?":
            dialog.open()
        elif key in KEYS:
            return press(str(key), told.get("shown"))
        return None

    ui.on("driving-key", pressed)
    return dialog.open
