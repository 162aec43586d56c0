"""One axis of a joystick with pulse output, such as a Compumotor 852 at an 1810 or 1811.

A spring centres the stick: at rest the joystick outputs AT ZERO.  A deflected joystick outputs pulses at a rate, and
their direction.  The direction changes only while AT ZERO is active: at least `settle_ns` after AT ZERO becomes active,
and at least `settle_ns` before AT ZERO ends.
"""

from collections.abc import Mapping
from typing import NamedTuple

from axistwin.core.errors import UsageError
from axistwin.core.units import MS, S
from axistwin.sim.clock import Clock, Procedure
from axistwin.sim.manual_actions import ManualAct, ManualActions
from axistwin.sim.pins import Pin

FASTEST = 2_000_000  # Maximum rate of the joystick, in pulses per second.


class JoystickInputs(NamedTuple):
    """Names of the controller inputs for the three joystick signals: AT ZERO, pulses and direction."""

    at_zero: str
    step: str
    direction: str
    settle_ns: int = 4 * MS  # Time for which AT ZERO is active before and after a change of direction.
    usual: int = 5000  # Default rate at full deflection, in pulses per second.


class Joystick:
    """One axis of the joystick; its first use connects it to the controller's inputs."""

    def __init__(self, clock: Clock, pins: Mapping[str, Pin], inputs: JoystickInputs) -> None:
        self.clock, self.inputs = clock, inputs
        self._at_zero, self._step, self._direction = (
            pins[name] for name in (inputs.at_zero, inputs.step, inputs.direction)
        )
        self.manual_actions = ManualActions(clock)  # Reports the actions of a person at the joystick.
        self.rate = 0  # Pulse rate in pulses per second; negative for counter-clockwise, 0 for a stick at rest.
        self._out = self._plugged_in = False

    def deflect(self, rate: int) -> None:
        """Output `rate` pulses per second; 0 releases the joystick.  Raises UsageError for an invalid rate."""
        if abs(rate) > FASTEST:
            raise UsageError(f"invalid joystick rate {rate}: expected {-FASTEST} to {FASTEST} pulses per second")
        self.manual_actions.report(ManualAct.JOYSTICK, rate)
        if not self._plugged_in:
            self._plug_in()
        self.rate = rate
        if rate and not self._out:
            self._out = True
            self.clock.process(self._deflected())

    def _plug_in(self) -> None:
        self._plugged_in = True
        for pin in (self._at_zero, self._step, self._direction):
            pin.wired = True
        self._at_zero.set(True)
        self._step.set(False)

    def _deflected(self) -> Procedure:
        while self.rate:
            clockwise = self.rate > 0
            yield from self._face(clockwise)
            self._at_zero.set(False)
            while self.rate and (self.rate > 0) is clockwise:
                yield from self._pulse(S // (2 * abs(self.rate)))
            self._at_zero.set(True)
            yield self.clock.timeout(self.inputs.settle_ns)
        self._out = False

    def _face(self, clockwise: bool) -> Procedure:
        """Set the direction, with `settle_ns` at zero before and after the change."""
        if self._direction.level is not clockwise:
            yield self.clock.timeout(self.inputs.settle_ns)
            self._direction.set(clockwise)
        yield self.clock.timeout(self.inputs.settle_ns)

    def _pulse(self, half_ns: int) -> Procedure:
        self._step.set(True)
        yield self.clock.timeout(half_ns)
        self._step.set(False)
        yield self.clock.timeout(half_ns)
