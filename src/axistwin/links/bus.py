"""The bus socket: the registers of a board on a bus, over TCP, in lines that anyone can type.

request         answer          meaning
r 1             50              read a register: the offset; two hex digits
r 0 16          80 00 00 …      read it so many times
w 1 10          ok              write a register: the offset, and one byte or several in hex
i               0               the interrupt line: 1 while the board interrupts
s 1             ok              from now on `! 1` and `! 0` tell at once when that line changes; s 0 ends it
init            ok              the bus's reset line

What is wrong is answered by one line, `error: …`, and nothing is done.  An access takes no virtual time; what a write
sets off happens after the answer.  A bus has one master: one client at a time is connected, as with a serial plug.

A client that does not read its answers is not read from until it does.  Meanwhile changes of the interrupt line are
not queued: it is told the last one.  `docs/bus.md` has it all.
"""

from collections.abc import Callable

from axistwin.errors import AxistwinError, UsageError
from axistwin.links.one import OneClient
from axistwin.links.pacing import Pacer
from axistwin.links.tcp import Connection
from axistwin.sim.pins import Pin
from axistwin.sim.registers import CONTROL, RegisterPort

LONGEST = 1024
"""Bytes of a line; a longer one is refused, and nothing is kept of it."""
MOST = 256
"""Bytes of a block transfer."""
USAGE = "r OFFSET [COUNT], w OFFSET HH …, i, s 0|1 or init"


class Slot(OneClient["Master"]):
    """A board's slot on the bus.  `reset`: what is done for each new client."""

    def __init__(
        self, name: str, bus: RegisterPort, pacer: Pacer, *, reset: Callable[[], object] = lambda: None
    ) -> None:
        super().__init__(name, pacer)
        self.bus, self.reset = bus, reset

    @property
    def full(self) -> bool:
        """Whether the client is not read from, as it does not read or is not heard."""
        return self._deaf or (self.client is not None and self.client.stalled)

    def begin(self) -> None:
        """A client has come."""
        self.reset()

    def exchange(self, bus: RegisterPort) -> None:
        """These registers take the place of the ones before.  They are left as they are."""
        self.bus = bus
        self.exchanged()

    def hand_over(self) -> None:
        """Tell the client what there is to tell by now."""
        if self.client is not None:
            self.client.flush()


class Master(Connection):
    """A client: a host with the board on its bus."""

    def __init__(self, slot: Slot) -> None:
        super().__init__(slot)
        self.slot = slot
        self._line = b""
        self._too_long = False
        self._unwatch: Callable[[], None] | None = None
        self._changes: list[bool] = []
        self._told = False

    def received(self, data: bytes) -> None:
        """Requests, or parts of them."""
        *lines, self._line = (self._line + data).split(b"\n")
        pacer = self.slot.pacer
        for line in lines:
            too_long, self._too_long = self._too_long or len(line) > LONGEST, False
            if too_long or line.strip():
                pacer.sync()
                self._write(self._answer(line, too_long))
                pacer.work()
        if len(self._line) > LONGEST:
            self._line, self._too_long = b"", True

    def _answer(self, request: bytes, too_long: bool) -> str:
        try:
            if too_long:
                raise UsageError(f"a line has at most {LONGEST} characters")
            return self._obey(request.decode("ascii", "replace").split())
        except AxistwinError as error:
            return f"error: {error}"

    def _obey(self, words: list[str]) -> str:
        match words:
            case ["r", offset]:
                return f"{self.slot.bus.read(_offset(offset)):02x}"
            case ["r", offset, count]:
                return self._read(_offset(offset), _count(count))
            case ["w", offset, *values] if values:
                return self._store(_offset(offset), [_byte(value) for value in values])
            case ["i"]:
                return str(int(self.slot.bus.interrupt))
            case ["s", "0" | "1" as on]:
                self._subscribe(on == "1")
                return "ok"
            case ["init"]:
                self.slot.bus.init()
                return "ok"
        raise UsageError(f"no request {_shown(' '.join(words))}: there are {USAGE}")

    def _read(self, offset: int, count: int) -> str:
        return " ".join(f"{self.slot.bus.read(offset):02x}" for _ in range(count))

    def _store(self, offset: int, values: list[int]) -> str:
        if len(values) > MOST:
            raise UsageError(f"{len(values)} bytes are too many: a block has at most {MOST}")
        for value in values:
            self.slot.bus.write(offset, value)
        return "ok"

    # The interrupt line

    def _subscribe(self, on: bool) -> None:
        self._end_subscription()
        if on:
            self._told = self.slot.bus.interrupt
            self._unwatch = self.slot.watch(lambda: self.slot.bus.interrupt_line, self._changed)

    def _end_subscription(self) -> None:
        if self._unwatch is not None:
            self._unwatch()
        self._unwatch = None
        self._changes.clear()

    def _changed(self, line: Pin) -> None:
        if not self._changes:
            self.slot.pacer.mark(self)
        self._changes.append(line.level)

    def flush(self) -> None:
        """Tell how the interrupt line has changed."""
        changes, self._changes = self._changes, []
        if not self.stalled:
            for level in changes:
                self._tell(level)

    def _tell(self, level: bool) -> None:
        self._told = level
        self._write(f"! {level:d}")

    # A client that does not read, or has gone

    def pause_writing(self) -> None:
        """It does not read: nothing more is taken from it."""
        self.stalled = True
        self.pause()

    def resume_writing(self) -> None:
        """It reads again."""
        self.stalled = False
        if not self.slot.full:
            self.resume()
        if self._unwatch is not None and self._told is not self.slot.bus.interrupt:
            self._tell(self.slot.bus.interrupt)

    def resume(self) -> None:
        """Go on taking what it sends, unless it does not read."""
        if not self.stalled:
            super().resume()

    def connection_lost(self, exc: Exception | None) -> None:
        """The client has gone."""
        self._end_subscription()
        super().connection_lost(exc)

    def _write(self, line: str) -> None:
        if not self._transport.is_closing():
            self._transport.write(line.encode() + b"\n")


def _offset(text: str) -> int:
    return _number(text, 10, CONTROL, "offset")


def _count(text: str) -> int:
    count = _number(text, 10, MOST, "count")
    if not count:
        raise UsageError(f"no count '0': give a number from 1 to {MOST}")
    return count


def _byte(text: str) -> int:
    return _number(text, 16, 0xFF, "byte")


def _number(text: str, base: int, highest: int, what: str) -> int:
    digits = "0123456789abcdefABCDEF" if base == 16 else "0123456789"
    if not set(text) <= set(digits) or len(text) > 3 or int(text, base) > highest:
        limits = "two hex digits" if base == 16 else f"a number from 0 to {highest}"
        raise UsageError(f"no {what} {_shown(text)}: give {limits}")
    return int(text, base)


def _shown(text: str) -> str:
    return repr(text if len(text) <= 20 else f"{text[:20]}…")
