"""An IOC: the records of a machine on the servers of EPICS."""

import asyncio
import logging
import warnings
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

from axistwin.real.integrations.driven_scene import Machine, tell_failure
from axistwin.real.integrations.epics.channel_access import LOOPBACK, ChannelAccess
from axistwin.real.integrations.epics.motor_record import MotorRecord

if TYPE_CHECKING:
    from axistwin.real.integrations.epics.pv_access import PvAccess

LONGEST_NAME = 60  # Longest name of a record in EPICS.


class Ioc:
    """The EPICS records of all controllers of a machine; for use in a running event loop, once connected."""

    def __init__(self, machine: Machine, prefix: str) -> None:
        self.machine = machine
        self.motors: list[MotorRecord] = []
        self.points = {}
        for station in machine.stations:
            base = f"{prefix}{station.name}"
            for name, axis in station.axes.items():
                self.motors.append(MotorRecord(axis, f"{base}:{name}", f"{station.name} {name}"))
            for point in station.points:
                self.points[f"{base}:{point.name.replace('.', ':')}"] = point

    @property
    def names(self) -> list[str]:
        return [*(motor.name for motor in self.motors), *self.points]

    @asynccontextmanager
    async def serving(
        self, addresses: Sequence[str] = (LOOPBACK,), port: int | None = None, *, pv_access: bool = False
    ) -> AsyncIterator[str]:
        """Serve the records and poll the machine; yields the address of Channel Access."""
        # Suppress the log messages of the library caproto, e.g. about refused writes of EPICS clients.
        logging.getLogger("caproto").setLevel(logging.CRITICAL)
        warnings.filterwarnings("ignore", module=r"caproto\.")  # about what clients ask for
        server = ChannelAccess(addresses, port)
        self._add_to(server)
        other = None
        if pv_access:
            # lazy import: only the protocol PV Access needs the library p4p
            from axistwin.real.integrations.epics.pv_access import PvAccess

            shared = PvAccess(addresses, None if port is None else port + 11)
            self._add_to(shared)
            other = await shared.open()
        tasks = [asyncio.ensure_future(one) for one in (self.machine.run(), server.run())]
        try:
            started = asyncio.ensure_future(server.started())
            await asyncio.wait([started, *tasks], return_when=asyncio.FIRST_COMPLETED)
            for task in tasks:
                if task.done():
                    started.cancel()
                    task.result()
                task.add_done_callback(tell_failure)
            yield started.result()
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            if other is not None:
                other.stop()

    def _add_to(self, server: "ChannelAccess | PvAccess") -> None:
        for motor in self.motors:
            server.add_motor(motor)
        for name, point in self.points.items():
            server.add_point(name, point)
