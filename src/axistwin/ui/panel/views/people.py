"""The users, in the menu: the driver, the other users, and the user's own name."""

from nicegui import ui

from axistwin.ui.panel.context import Context, Refresh


def people(context: Context) -> Refresh:
    with ui.element("div").classes("people").props('role=group aria-label="users"'):
        who = ui.label().classes("who").mark("people")
        take = ui.button("Drive", on_click=lambda: context.people.take_over(context.person))
        take.props("outline dense no-caps").mark("drive")
        name = (
            ui.input("Your name", value=context.person.name).props('dense outlined aria-label="your name"').mark("name")
        )
        name.on("blur", lambda: context.people.rename(context.person, name.value))
        name.on("keydown.enter", lambda: context.people.rename(context.person, name.value))
        those = ui.element("div").classes("those-people")
    shown: list[tuple[str, bool]] = []

    def refresh() -> None:
        nonlocal shown
        who.text = "you drive" if context.drives else f"{context.people.driver_name} drives"
        take.set_enabled(not context.drives)
        now = [(person.name, person is context.people.driver) for person in context.people.there]
        if now != shown:
            shown = now
            _list(those, now)

    return refresh


def _list(those: ui.element, now: list[tuple[str, bool]]) -> None:
    those.clear()
    with those:
        for name, drives in now:
            ui.label(f"{name} — drives" if drives else name)
