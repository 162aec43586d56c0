"""The channel to a motion board: numbered blocks with acknowledgement.  After a loss, all later blocks are repeated."""

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from axistwin.real.standin import frames

WINDOW = 12  # Largest number of unacknowledged blocks; the sequence number has four bits.
LEAST_TIMEOUT_S, MOST_TIMEOUT_S = 0.025, 0.5
RECEIVE_WINDOW = 192  # Size of a board's receive buffer in bytes, if its dictionary has no RECEIVE_WINDOW.


@dataclass
class _Sent:
    content: bytes
    data: bytes
    at_s: float
    again: bool = False  # True if the block has been sent more than once.
    lost: bool = False  # True if the board has requested the block again.


class Channel:
    """Converts commands to bytes for a board, and its bytes to responses; it does no input or output."""

    def __init__(self, window: int = RECEIVE_WINDOW) -> None:
        self.window = window  # Size of the board's receive buffer in bytes.
        self._reader = frames.Reader()
        self._first = 0  # Number of the oldest message block that the board has not acknowledged.
        self._agreed = False  # True after the board has acknowledged at least one message block.
        self._unacknowledged: deque[_Sent] = deque()
        self._waiting: deque[tuple[bytes, Callable[[float], None]]] = deque()
        self._timeout_s = LEAST_TIMEOUT_S
        self._silent_since_s: float | None = None
        self._gone_back_to = -1
        self.again = 0  # Number of blocks that were sent more than once.

    @property
    def damaged(self) -> int:
        """Number of times that damaged bytes from the board were dropped."""
        return self._reader.damaged

    @property
    def idle(self) -> bool:
        return not self._waiting and not self._unacknowledged

    def send(self, content: bytes, sent: Callable[[float], None] = lambda at_s: None) -> None:
        """Queue a command; small ones share a block.  `sent(at_s)` is called when its block is first sent."""
        self._waiting.append((content, sent))

    def silent_s(self, now_s: float) -> float:
        """Return the seconds since the last acknowledgement; 0 if all message blocks are acknowledged."""
        return 0.0 if self._silent_since_s is None else now_s - self._silent_since_s

    def receive(self, data: bytes, now_s: float) -> Iterator[bytes]:
        for sequence, content in self._reader.feed(data):
            self._acknowledge(sequence, now_s, is_empty=not content)
            if content:
                yield content

    def _acknowledge(self, sequence: int, now_s: float, *, is_empty: bool) -> None:
        ahead = (sequence - self._first) & 0x0F
        if ahead > len(self._unacknowledged):
            if not self._agreed:
                self._renumber(sequence)
            return
        self._agreed = self._agreed or ahead > 0
        for _ in range(ahead):
            sent = self._unacknowledged.popleft()
            if not sent.again:
                wished_s = max(2 * (now_s - sent.at_s), 0.9 * self._timeout_s)
                self._timeout_s = min(max(wished_s, LEAST_TIMEOUT_S), MOST_TIMEOUT_S)
        self._first += ahead
        if ahead:
            self._silent_since_s = now_s if self._unacknowledged else None
        elif is_empty and self._unacknowledged and self._gone_back_to != self._first:
            self._gone_back_to = self._first
            self._unacknowledged[0].lost = True

    def _renumber(self, sequence: int) -> None:
        """Renumber the unsent blocks from `sequence`, the number that the board expects after an earlier host."""
        self._first = sequence
        for number, sent in enumerate(self._unacknowledged, sequence):
            sent.data, sent.lost = frames.block(number, sent.content), True

    def due(self, now_s: float) -> bytes:
        """Return the bytes that must be sent to the board now."""
        out = bytearray()
        oldest = self._unacknowledged[0] if self._unacknowledged else None
        if oldest is not None and (oldest.lost or now_s - oldest.at_s >= self._timeout_s):
            if not oldest.lost:
                self._timeout_s = min(2 * self._timeout_s, MOST_TIMEOUT_S)
                self._gone_back_to = -1
            out.append(frames.SYNC)
            for block in self._unacknowledged:
                block.at_s, block.again, block.lost = now_s, True, False
                out += block.data
                self.again += 1
        while self._waiting and len(self._unacknowledged) < WINDOW:
            if self._unacknowledged and self._in_flight + len(self._waiting[0][0]) + frames.LEAST > self.window:
                break
            out += self._next_block(now_s)
        return bytes(out)

    @property
    def _in_flight(self) -> int:
        return sum(len(block.data) for block in self._unacknowledged)

    def _next_block(self, now_s: float) -> bytes:
        most = min(frames.MOST_CONTENT, self.window - self._in_flight - frames.LEAST)
        contents, calls = bytearray(), []
        while self._waiting and (not contents or len(contents) + len(self._waiting[0][0]) <= most):
            content, sent = self._waiting.popleft()
            contents += content
            calls.append(sent)
        data = frames.block(self._first + len(self._unacknowledged), bytes(contents))
        for call in calls:
            call(now_s)
        self._unacknowledged.append(_Sent(bytes(contents), data, now_s))
        if self._silent_since_s is None:
            self._silent_since_s = now_s
        return data

    def drop_waiting(self) -> None:
        self._waiting.clear()
