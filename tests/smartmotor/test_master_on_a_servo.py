"""An external encoder on another servo: reading the leader's block ahead gives the same as reading each sample."""

from fractions import Fraction
from random import Random

import pytest

from axistwin import Bench
from axistwin.plant.servo_axis import ServoAxis

SHAFT = {"motor": "frame23", "load": {"inertia_kg_m2": 3e-5}}
SAYS = (
    b"A=100 MV V=%d G ", b"A=50 V=%d D=3000 MD G ", b"V=%d G ", b"MP P=1000 V=%d G ", b"X ", b"OFF ", b"RP ", b"RCTR ",
    b"MF4 ", b"MF1 ", b"MFMUL=3 MFDIV=2 MFR G ",
)  # fmt: skip
DOES = ("jam", "push", "slip", "restart")


def chain(ratio, shaft):
    """Return three motors, switched on at odd times; the second follows the first, the third follows the second."""
    bench, motors = Bench(), []
    for n in range(3):
        bench.clock.run_to(bench.now + 1_234_567 * n)
        motors.append(bench.add("smartmotor", name=f"motor{n}", line="instant", shaft=shaft))
    bench.run(0.4)
    for motor in motors:
        motor.serial.write(b"UCI UDI ZS ")
    bench.run(0.01)
    motors[1].master.follow(motors[0].axes["shaft"], ratio)
    motors[2].master.follow(motors[1].axes["shaft"])
    return bench, motors


def do(motor, what, random):
    """Perform one random act: write a command, or turn the machine by hand."""
    if isinstance(what, bytes):
        motor.serial.write(what % random.randrange(1000, 400_000) if b"%" in what else what)
    elif what == "jam":
        motor.axes["shaft"].jam(random.random() < 0.3)
    elif what == "restart":
        motor.serial.write(b"Z ")
    else:
        getattr(motor.axes["shaft"].encoder, {"push": "displace", "slip": "slip"}[what])(random.randrange(-20, 20))


def session(seed):
    """Return the answers and all changes of positions of a random session."""
    random = Random(seed)
    bench, motors = chain(Fraction(random.choice((1, 2, -3)), random.choice((1, 2))), SHAFT if seed % 2 else {})
    samples, seen, last = [], [], {}
    for n, motor in enumerate(motors):
        motor.axes["shaft"].subscribe(
            lambda s, n=n: samples.extend((s.start_ns + k * s.period_ns, n, at) for k, at in enumerate(s.positions))
        )
        motor.serial.write((b"A=100 MV V=300000 G ", b"MF4 ", b"MFMUL=3 MFDIV=2 MFR G ")[n])
    for _ in range(16):
        at_once = random.random() < 0.8
        bench.clock.run_to(bench.now + (random.randrange(1, 40_000_000) if at_once else random.randrange(5) * 245_760))
        do(random.choice(motors), random.choice(SAYS + DOES), random)
        seen.append([(motor.axes["shaft"].position, motor.master.count, motor.serial.read()) for motor in motors])
    for motor in motors:
        motor.axes["shaft"].catch_up()
    for time_ns, n, at in sorted(samples):
        if last.get(n) != at:
            last[n] = at
            seen.append((time_ns, n, at))
    return seen


@pytest.mark.parametrize("seed", [3, 6])
def test_reading_ahead_is_the_same_as_reading_before_each_sample(seed, monkeypatch):
    ahead = session(seed)
    assert len(ahead) > 200
    monkeypatch.setattr(ServoAxis, "positions_ahead", lambda axis, times_ns: [axis.position])
    assert session(seed) == ahead


def test_a_follower_computes_blocks_as_long_as_its_leader(monkeypatch):
    """The follower reads its leader once per block, not once per sample."""
    bench, (leader, follower, _) = chain(Fraction(1), {})
    leader.serial.write(b"A=100 MV V=300000 G ")
    follower.serial.write(b"MF4 ")
    bench.run(0.5)
    readings, read = [], ServoAxis.positions_ahead
    monkeypatch.setattr(ServoAxis, "positions_ahead", lambda axis, times: readings.append(1) or read(axis, times))
    bench.run(0.5)
    assert len(readings) < 0.5 / 245_760e-9 / 10 and follower.axes["shaft"].position > 1000
    leader.serial.write(b"X ")
    bench.run(1.5)
    assert follower.axes["shaft"].velocity == leader.axes["shaft"].velocity == 0
    assert follower.master.count == leader.axes["shaft"].position


def test_a_leader_without_power_is_read_before_each_sample():
    """The follower counts a push by hand on a leader without power, which can come before any sample."""
    bench, (leader, follower, _) = chain(Fraction(2), {})
    follower.serial.write(b"MF4 ")
    leader.power(False)
    bench.run(0.1)
    before = follower.axes["shaft"].position
    leader.axes["shaft"].encoder.displace(50)
    bench.run(0.1)
    assert follower.axes["shaft"].position - before == 100


@pytest.mark.parametrize(("velocity", "level"), [(300_000, True), (-300_000, False)])
def test_a_step_source_on_a_servo_shows_its_direction_on_pin_b(velocity, level):
    """For MS, B is the direction: high while the source counts up."""
    bench, (leader, follower, _) = chain(Fraction(1), {})
    follower.serial.write(b"MS ")
    leader.serial.write(b"A=1000 MV V=%d G " % velocity)
    bench.run(0.5)
    assert follower.pins["B"].level is level
