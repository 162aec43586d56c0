"""State of position tracking: encoder count, parameters of B0h to B5h, and the present or most recent move."""

from dataclasses import dataclass
from enum import Enum
from functools import lru_cache
from math import isqrt

from axistwin.controllers.compumotor.parts.library import Move
from axistwin.controllers.compumotor.parts.pulses import Phase, PulseGenerator, VelocityProfile
from axistwin.controllers.compumotor.parts.ranges import VELOCITY_RANGES
from axistwin.plant.stepper import StepperAxis
from axistwin.sim.motion.profile import Segment


def wrapped(count: int) -> int:
    """Return the value of a signed 32-bit counter after `count` pulses, e.g. -2³¹ after 2³¹ pulses."""
    return (count + 0x8000_0000) % (1 << 32) - 0x8000_0000


@dataclass(frozen=True)
class Law:
    """The correction law of B3h.  `maximum` is in units of the velocity range in the upper nibble of `ranges`."""

    algorithm: int
    gain: int
    ranges: int
    maximum: int

    def velocity_profile(self, error: int) -> VelocityProfile:
        """Return endless motion that corrects `error`, at least at the resolution of the velocity range."""
        e = abs(error)
        wish = {1: self.gain * e, 2: isqrt(self.gain**2 * e), 3: self.gain * e**2}[self.algorithm]
        return _endless(self.ranges >> 4, min(wish, self.maximum))


@lru_cache(maxsize=64)
def _endless(velocity_range: int, number: int) -> VelocityProfile:
    """Return endless motion at velocity `number`; instead of 0, the lowest velocity of the range."""
    velocities = VELOCITY_RANGES[velocity_range]
    rate = velocities.rate(number) or velocities.resolution
    return VelocityProfile(((Phase.CONSTANT, (Segment(rate, None),)),), velocities.maximum, of_move=False)


class Encoder:
    """Counter of the encoder's quadrature edges.  Command 14h defines the + direction of the count.

    Without an encoder, and on an 1810, the count stays at 0.
    """

    def __init__(self, axis: StepperAxis | None, inverted: bool) -> None:
        self._axis, self._wired = axis, (-1 if inverted else +1)
        self._sense, self._origin = self._wired, 0
        self._origin = -self.count

    @property
    def count(self) -> int:
        """Encoder pulses since reset."""
        return self._origin + self._sense * ((self._axis.encoder_count if self._axis else None) or 0)

    def per_pulses(self, physical: int) -> tuple[int, int, int] | None:
        """Return counts, pulses and the largest deviation in counts, for a motion CW (+1) or CCW (-1).

        The counts are negative if the encoder counts down in this direction.  None while the motor loses steps.
        """
        if self._axis is None:
            return 0, 1, 0
        known = self._axis.counts_per_pulses()
        if known is None:
            return None
        counts, pulses, deviation = known
        return counts * physical * self._sense, pulses, deviation

    def face(self, sense: int) -> None:
        """Define the direction in which the encoder counts up, +1 for CW or -1 for CCW; the count stays."""
        before, self._sense = self.count, sense * self._wired
        self._origin += before - self.count


class Use(Enum):
    """Possible uses of the motor, e.g. an open-loop move or joystick control."""

    OPEN_LOOP = "an open-loop move, or none"
    CLOSED_LOOP = "a closed-loop move"
    SEARCH = "a search for home: no corrections, even between the motions of the search"
    JOYSTICK = "the joystick is enabled"


class Tracking:
    """Parameters and state of position tracking.  All positions are in encoder pulses.  The position at reset is 0."""

    def __init__(self, pulses: PulseGenerator, encoder: Encoder, *, moves: bool) -> None:
        """`moves`: True if closed-loop moves are available, by an encoder or by the option `encoder_commands`."""
        self._pulses, self.encoder, self.moves = pulses, encoder, moves
        self.ratio: tuple[int, int] | None = None
        self.resolution: int | None = None
        self.sigma: int | None = None
        self.teeth: int | None = None
        self.law: Law | None = None
        self.deadband: int | None = None
        self.on = False  # True while position maintenance (18h) is on.
        self.ends_stalled_moves = False  # True if a stall ends a move (19h).
        self.zero = self.desired = 0
        self.commanded: tuple[Move, int] | None = None
        # Kind of the present move, or of the last move if the motor is at rest, e.g. a search for HOME.
        self.use = Use.OPEN_LOOP
        self._began = 0
        self.ended: int | None = 0  # Encoder count at the end of the last move; None during a move.
        self.reference: tuple[int, int] | None = (0, 0)  # Positions from which slip is measured; None after a stall.
        self.correction: VelocityProfile | None = None
        self.ticking = False

    @property
    def absolute(self) -> int:
        """Absolute position of the encoder, in encoder pulses."""
        return wrapped(self.encoder.count - self.zero)

    @property
    def relative(self) -> int:
        """Encoder pulses since the start of the present move, or of the whole last move."""
        return wrapped((self.encoder.count if self.ended is None else self.ended) - self._began)

    @property
    def error(self) -> int:
        """Desired position minus actual position, in encoder pulses."""
        return wrapped(self.desired - self.encoder.count)

    @property
    def in_deadband(self) -> bool:
        """True if the error is within a defined deadband (B5h)."""
        return self.deadband is not None and abs(self.error) <= self.deadband

    def slipped(self, pulses: int, counts: int) -> int:
        """Return the slip between motor and encoder, less the backlash, in rotor teeth."""
        if self.ratio is None or not (self.resolution and self.teeth):
            return 0
        return self._teeth(abs(self._difference(pulses, counts)))

    def _difference(self, pulses: int, counts: int) -> int:
        """Return motor position less encoder position, in motor pulses divided by the ratio's encoder pulses."""
        assert self.ratio is not None
        motor, encoder = self.ratio
        return pulses * encoder - counts * motor

    def _teeth(self, difference: int) -> int:
        assert self.ratio is not None and self.resolution and self.teeth
        encoder = self.ratio[1]
        beyond = difference - (self.sigma or 0) * encoder
        return max(0, beyond * self.teeth // (self.resolution * encoder))

    @property
    def detects_stalls(self) -> bool:
        """True if the host has defined all parameters that the detection of stalls needs."""
        return self.ratio is not None and self.sigma is not None and bool(self.resolution and self.teeth)

    @property
    def watches(self) -> bool:
        return self.ended is None and self.reference is not None and self.detects_stalls

    @property
    def since_reference(self) -> tuple[int, int]:
        """Motor pulses and encoder counts since the start of the move.  Valid only while `watches` is True."""
        assert self.reference is not None
        pulses, counts = self.reference
        return self._pulses.position - pulses, self.encoder.count - counts

    def cannot_stall(self, within_ns: int) -> bool:
        """True if no stall can be detected within `within_ns`; valid while motion and machine do not change."""
        if not self.watches:
            return True
        per_pulses = self.encoder.per_pulses(self._pulses.physical)
        if per_pulses is None:
            return False
        assert self.ratio is not None
        (motor, encoder), (counts, pulses, deviation) = self.ratio, per_pulses
        drift = abs(self._pulses.sign * encoder * pulses - counts * motor) * self._pulses.within(within_ns)
        return not self._teeth(abs(self._difference(*self.since_reference)) + motor * deviation - (-drift // pulses))

    @property
    def complete(self) -> bool:
        """True if the host has defined all closed-loop parameters (commands B0h to B4h)."""
        return None not in (self.ratio, self.resolution, self.sigma, self.law, self.teeth)

    @property
    def maintains(self) -> bool:
        law = self.law
        return self.on and self.ratio is not None and law is not None and bool(law.gain and law.maximum)

    @property
    def owns_motion(self) -> bool:
        return self._pulses.velocity_profile is self.correction

    @property
    def correcting(self) -> bool:
        return self._pulses.moving and self.owns_motion

    def give_way(self) -> None:
        """End the correction of a position error, e.g. because a move begins."""
        if self.correcting:
            self._pulses.kill()

    def leave_zero(self) -> None:
        """Record the start of a move, unless a move is in progress."""
        if self.ended is not None:
            self.ended, self._began = None, self.encoder.count
            self.reference = self._pulses.position, self._began

    def define(self, position: int) -> None:
        """Set actual and desired position to `position` encoder pulses; the motor does not move."""
        self.desired = self.encoder.count
        self.zero = self.desired - position
