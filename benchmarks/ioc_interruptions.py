"""Stops, pauses, cut lines and power cuts at random moments: a motor record never has a stuck DMOV or a wrong RBV.

    python benchmarks/ioc_interruptions.py --seed 17 --runs 1000

Each run writes VAL, RLV, JOGF or JOGR of a motor record of a virtual controller, and interrupts the motion.  The write
must then be answered with DMOV 1 within 10 s, and RBV must be the position of the twin; after a power cut the record
must be in an alarm instead.  The exit code is 1 if not.
"""

import argparse
import asyncio
import random
import sys
import time
from collections import Counter
from collections.abc import Awaitable, Callable
from contextlib import suppress

from axistwin import Bench
from axistwin.drivers import DriverError, SilentError
from axistwin.real.integrations import Station, of_scene
from axistwin.real.integrations.epics.motor_record import MotorRecord

AXES = {"if1": "X", "1811": "motor", "smartmotor": "shaft"}
ACTS = ("stop", "abort", "pause", "cut", "new target", "power")
LONGEST_S = 10.0


class Runs:
    """Runs with one controller."""

    def __init__(
        self, model: str, station: Station, bench: Bench, drop: Callable[[str], None], chance: random.Random
    ) -> None:
        self.model, self.bench, self.drop, self.chance = model, bench, drop, chance
        self.record = MotorRecord(station.axes[AXES[model]], model, model)
        self.station = station
        self.acts: Counter[str] = Counter()
        self.wrong: list[str] = []
        self.slowest_s = 0.0
        self.offset = 0

    @property
    def true(self) -> int:
        """Position of the twin."""
        return self.bench[self.model].axes[AXES[self.model]].position - self.offset

    async def all(self, runs: int) -> None:
        """Execute runs."""
        await self.record.put("VELO", min(self.record.values["VMAX"], 20_000))
        await self.record.put("JVEL", 10_000)
        for number in range(runs):
            act = self.chance.choices(ACTS, (4, 2, 3, 4, 3, 1))[0]
            self.acts[act] += 1
            try:
                async with asyncio.timeout(LONGEST_S):
                    await self.one(act)
            except TimeoutError:
                self.wrong.append(f"{self.model} run {number}, {act}: DMOV is {self.record.values['DMOV']}")
                continue
            values = self.record.values
            if not values["DMOV"] or (values["RBV"] != self.true and values["SEVR"] != 3):
                self.wrong.append(f"{self.model} run {number}, {act}: RBV {values['RBV']}, true {self.true}")

    async def one(self, act: str) -> None:
        """Begin a motion, interrupt it, and wait for its end."""
        record, chance = self.record, self.chance
        begun = time.monotonic()
        field = chance.choice(("VAL", "VAL", "RLV", "JOGF", "JOGR"))
        value = 1 if field.startswith("JOG") else chance.randrange(-30_000, 30_000)
        motion = asyncio.create_task(record.put(field, value))
        await asyncio.sleep(chance.uniform(0, 0.05))
        await self.interrupt(act, jogs=field.startswith("JOG"))
        with suppress(DriverError):
            await motion
        self.slowest_s = max(self.slowest_s, time.monotonic() - begun)
        if act == "power":
            while record.values["STAT"] not in ("UDF", "NO_ALARM"):  # until the controller answers again
                record.axis.station.wake()
                await record.axis.station.polled()
            self.offset += self.true
            await again(record.axis.clear_faults)
            await again(lambda: record.axis.set_position(0))

    async def interrupt(self, act: str, *, jogs: bool) -> None:
        """Interrupt a motion, and end a jog."""
        record, chance = self.record, self.chance
        with suppress(DriverError):
            if act == "abort":
                await record.axis.stop(abort=True)
            elif act == "pause":
                await record.put("SPMG", "Pause")
                await asyncio.sleep(chance.uniform(0, 0.02))
                await record.put("SPMG", "Go")
            elif act == "cut":
                self.drop(self.model)
            elif act == "new target":
                await record.put("RLV", chance.randrange(-5_000, 5_000))
            elif act == "power":
                self.bench[self.model].power_cycle()
        while act == "stop" or jogs:
            try:
                await record.put("STOP", 1)
                return
            except DriverError:
                await asyncio.sleep(0.01)


async def again(act: Callable[[], Awaitable[None]]) -> None:
    """Repeat an act until the controller answers, which takes longer on a loaded computer."""
    while True:
        with suppress(SilentError):
            return await act()


async def campaign(seed: int, runs: int) -> bool:
    """Print the verdict."""
    bench = Bench()
    for model in AXES:
        bench.add(model, **({"self_test_s": 0.1} if model == "if1" else {}))
    machine = await of_scene(bench, {name: {"timeout": 0.5} for name in AXES}, speed=20.0, period_s=0.02)

    def drop(name: str) -> None:
        for endpoint in machine._server._endpoints:
            if endpoint.name == name and endpoint.client is not None:
                endpoint.client.drop()

    found = []
    async with machine:
        polling = asyncio.create_task(machine.run())
        for station in machine.stations:
            station.driver.core.axes[AXES[station.name]].velocity = 20_000
            chance = random.Random(f"{seed} {station.name}")
            found.append(Runs(station.name, station, bench, drop, chance))
        await asyncio.gather(*(one.all(runs // len(found)) for one in found))
        polling.cancel()
        await asyncio.wait([polling])
    wrong = [line for one in found for line in one.wrong]
    for one in found:
        print(f"{one.model}: {dict(one.acts)}, slowest {one.slowest_s:.2f} s, wrong {len(one.wrong)}")
    print(*wrong[:20], sep="\n")
    print(f"{runs} runs, {len(wrong)} wrong: {'failed' if wrong else 'passed'}")
    return bool(wrong)


def main() -> bool:
    """Read the command line, and run."""
    given = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    given.add_argument("--seed", type=int, default=17)
    given.add_argument("--runs", type=int, default=1000)
    arguments = given.parse_args()
    return asyncio.run(campaign(arguments.seed, arguments.runs))


if __name__ == "__main__":
    sys.exit(main())
