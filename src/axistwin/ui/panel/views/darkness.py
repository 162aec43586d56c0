"""Selection of dark or light colours, or of the colours of the user's system."""

from collections.abc import Callable

from nicegui import ui

from axistwin.ui.panel.context import Context

MODES = {
    None: ("brightness_auto", "Colours: as the system"),
    True: ("dark_mode", "Colours: dark"),
    False: ("light_mode", "Colours: light"),
}
"""Icon and label of each mode; a click selects the next mode."""


class Darkness(ui.dark_mode, component="darkness.js"):
    """Page element that applies the chosen colours to the page: dark, light, or as in the user's system.

    The browser sets the colours only when the selection changes.
    """


def darkness(context: Context) -> Callable[[], None]:
    """Apply the user's colours; return a function that builds the button which selects others."""
    settings = context.person.settings
    kept = settings.get("dark")
    dark = Darkness(kept if isinstance(kept, bool) else None)

    def build() -> None:
        def show() -> None:
            icon, words = MODES[dark.value]
            button.set_icon(icon)
            button.text = words

        def change() -> None:
            modes = list(MODES)
            settings["dark"] = dark.value = modes[(modes.index(dark.value) + 1) % len(modes)]
            show()

        button = ui.button(on_click=change).props("flat dense no-caps align=left").mark("darkness")
        show()

    return build
