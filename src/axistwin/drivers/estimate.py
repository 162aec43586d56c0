"""Estimate the position between two exact readings, from the commanded move."""

from dataclasses import dataclass
from math import sqrt


@dataclass(frozen=True)
class Trapezoid:
    """A move with constant acceleration and deceleration; `distance` is None until a stop ends it."""

    velocity: float
    acceleration: float
    distance: float | None = None

    def position(self, seconds: float) -> float:
        """Return the distance moved after this time."""
        speed, rate = self.velocity, self.acceleration
        if self.distance is not None:
            speed = min(speed, sqrt(self.distance * rate))
        ramp = speed / rate
        if seconds < ramp:
            return rate * seconds * seconds / 2
        cruise = speed * ramp / 2 + speed * (seconds - ramp)
        if self.distance is None:
            return cruise
        left = 2 * ramp + (self.distance - speed * ramp) / speed - seconds if speed else 0.0
        if left <= 0:
            return self.distance
        return self.distance - rate * left * left / 2 if left < ramp else cruise
