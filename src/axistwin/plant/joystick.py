"""A joystick that gives out pulses: as a Compumotor 852 does to an 1810 or 1811, one axis of it.

Its stick is held by a spring: at rest it says AT ZERO.  Deflected it gives out pulses at a rate, and their direction,
which it changes only while it has been at zero for long enough, before and after.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from axistwin.errors import UsageError
from axistwin.sim.by_hand import ByHand
from axistwin.sim.clock import Clock, Procedure
from axistwin.sim.pins import Pin
from axistwin.units import MS, S

FASTEST = 2_000_000
"""Pulses per second."""


@dataclass(frozen=True)
class JoystickInputs:
    """The inputs, by name, at which a controller is told of pulses, their direction, and that there are none."""

    at_zero: str
    step: str
    direction: str
    settle_ns: int = 4 * MS
    """It is at zero for so long before and after a change of direction."""
    usual: int = 5000
    """Pulses per second at full deflection, where nobody says otherwise."""


class Joystick:
    """One axis of it, plugged into a controller's inputs when it is first touched."""

    def __init__(self, clock: Clock, pins: Mapping[str, Pin], inputs: JoystickInputs) -> None:
        self.clock, self.inputs = clock, inputs
        self._at_zero, self._step, self._direction = (
            pins[name] for name in (inputs.at_zero, inputs.step, inputs.direction)
        )
        self.by_hand = ByHand(clock)
        """Reports how a person holds the stick: `joystick`."""
        self.rate = 0
        """Pulses per second, negative: counter-clockwise; 0: the stick is at rest."""
        self._out = self._plugged_in = False

    def deflect(self, rate: int) -> None:
        """Hold the stick so that it gives so many pulses per second; 0: let it go.  Raises UsageError."""
        if abs(rate) > FASTEST:
            raise UsageError(f"joystick {rate}: give pulses per second, from {-FASTEST} to {FASTEST}")
        self.by_hand.tell("joystick", rate)
        if not self._plugged_in:
            self._plug_in()
        self.rate = rate
        if rate and not self._out:
            self._out = True
            self.clock.process(self._deflected())

    def _plug_in(self) -> None:
        """From now on it has the inputs."""
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
        """At zero, in this direction, long enough."""
        if self._direction.level is not clockwise:
            yield self.clock.timeout(self.inputs.settle_ns)
            self._direction.set(clockwise)
        yield self.clock.timeout(self.inputs.settle_ns)

    def _pulse(self, half_ns: int) -> Procedure:
        self._step.set(True)
        yield self.clock.timeout(half_ns)
        self._step.set(False)
        yield self.clock.timeout(half_ns)
