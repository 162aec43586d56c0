"""Virtual time."""

from nicegui import ui

from axistwin.apps.panel.look import Look, Refresh


def clock(look: Look) -> Refresh:
    """What time it is on the bench, in seconds."""
    label = ui.label().classes("clock").mark("clock").props("data-test=clock")

    def refresh() -> None:
        label.text = f"{look.session.seconds:.3f} s"

    return refresh
