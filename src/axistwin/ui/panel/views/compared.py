"""A twin beside a real machine: the header, and the list of what differs."""

from functools import partial

from nicegui import ui
from nicegui.elements.mixins.text_element import TextElement

from axistwin.ui.panel.comparison import Comparison, Found
from axistwin.ui.panel.context import Context, Refresh
from axistwin.ui.panel.turns import breathe
from axistwin.ui.panel.views.darkness import darkness
from axistwin.ui.panel.views.parts import LiveText, called

MOST = 100  # Differences in the list.


def compared(context: Context, comparison: Comparison) -> Refresh:
    """Build the contents of the header: whether the machine agrees with its twin, and the time that is shown."""
    with ui.element("div").classes("ident"):
        ui.label("SHADOW").classes("virtual").props('title="The twin of a real machine; this page only shows"')
    with ui.element("div").classes("what") as box:
        ui.label(context.session.title).classes("scene-title").props("role=heading aria-level=1").mark("scene-title")
        with ui.element("div").classes("state"):
            words = called(ui.label().props("role=status aria-live=polite"), "state")
    clock = called(LiveText(tag="div", text="").classes("clock"), "clock")
    now = ui.button("Now", icon="sensors", on_click=comparison.go_on).props("outline dense no-caps").mark("now")
    breathe()
    darkness(context)()

    def refresh() -> None:
        words.text = f"Shadow: {comparison.state}"
        clock.text = comparison.clock
        now.set_visibility(comparison.past)
        tone = "blue" if comparison.past else "red" if comparison.differs else "green"
        if box.props.get("data-tone") != tone:
            box.props["data-tone"] = tone

    return refresh


def differences(comparison: Comparison) -> Refresh:
    """Build the list of what differs; a click on a line shows its moment."""
    with ui.element("div").classes("next").props('role=group aria-label="findings"'):
        those = called(ui.element("ul").classes("found"), "found")
    shown: list[Found] | None = None

    def refresh() -> None:
        nonlocal shown
        if (found := list(comparison.found[:MOST])) != shown:
            shown = found
            those.clear()
            with those:
                for number, each in enumerate(found):
                    _line(comparison, each, number)

    return refresh


def _line(comparison: Comparison, found: Found, number: int) -> None:
    with ui.element("li"):
        button = TextElement(tag="button", text=f"{found.at} {found.text}").classes("quiet" if found.note else "")
        button.props["type"] = "button"
        called(button.on("click", partial(_go_back, comparison, found), []), f"found-{number}")
        ui.label(found.times).classes("quiet")


def _go_back(comparison: Comparison, found: Found) -> None:
    if not comparison.go_back(found):
        ui.notify(f"what led to {found.at} is no longer kept", type="warning")
