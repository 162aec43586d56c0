"""The signals of a bench that can be traced, by name: `if1.output1`, `if1.X.pulses`, `if1.host_says`, `motor.RPE`.

Patterns select signals: `*` matches any text, `?` any single character, e.g. `if1.*`, `*.X.*`, `motor.a`.  A register
may have alternative names: the pattern `motor.@PE` also selects `motor.RPE`.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase

from axistwin.bench import Bench, Controller, endpoints
from axistwin.bench.events import terminals
from axistwin.core.errors import UsageError, most_similar
from axistwin.plant.servo_axis import ServoAxis
from axistwin.sim.pins import UserPin

LEVEL, COUNT, STEP, TEXT, REAL = "wire", "integer", "step", "string", "real"
"""Kinds of signals: a level (0 or 1), an integer, a step pulse, a text, and a floating-point number."""
FAULTS = "faults"  # Name of the signal that contains the names of all active faults of a controller and its machine.
DEFAULT = "default"  # Pattern that selects terminals, axes, messages and faults, but no registers.
EVERYTHING = "*"
UNITS = {
    ("pulses", COUNT): "pulses", ("velocity", REAL): "pulses/s", ("position", COUNT): "counts",
    ("commanded", COUNT): "counts",
}  # fmt: skip
"""Units of the signals of axes, by name and kind."""
SHOWN = 12


@dataclass(frozen=True)
class Signal:
    """A signal, e.g. `if1.output1`; `scope`: its controller, line or axis; `also`: alternative names."""

    scope: str
    name: str
    kind: str
    register: bool = False  # True for a register; the default pattern does not select registers.
    also: tuple[str, ...] = ()
    costly: bool = False  # True if tracing takes much time; only the full name selects such a signal, not a pattern.

    @property
    def full(self) -> str:
        """The full name of the signal, e.g. `if1.output1`."""
        return f"{self.scope}.{self.name}"

    @property
    def unit(self) -> str:
        """The unit of the signal, e.g. `pulses/s`; "" for levels, texts and registers."""
        if self.register:
            return ""
        return "V" if self.kind == REAL and self.name.endswith("_volts") else UNITS.get((self.name, self.kind), "")

    def matches(self, pattern: str) -> bool:
        """Return True if the name of the signal matches a pattern, e.g. `if1.X.pulses` matches `if1.X.*`."""
        if pattern == DEFAULT:
            return not self.register and not self.costly
        names = (self.full, *(f"{self.scope}.{name}" for name in self.also))
        return pattern in names if self.costly else any(fnmatchcase(name, pattern) for name in names)


def catalogue(bench: Bench) -> list[Signal]:
    """Return all signals that can be traced.  The signals of controllers come before the signals of shared lines."""
    found = [signal for controller in bench.controllers.values() for signal in _of(bench, controller)]
    lines = [name for name in endpoints.names(bench) if name not in bench.controllers]
    return found + [signal for name in lines for signal in _streams(name)]


def choose(signals: Sequence[Signal], patterns: Iterable[str]) -> list[Signal]:
    """Return the signals that match at least one pattern.  Raises UsageError for a pattern without a match."""
    patterns = tuple(patterns)
    for pattern in patterns:
        if not any(signal.matches(pattern) for signal in signals):
            names = [signal.full for signal in signals]
            raise UsageError(f"no signal matches {pattern!r}: {_suggestion(pattern, names)}")
    return [signal for signal in signals if any(signal.matches(pattern) for pattern in patterns)]


def split(text: str | None) -> tuple[str, ...]:
    """Split names and patterns at commas, e.g. "if1.X.*, if1.output1"; `DEFAULT` for an empty text."""
    return tuple(pattern.strip() for pattern in (text or DEFAULT).split(",") if pattern.strip())


def pin_signal(pin: str) -> str:
    """Return the name of a pin in a trace: dots become underscores, e.g. `host_dtr` for the pin `host.dtr`."""
    return pin.replace(".", "_")


def _of(bench: Bench, controller: Controller) -> Iterator[Signal]:
    name = controller.name
    for pin_name, pin in terminals(controller).items():
        # No signal for a step output: the signal `step` of the axis shows the same pulses.
        if not pin.silent:
            yield Signal(name, pin_signal(pin_name), LEVEL)
        if isinstance(pin, UserPin):
            yield Signal(name, f"{pin_name}_volts", REAL)
    for pin_name, pin in controller.pins.items():
        if pin.restless and not pin.silent:
            yield Signal(name, pin_name, LEVEL, costly=True)
    if name in endpoints.names(bench):
        yield from _streams(name)
    yield Signal(name, FAULTS, TEXT)
    for register_name, register in controller.registers.items():
        kind = TEXT if register.text else COUNT
        if not register.restless:
            yield Signal(name, register_name, kind, True, register.also, register.costly)
    for axis_name, axis in controller.axes.items():
        scope = f"{name}.{axis_name}"
        if isinstance(axis, ServoAxis):
            yield from (Signal(scope, "position", COUNT), Signal(scope, "commanded", COUNT))
        else:
            yield from (Signal(scope, "direction", LEVEL), Signal(scope, "step", STEP))
            yield from (Signal(scope, "pulses", COUNT), Signal(scope, "velocity", REAL))


def _streams(name: str) -> Iterator[Signal]:
    yield from (Signal(name, "host_says", TEXT), Signal(name, "controller_says", TEXT))


def _suggestion(pattern: str, names: Sequence[str]) -> str:
    if close := most_similar(pattern, names):
        return f"did you mean {close!r}?"
    few = ", ".join(names[:SHOWN])
    return f"there are {few}{', …' if len(names) > SHOWN else ''}"
