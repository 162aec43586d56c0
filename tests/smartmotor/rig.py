"""The kernel without a bench: a motor, and a processor with a program, in plain Python or compiled."""

from array import array
from math import pi

import numpy as np

from axistwin.controllers.smartmotor.kernel import (
    FETCH,
    HELD,
    STACK,
    TRAP,
    jit,
    machine,
    next_velocity,
    servo,
    servo_law,
    state,
    statement,
)
from axistwin.controllers.smartmotor.language import Program
from axistwin.plant import ServoLoad

from .talking import SAMPLE_S

FUNCTIONS = servo.rotate, servo_law.control, servo.overloaded, servo.resting, servo.rest


def tune(i, tuning):
    """Put KP KI KD KL KS KV KA KG in force."""
    for slot, value in enumerate(tuning, state.TUNING):
        i[slot] = value


class Rig:
    """A motor in position mode with its drive on; `compiled` compiles its functions with Numba."""

    def __init__(self, motor, load=None, *, compiled=False):
        self.motor, self.load = motor, load or ServoLoad()
        self.i, self.f = [0] * state.INTS, [0.0] * machine.FLOATS
        for slot, value in ((state.DIRECTION, 1), (state.PID_RATE, 1), (state.AMPS, 1023)):
            self.i[slot] = value
        self.i[state.TH], self.i[state.THD] = 70, 12_000
        self.i[state.DRIVE], self.i[state.MODE] = state.DRIVE_ON, state.M_POSITION
        machine.fit(self.i, self.f, motor, self.load)
        if motor is not None:
            tune(self.i, motor.tuning)
        functions = FUNCTIONS
        if compiled:
            self.i, self.f = np.array(self.i), np.array(self.f)
            functions = [jit.best(function) for function in FUNCTIONS]
        self._rotate, self._control, self._overloaded, self._resting, self._rest = functions

    def sample(self):
        """Compute shaft, servo law and protection for a sample; return True in an overload."""
        self.turn(1)
        self._control(self.i)
        self.i[state.SAMPLE] += 1
        return bool(self._overloaded(self.i, self.f))

    def turn(self, samples):
        """Compute one sample of the shaft alone."""
        for _ in range(samples):
            self._rotate(self.i, self.f)

    def seconds(self, seconds):
        """Compute samples of the shaft alone; return their time."""
        samples = round(seconds / SAMPLE_S)
        self.turn(samples)
        return samples * SAMPLE_S

    def trapezoid(self, target, revs_per_s, revs_per_s2):
        """Move to the target; return the following errors until 0.5 s after the move, and the final position."""
        i, cpr, errors = self.i, self.motor.counts_per_rev, []
        max_velocity, rate = (int(x * cpr * 65536) for x in (revs_per_s * SAMPLE_S, revs_per_s2 * SAMPLE_S**2))
        end = None
        while end is None or len(errors) < end + 2035:
            self.sample()
            i[state.VELOCITY] = next_velocity(
                i[state.VELOCITY], (target << 16) - i[state.COMMANDED], max_velocity, rate
            )
            i[state.COMMANDED] += i[state.VELOCITY]
            errors.append(self.error)
            if end is None and i[state.COMMANDED] == target << 16 and not i[state.VELOCITY]:
                end = len(errors)
        return errors, end

    def until_overload(self, limit):
        """Return the seconds until the overload; fail after `limit` samples."""
        return next(n * SAMPLE_S for n in range(1, limit + 1) if self.sample())

    def rest(self, samples):
        """Compute many samples of a motor at rest in one step."""
        self._rest(self.i, self.f, samples)

    @property
    def resting(self):
        return bool(self._resting(self.i, self.f))

    @property
    def error(self):
        return servo_law.following_error(self.i)

    @property
    def rad_per_s(self):
        return self.f[machine.SPEED] / SAMPLE_S / self.motor.counts_per_rev * 2 * pi

    @property
    def radians(self):
        return (self.i[state.SHAFT] + self.f[machine.FRACTION]) / self.motor.counts_per_rev * 2 * pi


class Processor:
    """A processor with one statement per sample; statements for Python are only listed in `performed`."""

    def __init__(self, text, *, compiled=False, overlay=True):
        self.program = Program.compile(text)
        self.i, self.v = array("q", [0] * state.INTS), array("q", [0] * state.VARIABLES)
        self.stack, self.code = array("q", [0] * STACK), array("q", self.program.code)
        self.i[state.DIRECTION] = self.i[state.PID_RATE] = 1
        self.i[state.ARRAY_BASE] = state.DOUBLES if overlay else state.ALONE
        self.i[state.PROGRAM] = state.RUNNING
        self.statement = jit.best(statement) if compiled else statement
        self.carried_out = []
        """The text of each statement in the order of the samples; None: a sample without a statement."""
        self.performed = []
        self.fetched = lambda text: 0

    def run(self, samples=1000):
        """Run `samples` samples, or until the program ends."""
        for _ in range(samples):
            if self.i[state.PROGRAM] != state.RUNNING:
                break
            self.carried_out.append(self._sample())
            self.i[state.SAMPLE] += 1
        return self

    def _sample(self):
        if self.i[state.SAMPLE] + 1 < self.i[state.WAIT_UNTIL]:
            return None
        result = self.statement(self.i, self.v, self.stack, self.code)
        if result == FETCH:
            text = self.program.statements[self.i[state.STATEMENT]].text
            self.v[state.HIDDEN] = self.fetched(text)
            result = self.statement(self.i, self.v, self.stack, self.code)
        if result == HELD:
            return None
        number = self.i[state.STATEMENT]
        text = self.program.statements[number].text if number < len(self.program.statements) else "(end)"
        if result == TRAP:
            self.performed.append(text)
        return text

    def __getitem__(self, letters):
        """Return a variable: a…z, aa…zz, aaa…zzz."""
        return self.v[26 * (len(letters) - 1) + ord(letters[0]) - ord("a")]
