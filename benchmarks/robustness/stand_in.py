"""A stand-in with a simulated board in virtual time: random programs, and a host that stops at random times.

    python benchmarks/robustness/stand_in.py [--seed 1] [--programs 60] [--kills 100]

Programs: an IF1 moves up to three axes, with changes of direction and stops by `#`; the pulses at the pins must be
those of the IF1 in number, direction and time.  Kills: the host stops sending during a move; the motors must stop and
the drives switch off within 120 ms. Prints the errors and a verdict; the exit code is 1 if there are errors.
"""

import argparse
import random
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "src"))
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np
from tests.standin.metal import Metal
from tests.standin.test_driver import Twin

MOST_ERROR_US, MOST_STANDSTILL_S = 5.0, 0.12
PINS = {"X": (2, +1), "Y": (5, -1), "Z": (12, +1)}


def message(rng: random.Random) -> bytes:
    """Return a random move or run."""
    axes = rng.sample("XYZ", rng.randint(1, 3))
    signs = "".join(f"{axis}{rng.choice('+-')}" for axis in axes)
    return f"{signs}{rng.randint(1, 1500)} @ {rng.choice((400, 1000, 1500, 3300, 4000))} $ \r".encode()


def program(seed: int) -> list[str]:
    """Run one program; return its errors."""
    rng, twin, wrong = random.Random(seed), Twin(line="instant"), []
    twin.initialise()
    for _ in range(rng.randint(1, 4)):
        twin.say(message(rng), rng.uniform(0.1, 2.0))
        if rng.random() < 0.4:
            twin.say(b"#", 0.3)
    twin.run(6.0)
    for name, (pin, sign) in PINS.items():
        axis, made = twin.controller.axes[name], twin.metal.small.pulses[pin]
        virtual = axis.pulse_times() / 1e9
        if len(made) != len(virtual) or sign * sum(direction for _, direction in made) != axis.position:
            wrong.append(f"program {seed}: {name}: {len(made)} pulses for {len(virtual)}: {twin.lines}")
        elif len(made):
            late = np.array([twin.metal.small.time_s(tick) for tick, _ in made]) - virtual
            worst = np.abs(late - np.median(late)).max() * 1e6
            if worst > MOST_ERROR_US:
                wrong.append(f"program {seed}: {name}: an edge is off by {worst:.1f} µs")
    return wrong


def kill(seed: int) -> list[str]:
    """Stop sending at a random time in a move; return the errors."""
    rng, metal = random.Random(seed), Metal(horizon_s=random.Random(seed).choice((0.1, 0.5))).start()
    metal.move("table.X", +1, metal.even(8000, rng.choice((500, 4000))), rng.uniform(0.02, 1.5))
    metal.alive, died = False, metal.now
    metal.run(1.0)
    last = max((metal.small.time_s(tick) for tick, _ in metal.small.pulses[2]), default=died)
    wrong = [f"kill {seed}: moving for {last - died:.3f} s"] if last - died > MOST_STANDSTILL_S else []
    return wrong + ([] if metal.small.levels[4] == 1 else [f"kill {seed}: the drive is enabled"])


def main() -> int:
    """Run both campaigns."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--programs", type=int, default=60)
    parser.add_argument("--kills", type=int, default=100)
    given = parser.parse_args()
    first = given.seed * 10_000
    wrong = [line for seed in range(first, first + given.programs) for line in program(seed)]
    wrong += [line for seed in range(first, first + given.kills) for line in kill(seed)]
    print("\n".join(wrong), end="\n" if wrong else "")
    print(f"{'FAILED' if wrong else 'held'}: {given.programs} programs, {given.kills} kills, seed {given.seed}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
