"""An hour of the manual's sequence sample 3, repeating for ever: how much faster than real, and what it costs to go on.

The same is measured for the third hour (memory stays, cost does not grow) and for moves a hundred times as long (cost
grows with commands, not with pulses).
"""

import gc
import sys
import tracemalloc
from pathlib import Path
from time import perf_counter

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "src"))

from axistwin import Bench
from axistwin.bench import Controller
from axistwin.motion.train import HISTORY

HOUR = 3600
STEPS = ["XS1", "X-S2", "YS3", "Y-S4", "ZS5", "Z-R5", "XYZR4", "X-YZR3", "X-Y-Z-R2", "X-Y-Z-R1"]
"""What the sample does: a move on one to three axes, then an output."""


def running(distance: int, history: int = HISTORY) -> tuple[Bench, Controller]:
    """An IF1 in the middle of the sequence, its first axis moving `distance` steps at 10,000 steps/s."""
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
    """Wall-clock seconds that the next hour takes."""
    begin = perf_counter()
    bench.run(HOUR)
    return perf_counter() - begin


def memory_growth(bench: Bench) -> int:
    """Bytes that an hour leaves behind, once the history of moves is full."""
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
