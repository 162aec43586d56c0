"""`axistwin stand-in` in real time, with a simulated board in another process.

    python benchmarks/robustness/stand_in_real_time.py [--seed 1] [--kills 100] [--load-s 600] [--spinners 2]

Kills: the program is killed (SIGKILL) at a random moment of a move; the motor must stand still within 120 ms and the
drive be off, and the next start must be refused.  The time begins at the kill, or when the board receives the last
bytes that were written before: a busy computer delivers the bytes of a pseudo terminal late.  Load: spinning processes
use all cores while an IF1 moves back and forth, with a horizon and a watchdog of 0.5 s; every pulse must be made, with
at most one stop.  As root, the process of the board has a higher priority, because a real board has a processor of its
own.  Prints the errors and a verdict; the exit code is 1 if there are errors.
"""

import argparse
import os
import random
import signal
import socket
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from tests.standin.command import StandInCommand

SCENE = """
[[controller]]
model = "if1"
name = "table"
line = "instant"
options = {{ self_test_s = 0.2 }}
ports = ["tcp://127.0.0.1:0"]

[stand-in]
horizon_ms = 500
watchdog_ms = {watchdog}

[[stand-in.board]]
name = "small"
port = "board"

[[stand-in.axis]]
axis = "table.X"
step = "P2"
direction = "P3"
enable = "!P4"
"""
MOST_STANDSTILL_S = 0.12


class Run(StandInCommand):
    """The command with an IF1 that is ready for messages, at a TCP port."""

    def __init__(self, folder: Path, watchdog_ms: int) -> None:
        super().__init__(folder, SCENE.format(watchdog=watchdog_ms))
        self._host = socket.create_connection(("127.0.0.1", int(self.first.rpartition(":")[2])))
        for text, seconds in ((b"", 0.6), (b"(", 0.3), (b"U61\r", 1.5)):
            self.say(text, seconds)

    def say(self, text: bytes, seconds: float) -> None:
        """Send text, and wait."""
        self._host.sendall(text)
        time.sleep(seconds)

    def refused(self) -> bool:
        """Start the command again; return True if it is refused."""
        ended = self.again()
        return ended.returncode == 2 and b"--unhomed" in ended.stderr

    def close(self) -> dict[str, object]:
        """End the host, the command and the board; return the pulses and levels of the board."""
        self._host.close()
        return super().close()


def kill(seed: int) -> list[str]:
    """Kill the program at a random moment; return the errors."""
    rng = random.Random(seed)
    with tempfile.TemporaryDirectory() as folder:
        try:
            run = Run(Path(folder), watchdog_ms=100)
        except RuntimeError as error:
            EARLY.append(str(error))
            return []
        run.say(b"X+9000 @ %d $ \r" % rng.choice((500, 4000)), rng.uniform(0.5, 2.5))
        before = run.stops()
        run.program.kill()
        killed = time.monotonic()
        time.sleep(0.5)
        refused = run.refused()
        found = run.close()
    last = max((found["begun"] + (tick - 0xFFF0_0000) / 16e6 for tick, _ in found["pulses"]["2"]), default=0.0)
    wrong = [] if refused else [f"kill {seed}: the next start is not refused"]
    moving_s = last - max(killed, found["heard"])
    STANDSTILLS.append(moving_s)
    if moving_s > MOST_STANDSTILL_S:
        wrong.append(f"kill {seed}: moving for {moving_s:.3f} s")
    if found["levels"]["4"] != 1:
        wrong.append(f"kill {seed}: the drive is enabled")
    EARLY.extend(before)
    return wrong


STANDSTILLS: list[float] = []
"""Times in s from each kill to the last pulse."""
EARLY: list[str] = []
"""Refused starts, and stops before the kill: the computer was late."""


def load(seconds: float, spinners: int) -> list[str]:
    """Move back and forth while all cores are in use; return the errors."""
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        run = Run(Path(folder), watchdog_ms=500)
        for _ in range(spinners):
            spinner = subprocess.Popen([sys.executable, "-c", "while True: pass"])
            stack.callback(spinner.wait)
            stack.callback(spinner.kill)
        ends, moves, seen, wrong = time.monotonic() + seconds, 0, 0, []
        while time.monotonic() < ends:
            run.say(b"X%c2000 @ 4000 $ \r" % b"+-"[moves % 2], 2.5)
            moves += 1
            if len(run.stops()) > seen:
                seen = len(run.stops())
                run.program.stdin.write("go\n")
                run.program.stdin.flush()
                time.sleep(2.0)
        time.sleep(3.0)
        stops = run.stops()
        run.program.send_signal(signal.SIGINT)
        run.program.wait(30)
        journal = run.journal.read_text().splitlines()[-1]
        found = run.close()
    made = found["pulses"]["2"]
    net = sum(direction for _, direction in made)
    print(f"load: {moves} moves, {len(made)} pulses, net {net}, {len(stops)} stops, load {os.getloadavg()[0]:.1f}")
    print("\n".join(stops), end="\n" if stops else "")
    if len(stops) > 1:
        wrong.append(f"load: {len(stops)} stops")
    if journal != f"end table.X={net}":
        wrong.append(f"load: the journal ends with {journal!r}")
    if not stops and len(made) != 2000 * moves:
        wrong.append(f"load: {len(made)} of {2000 * moves} pulses")
    return wrong


def main() -> int:
    """Run both campaigns."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--load-s", type=float, default=600.0)
    parser.add_argument("--spinners", type=int, default=os.cpu_count() or 2)
    given = parser.parse_args()
    first = given.seed * 10_000
    wrong: list[str] = []
    for number, seed in enumerate(range(first, first + given.kills), 1):
        wrong += kill(seed)
        if number % 10 == 0:
            print(f"kills: {number}, {len(EARLY)} not started or stopped before, {len(wrong)} errors", flush=True)
    print("\n".join(EARLY), end="\n" if EARLY else "")
    if STANDSTILLS:
        print(f"kills: the last pulse was made {max(STANDSTILLS) * 1e3:.0f} ms after the kill or later bytes, at most")
    wrong += load(given.load_s, given.spinners) if given.load_s else []
    print("\n".join(wrong), end="\n" if wrong else "")
    print(f"{'FAILED' if wrong else 'held'}: {given.kills} kills, {given.load_s:g} s of load, seed {given.seed}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
