"""Independent reference of the trajectory: every move by its definition, in 1/65536 count."""

from dataclasses import dataclass, field
from fractions import Fraction
from math import floor

COUNT = 65536


def braking(speed, rate):
    """Return the stopping distance from `speed`, if each further sample reduces the speed by `rate`."""
    steps, rest = divmod(speed, rate)
    return steps * (steps + 1) // 2 * rate + (steps + 1) * rest if speed > 0 else 0


def fastest(limit, distance, rate):
    """Find by bisection the largest speed up to `limit` from which the motor can stop within `distance`."""
    low, high = 0, limit
    while low < high:
        middle = (low + high + 1) // 2
        if braking(middle, rate) <= distance:
            low = middle
        else:
            high = middle - 1
    return low


def nearer(value, wanted, rate):
    """Step from a value towards another by at most `rate`."""
    return value + max(-rate, min(rate, wanted - value))


@dataclass
class Run:
    """An encoder run at constant speed from `base`: `ahead + done · rate` edges, at its end `counts`."""

    base: int = 0
    way: int = 1
    rate: Fraction = Fraction(0)
    ahead: Fraction = Fraction(0)
    end: int = 0
    left: int = 0
    done: int = 0

    @property
    def turned(self):
        return self.ahead + self.done * self.rate


@dataclass
class Master:
    """The external encoder on pins A and B, and the counter CTR."""

    edges: int = 0
    resolution: int = 4
    seen: int = 0
    ctr: int = 0
    by_hand: int = 0
    """Edges that have come through the pins themselves."""
    shown: str = ""
    """Pins that show the encoder, of "AB"."""
    steps: bool = False
    up: bool = False
    run: Run = field(default_factory=Run)

    def turn(self, motor):
        """Turn for one sample; pins A and B follow."""
        before = self.edges
        self._turn()
        if self.shown and self.edges != before:
            self.up = self.edges > before
        for pin in self.shown:
            motor.pins[pin] = self.level(pin)
            motor.values[f"U{pin}A"] = 1023 * motor.pins[pin]

    def level(self, pin):
        """A leads B by a quarter of a period when the encoder turns forwards; both are high at 0."""
        if self.steps:
            return pin == "B" and self.up
        return (self.edges - self.by_hand) % 4 in ((0, 3) if pin == "A" else (0, 1))

    def _turn(self):
        run = self.run
        if run.left:
            run.left, run.done = run.left - 1, run.done + 1
            self.edges = run.base + run.way * floor(run.turned) if run.left else run.end

    def counted(self):
        """Update CTR; return its change since the last call."""
        counts = floor(Fraction(self.edges * self.resolution, 4))
        moved, self.seen = counts - self.seen, counts
        self.ctr = (self.ctr + moved + 2**31) % 2**32 - 2**31
        return moved


@dataclass
class Trajectory:
    """Commanded position and velocity, with `mode` and its parameters."""

    mode: str = "off"
    place: int = 0
    velocity: int = 0
    target: int = 0
    """In counts; of a ratio the divisor."""
    top: int = 0
    rate: int = 0
    factor: int = 0
    """Of a ratio the multiplier."""
    owed: Fraction = Fraction(0)
    """Counts that a ratio has not turned into motion yet."""

    def move(self, motor, moved):
        """Compute one sample; return the reason to stop."""
        actions = {
            "position": self._position, "velocity": self._velocity, "stop": self._stop, "follow": self._follow,
            "step": self._follow, "ratio": self._ratio, "step ratio": self._ratio, "cam": self._cam,
            "host": self._host, "hold": lambda motor, moved: None,
        }  # fmt: skip
        return actions.get(self.mode, self._nothing)(motor, moved)

    def _nothing(self, motor, moved):
        self.place, self.velocity = motor.position * COUNT, 0

    def _position(self, motor, moved):
        remaining = self.target * COUNT - self.place
        way = 1 if remaining >= 0 else -1
        self.velocity = way * self._approach(way * self.velocity, abs(remaining))
        self.place += self.velocity
        if self.place == self.target * COUNT and abs(self.velocity) <= self.rate:
            self.velocity = motor.flags["Bt"] = 0

    def _approach(self, speed, distance):
        """Return the speed towards a target at this distance."""
        if self.rate == 0:
            return speed
        slowest = speed - self.rate
        limit = max(slowest, self.top) if speed > self.top else min(speed + self.rate, self.top)
        return limit if limit <= 0 else max(slowest, fastest(limit, distance, self.rate))

    def _velocity(self, motor, moved):
        self.velocity = nearer(self.velocity, self.top, self.rate)
        self.place += self.velocity

    def _stop(self, motor, moved):
        self.velocity = nearer(self.velocity, 0, self.rate)
        self.place += self.velocity
        if self.velocity == 0:
            self.mode, motor.flags["Bt"] = "hold", 0

    def _follow(self, motor, moved):
        self.velocity = moved * COUNT
        self.place += self.velocity

    def _ratio(self, motor, moved):
        self.owed += moved * Fraction(self.factor, self.target)
        self._follow(motor, floor(self.owed))
        self.owed -= floor(self.owed)

    def _cam(self, motor, moved):
        motor.cam.sample(motor, moved)

    def _host(self, motor, moved):
        return motor.host.sample(self)

    def wrap(self, motor):
        """Continue a position beyond 2^31 counts at -2^31."""
        inside = (self.place + 2**47) % 2**48 - 2**47
        if inside != self.place:
            turn = (inside - self.place) // COUNT
            self.place = inside
            motor.origin += turn
            motor.cam.origin += turn
            if self.mode == "position":
                self.target += turn
            motor.flags["Bw"] = 1


@dataclass
class Host:
    """Host mode: (position, clock) points; the first is the last point reached."""

    points: list = field(default_factory=list)
    passed: int = 0
    started: bool = False
    left: int = 0
    clock: int = 0

    def sample(self, trajectory):
        if not self.started and self.points:
            self.started = True
            trajectory.place, self.clock = self.points[0][0] * COUNT, self.points[0][1]
        if not self.left:
            if len(self.points) < 2:
                return "underflow"
            (here, now), (there, then) = self.points[:2]
            if now == then:
                return "exit"
            trajectory.velocity, self.left = floor(Fraction((there - here) * COUNT, then - now)), then - now
        return self._go_on(trajectory)

    def _go_on(self, trajectory):
        trajectory.place += trajectory.velocity
        self.left -= 1
        self.clock += 1
        if self.left:
            return None
        del self.points[0]
        self.passed += 1
        trajectory.place = self.points[0][0] * COUNT
        if len(self.points) == 1:
            return "last"
        return "exit" if self.points[0][1] == self.points[1][1] else None
