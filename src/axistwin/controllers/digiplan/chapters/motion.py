"""The ramp generator: axes that move together share clock, speed and ramp; each axis has its own direction.

A rate multiplier generates a second, slower clock for the minor axes of a linear interpolation.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction

from axistwin.plant.stepper import StepperAxis
from axistwin.sim.clock import Clock, Event
from axistwin.sim.motion.profile import Profile
from axistwin.sim.motion.ramp import Ramp
from axistwin.sim.pins import Pin

DIRECTIONS = {axis: f"{axis.lower()}_direction" for axis in "XYZ"}  # The direction output of each axis.
PULSE_NS = 5_000  # Time for which a clock output is high: half a period at 100,000 steps/s, the highest speed.


class RampGenerator:
    """Outputs step pulses and direction signals for all axes that move together."""

    def __init__(self, clock: Clock, axes: Mapping[str, StepperAxis], pins: Mapping[str, Pin]) -> None:
        self.clock, self.axes, self.pins = clock, axes, pins
        self.profile = Profile(())
        self.ramp: Ramp | None = None
        self.directions: dict[str, int] = {}
        self.ended: Event = clock.event()  # The end of the motion; a change of the profile replaces this event.
        self.interpolating = False
        self._ratios: dict[str, Fraction] = {}
        self._start_ns = 0
        self._steps_before = 0
        self._unmade_before: dict[str, int] = {}

    def begin(
        self, profile: Profile, ramp: Ramp, directions: Mapping[str, int], minor: Mapping[str, Fraction] | None = None,
        *, further: bool = False,
    ) -> None:  # fmt: skip
        """Start the axes; `further`: True if the steps belong to the previous motion.

        `minor`: in an interpolation, the ratio of the rate of each minor axis to that of the profile.
        """
        self._steps_before = self.steps if further else 0
        self._ratios, self.interpolating = dict(minor or {}), minor is not None
        self.profile, self.ramp, self.directions = profile, ramp, dict(directions)
        self._start_ns = self.clock.now
        self._unmade_before = {axis: self.axes[axis].unmade for axis in directions if axis not in self._ratios}
        for axis, direction in directions.items():
            self.pins[DIRECTIONS[axis]].set(direction > 0)
        for axis, direction in directions.items():
            self.axes[axis].start(self._share(axis), direction)
        self._plan_end()

    def _share(self, axis: str) -> Profile:
        ratio = self._ratios.get(axis)
        return self.profile if ratio is None else self.profile.scaled(ratio)

    def _plan_end(self) -> None:
        end_ns = self.profile.end_ns
        self.ended = self.clock.event() if end_ns is None else self.clock.timeout(end_ns - self._elapsed_ns)

    @property
    def _elapsed_ns(self) -> int:
        return self.clock.now - self._start_ns

    @property
    def running(self) -> bool:
        """True until the velocity profile has ended."""
        return not self.profile.over(self._elapsed_ns)

    @property
    def rate(self) -> Fraction:
        """Frequency of the pulse clock that all moving axes share, in steps/s."""
        return self.profile.rate_at(self._elapsed_ns)

    @property
    def trend(self) -> int:
        """Sign of the acceleration: +1, -1, or 0 at a constant speed."""
        return self.profile.trend(self._elapsed_ns)

    @property
    def levels(self) -> Sequence[Fraction]:
        """Step rates of the ramp, from the start/stop speed upwards; empty without a ramp."""
        return () if self.ramp is None else self.ramp.levels

    @property
    def steps(self) -> int:
        """Pulses of the common clock since the last index or run began."""
        made = self._steps_before + self.profile.pulses_by(self._elapsed_ns)
        unmade = (abs(self.axes[axis].unmade - before) for axis, before in self._unmade_before.items())
        return max(made - max(unmade, default=0), 0)

    def clock_level(self, axis: str) -> bool:
        """Return the level of an axis's clock output.  The output is high for 5 µs at each pulse."""
        if axis not in self.directions:
            return False
        share, elapsed_ns = self._share(axis), self._elapsed_ns
        return share.pulses_by(elapsed_ns) > share.pulses_by(max(elapsed_ns - PULSE_NS, 0))

    def decelerate(self) -> None:
        """Decelerate to rest along the ramp; at or below the start/stop speed, stop at once."""
        if not self.running or self.trend < 0:
            return
        assert self.ramp is not None
        self._change(self.profile.cut(self._elapsed_ns, self.ramp.down_from(self.rate)))

    def _change(self, profile: Profile) -> None:
        self.profile = profile
        for axis in self.directions:
            self.axes[axis].replace(self._share(axis))
        self._plan_end()

    def drop(self, axis: str) -> None:
        """Stop an axis without deceleration.  When the last axis stops, stop the ramp generator as well."""
        if self.directions.pop(axis, None) is None or not self.running:
            return
        self.axes[axis].halt()
        if not self.directions:
            self._change(self.profile.cut_whole(self._elapsed_ns))

    def stop(self) -> None:
        """Stop all axes immediately.  Called when the power is switched off."""
        for axis in tuple(self.directions):
            self.drop(axis)
