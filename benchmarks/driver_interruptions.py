"""Stops, aborts, cut lines and power cuts at random moments: a driver never returns a wrong position.

    python benchmarks/driver_interruptions.py --seed 17 --runs 1000

Each run begins a motion of a virtual controller at a served port, interrupts it, and waits for its end.  The position
of the driver must then be that of the twin.  It may be lost after power cuts only.  The exit code is 1 if not.
"""

import argparse
import random
import sys
import time
from collections import Counter

import axistwin
from axistwin.drivers import DriverError, PortError, Status, connect

AXES = {"if1": "X", "1811": "motor", "smartmotor": "shaft"}
ACTS = ("stop", "abort", "cut", "cut while a request is sent", "power")
RATES = {"if1": (2_000, 20_000), "1811": (5_000, 50_000), "smartmotor": (4_000, 40_000)}


class Run:
    """Runs with one controller."""

    def __init__(self, model: str, chance: random.Random) -> None:
        self.model, self.chance = model, chance
        self.found: Counter[str] = Counter()
        self.wrong: list[str] = []
        self.slowest_s = 0.0

    def all(self, runs: int) -> None:
        """Execute runs; each power cut is followed by a new definition of the position."""
        with axistwin.serve(self.model, speed=20.0) as twin:
            url = next(iter(twin.ports.values()))
            with connect(url, self.model) as controller:
                self.twin, self.controller = twin, controller
                self.axis = controller.axes[AXES[self.model]]
                self.axis.set_profile(*RATES[self.model])
                self.offset = self.true() - round(self.axis.position())
                for number in range(runs):
                    self.one(number)

    def true(self) -> int:
        """Return the position of the twin."""
        board = next(iter(self.twin.bench.controllers.values()))
        return self.twin.do(lambda: board.axes[AXES[self.model]].position)

    def one(self, number: int) -> None:
        """Begin a motion, interrupt it, compare."""
        chance, axis = self.chance, self.axis
        act = chance.choices(ACTS, (4, 4, 4, 4, 1))[0]
        if chance.random() < 0.5:
            axis.move_by(chance.randrange(-20_000, 20_000))
        else:
            axis.move_at(chance.choice((-1, 1)) * chance.uniform(300, 2_000))
        time.sleep(chance.uniform(0, 0.03))
        self.interrupt(act)
        status = self.end(act)
        self.found[act] += 1
        true = self.true() - self.offset
        if status.lost and act == "power":
            axis.clear_faults()
            axis.set_position(true)
        elif status.lost or status.moving or round(status.position) != true:
            self.wrong.append(f"{self.model} run {number}, {act}: {status}, true position {true}")
            axis.set_position(true)

    def interrupt(self, act: str) -> None:
        """Do what interrupts a motion."""
        if act in ("stop", "abort"):
            getattr(self.axis, act)()
        elif act == "cut":
            self.controller._port._port._socket.shutdown(2)
        elif act == "power":
            board = next(iter(self.twin.bench.controllers.values()))
            self.twin.do(board.power_cycle)
        else:
            request = {"if1": b"X1", "1811": b"w 0 3", "smartmotor": b"P=1"}[self.model]
            self.controller._port.write(request)
            self.controller._port._port._socket.shutdown(2)

    def end(self, act: str) -> Status:
        """Return the status at the end of the motion; errors of the interruption are expected."""
        self.controller.core.timeout = 0.3 if act == "power" else 3.0
        begun, stopped = time.monotonic(), act in ("stop", "abort", "power")
        while time.monotonic() - begun < 20:
            try:
                if not stopped:
                    self.axis.stop()
                    stopped = True
                status = self.axis.status()
                if not status.moving:
                    self.slowest_s = max(self.slowest_s, time.monotonic() - begun)
                    return status
            except DriverError as error:
                if isinstance(error, PortError) and act not in ACTS[2:4]:
                    raise
                self.found[type(error).__name__] += 1
        return self.axis.status()


def main() -> bool:
    """Print the verdict."""
    arguments = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    arguments.add_argument("--seed", type=int, default=17)
    arguments.add_argument("--runs", type=int, default=1000)
    arguments.add_argument("--models", default=",".join(AXES))
    given = arguments.parse_args()
    wrong: list[str] = []
    models = given.models.split(",")
    for model in models:
        run = Run(model, random.Random(f"{given.seed} {model}"))
        run.all(given.runs // len(models))
        wrong += run.wrong
        print(f"{model}: {dict(run.found)}, slowest end {run.slowest_s:.2f} s, wrong {len(run.wrong)}", flush=True)
    print(*wrong[:20], sep="\n")
    print(f"{given.runs} runs, {len(wrong)} wrong: {'failed' if wrong else 'passed'}")
    return bool(wrong)


if __name__ == "__main__":
    sys.exit(main())
