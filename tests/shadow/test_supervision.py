"""The twin's process: it is started again when it has failed, and the relay of a bus passes everything through."""

import asyncio
import os
import signal

from axistwin.links.urls import parse
from axistwin.real.shadow.bus_relay import BusRelay
from axistwin.real.shadow.feed import What
from axistwin.real.shadow.supervision import Supervisor

SETTINGS = {
    "model": "if1", "scene": None, "options": (), "line": None, "devices": {}, "tolerance_ms": None, "log": None,
    "json": False,
}  # fmt: skip


def test_a_twin_that_was_killed_is_started_again(monkeypatch, capfd):
    monkeypatch.setattr("axistwin.real.shadow.supervision.PAUSE_S", 0.0)
    warned = []
    supervisor = Supervisor(SETTINGS, warned.append)
    first = supervisor.pid
    os.kill(first, signal.SIGKILL)
    supervisor._process.wait()
    supervisor.add(What.HOST, b"E\r")
    supervisor.check()
    assert supervisor.pid != first and warned == ["the twin has failed (-9): it is started again"]
    assert supervisor.end() == 0
    assert "0 answers, no findings" in capfd.readouterr().out


def test_what_differed_before_a_restart_counts(monkeypatch):
    monkeypatch.setattr("axistwin.real.shadow.supervision.PAUSE_S", 0.0)
    supervisor = Supervisor(SETTINGS, lambda words: None)
    supervisor._process.kill()
    supervisor._process.wait()
    monkeypatch.setattr(supervisor._process, "poll", lambda: 1)  # it has ended by itself, with findings
    supervisor.check()
    assert supervisor.end() == 1


def test_a_bus_relay_passes_everything_through_and_tells_it_afterwards():
    relayed, served = [], []

    async def bridge(reader, writer):
        served.append(writer)
        while line := await reader.readline():
            writer.write(b"50\n" if line == b"r 1\n" else b"ok\n")
        writer.close()
        await writer.wait_closed()
        served.remove(writer)

    async def talk():
        board = await asyncio.start_server(bridge, "127.0.0.1", 0)
        url = parse(f"bus://127.0.0.1:{board.sockets[0].getsockname()[1]}")
        relay = BusRelay(url, lambda by_host, data: relayed.append((by_host, data)))
        port = await relay.open(parse("bus://127.0.0.1:0"))
        reader, writer = await asyncio.open_connection(port.host, port.port)
        heard = []
        for request in (b"r 1\n", b"w 0 83\n"):
            writer.write(request)
            heard.append(await reader.readline())
        second, refused = await asyncio.open_connection(port.host, port.port)
        assert await second.read() == b""  # a bus has one master
        for end in (refused, writer):
            end.close()
            await end.wait_closed()
        while relay.busy or served:
            await asyncio.sleep(0)
        relay.close()
        board.close()
        return heard

    assert asyncio.run(talk()) == [b"50\n", b"ok\n"]
    assert relayed == [(True, b"r 1\n"), (False, b"50\n"), (True, b"w 0 83\n"), (False, b"ok\n")]
