"""The users, the driver, and the user's name."""

from nicegui import ui

from axistwin.panel.look import Look, Refresh


def people(look: Look) -> Refresh:
    """Build a button with the driver's name, and a menu of all users."""
    button = ui.button(icon="people").props("flat color=white no-caps").classes("people").mark("people")
    with button, ui.menu().props("no-focus"), ui.column().classes("people-menu"):
        name = ui.input("your name", value=look.person.name).mark("name")
        name.on("blur", lambda: look.people.rename(look.person, name.value))
        name.on("keydown.enter", lambda: look.people.rename(look.person, name.value))
        those = ui.column()
        take = ui.button("Drive", on_click=lambda: look.people.take_over(look.person)).mark("drive")
    shown: list[tuple[str, bool]] = []

    def refresh() -> None:
        nonlocal shown
        button.text = "you drive" if look.drives else f"{look.people.driver_name} drives"
        take.set_enabled(not look.drives)
        now = [(person.name, person is look.people.driver) for person in look.people.there]
        if now != shown:
            shown = now
            _list(those, now)

    return refresh


def _list(those: ui.column, now: list[tuple[str, bool]]) -> None:
    those.clear()
    with those:
        for name, drives in now:
            ui.label(f"{name} — drives" if drives else name)
