"""The operator panel of a scene: its buttons, lamps and selector switches."""

from functools import partial

from nicegui import ui

from axistwin.scenes.tables import ButtonTable, LampTable, SelectorTable
from axistwin.sim.pins import Pin
from axistwin.ui.panel.context import Context, Refresh, together
from axistwin.ui.panel.views.parts import Key, Light, called

OTHER = {"high": "low", "low": "high"}


def operator(context: Context) -> Refresh:
    panel = context.session.operator
    ui.label("Operator panel").classes("machine-name")
    with ui.element("div").classes("operator"):
        shown = [_button(context, each) for each in panel.button]
        shown += [_lamp(context, each) for each in panel.lamp]
        shown += [_selector(context, each) for each in panel.selector]
    return together(*shown)


def _pin(context: Context, name: str) -> Pin:
    who, _, pin = name.rpartition(".")
    return context.bench[who].pins[pin]


def _set(context: Context, name: str, level: str) -> None:
    who, _, pin = name.rpartition(".")
    context.session.do(who, pin, level)


def _button(context: Context, table: ButtonTable) -> Refresh:
    def is_pressed() -> bool:
        return _pin(context, table.pin).level is (table.pressed == "high")

    def press(on: bool) -> None:
        if on is not is_pressed():
            context.touch(partial(_set, context, table.pin, table.pressed if on else OTHER[table.pressed]))

    with ui.element("div").classes("control"):
        key = Key("", table.name, (lambda: press(not is_pressed())) if table.latching else lambda: None)
        called(key.classes("round"), f"operator-{table.name}")
        if not table.latching:
            for event in ("pointerdown", "keydown.enter", "keydown.space"):
                key.on(event, lambda: press(True), [])
            for event in ("pointerup", "pointerleave", "keyup.enter", "keyup.space", "blur"):
                key.on(event, lambda: press(False), [])
        ui.label(table.name).classes("control-name")
        why = called(ui.label().classes("why"), f"operator-{table.name}-level")

    def refresh() -> None:
        key.show(is_pressed())
        level = "high" if _pin(context, table.pin).level else "low"
        why.text = f"{'pressed' if is_pressed() else 'free'}, {level}"

    return refresh


def _lamp(context: Context, table: LampTable) -> Refresh:
    with ui.element("div").classes("control"):
        light = called(Light(table.name, table.name), f"operator-{table.name}")
        ui.label(table.name).classes("control-name")
        why = ui.label(table.pin).classes("why")
        why.props["aria-hidden"] = "true"
    return lambda: light.show(_pin(context, table.pin).level is (table.lit == "high"))


def _selector(context: Context, table: SelectorTable) -> Refresh:
    def select(word: str) -> None:
        for each, pin in table.positions.items():
            if pin and each != word:
                _set(context, pin, OTHER[table.selected])
        if table.positions[word]:
            _set(context, table.positions[word], table.selected)

    def is_on(pin: str) -> bool:
        return bool(pin) and _pin(context, pin).level is (table.selected == "high")

    with ui.element("div").classes("control"):
        with ui.element("span").classes("keys"):
            keys = {word: _key(context, table, word, partial(select, word)) for word in table.positions}
        ui.label(table.name).classes("control-name")
        ui.label().classes("why")

    def refresh() -> None:
        some = any(is_on(pin) for pin in table.positions.values())
        for word, key in keys.items():
            pin = table.positions[word]
            key.show(is_on(pin) if pin else not some)

    return refresh


def _key(context: Context, table: SelectorTable, word: str, select: Refresh) -> Key:
    key = Key(word, f"{table.name}: {word}", lambda: context.touch(select))
    return called(key, f"operator-{table.name}-{word}")
