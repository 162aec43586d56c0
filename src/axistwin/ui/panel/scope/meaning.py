"""The meaning of signals: units of their values, words of their messages, and the signals that a bench uses."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from axistwin.bench import Bench, Controller, endpoints
from axistwin.bench.codec import Codec
from axistwin.plant.machine_units import MachineUnits
from axistwin.records.traces.signals import COUNT, LEVEL, REAL, TEXT, Signal, pin_signal
from axistwin.scenes.reasons.reasons import spoken
from axistwin.ui.drawings.scale import grouped, minus
from axistwin.ui.drawings.switches import lamps_of, level_words, spaced, title_of, wired_to


@dataclass(frozen=True)
class Meaning:
    """The name of a signal for users, the unit of its values, and the codec of its messages."""

    title: str = ""  # E.g. "X position", "Output 1".
    note: str = ""  # What a terminal is connected to: "to input 1", "Start".
    unit: str = ""
    units: MachineUnits | None = None
    levels: tuple[str, str] = ("off", "on")  # Words for low and high, those of the switch.
    codec: Codec | None = None
    by_host: bool = False

    @property
    def shown_unit(self) -> str:
        """The unit of the machine if there is one."""
        return self.unit if self.units is None else f"{self.units.of}{'/s' if self.unit.endswith('/s') else ''}"

    @property
    def per(self) -> float:
        """Number of pulses or counts in the shown unit."""
        return 1.0 if self.units is None else float(self.units.per)

    def number(self, value: float) -> str:
        """Format a value in the shown unit, without the unit."""
        if self.units is not None:
            return minus(self.units.shown(value))
        return grouped(round(value)) if abs(value) >= MANY else minus(f"{value:.4g}")

    def word(self, value: float) -> str:
        return self.levels[bool(value)]

    def words(self, text: str) -> str:
        """Return the meaning of a bus message in words, or "" if the text is not a complete bus message."""
        if self.codec is None:
            return ""
        try:
            return self.codec.words(bytes.fromhex(text), self.by_host)
        except ValueError:  # Only the beginning of a long bus message is stored, so the message cannot be decoded.
            return ""


MOST_TITLE = 20  # Largest number of characters of a product's name in a lane; a longer one gives way to its own name.
MANY = 1000  # Smallest value that is told without decimals.
PLAIN = Meaning()


def meanings(bench: Bench, signals: Iterable[Signal], named: Mapping[str, str]) -> dict[str, Meaning]:
    """Return the meaning of each signal by name; `named`: names on the operator panel, by "controller.pin"."""
    notes = {f"{name}.{pin_signal(pin)}": told
             for name, c in bench.controllers.items() for pin, told in wired_to(c).items()}  # fmt: skip
    notes |= {_terminal(pin): told for pin, told in named.items()}
    several = len(bench.controllers) > 1
    found = {}
    for signal in signals:
        title = _title(bench, signal)
        title = f"{signal.scope.partition('.')[0]} {title}" if several else title
        found[signal.full] = replace(_meaning(bench, signal), title=title, note=notes.get(signal.full, ""))
    return found


def _title(bench: Bench, signal: Signal) -> str:
    name, _, axis = signal.scope.rpartition(".")
    if name in bench.controllers and axis in bench[name].axes:
        words = f"{spoken(axis)} {'position' if signal.name == 'pulses' else signal.name.replace('_', ' ')}"
        return words[0].upper() + words[1:] if axis.isdigit() else words
    if signal.name == "host_says":
        return "Host"
    if signal.name == "controller_says":
        short = bench[signal.scope].product.indefinite.partition(" ")[2] if signal.scope in bench.controllers else ""
        return short if 0 < len(short) <= MOST_TITLE else signal.scope
    if pin := _pin(bench, signal):
        return title_of(pin, lamps_of(bench[signal.scope]))
    words = spaced(signal.name)
    return words if signal.kind in (COUNT, REAL) else words[:1].upper() + words[1:]


def _meaning(bench: Bench, signal: Signal) -> Meaning:
    name, _, axis = signal.scope.rpartition(".")
    if name in bench.controllers and axis in bench[name].axes:
        return _of_axis(bench[name], axis, signal)
    if signal.name.endswith("_volts"):
        return Meaning(unit="V")
    if signal.name in ("host_says", "controller_says") and endpoints.at_a_bus(bench, signal.scope):
        return Meaning(codec=endpoints.codec_at(bench, signal.scope), by_host=signal.name == "host_says")
    if pin := _pin(bench, signal):
        controller = bench[signal.scope]
        return Meaning(levels=level_words(controller.pins[pin], wired=pin in wired_to(controller)))
    return PLAIN


def _pin(bench: Bench, signal: Signal) -> str:
    """Return the terminal that a signal shows; "" if it shows none."""
    pins = bench[signal.scope].pins if signal.scope in bench.controllers and signal.kind == LEVEL else ()
    return next((name for name in pins if pin_signal(name) == signal.name), "")


def _of_axis(controller: Controller, name: str, signal: Signal) -> Meaning:
    axis = controller.axes[name]
    if signal.kind == REAL:
        return Meaning(unit=f"{axis.unit}/s", units=axis.units)
    return Meaning(unit=axis.unit, units=axis.units) if signal.kind == COUNT else PLAIN


def used(bench: Bench, signals: Sequence[Signal]) -> list[str]:
    """Return the signals that a scene uses: axes with a machine, wired terminals, messages of its hosts."""
    names = {signal.full for signal in signals}
    wired = [_terminal(end) for wire in bench.wires for end in wire]
    found = [*_motion(bench, signals), *dict.fromkeys(wired)]
    said = [signal.full for signal in signals if signal.kind == TEXT and signal.name.endswith("_says")]
    return [name for name in (*found, *said) if name in names] if found else []


def _motion(bench: Bench, signals: Iterable[Signal]) -> Iterator[str]:
    """Yield velocity and position of each axis with a machine."""
    axes = {f"{c.name}.{axis}" for c in bench.controllers.values() for axis in c.axes if c.given.get(axis)}
    of_axes = [signal for signal in signals if signal.scope in axes]
    for signal in of_axes:
        if signal.kind == REAL:
            yield signal.full
            places = (
                other for other in of_axes if other.scope == signal.scope and other.name in ("pulses", "position")
            )
            yield from (place.full for place in list(places)[-1:])


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
