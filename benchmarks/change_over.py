"""The longest pause of an event loop while the compiled kernel of SmartMotors is prepared.

The loop wakes up every millisecond, like a paced clock.  Each figure is from a process of its own: without a
preparation, with the preparation of `axistwin serve`, and with a preparation in a plain thread, as an independent
reference.  `--fresh` begins with an empty cache, so that the kernel is compiled.  The second figure counts only the
processor time that the preparing thread takes during a pause, for a computer with other work; it needs Linux.
"""

import argparse
import asyncio
import os
import subprocess
import sys
import tempfile
import threading
from pathlib import Path
from time import perf_counter, process_time, thread_time

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "src"))

from axistwin import Bench
from axistwin.bench import product
from axistwin.cli.serving import preparing

LEAST_S, RUNS = 1.0, 3
GOAL_MS = 15


def main() -> None:
    """Print the pauses."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--fresh", action="store_true", help="begin with an empty cache")
    fresh = parser.parse_args().fresh
    product("smartmotor").prepare(None, 1)  # the kernel is in the cache
    (before, worked_before), (pause, worked) = longest("thread", fresh), longest("serve", fresh)
    print(f"longest pause while the kernel is {'compiled' if fresh else 'loaded'}: {pause:.0f} ms (goal <= {GOAL_MS})")
    print(f"  {before:.0f} ms in a plain thread, {longest('nothing', fresh)[0]:.0f} ms without a preparation")
    print(f"  by processor time of the preparing thread: {worked:.1f} ms; {worked_before:.1f} ms in a plain thread")


def longest(how: str, fresh: bool) -> tuple[float, float]:
    """Return the longest pause, and the most processor time of another thread in a pause, in ms.

    Each is the least of some runs, in processes of their own.
    """
    runs = []
    for _ in range(1 if fresh else RUNS):
        with tempfile.TemporaryDirectory() as empty:
            environment = {**os.environ, **({"XDG_CACHE_HOME": empty} if fresh else {})}
            done = subprocess.run([sys.executable, __file__, how], env=environment, stdout=subprocess.PIPE, check=True)
        runs.append([float(word) for word in done.stdout.split()])
    pauses, worked = zip(*runs, strict=True)
    return min(pauses), min(worked)


async def ticking(ready: threading.Event) -> tuple[float, float]:
    """Return the longest time between two ticks of 1 ms until `ready` is set and for a minimum time, and the most
    processor time of other threads between two ticks; in ms.
    """
    began = last = perf_counter()
    others = process_time() - thread_time()
    pause = most = 0.0
    while not ready.is_set() or last - began < LEAST_S:
        await asyncio.sleep(0.001)
        now, worked = perf_counter(), process_time() - thread_time()
        pause, last = max(pause, now - last), now
        most, others = max(most, worked - others), worked
    return pause * 1000, most * 1000


def measure(how: str) -> tuple[float, float]:
    """Return the longest pause, and the most processor time of other threads in a pause, in ms, with one of the
    preparations.
    """
    ready = threading.Event()
    if how == "serve":
        bench = Bench()
        bench.add("smartmotor")
        with preparing.preparing(bench, None) as prepared:
            return asyncio.run(ticking(prepared))
    if how == "thread":
        threading.Thread(target=lambda: (product("smartmotor").prepare(None, 1), ready.set())).start()
    else:
        ready.set()
    return asyncio.run(ticking(ready))


if __name__ == "__main__":
    if sys.argv[1:] and not sys.argv[1].startswith("-"):
        print(*measure(sys.argv[1]))
    else:
        main()
