"""The controls of the oscilloscope: time base, signals, trigger, cursors and saving."""

from bisect import bisect_left
from collections.abc import Awaitable, Callable
from math import ceil, isnan, log10
from typing import Any

from nicegui import ui
from nicegui.elements.mixins.value_element import ValueElement

from axistwin.core.errors import AxistwinError
from axistwin.core.units import to_seconds
from axistwin.records.traces.signals import LEVEL, split
from axistwin.ui.drawings.scale import minus
from axistwin.ui.panel.context import Refresh, complain, together
from axistwin.ui.panel.scope.cursors import between, duration, rate, value_at
from axistwin.ui.panel.scope.meaning import PLAIN, Meaning
from axistwin.ui.panel.scope.saving import PICTURES, TRACES
from axistwin.ui.panel.scope.screen import MOST_SHOWN, SPANS_NS, Screen, searched
from axistwin.ui.panel.scope.tracks import Track, Words
from axistwin.ui.panel.scope.triggers import MODES, OFF, SINGLE, SLOPES
from axistwin.ui.panel.turns import breathe
from axistwin.ui.panel.views.parts import TOGGLE

DIVISIONS = 10  # Parts of the screen for which the time base is told.
HELP = (
    "Wheel or two fingers: zoom. Drag: shift. Click: set a cursor. Keys: + and − zoom, arrows shift, space freezes, "
    "Home shows all, a and b select a cursor, Shift with arrows moves the cursor, comma and full stop move the cursor "
    "to an edge, p and n show the previous and the next activity."
)
MOST_FOUND = 60
UNKNOWN = "–"
MOST_TITLE = 40  # Largest number of characters in the title of a lane.
Save = Callable[[str, bool], Awaitable[None]]
"""Function that saves a file; its arguments are the suffix, and True for the complete record."""


def attempt(action: Callable[[], object]) -> bool:
    """Perform an action; if the action fails, show the error to the user and return False."""
    try:
        action()
    except AxistwinError as error:
        complain(error)
        return False
    return True


FLAT = "dense flat no-caps"
MENU = f"{FLAT} icon-right=arrow_drop_down"


def head(screen: Screen, runs: Callable[[], bool]) -> Refresh:
    """Build title, Freeze, time base, and the steps to other activity."""
    ui.label("Oscilloscope").classes("scope-title").props("role=heading aria-level=2")
    freeze = ui.button(
        "Freeze", icon="pause", on_click=lambda: screen.pause() if screen.frozen is None else screen.live()
    )
    freeze.props(f"{FLAT} data-test=scope-pause").classes("scope-freeze").mark("scope-pause")
    breathe()
    refresh_time = _time_base(screen)
    breathe()
    all_ = ui.button("All", on_click=screen.fit).props(FLAT)
    all_.mark("scope-all").tooltip("Complete record")
    for icon, forward, what in (
        ("keyboard_double_arrow_left", False, "previous activity"),
        ("keyboard_double_arrow_right", True, "next activity"),
    ):
        jump = ui.button(icon=icon, on_click=lambda f=forward: jump_to(screen, f)).props(f"{FLAT} aria-label='{what}'")
        jump.classes("scope-icon").mark(f"scope-{what.replace(' ', '-')}").tooltip(what)
    breathe()
    state = ui.label().classes("scope-state quiet").props("role=status").mark("scope-state")

    def refresh() -> None:
        refresh_time()
        text = "Freeze" if screen.frozen is None else "Live"
        if freeze.text != text:
            freeze.text = text
            freeze.set_icon("pause" if text == "Freeze" else "play_arrow")
        state.text = _state(screen, runs())

    return refresh


def jump_to(screen: Screen, forward: bool) -> None:
    if not screen.jump(forward):
        ui.notify("no later activity" if forward else "no earlier activity")


def _state(screen: Screen, runs: bool) -> str:
    if screen.waiting:
        on = screen.trigger.signal
        return f"waiting for an edge of {screen.called(on)}" if on else "the trigger has no signal"
    frozen = "" if screen.frozen is None else "frozen; the bench runs" if runs else "frozen"
    if screen.begin_ns <= max(screen.edges[0], 0):
        return frozen
    since = f"recorded from {to_seconds(screen.begin_ns):.6g} s on: to see earlier changes, go back to 0 and run again"
    return f"{frozen}; {since}" if frozen else since


def _time_base(screen: Screen) -> Refresh:
    def turn(steps: int) -> None:
        place = min(max(bisect_left(SPANS_NS, screen.span_ns) + steps, 0), len(SPANS_NS) - 1)
        screen.zoom(SPANS_NS[place] / screen.span_ns, 0.5 if screen.frozen is not None else 1.0)

    shorter = ui.button(icon="remove", on_click=lambda: turn(-1)).props(f"{FLAT} aria-label='shorter time'")
    shorter.classes("scope-icon").mark("scope-shorter")
    label = ui.label().classes("scope-span").mark("scope-span")
    longer = ui.button(icon="add", on_click=lambda: turn(1)).props(f"{FLAT} aria-label='longer time'")
    longer.classes("scope-icon").mark("scope-longer")

    def refresh() -> None:
        label.text = f"{duration(float(f'{screen.span_ns / DIVISIONS:.4g}'))} a division"

    return refresh


def save_menu(save: Save) -> None:
    """Build the menu of files, and the button that gives the oscilloscope the whole window."""
    with ui.button("Save").props(f"{MENU} data-test=scope-save").mark("scope-save"), ui.menu():
        for whole, what in ((False, "visible window"), (True, "complete record")):
            for suffix in (*TRACES, *PICTURES):
                breathe()
                item = ui.menu_item(f"{what}, {suffix}", on_click=lambda s=suffix, w=whole: save(s, w))
                item.props("role=menuitem").mark(f"scope-save-{'all' if whole else 'seen'}{suffix}")
    full = (
        ui.button(icon="fullscreen").props(f"{FLAT} aria-label='whole window'").classes("scope-icon").mark("scope-full")
    )
    full.on("click", js_handler="() => document.querySelector('.scope-card').classList.toggle('whole')")


def choice(screen: Screen) -> Refresh:
    """Build the menus of signals and of presets."""

    def take() -> None:
        attempt(lambda: screen.choose(split(wanted.value)))

    signals = ui.button("Signals").props(MENU).classes("scope-first").mark("scope-list")
    with signals, ui.menu().props("no-focus role=dialog aria-label=signals"), ui.element("div").classes("scope-list"):
        with ui.element("div").classes("with-button"):
            wanted = ui.input("Signals", placeholder="*.X.velocity, if1.*says").on("keydown.enter", take)
            wanted.props("dense outlined data-test=scope-signals").mark("scope-signals")
            ui.button("Show", on_click=take).props("outline dense no-caps").mark("scope-show")
        breathe()
        _list(screen)
    with ui.button("Presets").props(MENU).mark("scope-presets"), ui.menu():
        for title in screen.recorder.presets:
            breathe()
            item = ui.menu_item(title, on_click=lambda t=title: attempt(lambda: _preset(screen, t)))
            item.props("role=menuitem").mark(f"scope-preset-{title}")
    shown: list[tuple[str, ...]] = []

    def refresh() -> None:
        if shown != [screen.names]:
            shown[:] = [screen.names]
            wanted.value = ", ".join(screen.names)

    return refresh


def arrange(screen: Screen) -> Refresh:
    """Build the menu of lanes: side by side or overlaid, their order, titles and folds."""
    button = ui.button("Lanes").props(MENU).mark("scope-arrange")
    with button, ui.menu().props("no-focus role=dialog aria-label=lanes"), ui.element("div").classes("scope-list"):
        lanes = ui.toggle({True: "Lanes", False: "Overlaid"}, value=screen.lanes).props(TOGGLE)
        refresh_lanes = kept(lanes.mark("scope-lanes"), screen, "lanes")
        ui.label("Lanes can also be dragged by their names").classes("quiet")
        build = _lanes(screen)
    button.on_click(lambda: build())
    shown: list[tuple[str, ...]] = []

    def refresh() -> None:
        refresh_lanes()
        if shown != [screen.names]:
            shown[:] = [screen.names]
            build(anew=False)

    return refresh


def _lanes(screen: Screen) -> Callable[..., None]:
    """Build the menu of lanes; return a function that builds its rows; `anew=False`: only if built before."""

    def rename(name: str, title: str) -> None:
        screen.titles[name] = " ".join(title.split())[:MOST_TITLE]

    def lanes() -> None:
        for place, name in enumerate(screen.names):
            breathe()
            with ui.row().classes("scope-lane"):
                for icon, to, what in (("arrow_upward", place - 1, "up"), ("arrow_downward", place + 1, "down")):
                    arrow = ui.button(icon=icon, on_click=lambda p=place, t=to: screen.move_lane(p, t))
                    arrow.props(f"dense flat round aria-label='{name} {what}'").mark(f"scope-{what}-{name}")
                fold = ui.switch("fold", value=name in screen.folded_now).props(f"dense aria-label='fold {name}'")
                fold.on_value_change(lambda event, n=name: screen.folded.update({n: bool(event.value)}))
                fold.mark(f"scope-fold-{name}")
                title = ui.input(screen.called(name), value=screen.titles.get(name, "")).props("dense outlined")
                title.on_value_change(lambda event, n=name: rename(n, event.value or ""))
                title.mark(f"scope-title-{name}")

    rows = ui.element("div").classes("scope-lanes")

    def build(anew: bool = True) -> None:
        if anew or rows.default_slot.children:
            rows.clear()
            with rows:
                lanes()

    return build


def _preset(screen: Screen, title: str) -> None:
    screen.show(screen.recorder.presets.get(title, ())[:MOST_SHOWN])


def _list(screen: Screen) -> None:

    def set_shown(name: str, shown: bool) -> None:
        names = [other for other in screen.names if other != name] + [name] * shown
        if not attempt(lambda: screen.show(names)):
            found.refresh()

    @ui.refreshable
    def found() -> None:
        signals = searched(list(screen.recorder.signals.values()), search.value or "", screen.called)
        for signal in signals[:MOST_FOUND]:
            breathe()
            box = ui.checkbox(screen.called(signal.full), value=signal.full in screen.names)
            box.props["title"] = signal.full
            box.on_value_change(lambda event, name=signal.full: set_shown(name, bool(event.value)))
            box.props("dense").mark(f"scope-box-{signal.full}")
        if len(signals) > MOST_FOUND:
            ui.label(f"and {len(signals) - MOST_FOUND} more: search for a part of the name").classes("quiet")

    search = ui.input("Search", placeholder="part of a name, or *", on_change=lambda: found.refresh())
    search.props("dense outlined clearable").mark("scope-search")
    ui.label(f"{MOST_SHOWN} at most").classes("quiet")
    found()


def trigger(screen: Screen) -> Refresh:
    """Build the menu of the trigger; its mode is on the button."""
    settings = screen.trigger
    button = ui.button(f"Trigger: {settings.mode}").props(MENU).mark("scope-trigger-menu")
    with button, ui.menu().props("no-focus role=dialog aria-label=trigger"), ui.element("div").classes("scope-list"):
        refresh_mode = _mode(screen)
        breathe()
        signal = ui.select(_names(screen), label="on", value=settings.signal)
        signal.props("dense options-dense outlined").mark("scope-trigger-signal")
        slope = ui.select(list(SLOPES), label="edge", value=settings.slope)
        slope.props("dense options-dense outlined").mark("scope-slope")
        breathe()
        value = ui.number("at", value=settings.value).props("dense outlined").mark("scope-value")
        ui.label("place on the screen").classes("quiet")
        place = ui.slider(min=0, max=1, step=0.05, value=settings.place).props("aria-label='place of the edge'")
        place.mark("scope-place")
        arm = ui.button("Arm", on_click=screen.live).props("outline dense no-caps").mark("scope-arm")
    fields: dict[str, ValueElement[Any]] = {"signal": signal, "slope": slope, "value": value, "place": place}
    refresh_fields = together(*(kept(field, settings, name, screen.arm) for name, field in fields.items()))

    def refresh() -> None:
        names = _names(screen)
        if signal.options != names:
            signal.set_options(names)
        button.text = f"Trigger: {settings.mode}"
        refresh_mode()
        refresh_fields()
        for field in (signal, slope, value, place):
            field.set_enabled(settings.mode != OFF)
        arm.set_visibility(settings.mode == SINGLE)

    return refresh


def _mode(screen: Screen) -> Refresh:
    settings = screen.trigger

    def arm() -> None:
        if not settings.signal and screen.names:
            settings.signal = screen.names[0]
        screen.arm()

    mode = ui.select(list(MODES), label="Trigger", value=settings.mode)
    mode.props("dense options-dense outlined").mark("scope-trigger")
    return kept(mode, settings, "mode", arm)


def kept(element: ValueElement[Any], owner: object, name: str, then: Callable[[], object] = lambda: None) -> Refresh:
    """Store an element's values in an attribute of `owner`, then call `then`; return its update function."""

    def set_() -> None:
        if element.value is not None and element.value != getattr(owner, name):
            setattr(owner, name, element.value)
            then()

    def refresh() -> None:
        element.value = getattr(owner, name)

    element.on_value_change(set_)
    return refresh


def _names(screen: Screen) -> dict[str, str]:
    signal = screen.trigger.signal
    names = [*screen.names, *([signal] if signal and signal not in screen.names else [])]
    return {"": ""} | {name: screen.called(name) for name in names}


def activate(screen: Screen, which: str) -> None:
    """Make a cursor active; if the cursor is not set, put the cursor in the middle of the screen."""
    screen.cursors.active = which
    if screen.cursors.active_ns is None:
        screen.move_cursor(0)


def clear_cursors(screen: Screen) -> None:
    screen.cursors.set("b", None)
    screen.cursors.set("a", None)


LABELS = {
    "name": "signal", "unit": "unit", "at": "at pointer", "now": "newest", "a": "at A", "b": "at B", "d": "B − A",
    "low": "least", "high": "greatest",
    "mean": "mean",
}  # fmt: skip
COLUMNS = [
    {"name": name, "label": label, "field": name, "align": "left" if name in ("name", "unit") else "right"}
    for name, label in LABELS.items()
]


def measuring(screen: Screen, shows_numbers: Callable[[], bool]) -> Refresh:
    """Build the menu of the cursors, with the table of measurements."""
    with (
        ui.button("Cursors").props(MENU).mark("scope-cursors"),
        ui.menu().props("no-focus role=dialog aria-label=cursors") as menu,
    ):
        menu.classes("scope-measures").mark("scope-measures")
        with ui.row().classes("scope-row"):
            for which in ("a", "b"):
                button = ui.button(which.upper(), on_click=lambda w=which: activate(screen, w))
                button.props(f"outline dense no-caps aria-label='cursor {which.upper()}'").mark(f"scope-cursor-{which}")
            for icon, forward, what in (
                ("navigate_before", False, "edge before"),
                ("navigate_next", True, "next edge"),
            ):
                step = ui.button(icon=icon, on_click=lambda f=forward: screen.jump_cursor(f))
                step.props(f"{FLAT} aria-label='{what}'").classes("scope-icon").mark(f"scope-{what.replace(' ', '-')}")
            snap = ui.switch("to edges", value=screen.cursors.snap).props("dense").mark("scope-snap")
            refresh_snap = kept(snap, screen.cursors, "snap")
            breathe()
            ui.button("Clear", on_click=lambda: clear_cursors(screen)).props(FLAT).mark("scope-clear")
        breathe()
        table = ui.table(columns=COLUMNS, rows=[], row_key="key")
        table.props("dense flat hide-pagination :rows-per-page-options=[0]").classes("scope-readout").mark(
            "scope-readout"
        )
        ui.label(HELP).classes("quiet scope-help")
    times = ui.label().classes("scope-times").mark("scope-times")

    def refresh() -> None:
        if not shows_numbers():
            return
        refresh_snap()
        times.text = _times(screen)
        rows = [_row(screen, name) for name in screen.names] if menu.value else []
        if table.rows != rows:
            table.rows = rows

    return refresh


def _times(screen: Screen) -> str:
    a_ns, b_ns = screen.cursors.a_ns, screen.cursors.b_ns
    active = f"{screen.cursors.active.upper()} moves" if b_ns is not None else ""
    told = [f"{name}{_beyond(screen, at)}: {_moment(screen, at)}" for name, at in screen.cursors.named.items()]
    if screen.pointer is not None:
        pointer = f"pointer {_seconds(screen, screen.time_at(screen.pointer))}"
        told, active = [pointer, *told], active if told else ""
    if a_ns is not None and b_ns is not None:
        told += [f"B − A {duration(b_ns - a_ns)}", f"1/(B − A) {rate(b_ns - a_ns)}"]
    return "   ".join(filter(None, [*told, active])) if told else ""


def _beyond(screen: Screen, time_ns: int) -> str:
    from_ns, to_ns = screen.edges
    return " (left of the screen)" if time_ns < from_ns else " (right of the screen)" if time_ns > to_ns else ""


def _moment(screen: Screen, time_ns: int) -> str:
    changed, seconds = screen.changed_at(time_ns), _seconds(screen, time_ns)
    return f"{changed} at {seconds}" if changed else seconds


def _seconds(screen: Screen, time_ns: int) -> str:
    """Return a time with the decimals that tell two pixels of the screen apart, at least milliseconds."""
    decimals = min(max(ceil(12 - log10(screen.span_ns)), 3), 9)
    return f"{to_seconds(time_ns):.{decimals}f} s"


def _row(screen: Screen, name: str) -> dict[str, str]:
    track = screen.record.tracks.get(name)
    row = dict.fromkeys(("at", "now", "a", "b", "d", "low", "high", "mean"), UNKNOWN)
    row |= {"name": screen.called(name), "key": name}
    meaning = screen.recorder.meanings.get(name, PLAIN)
    row["unit"] = meaning.shown_unit if meaning.units is None else f"{meaning.shown_unit} ({meaning.unit})"
    if track is None:
        return row
    at_ns = None if screen.pointer is None else screen.time_at(screen.pointer)
    a_ns, b_ns = screen.cursors.a_ns, screen.cursors.b_ns
    times = (("at", at_ns), ("now", screen.record.now_ns), ("a", a_ns), ("b", b_ns))
    if isinstance(track, Words):
        return row | {key: track.at(at) for key, at in times if at is not None}
    row |= {key: _told(track, meaning, value_at(track, at)) for key, at in times if at is not None}
    if a_ns is not None and b_ns is not None:
        found = between(track, a_ns, b_ns)
        row |= {"low": _told(track, meaning, found.low), "high": _told(track, meaning, found.high)}
        row |= {"d": _number(meaning, found.difference), "mean": _number(meaning, found.mean, 6)}
    return row


def _told(track: Track, meaning: Meaning, value: float) -> str:
    return meaning.word(value) if track.kind == LEVEL and not isnan(value) else _number(meaning, value)


def _number(meaning: Meaning, value: float, digits: int = 10) -> str:
    """Return a value in the machine's unit, if there is one, with the pulses or counts in brackets."""
    if isnan(value):
        return UNKNOWN
    own = minus(f"{value:.{digits}g}")
    return own if meaning.units is None else f"{meaning.number(value)} ({own})"
