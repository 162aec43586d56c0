"""A serial connector for several TCP clients.  Requests are sent one after the other; every client receives every
answer.

A request of a client ends with the terminator, or after 50 ms without a character in either direction.  While a request
and its answer are in progress, requests of other clients wait; among waiting clients the one that has waited longest is
next.  A line is sent as a whole, even while its client is alone: a half one would swallow the first request of the next
client, or become part of it.  It waits in the seat of its client, and leaves with it.
"""

import asyncio
import re
from collections.abc import Callable

from axistwin.links.plug import FULL, Plug
from axistwin.links.single_client import log
from axistwin.links.tcp import TcpClient
from axistwin.sim.frames import LineError
from axistwin.sim.serial_port import Flow

TERMINATOR = b"\r"  # End of a command line of an IF1, an IF2 and a SmartMotor.
LINES = re.compile(rb"(?:[^\r\n]*[\r\n])*(?:[^\r\n]*#)?[(%]*")
"""Lines of an IF1 or IF2, and behind them what acts without an end of line; # discards what is before it."""
WORDS = re.compile(rb'(?:(?:[^"\r\n\0 ]|"[^"\r\n\0]*(?:"|(?=[\r\n\0])))*[\r\n\0 ])*')
"""Commands of a SmartMotor: a space ends one, too, except between quotation marks."""
LONGEST_LINE = FULL  # Longest line in bytes; a client that sends more without an end is disconnected.
SILENCE_S = 0.05
MOST_SEATS = 100
LONGEST_S = 2.0  # Longest time from the end of a request to the next client's, if a controller always transmits.


class Seat:
    """Connection of a TCP client that shares a serial port with other TCP clients."""

    def __init__(self, hub: "Hub") -> None:
        self._hub = hub
        self.client: TcpClient | None = None
        self.waiting = bytearray()  # Characters that have not been sent to the controller.

    @property
    def name(self) -> str:
        return self._hub.plug.name

    @property
    def chunk(self) -> int:
        return self._hub.plug.chunk

    @property
    def full(self) -> bool:
        return self._hub.plug.full or len(self.waiting) > FULL

    def connect(self, client: TcpClient) -> bool:
        self.client = client
        if not self._hub.enter(self):
            self.client = None
        return self.client is not None

    def disconnect(self, client: TcpClient) -> None:
        if self.client is client:
            self._hub.leave(self)
            self.client = None

    def send(self, data: bytes) -> None:
        """Queue characters for the controller, behind the waiting requests of other clients."""
        self.waiting += data
        self._hub.pump(self)
        if len(self.waiting) - self._hub.sendable(self) > LONGEST_LINE:
            self._refuse_line()
        if self.full and self.client is not None:
            self.client.pause()

    def _refuse_line(self) -> None:
        if self.client is not None:
            log.warning(
                "%s: %s sends more than %d characters without an end of line and is disconnected: "
                "end each line with CR", self.name, self.client.name, LONGEST_LINE,
            )  # fmt: skip
            self.client.drop()
        self.waiting.clear()


class Hub:
    """The only client of a plug: it sends the requests of its seats, and distributes the answers."""

    flow: Flow | None = None

    def __init__(self, plug: Plug, *, motors: bool = False, plain: bool = False) -> None:
        """`motors`: commands of SmartMotors; `plain`: requests of which only their pauses are known."""
        self.plug, self.name, self._motors, self._plain = plug, "", motors, plain
        self._seats: list[Seat] = []
        self._queue: list[Seat] = []  # Waiting for a turn, longest wait first; without the present one.
        self._turn: Seat | None = None
        self._complete = False  # True after the terminator of the present request.
        self._complete_at_s = 0.0
        self._last: tuple[Seat | None, bytes] = None, b""  # Who has sent the last character, and the character.
        self._timer: asyncio.TimerHandle | None = None

    def seat(self) -> TcpClient:
        return TcpClient(Seat(self))

    # From the seats

    def enter(self, seat: Seat) -> bool:
        if len(self._seats) >= MOST_SEATS or self.plug.refuses_because or not (self._seats or self.plug.connect(self)):
            return False
        self._seats.append(seat)
        self._rename()
        return True

    def leave(self, seat: Seat) -> None:
        """Remove a seat; the plug is released with the last one."""
        if seat not in self._seats:
            return
        self._seats.remove(seat)
        self._rename()
        seat.waiting.clear()
        if seat in self._queue:
            self._queue.remove(seat)
        if self._turn is seat:
            self._complete = True  # A disconnected client cannot finish its request: treat the request as complete.
        if not self._seats:
            self._end_turn()
            self.plug.disconnect(self)

    def _rename(self) -> None:
        self.name = ", ".join(seat.client.name for seat in self._seats if seat.client is not None)

    def pump(self, seat: Seat) -> None:
        end = self.sendable(seat)
        if not end:
            return
        if self._turn not in (None, seat) or (self._complete and self._queue):
            if seat not in self._queue:
                self._queue.append(seat)
            return
        self._turn = seat
        one = seat.waiting.find(TERMINATOR) + 1 if self._queue and not self._plain else 0
        first = bytes(seat.waiting[: one or end])
        del seat.waiting[: len(first)]
        self._complete = first[-1:] in self._ends
        self._complete_at_s = asyncio.get_running_loop().time()
        if self.sendable(seat):
            self._queue.append(seat)
        self._restart_timer()
        self.plug.send(self._closing(seat, first) + first)

    def sendable(self, seat: Seat) -> int:
        """Return the number of waiting characters without the half line at their end.

        Bytes from 80h of a SmartMotor, and what follows them in the same turn, are sent as they come.
        """
        if self._plain:
            return len(seat.waiting)
        if self._motors and ((self._turn is seat and not self._complete) or not seat.waiting.isascii()):
            return len(seat.waiting)
        whole = (WORDS if self._motors else LINES).match(seat.waiting)
        return whole.end() if whole else 0

    @property
    def _ends(self) -> tuple[bytes, ...]:
        return (b"\r", b"\n", b"\0", b" ") if self._motors else (b"\r", b"\n")

    def _closing(self, seat: Seat, request: bytes) -> bytes:
        """Return the end of line that another client of an IF1 or IF2 has left out, e.g. behind #; usually none."""
        (owner, last), end = self._last, request[-1:]
        self._last = seat, end
        if self._motors or self._plain:
            return b""
        missing = owner is not seat and last not in (b"", b"(", end) and end in self._ends
        return end if missing else b""

    def _restart_timer(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
        loop = asyncio.get_running_loop()
        latest_s = self._complete_at_s + LONGEST_S
        self._timer = loop.call_at(min(loop.time() + SILENCE_S, latest_s), self._silent)

    def _silent(self) -> None:
        if self.plug.serial.pending:
            self._complete_at_s = asyncio.get_running_loop().time()
            self._restart_timer()
            return
        self._end_turn()
        if self._queue:
            seat = self._queue.pop(0)
            self.pump(seat)
            if seat.client is not None and not seat.full:
                seat.client.resume()

    def _end_turn(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._turn, self._complete, self._timer = None, False, None

    # From the plug

    def hung_up(self) -> bool:
        return False

    def drop(self) -> None:
        self._each(TcpClient.drop)

    def pause(self) -> None:
        self._each(TcpClient.pause)

    def resume(self) -> None:
        for seat in self._seats:
            if seat.client is not None and not seat.full:
                seat.client.resume()

    def deliver(self, data: bytes, errors: LineError) -> None:
        if self._turn is not None:
            self._restart_timer()
        self._each(lambda client: client.deliver(data, errors))

    def _each(self, act: Callable[[TcpClient], None]) -> None:
        for seat in tuple(self._seats):
            if seat.client is not None:
                act(seat.client)
