"""Power switches, ambient temperatures, the list of faults, and the form to inject a fault."""

import shlex
from functools import partial
from typing import Any

from nicegui import ui

from axistwin.bench.faults.injector import Fault, State
from axistwin.bench.faults.kinds import KINDS, THINGS
from axistwin.bench.faults.table import Kind, Parameter, Sort
from axistwin.core.units import to_seconds
from axistwin.ui.panel.context import Context, Refresh
from axistwin.ui.panel.views.parts import Key, called, drawer

TERMS = {
    "at": ("at", "s", "virtual time in seconds; empty: now"),
    "when": ("when", "", "a sentence, e.g. X passes 1000"),
    "nth": ("for the n-th time", "", "number of times that the sentence comes true; empty: 1"),
    "duration": ("for", "s", "seconds; empty: until the fault is removed"),
    "seed": ("seed", "", "seed of random values"),
    "name": ("name", "", "empty: the name of the kind"),
}
CELSIUS = (-40, 150)


def power(context: Context, name: str, mark: str = "") -> Refresh:
    def turn() -> None:
        word = "off" if context.bench[name].powered else "on"
        context.touch(partial(context.session.do, name, "power", word))

    key = called(Key("Power off", f"power of {name}", turn).classes("power"), mark or f"{name}-power")
    whose = f"{name}: " if len(context.bench.controllers) > 1 else ""

    def refresh() -> None:
        powered = context.bench.controllers[name].powered
        key.show(powered)
        word = "on" if powered else "off"
        key.text = f"{whose}{word}" if whose else f"Power {word}"
        key.props["aria-label"] = f"{key.text}, power of {name}"

    return refresh


def ambient(context: Context, name: str) -> Refresh:
    """Build the field for the temperature around a motor."""
    known: float | None = None

    def set_it() -> None:
        nonlocal known
        # If the typed temperature is refused, the next page update shows the previous temperature again.
        known = None
        if number.value is not None:
            context.touch(partial(context.session.do, name, "ambient", f"{number.value:g}"))

    number = ui.number("ambient, °C", min=CELSIUS[0], max=CELSIUS[1], step=1).props("dense").classes("ambient")
    called(number.on("change", set_it, []).on("keydown.enter", set_it, []), f"{name}-ambient")

    def refresh() -> None:
        nonlocal known
        celsius = context.bench.controllers[name].ambient
        if celsius != known:
            known = number.value = celsius

    return refresh


def faults(context: Context) -> Refresh:
    with ui.element("div").classes("faults-box").props("role=region aria-label=faults"):
        shown = _list(context)
        with drawer(context, "faults form", "Inject a fault"):
            _Form(context)
    return shown


# The list


def _list(context: Context) -> Refresh:
    box = called(ui.element("ul").classes("faults"), "faults")
    box.props["aria-label"] = "faults"
    known: list[tuple[str, State]] | None = None

    def refresh() -> None:
        nonlocal known
        now = [(fault.name, fault.state) for fault in context.bench.faults]
        if now == known:
            return
        known = now
        box.clear()
        with box:
            for fault in context.bench.faults:
                _row(context, fault)
            if not now:
                with ui.element("li"):
                    ui.label("No faults.").classes("quiet")

    return refresh


def _row(context: Context, fault: Fault) -> None:
    name, who = fault.name, _who(context, fault.spot.name)
    began = "" if fault.began_ns is None else f" since {to_seconds(fault.began_ns):.3f} s"
    state = {State.WAITING: "waiting", State.ON: f"on{began}", State.OVER: "over"}[fault.state]
    values = ", ".join(f"{key} {_shown(value)}" for key, value in fault.values.items() if value is not None)
    with ui.element("li").classes(f"fault-row {fault.state.value}"):
        ui.label(name).classes("fault-name")
        what = f"{fault.kind.name} of {fault.spot.name}" + (f" ({values})" if values else "")
        ui.label(what).props["title"] = fault.kind.doc
        called(ui.label(state).classes("why"), f"fault-{name}-state")
        if fault.state is not State.OVER:
            mend = partial(context.session.do, who, "mend", name)
            called(Key("mend", f"mend {name}", lambda: context.touch(mend)), f"mend-{name}")


def _who(context: Context, spot: str) -> str:
    """Return the controller that a fault affects; for a line with several motors, the first one."""
    own = spot.partition(".")[0]
    return own if own in context.bench.controllers else next(iter(context.bench.controllers))


def _shown(value: Any) -> str:
    return ("high" if value else "low") if isinstance(value, bool) else f"{value}"


# The form


class _Form:
    def __init__(self, context: Context) -> None:
        self._context = context
        with ui.element("div").classes("form"):
            self._kind = ui.select(
                {kind.name: f"{kind.name}: {kind.doc}" for kind in KINDS.values()}, label="kind", value="lose",
                on_change=self._build,
            )  # fmt: skip
            called(self._kind, "fault-kind")
            self._own = ui.element("div").classes("form")
        with ui.element("div").classes("form terms"):
            self._terms = {name: self._term(name) for name in TERMS}
        called(ui.button("Inject", on_click=self._put).props("no-caps"), "fault-put")
        self._build()

    @property
    def kind(self) -> Kind:
        return KINDS[str(self._kind.value)]

    def _build(self) -> None:
        self._own.clear()
        spots = self._spots()
        with self._own:
            self._on = ui.select(spots, label=THINGS[self.kind.on], value=spots[0] if spots else None)
            called(self._on, "fault-on")
            self._values = {parameter.name: _field(parameter) for parameter in self.kind.parameters}

    def _spots(self) -> list[str]:
        spots = {name: find() for name, find in self._context.bench.faults.spots(self.kind.on).items()}
        return list(dict.fromkeys(spot.name for spot in spots.values()))

    def _term(self, name: str) -> ui.input:
        label, unit, hint = TERMS[name]
        field = ui.input(f"{label}, {unit}" if unit else label, placeholder=hint).props("dense")
        return called(field, f"fault-{name}")

    def _put(self) -> None:
        if self._on.value is None:
            ui.notify(f"the bench has no {THINGS[self.kind.on]}", type="warning")
            return
        words = [self.kind.name, f"on={self._on.value}"]
        for name, field in (*self._values.items(), *self._terms.items()):
            if field.value not in (None, ""):
                words.append(f"{name}={shlex.quote(str(field.value).strip())}")
        on = str(self._on.value)
        self._context.touch(partial(self._context.session.do, _who(self._context, on), "fault", " ".join(words)))


def _field(parameter: Parameter) -> ui.input | ui.select:
    label = f"{parameter.name}, {parameter.unit}" if parameter.unit else parameter.name
    mark = f"fault-{parameter.name}"
    if parameter.sort in (Sort.LEVEL, Sort.WORD):
        words = list(parameter.words) or ["high", "low"]
        usual = _shown(parameter.default) if parameter.default is not None else words[0]
        return called(ui.select(words, label=label, value=usual).props("dense").tooltip(parameter.doc), mark)
    usual = "" if parameter.default is None else f"{parameter.default:g}"
    field = ui.input(label, placeholder=parameter.wanted, value=usual).props("dense")
    return called(field.props(f'hint="{parameter.doc}"'), mark)
