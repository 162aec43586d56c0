"""A serial connection as it is on the wire: frames of bits that take their time.

A `Uart` is one end: a format, a transmitter with a holding register, a receiver.  A `Line` is the wire from one end's
transmitter to the other end's receiver.  The receiver knows nothing of the sender's format: it waits for a falling edge
and samples the middle of each bit in its *own* format, as the chip does, and so finds the parity and framing errors
that a mismatch makes.
A character is received at the end of its first stop bit; the next one may begin after all stop bits.

How ends are connected is told in `wirings.py`; what a host has of a connection in `serial_port.py`.
"""

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Protocol

from axistwin.sim.clock import Clock, Event
from axistwin.sim.frames import MARK, SOUND, SPACE, Break, Frame, LineError, UartFormat
from axistwin.sim.trouble import Passage, Trouble, double, flip, lose
from axistwin.units import to_ns

_MOMENT_NS = 1
"""Before an edge; far less than a bit."""


LevelAt = Callable[[Fraction], bool]
"""The level of the line so many nanoseconds after a falling edge."""


class Wire(Protocol):
    """What a transmitter puts its characters on."""

    @property
    def instant(self) -> bool:
        """Whether characters take no time on it."""

    @property
    def ready(self) -> bool:
        """Whether everybody who receives has room; a sender on a line that takes no time waits for that."""

    def carry(self, sent: UartFormat, item: int | Break) -> int:
        """Put a character or a break on it, now.  Returns how long it is taken by it."""


class _Nowhere:
    """A plug that nothing is connected to."""

    instant, ready = False, True

    def carry(self, sent: UartFormat, item: int | Break) -> int:
        """It is lost."""
        return item.duration_ns if isinstance(item, Break) else sent.frame_ns


class Line:
    """The wire from a transmitter to a receiver."""

    def __init__(self, clock: Clock, receiver: "Uart", instant: bool = False) -> None:
        self.clock, self.receiver, self.instant = clock, receiver, instant
        self._frames: deque[Frame] = deque()
        self._listening = True
        self._idle_from = Fraction(0)
        self._troubles: list[Trouble] = []
        self._cuts: list[object] = []
        self._free_ns = 0  # until then characters are on their way that have been delayed

    # Line faults, on demand

    def disturb(self, trouble: Trouble) -> Callable[[], None]:
        """Something happens to the characters from now on.  Returns what ends it; ended twice it is ended."""
        self._troubles.append(trouble)
        return lambda: self._troubles.remove(trouble) if trouble in self._troubles else None

    def lose(self, characters: int = 1) -> None:
        """The next characters never arrive."""
        self.disturb(Trouble(lose, characters))

    def double(self, characters: int = 1) -> None:
        """The next characters arrive twice."""
        self.disturb(Trouble(double, characters))

    def flip(self, mask: int, characters: int = 1) -> None:
        """In the next characters the data bits in `mask` are inverted; the parity bit is not."""
        self.disturb(Trouble(flip(mask), characters))

    def cut(self) -> None:
        """The wire is open from now on, also in the middle of a character; the receiver sees mark."""
        self._cut_by(self)

    def sever(self) -> Callable[[], None]:
        """The same; returns what mends this cut, and no other."""
        token = object()
        self._cut_by(token)
        return lambda: self._cuts.remove(token)

    def _cut_by(self, token: object) -> None:
        self._cuts.append(token)
        if self._frames and self._frames[-1].cut_ns is None:
            self._frames[-1].cut_ns, self._frames[-1].intact = self.clock.now, None

    def mend(self) -> None:
        """What `cut` has done is mended."""
        self._cuts = [token for token in self._cuts if token is not self]

    def short(self, duration_ns: int) -> None:
        """The wire is held at space for so long from now on, whatever the transmitter says."""
        if self.instant:
            self.receiver.take(0, LineError.FRAMING | LineError.BREAK)
        else:
            self._append(Frame(self.clock.now, (SPACE,), Fraction(duration_ns)))

    # The transmitter's side

    @property
    def ready(self) -> bool:
        """Whether the receiver has room."""
        return self.receiver.has_room()

    def occupy(self, sent: UartFormat, item: int | Break) -> None:
        """The receiver's own transmitter is on the wire, too.  It does not hear itself, but garbles what comes."""
        if self.instant:
            return
        if isinstance(item, Break):
            self._append(Frame(self.clock.now, (SPACE,), Fraction(item.duration_ns), own=True))
        else:
            self._append(Frame(self.clock.now, sent.frame(item), sent.bit_ns, own=True))

    def carry(self, sent: UartFormat, item: int | Break) -> int:
        """Put a character or a break on the wire, now.  Returns how long the wire is taken by it."""
        if isinstance(item, Break):
            return self._carry_break(item)
        undisturbed = not self._troubles and not self._cuts and self._free_ns <= self.clock.now
        if self.instant and undisturbed and self.receiver.understands(sent):
            self.receiver.take(item & ((1 << sent.bytesize) - 1), SOUND)  # nothing to find out on the way
            return 0
        passage = self._passage(sent)
        if not self._cuts:
            self._pass(passage, item)
        return 0 if self.instant else max(passage.copies, 1) * sent.frame_ns

    def _passage(self, sent: UartFormat) -> Passage:
        """What becomes of a character that is sent now."""
        passage = Passage(sent)
        for trouble in tuple(self._troubles):
            trouble.meet(passage)
            if trouble.over and trouble in self._troubles:
                self._troubles.remove(trouble)
        return passage

    def _pass(self, passage: Passage, byte: int) -> None:
        """It arrives as often as it does; what has been delayed is not overtaken."""
        now_ns, frame_ns = self.clock.now, 0 if self.instant else passage.sent.frame_ns
        start_ns = max(now_ns + passage.delay_ns, self._free_ns)
        for copy in range(passage.copies):
            self._put(passage.sent, byte, passage.flips, start_ns - now_ns + copy * frame_ns)
        if start_ns > now_ns:
            self._free_ns = start_ns + passage.copies * frame_ns

    def _carry_break(self, item: Break) -> int:
        if self.instant:
            if not self._cuts:
                self.receiver.take(0, LineError.FRAMING | LineError.BREAK)
            return 0
        if not self._cuts:
            self._append(Frame(self.clock.now, (SPACE,), Fraction(item.duration_ns)))
        return item.duration_ns

    def _put(self, sent: UartFormat, byte: int, flips: int, delay_ns: int) -> None:
        intact = None if flips else (sent, byte & ((1 << sent.bytesize) - 1))
        frame = Frame(self.clock.now + delay_ns, sent.frame(byte, flips), sent.bit_ns, intact=intact)
        arrive = self._receive_at_once if self.instant else self._append
        if delay_ns:
            self.clock.call_later(delay_ns, lambda: arrive(frame))
        else:
            arrive(frame)

    # The receiver's side

    def _append(self, frame: Frame) -> None:
        self._frames.append(frame)
        if self._listening:
            self._listen()

    def _listen(self) -> None:
        """Wait for the next falling edge; known already, as frames are put on the wire whole."""
        self._listening = True
        frames = self._frames
        while frames and frames[0].end_ns < self._idle_from:
            frames.popleft()
        for frame, edge_ns in self._falls():
            if edge_ns >= self._idle_from and self._begin(frame, edge_ns):
                return
        self._frames = deque(frame for frame in frames if frame.own)  # nothing in the others began a character
        while self._frames and self._frames[0].end_ns < self.clock.now:
            self._frames.popleft()

    def _falls(self) -> Iterator[tuple[Frame, Fraction]]:
        """Each falling edge on the wire that somebody else has made, with its frame."""
        frames = self._frames
        if len(frames) == 1 and not frames[0].own:  # almost always; it begins with one
            yield from ((frames[0], edge_ns) for edge_ns, level in frames[0].edges() if level is SPACE)
            return
        found = [
            (edge_ns, number, frame)
            for number, frame in enumerate(frames)
            if not frame.own
            for edge_ns, level in frame.edges()
            if level is SPACE
        ]
        if len(frames) > 1:
            found = sorted(fall for fall in found if self._level(fall[0] - _MOMENT_NS) is MARK)
        for edge_ns, _, frame in found:
            yield frame, edge_ns

    def _begin(self, frame: Frame, edge_ns: Fraction) -> bool:
        """A start bit, perhaps.  A receiver without a format measures its length first (automatic baud rate)."""
        fmt = self.receiver.format
        if fmt is None or self.receiver.second_look is not None:
            fmt = self.receiver.measure(self._low_ns(edge_ns), lambda since_ns: self._level(edge_ns + since_ns))
        if fmt is None:
            return False
        self._listening = False
        self.clock.call_later(
            max(0, int(edge_ns) + fmt.receive_ns - self.clock.now), lambda: self._sample(frame, edge_ns, fmt)
        )
        return True

    def _low_ns(self, edge_ns: Fraction) -> Fraction:
        edges = ((at, level) for frame in self._frames for at, level in frame.edges())
        return next(at for at, level in edges if at > edge_ns and level is MARK) - edge_ns

    def _sample(self, frame: Frame, edge_ns: Fraction, fmt: UartFormat) -> None:
        """The first stop bit is over: read the character off the wire."""
        intact = frame.intact if frame.start_ns == edge_ns and self._alone(frame, fmt) else None
        if intact and intact[0].shape == fmt.shape:
            character: tuple[int, LineError] | None = intact[1], SOUND
        else:
            character = fmt.decode(lambda since_ns: self._level(edge_ns + since_ns))
        # The chip looks for the next start bit from the middle of the stop bit on.
        self._idle_from = edge_ns + (fmt.receive_ns - fmt.bit_ns / 2)
        if character is None:
            self._idle_from = edge_ns + fmt.bit_ns / 2
        elif self.receiver.resynchronises and LineError.FRAMING in character[1]:
            self._idle_from -= fmt.bit_ns
        if character is not None:
            self.receiver.take(*character)  # it may choose the format for what follows
        self._listen()

    def _alone(self, frame: Frame, fmt: UartFormat) -> bool:
        """Whether nobody else has been on the wire while a receiver in this format looked at it."""
        until_ns = frame.start_ns + fmt.receive_ns
        return all(
            other is frame or other.start_ns >= until_ns or other.end_ns <= frame.start_ns for other in self._frames
        )

    def _level(self, time_ns: Fraction) -> bool:
        """Space if anybody says so."""
        return all(frame.level(time_ns) for frame in self._frames)

    def _receive_at_once(self, frame: Frame) -> None:
        """A line that takes no time: each character is read by itself."""
        origin = Fraction(frame.start_ns)
        low_ns = next(at for at, level in frame.edges() if level is MARK) - origin
        fmt = self.receiver.format
        if fmt is None or self.receiver.second_look is not None:
            fmt = self.receiver.measure(low_ns, lambda since_ns: frame.level(origin + since_ns))
        if fmt is None:
            return
        if frame.intact and frame.intact[0].shape == fmt.shape:
            self.receiver.take(frame.intact[1], SOUND)
            return
        character = fmt.decode(lambda since_ns: frame.level(origin + since_ns))
        if character is not None:
            self.receiver.take(*character)


@dataclass
class Uart:
    """One end of a serial connection: transmitter with a holding register, receiver, format."""

    clock: Clock
    format: UartFormat | None = field(default_factory=UartFormat)
    on_receive: Callable[[int, LineError], None] = lambda byte, errors: None
    on_measure: Callable[[Fraction], UartFormat | None] = lambda low_ns: None
    """Asked for a format while `format` is None; it is told how long the line was low."""
    second_look: Callable[[Fraction, LevelAt], UartFormat | None] | None = None
    """Asked at each start bit while there is a `format`: another format for this one character, or None.

    It is given how long the line is low, and the levels from the falling edge on.
    """
    resynchronises: bool = False
    """True: a falling edge between the last data bit and a low stop bit is taken for the next start bit."""
    has_room: Callable[[], bool] = lambda: True
    """On a line that takes no time the sender waits while the receiver has no room."""

    on_idle: Callable[[], None] = lambda: None
    """Called when the last character given has left."""

    def __post_init__(self) -> None:
        self.line: Wire = _Nowhere()
        self.peers: tuple[Uart, ...] = ()
        """Whose characters come here."""
        self.hearers: list[Callable[[int, LineError], None]] = []
        """Told of each character that the receiver has, after whom it belongs to."""
        self.queue: deque[int | Break] = deque()
        self.sending = False
        self.held = False
        self._empty: Event | None = None
        self._idle: Event | None = None

    def take(self, byte: int, errors: LineError) -> None:
        """The receiver has a character."""
        self.on_receive(byte, errors)
        for hearer in tuple(self.hearers):
            hearer(byte, errors)

    def understands(self, sent: UartFormat) -> bool:
        """Whether characters sent in this format are received as they are."""
        return self.format is not None and self.format.shape == sent.shape

    def measure(self, low_ns: Fraction, level_at: LevelAt) -> UartFormat | None:
        """Return the format for a character that begins with the line low for so long."""
        if self.format is None:
            return self.on_measure(low_ns)
        other = None if self.second_look is None else self.second_look(low_ns, level_at)
        return other or self.format

    def send(self, data: bytes) -> None:
        """Queue characters; they leave one after the other, each in the format in force when it leaves."""
        self.queue.extend(data)
        self.pump()

    def send_break(self, seconds: float) -> None:
        """Hold the line at space for so long, after what is queued already."""
        self.queue.append(Break(to_ns(seconds)))
        self.pump()

    def pump(self) -> None:
        """Go on sending, if there is something to send and the wire is free."""
        line, queue = self.line, self.queue
        while queue and not self.sending and not self.held:
            assert self.format is not None
            if line.instant and not line.ready:
                return
            taken_ns = line.carry(self.format, queue.popleft())
            if taken_ns:
                self.sending = True
                self.clock.call_later(taken_ns, self._sent)
        if self._empty is not None and not queue:
            event, self._empty = self._empty, None
            event.succeed()

    def pump_peer(self) -> None:
        """There is room again: on a line that takes no time the other end may go on."""
        for peer in self.peers:
            if peer.queue:
                peer.pump()

    @property
    def instant(self) -> bool:
        """Whether characters take no time on this connection."""
        return self.line.instant

    def when_empty(self) -> Event:
        """An event for the moment when the holding register is free; the last character may still be on its way."""
        if self._empty is None:
            self._empty = self.clock.event()
        return self._empty

    def when_idle(self) -> Event:
        """An event for the moment when the last character has left."""
        if self._idle is None:
            self._idle = self.clock.event()
        return self._idle

    def _sent(self) -> None:
        self.sending = False
        self.pump()
        if self.sending:
            return
        self.on_idle()
        if self._idle is not None:
            event, self._idle = self._idle, None
            event.succeed()
