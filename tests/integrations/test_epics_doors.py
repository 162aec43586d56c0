"""What the libraries of EPICS open beside the port that they were given."""

import asyncio
import socket
import struct
import sys

import pytest

from axistwin.integrations import Point

from .conftest import free_port

pytest.importorskip("p4p", reason="p4p is not installed")

from axistwin.integrations.epics import pv_access


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
                sender.settimeout(10)
                sender.bind(("127.0.0.1", 0))
                search(sender, ("127.0.0.2", port + 1), 2)
                search(sender, ("127.0.0.1", port + 1), 1)
                answer, address = sender.recvfrom(2000)
            with pytest.raises(ConnectionRefusedError):
                socket.create_connection(("127.0.0.2", port), 10)
            socket.create_connection(("127.0.0.1", port), 10).close()
            with pytest.raises(OSError, match="assign"):
                await pv_access.PvAccess(["192.0.2.77"]).open()
            return address, struct.unpack_from(">I", answer, 20)
        finally:
            server.stop()

    assert asyncio.run(serve()) == (("127.0.0.1", port + 1), (1,))
