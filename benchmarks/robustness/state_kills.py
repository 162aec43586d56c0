"""Two processes that open one state directory, killed at random times between and during writes.

    python benchmarks/robustness/state_kills.py [--seed 1] [--rounds 100]

In each round two processes start at once, each with a SmartMotor that stores its memory in the same directory.  One
process must lock the directory; the other must end with a line that names the first.  The first process stores a
number that counts up until the process is killed: by SIGKILL after a random time, or at a random system call.  The
image is read during and after the round: it must be complete and contain the last stored number.  Afterwards the
directory must be unlocked.  Prints the errors and a verdict; the exit code is 1 if there are errors.
"""

import argparse
import json
import os
import random
import resource
import select
import signal
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "src"))

from axistwin import Bench
from axistwin.core.errors import UsageError

CALLS = ("open", "os.rename", "os.remove")
"""Audit events of a write in Python; `fsync` is between the first two."""
LONGEST_S, MOST_CALLS = 0.08, 60
IMAGE = "motor.json"


@dataclass(frozen=True)
class Worker:
    """A separate process that stores numbers."""

    pid: int
    told: int
    """Pipe with the lines that the process prints."""

    def lines(self) -> list[str]:
        """Return all lines until the end of the process."""
        with os.fdopen(self.told, closefd=True) as pipe:
            return pipe.read().splitlines()


def start(directory: Path, calls: int | None) -> Worker:
    """Start a process; it kills itself after `calls` system calls, counted from its lock of the directory."""
    read, write = os.pipe()
    pid = os.fork()
    if pid:
        os.close(write)
        return Worker(pid, read)
    os.close(read)
    try:
        work(directory, calls, write)
    finally:
        os._exit(1)


def work(directory: Path, calls: int | None, pipe: int) -> None:
    """Count up in the motor's EEPROM for ever; print each stored number."""
    bench = Bench()
    try:
        motor = bench.add("smartmotor", "motor", state=directory, line="instant")
    except UsageError as error:
        os.write(pipe, f"refused {error}\n".encode())
        os._exit(2)
    os.write(pipe, b"up\n")
    bench.run(0.3)
    motor.serial.write(b"EPTR=0 VLD(a,1) ")
    bench.run(0.01)
    if calls is not None:
        _die_after(calls)
    number = max(0, int.from_bytes(bytes.fromhex(_image(directory).get("eeprom") or "00"), "big"))
    while True:
        number += 1
        motor.serial.write(f"a={number} EPTR=0 VST(a,1) ".encode())
        bench.run(0.02)
        os.write(pipe, f"{number}\n".encode())


def _die_after(calls: int) -> None:
    left = [calls]

    def audit(event: str, _: object) -> None:
        if event in CALLS:
            left[0] -= 1
            if left[0] < 0:
                os.kill(os.getpid(), signal.SIGKILL)

    sys.addaudithook(audit)


def _image(directory: Path) -> dict[str, object]:
    """Return the present image; raise ValueError if it is incomplete."""
    try:
        text = (directory / IMAGE).read_text()
    except FileNotFoundError:
        return {}
    found: dict[str, object] = json.loads(text)
    return found


def stored(directory: Path) -> int:
    """Return the number in the image, -1 if there is none; raise ValueError if the image is incomplete."""
    eeprom = _image(directory).get("eeprom")
    return -1 if eeprom is None else int.from_bytes(bytes.fromhex(str(eeprom)), "big")


class Campaign:
    """All rounds of the campaign, in one state directory."""

    def __init__(self, directory: Path, seed: int) -> None:
        self.directory, self._chance = directory, random.Random(seed)
        self.looks = self.writes = 0
        self._least = -1

    def round(self) -> list[str]:
        """Run the next round; return its errors."""
        by_call = self._chance.random() < 0.5
        calls = self._chance.randrange(MOST_CALLS) if by_call else None
        both = [start(self.directory, calls) for _ in range(2)]
        wrong = self._watch(both, LONGEST_S * 20 if by_call else self._chance.random() * LONGEST_S)
        said = {worker.pid: worker.lines() for worker in both}
        wrong += self._who(said)
        kept = max((int(line) for lines in said.values() for line in lines if line.isdecimal()), default=-1)
        self.writes += sum(line.isdecimal() for lines in said.values() for line in lines)
        now = self._look(wrong)
        if now < kept:
            wrong.append(f"{kept} was stored, the image holds {now}")
        return wrong

    def _watch(self, both: Sequence[Worker], seconds: float) -> list[str]:
        """Read the image until both processes have ended; after `seconds`, kill the processes that still run."""
        wrong: list[str] = []
        for worker in both:
            select.select([worker.told], [], [], 30)
        alive, end_s = {worker.pid for worker in both}, time.monotonic() + seconds
        while alive:
            for pid in tuple(alive):
                if os.waitpid(pid, os.WNOHANG)[0]:
                    alive.discard(pid)
            self._look(wrong)
            if time.monotonic() > end_s:
                for pid in alive:
                    os.kill(pid, signal.SIGKILL)
        return wrong

    def _look(self, wrong: list[str]) -> int:
        self.looks += 1
        try:
            now = stored(self.directory)
        except ValueError as error:
            wrong.append(f"the image is not whole: {error}")
            return self._least
        if now < self._least:
            wrong.append(f"the image went back from {self._least} to {now}")
        self._least = max(now, self._least)
        return now

    def _who(self, said: dict[int, list[str]]) -> list[str]:
        """Return errors: a refused process must print one line, which names the other process."""
        up = [pid for pid, lines in said.items() if lines[:1] == ["up"]]
        refused = {pid: lines for pid, lines in said.items() if pid not in up}
        wrong = [f"process {pid} said {lines}" for pid, lines in refused.items() if len(lines) != 1]
        if not up:
            wrong.append(f"nobody got the directory: {said}")
        for pid, lines in refused.items():
            others = (f"in use by process {other} (" for other in up)
            if not any(other in lines[0] for other in others) and "in use by another process:" not in lines[0]:
                wrong.append(f"process {pid} was told {lines[0]!r}, and {up} had it")
        return wrong


def main(arguments: Sequence[str] | None = None) -> int:
    """Run all rounds."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--rounds", type=int, default=100)
    given = parser.parse_args(arguments)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    found = 0
    with TemporaryDirectory() as directory:
        campaign = Campaign(Path(directory), given.seed)
        for number in range(given.rounds):
            for told in campaign.round():
                found += 1
                print(f"round {number}: {told}", flush=True)
        left = [file.name for file in Path(directory).glob("*.new")]
        if len(left) > 1:
            found += 1
            print(f"left behind: {', '.join(left)}")
    verdict = "passed" if not found else "FAILED"
    print(f"{verdict}: {given.rounds} rounds, seed {given.seed}: {found} wrong in {campaign.looks} looks, ", end="")
    print(f"{campaign.writes} writes")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
