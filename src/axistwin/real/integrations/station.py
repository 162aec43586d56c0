"""A controller with its driver, polled at a constant rate."""

import asyncio
from collections.abc import Mapping
from contextlib import suppress
from fractions import Fraction

from axistwin.drivers.asynchronous import AsyncController
from axistwin.drivers.errors import DriverError
from axistwin.plant.machine_units import MachineUnits
from axistwin.real.integrations.driven_axis import DrivenAxis
from axistwin.real.integrations.pins_and_registers import Point, points_of

POINTS_S = 0.5  # Interval at which pins and registers are read, in seconds.
COUNTS = MachineUnits(Fraction(1), "counts")


class Station:
    """A controller.  `units`: units of its axes by name; `registers`: see `points_of`."""

    def __init__(
        self, name: str, model: str, driver: AsyncController, units: Mapping[str, MachineUnits] | None = None,
        registers: tuple[str, ...] = (),
    ) -> None:  # fmt: skip
        self.name, self.model, self.driver = name, model, driver
        self.axes = {axis: DrivenAxis(self, axis, (units or {}).get(axis, COUNTS)) for axis in driver.axes}
        self.points: list[Point] = points_of(driver, registers)
        self._wake, self._polled = asyncio.Event(), asyncio.Event()
        self._points_due = 0.0

    def wake(self) -> None:
        self._wake.set()

    async def polled(self) -> None:
        await self._polled.wait()

    async def poll_forever(self, period_s: float) -> None:
        """Poll the axes every `period_s` seconds, and the pins every half second."""
        loop = asyncio.get_running_loop()
        while True:
            due = loop.time() + period_s
            self._wake.clear()
            await self.poll()
            with suppress(TimeoutError):
                async with asyncio.timeout_at(due):
                    await self._wake.wait()

    async def poll(self) -> None:
        """Read the status of all axes.  Pins and registers are read only every half second."""
        polled, self._polled = self._polled, asyncio.Event()
        try:
            found = await self.driver.run(self.driver.core.statuses())
            for name, axis in self.axes.items():
                await axis.update(found[name])
            await self._read_points()
        except DriverError as error:
            for axis in self.axes.values():
                await axis.failed(error)
        polled.set()

    async def _read_points(self) -> None:
        now = asyncio.get_running_loop().time()
        if now >= self._points_due:
            self._points_due = now + POINTS_S
            for point in self.points:
                await point.refresh()

    async def close(self) -> None:
        """Cancel the motions that have not begun, and close the port.  A motion in progress continues."""
        for axis in self.axes.values():
            axis.close()
        await self.driver.close()
