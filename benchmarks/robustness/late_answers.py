"""Answers that arrive late, also after the driver has given up: an answer belongs to the question that was asked.

    python benchmarks/robustness/late_answers.py --seed 17 --runs 900

Each run moves an axis twice; from a random message on, for a random time, everything from the controller arrives late.
Errors that say so are expected, and the driver is asked again.  At the end, it must know the true position, without a
fault.  Virtual time only.  The exit code is 1 if not.
"""

import argparse
import asyncio
import random
import sys
from collections import Counter, deque
from contextlib import suppress

from axistwin import Bench
from axistwin.drivers import AsyncController, DriverError, StoppedError, make
from axistwin.real.integrations import InnerPort

AXES = {"if1": "X", "1811": "motor", "smartmotor": "shaft"}
WINDOWS_S = (0.01, 0.05, 0.3, 1.0, 3.0)
LATE_S = (0.02, 0.15, 0.27, 0.35, 0.6, 1.1, 2.3, 5.0, 9.0)
TRIES = 40


class LatePort(InnerPort):
    """A port; from a message on, for `window_s`, what is received arrives `late_s` later, in its order."""

    def __init__(self, bench: Bench, name: str, message: int, window_s: float, late_s: float) -> None:
        super().__init__(bench, name)
        self._left, self._window_s, self._late_s = message, window_s, late_s
        self._until, self._due = 0.0, 0.0
        self._waiting: deque[tuple[float, bytes]] = deque()

    async def write(self, data: bytes) -> None:
        """Send bytes to the controller."""
        self._left -= 1
        if not self._left:
            self._until = self.time() + self._window_s
        await super().write(data)

    async def read(self, timeout: float) -> bytes:
        """Return what has arrived within `timeout` seconds."""
        end = self.time() + timeout
        while not (arrived := self._arrived()) and self.time() < end:
            await self.pause(0.002)
        return arrived

    def _arrived(self) -> bytes:
        if self._received:
            now = self.time()
            self._due = max(self._due, now + (self._late_s if now < self._until else 0.0))
            self._waiting.append((self._due, bytes(self._received)))
            self._received.clear()
        found = b""
        while self._waiting and self._waiting[0][0] <= self.time():
            found += self._waiting.popleft()[1]
        return found


async def run(model: str, message: int, window_s: float, late_s: float) -> str:
    """Move twice with late answers; return what is wrong at the end, "" if nothing is."""
    bench = Bench()
    twin = bench.add(model).axes[AXES[model]]

    async def opening() -> LatePort:
        return LatePort(bench, model, message, window_s, late_s)

    driver = AsyncController("", make(model, {}), opening=opening)
    axis = driver.axes[AXES[model]]
    for target in (300, 700):
        for _ in range(TRIES):
            try:
                await axis.move_to(target)
                await axis.wait(30)
                break
            except StoppedError as error:
                if error.status.lost or error.status.faults:
                    break
            except DriverError:
                pass
    for _ in range(TRIES):
        with suppress(DriverError):
            status = await axis.status()
            break
    await driver.close()
    if (status.position, status.lost, status.faults, twin.position) == (700, "", (), 700):
        return ""
    return f"{model} {message} {window_s} {late_s}: {status}, true position {twin.position}"


def main() -> bool:
    """Print the verdict."""
    arguments = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    arguments.add_argument("--seed", type=int, default=17)
    arguments.add_argument("--runs", type=int, default=900)
    given = arguments.parse_args()
    chance, wrong, runs = random.Random(given.seed), [], Counter()
    for number in range(given.runs):
        model = list(AXES)[number % len(AXES)]
        found = asyncio.run(run(model, chance.randrange(1, 90), chance.choice(WINDOWS_S), chance.choice(LATE_S)))
        runs[model] += 1
        wrong += [found] if found else []
    print(*wrong[:20], sep="\n")
    print(f"{dict(runs)}, {len(wrong)} wrong: {'failed' if wrong else 'passed'}")
    return bool(wrong)


if __name__ == "__main__":
    sys.exit(main())
