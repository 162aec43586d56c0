"""Speed of an hour of the manual's sequence sample 3, repeated for ever, times real time, and its memory.

Also measured: the third hour, which needs no more time or memory, and moves a hundred times as long, which need no
more time, because the time depends on the number of commands, not of pulses.
"""

import gc
import sys
import tracemalloc
from pathlib import Path
from time import perf_counter

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "src"))

from axistwin import Bench
from axistwin.bench import Controller
from axistwin.sim.motion.train import HISTORY

HOUR = 3600
STEPS = ["XS1", "X-S2", "YS3", "Y-S4", "ZS5", "Z-R5", "XYZR4", "X-YZR3", "X-Y-Z-R2", "X-Y-Z-R1"]
"""Sequence of the sample: a move on one to three axes, then an output."""


def running(distance: int, history: int = HISTORY) -> tuple[Bench, Controller]:
    """Return an IF1 during the sequence, with moves of `distance` steps at 10,000 steps/s."""
    bench = Bench()
    if1 = bench.add("if1", line="instant", history=history)
    bench.run(1.1)
    if1.serial.write(b"(U61\r")
    bench.run(1.1)
    if1.pins["input1"].drive(True)
    first, *others = STEPS
    moves = [f"X{distance}@10000{first[1:]}", *others]
    if1.serial.write(f":R12345:H1:{':'.join(moves)}:=0,1:$\r".encode())
    bench.run(1)
    return bench, if1


def seconds_for_an_hour(bench: Bench) -> float:
    """Return the wall-clock seconds of the next hour."""
    begin = perf_counter()
    bench.run(HOUR)
    return perf_counter() - begin


def memory_growth(bench: Bench) -> int:
    """Return the memory growth of an hour, in bytes, after the history of moves is full."""
    gc.collect()
    tracemalloc.start()
    bench.run(HOUR / 4)
    gc.collect()
    before = tracemalloc.get_traced_memory()[0]
    bench.run(HOUR / 4)
    gc.collect()
    after = tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    return after - before


def main() -> None:
    """Print the ratios."""
    bench, if1 = running(1000)
    first, second, third = (seconds_for_an_hour(bench) for _ in range(3))
    moves = len(if1.axes["X"].train.moves) + if1.axes["X"].train.forgotten
    print(f"virtual hour of sample 3: {HOUR / min(first, second, third):,.0f} times real (goal >= 10,000)")
    print(f"third hour against the first: ratio {third / first:.2f} (goal about 1); {moves:,} moves of X so far")
    small, _ = running(1000, history=1000)
    small.run(HOUR)
    print(f"memory left behind by a quarter of an hour: {memory_growth(small) / 1024:.1f} KiB (goal about 0)")
    long_bench, _ = running(100_000)
    long = seconds_for_an_hour(long_bench)
    print(f"moves of 100 times the pulses: ratio {long / first:.2f} of the cost of an hour (goal <= 1)")


if __name__ == "__main__":
    main()
