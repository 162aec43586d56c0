"""Create axes from the options of `Bench.add`, and check these options."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import fields
from numbers import Integral, Real
from typing import Any, TypeVar

from axistwin.core.errors import UsageError
from axistwin.plant.encoder import EncoderData
from axistwin.plant.machine_units import MOST_POSITION, MachineUnits, position
from axistwin.plant.servo_axis import ServoAxis, data_sheets
from axistwin.plant.stepper import StepperAxis
from axistwin.plant.torque import Load, StepperMotor
from axistwin.sim.clock import Clock

Axis = StepperAxis | ServoAxis
MakeAxis = Callable[[Clock, str, Mapping[str, Any], int], Axis]
"""Function that creates an axis from a clock, a name, options and the number of stored moves."""

MOST = 1_000_000_000  # Largest number in the data of a stepper axis.
EXAMPLES = {
    "encoder": "{ counts_per_rev = 4000, pulses_per_rev = 400 }",
    "motor": "{ torque = [[0, 1.2], [5000, 0.4]] }",
    "load": "{ torque = 0.1, inertia = 1e-5 }",
}
"""Options of an axis in TOML, as scenes and the command line have them."""
STEPPER = ("limits", "home", "encoder", "motor", "load", "units")
SERVO = ("limits", "motor", "load", "units")


def stepper_axis(clock: Clock, name: str, given: Mapping[str, Any], history: int) -> StepperAxis:
    """Return an axis with a stepper motor.  Options: `units`, `limits`, `home`, `encoder`, `motor`, `load`."""
    _check(name, given, STEPPER)
    units = _units(name, given)
    limits, home = (_span(name, option, given.get(option), units) for option in ("limits", "home"))
    try:
        encoder = _data(EncoderData, "encoder", given.get("encoder"))
        motor = _data(StepperMotor, "motor", _with_points(given.get("motor")))
        load = _data(Load, "load", given.get("load"))
    except KeyError:
        raise UsageError(
            f"the motor of axis {name} needs `torque`: expected pairs of speed (pulses/s) and torque (N·m), "
            "e.g. torque=[[0, 1.2], [5000, 0.4]]"
        ) from None
    except ValueError as what_was_expected:
        raise UsageError(f"invalid option of axis {name}: {what_was_expected}") from None
    axis = StepperAxis(clock, name, motor=motor, load=load, encoder=encoder, limits=limits, home=home, history=history)
    axis.units = units
    return axis


T = TypeVar("T", EncoderData, StepperMotor, Load)


def _data(kind: type[T], part: str, given: Any) -> T | None:
    if given is None or isinstance(given, kind):
        return given
    if not isinstance(given, Mapping):
        raise ValueError(f"invalid {part} {given!r}: expected a table, e.g. {EXAMPLES[part]}")
    known = {field.name: field.type for field in fields(kind)}
    for name, value in given.items():
        if name not in known:
            raise ValueError(f"unknown parameter {name!r} of the {part}: expected one of {', '.join(known)}")
        if known[name] in (int, float):
            _check_number(f"{name}={value!r} of the {part}", value, whole=known[name] is int)
    return kind(**given)


def _check_number(text: str, value: Any, *, whole: bool) -> None:
    number = isinstance(value, Integral if whole else Real) and not isinstance(value, bool)
    if not number or not -MOST <= value <= MOST:
        raise ValueError(f"invalid {text}: expected a {'whole ' * whole}number from {-MOST} to {MOST}")


def _with_points(motor: Any) -> Any:
    if not isinstance(motor, Mapping):
        return motor
    points = motor["torque"]
    try:
        pairs = tuple((rate, torque) for rate, torque in points)
    except (TypeError, ValueError):
        raise ValueError("invalid torque curve: expected pairs (pulses/s, N·m), e.g. [[0, 1.2], [5000, 0.4]]") from None
    for number in (number for pair in pairs for number in pair):
        _check_number(f"number {number!r} of the torque curve", number, whole=False)
    return {**motor, "torque": tuple((float(rate), float(torque)) for rate, torque in pairs)}


def servo_axis(clock: Clock, name: str, given: Mapping[str, Any], history: int) -> ServoAxis:
    """Return an axis with servo motor and encoder.  Options: `units`, `limits`, `motor` (name or data), `load`."""
    _check(name, given, SERVO)
    units = _units(name, given)
    limits = _span(name, "limits", given.get("limits"), units)
    try:
        motor, load = data_sheets(given)
    except UsageError as what_was_expected:
        raise UsageError(f"invalid option of axis {name}: {what_was_expected}") from None
    axis = ServoAxis(clock, name, motor=motor, load=load, limits=limits, history=history)
    axis.units = units
    return axis


def _check(name: str, given: Mapping[str, Any], known: Iterable[str]) -> None:
    for option in given:
        if option not in known:
            raise UsageError(f"axis {name} has no option {option!r}: expected one of {', '.join(known)}")


def _units(name: str, given: Mapping[str, Any]) -> MachineUnits | None:
    if given.get("units") is None:
        return None
    try:
        return MachineUnits.given(given["units"])
    except UsageError as what_was_expected:
        raise UsageError(f"invalid units of axis {name}: {what_was_expected}") from None


def _span(name: str, option: str, given: Any, units: MachineUnits | None) -> tuple[int, int] | None:
    if given is None:
        return None
    try:
        first, last = given
    except (TypeError, ValueError):
        first = last = None
    try:
        first, last = (position(end, units) if isinstance(end, str) else end for end in (first, last))
    except UsageError as what_was_expected:
        raise UsageError(f"invalid {option}={given!r} of axis {name}: {what_was_expected}") from None
    if not (type(first) is int and type(last) is int and first <= last):
        raise UsageError(f"invalid {option}={given!r} of axis {name}: expected two positions, e.g. [-100, 5000]")
    if not -MOST_POSITION <= first <= last <= MOST_POSITION:
        raise UsageError(
            f"invalid {option} of axis {name}: expected positions from {-MOST_POSITION} to {MOST_POSITION}"
        )
    return first, last
