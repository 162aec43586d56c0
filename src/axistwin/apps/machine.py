"""What a conversation can do to a controller and ask of it, by the names people use."""

from collections.abc import Callable, Iterable
from decimal import Decimal, InvalidOperation
from functools import partial

from axistwin.bench import Controller, line_format
from axistwin.errors import ProgramError, UsageError
from axistwin.plant.stepper import StepperAxis
from axistwin.sim.serial import UartFormat

LEVELS = {"high": True, "on": True, "low": False, "off": False}
ATTRIBUTES = ("position", "pulses", "velocity", "encoder")

Value = bool | int | float | Decimal


def level_name(level: bool) -> str:
    """How a level is written."""
    return "high" if level else "low"


def action(controller: Controller, target: str, value: str) -> Callable[[], object]:
    """What `! target value` does, when called.  Raises ProgramError if there is no such thing."""
    if target in controller.pins:
        pin = controller.pins[target]
        return pin.release if value == "release" else partial(pin.drive, _level(value, "release"))
    axis, _, what = target.partition(".")
    if axis in controller.axes and what in ("jam", "load", "push"):
        return _axis_action(controller.axes[axis], what, value)
    if target == "power":
        return partial(controller.power, _level(value))
    return _bus_action(controller, target, value) if on_a_bus(controller) else _line_action(controller, target, value)


def on_a_bus(controller: Controller) -> bool:
    """Whether it has registers on a bus instead of a serial port."""
    return controller.product.attend is not None


def _bus_action(controller: Controller, target: str, value: str) -> Callable[[], object]:
    if target == "init":
        return controller.bus.init if _level(value) else lambda: None
    raise _nothing_called(target, (*controller.pins, "power", "init", "AXIS.jam", "AXIS.load", "AXIS.push"))


def _line_action(controller: Controller, target: str, value: str) -> Callable[[], object]:
    port = controller.serial
    match target:
        case "dtr":
            return partial(port.host.dtr_line.set, _level(value))
        case "rts":
            return partial(port.host.rts_line.set, _level(value))
        case "break":
            return partial(port.send_break, float(_positive(value)))
        case "line":
            return partial(setattr, port.host, "format", _line(value, controller))
    others = ("power", "dtr", "rts", "break", "line", "AXIS.jam", "AXIS.load", "AXIS.push")
    raise _nothing_called(target, (*controller.pins, *others))


def _nothing_called(name: str, known: Iterable[str]) -> ProgramError:
    return ProgramError(f"nothing called {name!r} here: there are {', '.join(known)}")


def question(controller: Controller, subject: str) -> Callable[[], Value]:
    """What `= subject …` looks at.  Raises ProgramError if there is no such thing."""
    if subject in controller.pins:
        return lambda: controller.pins[subject].level
    lines = ("interrupt",) if on_a_bus(controller) else ("dtr", "rts")
    if subject in lines:
        port = controller.bus if on_a_bus(controller) else controller.serial
        return lambda: bool(getattr(port, subject))
    name, _, attribute = subject.partition(".")
    if name in controller.axes and attribute in ATTRIBUTES:
        return _axis_question(controller.axes[name], attribute)
    axes = (f"{name}.{attribute}" for name in controller.axes for attribute in ATTRIBUTES)
    raise _nothing_called(subject, ("clock", *controller.pins, *lines, *axes))


def agrees(value: Value, wanted: str) -> bool:
    """Whether a value is what is wanted: a level, a whole number, or a number to as many decimals as are written."""
    if isinstance(value, bool):
        return value is _level(wanted)
    number = _number(wanted)
    return round(Decimal(value), _decimals(number)) == number


def shown(value: Value) -> str:
    """A value as it would be written in a conversation."""
    if isinstance(value, bool):
        return level_name(value)
    return str(value) if isinstance(value, int) else f"{value:.9f}".rstrip("0").rstrip(".")


def _axis_action(axis: StepperAxis, what: str, value: str) -> Callable[[], object]:
    if what == "jam":
        return partial(axis.jam, _level(value))
    if what == "load":
        return partial(axis.load, float(_number(value)))
    return partial(axis.encoder.displace, int(_number(value)))


def _axis_question(axis: StepperAxis, attribute: str) -> Callable[[], Value]:
    if attribute == "encoder":
        return partial(getattr, axis.encoder, "count")
    return partial(getattr, axis, attribute)


def _level(value: str, *others: str) -> bool:
    try:
        return LEVELS[value]
    except KeyError:
        raise ProgramError(f"{value!r} is no level: there are {', '.join((*LEVELS, *others))}") from None


def _positive(text: str) -> Decimal:
    number = _number(text)
    if number <= 0:
        raise ProgramError(f"{text} is not above zero")
    return number


def _number(text: str) -> Decimal:
    try:
        number = Decimal(text)
    except InvalidOperation:
        raise ProgramError(f"{text!r} is no number") from None
    if not number.is_finite():
        raise ProgramError(f"{text!r} is no number")
    return number


def _decimals(number: Decimal) -> int:
    exponent = number.as_tuple().exponent
    assert isinstance(exponent, int), "finite, as _number has seen to"
    return max(0, -exponent)


def _line(text: str, controller: Controller) -> UartFormat:
    try:
        return line_format(text, controller.serial.host.format)[0]
    except UsageError as error:
        raise ProgramError(str(error)) from None
