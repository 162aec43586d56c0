"""Actions on a controller, and queries of its values, by the names that conversations use.  Actions apply to pins, axes
and the host's end of a serial line.  A SmartMotor also has voltages, an ambient temperature and an external encoder
(`master`).
"""

import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from decimal import Decimal, localcontext
from fractions import Fraction
from functools import partial

from axistwin.bench.bench import Bench
from axistwin.bench.controller import Controller, on_a_bus
from axistwin.core.errors import ProgramError, UsageError
from axistwin.core.numbers import MOST_CHARACTERS, decimal, real, shortened
from axistwin.core.units import to_ns
from axistwin.plant.axes import Axis
from axistwin.plant.joystick import FASTEST
from axistwin.plant.servo_axis import ServoAxis
from axistwin.sim import serial_port
from axistwin.sim.frames import UartFormat
from axistwin.sim.line_format import line_format
from axistwin.sim.manual_actions import MOST_COUNTS
from axistwin.sim.pins import LEAST_VOLTS, MOST_VOLTS, PULLED_UP_VOLTS, Pin, UserPin
from axistwin.sim.registers import RegisterPort
from axistwin.sim.serial_port import Flow, SerialPort

LEVELS = {"high": True, "on": True, "low": False, "off": False}
FAULT_ACTS = ("fault", "mend")
BUS_ACTS = ("init", "read", "write")
LINE_ACTS = ("dtr", "rts", "break", "line", "flow", "hold", "drop", "instant")
ATTRIBUTES = ("position", "pulses", "velocity", "encoder")
SERVO_ATTRIBUTES = ("position", "commanded", "velocity", "encoder", "temperature")
_VOLTS = re.compile(r"(?P<volts>-?\d+(\.\d*)?|-?\.\d+) ?V", re.ASCII)
_READ = re.compile(r"(?P<offset>[01])(?: (?P<count>\d{1,4}))?", re.ASCII)
_WRITTEN = re.compile(r"(?P<offset>[01])(?P<data>( [0-9A-Fa-f]{2})+)")
MOST_AT_ONCE = 256  # Largest number of times that one action can read a register.
_SITS = re.compile(r"on (?P<axis>[^ ]+)(?: times (?P<above>-?\d{1,18})/(?P<below>\d{1,18}))?", re.ASCII)
_RUN = re.compile(r"(?P<counts>-?\d+) in (?P<seconds>\d+(\.\d*)?|\.\d+)", re.ASCII)

Value = bool | int | float | Decimal


def level_name(level: bool) -> str:
    return "high" if level else "low"


def action(controller: Controller, target: str, value: str) -> Callable[[], object]:
    """Return a function that performs the action `! target value`.  Raises ProgramError for an invalid action."""
    if target in controller.pins:
        return _pin_action(controller.pins[target], value)
    if target in FAULT_ACTS:
        return fault_action(controller.bench, controller.name, target, value)
    axis, _, what = target.partition(".")
    if axis in controller.axes and what in ("jam", "load", "push"):
        return _axis_action(controller.axes[axis], what, value)
    if target == "power":
        return partial(controller.power, _level(value))
    if target == "joystick" and controller.product.joystick is not None:
        return partial(controller.joystick.deflect, _count(value, FASTEST))
    if motor_of(controller) is not None and target in ("ambient", "master"):
        return _motor_action(controller, target, value)
    return _bus_action(controller, target, value) if on_a_bus(controller) else _line_action(controller, target, value)


def act_at(bench: Bench, who: str, target: str, value: str) -> Callable[[], object]:
    """Return a function that performs the action `! target value` at a controller, a second channel, or a shared line.

    Faults may have any name.  Raises ProgramError or UsageError for an invalid action.
    """
    if target in FAULT_ACTS:
        return fault_action(bench, who, target, value)
    if who in bench.controllers:
        return action(bench[who], target, value)
    return port_action(bench.port(who), target, value)


def fault_action(bench: Bench | None, here: str, target: str, value: str) -> Callable[[], object]:
    """Return a function that performs `! fault lose 3` or `! mend lose`; `here`: the default controller."""
    assert bench is not None, "the controller is on a bench"
    if target == "mend":
        return partial(bench.faults.mend, value.strip("\"'"))
    from axistwin.bench.faults import sentences

    with _placing_errors():
        return sentences.read(value, bench.faults, here)


def attributes(axis: Axis) -> tuple[str, ...]:
    return SERVO_ATTRIBUTES if isinstance(axis, ServoAxis) else ATTRIBUTES


def motor_of(controller: Controller) -> ServoAxis | None:
    """Return the servo axis of a SmartMotor; None for any other controller."""
    return next((axis for axis in controller.axes.values() if isinstance(axis, ServoAxis)), None)


def voltage(volts: float) -> str:
    return f"{volts:g}V"


def lead_value(pin: Pin) -> str:
    """Return the level that the user applies to a pin as text, e.g. `high` or `2.5V`; `release` if none."""
    lead = pin.lead
    if lead is None:
        return "release"
    if not isinstance(pin, UserPin):
        return level_name(bool(lead))
    return {0.0: "low", PULLED_UP_VOLTS: "high"}.get(lead, voltage(lead))


def action_value(target: str, *values: float) -> str:
    """Return the exact value of the action `! target value` that repeats an action of a person."""
    if target == "master":
        counts, seconds = values
        return f"{counts} in {_exact(seconds)}"
    (value,) = values
    return level_name(bool(value)) if target == "power" or target.endswith(".jam") else _exact(value)


def line_action(
    act: serial_port.SendBreak | serial_port.SetFormat | serial_port.SetLine | serial_port.Setting,
) -> tuple[str, str]:
    """Return target and value of the action `! target value` that repeats an event at the host's end of a line."""
    match act:
        case serial_port.SendBreak(seconds):
            return "break", f"{Decimal(seconds).quantize(Decimal('1e-9')):f}"
        case serial_port.SetFormat(fmt):
            return "line", str(fmt)
        case serial_port.SetFlow(flow):
            return "flow", flow.value
        case serial_port.DropPending():
            return "drop", "pending"
        case serial_port.SetLine(line, on):
            return line, level_name(on)
        case serial_port.Hold(on):
            return "hold", level_name(on)
        case serial_port.SetInstant(on):
            return "instant", level_name(on)


def _exact(value: float) -> str:
    return f"{Decimal(repr(value)):f}"


def _bus_action(controller: Controller, target: str, value: str) -> Callable[[], object]:
    bus = controller.bus
    match target:
        case "init":
            return bus.init if _level(value) else lambda: None
        case "read":
            offset, count = _register(value)
            return lambda: [bus.read(offset) for _ in range(count)]
        case "write":
            offset, data = _contents(value)
            return partial(_write, bus, offset, data)
    raise _unknown_name(name=target, known=targets(controller))


def _write(bus: RegisterPort, offset: int, data: bytes) -> None:
    for byte in data:
        bus.write(offset, byte)


def _register(value: str) -> tuple[int, int]:
    """Parse the value of an action `! read`, e.g. `0 16`: a register number and a number of reads."""
    found = _READ.fullmatch(value)
    if found is None or not 0 < int(found["count"] or 1) <= MOST_AT_ONCE:
        raise ProgramError(
            f"invalid value {value!r} of the action `read`: expected register 0 or 1, and a number of reads, e.g. 0 16"
        )
    return int(found["offset"]), int(found["count"] or 1)


def _contents(value: str) -> tuple[int, bytes]:
    found = _WRITTEN.fullmatch(value)
    if found is None:
        raise ProgramError(
            f"invalid value {value!r} of the action `write`: expected register 0 or 1, and hex bytes, e.g. 0 33 00"
        )
    return int(found["offset"]), bytes.fromhex(found["data"])


def _pin_action(pin: Pin, value: str) -> Callable[[], object]:
    if value == "release":
        return pin.release
    if not isinstance(pin, UserPin):
        return partial(pin.drive, _level(value, "release"))
    if value in LEVELS:
        return partial(pin.drive, LEVELS[value])
    found = _VOLTS.fullmatch(value)
    if found is None:
        levels = ", ".join((*LEVELS, "release"))
        raise ProgramError(f"invalid level {value!r}: expected {levels} or a voltage, e.g. 2.5V")
    volts = _real(found["volts"])
    if not LEAST_VOLTS <= volts <= MOST_VOLTS:
        raise ProgramError(f"voltage {value} would destroy the pin: expected 0 to 5 V")
    return partial(pin.drive, volts)


def _motor_action(controller: Controller, target: str, value: str) -> Callable[[], object]:
    if target == "ambient":
        return partial(setattr, controller, "ambient", _real(value))
    if sits := _SITS.fullmatch(value):
        return _sitting(controller, sits)
    found = _RUN.fullmatch(value)
    if found is None:
        example = _example_axis(controller)
        raise ProgramError(
            f"invalid value {value!r} of the action `! master` (external encoder): expected `COUNTS in SECONDS` or "
            f"`on CONTROLLER.AXIS times RATIO`, e.g. `4000 in 2`{example and f' or `on {example}`'}"
        )
    return partial(controller.master.move, _count(found["counts"]), _duration(found["seconds"]))


def _sitting(controller: Controller, sits: re.Match[str]) -> Callable[[], object]:
    """Return a function for `! master on table.X times 3/2`: the encoder gives 3/2 edges per count of table.X."""
    assert controller.bench is not None, "a controller with actions is part of a bench"
    name, _, axis = sits["axis"].rpartition(".")
    if name not in controller.bench.controllers or axis not in controller.bench[name].axes:
        axis_name = sits["axis"]
        example = _example_axis(controller)
        wanted = "the names of a controller and its axis" if example else "`COUNTS in SECONDS`"
        raise ProgramError(f"unknown axis {axis_name!r}: expected {wanted}, e.g. {example or '4000 in 2'}")
    numerator, denominator = int(sits["above"] or 1), int(sits["below"] or 1)
    if denominator == 0:
        raise ProgramError(f"invalid ratio {numerator}/0: expected a denominator above 0, e.g. 3/2")
    return partial(controller.master.follow, controller.bench[name].axes[axis], Fraction(numerator, denominator))


def _example_axis(motor: Controller) -> str:
    """Return an axis of another controller of the bench, which can turn the motor's external encoder, or ""."""
    assert motor.bench is not None, "a controller with actions is part of a bench"
    others = (each for each in motor.bench.controllers.values() if each is not motor)
    return next((f"{each.name}.{axis}" for each in others for axis in each.axes), "")


def _line_action(controller: Controller, target: str, value: str) -> Callable[[], object]:
    port = controller.ports.get(controller.name)
    if port is not None and target in _line_targets(port):
        return port_action(port, target, value)
    raise _unknown_name(name=target, known=targets(controller))


def targets(controller: Controller) -> tuple[str, ...]:
    """Return the valid targets of an action `! target value`; AXIS stands for the name of an axis."""
    port = controller.ports.get(controller.name)
    lines = () if port is None else _line_targets(port)
    motor = ("ambient", "master") if motor_of(controller) else ()
    stick = ("joystick",) if controller.product.joystick else ()
    host = (*BUS_ACTS, *stick) if on_a_bus(controller) else (*lines, *motor, *stick)
    return (*controller.pins, "power", *host, "AXIS.jam", "AXIS.load", "AXIS.push", *FAULT_ACTS)


def port_action(port: SerialPort, target: str, value: str) -> Callable[[], object]:
    """Return a function that performs an action at the host's serial port.  Raises ProgramError."""
    if target not in _line_targets(port):
        raise _unknown_name(name=target, known=_line_targets(port))
    match target:
        case "dtr":
            return partial(port.host.dtr_line.set, _level(value))
        case "rts":
            return partial(port.host.rts_line.set, _level(value))
        case "break":
            return partial(port.send_break, _duration(value, above_zero=True))
        case "flow":
            return partial(setattr, port, "flow", _flow(value))
        case "hold":
            return partial(setattr, port, "held", _level(value))
        case "instant":
            return partial(setattr, port, "instant", _level(value))
        case "drop":
            if value != "pending":
                raise ProgramError(
                    f"invalid value {value!r} of the action `drop`: "
                    "expected `! drop pending`, to discard unsent characters"
                )
            return port.drop_pending
    return partial(setattr, port.host, "format", _line(value, port))


def _line_targets(port: SerialPort) -> tuple[str, ...]:
    return LINE_ACTS if port.handshake else LINE_ACTS[2:]


def _flow(value: str) -> Flow:
    try:
        return Flow(value)
    except ValueError:
        known_values = ", ".join(flow.value for flow in Flow)
        raise ProgramError(f"invalid flow control {value!r}: expected one of {known_values}") from None


def _unknown_name(name: str, known: Iterable[str]) -> ProgramError:
    return ProgramError(f"unknown name {name!r}: expected one of {', '.join(known)}")


def question(controller: Controller, subject: str) -> Callable[[], Value]:
    """Return a function that reads the subject of an expectation `= subject value`.  Raises ProgramError."""
    if subject in controller.pins:
        return lambda: controller.pins[subject].level
    if subject in _lines(controller):
        port = controller.bus if on_a_bus(controller) else controller.serial
        return lambda: bool(getattr(port, subject))
    name, _, attribute = subject.partition(".")
    if name in controller.axes and attribute in attributes(controller.axes[name]):
        axis = controller.axes[name]
        return partial(getattr, axis.encoder, "count") if attribute == "encoder" else partial(getattr, axis, attribute)
    motor = motor_of(controller)
    if motor is not None and subject == "ambient":
        return lambda: controller.ambient
    if motor is not None and subject == "master":
        return lambda: controller.master.count
    if name in controller.pins and attribute == "volts" and isinstance(pin := controller.pins[name], UserPin):
        return lambda: pin.volts
    raise _unknown_name(name=subject, known=subjects(controller))


def subjects(controller: Controller) -> tuple[str, ...]:
    """Return the valid subjects of an expectation `= subject value`; PIN stands for the name of a pin."""
    axes = (f"{name}.{attribute}" for name, axis in controller.axes.items() for attribute in attributes(axis))
    others = () if motor_of(controller) is None else ("PIN.volts", "ambient", "master")
    return ("clock", *controller.pins, *_lines(controller), *others, *axes)


def _lines(controller: Controller) -> tuple[str, ...]:
    if on_a_bus(controller):
        return ("interrupt",)
    port = controller.ports.get(controller.name)
    return ("dtr", "rts") if port is not None and port.handshake else ()


def agrees(value: Value, wanted: str) -> bool:
    """True if a value equals the expected text.  A number is rounded to as many decimals as the expected text has."""
    if isinstance(value, bool):
        return value is _level(wanted)
    number = _number(wanted)
    # Increase the precision of Decimal from 28 to 300 digits, because the expected number can have 100 digits.
    with localcontext(prec=3 * MOST_CHARACTERS):
        return round(Decimal(value), _decimals(number)) == number


def shown(value: Value) -> str:
    if isinstance(value, bool):
        return level_name(value)
    return str(value) if isinstance(value, int) else f"{value:.9f}".rstrip("0").rstrip(".")


def _axis_action(axis: Axis, what: str, value: str) -> Callable[[], object]:
    if what == "jam":
        return partial(axis.jam, _level(value))
    if what == "load":
        return partial(axis.load, _real(value))
    return partial(axis.encoder.displace, _count(value))


def _level(value: str, *other_values: str) -> bool:
    try:
        return LEVELS[value]
    except KeyError:
        raise ProgramError(f"invalid level {value!r}: expected one of {', '.join((*LEVELS, *other_values))}") from None


def _duration(text: str, *, above_zero: bool = False) -> float:
    seconds = _real(text)
    if above_zero and seconds <= 0:
        raise ProgramError(f"duration {text} s is out of range: expected more than 0 s")
    with _placing_errors():
        to_ns(seconds)
    return seconds


def _count(text: str, most: int = MOST_COUNTS) -> int:
    """Parse a number of pulses or counts; decimals are dropped.  Raises ProgramError for a number beyond ±`most`."""
    number = _number(text)
    if abs(number) > most:
        raise ProgramError(f"number {shortened(text)} is out of range: expected {-most} to {most} pulses or counts")
    return int(number)


def _number(text: str) -> Decimal:
    with _placing_errors():
        return decimal(text)


def _real(text: str) -> float:
    with _placing_errors():
        return real(text)


@contextmanager
def _placing_errors() -> Iterator[None]:
    try:
        yield
    except UsageError as error:
        raise ProgramError(message=str(error)) from None


def _decimals(number: Decimal) -> int:
    exponent = number.as_tuple().exponent
    assert isinstance(exponent, int), "`_number` returns only finite numbers"
    return max(0, -exponent)


def _line(text: str, port: SerialPort) -> UartFormat:
    with _placing_errors():
        return line_format(text, port.host.format)[0]
