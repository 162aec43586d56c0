"""Requests to a controller, with a record of all sent and received data."""

from collections.abc import Callable

from axistwin.bench import Comment, Hear, Say, Wait, product
from axistwin.bench.acts import Act
from axistwin.bench.codec import codec_of
from axistwin.conversations import write
from axistwin.errors import LinkError
from axistwin.probing.ends import MESSAGE, End
from axistwin.sim.frames import UartFormat
from axistwin.units import MS, S

PATIENCE_S = 1.0
"""Longest silence before an expected answer, beyond the time of the characters on the line."""
SILENCE_NS = 200 * MS
Complete = Callable[[bytes], bool]
"""Returns True if an answer is complete."""


class Exchange:
    """A connection to a controller, with a record of all sent and received data."""

    def __init__(
        self,
        end: End,
        model: str,
        line: UartFormat | None = None,
        report: Callable[[int], None] = lambda answers: None,
    ) -> None:
        self.end, self.product = end, product(model)
        self._report, self._answers = report, 0
        self.line_format = line or self.product.line or UartFormat()
        self.frame_s = 0.0 if self.product.line is None else self.line_format.frame_ns / S
        self.terminator = b"\r"
        """Last character of an answer."""
        self.echo = False
        """True if the controller sends each received character back."""
        self.acts: list[Act] = [Comment(f"model: {self.product.model}")]

    def ask(self, *said: bytes, complete: Complete | None = None, patience_s: float = PATIENCE_S) -> bytes:
        """Send requests to the controller, and return the controller's answer without echoed characters.

        A long silence ends an incomplete answer.  `complete` None: an answer ends in the terminator; bit 8 of the
        terminator is ignored.
        """
        complete = complete or self._ends_line
        self.end.drain()
        for data in said:
            self.end.send(data)
        sent = sum(map(len, said))
        echoed = sent if self.echo else 0
        received = bytearray()
        last, wait_s = self.end.now, patience_s + 2 * sent * self.frame_s
        while not (len(received) > echoed and complete(bytes(received[echoed:]))) and self.end.now - last < wait_s:
            if more := self.end.receive():
                received += more
                last, wait_s = self.end.now, patience_s
        self._note(said, bytes(received))
        return bytes(received[echoed:])

    def _ends_line(self, answer: bytes) -> bool:
        return bool(answer) and answer[-1] & 0x7F == self.terminator[0]

    def line(self, said: bytes, patience_s: float = PATIENCE_S) -> str:
        """Send a request, and return the answer as text without its terminator.

        The text is empty if the controller does not answer.
        """
        answer = bytes(byte & 0x7F for byte in self.ask(said, patience_s=patience_s))
        return answer.rstrip(b"\r\n").decode("latin-1")

    def needed(self, said: bytes, what_to_check: str) -> str:
        """Return the answer to a request.  Raises LinkError if the controller does not answer."""
        answer = self.line(said)
        if not answer:
            request = said.decode("latin-1").strip()
            raise LinkError(f"the controller does not answer request {request}: check {what_to_check}")
        return answer

    def _note(self, said: tuple[bytes, ...], received: bytes) -> None:
        self._answers += bool(received)
        self._report(self._answers)
        self.acts += map(Say, said)
        if not received:
            self.acts += [Wait(SILENCE_NS), Hear(b"")]
        elif self.product.line is None:
            self.acts += [Hear(received[at : at + MESSAGE]) for at in range(0, len(received), MESSAGE)]
        else:
            self.acts.append(Hear(received))

    @property
    def received(self) -> bool:
        """True if the controller has sent any data."""
        return self._answers > 0

    def talk(self) -> str:
        """Return the recorded data as the text of a conversation file."""
        return write(self.acts, codec_of(self.product))
