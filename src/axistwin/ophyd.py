"""Devices of ophyd-async on the drivers: axes of real and virtual controllers in bluesky's plans.

    controller = Controller("socket://127.0.0.1:5001", "if1")
    x = controller.motor("X", name="x", counts_per_unit=400, unit="mm")
    RE(bp.scan([detector], x, 0, 10, 11))

Needs the extra `[ophyd]`.
"""

from collections.abc import AsyncGenerator
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from bluesky.protocols import Location, Stoppable, Triggerable
from ophyd_async.core import (
    AsyncLocatable,
    AsyncStatus,
    StandardReadable,
    StandardReadableFormat,
    WatchableAsyncStatus,
    WatcherUpdate,
    soft_signal_r_and_setter,
)

from axistwin.drivers.arguments import positive
from axistwin.drivers.asynchronous import AsyncAxis, AsyncController
from axistwin.drivers.axis import Scale, Status
from axistwin.drivers.blocking import arrived, nothing
from axistwin.drivers.errors import RefusedError
from axistwin.drivers.models import MODELS, make

if TYPE_CHECKING:
    from axistwin.bench import Bench

POLL_S = 0.05


class Controller:
    """A controller whose axes are motors of ophyd-async.

    The arguments are those of `axistwin.drivers.connect`.  The port is opened when the first motor is connected.
    """

    def __init__(self, url: str, model: Any, *, baud: int | None = None, **options: Any) -> None:
        self.driver = AsyncController(url, make(_described(model), options), baud)
        self._connected = False

    @classmethod
    def inside(cls, bench: "Bench", name: str, **options: Any) -> "Controller":
        """Return a connection to the virtual controller `name` of the simulation `bench`.

        Virtual time passes only while the driver waits, so a scan takes almost no real time.  `options`: options of the
        driver.  Raises UsageError.
        """
        from axistwin.real.integrations import driver_inside  # lazy import: only virtual controllers need the emulator

        made = cls.__new__(cls)
        made.driver, made._connected = driver_inside(bench, name, **options), False
        return made

    def motor(
        self, axis: str, name: str = "", *, counts_per_unit: float = 1.0, unit: str = "counts", poll_s: float = POLL_S
    ) -> "Motor":
        """Return an axis as a motor of ophyd-async.  Raises RefusedError if the controller has no such axis."""
        if axis not in self.driver.axes:
            raise RefusedError(f"no axis {axis!r}: expected one of {', '.join(self.driver.axes)}")
        found = self.driver.axes[axis]
        found.scale = Scale(counts_per_unit, unit)
        return Motor(self, found, name, positive("poll_s", poll_s))

    async def connect(self) -> None:
        """Open the port and find the controller."""
        if not self._connected:
            await self.driver.run(nothing())
            self._connected = True

    async def close(self) -> None:
        """Close the port.  A motion in progress continues."""
        self._connected = False
        await self.driver.close()


def _described(model: Any) -> Any:
    """Return what `make` takes for the name of a device of others."""
    if isinstance(model, str) and model not in MODELS:
        from axistwin.bench.models import is_model, product  # lazy import: our drivers do not need the emulator

        return product(model).driver if is_model(model) else model
    return model


class Motor(StandardReadable, AsyncLocatable[float], Stoppable, Triggerable):
    """An ophyd-async device that moves one controller axis, e.g. in a bluesky plan."""

    def __init__(self, controller: Controller, axis: AsyncAxis, name: str, poll_s: float) -> None:
        self.controller, self.axis, self._poll_s = controller, axis, poll_s
        self._stopped_well = False
        """True after a `stop` that counts as the success of the move."""
        unit = axis.scale.unit
        with self.add_children_as_readables(StandardReadableFormat.HINTED_SIGNAL):
            self.readback, self._set_readback = soft_signal_r_and_setter(float, units=unit)
        with self.add_children_as_readables():
            self.setpoint, self._set_setpoint = soft_signal_r_and_setter(float, units=unit)
        super().__init__(name=name)

    def set_name(self, name: str, *, child_name_separator: str | None = None) -> None:
        """Set the name of the motor and of its readback signal."""
        super().set_name(name, child_name_separator=child_name_separator)
        self.readback.set_name(name)

    async def connect(self, mock: Any = False, timeout: float = 10.0, force_reconnect: bool = False) -> None:
        """Open the port of the controller.  `mock`: True for a simulated motor, which has no port."""
        await super().connect(mock, timeout, force_reconnect)
        if not mock:
            await self.controller.connect()
            await self._update()

    async def _update(self) -> Status:
        status = await self.axis.status()
        self._set_readback(status.known_position())
        self._set_setpoint(status.setpoint)
        return status

    @AsyncStatus.wrap
    async def trigger(self) -> None:
        """Read the position of the motor.  A plan can use the motor as a detector."""
        await self._update()

    @WatchableAsyncStatus.wrap
    async def set(self, value: float) -> AsyncGenerator[WatcherUpdate[float]]:
        """Move to a position and wait for the arrival.

        Raises StoppedError if a limit, a fault, another host, a stop or another move ends the move.
        """
        initial = (await self._update()).position
        self._stopped_well = False
        await self.axis.move_to(value)
        target = self.axis.core.target
        while True:
            status = await self._update()
            yield WatcherUpdate(status.position, initial, value, self.name, self.axis.scale.unit)
            if not status.moving:
                break
            await self.controller.driver.clock.pause(self._poll_s)
        if self.axis.core.target != target and not self._stopped_well:
            why = "the target was not reached (a stop or another move ended the move: begin the motion again)"
            status = replace(status, missed=why)
        arrived(self.name, status)

    async def stop(self, success: bool = False) -> None:
        """Decelerate and wait until at rest.  `success`: True if the stopped move counts as successful."""
        self._stopped_well = success
        await self.axis.stop()
        while (await self._update()).moving:
            await self.controller.driver.clock.pause(self._poll_s)

    async def locate(self) -> Location[float]:
        """Return the setpoint and the position of the axis."""
        status = await self._update()
        return {"setpoint": status.setpoint, "readback": status.position}
