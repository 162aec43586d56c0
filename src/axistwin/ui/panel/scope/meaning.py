"""The meaning of signals: units of their values, words of their messages, and the signals that a bench uses."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from axistwin.bench import Bench, Controller, endpoints
from axistwin.bench.codec import Codec
from axistwin.plant.machine_units import MachineUnits
from axistwin.records.traces.signals import COUNT, LEVEL, REAL, TEXT, Signal, pin_signal


@dataclass(frozen=True)
class Meaning:
    """The unit of a signal's values, and the codec of its messages."""

    unit: str = ""
    units: MachineUnits | None = None
    codec: Codec | None = None
    by_host: bool = False

    def in_unit(self, value: float) -> str:
        """Format a value in the machine unit, e.g. `12.50 mm`; "" if no machine unit is defined."""
        if self.units is None:
            return ""
        return f"{self.units.shown(value)} {self.units.of}{'/s' if self.unit.endswith('/s') else ''}"

    def words(self, text: str) -> str:
        """Return the meaning of a bus message in words, or "" if the text is not a complete bus message."""
        if self.codec is None:
            return ""
        try:
            return self.codec.words(bytes.fromhex(text), self.by_host)
        except ValueError:  # Only the beginning of a long bus message is stored, so the message cannot be decoded.
            return ""


PLAIN = Meaning()


def meanings(bench: Bench, signals: Iterable[Signal]) -> dict[str, Meaning]:
    """Return the meaning of each signal that has a unit or messages in words, by name."""
    found = {signal.full: _meaning(bench, signal) for signal in signals}
    return {name: meaning for name, meaning in found.items() if meaning != PLAIN}


def _meaning(bench: Bench, signal: Signal) -> Meaning:
    name, _, axis = signal.scope.rpartition(".")
    if name in bench.controllers and axis in bench[name].axes:
        return _of_axis(bench[name], axis, signal)
    if signal.name.endswith("_volts"):
        return Meaning("V")
    if signal.name in ("host_says", "controller_says") and endpoints.at_a_bus(bench, signal.scope):
        return Meaning(codec=endpoints.codec_at(bench, signal.scope), by_host=signal.name == "host_says")
    return PLAIN


def _of_axis(controller: Controller, name: str, signal: Signal) -> Meaning:
    axis = controller.axes[name]
    if signal.kind == REAL:
        return Meaning(f"{axis.unit}/s", axis.units)
    return Meaning(axis.unit, axis.units) if signal.kind == COUNT else PLAIN


def used(bench: Bench, signals: Sequence[Signal]) -> list[str]:
    """Return the signals that a scene uses: axes with a machine, wired terminals, messages of its hosts."""
    names = {signal.full for signal in signals}
    wired = [_terminal(end) for wire in bench.wires for end in wire]
    found = [*_motion(bench, signals), *dict.fromkeys(wired)]
    said = [signal.full for signal in signals if signal.kind == TEXT and signal.name.endswith("_says")]
    return [name for name in (*found, *said) if name in names] if found else []


def _motion(bench: Bench, signals: Iterable[Signal]) -> Iterator[str]:
    axes = {f"{c.name}.{axis}" for c in bench.controllers.values() for axis in c.axes if c.given.get(axis)}
    for signal in signals:
        if signal.scope in axes and (signal.kind == REAL or signal.name in ("pulses", "position")):
            yield signal.full


def _terminal(terminal: str) -> str:
    name, _, pin = terminal.partition(".")
    return f"{name}.{pin_signal(pin)}"


def presets(bench: Bench, signals: Sequence[Signal]) -> Mapping[str, list[str]]:
    """Return useful selections of signals by title; empty selections are left out."""
    wired = {_terminal(end) for wire in bench.wires for end in wire}
    found = {
        "Scene": used(bench, signals),
        "Motion": [s.full for s in signals if s.kind in (REAL, COUNT) and "." in s.scope],
        "Wires": [s.full for s in signals if s.full in wired],
        "Terminals": [s.full for s in signals if s.kind == LEVEL and "." not in s.scope],
        "Messages": [s.full for s in signals if s.kind == TEXT and not s.register],
    }
    return {title: names for title, names in found.items() if names}
