"""Motor and servo law against the reference, bit by bit; `test_kernel_reference.py` does it compiled too."""

from dataclasses import replace
from random import Random

import pytest

from axistwin.controllers.smartmotor.kernel import physics as machine
from axistwin.controllers.smartmotor.kernel import state
from axistwin.plant.servo import SERVO_MOTORS, ServoLoad

from .reference.machine import ON, OPEN, SHORTED, ReferenceMachine, ReferenceServo
from .rig import Rig, tune

LAW = state.PID_RATE, state.AMPS, state.DIRECTION


class Pair:
    """A motor and its reference with the same inputs."""

    def __init__(self, seed):
        self.random = random = Random(seed)
        load = ServoLoad(
            inertia_kg_m2=random.choice((0.0, random.uniform(0, 1e-4))),
            coulomb_friction_nm=random.choice((0.0, random.uniform(0, 0.1))),
            viscous_friction_nm_s=random.choice((0.0, random.uniform(0, 1e-3))),
            gravity_torque_nm=random.choice((0.0, random.uniform(-0.2, 0.2))),
        )
        motor = replace(
            random.choice(list(SERVO_MOTORS.values())),
            winding_time_constant_s=random.uniform(0.01, 1),
            housing_time_constant_s=random.uniform(0.05, 2),
            winding_inductance_h=random.choice((0.0, random.uniform(1e-4, 5e-3))),
        )
        self.rig = Rig(motor, load)
        self.machine, self.law = ReferenceMachine(motor, load), ReferenceServo(motor.tuning)
        self.drive, self.mode = ON, state.M_POSITION

    def change(self):
        i, f, random = self.rig.i, self.rig.f, self.random
        self.drive = i[state.DRIVE] = random.choice((OPEN, SHORTED, ON, ON, ON, ON))
        self.mode = i[state.MODE] = random.choice((state.M_TORQUE, state.M_POSITION, state.M_VELOCITY))
        i[state.BRAKE] = self.machine.brake = random.random() < 0.1
        self.machine.jammed = random.random() < 0.1
        machine.set_jam(f, self.machine.jammed)
        self.machine.torque_nm = random.choice((0.0, random.uniform(-2, 2)))
        machine.set_torque(f, self.machine.torque_nm)
        self.machine.ambient = f[machine.AMBIENT] = random.uniform(-20, 90)
        i[state.T], i[state.AMPS] = random.randint(-1023, 1023), random.choice((1023, random.randint(0, 1023)))
        i[state.PID_RATE], i[state.TH], i[state.THD] = random.choice((1, 1, 2, 4, 8)), 70, random.randint(1, 500)
        i[state.DIRECTION], i[state.ORIGIN] = random.choice((-1, 1)), random.randint(-(2**31), 2**31)
        i[state.VELOCITY] = random.choice((0, random.randint(-(2**22), 2**22)))
        i[state.COMMANDED] = (random.randint(-900, 900) + i[state.DIRECTION] * i[state.SHAFT] + i[state.ORIGIN]) << 16
        self.law.rate, self.law.amps, self.law.direction = (int(i[slot]) for slot in LAW)
        if random.random() < 0.3:
            self.law.tuning = tuple(random.choice((0, 1, random.randint(0, 65535))) for _ in range(8))
            tune(i, self.law.tuning)

    def sample(self):
        """Compute one sample of both, with a moving trajectory; return their overloads."""
        i, law, reference = self.rig.i, self.law, self.machine
        i[state.COMMANDED] += i[state.VELOCITY]
        protests = self.rig.sample()
        reference.turn(self.drive, law.pwm)
        if self.drive != ON:
            law.off()
        elif self.mode == state.M_TORQUE:
            law.torque(int(i[state.T]))
        else:
            position = int(i[state.DIRECTION]) * reference.shaft + int(i[state.ORIGIN])
            law.follow(int(i[state.SAMPLE]) - 1, (int(i[state.COMMANDED]) >> 16) - position, int(i[state.VELOCITY]))
        return protests, reference.temperatures.overloaded(int(i[state.TH]), int(i[state.THD]))

    def compare(self):
        i, f, reference, heat = self.rig.i, self.rig.f, self.machine, self.machine.temperatures
        assert f[machine.AMPS_NOW] == reference.amps
        ours = [f[slot] for slot in (machine.SPEED, machine.FRACTION, machine.WINDING_C, machine.HOUSING_C)]
        assert [*ours, f[machine.MEAN_SQUARE]] == [
            reference.speed, reference.fraction, heat.winding, heat.housing, heat.mean_square,
        ]  # fmt: skip
        assert (i[state.SHAFT], i[state.PWM]) == (reference.shaft, self.law.pwm)
        assert (i[state.INTEGRAL], i[state.DIFFERENCE]) == (self.law.integral, self.law.difference)
        assert (i[state.CURRENT], i[state.BA]) == (reference.current.filtered // 16, reference.over_current)
        assert (i[state.TEMP], i[state.OVERLOAD], i[state.HOT]) == (heat.housing // 1, heat.overload, heat.hot)


@pytest.mark.parametrize("seed", range(12))
def test_random_runs_agree_to_the_bit(seed):
    pair = Pair(seed)
    for _ in range(25):
        for _ in range(pair.random.randint(1, 300)):
            protests, reference_protests = pair.sample()
            assert protests == reference_protests
            pair.compare()
        pair.change()
