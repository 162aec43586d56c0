"""Channel Access by caproto: channels of motor records, pins and registers.

Clients read and write channels; a write is processed by the record, and an answer with callback is sent when the record
has finished.
"""

import asyncio
import os
from collections.abc import Awaitable, Callable, Sequence
from contextlib import suppress
from typing import Any

from caproto import (
    DISCONNECTED,
    AccessRights,
    AlarmSeverity,
    AlarmStatus,
    CaprotoNetworkError,
    ChannelAlarm,
    ChannelChar,
    ChannelData,
    ChannelDouble,
    ChannelEnum,
    ChannelInteger,
    ChannelString,
    ChannelType,
    ClearChannelRequest,
    EventAddResponse,
    LocalProtocolError,
    WriteNotifyResponse,
    native_type,
)
from caproto._data import SubscriptionUpdate, _channel_type_by_name
from caproto.asyncio.server import Context, VirtualCircuit
from caproto.server.common import DisconnectedCircuit, Subscription

from axistwin.drivers.errors import RefusedError
from axistwin.real.integrations.epics.fields import MOTOR, NO_YES, Field, Kind, called
from axistwin.real.integrations.epics.motor_record import MotorRecord
from axistwin.real.integrations.pins_and_registers import Point

LOOPBACK = "127.0.0.1"
MOST_CLIENTS = 200
MOST_BYTES = 16384  # Longest incomplete message of a client; EPICS' own limit without EPICS_CA_MAX_ARRAY_BYTES.
Put = Callable[[Any], Awaitable[None]]


class Channel(ChannelData):
    """One process variable; a record processes its writes.  `put` is None if it can only be read."""

    put: Put | None = None

    def check_access(self, hostname: str, username: str) -> AccessRights:  # noqa: ARG002
        return AccessRights.READ if self.put is None else AccessRights.READ | AccessRights.WRITE

    async def write_from_dbr(self, data: Any, data_type: Any, metadata: Any, **given: Any) -> None:
        """Process a client's write.

        The library would convert 0.5, 2**32 and nan to some integer: raises RefusedError for such a number.
        """
        text = native_type(data_type) == ChannelType.STRING
        if not text and isinstance(self, ChannelInteger | ChannelEnum):
            ends = (0, len(self.enum_strings) - 1) if isinstance(self, ChannelEnum) else (-(2**31), 2**31 - 1)
            for value in data:
                if not (ends[0] <= value <= ends[1] and value == int(value)):
                    raise RefusedError(f"invalid value {value:g}: expected an integer from {ends[0]} to {ends[1]}")
        await super().write_from_dbr(data, data_type, metadata, **given)

    async def publish(self, flags: Any) -> None:
        """Send the value to each subscriber whose data type can represent it.

        The library would raise the error of the first one that cannot, and so end the polls of the controller.
        """
        self._content.clear()
        for queue, filters in self._queues.items():
            for types in filters.values():
                for wanted in types.values():
                    if found := tuple(spec for spec in wanted if self._is_eligible(spec)):
                        with suppress(Exception):
                            metadata, values = await self._read(_channel_type_by_name[found[0].data_type_name])
                            await queue.put(SubscriptionUpdate(found, metadata, values, flags, None))

    async def write(self, value: Any, *, verify_value: bool = True, **metadata: Any) -> None:
        """Process a write of a client, or (without `verify_value`) store and publish a value of the record."""
        if not verify_value:
            await super().write(value, verify_value=False, update_fields=False, **metadata)
        elif self.put is not None:
            await self.put(self.preprocess_value(value))


class _Double(Channel, ChannelDouble):
    pass


class _Long(Channel, ChannelInteger):
    pass


class _Menu(Channel, ChannelEnum):
    pass


class _String(Channel, ChannelString):
    pass


class _Text(Channel, ChannelChar):
    pass


def _make(field: Field, value: Any, put: Put | None, alarm: ChannelAlarm, kind: str) -> Channel:
    given = {"alarm": alarm, "reported_record_type": kind}
    made: Channel
    match field.kind:
        case Kind.DOUBLE:
            made = _Double(value=value, **given)
        case Kind.LONG:
            made = _Long(value=value, **given)
        case Kind.MENU:
            made = _Menu(value=field.menu[value], enum_strings=field.menu, **given)
        case Kind.STRING:
            made = _String(value=_latin(value), **given)
        case Kind.TEXT:
            made = _Text(value=_latin(value), max_length=256, **given)
    made.put = put
    return made


def _latin(value: Any) -> Any:
    """Replace the characters of a text that Channel Access cannot transfer, e.g. `…`."""
    return value.encode("latin-1", "replace").decode("latin-1") if isinstance(value, str) else value


class _Motor:
    def __init__(self, record: MotorRecord) -> None:
        self._record = record
        self._alarm = ChannelAlarm(status=AlarmStatus.UDF, severity=AlarmSeverity.INVALID_ALARM)
        self.channels = {name: self._channel(name, field) for name, field in MOTOR.items()}
        record.observers.append(self.post)

    def _channel(self, name: str, field: Field) -> Channel:
        async def put(value: Any) -> None:
            await self._record.put(name, value)

        allowed = put if self._record.writable(name) else None
        return _make(field, self._record.values[name], allowed, self._alarm, "motor")

    async def post(self, name: str, value: Any) -> None:
        """Publish a field; "": the alarm and the metadata."""
        if not name:
            await self.describe()
            return
        channel, menu = self.channels[name], MOTOR[name].menu
        await channel.write(menu[value] if menu else _latin(value), verify_value=False)

    async def describe(self) -> None:
        record, values = self._record, self._record.values
        status, severity = AlarmStatus[record.alarm.status], MOTOR["SEVR"].menu.index(record.alarm.severity)
        if (self._alarm.status, self._alarm.severity) != (status, severity):
            await self._alarm.write(status=status, severity=AlarmSeverity(severity))
        metadata = {"units": _latin(values["EGU"]), "precision": values["PREC"]}
        limits = {"lower_ctrl_limit": values["LLM"], "upper_ctrl_limit": values["HLM"]}
        for name, field in MOTOR.items():
            if field.scaled:
                more = limits if name in ("VAL", "RBV") else {}
                await self.channels[name].write_metadata(**metadata, **more)


class _Circuit(VirtualCircuit):
    """A client's connection.  Updates are sent at once, and before the answer to a write that caused them."""

    def refuse(self, what: str, error: Exception) -> None:
        why = f"unknown number {error}" if isinstance(error, KeyError) else str(error).partition("\n")[0]
        self.drop(f"it sent an invalid {what}: {why}")

    def drop(self, why: str) -> None:
        """Disconnect a client at once, also if it does not read what it was sent."""
        self.log.critical("Channel Access: %s:%d is disconnected, because %s", *self.circuit.address, why)
        self.client.writer.transport.abort()

    async def recv(self) -> None:
        """Receive messages.  A connection that was reset has ended, like one that was closed."""
        if not self.connected:  # else messages would be read that nobody processes
            raise DisconnectedCircuit
        try:
            await super().recv()
            if len(self.circuit._data) > MOST_BYTES:
                raise ValueError(f"longer than {MOST_BYTES} bytes")
        except DisconnectedCircuit:
            raise
        except Exception as error:  # noqa: BLE001  # the library's parser raises errors of many kinds
            if not isinstance(error, CaprotoNetworkError):
                self.refuse("message", error)
            await self.command_queue.put(DISCONNECTED)
            raise DisconnectedCircuit from None

    async def command_queue_loop(self) -> None:
        try:
            await super().command_queue_loop()
        except Exception as error:  # noqa: BLE001  # the library has accepted a message that it cannot answer
            self.refuse("message", error)
        while not self.command_queue.empty():  # `recv` may be waiting for a place
            self.command_queue.get_nowait()

    async def _command_queue_iteration(self, command: Any) -> Any:
        try:
            if isinstance(command, ClearChannelRequest):
                # The library compares a channel with a number here, and so keeps the subscriptions of the channel.
                await self._cull_subscriptions(None, lambda sub: bool(sub.channel.sid == command.sid))
            return await super()._command_queue_iteration(command)
        except DisconnectedCircuit:
            raise
        except Exception as error:  # noqa: BLE001  # so does its own search for the channel
            if self.connected:
                self.refuse(type(command).__name__, error)
            raise DisconnectedCircuit from None

    async def _start_write_task(self, handle_write: Callable[[], Awaitable[None]]) -> None:
        async def write() -> None:
            # The client may have gone, or cleared the channel, before a motion ends: then nobody waits for the answer.
            with suppress(DisconnectedCircuit, LocalProtocolError, KeyError):
                await handle_write()

        await super()._start_write_task(write)

    async def send(self, *commands: Any) -> None:
        if any(isinstance(command, WriteNotifyResponse) for command in commands):
            await self.context.subscription_queue.join()
            await self.subscription_queue.join()
        await super().send(*commands)

    async def subscription_queue_loop(self) -> None:
        """Send updates until the client disconnects.  All updates that wait in the queue are sent together."""
        self.events_on.set()
        try:
            while True:
                await self._send_updates([await self.subscription_queue.get()])
        except (DisconnectedCircuit, asyncio.CancelledError):
            return  # The caller of `cancel` waits for the end, and would end with a CancelledError.
        except Exception as error:  # noqa: BLE001
            # After an invalid message, the library has taken a channel away, but not its subscription.
            self.refuse("message", error)

    async def _send_updates(self, found: list[Callable[[], EventAddResponse | None]]) -> None:
        while not self.subscription_queue.empty():
            found.append(self.subscription_queue.get_nowait())
        wanted = {sub.subscriptionid for subs in self.subscriptions.values() for sub in subs}
        updates = [update for reference in found if (update := reference()) is not None]
        try:
            await self.send(*(update for update in updates if update.subscriptionid in wanted))
        finally:
            for _ in found:
                self.subscription_queue.task_done()

    async def _on_disconnect(self) -> None:
        await super()._on_disconnect()
        while not self.subscription_queue.empty():  # else `send` would wait for ever for updates that nobody sends
            self.subscription_queue.get_nowait()
            self.subscription_queue.task_done()


class _Context(Context):
    CircuitClass = _Circuit

    async def tcp_handler(self, client: Any, addr: Any) -> None:
        """Serve a client until it disconnects; refuse one too many."""
        if len(self.circuits) < MOST_CLIENTS:
            await super().tcp_handler(client, addr)
        else:
            client.close()

    async def _subscription_queue_send(self, sub_spec: Any, sub: Subscription, **update: Any) -> None:
        if sub.circuit.subscription_queue.full():  # else the updates of all others would wait for this client
            sub.circuit.drop("it does not read its updates")
            return
        try:
            await super()._subscription_queue_send(sub_spec, sub, **update)
        except Exception as error:  # noqa: BLE001  # what one client asks for must not end the updates of the others
            sub.circuit.refuse("subscription", error)

    async def subscription_queue_loop(self) -> None:
        while True:
            update = await self.subscription_queue.get()
            try:
                await self._subscription_queue_iteration(*update)
            finally:
                self.subscription_queue.task_done()


class ChannelAccess:
    """A server for Channel Access.  `port`: for UDP and TCP; if it is taken, the system chooses another TCP port."""

    def __init__(self, addresses: Sequence[str] = (LOOPBACK,), port: int | None = None) -> None:
        self._channels: dict[str, Channel] = {}
        self._motors: list[_Motor] = []
        self._addresses, self._port = list(addresses), port
        self._started = asyncio.Event()
        if all(address == LOOPBACK for address in addresses):
            # A server for local clients sends its EPICS beacons only to this computer.
            os.environ.setdefault("EPICS_CAS_AUTO_BEACON_ADDR_LIST", "NO")
            os.environ.setdefault("EPICS_CAS_BEACON_ADDR_LIST", LOOPBACK)

    def add_motor(self, record: MotorRecord) -> None:
        motor = _Motor(record)
        self._motors.append(motor)
        self._channels[record.name] = motor.channels["VAL"]
        for name, channel in motor.channels.items():
            self._channels[called(record.name, name)] = channel

    def add_point(self, name: str, point: Point) -> None:
        """Serve a pin as a binary record, a register as a long one."""
        field = Field(Kind.MENU, point.value or 0, NO_YES) if point.bit else Field(Kind.LONG, point.value or 0)
        alarm = ChannelAlarm(status=AlarmStatus.UDF, severity=AlarmSeverity.INVALID_ALARM)

        async def put(value: Any) -> None:
            await point.write(NO_YES.index(value) if isinstance(value, str) else int(value))

        async def post(value: int) -> None:
            good = {"status": AlarmStatus.NO_ALARM, "severity": AlarmSeverity.NO_ALARM}
            await channel.write(field.menu[value] if field.menu else value, verify_value=False)
            await alarm.write(**good)

        kind = ("bo" if point.bit else "longout") if point.writable else "bi" if point.bit else "longin"
        channel = _make(field, field.value, put if point.writable else None, alarm, kind)
        if point.value is not None:
            alarm._data.update(status=AlarmStatus.NO_ALARM, severity=AlarmSeverity.NO_ALARM)
        point.observers.append(post)
        self._channels[name] = channel

    async def run(self) -> None:
        for motor in self._motors:
            await motor.describe()
        context = _Context(self._channels, self._addresses)
        if self._port is not None:
            context.ca_server_port = self._port

        async def started(_: object) -> None:
            self._port = context.port
            self._started.set()

        await context.run(startup_hook=started)

    async def started(self) -> str:
        """Wait until the server listens; return its address."""
        await self._started.wait()
        return f"{self._addresses[0]}:{self._port}"
