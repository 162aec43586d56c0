"""What the libraries of EPICS open beside the port that they were given."""

import asyncio
import json
import os
import random
import socket
import struct
import sys
from contextlib import suppress
from pathlib import Path

import pytest

from axistwin.real.integrations import Point

from ..command import ended, running
from .conftest import free_port

pytest.importorskip("p4p", reason="p4p is not installed")

from axistwin.real.integrations.epics import pv_access


def search(sender, address, number):
    """Send a search for the PV `here`; the answer, if any, has the same number."""
    own = struct.pack("<H", sender.getsockname()[1])
    body = struct.pack("<IB3x", number, 0x80) + bytes(16) + own + b"\x01\x03tcp" + struct.pack("<HI", 1, 1)
    body += b"\x04here"
    sender.sendto(b"\xca\x02\x00\x03" + struct.pack("<I", len(body)) + body, address)


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux has 127.0.0.2 by default")
def test_pv_access_serves_this_computer_only_whatever_the_environment_says(monkeypatch):
    port = free_port()
    monkeypatch.setenv("EPICS_PVAS_INTF_ADDR_LIST", "127.0.0.2")
    monkeypatch.setenv("EPICS_PVAS_SERVER_PORT", str(port + 5))

    async def serve():
        served = pv_access.PvAccess(port=port)
        served.add_point("here", Point("here", None))
        server = await served.open()
        try:
            with socket.socket(type=socket.SOCK_DGRAM) as sender:
                sender.settimeout(300)
                sender.bind(("127.0.0.1", 0))
                search(sender, ("127.0.0.2", port + 1), 2)
                search(sender, ("127.0.0.1", port + 1), 1)
                answer, address = sender.recvfrom(2000)
            with pytest.raises(ConnectionRefusedError):
                socket.create_connection(("127.0.0.2", port), 300)
            socket.create_connection(("127.0.0.1", port), 300).close()
            with pytest.raises(OSError, match="assign"):
                await pv_access.PvAccess(["192.0.2.77"]).open()
            return address, struct.unpack_from(">I", answer, 20)
        finally:
            server.stop()

    assert asyncio.run(serve()) == (("127.0.0.1", port + 1), (1,))


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="the limit of a process is read in /proc")
def test_invalid_messages_by_pv_access_leave_no_trace_and_its_clients_find_descriptors(scene_file):
    """The library has no limit of clients, and spins when it has no descriptor for one more."""
    resource = pytest.importorskip("resource")
    most, port = resource.getrlimit(resource.RLIMIT_NOFILE)[1], free_port()
    words = ("ioc", scene_file, "--prefix", "LAB:", "--port", port, "--json", "--pva")
    environment = {name: value for name, value in os.environ.items() if name != "PVXS_LOG"}
    with running(
        *words, env=environment, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (256, most))
    ) as program:
        assert json.loads(program.stdout.readline())["records"]
        limits = Path(f"/proc/{program.pid}/limits").read_text().splitlines()
        noise = random.Random(1)
        messages = [struct.pack("<BBBBI", 0xCA, 2, 0, noise.randrange(24), n) + noise.randbytes(n) for n in range(40)]
        for data in (b"GET / HTTP/1.1\r\n\r\n", noise.randbytes(3000), *messages):
            with socket.create_connection(("127.0.0.1", port + 11), 300) as client, suppress(ConnectionError):
                client.sendall(data)
                client.shutdown(socket.SHUT_WR)
                while client.recv(4096):
                    pass
        found = ended(program)
    assert [line.split()[3:5] for line in limits if line.startswith("Max open files")] == [[str(most)] * 2]
    assert found == (0, "")
