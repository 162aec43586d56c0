"""A relay between a host and a real controller, for recording their conversation.

To the host, the relay appears as a controller on a bench whose virtual time is real time.  All kinds of ports work, and
a recorder can observe the bench.  On the simulated line between host and relay, characters take no time; on the real
wire they take their real time.

The real device is any URL of pyserial: `/dev/ttyUSB0`, `rfc2217://…`, `socket://…`.  One thread reads from the device
and polls its control lines.  A second thread executes the host's acts at the device in order, because a network device
that does not answer can take seconds for each act of the host.  All other work is done in the event loop.

    host ── port ── Plug ── SerialPort ── PassThrough ── pyserial ── controller

The host's line format, DTR, RTS and breaks are forwarded.  The host sees the controller's DTR and RTS, which are the
device's DSR and CTS on a crossed cable.  A break begins when the host has ended its break, and has the same length.
Hardware on raw TCP (`socket://`) receives characters only.
"""

import asyncio
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from functools import partial
from logging import getLogger
from threading import Thread

from axistwin.bench import Bench
from axistwin.bench.bench import SharedLine
from axistwin.core.errors import LinkError, reason
from axistwin.core.lazy import serial
from axistwin.links.devices import DEVICE_ERRORS, Lines, control_lines, opening, set_lines, settings_of
from axistwin.links.pacing import Pacer
from axistwin.links.plug import CHUNK
from axistwin.sim.frames import LineError, UartFormat
from axistwin.sim.pins import Pin
from axistwin.sim.serial import Uart
from axistwin.sim.serial_port import SerialPort
from axistwin.sim.signal import Signal
from axistwin.sim.wirings import direct

log = getLogger("axistwin.links")

POLL_S = 0.01  # Interval in seconds between two polls of the control lines, whose changes cause no event.
MAX_QUEUED = 1000  # Number of queued actions above which a device counts as lost.
LINGER_S = 1.0  # Longest time in seconds for which `close` waits for queued actions.


class PassThrough(Uart):
    """The device's end of the simulated line, which accepts characters in any format."""

    def understands(self, sent: UartFormat) -> bool:  # noqa: ARG002
        return True


class Relay:
    """A bench with one serial line, `name`, that is connected to a real device.

    `url`: a device or a URL of pyserial.  `line`: the initial format.  Raises LinkError if the device cannot be opened.
    """

    def __init__(self, url: str, name: str, line: UartFormat) -> None:
        self.bench, self.url = Bench(), url
        self._device = _open(url, line)
        clock = self.bench.clock
        self._pass_through = PassThrough(clock, line, on_receive=self._to_device)
        wiring = direct(self._pass_through, instant=True)
        self.port = SerialPort(clock, wiring, Pin(clock, "dtr", True), Pin(clock, "rts", True), line=line)
        self.bench.lines[name] = SharedLine(self.port, (), "serial")
        self._applied, self._outgoing, self._closing = line, bytearray(), False
        self._lines: Lines | None = None
        self._thread: Thread | None = None
        self.raw = url.startswith("socket://")  # True if the transport carries characters only.
        self._worker = ThreadPoolExecutor(1, "axistwin-device")
        self._latest: Future[None] | None = None
        self._asked, self._done = 0, 0
        self._warned: set[str] = set()
        self.relayed: Signal[bool, bytes] = Signal()  # Event: data has been passed on, from the host if True.
        self.formats: Signal[UartFormat] = Signal()  # Event: the host has set another line format.
        self._gone = False  # True while the device is lost.
        self._aside: Callable[[bytes], object] | None = None

    def ask(self, data: bytes, receive: Callable[[bytes], object]) -> None:
        """Send data that are not the host's.  Until `release`, `receive` is called instead of the host, which waits."""
        self._aside = receive
        self._queue(partial(self._write, data))

    def release(self, rest: bytes) -> None:
        """End what `ask` has begun; the host receives `rest`."""
        self._aside = None
        self._pacer.sync()
        self._to_host(rest)
        self._forward()

    def start(self, pacer: Pacer, lost: Callable[[LinkError], None]) -> None:
        """Start forwarding; call it in the event loop of the pacer.  `lost` is called when the device is lost."""
        self._pacer, self._lost, self._loop = pacer, lost, asyncio.get_running_loop()
        self._lines = control_lines(self._device)
        if self._lines is not None:
            self._show_lines(self._lines.dsr, self._lines.cts)
        host = self.port.host
        host.dtr_line.subscribe(lambda _: self._drive())
        host.rts_line.subscribe(lambda _: self._drive())
        self.port.breaks.subscribe(self._break)
        pacer.subscribe(self._forward)
        self._begin()

    def _begin(self) -> None:
        self._thread = Thread(target=self._listen, args=(self._device,), daemon=True)
        self._thread.start()

    async def reopen(self) -> None:
        """Open the device again after its loss.  Raises LinkError if it is still away."""
        device = await self._loop.run_in_executor(None, _open, self.url, self._applied)
        self._device, self._gone = device, False
        self._lines = control_lines(device)
        self._worker = ThreadPoolExecutor(1, "axistwin-device")
        self._asked = self._done = 0
        self._begin()

    def close(self) -> None:
        self._closing = True
        if self._thread is not None:
            self._thread.join()
        if self._latest is not None:
            wait([self._latest], LINGER_S)
        self._worker.shutdown(wait=False, cancel_futures=True)
        self._device.close()

    # Functions that forward data and settings from the host

    def _to_device(self, byte: int, errors: LineError) -> None:
        if not errors:
            self._outgoing.append(byte)

    def _forward(self) -> None:
        if self._aside is not None:
            return
        if self.port.host.format != self._applied:
            self._applied = self._pass_through.format = self.port.host.format
            settings = settings_of(self._applied)
            self.formats.emit(self._applied)
            self._queue_setting(f"do {self._applied}", partial(self._device.apply_settings, settings))
        if self._outgoing:
            data, self._outgoing = bytes(self._outgoing), bytearray()
            self._queue(partial(self._write, data))
            self.relayed.emit(True, data)

    def _drive(self) -> None:
        if self._lines is not None:
            host = self.port.host
            self._queue_setting("set DTR and RTS", partial(set_lines, self._lines, host.dtr, host.rts))

    def _break(self, seconds: float) -> None:
        self._forward()
        self._queue_setting("send a break", partial(setattr, self._device, "break_condition", True))
        end = partial(setattr, self._device, "break_condition", False)
        self._loop.call_later(seconds, self._queue_setting, "end a break", end)

    def _queue_setting(self, what: str, do: Callable[[], object]) -> None:
        if self.raw:
            self._warn_once("carries characters only: line format, control lines and breaks are not forwarded")
        else:
            self._queue(partial(self._apply, what, do))

    def _queue(self, do: Callable[[], None]) -> None:
        self._asked += 1
        if self._asked - self._done > MAX_QUEUED:
            self._lose(TimeoutError("it does not answer"))
        elif not (self._closing or self._gone):
            self._latest = self._worker.submit(self._counted, do)
            # `wrap_future` makes asyncio log an exception that the function `do` does not catch.
            asyncio.wrap_future(self._latest)

    # Functions that run in the thread that writes to the device

    def _counted(self, do: Callable[[], None]) -> None:
        try:
            do()
        finally:
            self._done += 1

    def _write(self, data: bytes) -> None:
        try:
            self._device.write(data)
        except DEVICE_ERRORS as error:
            if not self._closing:
                self._loop.call_soon_threadsafe(self._lose, error)

    def _apply(self, what: str, do: Callable[[], object]) -> None:
        try:
            do()
        except DEVICE_ERRORS as error:
            if not self._closing:
                self._warn_once(f"cannot {what}: {reason(error)}")

    def _warn_once(self, words: str) -> None:
        if words not in self._warned:
            self._warned.add(words)
            log.warning("%s %s", self.url, words)

    # Functions that forward data from the device to the host

    def _listen(self, device: "serial.Serial") -> None:
        loop = self._loop
        while not self._closing and device is self._device:
            try:
                data = self._read()
                levels = None if self._lines is None else (self._lines.dsr, self._lines.cts)
            except (OSError, TypeError) as error:  # pyserial raises TypeError if another thread has closed the device
                if not self._closing:
                    loop.call_soon_threadsafe(self._lose, error)
                return
            if data or levels not in (None, (self.port.dtr, self.port.rts)):
                loop.call_soon_threadsafe(self._take, data, levels)

    def _read(self) -> bytes:
        data = bytearray(self._device.read(1))
        while data and len(data) < CHUNK and (more := self._device.in_waiting):
            data += self._device.read(more)
        return bytes(data)

    def _take(self, data: bytes, levels: tuple[bool, bool] | None) -> None:
        self._pacer.sync()
        if levels is not None:
            self._show_lines(*levels)
        if data and self._aside is not None:
            self._aside(data)
            return
        self._to_host(data)
        if data:
            self.relayed.emit(False, data)

    def _to_host(self, data: bytes) -> None:
        self._pass_through.format = self.port.host.format
        self._pass_through.send(data)
        self._pacer.work()

    def _show_lines(self, dsr: bool, cts: bool) -> None:
        self.port.dtr_line.set(dsr)
        self.port.rts_line.set(cts)

    def _lose(self, error: Exception) -> None:
        if not self._gone:
            self._gone = True
            self._worker.shutdown(wait=False, cancel_futures=True)
            self._device.close()
            self._lost(LinkError(f"lost {self.url}: {error}"))


def _open(url: str, line: UartFormat) -> "serial.Serial":
    with opening(url):
        return serial.serial_for_url(url, timeout=POLL_S, **settings_of(line))
