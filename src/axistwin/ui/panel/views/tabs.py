"""Tabs, each with a view that is built when the tab is first opened, and updated while the tab is open."""

from collections.abc import Callable
from functools import partial

from nicegui import ui

from axistwin.ui.panel.context import Context, Refresh
from axistwin.ui.panel.turns import breathe

Kinds = dict[str, Callable[[], Refresh]]


def tabs(context: Context, name: str, kinds: Kinds, look: str = "kinds") -> Refresh:
    """Build tabs that remember the open one for the user; `look`: a CSS class."""
    made: dict[str, Refresh | None] = {}
    setting = f"tab {name}"
    wanted = str(context.person.settings.get(setting, ""))
    first = wanted if wanted in kinds else next(iter(kinds))
    with ui.tabs().props("dense no-caps align=left outside-arrows mobile-arrows").classes(f"tabs {look}") as bar:
        for kind in kinds:
            ui.tab(kind).props(f'data-test="tab {name} {kind}"')
    breathe()
    with ui.tab_panels(bar, value=first, animated=False).classes("tab-panels"):
        panels = {kind: ui.tab_panel(kind) for kind in kinds}
    breathe()

    def build(kind: str) -> None:
        with panels[kind]:
            view = made[kind] = kinds[kind]()
        if kind == str(bar.value):
            view()

    def keep(kind: str) -> None:
        context.person.settings[setting] = kind

    bar.on_value_change(lambda event: keep(event.value))
    keep(first)

    def refresh() -> None:
        kind = str(bar.value)
        if kind not in made:  # Build the contents of a tab only when the user opens the tab.
            made[kind] = None
            context.unbuilt.append(partial(build, kind))
        elif view := made[kind]:
            view()

    return refresh
