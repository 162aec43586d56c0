"""What a client of Channel Access leaves behind."""

import asyncio
import gc
import json
import logging
import re
import socket
import struct
from collections import deque
from contextlib import asynccontextmanager, suppress

import pytest

from axistwin.drivers import RefusedError
from axistwin.real.integrations import Point

from ..command import ended, running
from .conftest import free_port

ca = pytest.importorskip("caproto", reason="caproto is not installed")

from axistwin.real.integrations.epics import channel_access  # noqa: E402

Field, Kind = channel_access.Field, channel_access.Kind


class Visitor:
    def __init__(self, reader, writer, port, name="P"):
        self._reader, self._writer, self._received = reader, writer, deque()
        self._circuit = ca.VirtualCircuit(ca.CLIENT, ("127.0.0.1", port), 0)
        self.channel = ca.ClientChannel(name, self._circuit)

    def other(self, name):
        self.channel = ca.ClientChannel(name, self._circuit)
        return self.channel

    def send_bytes(self, data):
        self._writer.write(data)

    def send(self, *commands):
        self._writer.write(b"".join(map(bytes, self._circuit.send(*commands))))

    async def until(self, kind):
        while True:
            while self._received:
                self._circuit.process_command(command := self._received.popleft())
                if isinstance(command, kind):
                    return command
            self._received.extend(self._circuit.recv(await self._reader.read(4096))[0])

    async def join(self):
        channel = self.channel
        self.send(ca.VersionRequest(0, 13), channel.host_name("here"), channel.client_name("me"), channel.create())
        await self.until(ca.CreateChanResponse)

    async def gone(self):
        with suppress(ConnectionError):
            await self._writer.wait_closed()

    def leave(self, *, abort):
        (self._writer.transport.abort if abort else self._writer.close)()


@asynccontextmanager
async def served(channels):
    """Serve channels by their names; yield a function that connects a client to one of them."""
    port, escaped, clients, ready = free_port(), [], [], asyncio.Event()
    asyncio.get_running_loop().set_exception_handler(lambda _, context: escaped.append(context["message"]))
    context = channel_access._Context(channels, ["127.0.0.1"])
    context.ca_server_port = port

    async def started(_):
        ready.set()

    async def visitor(name="P"):
        clients.append(client := Visitor(*await asyncio.open_connection("127.0.0.1", port), port, name))
        await client.join()
        return client

    serving = asyncio.ensure_future(context.run(startup_hook=started))
    await ready.wait()
    yield visitor
    for client in clients:
        client.leave(abort=False)
        await client.gone()
    await until_gone(context, 100)
    serving.cancel()
    await asyncio.gather(serving, return_exceptions=True)
    gc.collect()  # an exception that nobody has retrieved is told when its task is collected
    assert escaped == []


def channel_of(kind, value, put=None):
    return channel_access._make(Field(kind, value), value, put, ca.ChannelAlarm(), "motor")


async def until_gone(context, count):
    for _ in range(1000):
        if not context.circuits and len(asyncio.all_tasks()) <= count:
            return
        await asyncio.sleep(0.01)


def test_one_client_too_many_is_refused(monkeypatch):
    async def visits():
        port = free_port()
        server = channel_access.ChannelAccess(port=port)
        server.add_point("P", Point("P", None))
        serving = asyncio.ensure_future(server.run())
        await server.started()
        first = Visitor(*await asyncio.open_connection("127.0.0.1", port), port)
        await first.join()
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        refused = await reader.read()
        writer.close()
        first.send(first.channel.read())
        await first.until(ca.ReadNotifyResponse)
        first.leave(abort=False)
        await first.gone()
        serving.cancel()
        await asyncio.gather(serving, return_exceptions=True)
        return refused

    monkeypatch.setattr(channel_access, "MOST_CLIENTS", 1)
    assert asyncio.run(visits()) == b""


@pytest.mark.parametrize("does", ["nothing", "subscribes", "writes"])
def test_nothing_is_left_of_a_client(monkeypatch, does):
    contexts = []

    class Context(channel_access._Context):
        def __init__(self, *arguments):
            super().__init__(*arguments)
            contexts.append(self)

    async def visits():
        port, free = free_port(), asyncio.Event()

        async def write(value):
            await free.wait()

        server, point = channel_access.ChannelAccess(port=port), Point("P", None, write)
        server.add_point("P", point)
        serving = asyncio.ensure_future(server.run())
        await server.started()
        before = len(asyncio.all_tasks())
        for number in range(6):
            visitor = Visitor(*await asyncio.open_connection("127.0.0.1", port), port)
            await visitor.join()
            if does != "nothing":
                visitor.send(visitor.channel.subscribe())
                await visitor.until(ca.EventAddResponse)
            if does == "writes":
                visitor.send(visitor.channel.write((number % 2,), notify=True))
                visitor.send(visitor.channel.read())
                await visitor.until(ca.ReadNotifyResponse)  # the write has begun
            visitor.leave(abort=bool(number % 2))
        free.set()
        await until_gone(contexts[0], before)
        left = len(contexts[0].circuits), len(asyncio.all_tasks()) - before
        serving.cancel()
        await asyncio.gather(serving, return_exceptions=True)
        return left

    monkeypatch.setattr(channel_access, "_Context", Context)
    assert asyncio.run(visits()) == (0, 0)


@pytest.mark.parametrize("refused", [False, True])
@pytest.mark.parametrize("leaves", ["clears", "closes", "aborts"])
def test_a_client_may_leave_before_its_write_ends(leaves, refused):
    async def visits():
        free, ends = asyncio.Event(), []

        async def write(value):
            try:
                await free.wait()
                if refused:
                    raise RefusedError("the motion failed")
            finally:
                ends.append(value)

        async with served({"P": channel_of(Kind.LONG, 0, write)}) as visitor:
            client, other = await visitor(), await visitor()
            client.send(client.channel.subscribe(), client.channel.write((1,), notify=True), client.channel.read())
            await client.until(ca.ReadNotifyResponse)  # the write has begun
            if leaves == "clears":
                client.send(client.channel.clear())
                await client.until(ca.ClearChannelResponse)
            else:
                client.leave(abort=leaves == "aborts")
                await client.gone()
            free.set()
            while not ends:
                await asyncio.sleep(0)
            other.send(other.channel.read())
            await other.until(ca.ReadNotifyResponse)
            return ends

    assert asyncio.run(visits()) == [1]


def test_a_cleared_channel_takes_only_its_own_updates_away():
    async def visits():
        first, second = channel_of(Kind.LONG, 0), channel_of(Kind.LONG, 0)
        async with served({"A": first, "B": second}) as visitor:
            client = await visitor("A")
            cleared, kept = client.channel, client.other("B")
            client.send(kept.create())
            await client.until(ca.CreateChanResponse)
            for channel in (cleared, kept):
                client.send(channel.subscribe())
                await client.until(ca.EventAddResponse)
            client.send(cleared.clear())
            await client.until(ca.ClearChannelResponse)
            await first.write(7, verify_value=False)
            await second.write(8, verify_value=False)
            return (await client.until(ca.EventAddResponse)).data[0]

    assert asyncio.run(visits()) == 8


def message(command, payload=b"", kind=0, count=0, first=0, second=0):
    return struct.pack(">HHHHII", command, len(payload), kind, count, first, second) + payload


READ, WRITE, SUBSCRIBE, CANCEL, CREATE, CLEAR = 15, 19, 1, 2, 18, 12
CROSSED = (
    "message: <ChannelState states={CLIENT: CONNECTED, SERVER: CONNECTED}> cannot handle command type "
    "ClearChannelResponse when role=Role.SERVER and state=States.CONNECTED"
)
LONG = struct.pack(">HHHHIIII", READ, 0xFFFF, 6, 0, 0, 0, 2**31, 1)
"""The beginning of a message of 2 GiB."""


@pytest.mark.parametrize(("data", "why"), [
    (message(READ, kind=6, count=1, first=77), "ReadNotifyRequest: unknown number 77"),
    (message(WRITE, bytes(8), 6, 1, 77), "WriteNotifyRequest: unknown number 77"),
    (message(SUBSCRIBE, bytes(16), 6, 1, 77), "EventAddRequest: unknown number 77"),
    (message(SUBSCRIBE, b"", 6, 1), "message: Buffer size too small (0 instead of at least 16 bytes)"),
    (message(99), "message: Packet with bad command ID 0x63 was received."),
    (bytes(range(1, 17)) * 64, "message: Packet with bad command ID 0x102 was received."),
    (LONG + bytes(16384), "message: longer than 16384 bytes"),
    (
        message(CREATE, b"P".ljust(8, b"\0"), first=5, second=13) + message(CLEAR, first=1, second=0),
        CROSSED,
    )], ids=["read", "write", "subscribe", "short", "command", "noise", "long", "crossed"])  # fmt: skip
def test_an_invalid_message_costs_its_sender_the_connection_and_us_one_line(caplog, data, why):
    async def visits():
        async with served({"P": channel_of(Kind.LONG, 0)}) as visitor:
            client, other = await visitor(), await visitor()
            client.send_bytes(data)
            with suppress(ConnectionError):
                while await client._reader.read(4096):
                    pass
            other.send(other.channel.read())
            await other.until(ca.ReadNotifyResponse)

    logging.getLogger("caproto").setLevel(logging.CRITICAL)  # as the IOC does
    asyncio.run(visits())
    lines = [record.getMessage() for record in caplog.records if record.levelno == logging.CRITICAL]
    assert [line.partition("invalid ")[2] for line in lines] == [why]
    assert all(record.exc_info is None for record in caplog.records if record.levelno == logging.CRITICAL)


def test_a_channel_that_the_library_takes_away_ends_its_updates_quietly():
    async def visits():
        channel = channel_of(Kind.LONG, 0)
        async with served({"P": channel}) as visitor:
            client, other = await visitor(), await visitor()
            for each in (client, other):
                each.send(each.channel.subscribe())
                await each.until(ca.EventAddResponse)
            client.send_bytes(message(CANCEL, kind=6, count=1))  # the subscription is of type LONG
            await client.until(ca.ServerDisconnResponse)
            await channel.write(7, verify_value=False)
            with suppress(ConnectionError):
                while await client._reader.read(4096):
                    pass
            return (await other.until(ca.EventAddResponse)).data[0]

    assert asyncio.run(visits()) == 7


def test_a_client_that_does_not_read_its_updates_delays_nobody(monkeypatch, caplog):
    blocked = set()

    class Circuit(channel_access._Circuit):
        async def send(self, *commands):
            if self.circuit.address in blocked:
                await asyncio.Event().wait()  # as if the buffers of the connection were full
            await super().send(*commands)

    async def visits():
        channel = channel_of(Kind.LONG, 0)
        async with served({"P": channel}) as visitor:
            slow, other = await visitor(), await visitor()
            for client in (slow, other):
                client.send(client.channel.subscribe())
                await client.until(ca.EventAddResponse)
            blocked.add(slow._writer.get_extra_info("sockname"))
            for number in range(1, 21):
                await channel.write(number, verify_value=False)
                await asyncio.sleep(0)
            while (await other.until(ca.EventAddResponse)).data[0] != 20:
                pass
            with suppress(ConnectionError):
                assert await slow._reader.read() == b""

    monkeypatch.setattr(ca, "MAX_TOTAL_SUBSCRIPTION_BACKLOG", 5)
    monkeypatch.setattr(channel_access._Context, "CircuitClass", Circuit)
    asyncio.run(visits())
    assert "is disconnected, because it does not read its updates" in caplog.text


@pytest.mark.slow
def test_invalid_messages_of_a_hundred_clients_are_a_few_lines(scene_file):
    words = ("ioc", scene_file, "--prefix", "LAB:", "--port", free_port(), "--json")
    with running(*words) as program:
        address, number = json.loads(program.stdout.readline())["address"].split(":")
        for _ in range(100):
            with socket.create_connection((address, int(number)), 300) as client, suppress(ConnectionError):
                client.sendall(message(99))
                while client.recv(4096):
                    pass
        code, messages = ended(program)
    lines = messages.splitlines()
    in_full = re.compile(
        r"axistwin: Channel Access: 127\.0\.0\.1:\d+ is disconnected, because it sent an invalid message: "
        r"Packet with bad command ID 0x63 was received\."
    )
    assert (code, sum(bool(in_full.fullmatch(line)) for line in lines)) == (0, 10)
    assert lines[10:] == [
        f"axistwin: caproto.circ has reported {count} errors; later ones are only counted" for count in (16, 32, 64)
    ]


def test_a_subscription_to_an_impossible_type_takes_nothing_from_others():
    """A text is no number: the library would raise its error in the poll that publishes the text."""

    async def publish():
        channel = channel_of(Kind.STRING, "")
        async with served({"P": channel}) as visitor:
            clients = []
            for kind in (ca.ChannelType.DOUBLE, ca.ChannelType.STRING):
                clients.append(client := await visitor())
                client.send(client.channel.subscribe(data_type=kind))
                await client.until(ca.EventAddResponse)
            await channel.write("mm", verify_value=False)
            return (await clients[1].until(ca.EventAddResponse)).data[0]

    assert asyncio.run(publish()) == b"mm"


def test_a_text_that_channel_access_cannot_transfer_is_shown_with_question_marks():
    assert channel_of(Kind.TEXT, "no answer from …, 5 µm").value == "no answer from ?, 5 µm"
