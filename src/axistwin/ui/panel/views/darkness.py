"""Selection of dark or light colours, or of the colours of the user's system."""

from nicegui import ui

from axistwin.ui.panel.context import Context

MODES = {
    None: ("brightness_auto", "colours: as the system"),
    True: ("dark_mode", "colours: dark"),
    False: ("light_mode", "colours: light"),
}
"""Icon and label of each mode; a click selects the next mode."""


class Darkness(ui.dark_mode, component="darkness.js"):
    """Page element that applies the chosen colours to the page: dark, light, or as in the user's system.

    The browser sets the colours only when the selection changes.
    """


def darkness(context: Context) -> None:
    """Build the button that selects dark or light colours; the selection is stored for this user."""
    settings = context.person.settings
    kept = settings.get("dark")
    dark = Darkness(kept if isinstance(kept, bool) else None)

    def show() -> None:
        icon, words = MODES[dark.value]
        button.set_icon(icon)
        button.props["aria-label"] = button.props["title"] = words

    def change() -> None:
        modes = list(MODES)
        settings["dark"] = dark.value = modes[(modes.index(dark.value) + 1) % len(modes)]
        show()

    button = ui.button(on_click=change).props("dense flat color=white").mark("darkness")
    show()
