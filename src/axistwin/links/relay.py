"""A real controller behind a port of ours: what a host says goes to it, what it says goes to the host.

To the host it looks like a controller on a bench of its own, whose virtual time is real time: every kind of port
works, and whoever observes the bench, such as a recorder, sees what is said and when.  The line from the host's port
to here takes no time; the characters take theirs on the real wire.

The real device is whatever pyserial opens: `/dev/ttyUSB0`, `rfc2217://…`, `socket://…`.  A thread listens to it, and
looks at its control lines meanwhile; another does at the device what the host wants, in order, as hardware on a network
that does not answer takes seconds for each thing.  Everything else happens in the event loop.

    host ── port ── Plug ── SerialPort ── Through ── pyserial ── controller

The host's line format, DTR, RTS and breaks are passed on; the controller's DTR and RTS (the device's DSR and CTS, the
cable being crossed) are shown to the host.  A break begins when the host has ended it, and is as long.  Hardware on raw
TCP (`socket://`) gets characters and nothing else.
"""

import asyncio
import termios
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from functools import partial
from logging import getLogger
from threading import Thread
from typing import TYPE_CHECKING

from axistwin.bench import Bench
from axistwin.bench.bench import SharedLine
from axistwin.errors import LinkError
from axistwin.links.pacing import Pacer
from axistwin.links.plug import CHUNK
from axistwin.links.serialdev import Lines, control_lines, settings_of, why
from axistwin.sim.frames import LineError, UartFormat
from axistwin.sim.pins import Pin
from axistwin.sim.serial import Uart
from axistwin.sim.serial_port import SerialPort
from axistwin.sim.wirings import direct

if TYPE_CHECKING:
    import serial

log = getLogger("axistwin.links")

LOOK_S = 0.01
"""So often the control lines are looked at while nothing is said; nothing tells when they change."""


MOST_WAITING = 1000
"""A device that has left so many things undone is given up."""
LAST_WORDS_S = 1.0
"""So long what is still to be done at the end may take."""


class Through(Uart):
    """The end of the line, where the real one begins: it takes characters in whatever format."""

    def understands(self, sent: UartFormat) -> bool:  # noqa: ARG002
        """It need not."""
        return True


class Relay:
    """A bench with one line, `name`, that leads to a real device.

    `url`: a device or what pyserial calls a URL.  `line`: the format to begin with.  Raises LinkError if it cannot be
    opened.
    """

    def __init__(self, url: str, name: str, line: UartFormat) -> None:
        self.bench, self.url = Bench(), url
        self._device = _open(url, line)
        clock = self.bench.clock
        self._through = Through(clock, line, on_receive=self._to_device)
        wiring = direct(self._through, instant=True)
        self.port = SerialPort(clock, wiring, Pin(clock, "dtr", True), Pin(clock, "rts", True), line=line)
        self.bench.lines[name] = SharedLine(self.port, ())
        self._applied = line
        self._outgoing = bytearray()
        self._closing = False
        self._lines: Lines | None = None
        self._thread: Thread | None = None
        self.raw = url.startswith("socket://")
        """Whether the device can be told nothing but characters."""
        self._hands = ThreadPoolExecutor(1, "axistwin-device")
        self._latest: Future[None] | None = None
        self._asked, self._done = 0, 0
        self._told: set[str] = set()

    def start(self, pacer: Pacer, lost: Callable[[LinkError], None]) -> None:
        """From now on pass on; `lost` is told when the device is gone.  Within the event loop of the pacer."""
        self._pacer, self._lost, self._loop = pacer, lost, asyncio.get_running_loop()
        self._lines = control_lines(self._device)
        if self._lines is not None:
            self._show_lines(self._lines.dsr, self._lines.cts)
        host = self.port.host
        host.dtr_line.watch(lambda _: self._drive())
        host.rts_line.watch(lambda _: self._drive())
        self.port.watch_breaks(self._break)
        pacer.watch(self._pass_on)
        self._thread = Thread(target=self._listen, daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Let go of the device."""
        self._closing = True
        if self._thread is not None:
            self._thread.join()  # which looks up often
        if self._latest is not None:
            wait([self._latest], LAST_WORDS_S)
        self._hands.shutdown(wait=False, cancel_futures=True)
        self._device.close()

    # From the host

    def _to_device(self, byte: int, errors: LineError) -> None:
        if not errors:  # a break is passed on by itself
            self._outgoing.append(byte)

    def _pass_on(self) -> None:
        """The bench has been advanced: what has come from the host goes out, in the format that the host has now."""
        if self.port.host.format != self._applied:
            self._applied = self._through.format = self.port.host.format
            settings = settings_of(self._applied)
            self._at_the_device(f"do {self._applied}", partial(self._device.apply_settings, settings))
        if self._outgoing:
            data, self._outgoing = bytes(self._outgoing), bytearray()
            self._soon(partial(self._write, data))

    def _drive(self) -> None:
        if self._lines is not None:
            host = self.port.host
            self._at_the_device("set DTR and RTS", partial(_set_lines, self._lines, host.dtr, host.rts))

    def _break(self, seconds: float) -> None:
        self._pass_on()
        self._at_the_device("send a break", partial(setattr, self._device, "break_condition", True))
        self._loop.call_later(seconds, self._end_break)

    def _end_break(self) -> None:
        self._at_the_device("end a break", partial(setattr, self._device, "break_condition", False))

    def _at_the_device(self, what: str, do: Callable[[], object]) -> None:
        if self.raw:
            self._tell_once("carries characters only: no line format, control lines or breaks are passed on")
        else:
            self._soon(partial(self._try, what, do))

    def _soon(self, do: Callable[[], None]) -> None:
        """Have it done at the device after all that has been asked for before; nobody waits for it."""
        self._asked += 1
        if self._asked - self._done > MOST_WAITING:
            self._gone(TimeoutError("it does not answer"))
        elif not self._closing:
            self._latest = self._hands.submit(self._counted, do)
            asyncio.wrap_future(self._latest)  # tells of a bug

    # At the device, in a thread

    def _counted(self, do: Callable[[], None]) -> None:
        try:
            do()
        finally:
            self._done += 1

    def _write(self, data: bytes) -> None:
        try:
            self._device.write(data)
        except (OSError, ValueError, termios.error) as error:
            if not self._closing:
                self._loop.call_soon_threadsafe(self._gone, error)

    def _try(self, what: str, do: Callable[[], object]) -> None:
        """What the device cannot do is told, and the recording goes on.  That it is gone, `_listen` finds out."""
        try:
            do()
        except (OSError, ValueError, termios.error) as error:
            if not self._closing:
                self._tell_once(f"cannot {what}: {why(error)}")

    def _tell_once(self, words: str) -> None:
        if words not in self._told:
            self._told.add(words)
            log.warning("%s %s", self.url, words)

    # From the device.  `_listen` is the thread.

    def _listen(self) -> None:
        loop = self._loop
        while not self._closing:
            try:
                data = self._read()
                levels = None if self._lines is None else (self._lines.dsr, self._lines.cts)
            except (OSError, TypeError) as error:  # TypeError: how pyserial says that it has been closed meanwhile
                if not self._closing:
                    loop.call_soon_threadsafe(self._gone, error)
                return
            if data or levels not in (None, (self.port.dtr, self.port.rts)):
                loop.call_soon_threadsafe(self._take, data, levels)

    def _read(self) -> bytes:
        """What has come; waits a moment for the first character."""
        data = bytearray(self._device.read(1))
        while data and len(data) < CHUNK and (more := self._device.in_waiting):
            data += self._device.read(more)
        return bytes(data)

    def _take(self, data: bytes, levels: tuple[bool, bool] | None) -> None:
        self._pacer.sync()
        if levels is not None:
            self._show_lines(*levels)
        self._through.format = self.port.host.format
        self._through.send(data)
        self._pacer.work()

    def _show_lines(self, dsr: bool, cts: bool) -> None:
        self.port.dtr_line.set(dsr)
        self.port.rts_line.set(cts)

    def _gone(self, error: Exception) -> None:
        self._lost(LinkError(f"{self.url} is gone: {error}"))


def _set_lines(lines: Lines, dtr: bool, rts: bool) -> None:
    lines.dtr, lines.rts = dtr, rts


def _open(url: str, line: UartFormat) -> "serial.Serial":
    import serial  # late: it is asked for here only

    try:
        return serial.serial_for_url(url, timeout=LOOK_S, **settings_of(line))
    except (OSError, ValueError, termios.error) as error:
        raise LinkError(f"cannot open {url}: {why(error)}: is it there, free, and are you allowed to use it?") from None
