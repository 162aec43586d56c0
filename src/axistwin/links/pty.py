"""A pseudo terminal, for host programs that open a serial device.

Linux passes the client's baud rate, stop bits and odd parity to this end, but not data bits and even parity.  A pty has
no control lines and no break.  Settings that are not passed on are those of `--line`.  A baud rate of 0 sets DTR and
RTS off.  Use RFC
2217 for all settings.

A client is connected from its first setting or character until the client closes the device.  This end holds
the device open only while no client is connected.  While a client is connected, reading fails as soon as the last
client closes the device, which shows that the client has disconnected.
"""

import asyncio
import errno
import fcntl
import logging
import os
import select
import struct
import termios
import tty
from contextlib import ExitStack
from pathlib import Path

from axistwin.core.errors import LinkError, reason
from axistwin.links.manual_pacer import ManualPacer
from axistwin.links.plug import Plug
from axistwin.links.urls import PortUrl
from axistwin.links.writer import Writer
from axistwin.sim.frames import FASTEST_BAUD, LineError, UartFormat
from axistwin.sim.serial_port import Flow

_log = logging.getLogger("axistwin.links")
EXTPROC = 0o200000  # This terminal flag makes Linux report every change of the line settings.
TIOCPKT_IOCTL = 0x40
FLUSHED = termios.TIOCPKT_FLUSHREAD | termios.TIOCPKT_FLUSHWRITE
TCGETS2, TCSETS2 = 0x802C542A, 0x402C542B
# Byte layout of the Linux structure `termios2`, which contains the settings of a terminal
TERMIOS2 = struct.Struct("4I20s2I")
CBAUD, BOTHER = 0o010017, 0o010000


class PtyPort:
    """A pseudo terminal, its symbolic link, and its client."""

    flow: Flow | None = None

    def __init__(self, plug: Plug, url: PortUrl) -> None:
        self.plug = plug
        self._refused = self._closed = False
        self._link = Path(url.path) if url.path else None
        self._loop = asyncio.get_running_loop()
        self._open_pair()
        self.url = PortUrl("pty", path=url.path or self.device)
        self.name = str(self.url)
        self._make_link()
        self._begin()
        self._subscriptions = ExitStack()
        self._subscriptions.callback(plug.hang_ups.subscribe(lambda _: self._loop.call_soon(self._follow_hang_up)))
        if isinstance(plug.pacer, ManualPacer):
            self._subscriptions.callback(plug.pacer.settling.subscribe(self._settle))

    def _open_pair(self) -> None:
        self._master, slave = os.openpty()
        self._gone = False
        self.device = os.ttyname(slave)
        self._slave: int | None = slave
        tty.setraw(slave)
        self._show(self.plug.default_format)
        self._fresh = fcntl.ioctl(self._master, TCGETS2, bytes(TERMIOS2.size))
        self._report_settings(on=True)
        os.set_blocking(self._master, False)

    def _begin(self) -> None:
        self._writer = Writer(self._master, f"{self.plug.name}: {self.name}")
        self._loop.add_reader(self._master, self._readable)

    def _report_settings(self, *, on: bool) -> None:
        fcntl.ioctl(self._master, termios.TIOCPKT, struct.pack("i", on))

    def _make_link(self) -> None:
        """Create the link to the pseudo terminal; replace only a dead one, which a killed server leaves."""
        if self._link is None:
            return
        try:
            if self._link.is_symlink() and (not self._link.exists() or os.readlink(self._link) == self.device):
                self._link.unlink()
            self._link.symlink_to(self.device)
        except FileExistsError:
            self._close_files()
            raise LinkError(
                f"cannot create {self.url}: the file {self._link} already exists; choose another path"
            ) from None
        except OSError as error:
            self._close_files()
            raise LinkError(f"cannot create {self.url}: {reason(error)}; choose another path") from None

    def close(self) -> None:
        self._closed = True
        self._subscriptions.close()
        self._take_away()

    def _take_away(self) -> None:
        if self._gone:
            return
        self._gone = True
        self._loop.remove_reader(self._master)
        self._writer.clear()
        self.plug.disconnect(self)
        if self._link is not None and self._link.is_symlink() and os.readlink(self._link) == self.device:
            self._link.unlink()
        self._close_files()

    def _follow_hang_up(self) -> None:
        if self._closed:
            return
        if self.plug.serial.hung_up.level:
            self._take_away()
        elif self._gone:
            before = self.device
            self._replace()
            if self._link is None and self.device != before:
                _log.warning("%s: %s has come back as %s", self.plug.name, before, self.device)

    def _close_files(self) -> None:
        os.close(self._master)
        self._let_go()

    # Functions that receive data from the client

    def _readable(self) -> None:
        try:
            # The first byte from a pseudo terminal is the type of the packet.
            packet = os.read(self._master, 1 + self.plug.chunk)
        except BlockingIOError:
            return
        except OSError as error:
            if error.errno != errno.EIO:
                raise
            self._hold()
            self.plug.disconnect(self)
            return
        # If no client is connected to this port, ignore a report that the terminal's buffers were cleared.
        if packet[0] | FLUSHED == FLUSHED and packet[0] and self.plug.client is not self:
            return
        if self._connect():
            self._take(packet[0], packet[1:])

    def _take(self, happened: int, data: bytes) -> None:
        if happened & TIOCPKT_IOCTL:
            self.plug.change(self._take_over_settings)
        if happened & termios.TIOCPKT_FLUSHREAD:
            self._writer.clear()
        if happened & termios.TIOCPKT_FLUSHWRITE:
            self.plug.change(self.plug.serial.drop_pending)
        if data:
            self.plug.send(data)

    def _connect(self) -> bool:
        """True if a client is connected; a refused one is not tried again before it closes the device."""
        if self.plug.client is self:
            return True
        if self._refused:
            return False
        self._let_go()
        self._refused = not self.plug.connect(self)
        if not self._refused:
            self.plug.change(self._take_over_settings)
        return not self._refused

    def _let_go(self) -> None:
        if self._slave is not None:
            os.close(self._slave)
            self._slave = None

    def _hold(self) -> None:
        """Keep the pseudo terminal open until the next client opens the device, as if it had just been made.

        All buffers are emptied, and what the client has left (settings, exclusive use) is undone.  Without the right to
        open a terminal in exclusive use, another pseudo terminal takes its place.
        """
        if self._slave is None:
            try:
                self._slave = os.open(self.device, os.O_RDWR | os.O_NOCTTY)
            except OSError as error:
                if error.errno != errno.EBUSY:
                    raise
                self._renew()
        assert self._slave is not None
        fcntl.ioctl(self._slave, termios.TIOCNXCL)
        self._report_settings(on=False)
        fcntl.ioctl(self._master, TCSETS2, self._fresh)
        self._report_settings(on=True)
        termios.tcflush(self._slave, termios.TCIOFLUSH)
        self._refused = False
        self._writer.clear()

    def _renew(self) -> None:
        before = self.device
        self._loop.remove_reader(self._master)
        os.close(self._master)
        self._replace()
        if self._link is None:
            _log.warning("%s: a client has left %s in exclusive use: now %s", self.plug.name, before, self.device)

    def _replace(self) -> None:
        self._open_pair()
        if self._link is None:
            self.url = PortUrl("pty", path=self.device)
            self.name = str(self.url)
        self._make_link()
        self._begin()

    def _take_over_settings(self) -> None:
        _, _, flags, _, _, _, speed = self._settings()
        host, usual = self.plug.serial.host, self.plug.default_format
        host.dtr = host.rts = speed > 0
        host.format = UartFormat(
            min(speed, FASTEST_BAUD) or host.format.baudrate, usual.bytesize,
            "O" if flags & termios.PARODD else usual.parity, 2 if flags & termios.CSTOPB else 1,
        )  # fmt: skip

    # Functions that send data to the client

    def deliver(self, data: bytes, errors: LineError) -> None:  # noqa: ARG002
        self._writer.write(data)

    def hung_up(self) -> bool:
        """True if the client has closed the pseudo terminal.  The value is valid also while reading is paused."""
        poll = select.poll()
        poll.register(self._master, select.POLLHUP)
        return bool(poll.poll(0))

    def _settle(self) -> None:
        """Let Linux pass on what is queued in both directions.

        It does so when an end without input is polled, otherwise later, by a thread of its own; until then a client
        would count as waiting for an answer that has been sent.
        """
        if self._gone or self.hung_up():
            return
        try:
            client = os.open(self.device, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        except OSError:  # The client uses the device alone.
            return
        select.select([client], [], [], 0)
        os.close(client)

    def drop(self) -> None:
        if not self._gone and not self.plug.serial.hung_up.level:
            self._hold()
            self.resume()

    def pause(self) -> None:
        if not self._gone:
            self._loop.remove_reader(self._master)

    def resume(self) -> None:
        if not self._gone:
            self._loop.add_reader(self._master, self._readable)

    # Settings

    def _settings(self) -> tuple[int, int, int, int, bytes, int, int]:
        settings: tuple[int, int, int, int, bytes, int, int] = TERMIOS2.unpack(
            fcntl.ioctl(self._master, TCGETS2, bytes(TERMIOS2.size))
        )
        return settings

    def _show(self, fmt: UartFormat) -> None:
        iflag, oflag, flags, lflag, characters, _, _ = self._settings()
        flags = flags & ~(CBAUD | termios.CSTOPB | termios.PARODD) | getattr(termios, f"B{fmt.baudrate}", BOTHER)
        flags |= termios.CSTOPB if fmt.stopbits > 1 else 0
        flags |= termios.PARODD if fmt.parity == "O" else 0
        packed = TERMIOS2.pack(iflag, oflag, flags, lflag | EXTPROC, characters, fmt.baudrate, fmt.baudrate)
        fcntl.ioctl(self._master, TCSETS2, packed)
