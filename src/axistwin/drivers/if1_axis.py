"""An axis of an IF1 or IF2, and what the driver knows about the controller's moves."""

from dataclasses import dataclass, field
from math import sqrt
from typing import TYPE_CHECKING

from axistwin.drivers.axis import Status
from axistwin.drivers.core import AxisCore
from axistwin.drivers.errors import BusyError, RefusedError
from axistwin.drivers.steps import Procedure

if TYPE_CHECKING:
    from axistwin.drivers.if1 import IF1

MAX_DISTANCE = 999_999_999
MAX_SPEED = {1: 25_000, 2: 50_000, 3: 100_000, 4: 4_000}
I_INPUTS = {1: 8, 2: 64, 3: 128}
"""Bits of the inputs 1 to 3 in the answer to I."""


START_POLLS = 5


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


@dataclass
class Move:
    """A commanded motion of one or more axes."""

    signs: dict[str, int]
    """The direction of each axis."""
    distance: int | None
    """Number of steps; None for a run that lasts until `stop`."""
    profile: Trapezoid
    begun: float
    counted: int
    """The step count (N) before the move."""
    seen: int = 0
    """Number of polls before the motion began; START_POLLS after the motion has begun."""
    made: float = 0.0
    """Largest estimate so far."""
    homing: bool = False
    sequence: bool = False
    stopped: bool = False
    sure: bool = False
    """False until the controller has confirmed the message that begins the move."""


@dataclass
class Known:
    """Knowledge of the driver about the controller: positions, inputs, and the faults since the last `clear_faults`."""

    positions: dict[str, int]
    lost: dict[str, str] = field(default_factory=dict)
    counted: int = 0
    inputs: int = 0
    latched: int = 0
    communication: int = 0


class IF1Axis(AxisCore):
    """An axis of an IF1."""

    def __init__(self, core: "IF1", name: str) -> None:
        super().__init__(name, velocity=1000.0, acceleration=10_000.0, exact=False)
        self._if1 = core
        self.max_velocity = float(MAX_SPEED[core.speed_range])
        self.max_position = MAX_DISTANCE

    def move_to(self, target: int) -> Procedure[None]:
        yield from self._at_rest()
        yield from self._move_to(target)

    def _at_rest(self) -> Procedure[None]:
        if (yield from self._if1._poll()):
            raise BusyError(
                "the IF1 is moving, so no other move can begin: wait for the end of the motion, or stop the axes"
            )

    def _move_to(self, target: int) -> Procedure[None]:
        core = self._if1
        distance, speed = target - core.position_of(self.name), core.speed(self.velocity)
        if abs(distance) > MAX_DISTANCE:
            raise RefusedError(f"the distance of {distance} steps is too long: expected at most 999999999 steps")
        if distance:
            yield from core._set_ramp(self.acceleration)
            sign = 1 if distance > 0 else -1
            yield from core.begin({self.name: sign}, abs(distance), speed, f"{self.name}{distance:+d}@{speed}$")
        else:
            self._aim(target, faults=core._faults())
        self.setpoint = target

    def move_by(self, distance: int) -> Procedure[None]:
        """Begin a relative move: the new target is the present position plus `distance`."""
        yield from self._at_rest()
        yield from self._move_to(self._if1.position_of(self.name) + distance)

    def move_at(self, velocity: float) -> Procedure[None]:
        if not velocity:
            yield from self.stop()
            return
        core, speed = self._if1, self._if1.speed(abs(velocity))
        yield from core._ready_for({1 if velocity > 0 else -1})
        yield from core._set_ramp(self.acceleration)
        sign = "+" if velocity > 0 else "-"
        yield from core.begin({self.name: 1 if velocity > 0 else -1}, None, speed, f"{self.name}{sign}@{speed}G$")

    def stop(self) -> Procedure[None]:
        """Decelerate all axes to a standstill."""
        yield from self._if1.stop()

    def abort(self) -> Procedure[None]:
        """Decelerate all axes, as `stop` does, because an IF1 has no faster stop."""
        yield from self._if1.stop()

    def home(self, direction: int) -> Procedure[None]:
        """Move the axis at the start/stop speed to the home switch, and set the axis position to 0."""
        core = self._if1
        if core.home_input is None:
            raise RefusedError("no home switch is configured: expected the option home_input, e.g. home_input=1")
        yield from core._ready_for({direction})
        if not core._state.inputs & I_INPUTS[core.home_input]:
            raise RefusedError(f"home input {core.home_input} is already high: move the axis away from the home switch")
        sign = "+" if direction > 0 else "-"
        text = f":{self.name}{sign}@{core.start_stop}G:H{core.home_input}A:$"
        move = yield from core.begin({self.name: direction}, None, core.start_stop, text)
        move.homing = self._seeking = True

    def status(self) -> Procedure[Status]:
        return (yield from self._if1.status_of(self))

    def set_position(self, position: int) -> Procedure[None]:
        """Set the present position of the axis to a new value without a move; all axes must be at rest."""
        yield from self._if1.set_position(self.name, position)

    def clear_faults(self) -> Procedure[None]:
        yield from self._if1.clear_faults()
