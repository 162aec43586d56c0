"""Virtual time."""

from nicegui import ui

from axistwin.panel.look import Look, Refresh


def clock(look: Look) -> Refresh:
    """Show the virtual time in seconds; in microseconds while paused."""
    label = ui.label().classes("clock").mark("clock").props("data-test=clock")

    def refresh() -> None:
        label.text = f"{look.session.seconds:.{3 if look.session.running else 6}f} s"

    return refresh
