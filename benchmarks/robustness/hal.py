"""The pulses of an IF1 through LinuxCNC HAL in real time, counted at the step output by an encoder module of HAL.

    python benchmarks/robustness/hal.py [--seed 1] [--pulses 100000] [--horizon 1.0]

An IF1 makes random moves on both sides of its start; step generators make the pulses at up to 4,000/s.  An encoder
module counts all edges.  Prints the differences and a verdict; the exit
code is 1 if there are any.  rtapi_app refuses root: as root, HAL runs as the user `nobody`.
"""

import argparse
import os
import queue
import random
import shutil
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "src"))

import numpy as np

from axistwin import Bench
from axistwin.real.standin.events import Ready, Stopped
from axistwin.real.standin.hal.board import HalBoard
from axistwin.real.standin.hal.sender import HalSender
from axistwin.real.standin.hal.wiring import HalWiring
from axistwin.real.standin.wiring import DrivenAxis

HAL_FILE = """
loadrt threads name1=all period1=50000
loadrt stepgen step_type=0 ctrl_type=v
loadrt encoder num_chan=1
loadrt pid num_chan=1
addf stepgen.make-pulses all
addf encoder.update-counters all
addf stepgen.capture-position all
addf encoder.capture-position all
addf pid.0.do-pid-calcs all
addf stepgen.update-freq all
setp stepgen.0.position-scale 1
setp stepgen.0.steplen 50000
setp encoder.0.counter-mode true
setp pid.0.Pgain 500
net step stepgen.0.step => encoder.0.phase-A
net position axistwin.table.X.position-cmd => pid.0.command
net feedback stepgen.0.position-fb => axistwin.table.X.position-fb pid.0.feedback
net velocity pid.0.output => stepgen.0.velocity-cmd
net on axistwin.table.X.enable => stepgen.0.enable pid.0.enable
start
"""


def runs(pulses: int, seed: int) -> tuple[list[tuple[int, "np.ndarray"]], int]:
    """Return direction and times in s of the pulses of random moves, and the IF1's position."""
    rng, bench = random.Random(seed), Bench()
    if1 = bench.add("if1", "table", line="instant", history=10_000)
    for text, seconds in ((b"", 1.6), (b"(", 0.2), (b"U61\r", 1.3)):
        if1.serial.write(text)
        bench.run(seconds)
    left = pulses
    while left:
        length = min(left, rng.randint(1, 3000))
        if1.serial.write(f"X{rng.choice('+-')}{length} @ {rng.choice((400, 1000, 2500, 4000))} $ \r".encode())
        left -= length
        bench.run(0.1)
        while if1.axes["X"].moving:
            bench.run(0.1)
    made = [(way, times / 1e9) for way, times in if1.axes["X"].train.pulse_runs(0, bench.now + 1)]
    return made, if1.axes["X"].position


def main() -> int:
    """Run the campaign."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--pulses", type=int, default=100_000)
    parser.add_argument("--horizon", type=float, default=1.0)
    given = parser.parse_args()
    made, position = runs(given.pulses, given.seed)
    home, prefix = Path(tempfile.mkdtemp()), []
    if os.geteuid() == 0:
        shutil.chown(home, "nobody")
        prefix = ["runuser", "-u", "nobody", "--", "env", f"HOME={home}"]
    (home / "campaign.hal").write_text(HAL_FILE)
    events: queue.Queue = queue.Queue()
    wiring = HalWiring("hal", (DrivenAxis("table.X"),), file=home / "campaign.hal")
    sender = HalSender(HalBoard(wiring, given.horizon), lambda _, event: events.put(event), prefix)
    sender.start()
    try:
        found = events.get(timeout=30)
        assert isinstance(found, Ready), found
        offset = time.monotonic() + 0.1 - made[0][1][0]
        for direction, times in made:
            for block in np.array_split(times, max(1, len(times) // 40)):
                while time.monotonic() < block[-1] + offset:
                    sender.complete(min(time.monotonic(), block[0] + offset))
                    time.sleep(0.01)
                sender.queue("table.X", direction, block + offset)
                sender.complete(block[-1] + offset)
        sender.complete(made[-1][1][-1] + offset + 0.2)
        stopped = events.get(timeout=60)
        assert isinstance(stopped, Stopped), stopped
        edges = int(float(sender._halcmd("getp", "encoder.0.rawcounts")))
    finally:
        sender.close()
        shutil.rmtree(home)
    total = sum(len(times) for _, times in made)
    seconds = made[-1][1][-1] - made[0][1][0]
    print(f"{total} pulses, {len(made)} moves, {seconds:.0f} s; position {position}; {stopped.reason}")
    print(f"HAL: {edges} edges, position {stopped.positions['table.X']}")
    wrong = abs(edges - total) + abs(stopped.positions["table.X"] - position)
    print(f"{'FAILED' if wrong else 'held'}: difference {wrong}, seed {given.seed}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
