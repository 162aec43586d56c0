"""The kernel against a reference, bit by bit: random motors and programs, in plain Python and compiled.

One run of the reference serves both kernels, because it takes as long as both of them together.
"""

from dataclasses import replace
from fractions import Fraction

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from axistwin.controllers.smartmotor.kernel import interpreter, jit, state
from axistwin.plant.servo import SERVO_MOTORS, ServoLoad

from .reference import inventing
from .reference.bridge import CALLS, POINTS, REASONS, Kernel, shown
from .reference.cam import Cam, Parameters
from .reference.machine import ON, OPEN, SHORTED
from .reference.motor import FLAGS, ReferenceMotor
from .reference.program import Program
from .reference.trajectory import Run, Trajectory

CHANCE = st.randoms(use_true_random=True)
"""Of a seed that Hypothesis chooses and repeats: a failure is not shrunk, so that it need not know each number."""
THOROUGH = settings(
    max_examples=25,
    deadline=None,
    suppress_health_check=list(HealthCheck),
    phases=[Phase.explicit, Phase.reuse, Phase.generate],  # shrinking such a failure takes minutes and helps little
)
PARAMETERS = ["A", "V", "P", "MFMUL", "MFDIV", "BASE", "SIZE", "KP", "KI", "KD", "KL", "KS", "KV", "KA", "KG", "ADDR"]


def invented(random, text="END"):
    """Return a random motor, with random wiring."""
    data = random.choice([None, *SERVO_MOTORS.values()])
    if data:
        inductance = random.choice([0.0, 0.0, 7e-4])
        data = replace(data, winding_time_constant_s=0.05, housing_time_constant_s=0.2, winding_inductance_h=inductance)
    load = ServoLoad(coulomb_friction_nm=random.choice([0.0, 0.01]), inertia_kg_m2=random.choice([0.0, 1e-5]))
    motor = ReferenceMotor(Program(text), data, load, random.random() < 0.8, random.choice([1, 1, 2, 5]))
    motor.runner.left = motor.per_sample
    motor.values |= {name: random.choice([0, 1, -1, random.randint(-(2**31), 2**31 - 1)]) for name in PARAMETERS}
    motor.values |= {f"U{pin}A": random.randrange(1024) for pin in "ABCDEFG"} | {"OBSERVE_INDEX": random.randrange(2)}
    motor.sample_number, motor.clock_zero = random.choice([0, random.randrange(2**40)]), random.randrange(1000)
    motor.machine.shaft = random.randint(-5000, 5000)
    index = motor.index
    index.at, index.turn = random.randrange(2000), random.choice([2000, 4000])
    index.shaft, index.armed = motor.shaft, random.random() < 0.5
    index.below = (motor.shaft - index.at) // index.turn * index.turn + index.at
    motor.flags["Bx"] = int(index.below == motor.shaft)
    motor.cam.table_factor = random.random() < 0.3
    for name in inventing.NAMES:
        motor.memory[name] = random.choice([0, 1, 2, 3, -1, -7, -13, -100, random.randint(-(2**31), 2**31 - 1)])
    motor.trajectory.place = motor.position * 65536
    return motor


# External influences


def somebody_sets_flags(random, motor):
    for flag in random.sample(FLAGS, 4):
        if flag not in ("Bx", "Bt"):
            motor.flags[flag] = random.randrange(2)
    motor.stopping = random.random() < 0.3
    motor.plus.acknowledged, motor.minus.acknowledged = random.random() < 0.5, random.random() < 0.5


def pins_change(random, motor):
    for pin in random.sample("ABCDEFG", 3):
        motor.pins[pin] = random.random() < 0.5
    motor.plus.has_pin, motor.minus.has_pin = random.random() < 0.3, random.random() < 0.3
    motor.brake_pin = random.choice(["", "C", "G"])
    motor.go.debounce = random.choice([1, 2, 4])


def limits_are_set(random, motor):
    motor.soft_limits = random.random() < 0.5
    motor.plus.soft, motor.minus.soft = (
        motor.position + way * random.choice([0, random.randint(0, 3000)]) for way in (1, -1)
    )
    motor.error_limit = random.choice([0, 5, 1000, 32000])
    motor.hot_limit = random.choice([(70, 12_000), (26, 40), (25, 3)])


def the_machine_changes(random, motor):
    machine = motor.machine
    motor.drive = random.choice([ON, ON, ON, OPEN, SHORTED])
    machine.brake, machine.jammed = random.random() < 0.2, random.random() < 0.1
    machine.torque_nm, machine.ambient = random.uniform(-0.5, 0.5), random.uniform(0, 60)
    reach = random.randint(0, 2000)
    motor.window = (motor.shaft - reach, motor.shaft + random.randint(0, 2000))


def the_servo_is_tuned(random, motor):
    motor.rate = random.choice([1, 1, 2, 4, 8])
    motor.amps, motor.torque = random.choice([1023, 300, 0]), random.randint(-1023, 1023)
    if random.random() < 0.3:
        motor.law.tuning = tuple(random.choice([0, 1, random.randint(0, 65535)]) for _ in range(8))


def coordinates_change(random, motor):
    """Reverse the shaft's direction by F=2, or move the origin by O=, sometimes close to the wrap of positions."""
    motor.direction = random.choice([1, -1])
    motor.cam.origin = 0
    here = random.choice([0, random.randint(-3000, 3000), 2**31 - random.randint(1, 50), -(2**31) + 5])
    motor.origin = here - motor.direction * motor.shaft
    motor.trajectory.place = here * 65536 + random.choice([0, random.randint(-(2**20), 2**20)])
    motor.index.forced = random.random() < 0.1
    if motor.index.forced:
        motor.flags["Bx"] = 1


def move(random, motor, mode, **values):
    old = motor.trajectory
    velocity = max(-(2**31), min(2**31, old.velocity))  # limit the velocity of a jump
    motor.trajectory = Trajectory(mode, old.place, velocity, **values)
    motor.flags["Bt"] = 1


def a_move_starts(random, motor):
    """Start MP, MV or X with any A, V and P; often with a position that is soon reached."""
    whole = random.randint(1, 20) * 65536
    rate = random.choice([0, 1, whole, whole, random.randint(1, 2**18), random.randint(1, 2**31 - 1)])
    top = random.choice(
        [0, 3 * whole, random.randint(1, 2**16), random.randint(1, 2**24), random.randint(1, 2**31 - 1)]
    )
    samples = random.randint(2, 100)
    near = motor.trajectory.place + random.choice([1, -1]) * (rate * samples**2 // 4 + random.choice([0, 65536]))
    near //= 65536  # a relative move may pass 2^31
    target = random.choice([near, near, near, random.randint(-(2**31), 2**31 - 1)])
    if random.random() < 0.3:
        motor.trajectory.velocity = random.randint(-(2**22), 2**22)
    mode = random.choice(["position", "position", "velocity", "stop", "hold", "torque", "brake", "off"])
    if mode == "velocity":
        top *= random.choice([1, -1])
    move(random, motor, mode, target=target, top=top, rate=rate)


def the_master_turns(random, motor):
    samples = random.randint(1, 300)
    quarter = Fraction(motor.cam.now.base, 4 * motor.cam.now.factor)  # of a cycle; too fast for one sample
    rate = random.choice([Fraction(random.randint(0, 50_000), random.randint(1, 999)), quarter, quarter * 4 // 5])
    way, part = random.choice([1, -1]), random.randrange(7)
    ahead, base = Fraction(part, 7), motor.master.edges
    end = base + way * random.randint(0, 100)
    motor.master.run = Run(base, way, rate, ahead, end, samples)
    motor.master.shown, motor.master.by_hand = random.choice(["", "A", "B", "AB", "AB"]), random.randrange(4)
    motor.master.steps = random.random() < 0.3


def it_follows(random, motor):
    mode = random.choice(["follow", "step", "ratio", "step ratio"])
    motor.master.resolution = random.choice([1, 2, 4]) if mode == "follow" else 4
    motor.master.seen = motor.master.edges * motor.master.resolution // 4
    divisor = random.choice([1, 3, 1000, 10_000])
    move(random, motor, mode, factor=random.randint(-3 * divisor, 3 * divisor), target=divisor)
    the_master_turns(random, motor)


def table(random, motor):
    for n in range(102):
        motor.memory.set_element("aw", n, random.choice([0, 100 * n, random.randint(-32768, 32767)]))


def cam_parameters(random):
    size = random.choice([1, 4, 5, 8, random.randint(1, 101)])
    word = random.choice([0, 16, 128, 144, 16 + 33, 8])
    base = size + random.choice([0, 8000, random.randint(0, 500)])
    return Parameters(base, size, random.choice([1, 2, 4, 8]), random.choice([0, 50, 2000, -5]), word)


def it_begins_a_cam(random, motor):
    if random.random() < 0.7:
        table(random, motor)
    motor.cam = Cam(motor.cam.table_factor, prepared=cam_parameters(random))
    motor.cam.start()
    motor.cam.phase = random.choice([0, random.randrange(motor.cam.now.cycle)])
    motor.cam.origin = random.choice([0, random.randint(-9999, 9999)])
    move(random, motor, "cam")
    the_master_turns(random, motor)


def cam_parameters_change(random, motor):
    """Change D, BASE, SIZE, MCn or F, and then give CI."""
    motor.cam.prepared = cam_parameters(random)
    motor.cam.pending = random.random() < 0.8
    the_master_turns(random, motor)


def it_begins_host_mode(random, motor):
    host, clock = motor.host, random.randrange(1000)
    host.points, host.started, host.left, host.passed = [], False, 0, 0
    for _ in range(random.randint(0, POINTS)):
        host.points.append((random.choice([random.randint(-2000, 2000), random.randint(-(2**31), 2**31 - 1)]), clock))
        clock += random.choice([0, 1, 3, 16, 64])
    move(random, motor, "host")


def the_host_sends_points(random, motor):
    host = motor.host
    if host.points and len(host.points) < POINTS:
        position, clock = host.points[-1]
        host.points.append((position + random.randint(-99, 99), clock + random.choice([0, 5, 20])))


HAPPENINGS = [
    somebody_sets_flags, pins_change, limits_are_set, the_machine_changes, the_servo_is_tuned, coordinates_change,
    a_move_starts, a_move_starts, the_master_turns, it_follows, it_begins_a_cam, cam_parameters_change,
    cam_parameters_change, it_begins_host_mode, the_host_sends_points,
]  # fmt: skip


class Beside:
    """The reference, and kernels on the same motor, in plain Python and, with Numba, compiled."""

    def __init__(self, random, text):
        self.random, self.motor = random, invented(random, text)
        self.kernels = [Kernel(self.motor, text, compiled=compiled) for compiled in {False, jit.available()}]

    def run(self, most):
        """Run reference and kernels for up to `most` samples, and compare them."""
        motor = self.motor
        why, shafts, commanded = motor.advance(most)
        expected, what = (sum(REASONS[reason] for reason in why), shafts, commanded), shown(motor)
        for kernel in self.kernels:
            assert kernel.advance(most) == expected
            kernel.compare(motor, what)
        if self._react(why):
            self._take()
        return why

    def _take(self):
        what = shown(self.motor)
        for kernel in self.kernels:
            kernel.take(self.motor, what)

    def _react(self, why):
        """Handle some of the events that Python handles; return True if the state has changed."""
        motor, runner = self.motor, self.motor.runner
        leaves = "host" in motor.trajectory.mode and "exit" in why
        if "value" in why:
            motor.fetched = self.random.randint(-1, 255)
        if "call" in why:
            called = "C1" if "C1" in runner.pending else "C2"
            runner.pending.clear()
            if runner.state != "stopped":
                self._call(called)
        if leaves:
            move(self.random, motor, "velocity", rate=100)
        return leaves or not why.isdisjoint(("value", "call"))

    def _call(self, called):
        runner = self.motor.runner
        runner.c2_called |= called == "C2"
        number = 1 if called == "C1" else 2
        for kernel in self.kernels:
            interpreter.call(kernel.i, kernel.program.labels[number], int(kernel.i[state.PC]), CALLS[called])
        runner.call(self.motor.program.labels[number], runner.step, called)

    def interrupt(self):
        runner = self.motor.runner
        runner.pending.add(self.random.choice(["C1", "C2"]))
        runner.fault_again = self.random.random() < 0.3
        runner.wait_until = 0
        self._take()

    def happen(self, *happenings):
        for happening in happenings:
            happening(self.random, self.motor)
        self._take()


@THOROUGH
@given(random=CHANCE)
def test_a_motor_is_that_of_the_reference_whatever_happens_to_it(random):
    all_of_them = Beside(random, "END")
    for _ in range(8):
        all_of_them.happen(*(random.choice(HAPPENINGS) for _ in range(random.randint(1, 4))))
        for _ in range(random.randint(1, 4)):
            all_of_them.run(random.randint(1, 60))


@pytest.mark.parametrize("happenings", [
    (a_move_starts, a_move_starts),
    (it_follows, the_master_turns),
    (it_begins_a_cam, cam_parameters_change, cam_parameters_change),
    (it_begins_host_mode, the_host_sends_points)], ids=["moves", "follow", "cam", "host"])  # fmt: skip
@THOROUGH
@given(random=CHANCE)
def test_each_kind_of_trajectory_is_that_of_the_reference(happenings, random):
    all_of_them = Beside(random, "END")
    all_of_them.happen(happenings[0])
    for _ in range(6):
        all_of_them.run(random.randint(1, 200))
        all_of_them.happen(random.choice(happenings[1:]))


@THOROUGH
@given(random=CHANCE)
def test_a_program_is_carried_out_as_the_reference_does(random):
    all_of_them = Beside(random, inventing.program(random))
    for _ in range(40):
        why = all_of_them.run(random.randint(1, 30))
        if random.random() < 0.1:
            all_of_them.interrupt()
        elif not why and random.random() < 0.5:
            all_of_them.happen(random.choice([a_move_starts, pins_change, somebody_sets_flags]))
