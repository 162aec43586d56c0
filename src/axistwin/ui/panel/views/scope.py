"""The oscilloscope, which shows any signals of the bench over time."""

import asyncio
import json
from collections.abc import Callable
from functools import partial
from math import isfinite
from typing import Any

from nicegui import events, run, ui

from axistwin.core.errors import AxistwinError
from axistwin.core.units import S, to_seconds
from axistwin.scenes.sessions.session import Session
from axistwin.ui.panel.actions import State
from axistwin.ui.panel.context import Context, Refresh, complain
from axistwin.ui.panel.outbound import execute
from axistwin.ui.panel.people import Person
from axistwin.ui.panel.scope import frames
from axistwin.ui.panel.scope.recorder import Recorder
from axistwin.ui.panel.scope.saving import PICTURES, TRACES, exact_ns, saved
from axistwin.ui.panel.scope.screen import FIRST_SHOWN, PIXELS, Screen, first_choice
from axistwin.ui.panel.turns import breathe
from axistwin.ui.panel.views import scope_controls as controls
from axistwin.ui.panel.views.operator import inscriptions

FIRST_SPAN_NS = 5 * S
READOUT_EVERY = 5  # Number of frames between two updates of the table of measurements.


class Scopes:
    """The oscilloscope screens of all users, and the recorder of the shown signals."""

    def __init__(self, session: Session) -> None:
        self.recorder = Recorder(inscriptions(session.operator))
        self.drawn = 0  # Number of screens that have been sent to browsers; used by tests.
        self.saving = asyncio.Lock()
        self._pages: dict[Screen, int] = {}
        session.each_bench(self.recorder.attach)

    def come(self, person: Person) -> Screen:
        """Count a newly opened page of this user, and return the user's screen; a new screen shows motion signals."""
        screen = person.settings.get("scope")
        if not isinstance(screen, Screen):
            screen = person.settings["scope"] = Screen(self.recorder, span_ns=FIRST_SPAN_NS)
            signals = list(self.recorder.signals.values())
            screen.names = tuple(self.recorder.presets.get("Scene", first_choice(signals))[:FIRST_SHOWN])
        self._pages[screen] = self._pages.get(screen, 0) + 1
        breathe()
        try:
            screen.show(screen.names)
        except AxistwinError:  # The recorder has refused the signals, e.g. because there are too many: show none.
            screen.show(())
        return screen

    def go(self, screen: Screen) -> None:
        """Count a closed page with this screen; when the last page is closed, stop recording the signals."""
        self._pages[screen] -= 1
        if not self._pages[screen]:
            self.recorder.leave(screen)


def scope(context: Context) -> Refresh:
    all_ = context.common(Scopes)
    screen = all_.come(context.person)
    breathe()
    ui.context.client.on_delete(lambda: all_.go(screen))
    with ui.element("div").classes("scope").mark("scope"):
        return _Scope(context, screen, all_).refresh


class _Scope:
    def __init__(self, context: Context, screen: Screen, all_: Scopes) -> None:
        self._context, self.screen, self._all = context, screen, all_
        self._client = ui.context.client
        self._pixels, self._seen = screen.pixels, True
        self._drawn: object = None
        self._frames = 0
        self._views: list[Refresh] = []
        with ui.element("div").classes("scope-bar"):
            for control in (
                partial(controls.head, runs=self._runs), controls.choice, controls.trigger, controls.arrange,
                partial(controls.measuring, shows_numbers=self._shows_numbers),
            ):  # fmt: skip
                self._views.append(control(screen))
                breathe()
            controls.save_menu(self.save)
        self.plot = ui.element("div").classes("scope-plot").mark("scope-plot")
        self.plot.props(f'tabindex=0 role=application aria-label="Oscilloscope. {controls.HELP}" data-test=scope-plot')
        breathe()
        ui.on("scope", self._done)
        self._client.run_javascript(f"axistwinScope.attach({self.plot.id})")
        self._client.on_delete(
            self._views.clear
        )  # To save memory, empty the list of update functions when the page is closed.

    def refresh(self) -> None:
        screen = self.screen
        screen.recorder.catch_up()
        if screen.frozen is not None and to_seconds(screen.frozen.now_ns) > self._context.session.recorded_seconds:
            # Data of the paused screen have been deleted, e.g. by a restart of the simulation, so show live data.
            screen.live()
        for view in self._views:
            view()
        self._frames += 1
        if not self._seen:
            return
        screen.pixels = self._pixels
        state = (
            screen.edges, screen.names, screen.pixels, screen.lanes, screen.cursors.a_ns, screen.cursors.b_ns,
            screen.folded_now, tuple(screen.titles.items()), screen.hit_ns, screen.pointer,
            screen.frozen is None and screen.recorder.version, screen.record.now_ns, id(screen.record),
        )  # fmt: skip
        if state != self._drawn:
            self._drawn = state
            self._all.drawn += 1
            execute(self._client, f"axistwinScope.draw({self.plot.id},{json.dumps(frames.frame(screen))})")

    def _runs(self) -> bool:
        return self._context.actions.state is State.RUNNING

    def _shows_numbers(self) -> bool:
        return self._frames % READOUT_EVERY == 0 or not self._runs()

    # Functions that handle messages from the browser

    def _done(self, event: events.GenericEventArguments) -> None:
        value = event.args if isinstance(event.args, dict) else {}
        screen, place = self.screen, _number(value.get("place"), 0.0, 1.0, 0.5)
        match value.get("do"):
            case "size":
                self._pixels = int(_number(value.get("pixels"), *PIXELS, 800))
            case "seen":
                self._seen = bool(value.get("seen"))
            case "zoom":
                if not self._runs():
                    # Pause the screen, so that the time under the mouse pointer stays in place during the zoom.
                    screen.pause()
                screen.zoom(_number(value.get("factor"), 0.01, 100.0, 1.0), place)
            case "pan":
                screen.pan(_number(value.get("part"), -10.0, 10.0, 0.0))
            case "lane":
                last = len(screen.names) - 1
                lane, to = (int(_number(value.get(key), 0, last, 0)) for key in ("lane", "to"))
                screen.move_lane(lane, to)
            case "hover":
                screen.pointer = None if value.get("place") is None else place
            case "drag":
                screen.put_cursor("b" if value.get("which") == "b" else "a", place, self._lane(value))
            case "click":
                self._click(place, bool(value.get("other")), self._lane(value))
            case "key":
                self._key(str(value.get("key")), bool(value.get("shift")), bool(value.get("alt")))

    def _lane(self, value: dict[str, Any]) -> str | None:
        names = self.screen.names
        if value.get("lane") is None or not self.screen.lanes or not names:
            return None
        return names[int(_number(value["lane"], 0, len(names) - 1, 0))]

    def _click(self, place: float, other: bool, lane: str | None) -> None:
        """Move the active, or the `other`, cursor to a click; the first two clicks set A and B."""
        cursors = self.screen.cursors
        which = {"a": "b", "b": "a"}[cursors.active] if other else cursors.active
        self.screen.put_cursor(which, place, lane)
        if cursors.b_ns is None:
            cursors.active = "b"

    def _key(self, key: str, shift: bool, alt: bool) -> None:
        screen = self.screen
        if key in ("ArrowLeft", "ArrowRight"):
            forward = 1 if key == "ArrowRight" else -1
            if shift:
                screen.move_cursor(forward * (10 if alt else 1))
            else:
                screen.pan(0.1 * forward)
        elif key in KEYS:
            KEYS[key](screen)

    # Saving

    async def save(self, suffix: str, whole: bool) -> None:
        """Save the shown signals in a file for the browser; `whole`: the complete record, not the visible time."""
        screen = self.screen
        signals = {name: screen.recorder.signals[name] for name in screen.tracks}
        from_ns, to_ns = (0, screen.record.now_ns) if whole else screen.edges
        record = screen.frozen or screen.recorder.frozen(screen.names)
        async with self._all.saving:
            try:
                data = await run.io_bound(saved, record, signals, from_ns, to_ns, suffix, screen.cursors.named)
            except AxistwinError as error:
                complain(error)
                return
        if suffix in TRACES and exact_ns(record, signals) > max(from_ns, 0):
            since_s = to_seconds(exact_ns(record, signals))
            ui.notify(
                f"Before {since_s:.6f} s, the file contains only the extremes of intervals, not every change",
                type="warning",
            )
        assert data is not None, "the application is running"
        ui.download.content(data, f"scope{suffix}")


KEYS: dict[str, Callable[[Screen], object]] = {
    "+": lambda screen: screen.zoom(0.5), "=": lambda screen: screen.zoom(0.5), "-": lambda screen: screen.zoom(2.0),
    "a": lambda screen: controls.activate(screen, "a"), "b": lambda screen: controls.activate(screen, "b"),
    "A": lambda screen: controls.activate(screen, "a"), "B": lambda screen: controls.activate(screen, "b"),
    ",": lambda screen: screen.jump_cursor(False), ".": lambda screen: screen.jump_cursor(True),
    "<": lambda screen: screen.jump_cursor(False), ">": lambda screen: screen.jump_cursor(True),
    " ": lambda screen: screen.pause() if screen.frozen is None else screen.live(), "Home": lambda screen: screen.fit(),
    "Escape": lambda screen: controls.clear_cursors(screen), "p": lambda screen: controls.jump_to(screen, False),
    "n": lambda screen: controls.jump_to(screen, True), "l": lambda screen: setattr(screen, "lanes", not screen.lanes),
}  # fmt: skip
SUFFIXES = (*TRACES, *PICTURES)


def _number(value: Any, least: float, most: float, otherwise: float) -> float:
    if isinstance(value, int | float) and isfinite(value):
        return min(max(float(value), least), most)
    return otherwise
