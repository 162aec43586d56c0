"""A port with a controller at its other end, opened by pyserial.  A thread reads the port."""

import asyncio
from collections.abc import Callable
from threading import Thread

import serial

from axistwin.bench import line_format
from axistwin.core.errors import LinkError
from axistwin.real.hosts.real_time import open_port
from axistwin.sim.frames import UartFormat

USUAL = UartFormat(9600, 8, "N", 2)
QUIET_S = 0.3  # Seconds of silence after which a controller counts as idle.


class PortEnd:
    """Connection to a port.  `receive` is called with received data, `lost` with the error if the port fails."""

    def __init__(
        self, target: str, line: str | None, receive: Callable[[bytes], None], lost: Callable[[LinkError], None]
    ) -> None:
        self._loop = asyncio.get_running_loop()
        self._target, self._receive, self._failed = target, receive, lost
        self._port = open_port(target, line_format(line, USUAL)[0], timeout_s=0.1)
        self._closing = False
        self._last_s = self._loop.time()
        self._thread = Thread(target=self._subscribe, daemon=True)
        self._thread.start()

    def send(self, data: bytes) -> None:
        self._last_s = self._loop.time()
        try:
            self._port.write(data)
        except serial.SerialException as error:
            self._failed(self._gone(error))

    async def run_until_quiet(self) -> None:
        """Wait until no data have arrived for `QUIET_S` seconds."""
        while (left_s := self._last_s + QUIET_S - self._loop.time()) > 0:
            await asyncio.sleep(left_s)

    async def wait(self, seconds: float) -> None:
        await asyncio.sleep(seconds)

    def close(self) -> None:
        self._closing = True
        self._thread.join()  # Wait up to 0.1 s for the end of the thread that reads the port.
        self._port.close()

    def _subscribe(self) -> None:
        while not self._closing:
            try:
                data = self._port.read(max(1, self._port.in_waiting))
            except (serial.SerialException, OSError) as error:
                self._loop.call_soon_threadsafe(self._failed, self._gone(error))
                return
            if data:
                self._loop.call_soon_threadsafe(self._take, data)

    def _gone(self, error: Exception) -> LinkError:
        return LinkError(f"{self._target} was disconnected: {error}")

    def _take(self, data: bytes) -> None:
        self._last_s = self._loop.time()
        self._receive(data)
