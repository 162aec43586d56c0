"""Step commands for moves of 20,000 pulses of an IF1, an 1811 and a SmartMotor, planned as a whole for a 16 MHz clock.

    python benchmarks/step_commands.py [--pulses 20000] [--least]

The pulses of step outputs must be within 0.5 µs of their times.  The counts of a SmartMotor are known to a sample of
246 µs; their tolerance is a quarter of the time between two.  The typical moves must take at most 150 commands.  Each
velocity level of a fast ramp needs commands of its own, so the other moves must take at most 2.5 for each level.
Prints the figures and a verdict; the exit code is 1 if one fails.

The pulse times of a command are a quadratic function of the pulse number.  `--least` (needs SciPy) also prints the
smallest number of quadratic functions, of any real coefficients, that are within the tolerance of all pulse times: no
planner can take fewer commands.
"""

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "src"))

import numpy as np

from axistwin import Bench
from axistwin.bench import Controller
from axistwin.real.standin.motors import Motor, motor
from axistwin.sim.motion.step_queue import plan

MHZ, MOST_COMMANDS, MOST_PER_LEVEL = 16, 150, 2.5
COLLECT_S, LONGEST_S = 0.01, 30.0

Prepare = Callable[[Bench, int], tuple[Controller, Callable[[], None]]]
"""Function that returns a controller that is ready to move, and a function that starts the move."""


class Figures(NamedTuple):
    """Figures of one move."""

    pulses: int
    commands: int
    levels: int
    worst_us: float
    tolerance_us: float
    least: int
    """Smallest number of commands that any planner could take; 0: not computed."""

    def __str__(self) -> str:
        return (
            f"{self.pulses} pulses in {self.commands} commands, {self.levels} velocity levels, worst error "
            f"{self.worst_us:.2f} of {self.tolerance_us:.2f} µs"
            + (f", no planner can take fewer than {self.least} commands" if self.least else "")
        )


def if1(rate: int) -> Prepare:
    """Prepare a move of an IF1 at this rate."""

    def prepare(bench: Bench, pulses: int) -> tuple[Controller, Callable[[], None]]:
        controller = bench.add("if1", line="instant")
        for text, seconds in ((b"", 1.6), (b"(", 0.3), (b"U61\r", 2.0)):
            controller.serial.write(text)
            bench.run(seconds)
        return controller, lambda: controller.serial.write(b"X%d @ %d $ \r" % (pulses, rate))

    return prepare


def compumotor(velocity: int, acceleration: int) -> Prepare:
    """Prepare a move of an 1811 at this velocity in pulses/s."""

    def prepare(bench: Bench, pulses: int) -> tuple[Controller, Callable[[], None]]:
        controller = bench.add("1811")

        def command(*values: int) -> None:
            for value in values:
                controller.bus.write(0, value)
            controller.bus.write(1, 0x10)
            bench.run(0.1)

        bench.run(1.2)
        command(0x31, 0, 0, *velocity.to_bytes(4, "big"), *acceleration.to_bytes(4, "big"))
        return controller, lambda: command(0x33, *pulses.to_bytes(4, "big"))

    return prepare


def smartmotor(acceleration: int, velocity: int) -> Prepare:
    """Prepare a move of a SmartMotor."""

    def prepare(bench: Bench, pulses: int) -> tuple[Controller, Callable[[], None]]:
        controller = bench.add("smartmotor")
        bench.run(1.5)
        controller.serial.write(b"UCI UDI ZS ")
        bench.run(0.5)
        order = b"A=%d V=%d P=%d G " % (acceleration, velocity, pulses)
        return controller, lambda: controller.serial.write(order)

    return prepare


def figures(prepare: Prepare, pulses: int, least: bool) -> Figures:
    """Make a move, plan its pulses and return the figures."""
    bench = Bench()
    controller, start = prepare(bench, pulses)
    axis = next(iter(controller.axes.values()))
    driven = motor(axis)
    list(driven.runs())
    start()
    times_ns = collected(bench, driven)
    tolerance = driven.tolerance_s(times_ns) * 1e6 * MHZ
    wanted = times_ns * MHZ / 1000
    at = int(wanted[0]) - MHZ * 5000
    commands = made = 0
    worst = 0.0
    for steps in plan(wanted, at, tolerance):
        worst = max(worst, float(np.abs(steps.times(at) - wanted[made : made + steps.count]).max()))
        at, made, commands = at + steps.ticks, made + steps.count, commands + 1
    moves = axis.train.moves if hasattr(axis, "train") else []
    levels = sum(len(move.profile.segments) for move in moves)
    fewest = least_commands(wanted, tolerance) if least else 0
    return Figures(made, commands, levels, worst / MHZ, tolerance / MHZ, fewest)


def least_commands(times: "np.typing.NDArray[np.float64]", tolerance: float) -> int:
    """Return the smallest number of quadratic functions that cover all times, in order, within the tolerance."""
    done = found = 0
    while done < len(times):
        left = times[done:]
        fits, fails = min(3, len(left)), len(left) + 1
        while fails - fits > 1:
            tried = min(2 * fits, (fits + fails) // 2)
            if quadratic(left[:tried], tolerance):
                fits = tried
            else:
                fails = tried
        done, found = done + fits, found + 1
    return found


def quadratic(times: "np.typing.NDArray[np.float64]", tolerance: float) -> bool:
    """True if a quadratic function of the pulse number is within the tolerance of all times.

    Linear programming finds the best function for some of the pulses; the pulse with the largest error joins them.
    """
    from scipy.optimize import linprog

    count = len(times)
    wanted, scaled = times - times.mean(), np.linspace(-1, 1, count)
    powers = np.stack([np.ones(count), scaled, scaled**2], axis=1)
    chosen = np.unique(np.linspace(0, count - 1, min(count, 12)).astype(int))
    while True:
        some, slack = powers[chosen], -np.ones((len(chosen), 1))
        above, below = np.hstack([some, slack]), np.hstack([-some, slack])
        bounds = np.concatenate([wanted[chosen], -wanted[chosen]])
        *coefficients, error = linprog([0, 0, 0, 1], np.vstack([above, below]), bounds, bounds=(None, None)).x
        if error > tolerance * (1 + 1e-9):
            return False
        errors = np.abs(powers @ coefficients - wanted)
        worst = int(errors.argmax())
        if errors[worst] <= tolerance * (1 + 1e-6) or worst in chosen:
            return True
        chosen = np.append(chosen, worst)


def collected(bench: Bench, driven: Motor) -> "np.typing.NDArray[np.int64]":
    """Return the times of the pulses, collected in blocks as the driver does."""
    found = []
    for _ in range(round(LONGEST_S / COLLECT_S)):
        bench.run(COLLECT_S)
        found += [times for _, times in driven.runs()]
    return np.concatenate(found)


TYPICAL = {
    "IF1 at 1,000/s": if1(1000),
    "IF1 at 4,000/s": if1(4000),
    "1811 at 5,000/s, 100,000/s²": compumotor(5000, 100_000),
    "SmartMotor A=100 V=100000 (6,200/s)": smartmotor(100, 100_000),
    "SmartMotor A=400 V=50000 (3,100/s)": smartmotor(400, 50_000),
}
FAST = {
    "IF1 at 10,000/s": if1(10_000),
    "IF1 at 20,000/s": if1(20_000),
    "1811 at 20,000/s, 50,000/s²": compumotor(20_000, 50_000),
}


def main() -> int:
    """Print the figures of all moves."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--pulses", type=int, default=20_000)
    parser.add_argument("--least", action="store_true")
    given, held = parser.parse_args(), True
    for name, prepare in (TYPICAL | FAST).items():
        found = figures(prepare, given.pulses, given.least)
        most = MOST_COMMANDS if name in TYPICAL else MOST_PER_LEVEL * found.levels
        good = found.pulses == given.pulses and found.commands <= most and found.worst_us <= found.tolerance_us + 1e-9
        held = held and good
        print(f"{'held' if good else 'FAILED'}: {name}: {found}", flush=True)
    return 0 if held else 1


if __name__ == "__main__":
    sys.exit(main())
