"""The variables of an FMU: its inputs and outputs, found on the bench of a scene.

table.X.torque                     input: torque on the shaft in N·m, for an axis with the data sheet of a motor
table.input1                       input: level of an open terminal
knife.D.low                        input: True connects an open terminal of a SmartMotor to ground
start                              input: a command; each change to True performs it
table.X.position, table.X.pulses   outputs: position, and for a stepper motor the net issued pulses
table.X.velocity                   output: pulses or counts per second
table.X.angle, table.X.speed       outputs: the same in rad and rad/s, if the data sheets give pulses per revolution
table.output1                      output: level of a terminal
"""

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from math import pi

from axistwin.bench import Bench, Controller
from axistwin.bench.action_runner import ActionRunner
from axistwin.bench.actions import FAULT_ACTS
from axistwin.bench.acts import Do, Say
from axistwin.bench.codec import codec_of
from axistwin.bench.talk.conversation import parse_line
from axistwin.core.errors import AxistwinError, PlacedError, UsageError
from axistwin.plant.axes import Axis
from axistwin.plant.stepper import StepperAxis
from axistwin.sim.pins import Pin, UserPin

TIME = "time"  # Name of the independent variable of an FMU.
TORQUE, ANGLE, SPEED = "N.m", "rad", "rad/s"  # Units, in the notation of FMI.
EXAMPLE = r"'start: > X3000@5000S1$\r' or 'start: table: ! input1 high'"
_PLAIN = re.compile(r"[A-Za-z_]\w*", re.ASCII)


@dataclass(frozen=True)
class Input:
    """An input: a number if it has a unit, else a level.  `set` is called only with a new value."""

    name: str
    doc: str
    set: Callable[[float], object]
    first: float = 0
    unit: str = ""


@dataclass(frozen=True)
class Output:
    """An output of an FMU, which is a logic level or a number."""

    name: str
    doc: str
    get: Callable[[], float]
    level: bool = False
    unit: str = ""


def inputs(bench: Bench, commands: Mapping[str, str]) -> list[Input]:
    """Return the inputs of an FMU.  `commands`: lines of a conversation by name, inputs too.  Raises UsageError."""
    found = [each for controller in bench.controllers.values() for each in _inputs(controller)]
    taken = {*(each.name for each in found), *(each.name for each in outputs(bench)), TIME}
    for name, line in commands.items():
        if name in taken or not _PLAIN.fullmatch(name):
            raise UsageError(f"invalid command name {name!r}: expected an identifier that is not yet used, e.g. start")
        try:
            act = _command(bench, line)
        except AxistwinError as error:
            error_in_line = error.message if isinstance(error, PlacedError) else str(error)
            raise UsageError(f"invalid command {name!r}: {error_in_line}") from None
        found.append(Input(name, f"A change to true performs: {line}", act))
    return found


def outputs(bench: Bench) -> list[Output]:
    return [each for controller in bench.controllers.values() for each in _outputs(controller)]


def named(*parts: str) -> str:
    """Return a variable name in FMI's structured notation, e.g. table.X.position."""
    return ".".join(part if _PLAIN.fullmatch(part) else f"'{part}'" for part in parts)


def _inputs(controller: Controller) -> Iterator[Input]:
    for name, axis in controller.axes.items():
        if axis.motor is not None:
            text = f"Torque on the shaft of {name}, positive in the positive direction"
            yield Input(named(controller.name, name, "torque"), text, axis.load, unit=TORQUE)
    for name, pin in controller.pins.items():
        if not _open(pin):
            continue
        if isinstance(pin, UserPin):
            text = f"True connects terminal {name} to ground"
            yield Input(named(controller.name, name, "low"), text, partial(_ground, pin))
        else:
            yield Input(named(controller.name, name), f"Level of input {name}", partial(_drive, pin), pin.level)


def _open(pin: Pin) -> bool:
    return not pin.wired and (isinstance(pin, UserPin) or pin.drivable)


def _ground(pin: Pin, low: float) -> None:
    if low:
        pin.drive(False)
    else:
        pin.release()


def _drive(pin: Pin, level: float) -> None:
    pin.drive(bool(level))


def _outputs(controller: Controller) -> Iterator[Output]:
    for name, axis in controller.axes.items():
        yield from _axis_outputs(controller.name, name, axis)
    for name, pin in controller.pins.items():
        if not pin.silent and (isinstance(pin, UserPin) or not _open(pin)):
            yield Output(named(controller.name, name), f"Level of terminal {name}", partial(_level, pin), level=True)


def _level(pin: Pin) -> float:
    return pin.level


def _axis_outputs(controller: str, name: str, axis: Axis) -> Iterator[Output]:
    def value(attribute: str, factor: float = 1) -> Callable[[], float]:
        return lambda: factor * float(getattr(axis, attribute)) + 0.0  # not -0.0

    yield Output(named(controller, name, "position"), f"Position of {name} in {axis.unit}", value("position"))
    if isinstance(axis, StepperAxis):
        yield Output(named(controller, name, "pulses"), f"Net issued pulses of {name}", value("pulses"))
    text = f"Velocity of {name} in {axis.unit} per second"
    yield Output(named(controller, name, "velocity"), text, value("velocity"))
    if (per_rev := axis.per_rev) is not None:
        text = f"Angle of the shaft of {name}"
        yield Output(named(controller, name, "angle"), text, value("position", 2 * pi / per_rev), unit=ANGLE)
        text = f"Speed of the shaft of {name}"
        yield Output(named(controller, name, "speed"), text, value("velocity", 2 * pi / per_rev), unit=SPEED)


def _command(bench: Bench, line: str) -> Callable[[float], object]:
    only = next(iter(bench.controllers)) if len(bench.controllers) == 1 else ""
    who = line.partition(":")[0].strip() if not line.strip().startswith((">", "!")) else only
    codec = codec_of(bench[who].product) if who in bench.controllers else None
    act = parse_line(line, 0, "") if codec is None else parse_line(line, 0, "", codec)
    if not isinstance(act, Say | Do):
        raise UsageError(f"invalid line {line!r}: expected > before a command or ! before an action, e.g. {EXAMPLE}")
    if not act.controller:
        if not only and not (isinstance(act, Do) and act.target in FAULT_ACTS):
            raise UsageError(
                f"no controller name in {line!r}: begin the line with the name of the controller and a colon, "
                f"e.g. '{next(iter(bench.controllers))}: {line.strip()}'"
            )
        act = type(act)(**{**vars(act), "controller": only})
    perform = ActionRunner(bench).prepare(act)

    def rise(level: float) -> None:
        if level:
            perform()

    return rise
