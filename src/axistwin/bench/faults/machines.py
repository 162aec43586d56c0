"""Faults of machines: switches and pins, encoders, motors, drives, supplies."""

from collections.abc import Callable, Mapping
from fractions import Fraction
from math import prod
from typing import Any

from axistwin.bench.faults.places import Spot
from axistwin.bench.faults.table import Case, Mend, all_of, ended
from axistwin.core.errors import UsageError
from axistwin.core.units import MS
from axistwin.plant.axes import Axis
from axistwin.plant.servo_axis import ServoAxis
from axistwin.plant.stepper import StepperAxis
from axistwin.sim.pins import Pin


def stuck(case: Case) -> Mend:
    """Fault: the terminal is held at a level, even if another level is applied."""
    return _pin(case).hold(case.values["level"])


class Bounce:
    """Fault: a contact opens and closes again a few times after every change.

    While the contact bounces, the terminal ignores its source.  If the source has changed by the end, the contact
    bounces again.
    """

    def __init__(self, case: Case) -> None:
        self._case, self._pin = case, _pin(case)
        self._bouncing = False
        self._let_go: Callable[[], None] = ended
        self._unsubscribe = self._pin.subscribe(self._changed)

    def end(self) -> None:
        self._unsubscribe()
        self._bouncing = False
        self._release()

    def _changed(self, pin: Pin) -> None:
        if not self._bouncing:
            self._bouncing = True
            self._go_on(pin.level, 2 * self._case.values["count"])

    def _go_on(self, level: bool, left: int) -> None:
        self._case.clock.call_later(self._pause_ns(), lambda: self._swing(not level, left))

    def _swing(self, level: bool, left: int) -> None:
        if not self._bouncing:
            return
        before, self._let_go = self._let_go, self._pin.hold(level)
        before()
        if left > 1:
            self._go_on(level, left - 1)
        else:
            self._bouncing = False
            self._release()

    def _release(self) -> None:
        let_go, self._let_go = self._let_go, ended
        let_go()

    def _pause_ns(self) -> int:
        mean_ns: int = round(self._case.values["ms"] * MS / (2 * self._case.values["count"]))
        chance = self._case.chance
        return max(1, mean_ns if chance is None else mean_ns // 2 + chance.below(mean_ns + 1))


def bounce(case: Case) -> Mend:
    """Fault: the contact bounces at each change of its level."""
    return Bounce(case).end


def open_wire(case: Case) -> Mend:
    """Fault: the wire of an input is broken.

    An opto-isolated input of an IF1 is low without current; the inputs of the others have pull-up resistors.
    """
    return _pin(case).hold(not case.spot.machine.product.closed_level)


NO_SWITCH = ("channel_z", "test_switch")  # Inputs of an 1810 or 1811 whose manual states no level for an open wire.


def check_wire(spot: Spot) -> None:
    """Raise UsageError unless a pin is an input whose unconnected level the manual states."""
    assert spot.pin is not None, "the fault is one of a pin"
    terminal = spot.name
    if not spot.pin.drivable:
        raise UsageError(f"{terminal} is an output: expected an input")
    if spot.pin.name in NO_SWITCH:
        raise UsageError(
            f"the fault `open_wire` is not possible at {terminal}, because the manual gives no level for an open wire: "
            "use the fault `stuck`, which sets the level"
        )


def open_limit(case: Case) -> Mend:
    """Fault: the circuit of a limit switch is open."""
    product, pins = case.spot.machine.product, case.spot.machine.pins
    sides = {"minus": slice(0, 1), "plus": slice(1, 2), "both": slice(0, 2)}
    names = dict.fromkeys(name for both in product.limit_pins.values() for name in both[sides[case.values["side"]]])
    return all_of([pins[name].hold(not product.closed_level) for name in names])


def check_limits(spot: Spot) -> None:
    """Raise UsageError if the controller has no limit inputs."""
    if not spot.machine.product.limit_pins:
        raise UsageError(f"controller {spot.name} has no inputs for limit switches: expected e.g. a SmartMotor")


def encoder_slips(case: Case) -> Mend:
    """Fault: the encoder slips once on its shaft, by a number of counts."""
    _axis(case).encoder.slip(case.values["counts"])
    return ended


def encoder_loses(case: Case) -> Mend:
    """Fault: every n-th count of the encoder is lost."""
    return _miscount(case, "encoder_loses")


def encoder_reversed(case: Case) -> Mend:
    """Fault: the encoder counts backwards, as if two wires were exchanged."""
    return _miscount(case, "encoder_reversed")


def encoder_dead(case: Case) -> Mend:
    """Fault: the encoder stops counting."""
    return _miscount(case, "encoder_dead")


MISCOUNTS: dict[str, Callable[[Mapping[str, Any]], Fraction]] = {
    "encoder_loses": lambda values: Fraction(values["every"] - 1, values["every"]),
    "encoder_reversed": lambda _: Fraction(-1),
    "encoder_dead": lambda _: Fraction(0),
}
"""By kind of fault, the ratio of the encoder's counts to the correct counts."""


def _miscount(case: Case, kind: str) -> Mend:
    """Combine all active encoder faults: multiply their ratios."""
    encoder = _axis(case).encoder

    def count(*own: Fraction) -> None:
        others = (MISCOUNTS[name](values) for name, values in case.others() if name in MISCOUNTS)
        ratio = prod((*own, *others), start=Fraction(1))
        encoder.miscount(ratio.numerator, ratio.denominator)

    count(MISCOUNTS[kind](case.values))
    return count


def check_encoder(spot: Spot) -> None:
    """Raise UsageError if the axis has no encoder."""
    if isinstance(spot.axis, ServoAxis):
        check_data_sheet(spot)
    elif spot.axis is not None:
        _ = spot.axis.encoder  # Reading the property `encoder` raises UsageError if the axis has no encoder.


def check_data_sheet(spot: Spot) -> None:
    """Raise UsageError for an ideal motor, whose shaft follows exactly: the fault would have no effect."""
    axis = spot.axis or next(iter(spot.machine.axes.values()))
    if isinstance(axis, ServoAxis) and axis.motor is None:
        name = spot.name
        raise UsageError(
            f'the motor of {name} is ideal and cannot have this fault: select a real motor type, e.g. motor="frame23"'
        )


def stall(case: Case) -> Mend:
    """Fault: the motor has only a fraction of its torque, or no torque."""
    return _axis(case).weaken(case.values["left"])


def jam(case: Case) -> Mend:
    """Fault: the shaft is blocked."""
    return _axis(case).seize()


def load(case: Case) -> Mend:
    """Fault: an additional torque acts on the shaft."""
    return _axis(case).burden(case.values["torque"])


def push(case: Case) -> Mend:
    """Fault: the load is displaced once, by a number of counts."""
    _axis(case).encoder.displace(case.values["counts"])
    return ended


def check_push(spot: Spot) -> None:
    """Raise UsageError if the axis has no encoder to detect a displacement."""
    if isinstance(spot.axis, StepperAxis):
        _ = spot.axis.encoder


def drive_fault(case: Case) -> Mend:
    """Fault: the drive switches off and signals the fault.  The motor has no torque."""
    let_go = case.spot.machine.pins[_fault_pin(case.spot)].hold(False)
    return all_of([_axis(case).weaken(0.0), let_go])


def check_drive(spot: Spot) -> None:
    """Raise UsageError if the controller has no drive fault input for the axis."""
    _fault_pin(spot)


def _fault_pin(spot: Spot) -> str:
    name = spot.name.rpartition(".")[2]
    controller, pins = spot.machine.name, spot.machine.product.drive_fault_pins
    if not pins:
        raise UsageError(f"controller {controller} has no drive fault input: simulate another fault, e.g. `jam`")
    if name not in pins:
        axes = ", ".join(pins)
        raise UsageError(f"{controller} has no drive fault input for axis {name}: expected one of the axes {axes}")
    return pins[name]


def overheat(case: Case) -> Mend:
    """Fault: the temperature around the motor rises."""
    return _servo(case.spot).heat(case.values["celsius"])


def supply_dip(case: Case) -> Mend:
    """Fault: the supply voltage drops.  A SmartMotor resets below a limit; other controllers always reset."""
    axis = next((axis for axis in case.spot.machine.axes.values() if isinstance(axis, ServoAxis)), None)
    return power_cut(case) if axis is None else axis.sag(case.values["left"])


def power_cut(case: Case) -> Mend:
    """Fault: the power is off until the fault ends."""
    machine = case.spot.machine
    machine.power(False)
    servo = any(isinstance(axis, ServoAxis) for axis in machine.axes.values())
    cuts = ("power_cut",) if servo else ("power_cut", "supply_dip")

    def mend() -> None:
        if not any(name in cuts for name, _ in case.others()):
            machine.power(True)

    return mend


def check_motor(spot: Spot) -> None:
    """Raise UsageError if the controller is not a SmartMotor."""
    _servo(spot)


def _servo(spot: Spot) -> ServoAxis:
    axis = next((axis for axis in spot.machine.axes.values() if isinstance(axis, ServoAxis)), None)
    if axis is None:
        raise UsageError(f"{spot.name} is not a SmartMotor: expected the name of a SmartMotor")
    return axis


def _axis(case: Case) -> Axis:
    assert case.spot.axis is not None, "an axis was found"
    return case.spot.axis


def _pin(case: Case) -> Pin:
    assert case.spot.pin is not None, "a terminal was found"
    return case.spot.pin
