"""The bus socket: access to the registers of a board over TCP, in text lines.

request         answer          meaning
r 1             50              read a register: the offset; two hex digits
r 0 16          80 00 00 …      read a register repeatedly: the offset, the count
w 1 10          ok              write a register: the offset, and one byte or several in hex
i               0               read the interrupt line: 1 while the board interrupts
s 1             ok              report each change of the interrupt line as `! 1` or `! 0`; s 0 ends the reports
init            ok              pulse the reset line of the bus

An invalid request has no effect and is answered by one line, `error: …`.  An access takes no virtual time.  The effects
of a write occur after its answer.  A bus has one master: only one client can be connected.

No requests are read from a client that does not read its answers.  During that time changes of the interrupt line are
not queued; afterwards the client receives the last level.  See `docs/bus.md`.
"""

from collections.abc import Callable
from typing import Protocol

from axistwin.core.errors import AxistwinError, UsageError
from axistwin.links.pacing import Pacer
from axistwin.links.single_client import Gate, SingleClient
from axistwin.links.tcp import Connection
from axistwin.sim.pins import Pin
from axistwin.sim.registers import CONTROL

LONGEST_LINE = 1024  # Longest request line in bytes; a longer line is discarded and answered with an error.
MAX_BLOCK = 256


class Registers(Protocol):
    """Interface for reading and writing the registers of a board.  `RegisterPort` implements this interface."""

    @property
    def interrupt(self) -> bool: ...

    @property
    def interrupt_line(self) -> Pin: ...

    def read(self, offset: int) -> int: ...

    def write(self, offset: int, value: int) -> None: ...

    def init(self) -> None: ...


class Slot(SingleClient["Master"]):
    """The slot of a board on the bus, for one client.  `reset` is called for each new client."""

    def __init__(
        self, name: str, bus: Registers, pacer: Pacer, *, reset: Callable[[], object] = lambda: None,
        gate: Gate | None = None,
    ) -> None:  # fmt: skip
        super().__init__(name, pacer, gate)
        self.bus, self.reset = bus, reset

    @property
    def full(self) -> bool:
        """True while no requests are read from the client: the gate is closed, or the client does not read answers."""
        return self.gate.closed or (self.client is not None and self.client.stalled)

    def begin(self) -> None:
        self.reset()

    def flush_pending(self) -> None:
        if self.client is not None:
            self.client.flush()


class Master(Connection):
    """A client that is connected to the bus socket and acts as the bus master."""

    answers = True

    def __init__(self, slot: Slot) -> None:
        super().__init__(slot)
        self.slot, self._line, self._too_long = slot, b"", False
        self._unsubscribe: Callable[[], None] | None = None
        self._changes: list[bool] = []
        self._last_reported = False

    def received(self, data: bytes) -> None:
        *lines, self._line = (self._line + data).split(b"\n")
        pacer = self.slot.pacer
        for line in lines:
            too_long, self._too_long = self._too_long or len(line) > LONGEST_LINE, False
            if too_long or line.strip():
                pacer.sync()
                self.slot.heard_ns = pacer.clock.now
                self._write(self._answer(line, too_long))
                pacer.work()
        if len(self._line) > LONGEST_LINE:
            self._line, self._too_long = b"", True

    def _answer(self, request: bytes, too_long: bool) -> str:
        try:
            if too_long:
                raise UsageError(
                    f"the bus request is too long: expected at most {LONGEST_LINE} characters, e.g. `r 0 16`"
                )
            return self._execute(request.decode("ascii", "replace").split())
        except AxistwinError as error:
            return f"error: {error}"

    def _execute(self, words: list[str]) -> str:
        match words:
            case ["r", offset]:
                return f"{self.slot.bus.read(_offset(offset)):02x}"
            case ["r", offset, count]:
                number, times = _offset(offset), _count(count)
                return " ".join(f"{self.slot.bus.read(number):02x}" for _ in range(times))
            case ["w", offset, *values] if values:
                return self._store(_offset(offset), [_number(value, 16, 0xFF, "byte") for value in values])
            case ["i"]:
                return str(int(self.slot.bus.interrupt))
            case ["s", "0" | "1" as on]:
                self._subscribe(on == "1")
                return "ok"
            case ["init"]:
                self.slot.bus.init()
                return "ok"
        raise UsageError(f"unknown request {_shown(' '.join(words))}: expected r, w, i, s or init, e.g. r 0")

    def _store(self, offset: int, values: list[int]) -> str:
        if len(values) > MAX_BLOCK:
            raise UsageError(f"cannot write {len(values)} bytes in one request: expected at most {MAX_BLOCK}")
        for value in values:
            self.slot.bus.write(offset, value)
        return "ok"

    # Functions that report changes of the interrupt line

    def _subscribe(self, on: bool) -> None:
        self._end_subscription()
        if on:
            self._last_reported = self.slot.bus.interrupt
            self._unsubscribe = self.slot.bus.interrupt_line.subscribe(self._changed)

    def _end_subscription(self) -> None:
        if self._unsubscribe is not None:
            self._unsubscribe()
        self._unsubscribe = None
        self._changes.clear()

    def _changed(self, line: Pin) -> None:
        if not self._changes:
            self.slot.pacer.request_flush(self)
        self._changes.append(line.level)

    def flush(self) -> None:
        changes, self._changes = self._changes, []
        if not self.stalled:
            for level in changes:
                self._report(level)

    def _report(self, level: bool) -> None:
        self._last_reported = level
        self._write(f"! {level:d}")

    # Functions that handle slow and disconnected clients

    def resume_writing(self) -> None:
        super().resume_writing()
        if self._unsubscribe is not None and self._last_reported is not self.slot.bus.interrupt:
            self._report(self.slot.bus.interrupt)

    def connection_lost(self, exc: Exception | None) -> None:
        self._end_subscription()
        super().connection_lost(exc)

    def _write(self, line: str) -> None:
        if not self._transport.is_closing():
            self.transmit(line.encode() + b"\n")


def _offset(text: str) -> int:
    return _number(text, 10, CONTROL, "offset")


def _count(text: str) -> int:
    return _number(text, 10, MAX_BLOCK, "number of bytes", lowest=1)


def _number(text: str, base: int, highest: int, parameter: str, lowest: int = 0) -> int:
    digits = "0123456789abcdefABCDEF" if base == 16 else "0123456789"
    if not set(text) <= set(digits) or len(text) > 3 or not lowest <= int(text, base) <= highest:
        if base == 16:
            raise UsageError(f"invalid byte {_shown(text)}: expected two hex digits, e.g. 8F")
        raise UsageError(
            f"invalid {parameter} {_shown(text)}: expected a number from {lowest} to {highest}, e.g. {lowest}"
        )
    return int(text, base)


def _shown(text: str) -> str:
    return repr(text if len(text) <= 20 else f"{text[:20]}…")
