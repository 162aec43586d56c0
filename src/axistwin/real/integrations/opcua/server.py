"""The OPC UA server of a machine."""

import asyncio
import logging
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from pathlib import Path

from axistwin.real.integrations.driven_scene import Machine, tell_failure
from axistwin.real.integrations.opcua.address_space import AddressSpace
from axistwin.real.integrations.opcua.channels import GuardedServer
from axistwin.real.integrations.opcua.security import APPLICATION, Account, Users, secure


@asynccontextmanager
async def serving(
    machine: Machine, address: str = "127.0.0.1", port: int = 4840, *, users: Mapping[str, Account] | None = None,
    certificates: Path | None = None,
) -> AsyncIterator[str]:  # fmt: skip
    """Serve a machine that has been opened, and poll its controllers; yield the server's URL."""
    # Suppress the log messages of the library asyncua, e.g. about each refused request of a client.
    logging.getLogger("asyncua").setLevel(logging.CRITICAL)
    server = GuardedServer(None if users is None else Users(users))
    await server.init()
    url = f"opc.tcp://{address}:{port}/axistwin"
    server.set_endpoint(url)
    server.set_server_name("axistwin")
    await server.set_application_uri(APPLICATION)
    await secure(server, users is not None, certificates, address)
    await AddressSpace(server).build(machine.stations)
    async with server:
        polling = asyncio.ensure_future(machine.run())
        polling.add_done_callback(tell_failure)
        try:
            yield url
        finally:
            polling.cancel()
            await asyncio.gather(polling, return_exceptions=True)
