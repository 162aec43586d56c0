"""Menu of users: the driver, the other users, and the user's own name."""

from nicegui import ui

from axistwin.ui.panel.context import Context, Refresh


def people(context: Context) -> Refresh:
    button = ui.button(icon="people").props("flat color=white no-caps").classes("people").mark("people")
    with button, ui.menu().props("no-focus"), ui.column().classes("people-menu"):
        name = ui.input("your name", value=context.person.name).mark("name")
        name.on("blur", lambda: context.people.rename(context.person, name.value))
        name.on("keydown.enter", lambda: context.people.rename(context.person, name.value))
        those = ui.column()
        take = ui.button("Drive", on_click=lambda: context.people.take_over(context.person)).mark("drive")
    shown: list[tuple[str, bool]] = []

    def refresh() -> None:
        nonlocal shown
        button.text = "you drive" if context.drives else f"{context.people.driver_name} drives"
        take.set_enabled(not context.drives)
        now = [(person.name, person is context.people.driver) for person in context.people.there]
        if now != shown:
            shown = now
            _list(those, now)

    return refresh


def _list(those: ui.column, now: list[tuple[str, bool]]) -> None:
    those.clear()
    with those:
        for name, drives in now:
            ui.label(f"{name} — drives" if drives else name)
