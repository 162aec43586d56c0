"""Recent messages of hosts and controllers, stored once for all pages; each page converts them to text."""

from collections import deque
from collections.abc import Iterable, Iterator
from contextlib import ExitStack
from itertools import islice

from axistwin.bench import Bench, endpoints
from axistwin.bench.codec import Codec, unpadded, word
from axistwin.bench.events import Event, LineBreak, Received, Sent, observing
from axistwin.core.units import MS, to_seconds
from axistwin.scenes.sessions.session import Session

KEPT = 20_000  # Largest number of stored events per endpoint; on a serial line, each character is an event.
SHOWN = 4_000  # Largest number of stored events that a newly opened terminal shows.
PAUSE_NS = 50 * MS  # Longest pause within one line of a terminal; after a longer pause, a new line begins.
CR, LF = b"\r", b"\n"

Utterance = Sent | Received | LineBreak

DIM, HOST, DEVICE, WRONG, NORMAL = "\x1b[2m", "\x1b[36m", "\x1b[32m", "\x1b[31m", "\x1b[0m"


class Talk:
    """Recorded messages of a session; `generation`: number of benches that it has used."""

    def __init__(self, session: Session) -> None:
        self.generation = 0
        self._said: dict[str, deque[Utterance]] = {}
        self._count: dict[str, int] = {}
        self._listening = ExitStack()
        session.each_bench(self._attach)

    def _attach(self, bench: Bench) -> None:
        self._listening.close()
        self.generation += 1
        self._said = {name: deque(maxlen=KEPT) for name in endpoints.names(bench)}
        self._count = dict.fromkeys(self._said, 0)
        self._listening.enter_context(observing(bench, self._take))

    def since(self, name: str, count: int) -> tuple[int, list[Utterance]]:
        """Return the total number of events at an endpoint, and the events after the first `count`."""
        total, said = self._count.get(name, 0), self._said.get(name, deque())
        new = min(total - count, len(said), SHOWN)
        return total, list(islice(said, len(said) - new, None))

    def _take(self, event: Event) -> None:
        if isinstance(event, Utterance) and event.controller in self._said:
            self._said[event.controller].append(event)
            self._count[event.controller] += 1


class Printer:
    """Converts the events of one terminal to text.  Each message is a line with its start time."""

    def __init__(self, codec: Codec, whole: bool) -> None:
        self._codec, self._whole = codec, whole
        self._by_host: bool | None = None  # True if the present line is the host's; None before the first line.
        self._last_ns = 0
        self._ended = False

    def end_line(self) -> None:
        self._by_host = None

    def text(self, said: Iterable[Utterance]) -> str:
        return "".join(part for utterance in said for part in self._parts(utterance))

    def _parts(self, said: Utterance) -> Iterator[str]:
        by_host = not isinstance(said, Received)
        if self._begins_line(said, by_host):
            sign = f"{HOST}>" if by_host else f"{DEVICE}<"
            yield f"\r\n{DIM}{to_seconds(said.time_ns):12.6f}{NORMAL} {sign}{NORMAL} "
        self._by_host, self._last_ns = by_host, said.time_ns
        if isinstance(said, LineBreak):
            yield f"{DIM}<BREAK {said.seconds:g} s>{NORMAL}"
        elif self._whole:
            yield self._message(said)
        else:
            yield from self._characters(said)

    def _begins_line(self, said: Utterance, by_host: bool) -> bool:
        if self._whole or by_host is not self._by_host or said.time_ns > self._last_ns + PAUSE_NS:
            return True
        return self._ended and not (isinstance(said, Received) and said.data == LF)

    def _message(self, said: Sent | Received) -> str:
        by_host = isinstance(said, Sent)
        data = said.data if by_host else unpadded(said.data)
        return f"{self._codec.show(data)}   {DIM}{self._codec.words(said.data, by_host)}{NORMAL}"

    def _characters(self, said: Sent | Received) -> Iterator[str]:
        wrong = isinstance(said, Received) and bool(said.errors)
        for byte in said.data:
            shown = word(byte)
            colour = WRONG if wrong else DIM if len(shown) > 1 else ""
            yield f"{colour}{shown}{NORMAL}" if colour else shown
        self._ended = said.data[-1:] in (CR, LF)
