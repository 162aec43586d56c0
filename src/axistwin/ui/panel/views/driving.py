"""The header: that the machine is virtual, its power, its state, and the control of virtual time."""

import json
from collections.abc import Awaitable, Callable, Iterator
from functools import partial

from nicegui import events, ui

from axistwin.core.units import to_seconds
from axistwin.links.pacing import read_speed
from axistwin.scenes.sessions.condition import RUN
from axistwin.scenes.sessions.session import Session
from axistwin.ui.panel.context import Context, Refresh, seldom, together
from axistwin.ui.panel.outbound import execute
from axistwin.ui.panel.turns import breathe
from axistwin.ui.panel.views.faults import power
from axistwin.ui.panel.views.keys import keys
from axistwin.ui.panel.views.more import go_to, more
from axistwin.ui.panel.views.parts import LiveText
from axistwin.ui.panel.views.state import Conditions, state

SPEEDS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, None)
"""Speeds that the keys + and - select."""
OFFERED = (0.1, 1.0, 10.0, 100.0, None)
STEPS = {
    "event": "a level, a message, a motion or a fault changes",
    "character": "an event, where each character of a message is an event",
    "statement": "a line of a program begins",
    "move": "a move begins or ends",
}
STEPS_BY_KEY = {kind[0]: kind for kind in STEPS}
SHOWN = "(event) => emit(event.currentTarget.dataset.shown)"
"""JavaScript that sends the text that the button has when the user clicks it: Run, Pause or Stop."""
FLAT = "flat dense no-caps"
OUTLINE = "outline dense no-caps"
SELDOM = 10  # Number of frames between two updates of the timeline.
FAR_S = 10.0  # Time of a long step back or on.
MOST_MARKS = 60


def driving(context: Context) -> Refresh:
    """Build the contents of the header: one row, on a phone two."""
    views: list[Refresh] = []
    with ui.element("div").classes("ident"):
        ui.label("VIRTUAL").classes("virtual").props('title="There is no hardware here"')
        views += _made(context, *(partial(power, name=name) for name in context.bench.controllers))
    views += _made(context, state, _clock)
    with ui.element("div").classes("run-box").props('role=group aria-label="driving"'):
        button, show_button = _run(context)
        views.append(show_button)
        breathe()
    with ui.element("div").classes("pace"):
        _steps(context)
        breathe()
        views += _made(context, _speed)
    show_keys = keys(lambda key, shown: _drive(context, shown, button) if key == " " else _key(context, key))
    with ui.element("div").classes("end"):
        views += _made(context, _timeline, partial(more, show_keys=show_keys, without_room=_without_room))
    ui.on("timeline", lambda event: _by_key(context, event))
    return together(*views)


def _clock(context: Context) -> Refresh:
    label = LiveText(tag="div", text="").classes("clock").mark("clock").props("data-test=clock")

    def refresh() -> None:
        label.text = f"{context.session.seconds:.{3 if context.session.running else 6}f} s"

    return refresh


def _made(context: Context, *views: Callable[[Context], Refresh]) -> Iterator[Refresh]:
    for view in views:
        yield view(context)
        breathe()


# Running


def _run(context: Context) -> tuple[ui.button, Refresh]:
    button = ui.button().props(OUTLINE).classes("run").mark("run")
    button.on("click", lambda event: _drive(context, event.args, button), js_handler=SHOWN)
    _restart(context, "restart")

    conditions = context.common(Conditions)

    def refresh() -> None:
        text = "Stop" if context.actions.busy else "Pause" if context.session.running else "Run"
        if button.text != text:
            button.text = button.props["data-shown"] = text
            button.set_icon("play_arrow" if text == "Run" else "pause" if text == "Pause" else "stop")
        asked = text == "Run" and RUN in conditions.now.buttons  # Filled, if it is the step that the page asks for.
        if asked is not ("unelevated" in button.props):
            look = ("unelevated", "outline")
            button.props(look[not asked], remove=look[asked])

    return button, refresh


def _restart(context: Context, mark: str) -> None:
    button = ui.button("Restart", icon="replay", on_click=lambda: context.touch(context.session.restart))
    button.props(OUTLINE).classes("restart").mark(mark)
    button.tooltip("begin again at 0 s and run; the recording is discarded, see Undo")


def _without_room(context: Context) -> Refresh:
    """Build what a narrow header leaves out, for the menu: power, Restart and the timeline."""
    with ui.element("div").classes("without-room"):
        with ui.element("div").classes("ident"):
            views = [power(context, name, mark=f"{name}-power-more") for name in context.bench.controllers]
        _restart(context, "restart-more")
        views.append(_timeline(context, "-more"))
    return together(*views)


def _drive(context: Context, shown: object, button: ui.button) -> None:
    """Perform the action that the button named when the user clicked it, even if the state has changed since."""
    session = context.session
    match shown if isinstance(shown, str) else button.text:
        case "Stop":
            context.touch(context.actions.stop, now=True)
        case "Pause":
            context.touch(lambda: session.pause() if session.running else None)
        case _:
            context.touch(lambda: None if session.running else session.run())


def _steps(context: Context) -> None:
    button = (
        ui.button("Step", icon="skip_next").props(f"{FLAT} icon-right=arrow_drop_down").classes("steps").mark("steps")
    )
    with button, ui.menu().classes("pop"):
        for kind, what in STEPS.items():
            breathe()
            item = ui.menu_item(on_click=partial(_step, context, kind)).mark(f"step-{kind}")
            with item.props(f'role=menuitem title="run until {what}"'):
                ui.label(f"to the next {kind}")
                ui.label(kind[0]).classes("key")
        breathe()
        back = ui.menu_item(on_click=lambda: _move_by(context, -FAR_S)).props("role=menuitem").mark("step-back")
        with back:
            ui.label(f"{FAR_S:g} s back")


def _step(context: Context, kind: str) -> Awaitable[None] | None:
    def done(found: object) -> None:
        if found is False:
            ui.notify(f"no such event within 60 virtual seconds: {STEPS[kind]}", type="warning")

    return context.move(lambda: context.session.step(kind), done)


def _key(context: Context, key: str) -> Awaitable[None] | None:
    match key:
        case "+":
            _change_speed(context, 1)
        case "-":
            _change_speed(context, -1)
        case _:
            return _step(context, STEPS_BY_KEY[key])
    return None


# Speed


def _speed(context: Context) -> Refresh:
    shown: float | None = -1.0
    button = ui.button().props(f"{FLAT} icon-right=arrow_drop_down").classes("speed").mark("speed-words")

    def show() -> None:
        nonlocal shown
        shown = context.session.speed
        box.value = _speed_text(shown)
        button.text = "Speed max" if shown is None else f"Speed \u00d7{shown:g}"

    def change(action: Callable[[], object]) -> None:
        context.touch(action, now=True)
        show()  # Show the new simulation speed at once, not only at the next update of the page.

    with button, ui.menu().props("no-focus role=dialog aria-label=speed").classes("pop"):
        for speed in OFFERED:
            breathe()
            item = ui.menu_item(on_click=lambda s=speed: change(lambda: _set_speed(context, s)))
            with item.props("role=button").mark(f"speed-{_speed_text(speed)}"):
                ui.label("as fast as possible" if speed is None else f"\u00d7{speed:g}")
        box = ui.input("times real time, or max", value=_speed_text(context.session.speed))
        box.props('dense outlined aria-label="times real time"').mark("speed-box")
        box.on("keydown.enter", lambda: change(lambda: _set_speed(context, read_speed(box.value.strip()))))

    def refresh() -> None:
        if context.session.speed != shown:
            show()

    return refresh


def _speed_text(speed: float | None) -> str:
    return "max" if speed is None else f"{speed:g}"


def _nearest(speed: float | None) -> int:
    if speed is None:
        return len(SPEEDS) - 1
    return min(range(len(SPEEDS) - 1), key=lambda n: abs((SPEEDS[n] or 0.0) - speed))


def _set_speed(context: Context, speed: float | None) -> None:
    context.session.speed = speed


def _change_speed(context: Context, by: int) -> None:
    place = _nearest(context.session.speed) + by
    context.touch(lambda: _set_speed(context, SPEEDS[min(max(place, 0), len(SPEEDS) - 1)]), now=True)


# Time


def _by_key(context: Context, event: events.GenericEventArguments) -> Awaitable[None] | None:
    by_s = event.args.get("by") if isinstance(event.args, dict) else None
    return _move_by(context, by_s) if by_s in (-FAR_S, -1, 1, FAR_S) else None


def _move_by(context: Context, by_s: float) -> Awaitable[None] | None:
    session = context.session
    return context.move(lambda: session.go_to(min(max(session.seconds + by_s, 0.0), session.recorded_seconds)))


def _timeline(context: Context, suffix: str = "") -> Refresh:
    with ui.element("div").classes("past"):
        marks = ui.element("div").classes("marks").props("aria-hidden=true")
        slider = ui.slider(min=0, max=1, value=1, step=0.001).props('aria-label="moment, in seconds" thumb-size=14px')
        slider.classes("timeline").mark(f"timeline{suffix}")
        ui.label("0 s").classes("from")
        words = ui.label().classes("to").mark(f"time-words{suffix}")
        ui.element("div").classes("pointed").props("aria-hidden=true")
    held = False  # True while the user holds the slider: no frame resets the value before the user releases it.
    shown: object = None

    def hold(on: bool) -> None:
        nonlocal held
        held = on

    def release(event: events.GenericEventArguments) -> Awaitable[None] | None:
        hold(False)
        return go_to(context, float(event.args))

    slider.on("pointerdown", lambda: hold(True), []).on("pointercancel", lambda: hold(False), [])
    slider.on("change", release)

    def refresh() -> None:
        nonlocal shown
        end = max(round(context.session.recorded_seconds, 3), 0.001)
        if not held:
            # Only changed values are assigned, because each assignment is sent to the browser.
            if slider.props["max"] != end:
                slider.props["max"] = end
            repeats = context.session.repeating
            slider.value = round(context.session.seconds, 3) if repeats else end
            words.text = f"{end:,.1f} s" if repeats else "live"
        now = [(round(at / end, 4), alarm) for at, alarm in _marks(context.session, end)]
        if now != shown:
            shown = now
            execute(marks.client, f"axistwinState.marks({marks.id},{json.dumps(now)})")

    return seldom(context, SELDOM, refresh)


def _marks(session: Session, end: float) -> list[tuple[float, bool]]:
    """Return the times of the latest planned actions and begun faults in the recording; True for a fault."""
    planned = [(to_seconds(at_ns), False) for at_ns, _ in session.bench.planned]
    faults = [(to_seconds(fault.began_ns), True) for fault in session.bench.faults if fault.began_ns is not None]
    return sorted((at, alarm) for at, alarm in (*planned, *faults) if at <= end)[-MOST_MARKS:]
