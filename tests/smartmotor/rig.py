"""The kernel without a bench: a motor, a processor with a program, and both together, in plain Python or compiled."""

from array import array
from math import pi

from axistwin.controllers.smartmotor.kernel import jit, servo, servo_law, state
from axistwin.controllers.smartmotor.kernel import physics as machine
from axistwin.controllers.smartmotor.kernel.interpreter import FETCH, HELD, STACK, TRAP, statement
from axistwin.controllers.smartmotor.kernel.kernel import advance
from axistwin.controllers.smartmotor.kernel.trajectory import next_velocity
from axistwin.controllers.smartmotor.language.program import Program
from axistwin.plant.servo import ServoLoad

from .talking import SAMPLE_S


def tune(i, tuning):
    """Put KP KI KD KL KS KV KA KG in force."""
    for slot, value in enumerate(tuning, state.TUNING):
        i[slot] = value


SAMPLES = 4000
"""Largest number of samples of `Whole` in one call."""


class Rig:
    """A motor in position mode with its drive on."""

    def __init__(self, motor, load=None):
        self.motor, self.load = motor, load or ServoLoad()
        self.i, self.f = [0] * state.INTS, [0.0] * machine.FLOATS
        for slot, value in ((state.DIRECTION, 1), (state.PID_RATE, 1), (state.AMPS, 1023)):
            self.i[slot] = value
        self.i[state.TH], self.i[state.THD] = 70, 12_000
        self.i[state.DRIVE], self.i[state.MODE] = state.DRIVE_ON, state.M_POSITION
        machine.fit(self.i, self.f, motor, self.load)
        if motor is not None:
            tune(self.i, motor.tuning)

    def sample(self):
        """Compute shaft, servo law and protection for a sample; return True in an overload."""
        self.turn(1)
        servo_law.control(self.i)
        self.i[state.SAMPLE] += 1
        return bool(servo.overloaded(self.i, self.f))

    def turn(self, samples):
        """Compute one sample of the shaft alone."""
        for _ in range(samples):
            servo.rotate(self.i, self.f)

    def seconds(self, seconds):
        """Compute samples of the shaft alone; return their time."""
        samples = round(seconds / SAMPLE_S)
        self.turn(samples)
        return samples * SAMPLE_S

    def trapezoid(self, target, revs_per_s, revs_per_s2):
        """Move to the target; return the following errors until 0.3 s after the move, and the final position."""
        i, cpr, errors = self.i, self.motor.counts_per_rev, []
        max_velocity, rate = (int(x * cpr * 65536) for x in (revs_per_s * SAMPLE_S, revs_per_s2 * SAMPLE_S**2))
        end = None
        while end is None or len(errors) < end + 1200:
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
        servo.rest(self.i, self.f, samples)

    @property
    def resting(self):
        return bool(servo.resting(self.i, self.f))

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

    def __init__(self, text, *, overlay=True):
        self.program = Program.compile(text)
        self.i, self.v = array("q", [0] * state.INTS), array("q", [0] * state.VARIABLES)
        self.stack, self.code = array("q", [0] * STACK), array("q", self.program.code)
        self.i[state.DIRECTION] = self.i[state.PID_RATE] = 1
        self.i[state.ARRAY_BASE] = state.DOUBLES if overlay else state.ALONE
        self.i[state.PROGRAM] = state.RUNNING
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
        result = statement(self.i, self.v, self.stack, self.code)
        if result == FETCH:
            text = self.program.statements[self.i[state.STATEMENT]].text
            self.v[state.HIDDEN] = self.fetched(text)
            result = statement(self.i, self.v, self.stack, self.code)
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


class Whole:
    """The whole kernel, with the state of a rig and a program; `compiled`: as machine code."""

    def __init__(self, rig, text="END", *, compiled):
        code = Program.compile(text).code
        self.i, self.f = array("q", rig.i), array("d", rig.f)
        self.v = array("q", [0] * state.VARIABLES)
        self.i[state.PROGRAM], self.i[state.STATEMENTS_PER_SAMPLE], self.i[state.BUDGET] = state.RUNNING, 1, 1
        self.i[state.ARRAY_BASE] = state.DOUBLES
        self.i[state.E], self.i[state.WINDOW_LOW], self.i[state.WINDOW_HIGH] = 1000, -(2**40), 2**40
        self.i[state.COUNTS_PER_REV] = self.i[state.INDEX_HIGH] = 2000
        others = (array("q", [0] * size) for size in (STACK, 2, 1, SAMPLES, SAMPLES, 3))
        stack, ring, told, shaft, commanded, log = others
        arrays = self.i, self.v, self.f, stack, array("q", code), ring, told, shaft, commanded, log
        self._advance = jit.best(advance) if compiled else advance
        self._arrays = list(map(jit.view, arrays)) if compiled else arrays

    def run(self, samples):
        """Compute samples; return the reasons for which the kernel has stopped."""
        reasons = []
        while self.i[state.SAMPLE] < samples:
            reasons.append(self._advance(*self._arrays, samples - self.i[state.SAMPLE]))
        return reasons
