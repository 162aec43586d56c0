"""The connection to a board's firmware: commands, requests with responses, and the board's clock."""

from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass
from typing import Any

from axistwin.core.errors import AxistwinError
from axistwin.real.standin.channel import Channel
from axistwin.real.standin.clock_fit import ClockFit
from axistwin.real.standin.dictionary import Dictionary

SOON_S = 0.05  # Longest time in seconds for a command to reach a working board.
MOST_SILENT_S, MOST_SILENT_AT_START_S = 1.0, 5.0  # Failed after so long without acknowledgement; after a reset.
MOST_CLOCK_S, LEAST_CLOCK_S = 0.25, 0.02  # Longest and shortest interval in seconds at which the board's clock is read.
CLOCKS = 100  # The interval is the time since the start divided by this, so samples cover ever more time.
ANSWER_S, MOST_REQUESTS = 0.25, 24  # Until an unanswered request is sent again, and how often it is sent.

Procedure = Generator[tuple[str, int | None, bytes], dict[str, Any], None]
"""Generator that yields requests to a board and receives the values of each response."""


@dataclass
class _Request:
    procedure: Procedure
    name: str
    oid: int | None
    content: bytes
    left: int
    again_at_s: float


class Connection:
    """Sends commands, and decodes responses; `fail` is called with the reason of a failed request."""

    def __init__(self, fail: Callable[[str], None]) -> None:
        self._fail, self.now_s = fail, 0.0
        self.channel, self.dictionary = Channel(), Dictionary()
        self.clock = ClockFit(1.0)
        self._requests: list[_Request] = []
        self._clock_sent_s: float | None = None
        self._clock_from_s = self._next_clock_s = 0.0

    def restart(self, now_s: float) -> None:
        """Discard all knowledge of the board's firmware, because the board may have been reset."""
        self.now_s = now_s
        self.channel, self.dictionary = Channel(), Dictionary()

    def drop(self) -> None:
        self._requests.clear()
        self.channel.drop_waiting()

    @property
    def silent(self) -> bool:
        most_s = MOST_SILENT_S if self.dictionary.constants else MOST_SILENT_AT_START_S
        return self.channel.silent_s(self.now_s) > most_s

    def send(self, name: str, **values: int) -> None:
        self.channel.send(self.dictionary.encode(name, **values))

    def receive(self, data: bytes) -> Iterator[tuple[str, dict[str, Any]]]:
        """Yield name and values of each response; procedures that wait for a response are then resumed."""
        for content in self.channel.receive(data, self.now_s):
            name, values = self.dictionary.decode(content)
            if name == "clock" and self._clock_sent_s is not None:
                self.clock.add(self._clock_sent_s, self.now_s, values["clock"])
                self._clock_sent_s = None
            if name:
                yield name, values
                self._answer(name, values)

    # Requests

    def begin(self, procedure: Procedure) -> None:
        self._advance(procedure, None)

    def ask(self, name: str, answer: str, **values: int) -> Generator[Any, dict[str, Any], dict[str, Any]]:
        """Send a command within a procedure; return the values of the response called `answer`."""
        found: dict[str, Any] = yield answer, values.get("oid"), self.dictionary.encode(name, **values)
        return found

    def repeat_requests(self) -> None:
        for request in self._requests:
            if request.content and self.now_s >= request.again_at_s:
                request.left -= 1
                request.again_at_s = self.now_s + ANSWER_S
                if not request.left:
                    self._fail(f"the board does not answer ({request.name}): check its firmware, then try again")
                    return
                self.channel.send(request.content)

    def _advance(self, procedure: Procedure, values: dict[str, Any] | None) -> None:
        try:
            name, oid, content = next(procedure) if values is None else procedure.send(values)
        except StopIteration:
            return
        except AxistwinError as error:
            self._fail(str(error))
            return
        if content:
            self.channel.send(content)
        self._requests.append(_Request(procedure, name, oid, content, MOST_REQUESTS, self.now_s + ANSWER_S))

    def _answer(self, name: str, values: dict[str, Any]) -> None:
        for request in [each for each in self._requests if each.name == name]:
            if request.oid is None or request.oid == values.get("oid"):
                self._requests.remove(request)
                self._advance(request.procedure, values)

    # Clock

    def forget_clock(self) -> None:
        self.clock = ClockFit(self.dictionary.clock_hz)
        self._clock_from_s = self.now_s

    def read_clock(self) -> None:
        """Request a reading if one is due, and none is missing: its response would be taken for that of the new one."""
        missing = self._clock_sent_s is not None and self.now_s < self._clock_sent_s + ANSWER_S
        if self.now_s >= self._next_clock_s and not missing:
            interval_s = (self.now_s - self._clock_from_s) / CLOCKS
            self._next_clock_s = self.now_s + min(max(interval_s, LEAST_CLOCK_S), MOST_CLOCK_S)
            self._clock_sent_s = None
            self.channel.send(self.dictionary.encode("get_clock"), self._clock_is_sent)

    def _clock_is_sent(self, at_s: float) -> None:
        self._clock_sent_s = at_s

    def soon(self) -> float:
        """Return `SOON_S` from now in ticks of the board's clock; a working board has a command before then."""
        return self.clock.ticks(self.now_s + SOON_S)

    def ticks(self, seconds: float) -> int:
        return round(seconds * self.dictionary.clock_hz)
