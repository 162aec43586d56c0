"""Views behind tabs: each is made when it is first looked at, and brought up to date while it is looked at."""

from collections.abc import Callable

from nicegui import ui

from axistwin.panel.look import Look, Refresh

Kinds = dict[str, Callable[[], Refresh]]
"""Views by the words on their tabs."""


def tabs(look: Look, name: str, kinds: Kinds) -> Refresh:
    """These, with the one open that this person looked at last."""
    made: dict[str, Refresh] = {}
    setting = f"tab {name}"
    wanted = str(look.person.settings.get(setting, ""))
    first = wanted if wanted in kinds else next(iter(kinds))
    with ui.tabs().props("dense no-caps align=left outside-arrows mobile-arrows").classes("tabs") as bar:
        for kind in kinds:
            ui.tab(kind).props(f'data-test="tab {name} {kind}"')
    with ui.tab_panels(bar, value=first, animated=False).classes("tab-panels"):
        panels = {kind: ui.tab_panel(kind) for kind in kinds}

    def show(kind: str) -> None:
        look.person.settings[setting] = kind
        if kind not in made:
            with panels[kind]:
                made[kind] = kinds[kind]()

    bar.on_value_change(lambda event: show(event.value))
    if first != wanted:
        show(first)

    def refresh() -> None:
        if str(bar.value) not in made:  # the page is drawn by now, and a terminal finds its size
            show(str(bar.value))
        made[str(bar.value)]()

    return refresh
