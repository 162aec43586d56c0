"""Requests of the shadow's own to the machine, while host and machine are silent, so that the twin begins in its state.

Nothing that is asked moves, sets or clears anything: K, Q and F of an IF1 clear faults that the host has not read.
"""

import re
from collections import deque
from collections.abc import Callable
from typing import NamedTuple

from axistwin.controllers.product import Product
from axistwin.devices.framing import Lines
from axistwin.drivers.text import TextCore, core_of_device
from axistwin.sim.frames import UartFormat

SILENCE_S = 0.1  # Silence after the machine's last character before a request.
UNANSWERED_S = 2.0  # The same after the host's last character: the machine may still be about to answer.
ENDED_S = 0.03  # Silence after which an answer is complete; at least `CHARACTERS`.
CHARACTERS = 3
PATIENCE_S = 0.5  # Longest time for an answer to begin, and for which data of the host wait.
AGAIN_S = 1.0  # Time between two requests to a machine that moves.
MOST = 16  # Requests to a device.
SEVEN_BITS = bytes(code & 0x7F for code in range(256))
NUMBER, ANY, NEVER = rb"-?\d+\r\n?", rb"[^\r\n]*", rb"(?!)"
LOADS, LOADED = b"LOAD", b"\xff"  # Between these, what a host sends to a SmartMotor is a program.
MOST_SAID = 1 << 16


class Question(NamedTuple):
    """One request, and its answer as regular expressions.  What follows `busy` is asked when the machine rests."""

    data: bytes
    form: bytes = NUMBER
    busy: bytes = NEVER
    told: bool = True  # False: only for the shadow, e.g. the first one, which shows how a line ends.


INPUTS, STATUS = Question(b"I\r"), Question(b"RW\r")
QUESTIONS = {
    # CR LF ends a request in both data formats.  The twin takes the format from the first request that it is told.
    # It is not told an F, whose cause only K or the host's next request tells.
    "digiplan": (
        Question(b"I\r\n", told=False), INPUTS, INPUTS,
        Question(b"E\r\n", rb"[CEF\[]\r\n?", busy=b"E", told=False), Question(b"N\r"),
    ),
    "smartmotor": (STATUS._replace(told=False), STATUS, Question(b"RBt\r", busy=b"1"), Question(b"RP\r")),
    "compumotor": tuple(
        Question(bytes((code,)), busy=rb"\x8c[^\0]" if code == 0x8C else NEVER)
        for code in (0x88, 0x89, 0x94, 0x97, 0x8C, 0x83)
    ),
}  # fmt: skip
"""By family: inputs and status, whether it moves, and positions."""
ENDS = {"digiplan": b"\r\n", "smartmotor": b" \r" + bytes((LOADED[0] & 0x7F,))}


def questions_of(product: Product) -> tuple[Question, ...]:
    """Return what a model may be asked; nothing if it does not say which requests change nothing."""
    if product.family in QUESTIONS:
        return QUESTIONS[product.family]
    device, found = product.driver, _driver_asks(product.driver)
    framing = getattr(device, "framing", None)
    if not isinstance(framing, Lines):
        return _first_untold(found, b".{%d}" % device.driver.size) if found else ()
    found = found or tuple(
        product.phrase(command, {"axis": axis})
        for command in product.commands
        for axis in (product.axes if command.parameters else ("",))
        if getattr(command, "asks", False) and all(each.name == "axis" for each in command.parameters)
        if product.phrase is not None
    )
    return _first_untold(found, ANY + re.escape(framing.endings[1]))


def _first_untold(found: tuple[bytes, ...], form: bytes) -> tuple[Question, ...]:
    asked = [Question(data, form) for data in dict.fromkeys(found[:MOST]) if data]
    return (*(one._replace(told=False) for one in asked[:1]), *asked)


def _driver_asks(device: object) -> tuple[bytes, ...]:
    if getattr(device, "driver", None) is None:
        return ()
    core = core_of_device(device)()
    if not isinstance(core, TextCore):
        return ()
    return tuple(core.driver.said(name, axis=axis) for axis in core.axes for name in ("busy", "position"))


class Asker:
    """Asks its questions one after the other.  Pure: times are arguments, in seconds.

    `send` sends a request to the machine, whose data go to `received` until `release`, which lets the host's own data
    pass again, with what the host receives of those.  `tell` receives what the twin hears: True for a request.
    """

    def __init__(
        self, product: Product, send: Callable[[bytes], object], release: Callable[[bytes], object],
        tell: Callable[[bool, bytes], object],
    ) -> None:  # fmt: skip
        self.questions, self._send, self._release, self._tell = questions_of(product), send, release, tell
        self._ends = ENDS.get(product.family) or product.endings[0][-1:]
        self._left: deque[Question] = deque()
        self._asked: Question | None = None
        self._received, self._said = bytearray(), bytearray()
        self._free_s = self._last_s = 0.0
        self._silent = False  # True until the machine says something, if it has not answered.
        self._end = b"\r" if product.family == "digiplan" else b""  # What the data format says; b"": it never differs.
        self._echo, self._switch = b"?", b"ECHO\r" if product.family == "smartmotor" else b""
        self.character_s = 0.0

    def pace(self, fmt: UartFormat) -> None:
        self.character_s = fmt.frame_ns / 1e9

    def begin(self, now_s: float) -> None:
        """Ask everything, at the next silence: the twin knows nothing of the machine."""
        self._left, self._silent, self._echo = deque(self.questions), False, b"?"
        self._free_s = max(self._free_s, now_s + SILENCE_S)

    def passed(self, now_s: float, by_host: bool, data: bytes) -> None:
        """Note what has been passed on between host and machine."""
        if by_host:
            self._said += data
            del self._said[:-MOST_SAID]
        self._silent &= by_host
        self._free_s = now_s + (UNANSWERED_S if by_host else max(SILENCE_S, CHARACTERS * self.character_s))

    def received(self, now_s: float, data: bytes) -> None:
        """Add what the machine sends while it is asked."""
        self._last_s = now_s
        self._received += data
        if self._asked is not None and self._asked.told:
            self._tell(False, data)

    def tick(self, now_s: float) -> None:
        """Ask, or end a request; to be called every few milliseconds."""
        if self._asked is not None:
            self._wait(self._asked, now_s)
        elif self._left and not self._silent and now_s >= self._free_s and self._line_ends:
            self._ask(self._left[0], now_s)

    @property
    def _line_ends(self) -> bool:
        """False after half a command, and within a program for a SmartMotor.  Half a datagram is lost in a silence."""
        said = self._said
        return not (said and self._ends) or (said[-1] & 0x7F in self._ends and said.rfind(LOADS) <= said.rfind(LOADED))

    def _ask(self, question: Question, now_s: float) -> None:
        self._asked, self._last_s = question, now_s
        self._received.clear()
        data = question.data
        if question.told:
            data = data.replace(b"\r", self._end) if self._end else data
            self._tell(True, data)
        self._send(data)

    def _wait(self, asked: Question, now_s: float) -> None:
        text = self._received.translate(SEVEN_BITS)
        echo = rb"(?P<echo>%s\r?\n?)" % re.escape(asked.data.strip())
        found = re.search(echo + self._echo + rb"(?P<answer>%s)" % asked.form, text, re.DOTALL)
        quiet_s = now_s - self._last_s
        if found is not None and quiet_s >= max(ENDED_S, CHARACTERS * self.character_s):
            self._answered(asked, found, now_s)
        elif quiet_s >= PATIENCE_S + 2 * CHARACTERS * self.character_s:
            self._end_request(bytes(self._received), now_s)
            self.begin(now_s)
            self._silent = True

    def _answered(self, asked: Question, found: re.Match[bytes], now_s: float) -> None:
        if not asked.told:
            feeds = found["answer"].endswith(b"\n") and (found["echo"] or b"\n").endswith(b"\n")
            self._end = self._end and (b"\n" if feeds else b"\r")
            self._echo = b"" if found["echo"] else b"{0}"
            if found["echo"] and self._switch:
                self._tell(True, self._switch)
        busy = re.match(asked.busy, found["answer"]) is not None
        if not busy:
            self._left.popleft()
        rest = bytes(self._received[: found.start()] + self._received[found.end() :])
        self._end_request(rest, now_s + (AGAIN_S if busy else 0.0))

    def _end_request(self, rest: bytes, free_s: float) -> None:
        if rest and self._asked is not None and not self._asked.told:
            self._tell(False, rest)
        self._asked, self._free_s = None, free_s
        self._release(rest)
