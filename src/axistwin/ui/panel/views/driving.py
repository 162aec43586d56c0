"""Toolbars that control virtual time, breakpoints and saving of the session."""

import io
import zipfile
from collections.abc import Awaitable, Callable, Iterator
from functools import partial
from math import ceil

from nicegui import events, ui

from axistwin.bench import Bench, endpoints
from axistwin.core.errors import UsageError
from axistwin.core.numbers import NumberError, real, shortened
from axistwin.core.units import figures, to_seconds
from axistwin.links.pacing import read_speed
from axistwin.scenes.sessions.breaks import Break
from axistwin.ui.panel.context import Context, Refresh, seldom, together
from axistwin.ui.panel.turns import breathe
from axistwin.ui.panel.views.darkness import darkness
from axistwin.ui.panel.views.keys import keys
from axistwin.ui.panel.views.parts import LiveText
from axistwin.ui.panel.views.people import people

SPEEDS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, None)
"""Speeds that the slider can select; the text field accepts all speeds."""
STEPS = {
    "event": "a level, a message, a motion or a fault changes",
    "character": "an event, where each character of a message is an event",
    "statement": "a line of a program begins",
    "move": "a move begins or ends",
}
STEPS_BY_KEY = {kind[0]: kind for kind in STEPS}
SHOWN = "(event) => emit(event.currentTarget.dataset.shown)"
"""JavaScript that sends the text that the button has when the user clicks it: Run, Pause or Stop."""
UNFOLD = "document.documentElement.classList.toggle('more', {on})"
"""JavaScript that shows or hides the rarely used controls on a narrow screen."""
OUTLINE = "dense outline no-caps color=white"
SELDOM = 10  # Number of frames between two updates of delay and timeline.


def driving(context: Context) -> Refresh:
    with ui.row().classes("driving").props('role=toolbar aria-label="driving"'):
        ui.label("VIRTUAL").classes("virtual").tooltip("There is no hardware here")
        show_clock = _clock(context)
        breathe()
        button, show_button = _run(context)
        breathe()
        views = [show_clock, show_button, *_made(context, _speed)]
        _more(context)
    with ui.row().classes("driving").props('role=toolbar aria-label="time"'):
        views += _made(context, _timeline, _until, _breaks)
        _save(context)
        breathe()
        keys(lambda key, shown: _drive(context, shown, button) if key == " " else _key(context, key))
    with ui.row().classes("driving status"):
        breathe()
        views.append(_status(context))
        breathe()
        with ui.row().classes("driving visitor"):
            views.append(people(context))
            darkness(context)
    return together(*views)


def _clock(context: Context) -> Refresh:
    label = LiveText(tag="div", text="").classes("clock").mark("clock").props("data-test=clock")

    def refresh() -> None:
        label.text = f"{context.session.seconds:.{3 if context.session.running else 6}f} s"

    return refresh


def _more(context: Context) -> None:
    settings = context.person.settings

    def show() -> None:
        ui.run_javascript(UNFOLD.format(on="true" if settings.get("more") else "false"))

    def fold() -> None:
        settings["more"] = not settings.get("more")
        show()

    if settings.get("more"):
        show()
    ui.button(icon="tune", on_click=fold).props('flat dense color=white aria-label="more controls"').classes("more")


def _made(context: Context, *views: Callable[[Context], Refresh]) -> Iterator[Refresh]:
    for view in views:
        yield view(context)
        breathe()


# Running


def _run(context: Context) -> tuple[ui.button, Refresh]:
    button = ui.button().props("dense no-caps").classes("run").mark("run")
    button.on("click", lambda event: _drive(context, event.args, button), js_handler=SHOWN)
    restart = ui.button("Restart", icon="replay", on_click=lambda: context.touch(context.session.restart))
    restart.props(OUTLINE).mark("restart").tooltip("begin again at 0 s and run; the recording is discarded, see Undo")
    for kind, what in STEPS.items():
        step = ui.button(kind, icon="skip_next", on_click=lambda kind=kind: _step(context, kind))
        breathe()
        step.props(OUTLINE).classes("rest").mark(f"step-{kind}").tooltip(f"run until {what}")

    def refresh() -> None:
        text = "Stop" if context.actions.busy else "Pause" if context.session.running else "Run"
        if button.text != text:
            button.text = button.props["data-shown"] = text
            button.set_icon("play_arrow" if text == "Run" else "pause")

    return button, refresh


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
    words = ui.label().classes("slider-words rest").mark("speed-words")
    slider = ui.slider(min=0, max=len(SPEEDS) - 1, step=1).props('snap aria-label="speed"')
    slider.classes("speed rest").mark("speed")
    box = ui.input(value=_speed_text(context.session.speed)).props('dense outlined aria-label="times real time"')
    box.classes("speed-box rest").mark("speed-box").tooltip("times real time, or max")
    shown: float | None = -1.0

    def show() -> None:
        nonlocal shown
        shown = context.session.speed
        box.value, slider.value = _speed_text(shown), _nearest(shown)
        words.text = "speed max" if shown is None else f"speed \u00d7{shown:g}"

    def change(action: Callable[[], object]) -> None:
        context.touch(action, now=True)
        show()  # Show the new simulation speed at once, not only at the next update of the page.

    slider.on("change", lambda event: change(lambda: _set_speed(context, SPEEDS[round(event.args)])))
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


# State


def _status(context: Context) -> Refresh:
    ui.label(context.session.title).classes("title scene-title").mark("scene-title")
    words = ui.label().classes("state").props("role=status aria-live=polite data-test=state").mark("state")
    late = ui.label().classes("quiet late").mark("late")
    views = [_planned(context), _deleted(context)]

    def show_delay() -> None:
        late.text = context.session.pacer.report() or ""

    def refresh() -> None:
        words.text = _in_words(context)

    return together(refresh, *views, seldom(context, SELDOM, show_delay))


def _planned(context: Context) -> Refresh:
    text = ui.label().classes("quiet planned").mark("planned")
    at_s: float | None = None

    def go() -> Awaitable[None] | None:
        return None if at_s is None else context.move(partial(context.session.advance_to, at_s))

    button = ui.button("Go there", on_click=go).props(OUTLINE).mark("go-planned")
    button.tooltip("run at full speed to this time")

    def refresh() -> None:
        nonlocal at_s
        now = context.bench.now
        time_ns, what = min(((at, what) for at, what in context.bench.planned if at > now), default=(0, ""))
        at_s = to_seconds(time_ns) if what else None
        text.text = "" if at_s is None else f"{what} at {figures(at_s)} s"
        button.set_visibility(at_s is not None)

    button.set_visibility(False)
    return refresh


def _deleted(context: Context) -> Refresh:
    forget = ui.button("Live from here", on_click=lambda: context.touch(context.session.forget_rest)).props(OUTLINE)
    forget.mark("forget").tooltip("end the replay and discard the rest of the recording")
    undo = ui.button("Undo", icon="undo", on_click=lambda: context.move(context.session.undo)).props(OUTLINE)
    undo.mark("undo").tooltip("restore the recording that has just been discarded")

    def refresh() -> None:
        left_s = ceil(context.session.undo_seconds)
        undo.set_visibility(bool(left_s))
        if left_s:
            undo.text = f"Undo ({left_s} s)"
        forget.set_visibility(context.session.repeating)

    return refresh


def _in_words(context: Context) -> str:
    session = context.session
    if session.progress is not None:
        return f"replaying the run: {session.progress:.0%}"
    if session.busy:
        return "moving"
    if session.waiting:
        return "paused at 0 s until a browser or a host connects"
    repeating = ", replaying the recording" if session.repeating else ""
    if session.running:
        return f"running{repeating}" if repeating or not session.finished else "running: the scene has finished"
    return f"paused{repeating}" + (f": {session.halted_by}" if session.halted_by else "")


# Time


def _timeline(context: Context) -> Refresh:
    words = ui.label().classes("slider-words time-words").mark("time-words")
    slider = ui.slider(min=0, max=1, step=0.001).props('aria-label="moment, in seconds"')
    slider.classes("timeline").mark("timeline")
    box = ui.input(placeholder="seconds").props('dense outlined aria-label="go to this moment"')
    box.classes("moment rest").mark("moment")
    held = False  # True while the user holds the slider: no frame resets the value before the user releases it.

    def hold(on: bool) -> None:
        nonlocal held
        held = on

    def release(event: events.GenericEventArguments) -> Awaitable[None] | None:
        hold(False)
        return _go_to(context, float(event.args))

    slider.on("pointerdown", lambda: hold(True), []).on("pointercancel", lambda: hold(False), [])
    slider.on("change", release)
    box.on("keydown.enter", lambda: _go_to(context, box.value))

    def refresh() -> None:
        if not held:
            end = max(round(context.session.recorded_seconds, 3), 0.001)
            # Only changed values are assigned, because each assignment is sent to the browser.
            if slider.props["max"] != end:
                slider.props["max"] = end
                words.text = f"time 0 \u2026 {end:,.1f} s"
            slider.value = round(context.session.seconds, 3)

    return seldom(context, SELDOM, refresh)


def _go_to(context: Context, moment: float | str) -> Awaitable[None] | None:
    return context.move(lambda: context.session.go_to(_seconds(moment)))


def _seconds(moment: float | str) -> float:
    try:
        return real(str(moment))
    except NumberError:
        raise UsageError(f"invalid time {shortened(str(moment))}: expected seconds, e.g. 1.5") from None


# Sentences


def _stems(bench: Bench) -> list[str]:
    found = []
    for name, controller in bench.controllers.items():
        found += [f"{name}.{axis} passes 0" for axis in controller.axes]
        found += [f"{name}.{pin} {verb}" for pin in controller.pins for verb in ("rises", "falls", "changes")]
        if controller.alarms is not None:
            found += [f"{name} raises {flag}" for flag in controller.alarms.names]
        found += [f"{name} runs 1"] if controller.programs else []
    for name in endpoints.names(bench):
        found += [f"{name} hears ", f"{name} says "]
    return found + [f"{fault} {verb}" for fault in bench.faults.names for verb in ("begins", "ends")]


def _until(context: Context) -> Refresh:
    def run() -> None:
        context.touch(lambda: context.session.run_until(box.value.strip()))

    box = ui.input(placeholder="run until …", autocomplete=_stems(context.bench)).on("keydown.enter", run)
    box.props('dense outlined aria-label="run until"').classes("sentence rest").mark("until")
    box.tooltip("e.g. table.X passes 1000, table.output1 rises, or motor runs 12")
    ui.button("Until", on_click=run).props(OUTLINE).classes("rest").mark("run-until")
    return lambda: None


def _breaks(context: Context) -> Refresh:
    button = ui.button("Breaks", icon="pan_tool").props(OUTLINE).classes("rest").mark("breaks")
    with button, ui.menu().props("no-focus"), ui.column().classes("breaks-menu"):
        box = ui.input("stop whenever", autocomplete=_stems(context.bench)).classes("sentence").mark("new-break")
        box.on("keydown.enter", lambda: context.touch(lambda: context.session.add_break(box.value.strip())))
        those = ui.column().mark("those-breaks")
    shown: list[tuple[str, bool, int]] = []

    def refresh() -> None:
        nonlocal shown
        now = [(each.sentence, each.on, each.hits) for each in context.session.breaks]
        if now != shown:
            shown = now
            button.text = f"Breaks ({len(now)})" if now else "Breaks"
            _list_breaks(context, those)

    return refresh


def _list_breaks(context: Context, those: ui.column) -> None:
    those.clear()
    with those:
        for each in context.session.breaks:
            with ui.row().classes("break"):
                ui.checkbox(each.sentence, value=each.on, on_change=partial(_switch, context, each))
                ui.label(f"{each.hits} times" if each.hits != 1 else "once").classes("quiet")
                ui.button(icon="delete", on_click=partial(_remove, context, each)).props(
                    'flat dense aria-label="remove"'
                )


def _switch(context: Context, each: Break, event: events.ValueChangeEventArguments[bool | None]) -> None:
    context.touch(lambda: setattr(each, "on", bool(event.value)), now=True)


def _remove(context: Context, each: Break) -> None:
    context.touch(lambda: context.session.remove_break(each), now=True)


# Saving


def _save(context: Context) -> None:
    button = (
        ui.button("Save", icon="save", on_click=lambda: _download(context)).props(OUTLINE).classes("rest").mark("save")
    )
    button.tooltip("save the session, with the messages of all hosts, as a scene that repeats it")


def _download(context: Context) -> None:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in context.session.save().items():
            archive.writestr(name, text)
    ui.download.content(packed.getvalue(), "session.zip")
