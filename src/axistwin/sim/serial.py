"""A serial connection as it is on the wire: frames of bits that take their time.

A `Uart` is one end: a format, a transmitter with a holding register, a receiver.  A `Line` is the wire from one end's
transmitter to the other end's receiver.  The receiver knows nothing of the sender's format: it waits for a falling edge
and samples the middle of each bit in its *own* format, as the chip does, and so finds the parity and framing errors
that a mismatch makes.
A character is received at the end of its first stop bit; the next one may begin after all stop bits.

How ends are connected is told in `wirings.py`; what a host has of a connection in `serial_port.py`.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Protocol

from axistwin.sim.clock import Clock, Event
from axistwin.sim.frames import SOUND, Break, Frame, LineError, UartFormat
from axistwin.sim.levels import Levels, Space
from axistwin.sim.trouble import Passage, Trouble, double, flip, lose
from axistwin.units import S, to_ns

MANY = 12
"""Spaces on a wire, those of some three characters; when there are more, a receiver reads as far as it can already."""
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


class _Reading:
    """A character that is being received in `fmt`: the levels at the middles of its bits, one after the other.

    Instants are whole numbers of 1/`per` ns.  `edge/edge_per` ns: the falling edge of its start bit.
    """

    __slots__ = ("edge_ns", "end_ns", "fmt", "idle", "left", "levels", "next", "per", "space", "step", "taken", "whole")

    def __init__(
        self, fmt: UartFormat, edge: int, edge_per: int, *, whole: Frame | None = None, space: Space | None = None
    ) -> None:
        half_bit = S * edge_per
        self.fmt, self.per = fmt, 2 * fmt.baudrate * edge_per
        begin = 2 * fmt.baudrate * edge
        self.next, self.step = begin + half_bit, 2 * half_bit
        self.levels, self.taken, self.left = 0, 0, fmt.samples
        self.idle = begin + fmt.receive_ns * self.per - half_bit
        """From here on the receiver looks for the next start bit: the middle of the stop bit, as the chip does it."""
        self.edge_ns = edge // edge_per
        self.end_ns = self.edge_ns + fmt.receive_ns
        """The end of the first stop bit."""
        self.whole = whole
        """A frame that is received as it was sent, as long as nothing else is put on the wire before the end."""
        self.space = space
        """Otherwise the space that begins with the edge."""

    def read(self, wire: Levels, before_ns: int | None = None) -> int:
        """Take the levels before this time, or all; after a false start no more.  Returns how many."""
        count = self.left
        if before_ns is not None:
            missing = before_ns * self.per - self.next
            if missing <= 0 or not count:
                return 0
            count = min(count, -(-missing // self.step))
        if not self.taken and not wire.low(self.next, self.per):
            count, self.levels = 1, 1
        else:
            self.levels |= wire.sample(self.next, self.step, self.per, count) << self.taken
        self.taken += count
        self.left -= count
        self.next += count * self.step
        return count

    @property
    def false_start(self) -> bool:
        """True if the start bit is over before its middle."""
        return self.levels & 1 == 1


class Line:
    """The wire from a transmitter to a receiver."""

    def __init__(self, clock: Clock, receiver: "Uart", instant: bool = False) -> None:
        self.clock, self.receiver, self.instant = clock, receiver, instant
        self.samples = 0
        """Levels that have been read off the wire so far."""
        self._levels = Levels()
        self._reading: _Reading | None = None
        self._idle = 0, 1  # from this instant on a falling edge is a start bit: a number, and in units of what
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
        self._unfold()
        self._levels.cut(self.clock.now)

    def mend(self) -> None:
        """What `cut` has done is mended."""
        self._cuts = [token for token in self._cuts if token is not self]

    def short(self, duration_ns: int) -> None:
        """The wire is held at space for so long from now on, whatever the transmitter says."""
        if self.instant:
            self.receiver.take(0, LineError.FRAMING | LineError.BREAK)
        else:
            self._append(Frame.held(self.clock.now, duration_ns))

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
            self._append(Frame.held(self.clock.now, item.duration_ns, own=True))
        else:
            self._append(Frame.of(self.clock.now, sent, item, own=True))

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
            self._append(Frame.held(self.clock.now, item.duration_ns))
        return item.duration_ns

    def _put(self, sent: UartFormat, byte: int, flips: int, delay_ns: int) -> None:
        frame = Frame.of(self.clock.now + delay_ns, sent, byte, flips)
        arrive = self._receive_at_once if self.instant else self._append
        if delay_ns:
            self.clock.call_later(delay_ns, lambda: arrive(frame))
        else:
            arrive(frame)

    # The receiver's side

    def _append(self, frame: Frame) -> None:
        """A frame begins now.  What a receiver has seen before now cannot change any more."""
        if self._reading is not None:
            self._unfold()
            if len(self._levels) > MANY:
                self._read_on(frame.start_ns)
            self._reconsider()
        reading = self._reading
        if reading is None:
            self._levels.forget(frame.start_ns)
            if self._begin_whole(frame):
                return
            self._levels.put(frame)
            self._listen()
        elif not self._invisible(frame, reading):
            self._levels.put(frame)

    def _invisible(self, frame: Frame, reading: _Reading) -> bool:
        """True if the frame is over before the receiver looks at the wire again."""
        last = reading.left <= (1 if self.receiver.resynchronises else 0)
        return not last and reading.whole is None and frame.end * reading.per <= reading.next * frame.per

    def _begin_whole(self, frame: Frame) -> bool:
        """If the receiver understands this frame and nothing else is on the wire, it need not be sampled."""
        idle, per = self._idle
        receiver = self.receiver
        plain = frame.sent is not None and not frame.own and receiver.understands(frame.sent[0])
        if (
            not plain
            or receiver.second_look is not None
            or frame.start_ns * per < idle
            or not self._levels.free(frame.start_ns)
        ):
            return False
        assert receiver.format is not None
        self._begin(_Reading(receiver.format, frame.start_ns, 1, whole=frame))
        return True

    def _unfold(self) -> None:
        """Something else happens on the wire: a character that was not to be sampled must be, if it is not over."""
        reading = self._reading
        if reading is not None and reading.whole is not None and self.clock.now < reading.end_ns:
            self._levels.put(reading.whole)
            reading.whole = None

    def _reconsider(self) -> None:
        """A start bit that is still to come may be another one, now that something else happens on the wire."""
        reading = self._reading
        if reading is not None and reading.space is not None and reading.edge_ns >= self.clock.now:
            reading.space.unread, self._reading = True, None

    def _listen(self) -> None:
        """Wait for the next falling edge; known already, as frames are put on the wire whole.

        A receiver without a format measures how long the line is low first (automatic baud rate).
        """
        for space in self._levels.falls(*self._idle):
            fmt = self._format(self._levels, space)
            if fmt is not None:
                self._begin(_Reading(fmt, space.begin, space.per, space=space))
                return

    def _format(self, levels: Levels, space: Space) -> UartFormat | None:
        """The format in which the receiver reads a character that begins with this space."""
        receiver = self.receiver
        if receiver.format is not None and receiver.second_look is None:
            return receiver.format
        edge_ns = Fraction(space.begin, space.per)
        low_ns = Fraction(space.end, space.per) - edge_ns
        return receiver.measure(low_ns, lambda since_ns: levels.at(edge_ns + since_ns))

    def _begin(self, reading: _Reading) -> None:
        """A start bit, perhaps."""
        self._reading = reading
        self.clock.call_later(max(0, reading.end_ns - self.clock.now), lambda: self._over(reading))

    def _read_on(self, now_ns: int) -> None:
        """Read the levels up to now."""
        while (reading := self._reading) is not None and reading.whole is None:
            self.samples += reading.read(self._levels, now_ns)
            if not reading.false_start:
                return
            self._idle, self._reading = (reading.next - reading.step, reading.per), None
            self._listen()

    def _over(self, reading: _Reading) -> None:
        """The first stop bit is over: the receiver has a character."""
        self._read_on(self.clock.now)
        if reading is not self._reading:  # it was a false start
            return
        sent = None if reading.whole is None else reading.whole.sent
        byte, errors = reading.fmt.read(reading.levels) if sent is None else (sent[1], SOUND)
        again = self.receiver.resynchronises and LineError.FRAMING in errors
        self._idle = reading.idle - again * reading.step, reading.per
        self.receiver.take(byte, errors)  # it may choose the format for what follows
        self._reading = None
        self._listen()

    def _receive_at_once(self, frame: Frame) -> None:
        """A line that takes no time: each character is read by itself."""
        levels = Levels()
        levels.put(frame)
        [first, *_] = levels.falls(0, 1)
        fmt = self._format(levels, first)
        if fmt is None:
            return
        if frame.sent is not None and frame.sent[0].shape == fmt.shape:
            self.receiver.take(frame.sent[1], SOUND)
            return
        reading = _Reading(fmt, first.begin, first.per)
        reading.read(levels)
        if not reading.false_start:
            self.receiver.take(*fmt.read(reading.levels))


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
