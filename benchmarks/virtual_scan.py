"""A bluesky scan with the twin inside: virtual seconds per second of processor time.

    python benchmarks/virtual_scan.py --points 11 --seed 17

For each family, a plan of bluesky moves an axis of `axistwin.ophyd` to random points.  Each move takes 5 s or more of
virtual time, which passes only while the driver waits.  The exit code is 1 if a position is wrong, a move is shorter,
or a scan is less than 50 times faster than a real controller.  The ratio is that of processor time, because the
computer may have other work; the ratio of real time is printed too.
"""

import argparse
import asyncio
import random
import sys
import time
import warnings
from itertools import pairwise

AXES = {"if1": "X", "1811": "motor", "smartmotor": "shaft"}
VELOCITY = 300
"""Counts per second."""
SHORTEST, LONGEST = 1600, 4000
"""Distances in counts; the shortest takes at least 5.3 s."""
LEAST_RATIO = 50


def points(number: int, chance: random.Random) -> list[int]:
    """Return the points of a scan; the first is that of the axis at rest."""
    found = [0]
    while len(found) < number:
        found.append(found[-1] + chance.choice((-1, 1)) * chance.randint(SHORTEST, LONGEST))
    return found


def run(model: str, targets: list[int]) -> bool:
    """Scan with one controller; print the figures, and return True if they are good."""
    from bluesky import RunEngine
    from bluesky.plans import list_scan

    from axistwin import Bench
    from axistwin.ophyd import Controller

    bench = Bench()
    bench.add(model)
    engine, seen = RunEngine(), []

    def note(kind: str, document: dict) -> None:
        if kind == "event":
            seen.append((bench.seconds, document["data"]["m"]))

    engine.subscribe(note)
    motor = Controller.inside(bench, model).motor(AXES[model], name="m")
    motor.axis.set_profile(velocity=VELOCITY)

    async def connect() -> None:
        await motor.connect()

    asyncio.run_coroutine_threadsafe(connect(), engine.loop).result()
    began, real, busy = bench.seconds, time.monotonic(), time.process_time()
    engine(list_scan([], motor, targets))
    busy, real, virtual = time.process_time() - busy, time.monotonic() - real, bench.seconds - began
    final = bench[model].axes[AXES[model]].position
    exact = [*(position for _, position in seen), final] == [*targets, targets[-1]]
    shortest = min(late - early for (early, _), (late, _) in pairwise(seen))
    good = exact and shortest >= 5 and virtual / busy >= LEAST_RATIO
    print(
        f"{model:10} {len(targets)} points {'exact' if exact else 'WRONG'}, shortest move {shortest:.1f} s, "
        f"{virtual:.0f} virtual s in {busy:.2f} s of processor time: {virtual / busy:.0f} times faster "
        f"({virtual / real:.0f} times in real time)"
    )
    return good


def main() -> int:
    """Run the scans and print the verdict."""
    given = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    given.add_argument("--points", type=int, default=11)
    given.add_argument("--seed", type=int, default=17)
    words = given.parse_args()
    warnings.simplefilter("ignore", DeprecationWarning)  # of bluesky
    chance = random.Random(words.seed)
    results = [run(model, points(words.points, chance)) for model in AXES]
    good = all(results)
    print("passed" if good else "failed")
    return not good


if __name__ == "__main__":
    sys.exit(main())
