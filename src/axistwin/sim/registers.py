"""A register port: two addresses on a bus, as a host finds them.

    offset   read                          write
    0        output data buffer (FIFO)     input data buffer (FIFO)
    1        status byte                   control byte

The port is the hardware only; what the bits mean is the device's affair.  The device tells when a whole command has
been handed over and when a whole message lies ready, for those who listen in.
"""

from collections import deque
from collections.abc import Callable

from axistwin.errors import UsageError
from axistwin.sim.clock import Clock
from axistwin.sim.host_acts import HostAct, HostActs
from axistwin.sim.pins import Pin

DEPTH = 16
"""Bytes in a FIFO."""

DATA, CONTROL = 0, 1
NOBODY_DRIVES = 0xFF
"""What a host reads from a bus that no board drives."""


class Fifo:
    """Bytes, first in first out.  Full: what is written is lost.  Empty: what is read is 0."""

    def __init__(self, depth: int = DEPTH) -> None:
        self.depth = depth
        self._bytes: deque[int] = deque()

    def __len__(self) -> int:
        return len(self._bytes)

    @property
    def contents(self) -> bytes:
        """All bytes; they stay."""
        return bytes(self._bytes)

    def push(self, value: int) -> None:
        """One byte in."""
        if len(self._bytes) < self.depth:
            self._bytes.append(value)

    def pop(self) -> int:
        """One byte out."""
        return self._bytes.popleft() if self._bytes else 0

    def load(self, data: bytes) -> None:
        """These bytes, and none from before."""
        self._bytes = deque(data[: self.depth])

    def drain(self) -> bytes:
        """All bytes; the FIFO is then empty."""
        data = bytes(self._bytes)
        self._bytes.clear()
        return data


class RegisterPort:
    """The host's side (`read`, `write`, `interrupt`, `init`) and the device's (everything else)."""

    def __init__(self, clock: Clock) -> None:
        self.clock = clock
        self.powered = False
        self.input, self.output = Fifo(), Fifo()
        self._status = 0
        self._doing = HostActs(clock)
        self._watchers: list[Callable[[], None]] = []
        self._listeners: list[Callable[[bytes], None]] = []
        self._hearers: list[Callable[[bytes], None]] = []
        self.interrupt_line = Pin(clock, "interrupt", output=True)
        """The line to the host, for those who want to watch it; high: active."""
        self.on_control: Callable[[int], None] = lambda value: None
        self.on_init: Callable[[], None] = lambda: None

    @property
    def interrupt(self) -> bool:
        """Whether the board interrupts the host."""
        return self.interrupt_line.level

    def read(self, offset: int) -> int:
        """Read a register: 0 the output data buffer, 1 the status byte.  It takes no virtual time."""
        _check("offset", offset, CONTROL)
        if not self.powered:
            return NOBODY_DRIVES
        if offset == CONTROL:
            return self.status
        return self._doing("read", None, lambda _: self.output.pop())

    def write(self, offset: int, value: int) -> None:
        """Write a register: 0 the input data buffer, 1 the control byte.  It takes no virtual time."""
        _check("offset", offset, CONTROL)
        _check("value", value, 0xFF)
        if self.powered:
            self._doing("write", (offset, value), self._write)

    def _write(self, where_and_what: tuple[int, int]) -> None:
        offset, value = where_and_what
        if offset == DATA:
            self.input.push(value)
        else:
            self.on_control(value)

    def init(self) -> None:
        """The bus's reset line is activated."""
        if self.powered:
            self._doing("init", None, lambda _: self.on_init())

    def watch_host(self, watcher: Callable[[HostAct], None]) -> Callable[[], None]:
        """Call `watcher(act)` before everything that a host does here and that changes something.

        Kinds, with their values: `read` of the data buffer (None), `write` (offset, byte), `init` (None).  An unpowered
        board notices none of them.  Returns what ends the watching.
        """
        return self._doing.watch(watcher)

    def perform(self, act: HostAct) -> None:
        """Do, from the host's side, what such an act says."""
        match act.kind:
            case "read":
                self.read(DATA)
            case "write":
                self.write(*act.value)
            case "init":
                self.init()
            case _:
                raise UsageError(f"a host on a bus cannot {act.kind!r}")

    @property
    def status(self) -> int:
        """The status byte, as the device has set it."""
        return self._status

    @status.setter
    def status(self, value: int) -> None:
        if value != self._status:
            self._status = value
            _call(self._watchers)

    # For those who listen in

    def watch(self, watcher: Callable[[], None]) -> Callable[[], None]:
        """Call `watcher` whenever the status byte has changed.  Returns what ends it."""
        return _join(self._watchers, watcher)

    def listen(self, listener: Callable[[bytes], None]) -> Callable[[], None]:
        """Call `listener` with each command that the host hands over.  Returns what ends it."""
        return _join(self._listeners, listener)

    def hear(self, hearer: Callable[[bytes], None]) -> Callable[[], None]:
        """Call `hearer` with each message that lies ready for the host.  Returns what ends it."""
        return _join(self._hearers, hearer)

    def told(self, command: bytes) -> None:
        """From the device: the host has handed over this command."""
        _call(self._listeners, command)

    def said(self, message: bytes) -> None:
        """From the device: this message lies ready."""
        _call(self._hearers, message)


def _join(those: list[Callable[..., None]], one: Callable[..., None]) -> Callable[[], None]:
    those.append(one)
    return lambda: those.remove(one)


def _call(those: list[Callable[..., None]], *words: bytes) -> None:
    for one in tuple(those):
        one(*words)


def _check(what: str, value: object, highest: int) -> None:
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= highest:
        raise UsageError(f"no {what} {value!r} on this bus: give an integer from 0 to {highest}")
