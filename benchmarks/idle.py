"""Time to build a thousand idle controllers of all families, and memory of each."""

import gc
import sys
import tracemalloc
from pathlib import Path
from time import perf_counter

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "src"))

from axistwin import Bench

COUNT, RUNS = 1000, 3
MODELS = ("if1", "if2", "1810", "1811", "smartmotor")
GOAL_KIB, GOAL_S = 64, 2.0
AWAKE_S = 3


def main() -> None:
    """Print time and memory, mixed and of the largest alone."""
    build(("smartmotor",), COUNT).run(AWAKE_S)  # the kernels are compiled before the measurement
    for models, what in ((MODELS, "mixed"), (("smartmotor",), "SmartMotors")):
        seconds = min(took(models) for _ in range(RUNS))
        print(f"{COUNT:,} idle controllers, {what}: built in {seconds:.2f} s (goal <= {GOAL_S:g}), ", end="")
        print(f"{memory(models) / COUNT / 1024:.0f} KiB each (goal <= {GOAL_KIB})")


def build(models: tuple[str, ...], count: int) -> Bench:
    """Return controllers after power-up."""
    bench = Bench()
    for n in range(count):
        bench.add(models[n % len(models)], f"c{n}")
    return bench


def took(models: tuple[str, ...]) -> float:
    """Return the seconds to build the controllers."""
    gc.collect()
    began = perf_counter()
    build(models, COUNT)
    return perf_counter() - began


def memory(models: tuple[str, ...]) -> int:
    """Return the memory of the idle controllers, in bytes."""
    gc.collect()
    tracemalloc.start()
    bench = build(models, COUNT)
    bench.run(AWAKE_S)
    gc.collect()
    found, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert bench.controllers
    return found


if __name__ == "__main__":
    main()
