"""A relay between a host's bus socket and the bridge to a real board: bytes pass through as they are."""

import asyncio
import contextlib
from collections.abc import Callable

from axistwin.core.errors import LinkError, cannot_open
from axistwin.links.urls import PortUrl
from axistwin.real.shadow.board_asking import BoardAsker

CHUNK = 4096


class BusRelay:
    """Listens for one host, and connects to `board` for it.  `relayed(from_host, data)` is called afterwards.

    `asker` asks the board before its data pass.
    """

    def __init__(
        self, board: PortUrl, relayed: Callable[[bool, bytes], object], asker: BoardAsker | None = None
    ) -> None:
        self._board, self._relayed, self._asker = board, relayed, asker
        self._server: asyncio.Server | None = None
        self.busy = False  # True while a host is connected.

    async def open(self, url: PortUrl) -> PortUrl:
        """Check that the board's bridge is there, and listen.  Raises LinkError."""
        try:
            _, writer = await self._connected()
            writer.close()
            self._server = await asyncio.start_server(self._serve, url.host, url.port)
        except OSError as error:
            raise LinkError(cannot_open(url if self._server else self._board, error)) from None
        port = self._server.sockets[0].getsockname()[1]
        return PortUrl("bus", url.host, port)

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        if self.busy:
            writer.close()
            return
        self.busy = True
        try:
            there, back = await self._connected()
            ways = ((reader, back, True), (there, writer, False))
            tasks = [asyncio.create_task(self._pass(*way)) for way in ways]
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            for task in tasks:
                task.cancel()
            back.close()
            await back.wait_closed()
        except OSError:
            pass  # The host sees a closed connection, and may try again.
        finally:
            self.busy = False
            writer.close()

    async def _connected(self) -> tuple[asyncio.StreamReader, asyncio.StreamWriter]:
        reader, writer = await asyncio.open_connection(self._board.host, self._board.port)
        if self._asker is None or await self._asker.ask(reader, writer):
            return reader, writer
        writer.close()  # What is still answered is not for the host.
        await writer.wait_closed()
        return await asyncio.open_connection(self._board.host, self._board.port)

    async def _pass(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, from_host: bool) -> None:
        with contextlib.suppress(OSError):
            while data := await reader.read(CHUNK):
                writer.write(data)
                await writer.drain()
                self._relayed(from_host, data)

    def close(self) -> None:
        if self._server is not None:
            self._server.close()
