"""Keys for the control of virtual time, and a dialog with all keys."""

from collections.abc import Callable

from nicegui import events, ui

from axistwin.panel.turns import breathe

KEYS = {
    " ": "run or pause", "e": "step to the next event", "s": "step to the next statement",
    "m": "step to the next move", "+": "faster", "-": "slower", "?": "this help",
}  # fmt: skip
ELSEWHERE = {
    "Tab, Shift-Tab": "from control to control", "Enter": "sends what has been typed",
    "arrows": "move what has the focus: a slider, a stick, a line of a program, the oscilloscope",
}  # fmt: skip


def keys(press: Callable[[str, object], object]) -> None:
    """Call `press(key, shown)` for each key except `?`, with the act that the Run button shows; add the help button."""
    with ui.dialog().mark("keys") as dialog, ui.card():
        ui.label("Keys").classes("title")
        for key, what in (KEYS | ELSEWHERE).items():
            breathe()
            with ui.row():
                ui.label("space" if key == " " else key).classes("key")
                ui.label(what)
        ui.button("Close", on_click=dialog.close)
    ui.button("?", on_click=dialog.open).props('dense flat color=white aria-label="help"').mark("help")

    def pressed(event: events.GenericEventArguments) -> object:
        told = event.args if isinstance(event.args, dict) else {}
        key = told.get("key")
        if key == "?":
            dialog.open()
        elif key in KEYS:
            return press(str(key), told.get("shown"))
        return None

    ui.on("driving-key", pressed)
