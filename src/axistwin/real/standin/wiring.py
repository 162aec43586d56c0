"""The wiring of a board: the use of its pins, and the commands that configure the board."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from zlib import crc32

from axistwin.core.errors import UsageError
from axistwin.real.standin.dictionary import Dictionary

_PIN = re.compile(r"([\^~]?)(!?)(\w+)")
_PULLS = {"^": 1, "~": -1, "": 0}


@dataclass(frozen=True)
class BoardPin:
    """A pin in Klipper's notation: `^` for pull-up, `~` for pull-down, `!` for inverted, then the name."""

    name: str
    inverted: bool = False
    pull: int = 0

    @classmethod
    def read(cls, text: str) -> "BoardPin":
        """Parse a pin, e.g. `^!PC1`.  Raises UsageError."""
        found = _PIN.fullmatch(text)
        if found is None:
            raise UsageError(f"invalid pin {text!r}: expected the name of a board's pin, e.g. PD2, !PB0 or ^PC1")
        return cls(found[3], bool(found[2]), _PULLS[found[1]])

    def __str__(self) -> str:
        return {1: "^", -1: "~", 0: ""}[self.pull] + "!" * self.inverted + self.name


@dataclass(frozen=True)
class DrivenAxis:
    """A simulated axis with a real motor; `travel` and `max_rate` limit position and pulse rate."""

    axis: str  # Name of the axis on the bench: "controller.axis".
    travel: tuple[int, int] | None = field(default=None, kw_only=True)
    max_rate: float | None = field(default=None, kw_only=True)

    @property
    def controller(self) -> str:
        return self.axis.rpartition(".")[0]

    def refusal(self, rate: float, end: int) -> str:
        """Return an error message if a move to `end` exceeds a limit of the axis; "" if it is permitted."""
        if self.max_rate is not None and rate > self.max_rate * 1.001:
            return f"{self.axis}: {rate:.0f} pulses/s is above max_rate {self.max_rate:g}"
        if self.travel is not None and not self.travel[0] <= end <= self.travel[1]:
            return f"{self.axis}: position {end} is beyond travel {list(self.travel)}"
        return ""


@dataclass(frozen=True)
class AxisPins(DrivenAxis):
    """An axis, and the pins of the board that control the axis's motor drive."""

    step: BoardPin
    direction: BoardPin
    enable: BoardPin | None = None
    pulse_us: float = 2.0


@dataclass(frozen=True)
class Sensed:
    """A controller's input that is wired to a real switch."""

    to: str  # Terminal of the bench, as "controller.pin".
    stops: int | None = field(default=None, kw_only=True)  # Direction that the input stops: +1, -1, 0 both; None: no.
    stops_at: bool = field(default=False, kw_only=True)  # Level of the terminal that stops the motion.

    @property
    def controller(self) -> str:
        return self.to.rpartition(".")[0]


@dataclass(frozen=True)
class InputPin(Sensed):
    """A controller's input that is wired to a pin of a board."""

    pin: BoardPin


@dataclass(frozen=True)
class Switched:
    """An output, which has the level `safe` when the motors have been stopped."""

    source: str  # Terminal of the bench, as "controller.pin".
    safe: bool = field(default=False, kw_only=True)


@dataclass(frozen=True)
class OutputPin(Switched):
    """A controller's output that is wired to a pin of a board."""

    pin: BoardPin


def open_input(inputs: Sequence[Sensed], levels: Mapping[str, bool], axis: DrivenAxis, direction: int) -> str:
    """Return an error message if an open stop input forbids motion in this direction, else ""."""
    for given in inputs:
        blocks = given.controller == axis.controller and given.stops in (0, direction)
        if blocks and levels[given.to] is given.stops_at:
            return f"{axis.axis}: {given.to} is open: no motion in this direction"
    return ""


@dataclass(frozen=True)
class Wired:
    """The axes, inputs and outputs that are wired to one board."""

    name: str
    axes: tuple[DrivenAxis, ...]
    inputs: tuple[Sensed, ...] = ()
    outputs: tuple[Switched, ...] = ()

    @cached_property
    def groups(self) -> tuple[str, ...]:
        """Names of the controllers whose axes the board drives."""
        return tuple(dict.fromkeys(axis.controller for axis in self.axes))

    def check(self) -> None:
        """Raise UsageError if an input that stops motion is wired to another board than the axes of its controller."""
        for given in self.inputs:
            if given.stops is not None and given.controller not in self.groups:
                raise UsageError(
                    f"the stop input {given.to} is wired to the wrong board: "
                    f"expected the same board as for the axes of the controller {given.controller}"
                )


@dataclass(frozen=True)
class Wiring(Wired):
    """The wiring of a board with Klipper's firmware."""

    axes: tuple[AxisPins, ...]
    inputs: tuple[InputPin, ...] = ()
    outputs: tuple[OutputPin, ...] = ()
    watchdog_s: float = 0.1
    stop_sample_s: float = 100e-6  # Shortest time between two readings of an input that stops motion.
    sample_s: float = 1e-3  # Approximate time between two readings of any other input.

    @cached_property
    def enables(self) -> tuple[BoardPin, ...]:
        """Pins that enable the drives; several axes may share an enable pin."""
        return tuple(dict.fromkeys(axis.enable for axis in self.axes if axis.enable is not None))

    def used(self) -> Iterator[tuple[BoardPin, str]]:
        for axis in self.axes:
            yield axis.step, f"{axis.axis} step"
            yield axis.direction, f"{axis.axis} direction"
        for pin in self.enables:
            yield pin, f"{', '.join(axis.axis for axis in self.axes if axis.enable == pin)} enable"
        for given in self.inputs:
            yield given.pin, f"{given.to} input"
        for output in self.outputs:
            yield output.pin, f"{output.source} output"

    def check(self) -> None:
        """Check that no pin has two uses, and that each axis has an enable pin.

        Raises UsageError, also for an input of another board.
        """
        uses: dict[str, str] = {}
        for pin, use in self.used():
            if pin.name in uses:
                raise UsageError(
                    f"pin {pin.name} is used for {uses[pin.name]} and for {use}: choose another pin for one of them"
                )
            uses[pin.name] = use
        for axis in self.axes:
            if axis.enable is None:
                raise UsageError(
                    f"axis {axis.axis} has no enable pin: "
                    "expected a pin of the board for the enable input of the drive, e.g. PB0"
                )
        super().check()

    def check_pins(self, dictionary: Dictionary) -> None:
        """Check that all pins of the wiring exist on the board and are not reserved.  Raises UsageError."""
        reserved = {
            pin: key.removeprefix("RESERVE_PINS_")
            for key, pins in dictionary.constants.items()
            if key.startswith("RESERVE_PINS_")
            for pin in str(pins).split(",")
        }
        for pin, use in self.used():
            if pin.name not in dictionary.pins:
                examples = ", ".join(list(dictionary.pins)[:8])
                raise UsageError(f"the board has no pin {pin.name} for {use}: expected one of {examples}, …")
            if pin.name in reserved:
                purpose = reserved[pin.name]
                raise UsageError(
                    f"pin {pin.name} cannot be used for {use}, because it is reserved for {purpose}: choose another pin"
                )


@dataclass(frozen=True)
class Objects:
    """Object numbers of a board's configuration, and the commands that create the objects."""

    steppers: dict[str, int] = field(default_factory=dict)
    enables: dict[BoardPin, int] = field(default_factory=dict)
    groups: dict[str, int] = field(default_factory=dict)
    endstops: dict[str, int] = field(default_factory=dict)
    watches: dict[str, int] = field(default_factory=dict)
    outputs: dict[str, int] = field(default_factory=dict)
    commands: tuple[bytes, ...] = ()
    crc: int = 0


def objects(wiring: Wiring, dictionary: Dictionary) -> Objects:
    """Assign a number to each object that a board's firmware must create, e.g. a stepper object per axis."""
    number = iter(range(256))
    steppers = {axis.axis: next(number) for axis in wiring.axes}
    enables = {pin: next(number) for pin in wiring.enables}
    groups = {group: next(number) for group in wiring.groups}
    endstops = {given.to: next(number) for given in wiring.inputs}
    watches = {given.to: next(number) for given in wiring.inputs}
    outputs = {output.source: next(number) for output in wiring.outputs}
    encode, pins = dictionary.encode, dictionary.pins
    made = [encode("allocate_oids", count=next(number))]
    for axis in wiring.axes:
        step, direction = pins[axis.step.name], pins[axis.direction.name]
        ticks = round(axis.pulse_us * 1e-6 * dictionary.clock_hz)
        made.append(
            encode("config_stepper", oid=steppers[axis.axis], step_pin=step, dir_pin=direction,
                   invert_step=int(axis.step.inverted), step_pulse_ticks=ticks)
        )  # fmt: skip
    for pin, oid in enables.items():
        off, longest = int(pin.inverted), round(wiring.watchdog_s * dictionary.clock_hz)
        made.append(_output(dictionary, oid, pin, off, longest))
    made += [encode("config_trsync", oid=oid) for oid in (*groups.values(), *watches.values())]
    for given in wiring.inputs:
        pin = given.pin
        made.append(encode("config_endstop", oid=endstops[given.to], pin=pins[pin.name], pull_up=pin.pull))
    for output in wiring.outputs:
        level = int(output.safe is not output.pin.inverted)
        made.append(_output(dictionary, outputs[output.source], output.pin, level, 0))
    crc = crc32(b"".join(made))
    made.append(encode("finalize_config", crc=crc))
    return Objects(steppers, enables, groups, endstops, watches, outputs, tuple(made), crc)


def _output(dictionary: Dictionary, oid: int, pin: BoardPin, level: int, longest: int) -> bytes:
    return dictionary.encode(
        "config_digital_out", oid=oid, pin=dictionary.pins[pin.name], value=level, default_value=level,
        max_duration=longest,
    )  # fmt: skip
