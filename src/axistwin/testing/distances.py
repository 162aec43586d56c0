"""The check of a controller's motion: its driver moves each axis, and the machine is measured."""

import asyncio
from random import Random
from typing import Any

from axistwin.bench import Bench
from axistwin.controllers.product import Product
from axistwin.drivers.errors import DriverError
from axistwin.real.integrations import driver_inside

MOVES = 6
FARTHEST = 600  # Counts: a few seconds at the speed that the drivers use.
LONGEST_S = 120.0


def check_distances(product: Product, rng: Random) -> None:
    """Move each axis to some places and back, and stop it in motion.  Raises AssertionError."""
    bench = Bench()
    bench.clock.patient = False
    controller = bench.add(product)
    bench.run(3.0)
    asyncio.run(_drive(bench, controller, rng))


async def _drive(bench: Bench, controller: Any, rng: Random) -> None:
    async with driver_inside(bench, controller.name) as driver:
        for name, axis in driver.axes.items():
            await _move(f"{controller.product.model}, axis {name}", axis, controller.axes[name], rng)


async def _move(what: str, axis: Any, machine: Any, rng: Random) -> None:
    try:
        zero = await axis.position() - machine.position
        for target in [*(rng.randint(-FARTHEST, FARTHEST) for _ in range(MOVES)), 0]:
            begin_ns, begin = machine.clock.now + 1, machine.position
            await axis.move_to(target)
            await axis.wait(LONGEST_S)
            made = machine.position - begin
            _agree(what, f"after a move to {target}", await axis.position(), target, machine.position + zero)
            pulses = len(machine.pulse_times(begin_ns)) if hasattr(machine, "train") else abs(made)
            if pulses != abs(made):
                raise AssertionError(f"{what}: a move of {made} has made {pulses} pulses: move without a detour")
        await axis.move_to(20 * FARTHEST)
        await axis.controller.clock.pause(rng.uniform(0.1, 0.6))
        await axis.stop()
        while (await axis.status()).moving:
            await axis.controller.clock.pause(0.02)
        position = await axis.position()
        _agree(what, "after a stop in motion", position, position, machine.position + zero)
    except DriverError as error:
        raise AssertionError(f"{what}: {error}") from None


def _agree(what: str, when: str, reported: float, target: float, real: float) -> None:
    if not reported == target == real:
        raise AssertionError(
            f"{what} {when}: it reports {reported:g}, and the machine is at {real:g}: report the position of the "
            "Positioner, which counts what the machine has made"
        )
