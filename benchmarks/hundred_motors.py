"""Speed of 100 moving SmartMotors on one bench, with servo and motor physics, times real time.

The speed is that of processor time, as other programs also use the processor.  A motor among the others answers the
same bytes and moves in the same way as alone.  Exit code 1 if it does not, or if the goal is missed.
"""

import sys
from collections.abc import Callable, Sequence
from hashlib import sha256
from pathlib import Path
from time import perf_counter, process_time

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "src"))

import numpy as np
from smartmotor_speed import moving, switched_on

from axistwin import Bench
from axistwin.bench import Controller, product
from axistwin.plant.counts import Samples

MOTORS, SECONDS, RUNS, GOAL = 100, 20, 5, 90
ALONE = (0, 41, 99)
"""Numbers of the motors that are compared with the same motors alone."""
COMMANDS = b"A=%d MV V=%d G ", b"RP RPE V=-200000 G ", b"X RW ", b"MP O=0 D=9000 G ", b"RP RPE RI RBt "


def main() -> int:
    """Print speed and verdicts."""
    product("smartmotor").prepare(None, MOTORS)
    bench, _ = moving(MOTORS)
    times = [measure(bench) for _ in range(RUNS)]
    by_processor, by_clock = (SECONDS / min(taken) for taken in zip(*times, strict=True))
    print(f"{MOTORS} motors moving on one bench: {by_processor:,.0f} times real (goal >= {GOAL}); ", end="")
    print(f"{by_clock:,.0f} by the wall clock")
    together = played(range(MOTORS))
    same = all(played([number])[number] == together[number] for number in ALONE)
    print(f"  {'met' if by_processor >= GOAL else 'MISSED'}; samples and bytes {'as alone' if same else 'DIFFER'}")
    return 0 if same and by_processor >= GOAL else 1


def measure(bench: Bench) -> tuple[float, float]:
    """Run the bench; return the seconds of processor time and by the wall clock."""
    worked, began = process_time(), perf_counter()
    bench.run(SECONDS)
    return process_time() - worked, perf_counter() - began


def played(numbers: Sequence[int]) -> dict[int, tuple[object, ...]]:
    """Return samples, bytes, temperature and energy of the motors of these numbers, all on one bench."""
    bench, motors = switched_on(len(numbers))
    hashes = [hashed(motor) for motor in motors]
    for n, text in enumerate(COMMANDS):
        for number, motor in zip(numbers, motors, strict=True):
            motor.serial.write(text % (20 + number, 100_000 + 1000 * number) if n == 0 else text)
        bench.run(4.3)
    found = {}
    for number, motor, samples in zip(numbers, motors, hashes, strict=True):
        shaft = motor.axes["shaft"]
        shaft.catch_up()
        found[number] = (samples(), motor.serial.read(), shaft.temperature, shaft.energy)
    return found


def hashed(motor: Controller) -> Callable[[], str]:
    """Return a function that returns a hash of all samples of the motor from now on."""
    digest = sha256()

    def add(samples: Samples) -> None:
        digest.update(np.stack((samples.positions, samples.commanded), axis=1).tobytes())

    motor.axes["shaft"].subscribe(add)
    return digest.hexdigest


if __name__ == "__main__":
    sys.exit(main())
