"""PV Access by p4p: the same records as normative types, NTScalar and NTEnum."""

import os
import time
from collections.abc import Awaitable, Callable, Sequence
from typing import Any

from p4p import logLevelOff
from p4p._p4p import logger_level_set
from p4p.nt import NTEnum, NTScalar
from p4p.server import Server, ServerOperation
from p4p.server.asyncio import SharedPV

from axistwin.drivers.errors import DriverError
from axistwin.real.integrations.epics.channel_access import LOOPBACK
from axistwin.real.integrations.epics.fields import MOTOR, NO_YES, Field, Kind, called
from axistwin.real.integrations.epics.motor_record import MotorRecord
from axistwin.real.integrations.epics.state import Alarm
from axistwin.real.integrations.pins_and_registers import Point

CODES = {Kind.DOUBLE: "d", Kind.LONG: "i", Kind.STRING: "s", Kind.TEXT: "s"}
STATUSES = {"NO_ALARM": 0, "STATE": 1, "COMM": 3, "UDF": 6}  # Classes of alarms: device, driver, undefined.
Put = Callable[[Any], Awaitable[None]]


class _Channel:
    def __init__(self, field: Field, value: Any, put: Put | None) -> None:
        self._menu, self._put = field.menu, put
        self._nt = NTEnum() if field.menu else NTScalar(CODES[field.kind], display=True)
        initial = {"index": value, "choices": list(field.menu)} if field.menu else value
        self.pv = SharedPV(nt=self._nt, initial=self._nt.wrap(initial), handler=self)

    async def put(self, pv: SharedPV, operation: ServerOperation) -> None:  # noqa: ARG002
        if self._put is None:
            operation.done(error="this field can only be read")
            return
        raw = operation.value().raw
        if not raw.changed("value.index" if self._menu else "value"):  # else its default, 0, would be a new target
            operation.done(error="no value: only the value can be written")
            return
        try:
            await self._put(int(raw.value.index) if self._menu else raw.value)
        except DriverError as error:
            operation.done(error=str(error))
        else:
            operation.done()

    def post(self, value: Any, alarm: Alarm, extra: dict[str, Any]) -> None:
        changed = self.pv.current().raw
        changed.unmark()
        if self._menu:
            changed.value.index = value
        else:
            changed.value = value
        changed.alarm.severity = MOTOR["SEVR"].menu.index(alarm.severity)
        changed.alarm.status, changed.alarm.message = STATUSES[alarm.status], alarm.status
        for name, given in extra.items():
            changed[name] = given
        seconds = time.time()
        changed.timeStamp.secondsPastEpoch = int(seconds)
        changed.timeStamp.nanoseconds = int(seconds % 1 * 1e9)
        self.pv.post(changed)


class _Motor:
    def __init__(self, record: MotorRecord) -> None:
        self._record = record
        self.channels = {name: self._channel(name, field) for name, field in MOTOR.items()}
        record.observers.append(self.post)

    def _channel(self, name: str, field: Field) -> _Channel:
        async def put(value: Any) -> None:
            await self._record.put(name, value)

        return _Channel(field, self._record.values[name], put if self._record.writable(name) else None)

    async def post(self, name: str, value: Any) -> None:
        """Publish a field; "": the alarm and the metadata."""
        record = self._record
        if name:
            self.channels[name].post(value, record.alarm, {})
            return
        values = record.values
        extra = {"display.units": values["EGU"]}
        for one in ("VAL", "RBV"):
            self.channels[one].post(values[one], record.alarm, extra)


class PvAccess:
    """A server for PV Access.  Use within a running event loop: `with server.open():`."""

    def __init__(self, addresses: Sequence[str] = (LOOPBACK,), port: int | None = None) -> None:
        self._addresses, self._port = list(addresses), port
        self._motors: list[_Motor] = []
        self._channels: dict[str, SharedPV] = {}

    def add_motor(self, record: MotorRecord) -> None:
        motor = _Motor(record)
        self._motors.append(motor)
        self._channels[record.name] = motor.channels["VAL"].pv
        for name, channel in motor.channels.items():
            self._channels[called(record.name, name)] = channel.pv

    def add_point(self, name: str, point: Point) -> None:
        field = Field(Kind.MENU, 0, NO_YES) if point.bit else Field(Kind.LONG, 0)

        async def put(value: Any) -> None:
            await point.write(int(value))

        channel = _Channel(field, point.value or 0, put if point.writable else None)

        async def post(value: int) -> None:
            channel.post(value, Alarm(), {})

        point.observers.append(post)
        self._channels[name] = channel.pv

    async def open(self) -> Server:
        """Start and return the server, which runs until the caller stops it.  Raises OSError if it cannot listen."""
        for motor in self._motors:
            await motor.post("", None)
        here = all(address == LOOPBACK for address in self._addresses)
        given = {name: value for name, value in os.environ.items() if name.startswith("EPICS_PVA")}
        given |= {"EPICS_PVAS_INTF_ADDR_LIST": " ".join(self._addresses)}
        if here:
            # Send EPICS beacons (announcements of the server) only to this computer.
            given |= {"EPICS_PVAS_AUTO_BEACON_ADDR_LIST": "NO", "EPICS_PVAS_BEACON_ADDR_LIST": LOOPBACK}
        if self._port is not None:
            given |= {"EPICS_PVAS_SERVER_PORT": str(self._port), "EPICS_PVAS_BROADCAST_PORT": str(self._port + 1)}
        if "PVXS_LOG" not in os.environ:
            # The library would write each invalid message of a client to stderr, some with a stack trace of 2 KB.
            logger_level_set("pvxs.tcp.*", logLevelOff - 1)  # which includes CRIT
        try:
            return Server(providers=[self._channels], conf=given, useenv=False)  # with useenv the environment would win
        except RuntimeError as error:
            raise OSError(str(error)) from None
