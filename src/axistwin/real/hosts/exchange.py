"""Requests to a controller, with a record of all sent and received data."""

from collections.abc import Callable

from axistwin.bench import Comment, Hear, Say, Wait, product
from axistwin.bench.acts import Act
from axistwin.bench.codec import codec_of
from axistwin.bench.talk.conversation import write
from axistwin.core.errors import LinkError
from axistwin.core.units import MS, S
from axistwin.real.hosts.end import MESSAGE, End
from axistwin.sim.frames import UartFormat

PATIENCE_S = 1.0  # Longest silence before an expected answer, beyond the time of the characters on the line.
SILENCE_NS = 200 * MS
MOST_UNANSWERED = 3  # Consecutive requests without an answer, after which a rescue checks that the controller lives.
Complete = Callable[[bytes], bool]  # Returns True if an answer is complete.
Report = Callable[[int, int], None]  # Receives the number of answers, and of the last requests that have had none.


class Exchange:
    """A connection to a controller, with a record of all sent and received data."""

    def __init__(
        self, end: End, model: str, line: UartFormat | None = None, report: Report = lambda answers, unanswered: None
    ) -> None:
        self.end, self.product = end, product(model)
        self._report, self._answers, self._unanswered = report, 0, 0
        self.heard = b""  # First data from the controller.
        self.sign_of_life = b""  # Request that a living controller always answers; b"" until it has been answered.
        self.line_format = line or self.product.line or UartFormat()
        self.frame_s = 0.0 if self.product.line is None else self.line_format.frame_ns / S
        self.terminator = b"\r"  # Last character of an answer.
        self.echo = False  # True if the controller sends each received character back.
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
        if self._unanswered == MOST_UNANSWERED:
            self.check_alive()
        return bytes(received[echoed:])

    def check_alive(self) -> None:
        """Raise LinkError if the controller has answered before, and no longer answers."""
        if not self.sign_of_life:
            return
        request, self.sign_of_life = self.sign_of_life, b""
        if not self.line(request):
            raise LinkError(
                f"the controller no longer answers, after {self._answers} answers: check its power and the cable, "
                "then run axistwin rescue again"
            )
        self.sign_of_life, self._unanswered = request, 0

    def _ends_line(self, answer: bytes) -> bool:
        return bool(answer) and answer[-1] & 0x7F == self.terminator[0]

    def line(self, said: bytes, patience_s: float = PATIENCE_S) -> str:
        """Send a request, and return the answer without its terminator; "" without an answer."""
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
        self.heard = self.heard or received
        self._answers += bool(received)
        self._unanswered = 0 if received else self._unanswered + 1
        self._report(self._answers, self._unanswered)
        self.acts += map(Say, said)
        if not received:
            self.acts += [Wait(SILENCE_NS), Hear(b"")]
        elif self.product.line is None:
            self.acts += [Hear(received[at : at + MESSAGE]) for at in range(0, len(received), MESSAGE)]
        else:
            self.acts.append(Hear(received))

    @property
    def received(self) -> bool:
        return self._answers > 0

    def talk(self) -> str:
        return write(self.acts, codec_of(self.product))
