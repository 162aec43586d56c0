"""Blocks of samples: neither their lengths nor other motors on the bench change samples, bytes or the end of a run."""

from array import array

import pytest

from axistwin import Bench
from axistwin.controllers.smartmotor.kernel import core, jit, kernel

from .talking import SAMPLE_NS

SHAFTS = ({"motor": "frame17"}, {"motor": "frame23", "load": {"inertia_kg_m2": 3e-5}}, {})
TALKS = {
    0: ("UCI UDI ZS A=100 MV V=200000 G", "UCI UDI ZS A=50 MP O=0 V=90000 P=40000 G"), 9_000: ("RP RPE", "V=-150000 G"),
    31_111: ("X", "RW RP"), 40_000: ("MP V=400000 D=9000 G", "MT T=200 G"),
}  # fmt: skip
"""Commands of the motors with an even and with an odd number, by the sample at which they are written."""
END = 45_000


@pytest.fixture
def compiled(monkeypatch):
    """Compile the kernel before the first sample."""
    if not jit.available():
        pytest.skip("Numba is not installed")
    monkeypatch.setattr(core.Engine, "compiled", jit.best(kernel.advance))


@pytest.fixture
def lengths(monkeypatch):
    """Return a list of the lengths of all blocks."""
    found, run_kernel = [], core.Engine.run
    monkeypatch.setattr(core.Engine, "run", lambda engine, most: found.append(most) or run_kernel(engine, most))
    return found


def added(bench, number):
    """Add the motor of this number; the motors differ in machine and speed."""
    return bench.add("smartmotor", f"motor{number}", line="instant", shaft=SHAFTS[number % len(SHAFTS)])


def recorded(motor):
    """Return three arrays that will be filled with the times, positions and setpoints of all samples."""
    times, positions, setpoints = array("q"), array("q"), array("q")

    def add(samples):
        times.extend(map(samples.time_ns, range(len(samples))))
        positions.extend(samples.positions)
        setpoints.extend(samples.commanded)

    motor.axes["shaft"].subscribe(add)
    return times, positions, setpoints


def run(numbers):
    """Return all samples, the last bytes, heat and velocity of the motors on one bench."""
    bench = Bench()
    motors = {number: added(bench, number) for number in numbers}
    samples = {number: recorded(motor) for number, motor in motors.items()}
    for sample, lines in TALKS.items():
        bench.clock.run_to(sample * SAMPLE_NS)
        for number, motor in motors.items():
            motor.serial.write(f"{lines[number % 2]} V={100_000 + 1000 * number}\r".encode())
    bench.clock.run_to(END * SAMPLE_NS)
    for motor in motors.values():
        motor.axes["shaft"].catch_up()
    return {
        number: (*samples[number], motor.serial.read(), motor.axes["shaft"].energy, motor.axes["shaft"].velocity)
        for number, motor in motors.items()
    }


def test_six_motors_move_together_as_alone(compiled):
    together = run(range(6))
    for number, result in together.items():
        _, positions, _, said, *_ = result
        assert len(set(positions)) > 5000 and said
        assert {number: result} == run([number])


def stopped(sample):
    """Let the host stop a motor at this sample; return all samples, and the sample at which the run ends."""
    bench = Bench()
    motor = added(bench, 1)
    samples = recorded(motor)
    motor.serial.write(b"UCI UDI ZS A=100 MV V=200000 G ")
    bench.clock.run_to(sample * SAMPLE_NS)
    motor.serial.write(b"X ")
    assert bench.run_until(lambda: bench.clock.quiet, 60)
    return samples, bench.now // SAMPLE_NS


@pytest.mark.parametrize("sample", [24_600, 24_700, 30_000])
def test_several_blocks_as_one_move_and_end_as_single_blocks(sample, compiled, lengths, monkeypatch):
    """Wherever the stop comes, several blocks computed as one give the same samples and end as single blocks."""
    as_one = *stopped(sample), lengths[-2:]
    assert max(lengths) == 4 * core.LONGEST
    lengths.clear()
    monkeypatch.setattr(core, "AT_ONCE", 1)
    assert (*stopped(sample), lengths[-2:]) == as_one and max(lengths) == core.LONGEST


def test_a_bench_with_a_wall_clock_computes_single_blocks(compiled, lengths):
    bench = Bench()
    bench.clock.patient = False
    added(bench, 1).serial.write(b"UCI UDI ZS A=100 MV V=200000 G ")
    bench.clock.run_to(30_000 * SAMPLE_NS)
    assert max(lengths) == core.LONGEST
