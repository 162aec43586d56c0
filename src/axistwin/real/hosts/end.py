"""Requests to a controller, and its answers, over any port."""

import re
from abc import ABC, abstractmethod
from typing import NamedTuple

from axistwin.sim.frames import UartFormat

QUIET_S = 0.06  # Time without data after which an answer is complete.
LONGEST_S = 1.0  # Longest time in seconds to wait for the expected bytes, in addition to their usual time.
LATE_S = 2.0  # Silence after which nothing late is expected any more.
TRIES = 3  # Number of times that a request is sent before the controller counts as silent.
POLL_S = 0.015  # Longest usual time between two looks at a port.
MESSAGE = 16  # Bytes of a board's message.
USER_BITS = 0x07  # The user bits of a board's status byte.


class Answer(NamedTuple):
    """Received bytes, and the time in seconds from the request to the last byte."""

    data: bytes
    seconds: float


class End(ABC):
    """Host side of a connection to a controller."""

    grain_s = 0.02  # Uncertainty of a measured time.
    exact = False  # True if a loaded computer cannot delay an answer.
    messages = False  # True for a board on a bus, which receives commands and sends messages.
    has_line = True  # True if the port has a baud rate and a frame.

    def __init__(self) -> None:
        self.frame_s = 0.0  # Time of one character on the line.
        self.echo = False  # True if the controller echoes; an echo is not the answer for which a request waits.
        self.received = bytearray()  # All data since `begin`, including what came after the end of an answer.
        self.late_s = 0.0  # Time by which this program was late with requests since `begin`.
        self._ended: float | None = None

    def begin(self) -> None:
        """Discard received data, and begin to collect those of the next requests."""
        self.drain()
        self.received.clear()
        self.late_s, self._ended = 0.0, None

    def ask(self, data: bytes, expected: int = 0, wait_s: float = 0.0, patience_s: float = 0.0) -> Answer:
        """Send a request to the controller, and return the answer.

        The answer is complete after `expected` bytes and a silence.  If bytes are missing, the answer ends after
        `LONGEST_S`, or `patience_s` later for a controller that holds back answers.  A request without an answer
        takes `wait_s` seconds.  No `data`: the answer is the user bits of a board's status byte.
        """
        if not data:
            return Answer(bytes((self.user_bits,)), 0.0)
        self.received += self.drain()
        began = last = self.now
        self.send(data)
        self._was_late(self.now - (began if self._ended is None else self._ended))
        received = bytearray()
        sending_s = len(data) * self.frame_s
        quiet_s, wait_s = max(QUIET_S, 3 * self.frame_s), wait_s + sending_s
        echoed = len(data) if self.echo else 0
        while True:
            since = self.now - began
            silence_s = quiet_s - (self.now - last)
            if len(received) <= echoed:
                silence_s = max(silence_s, wait_s - since)
            missing_s = wait_s + sending_s + LONGEST_S + patience_s - since
            complete = len(received) >= expected or missing_s < 0
            if complete and silence_s <= 0:
                self._ended = self.now
                self._was_late(-silence_s)
                return Answer(bytes(received), last - began)
            if more := self.receive(silence_s if complete else max(silence_s, missing_s)):
                received += more
                self.received += more
                last = self.now

    def _was_late(self, seconds: float) -> None:
        if seconds > POLL_S:
            self.late_s += seconds

    def ask_again(self, data: bytes, form: bytes) -> bytes:
        """Send a request until its answer fits a regular expression, at most three times; return the last answer.

        The answer may begin with an echo of the request.
        """
        whole = re.compile(b"(?:.{%d})?%s" % (len(data), form), re.DOTALL)
        received = bytearray()
        for _ in range(TRIES):
            self.drain()
            received.clear()
            self.send(data)
            last = self.now
            while self.now - last < LATE_S:
                if more := self.receive():
                    received += more
                    last = self.now
                elif whole.fullmatch(received) and self.now - last > QUIET_S:
                    return bytes(received)
        return bytes(received)

    def settle(self) -> None:
        """Receive until nothing late is expected any more."""
        last = self.now
        while self.now - last < LATE_S:
            if more := self.receive():
                self.received += more
                last = self.now

    @property
    @abstractmethod
    def now(self) -> float: ...

    @abstractmethod
    def send(self, data: bytes) -> None: ...

    @abstractmethod
    def receive(self, silence_s: float = 0.0) -> bytes:
        """Return the received data, or no bytes if no data arrive within some milliseconds.

        `silence_s`: time without data that the caller waits for in any case; the function may use it up to 20 ms.
        """

    @abstractmethod
    def drain(self) -> bytes: ...

    def set_line(self, line: UartFormat) -> None:  # noqa: B027  # a bus has no line format
        ...

    @property
    def user_bits(self) -> int:
        return 0

    @abstractmethod
    def close(self) -> None: ...
