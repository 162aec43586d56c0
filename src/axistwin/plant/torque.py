"""The torque-speed curve of a stepper motor, and the steps that the motor loses beyond the curve.

If the required torque exceeds the curve at the present rate, the rotor falls out of step and stops.  It falls into step
again when the rate is back within `pull_in` and the torque suffices.  The rotor's equilibria are one tooth apart, so it
loses a whole number of teeth.
"""

from bisect import bisect_left
from collections.abc import Callable
from dataclasses import dataclass
from math import inf, pi

from axistwin.core.units import S
from axistwin.sim.motion.profile import Profile


@dataclass(frozen=True)
class Load:
    """The load on the shaft: friction `torque` in N·m against the motion, `inertia` in kg·m²."""

    torque: float = 0.0
    inertia: float = 0.0

    def __post_init__(self) -> None:
        if not (0 <= self.torque < inf and 0 <= self.inertia < inf):
            raise ValueError("invalid load: expected a friction torque of 0 or more, and an inertia of 0 or more")


@dataclass(frozen=True)
class StepperMotor:
    """A stepper motor's data sheet.

    `torque`: (pulses/s, N·m) points of the pull-out curve, linear between them, zero beyond the last. `pull_in`: the
    highest rate in pulses/s at which a rotor at rest falls into step.  `inertia` of the rotor in kg·m².
    """

    torque: tuple[tuple[float, float], ...]
    pull_in: float = 1000.0
    inertia: float = 0.0
    pulses_per_rev: int = 400
    rotor_teeth: int = 50

    def __post_init__(self) -> None:
        rates = [rate for rate, _ in self.torque]
        if not rates or rates != sorted(set(rates)):
            raise ValueError("invalid torque curve: expected pairs (pulses/s, N·m) with increasing pulse rates")
        if not all(0 <= torque < inf for _, torque in self.torque):
            raise ValueError("invalid torque curve: expected torques of 0 N·m or more")
        if not 0 <= self.inertia < inf:
            raise ValueError(
                f"invalid inertia={self.inertia!r} of the motor: expected 0 kg·m² or more, e.g. inertia=0.00001"
            )
        if not self.pull_in >= 0:
            raise ValueError(
                f"invalid pull_in={self.pull_in!r} of the motor: expected 0 pulses/s or more, e.g. pull_in=1000"
            )
        if self.pulses_per_rev <= 0 or self.rotor_teeth <= 0:
            raise ValueError(
                "invalid motor: expected pulses_per_rev and rotor_teeth above 0, "
                "e.g. pulses_per_rev=400 and rotor_teeth=50"
            )

    @property
    def pulses_per_tooth(self) -> int:
        return max(1, self.pulses_per_rev // self.rotor_teeth)

    def torque_at(self, rate: float) -> float:
        """Return the pull-out torque in N·m at a rate in pulses/s."""
        j = bisect_left(self.torque, rate, key=lambda point: point[0])
        if j == len(self.torque):
            return 0.0
        if j == 0:
            return self.torque[0][1]
        (low, at_low), (high, at_high) = self.torque[j - 1], self.torque[j]
        return at_low + (at_high - at_low) * (rate - low) / (high - low)

    def to_radians(self, pulses: float) -> float:
        return pulses * 2 * pi / self.pulses_per_rev


@dataclass
class Slip:
    """A loss of steps: the rotor stops at pulse `first` and falls into step at pulse `last`; None: not in this move."""

    first: int
    last: int | None = None


def slips(
    motor: StepperMotor, needed: Callable[[float], float], profile: Profile, elapsed_ns: int, out_of_step: bool
) -> list[Slip]:
    """Return slips from `elapsed_ns` on; `needed(acceleration)`: torque in N·m at pulses/s²."""
    found: list[Slip] = [Slip(profile.pulses_by(elapsed_ns))] if out_of_step else []
    before = profile.before
    for j, segment in enumerate(profile.segments):
        begins_ns = profile.starts[j] * S // profile.ticks
        ends_ns = profile.starts[j + 1] * S // profile.ticks if j + 1 < len(profile.starts) else None
        from_standstill = j == 0 and not before
        acceleration = 0.0
        if not from_standstill and segment.seconds:
            acceleration = float((segment.rate - before) / segment.seconds)
        before = segment.rate
        if ends_ns is not None and ends_ns <= elapsed_ns:
            continue
        pulse = profile.pulses_by(max(begins_ns, elapsed_ns))
        holds = needed(acceleration) <= motor.torque_at(float(segment.rate))
        catches = holds and segment.rate <= motor.pull_in
        if out_of_step and catches:
            found[-1].last, out_of_step = pulse, False
        elif not out_of_step and not (catches if from_standstill else holds):
            found.append(Slip(pulse))
            out_of_step = True
    return found


def lost_pulses(found: list[Slip], pulses: int, over: bool, per_tooth: int) -> int:
    """Return the number of pulses that the rotor lags after `pulses` pulses of the move."""
    lost = 0
    for slip in found:
        if pulses <= slip.first:
            break
        if slip.last is None or pulses < slip.last:
            standing = pulses - slip.first
            return lost + (whole_teeth(standing, per_tooth) if over else standing)
        lost += whole_teeth(slip.last - slip.first, per_tooth)
    return lost


def whole_teeth(pulses: int, per_tooth: int) -> int:
    """Return a number of pulses, 0 or more, rounded to whole teeth."""
    return (2 * pulses + per_tooth) // (2 * per_tooth) * per_tooth
