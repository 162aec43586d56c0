"""What a client of Channel Access leaves behind."""

import asyncio
from contextlib import suppress

import pytest

from axistwin.integrations import Point

from .conftest import free_port

ca = pytest.importorskip("caproto", reason="caproto is not installed")

from axistwin.integrations.epics import channel_access  # noqa: E402


class Visitor:
    """A client that writes its messages itself."""

    def __init__(self, reader, writer, port):
        self._reader, self._writer = reader, writer
        self._circuit = ca.VirtualCircuit(ca.CLIENT, ("127.0.0.1", port), 0)
        self.channel = ca.ClientChannel("P", self._circuit)

    def send(self, *commands):
        self._writer.write(b"".join(map(bytes, self._circuit.send(*commands))))

    async def until(self, kind):
        while True:
            for command in self._circuit.recv(await self._reader.read(4096))[0]:
                self._circuit.process_command(command)
                if isinstance(command, kind):
                    return

    async def join(self):
        channel = self.channel
        self.send(ca.VersionRequest(0, 13), channel.host_name("here"), channel.client_name("me"), channel.create())
        await self.until(ca.CreateChanResponse)

    async def gone(self):
        with suppress(ConnectionError):
            await self._writer.wait_closed()

    def leave(self, *, abort):
        (self._writer.transport.abort if abort else self._writer.close)()


def without_beacons(monkeypatch):
    monkeypatch.setenv("EPICS_CAS_AUTO_BEACON_ADDR_LIST", "NO")
    monkeypatch.setenv("EPICS_CAS_BEACON_ADDR_LIST", "")


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
    without_beacons(monkeypatch)
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
    without_beacons(monkeypatch)
    assert asyncio.run(visits()) == (0, 0)
