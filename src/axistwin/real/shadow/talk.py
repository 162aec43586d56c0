"""Commands of the host and answers of a controller, cut from a stream of bytes with times."""

from collections.abc import Callable, Iterator
from typing import NamedTuple

from axistwin.core.units import MS

QUIET_NS = 60 * MS  # Silence after which an answer without a terminator is complete.
TYPING_NS = 1000 * MS  # The same while each character of a host, or of a person who types, is echoed.
CR, LF = 0x0D, 0x0A


class Command(NamedTuple):
    """One command of the host.  `answers`: the number of messages with which a controller answers it."""

    name: str
    section: str
    data: bytes
    answers: int = 0
    starts: bool = False  # True if the command may begin a motion.
    words: str = ""  # The command for users; default: its name.

    @property
    def text(self) -> str:
        return self.words or self.name


class Asked(NamedTuple):
    """A message that a controller owes to a command."""

    number: int
    command: Command
    time_ns: int
    echo: bool = False


class Answer(NamedTuple):
    """One message of a controller.  Of the twin at this time: `speed`, `busy`, and the end of the present move.

    `total`: the pulses of the whole move; `left`: those that remain, negative if it goes back.
    """

    time_ns: int
    data: bytes
    asked: Asked | None = None
    speed: float = 0.0
    busy: bool = False
    total: int = 0
    left: int = 0


class Messages:
    """Cuts bytes into messages: after a terminator, a silence, or of a fixed size; an LF after a CR is left out.

    `add` receives the time of the last byte and the message.
    """

    def __init__(self, add: Callable[[int, bytes], object], size: int = 0, ends: bytes = b"\r\n") -> None:
        self._add, self._size, self._ends = add, size, ends
        self._data, self._last_ns, self._after_cr = bytearray(), 0, False
        self.quiet_ns = QUIET_NS

    def receive(self, time_ns: int, data: bytes) -> None:
        self.catch_up(time_ns)
        for byte in data:
            code, after_cr = byte & 0x7F, self._after_cr
            self._last_ns, self._after_cr = time_ns, code == CR and not self._size
            if code == LF and after_cr:
                continue
            self._data.append(byte)
            if len(self._data) == self._size if self._size else code in self._ends:
                self._flush()

    def catch_up(self, now_ns: int) -> None:
        """Complete a message whose end shows by silence only."""
        if self._data and now_ns - self._last_ns > self.quiet_ns:
            self._flush()

    def clear(self) -> None:
        self._data.clear()

    def _flush(self) -> None:
        data = bytes(self._data)
        self._data.clear()
        self._add(self._last_ns, data)


class Words:
    """Cuts the host's bytes at terminators; a part without one waits for the next data."""

    LONGEST = 4096

    def __init__(self, terminators: bytes) -> None:
        self._terminators, self._data = terminators, bytearray()

    def receive(self, data: bytes) -> Iterator[bytes]:
        """Yield the whole words, each with its terminator."""
        for byte in data:
            self._data.append(byte)
            if byte in self._terminators or len(self._data) >= self.LONGEST:
                yield bytes(self._data)
                self._data.clear()

    def clear(self) -> None:
        self._data.clear()
