"""Chapters Speed, Start/stop speed and Acceleration rate: programmed and actual values."""

from fractions import Fraction
from functools import lru_cache
from typing import NamedTuple

from axistwin.controllers.digiplan.rules import TOO_FAST
from axistwin.controllers.digiplan.step import Fault, Parameters, Problem, Step
from axistwin.sim.motion.ramp import Ramp


class SpeedRange(NamedTuple):
    """One of the four speed ranges of the interface, with values in steps/s."""

    maximum: int
    resolution: Fraction
    increment: int


RANGES = {
    1: SpeedRange(25_000, Fraction(25, 4), 100),
    2: SpeedRange(50_000, Fraction(25, 2), 200),
    3: SpeedRange(100_000, Fraction(25), 400),
    4: SpeedRange(4_000, Fraction(1), 16),
}


def actual_speed(speed_range: int, speed: int) -> Fraction:
    """Return the speed rounded to the range's resolution, never to 0.  In range 1, 503 becomes 500 steps/s."""
    resolution = RANGES[speed_range].resolution
    return resolution * max(1, round(speed / resolution))


def actual_start_stop(speed_range: int, hundreds: int) -> Fraction:
    """Return the start/stop speed as a multiple of the ramp's increment.  In range 4, 300 become 288 steps/s."""
    increment = RANGES[speed_range].increment
    return Fraction(increment * max(1, hundreds * 100 // increment))


def ramp(parameters: Parameters) -> Ramp:
    """Return step rates that rise by a constant increment; each lasts `increment / acceleration` seconds."""
    return _ramp(parameters.speed_range, parameters.speed, parameters.start_stop, parameters.acceleration)


@lru_cache(maxsize=256)
def _ramp(speed_range: int, speed: int, start_stop: int, acceleration: int) -> Ramp:
    increment = RANGES[speed_range].increment
    return Ramp(
        start=actual_start_stop(speed_range, start_stop), top=actual_speed(speed_range, speed),
        increment=Fraction(increment), interval=Fraction(increment, acceleration * 1000),
    )  # fmt: skip


def too_fast(parameters: Parameters) -> Problem | None:
    """Return a problem if the speed is above the maximum of the speed range, otherwise None."""
    maximum = RANGES[parameters.speed_range].maximum
    if parameters.speed <= maximum:
        return None
    message = f"speed {parameters.speed} is above {maximum} steps/s, the maximum of range {parameters.speed_range}"
    return Problem(TOO_FAST, Fault.RANGE, 0, message, "Speed", ("speed", "speed_range"))


def setting(name: str, step: Step, value: int) -> None:
    """Commands > < ^ @ D: keep a parameter until it is overwritten.

    `>` speed range 1 to 4; `<` start/stop speed 1 to 40 x 100 steps/s; `^` acceleration 1 to 500 x 1000 steps/s²;
    `@` speed 1 to 99,999 steps/s, at most the range's maximum; `D` inter-character delay 0 to 25 x 10 ms.
    After > < ^ a new ramp is calculated, which takes up to 1 second.
    Chapters Speed to Acceleration rate, Inter-character delay.
    """
    step.settings[name] = value
