"""Controls for the inputs of a controller: digital and analog inputs, joystick, external encoder and DTR and RTS."""

from collections.abc import Callable
from functools import partial

from nicegui import events, ui

from axistwin.bench import Controller
from axistwin.bench.actions import targets
from axistwin.sim.pins import FULL_SCALE, PULLED_UP_VOLTS, Pin, UserPin
from axistwin.ui.panel.context import Context, Refresh, together
from axistwin.ui.panel.views.faults import ambient
from axistwin.ui.panel.views.parts import Key, Light, called
from axistwin.ui.panel.views.table import tool_choice

LEVELS = {"high": True, "low": False}
HOST_LINES = ("dtr", "rts")
STEP_V = 0.05
THROTTLE_S = 0.1  # Shortest time between two messages from a slider or a joystick.
ARROWS = {"ArrowRight": 1, "ArrowUp": 1, "ArrowLeft": -1, "ArrowDown": -1}
GENTLY = 0.2  # Deflection of the joystick while an arrow key is pressed without Shift; with Shift, it is 1.


def pins(context: Context, name: str) -> Refresh:
    controller = context.bench[name]
    possible = targets(controller)
    shown: list[Refresh] = []
    if controller.product.joystick is not None:
        shown.append(_Joystick(context, name, controller.product.joystick.usual).refresh)
    with ui.element("div").classes("switches"):
        shown += [_terminal(context, name, names) for names in inputs(controller)]
        shown += [_host_line(context, name, line) for line in HOST_LINES if line in possible]
    if "master" in possible:
        _encoder(context, name)
    tool_choice(context, name)
    if "ambient" in possible:
        shown.append(ambient(context, name))
    return together(*shown)


def inputs(controller: Controller) -> list[list[str]]:
    found: dict[Pin, list[str]] = {}
    for name, pin in controller.pins.items():
        if pin.drivable:
            found.setdefault(pin, []).append(name)
    return list(found.values())


def _terminal(context: Context, name: str, names: list[str]) -> Refresh:
    pin_name = names[0]
    analog = isinstance(context.bench[name].pins[pin_name], UserPin)
    with ui.element("div").classes("switch analog" if analog else "switch") as row:
        row.props.update({"role": "group", "aria-label": f"{name}.{pin_name}"})
        light = called(Light(", ".join(names), f"{pin_name} high"), f"{name}-{pin_name}-level")
        why = called(ui.label().classes("why"), f"{name}-{pin_name}-why")
        with ui.element("span").classes("keys"):
            keys = {word: _key(context, name, pin_name, word) for word in (*LEVELS, "release")}
        volts = _volts(context, name, pin_name) if analog else None

    def refresh() -> None:
        pin = context.bench.controllers[name].pins[pin_name]
        light.show(pin.level)
        why.text = _decides(pin)
        now = _pressed(pin)
        for level, key in keys.items():
            key.show(level == now)
        if volts is not None and isinstance(pin, UserPin):
            volts(pin)

    return refresh


def _pressed(pin: Pin) -> str:
    if not pin.driven:
        return "release"
    if isinstance(pin, UserPin) and 0 < pin.volts < PULLED_UP_VOLTS:
        return ""
    return "high" if pin.level else "low"


def _decides(pin: Pin) -> str:
    if pin.held:
        return "stuck"
    if pin.driven:
        return "driven"
    if pin.is_output:
        return "output"
    return "wired" if pin.wired else ""


def _key(context: Context, name: str, target: str, word: str) -> Key:
    def press() -> None:
        context.touch(partial(context.session.do, name, target, word))

    return called(Key(word, f"{word} {name}.{target}", press), f"{name}-{target}-{word}")


def _volts(context: Context, name: str, pin_name: str) -> Callable[[UserPin], None]:
    known: float | None = None

    def moved(event: events.GenericEventArguments) -> None:
        nonlocal known
        context.touch(partial(context.session.do, name, pin_name, f"{float(event.args):.2f}V"))
        pin = context.bench[name].pins[pin_name]
        known = float(event.args) if isinstance(pin, UserPin) and pin.volts == float(event.args) else None

    slider = ui.slider(min=0, max=PULLED_UP_VOLTS, step=STEP_V, value=0).classes("volts")
    called(slider, f"{name}-{pin_name}-volts")
    slider.props["aria-label"] = f"{name}.{pin_name} volts"
    # The last value comes when the slider is let go, not later, when the terminal may have been released.
    slider.on("update:model-value", moved, throttle=THROTTLE_S, trailing_events=False).on("change", moved)
    figure = called(ui.label().classes("figure"), f"{name}-{pin_name}-figure")
    figure.props["title"] = f"0 to {FULL_SCALE} are 0 to {PULLED_UP_VOLTS:g} V"

    def show(pin: UserPin) -> None:
        nonlocal known
        if pin.volts != known:
            known = slider.value = pin.volts
        figure.text = f"{pin.volts:.2f} V = {pin.analog}"

    return show


def _host_line(context: Context, name: str, line: str) -> Refresh:
    with ui.element("div").classes("switch") as row:
        row.props.update({"role": "group", "aria-label": f"{name} host's {line.upper()}"})
        light = called(Light(f"host {line.upper()}", f"host's {line.upper()} on"), f"{name}-host-{line}-level")
        with ui.element("span").classes("keys"):
            keys = {word: _key(context, name, line, word) for word in LEVELS}

    def refresh() -> None:
        host = context.bench.controllers[name].ports[name].host
        level = (host.dtr_line if line == "dtr" else host.rts_line).level
        light.show(level)
        for word, key in keys.items():
            key.show(LEVELS[word] is level)

    return refresh


def _encoder(context: Context, name: str) -> None:
    with ui.row().classes("encoder items-center"):
        ui.label("External encoder")
        counts = called(ui.number("counts", value=2000, precision=0).props("dense"), f"{name}-master-counts")
        seconds = called(ui.number("in seconds", value=1, min=0.001).props("dense"), f"{name}-master-seconds")

        def turn() -> None:
            run = f"{int(counts.value or 0)} in {float(seconds.value or 0):.6f}"
            context.touch(partial(context.session.do, name, "master", run))

        called(Key("turn", f"turn the external encoder of {name}", turn), f"{name}-master-turn")


# Joystick


class _Joystick:
    def __init__(self, context: Context, name: str, most: int) -> None:
        self._context, self._name, self._most, self._client = context, name, most, ui.context.client
        self._held = 0  # Pulse rate that this page has set.
        with ui.element("div").classes("stick-row"):
            self._box = ui.element("div").classes("stick")
            self._label = called(ui.label().classes("figure"), f"{name}-joystick-rate")
        with self._box:
            self._build()
        self._client.on_disconnect(self._release)

    def refresh(self) -> None:
        rate = self._context.bench.controllers[self._name].joystick.rate
        text = f"joystick: {rate} pulses/s" if rate else "joystick: at zero"
        if self._label.text != text:
            self._label.text = text
            self._box.props["aria-valuenow"] = rate

    def _build(self) -> None:
        box, name = self._box, self._name
        box.props.update({"tabindex": "0", "role": "slider", "aria-label": f"joystick of {name}, by arrow keys"})
        box.props.update({"aria-valuemin": -self._most, "aria-valuemax": self._most, "aria-valuenow": 0})
        box.on("keydown", self._pressed, ["key", "repeat", "shiftKey"]).on("keyup", lambda: self._deflect(0), [])
        called(box.on("blur", lambda: self._deflect(0), []), f"{name}-stick")
        ui.joystick(
            on_move=lambda event: self._deflect(event.x or 0), on_end=lambda: self._deflect(0), throttle=THROTTLE_S,
            color="#1d5a96", size=90, mode="static", position={"left": "50%", "top": "50%"},
        ).mark(f"{name}-joystick")  # fmt: skip

    def _deflect(self, part: float) -> None:
        """Set the deflection of the joystick; full deflection is -1 or 1."""
        context, rate = self._context, round(part * 50) * self._most // 50
        if rate != self._held and context.touch(partial(context.session.do, self._name, "joystick", str(rate))):
            self._held = rate

    def _pressed(self, event: events.GenericEventArguments) -> None:
        if event.args["key"] in ARROWS and not event.args.get("repeat"):
            self._deflect(ARROWS[event.args["key"]] * (1 if event.args.get("shiftKey") else GENTLY))

    def _release(self) -> None:
        """Release the joystick.  Called when the browser disconnects."""
        if self._held and self._context.drives:
            with self._client:
                self._deflect(0)
