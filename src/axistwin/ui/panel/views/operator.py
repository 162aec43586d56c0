"""The operator panel of a scene: its buttons, lamps and selector switches, drawn as on a machine."""

from functools import partial

from nicegui import ui

from axistwin.scenes.tables import ButtonTable, LampTable, OperatorTable, SelectorTable
from axistwin.sim.pins import Pin
from axistwin.ui.drawings.buttons import LAMP, MUSHROOM, PUSH, START
from axistwin.ui.panel.context import Context, Refresh, together
from axistwin.ui.panel.views.parts import Key, called
from axistwin.ui.panel.views.state import wanted

OTHER = {"high": "low", "low": "high"}


def operator(context: Context) -> Refresh:
    panel = context.session.operator
    ui.label("Operator panel").classes("desk-title").props("role=heading aria-level=2")
    buttons = sorted(panel.button, key=lambda each: not is_stop(each))
    shown = [_button(context, each) for each in buttons]
    shown += [_selector(context, each) for each in panel.selector]
    shown += [_lamp(context, each) for each in panel.lamp]
    return together(*shown)


def inscriptions(panel: OperatorTable) -> dict[str, str]:
    """Return the names on the operator panel by terminal, as "controller.pin"."""
    found = {each.pin: each.name for each in panel.lamp} | {each.pin: each.name for each in panel.button}
    for selector in panel.selector:
        found |= {pin: f"{selector.name}: {word}" for word, pin in selector.positions.items() if pin}
    return found


def is_stop(button: ButtonTable) -> bool:
    """True for an emergency stop: a latching button at the input for it, or with this name."""
    return button.latching and (button.pin.endswith(".estop") or "emergency" in button.name.lower())


def _pin(context: Context, name: str) -> Pin:
    who, _, pin = name.rpartition(".")
    return context.bench[who].pins[pin]


def _set(context: Context, name: str, level: str) -> None:
    who, _, pin = name.rpartition(".")
    context.session.do(who, pin, level)


class _Control(ui.element):
    """A part of the operator panel: its picture, its name, and its state in one word."""

    def __init__(self, tag: str, name: str, picture: str) -> None:
        super().__init__(tag)
        self.classes("op")
        self._name, self._word = name, ""
        with self:
            ui.html(picture, sanitize=False).classes("op-picture").props("aria-hidden=true")
            with ui.element("span").classes("op-words"):
                ui.label(name).classes("op-name")
                self._told = called(ui.label().classes("op-state"), f"operator-{name}-word")

    def show(self, on: bool, word: str, level: bool, *, is_button: bool) -> None:
        if word == self._word:
            return
        self._word = self._told.text = word
        self.props["title"] = "high" if level else "low"
        if is_button:
            self.props["aria-pressed"] = "true" if on else "false"
        else:
            self.props["aria-label"] = f"{self._name}: {word}"
        self.classes(**{"add" if on else "remove": "lit"})

    def want(self, on: bool) -> None:
        if on is not ("wanted" in self.classes):
            self.classes(**{"add" if on else "remove": "wanted"})


def _button(context: Context, table: ButtonTable) -> Refresh:
    def is_pressed() -> bool:
        return _pin(context, table.pin).level is (table.pressed == "high")

    def press(on: bool) -> None:
        if on is not is_pressed():
            context.touch(partial(_set, context, table.pin, table.pressed if on else OTHER[table.pressed]))

    stop = is_stop(table)
    picture = MUSHROOM if stop else START if "start" in table.name.lower() else PUSH
    key = called(_Control("button", table.name, picture), f"operator-{table.name}")
    key.classes("stop" if stop else "push").props("type=button")
    if table.latching:
        key.on("click", lambda: press(not is_pressed()), [])
    else:
        for event in ("pointerdown", "keydown.enter", "keydown.space"):
            key.on(event, lambda: press(True), [])
        for event in ("pointerup", "pointerleave", "keyup.enter", "keyup.space", "blur"):
            key.on(event, lambda: press(False), [])

    def refresh() -> None:
        on = is_pressed()
        word = "released" if not on else "pressed: click to release" if table.latching else "pressed"
        key.show(on, word, _pin(context, table.pin).level, is_button=True)
        key.want(wanted(context) == table.pin)

    return refresh


def _lamp(context: Context, table: LampTable) -> Refresh:
    light = called(_Control("div", table.name, LAMP), f"operator-{table.name}").classes("lamp-row").props("role=img")

    def refresh() -> None:
        level = _pin(context, table.pin).level
        on = level is (table.lit == "high")
        light.show(on, "on" if on else "off", level, is_button=False)

    return refresh


def _selector(context: Context, table: SelectorTable) -> Refresh:
    def select(word: str) -> None:
        for each, pin in table.positions.items():
            if pin and each != word:
                _set(context, pin, OTHER[table.selected])
        if table.positions[word]:
            _set(context, table.positions[word], table.selected)

    def is_on(pin: str) -> bool:
        return bool(pin) and _pin(context, pin).level is (table.selected == "high")

    with ui.element("div").classes("op selector").props(f'role=group aria-label="{table.name}"'):
        with ui.element("span").classes("keys"):
            keys = {word: _key(context, table, word, partial(select, word)) for word in table.positions}
        ui.label(table.name).classes("op-name")

    def refresh() -> None:
        some = any(is_on(pin) for pin in table.positions.values())
        for word, key in keys.items():
            pin = table.positions[word]
            key.show(is_on(pin) if pin else not some)

    return refresh


def _key(context: Context, table: SelectorTable, word: str, select: Refresh) -> Key:
    key = Key(word, f"{table.name}: {word}", lambda: context.touch(select))
    return called(key, f"operator-{table.name}-{word}")
