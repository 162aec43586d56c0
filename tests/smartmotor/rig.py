"""A motor on a test rig: the arrays of the processor with a data sheet, and the sampled functions plain or compiled."""

from math import pi

from axistwin.controllers.smartmotor.kernel import machine, servo, servo_law, state
from axistwin.controllers.smartmotor.kernel.trajectory import approach
from axistwin.plant.servo import ServoLoad

SAMPLE_S = 245_760e-9
FUNCTIONS = servo.rotate, servo_law.control, servo.overloaded, servo.resting, servo.rest


class Rig:
    """A motor in position mode with its drive on; `compiled` for functions compiled with Numba."""

    def __init__(self, motor, load=None, *, compiled=False):
        self.motor, self.load = motor, load or ServoLoad()
        self.i, self.f = [0] * state.INTS, [0.0] * machine.FLOATS
        for slot, value in ((state.DIRECTION, 1), (state.PID_RATE, 1), (state.AMPS, 1023)):
            self.i[slot] = value
        self.i[state.TH], self.i[state.THD] = 70, 12_000
        self.i[state.DRIVE], self.i[state.MODE] = state.DRIVE_ON, state.M_POSITION
        machine.fit(self.i, self.f, motor, self.load)
        if motor is not None:
            machine.tune(self.i, motor.tuning)
        functions = _compiled(self) if compiled else FUNCTIONS
        self._rotate, self._control, self._overloaded, self._resting, self._rest = functions

    def sample(self):
        """Shaft, servo law, protection; true if it protests."""
        self.turn(1)
        self._control(self.i)
        self.i[state.SAMPLE] += 1
        return bool(self._overloaded(self.i, self.f))

    def turn(self, samples):
        """The shaft alone."""
        for _ in range(samples):
            self._rotate(self.i, self.f)

    def seconds(self, seconds):
        """The shaft alone, for so long; returns the time it has really been."""
        samples = round(seconds / SAMPLE_S)
        self.turn(samples)
        return samples * SAMPLE_S

    def trapezoid(self, target, revs_per_s, revs_per_s2):
        """Move the trajectory there; the following error of each sample, and 0.5 s beyond."""
        i, cpr, errors = self.i, self.motor.counts_per_rev, []
        top, rate = (int(x * cpr * 65536) for x in (revs_per_s * SAMPLE_S, revs_per_s2 * SAMPLE_S**2))
        end = None
        while end is None or len(errors) < end + 2035:
            self.sample()
            i[state.VELOCITY] = approach(i[state.VELOCITY], (target << 16) - i[state.COMMANDED], top, rate)
            i[state.COMMANDED] += i[state.VELOCITY]
            errors.append(self.error)
            if end is None and i[state.COMMANDED] == target << 16 and not i[state.VELOCITY]:
                end = len(errors)
        return errors, end

    def until_protest(self, most):
        """Seconds until it is overheated."""
        for n in range(1, most + 1):
            if self.sample():
                return n * SAMPLE_S
        raise AssertionError("it has not been overheated")

    def rest(self, samples):
        """Let it rest, if it does."""
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


def _compiled(rig):
    import numpy as np

    from axistwin.controllers.smartmotor.kernel import jit

    rig.i, rig.f = np.array(rig.i), np.array(rig.f)
    return [jit.best(function) for function in FUNCTIONS]
