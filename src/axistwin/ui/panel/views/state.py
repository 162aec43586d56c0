"""The state in words, in the header, and the next line, which says what moves or what to do."""

import json
from collections.abc import Awaitable
from functools import partial
from math import ceil

from nicegui import ui

from axistwin.core.units import figures, to_seconds
from axistwin.scenes.sessions.buttons import perform
from axistwin.scenes.sessions.condition import Button, Condition, Kind, condition, next_act
from axistwin.scenes.sessions.session import Session
from axistwin.ui.panel.context import Context, Refresh, seldom, together
from axistwin.ui.panel.turns import breathe

SELDOM, LATE = 6, 10  # Number of frames between two updates of the state, and of the delay.
LATE_SHOWN = 10  # Number of its updates for which a delay is shown, about 5 s.
OLDEST = 10
MOST_BUTTONS = 3
ELSEWHERE = ("run", "restart", "stop", "go")  # What buttons in the header and beside the plan do.
OUTLINE = "outline dense no-caps"
ICONS = {
    Kind.GOING: "fast_forward", Kind.REPLAY: "history", Kind.OFF: "power_settings_new", Kind.STOPPED: "report",
    Kind.RELEASED: "report", Kind.FAULT: "report", Kind.PAUSED: "pause", Kind.INPUT: "schedule",
    Kind.RUNNING: "play_arrow", Kind.COMMAND: "schedule", Kind.ENDED: "stop",
}  # fmt: skip


class Conditions:
    """The condition of a session, found once for all pages and views that show it in a frame."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._key: object = None
        self._age = 0  # Number of frames that the condition is old.
        self.now = Condition(Kind.PAUSED, "")

    def find(self) -> Condition:
        """Return the condition, found anew if something has happened, or after `OLDEST` frames."""
        session = self._session
        key = (
            id(session.bench), session.bench.now, session.running, session.busy, session.repeating, session.waiting,
            session.halted_by, session.journal.bytes,
        )  # fmt: skip
        self._age += 1
        if key != self._key or self._age >= OLDEST:
            self._key, self._age, self.now = key, 0, condition(session)
        return self.now


def wanted(context: Context) -> str:
    """Return the input that the user must change, as "controller.pin"; "" if there is none."""
    return context.common(Conditions).now.pin


def state(context: Context) -> Refresh:
    """Build the title and the state, for the header."""
    conditions = context.common(Conditions)
    known, left = context.session.pacer.delays.overruns, 0
    with ui.element("div").classes("what") as box:
        with ui.element("div").classes("title-row"):
            ui.label(_title(context)).classes("scene-title").props("role=heading aria-level=1").mark("scene-title")
            late = ui.label().classes("late").mark("late")
        with ui.element("div").classes("state"):
            icon = ui.icon("pause").props("aria-hidden=true")
            words = ui.label().props("role=status aria-live=polite data-test=state").mark("state")

    def refresh() -> None:
        now = conditions.find()
        words.text = now.words
        if icon.props["name"] != ICONS[now.kind]:
            icon.props["name"] = ICONS[now.kind]
        _tone(box, now)

    def show_delay() -> None:
        nonlocal known, left
        pacer = context.session.pacer
        left = LATE_SHOWN if pacer.delays.overruns != known else max(0, left - 1)
        known = pacer.delays.overruns
        late.text = (pacer.report() or "") if left and context.session.running else ""

    return together(seldom(context, SELDOM, refresh), seldom(context, LATE, show_delay))


def _title(context: Context) -> str:
    title, controllers = context.session.title, context.bench.controllers
    return controllers[title].product.title if title in controllers else title


def _tone(box: ui.element, now: Condition) -> None:
    if box.props.get("data-tone") != now.tone:
        box.props["data-tone"] = str(now.tone)


def next_line(context: Context) -> Refresh:
    """Build the line that says what moves, or what to do, with the buttons for it."""
    conditions = context.common(Conditions)
    with ui.element("div").classes("next").props('role=group aria-label="next"') as box:
        with ui.element("div").classes("next-words"):
            words = ui.label().classes("now").props("role=status").mark("next-words")
        views = [_acts(context), _planned(context), _undo(context)]  # The plan last: it moves no act.

    def show() -> None:
        words.text = conditions.now.next
        _tone(box, conditions.now)

    return together(seldom(context, SELDOM, show), *views)


def _acts(context: Context) -> Refresh:
    """Build the buttons of the state; at most one is filled."""
    conditions, offered = context.common(Conditions), [Button("", "")] * MOST_BUTTONS

    def press(place: int) -> Awaitable[None] | None:
        button, name = offered[place], conditions.now.controller
        if button.does == "lessons":
            ui.run_javascript(f"axistwinState.lessons({json.dumps(name)})")
            return None
        return context.move(lambda: perform(context.session, button, name))

    made: list[ui.button] = []
    for place in reversed(range(MOST_BUTTONS)):  # The first is at the right, where no other moves it.
        breathe()
        made.insert(0, ui.button(on_click=partial(press, place)).props(OUTLINE).classes("act").mark(f"act-{place}"))
        made[0].set_visibility(False)

    def refresh() -> None:
        found = [each for each in conditions.now.buttons if each.does not in ELSEWHERE]
        for place, element in enumerate(made):
            now = found[place] if place < len(found) else Button("", "")
            if now != offered[place]:
                offered[place] = now
                element.set_visibility(bool(now.label))
                element.text = now.label
                look = ("unelevated", "outline")
                element.props(look[not now.filled], remove=look[now.filled])

    return refresh


def _planned(context: Context) -> Refresh:
    conditions = context.common(Conditions)
    at_s: float | None = None
    with ui.element("div").classes("planned-box") as box:
        text = ui.label().classes("quiet planned").mark("planned")

        def go() -> Awaitable[None] | None:
            return None if at_s is None else context.move(partial(context.session.advance_to, at_s))

        button = ui.button("Go there", on_click=go).props(OUTLINE).mark("go-planned")
    button.tooltip("run at full speed to this time")

    def refresh() -> None:
        nonlocal at_s
        told, planned = conditions.now, next_act(context.bench)
        at_s = None if planned is None else to_seconds(planned[0])
        plan = "" if planned is None or at_s is None else f"{planned[1]} at {figures(at_s)} s"
        text.text = "" if plan[1:] in told.next else "\nat ".join(plan.rsplit(" at ", 1))
        button.set_visibility(at_s is not None)
        if at_s is not None:
            box.classes("kept")  # Its width stays after the last plan, so that no button beside it moves.

    button.set_visibility(False)
    return refresh


def _undo(context: Context) -> Refresh:
    undo = ui.button("Undo", icon="undo", on_click=lambda: context.move(context.session.undo)).props(OUTLINE)
    undo.classes("undo").mark("undo").tooltip("restore the recording that has just been discarded")

    def refresh() -> None:
        left_s = ceil(context.session.undo_seconds)
        undo.set_visibility(bool(left_s))
        if left_s:
            undo.text = f"Undo {context.session.undoes} ({left_s} s)"

    return refresh
