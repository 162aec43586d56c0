"""A setting of a machine, and the defects that override the setting while they are active; the settings of a shaft."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from axistwin.plant.machine_units import MachineUnits
from axistwin.sim.clock import Clock
from axistwin.sim.manual_actions import ManualAct, ManualActions, check_torque
from axistwin.sim.signal import Signal

T = TypeVar("T")


@dataclass(eq=False)
class _Value(Generic[T]):
    value: T


class Override(Generic[T]):
    """`values`: first the setting, then the values of the present defects, the latest at the end.

    `before_change` is called before each change, `on_change` after it.
    """

    def __init__(
        self, first: T, on_change: Callable[[], None], before_change: Callable[[], None] = lambda: None
    ) -> None:
        self._on_change, self._before_change = on_change, before_change
        self._values = [_Value(first)]

    @property
    def values(self) -> list[T]:
        return [added.value for added in self._values]

    def set(self, value: T) -> None:
        """Change the setting; an active defect still overrides it."""
        self._before_change()
        self._values[0].value = value
        self._on_change()

    def add(self, value: T) -> Callable[[], None]:
        """Add the value of a defect.  Return a function that ends the defect."""
        added = _Value(value)
        self._before_change()
        self._values.append(added)
        self._on_change()
        return lambda: self._end(added)

    def _end(self, added: _Value[T]) -> None:
        self._before_change()
        self._values.remove(added)
        self._on_change()


class Shaft:
    """Base of all axes: switches, units, torques and jams from outside, and the remaining torque of the motor.

    `limits`: first and last position within the limit switches; None: no switches.
    """

    def __init__(
        self, clock: Clock, name: str, limits: tuple[int, int] | None, on_change: Callable[[], None],
        before_change: Callable[[], None] = lambda: None,
    ) -> None:  # fmt: skip
        """The last two arguments are those of `Override`."""
        self.clock, self.name, self.limits = clock, name, limits
        self.units: MachineUnits | None = None
        """Unit of positions in texts and plots; the axis itself counts pulses or edges.  None: no other unit."""
        self.on_motion: Signal[[]] = Signal()
        """Event: a move begins, or changes its profile; never at a servo, whose position is read at each sample."""
        self.on_replan: Signal[[]] = Signal()
        """Event: later positions from `positions_ahead` are no longer certain; never at a stepper, which has none."""
        self._outside = Override(0.0, on_change, before_change)
        self._jams = Override(False, on_change, before_change)
        self._torque = Override(1.0, on_change, before_change)
        self.manual_actions = ManualActions(clock)
        """Reports the actions of a person at the axis: `load`, `jam`, `push`, and `ambient` at a servo motor."""

    @property
    def outside_torque(self) -> float:
        """External torque on the shaft, in N·m."""
        return sum(self._outside.values)

    @property
    def jammed(self) -> bool:
        return any(self._jams.values)

    @property
    def strength(self) -> float:
        """Remaining fraction of the motor's torque, 0 to 1; with several defects, the smallest fraction."""
        return min(self._torque.values)

    def weaken(self, left: float) -> Callable[[], None]:
        """Reduce the motor's torque to the fraction `left`, 0 to 1.  With 0 a stepper motor stops.

        An ideal motor distinguishes only 0 from other values.  Return a function that ends the defect.
        """
        return self._torque.add(left)

    def load(self, newton_metres: float) -> None:
        """Apply an external torque to the shaft; a positive torque acts in the positive direction."""
        check_torque(newton_metres)
        self.manual_actions.report(ManualAct.LOAD, newton_metres)
        self._outside.set(float(newton_metres))

    def burden(self, newton_metres: float) -> Callable[[], None]:
        return self._outside.add(newton_metres)

    def jam(self, on: bool = True) -> None:
        """Block the shaft, or release it; the pulses or the trajectory continue."""
        self.manual_actions.report(ManualAct.JAM, bool(on))
        self._jams.set(bool(on))

    def seize(self) -> Callable[[], None]:
        return self._jams.add(True)
