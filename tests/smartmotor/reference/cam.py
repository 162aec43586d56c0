"""Independent reference of mode cam (chapter 9): the place in the cycle, and the table's position there."""

from dataclasses import dataclass, field, replace
from fractions import Fraction
from math import floor

RELATIVE, MODULO = 16, 128


@dataclass(frozen=True)
class Parameters:
    """Parameters of a cycle: encoder counts, highest index, MCn, D, and F."""

    base: int = 1
    size: int = 1
    factor: int = 1
    dwell: int = 0
    word: int = 0

    @property
    def cycle(self):
        return self.base + self.dwell


@dataclass
class Cam:
    """The cycle in force, the parameters that MCn has prepared, and the place in the cycle."""

    table_factor: bool = False
    """MCn multiplies the table, not the encoder's counts."""
    now: Parameters = field(default_factory=Parameters)
    prepared: Parameters = field(default_factory=Parameters)
    pending: bool = False
    origin: int = 0
    phase: int = 0
    index: int = 0

    def sample(self, motor, moved):
        trajectory = motor.trajectory
        before = trajectory.place
        shift = self.turn(motor, moved) if moved else 0
        trajectory.place = (self.origin + self.position(motor)) * 65536
        trajectory.velocity = trajectory.place - before + shift * 65536

    def entry(self, motor, n, parameters=None):
        """Return aw[n]."""
        return motor.memory.element("aw", n) * ((parameters or self.now).factor if self.table_factor else 1)

    def position(self, motor):
        """Return the position: linear between two points, in the dwell the last point."""
        now = self.now
        if self.phase >= now.base:
            self.index = now.size
            return self.entry(motor, now.size)
        along = Fraction(self.phase * now.size, now.base)
        self.index = n = floor(along)
        closes = not now.word and n + 1 == now.size  # F=0: the last point is the next cycle's first
        here, there = self.entry(motor, n), self.entry(motor, 0 if closes else n + 1)
        return here + floor((there - here) * (along - n))

    def turn(self, motor, moved):
        """Turn the encoder; return the shift of the coordinates (F=128)."""
        step = moved * (1 if self.table_factor else self.now.factor)
        place = self.phase + step
        self.phase = place % self.now.cycle
        if Fraction(abs(step), self.now.base) >= Fraction(1, 4) or 0 <= place < self.now.cycle:
            return 0
        return self.forwards(motor) if place > 0 else self.backwards(motor, place)

    def forwards(self, motor):
        """Complete a cycle; the next cycle begins at the position where this one ended."""
        done, old = self.entry(motor, self.now.size), self.now
        self._take_over()
        return self._begin(motor, old.word, done)

    def backwards(self, motor, place):
        """Enter the end of the previous cycle."""
        old = self.now
        if self.pending:
            self._take_over()
            self.phase = max(0, place + self.now.cycle)
        return self._begin(motor, old.word, -self.entry(motor, self.now.size))

    def _take_over(self):
        """Take over the prepared parameters; the dwell is D counts with F=16 or F=128, otherwise 0 (9.5)."""
        if self.pending:
            word = self.prepared.word & (RELATIVE | MODULO)
            dwell = max(self.prepared.dwell, 0) if word else 0
            self.now, self.pending = replace(self.prepared, dwell=dwell, word=word), False

    def _begin(self, motor, word, way):
        shift = 0
        if word & MODULO:
            shift = self.origin + way
            motor.trajectory.place -= shift * 65536
            motor.origin -= shift
            self.origin = 0
            motor.master.ctr = self.phase // (1 if self.table_factor else self.now.factor)
        elif word & RELATIVE:
            self.origin += way
        if not self.now.word:
            self.origin = 0
        return shift

    def start(self):
        self.pending = True
        self._take_over()
