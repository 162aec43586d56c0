"""A serial connection at the level of bits: frames that occupy the wire for their duration.

A `Uart` is one end of the connection: a transmitter with a holding register, a receiver, and a format.  A `Line` is the
wire from one end's transmitter to the other end's receiver.  The receiver does not use the sender's format: it detects
a falling edge and samples the middle of each bit in its *own* format, as a real UART does.  Parity and framing errors
follow from a mismatch of formats.

A character is received at the end of its first stop bit; the next one may begin after all stop bits.

`wirings.py` connects the ends; `serial_port.py` is the host's view of a connection.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial
from typing import Protocol

from axistwin.core.units import S, to_ns
from axistwin.sim.clock import Clock, Moment
from axistwin.sim.disturbance import Disturbance, Passage, double, flip, lose
from axistwin.sim.frames import SOUND, Break, Frame, LineError, UartFormat
from axistwin.sim.levels import Levels, Space
from axistwin.sim.receiving import Reading, Whole
from axistwin.sim.signal import Signal

MANY = 12  # Number of stored spaces above which a receiver samples early; about three characters.
LevelAt = Callable[[Fraction], bool]  # Level of the line at a time in ns after a falling edge.


class Wire(Protocol):
    """Interface of a wire that carries the characters of a transmitter."""

    @property
    def instant(self) -> bool: ...

    @property
    def ready(self) -> bool:
        """True if all receivers have room; on an instant line the sender blocks until then."""

    def carry(self, sent: UartFormat, item: int | Break) -> int:
        """Send a character or a break signal, and return the duration of the transmission in ns."""


class _Nowhere:
    instant, ready = False, True

    def carry(self, sent: UartFormat, item: int | Break) -> int:
        return item.duration_ns if isinstance(item, Break) else sent.frame_ns


class Line:
    """The wire from a serial transmitter to a serial receiver."""

    def __init__(self, clock: Clock, receiver: "Uart", instant: bool = False) -> None:
        self.clock, self.receiver, self.instant = clock, receiver, instant
        self.samples = 0
        self._levels = Levels()
        self._whole: Whole | None = None
        self._reading: Reading | None = None
        # Earliest time of the next start bit in ns, as the numerator and denominator of a fraction.
        self._idle = 0, 1
        self._disturbances: list[Disturbance] = []
        self._cuts: list[object] = []
        # End time of the latest delayed character in ns; the next character must not begin before this time.
        self._free_ns = 0

    def disturb(self, disturbance: Disturbance) -> Callable[[], None]:
        """Begin a disturbance, e.g. the loss of characters; return a function that ends it."""
        self._disturbances.append(disturbance)
        return lambda: self._disturbances.remove(disturbance) if disturbance in self._disturbances else None

    def lose(self, characters: int = 1) -> None:
        self.disturb(Disturbance(lose, characters))

    def double(self, characters: int = 1) -> None:
        self.disturb(Disturbance(double, characters))

    def flip(self, mask: int, characters: int = 1) -> None:
        """Inject a fault: invert data bits of the next characters; `mask` selects the bits."""
        self.disturb(Disturbance(flip(mask), characters))

    def cut(self) -> None:
        """Cut the wire from now on, even in the middle of a character; the receiver then samples mark."""
        self._cut_by(self)

    def sever(self) -> Callable[[], None]:
        """Cut the wire.  Return a function that repairs only this cut."""
        token = object()
        self._cut_by(token)
        return lambda: self._cuts.remove(token)

    def _cut_by(self, token: object) -> None:
        self._cuts.append(token)
        self._sample_whole()
        self._levels.cut(self.clock.now)

    def mend(self) -> None:
        self._cuts = [token for token in self._cuts if token is not self]

    def short(self, duration_ns: int) -> None:
        """Inject a short circuit, which holds the wire at space (logic 0) for `duration_ns`."""
        if self.instant:
            self.receiver.take(0, LineError.FRAMING | LineError.BREAK)
        else:
            self._append(Frame.held(self.clock.now, duration_ns))

    @property
    def ready(self) -> bool:
        return self.receiver.has_room()

    def occupy(self, sent: UartFormat, item: int | Break) -> None:
        """Put a signal of the receiver's own device on the wire: it is ignored, but garbles other characters."""
        if self.instant:
            return
        if isinstance(item, Break):
            self._append(Frame.held(self.clock.now, item.duration_ns, own=True))
        else:
            self._append(Frame.of(self.clock.now, sent, item, own=True))

    def carry(self, sent: UartFormat, item: int | Break) -> int:
        if isinstance(item, Break):
            return self._carry_break(item)
        delayed = self._free_ns and self._free_ns > self.clock.now
        if not (delayed or self._disturbances or self._cuts) and self.receiver.understands(sent):
            byte = item & ((1 << sent.bytesize) - 1)
            if self.instant:
                self.receiver.take(byte, SOUND)
                return 0
            if self._begin_whole(sent, byte, self.clock.now):
                return sent.frame_ns
        passage = self._passage(sent)
        if not self._cuts:
            self._pass(passage, item)
        return 0 if self.instant else max(passage.copies, 1) * sent.frame_ns

    def _passage(self, sent: UartFormat) -> Passage:
        passage = Passage(sent)
        for disturbance in tuple(self._disturbances):
            disturbance.meet(passage)
            if disturbance.over and disturbance in self._disturbances:
                self._disturbances.remove(disturbance)
        return passage

    def _pass(self, passage: Passage, byte: int) -> None:
        """Deliver all copies of a character; later characters do not overtake delayed ones."""
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

    def _append(self, frame: Frame) -> None:
        """Put a frame on the wire now.  Samples before now are final."""
        self._sample_whole()
        if self._reading is not None:
            if len(self._levels) > MANY:
                self._read_on(frame.start_ns)
            self._discard_future_start()
        reading = self._reading
        if self._whole is not None:
            self._levels.put(frame)
        elif reading is None:
            self._levels.forget(frame.start_ns)
            self._levels.put(frame)
            self._find_start_bit()
        elif (
            reading.left <= (1 if self.receiver.resynchronises else 0)
            or frame.end * reading.per > reading.next * frame.per
        ):
            self._levels.put(frame)  # A pulse that ends before the receiver samples the next bit has no effect.

    def _begin_whole(self, sent: UartFormat, byte: int, now_ns: int) -> bool:
        """Receive a character without sampling, and return True, if the wire is free and the format understood."""
        if self._whole is not None or self._reading is not None or self.receiver.second_look is not None:
            return False
        idle, per = self._idle
        if now_ns * per < idle or not self._levels.free(now_ns):
            return False
        self._levels.forget(now_ns)
        whole = self._whole = Whole(sent, byte, now_ns)
        self.clock.call_later(sent.receive_ns, partial(self._end_whole, whole))
        return True

    def _end_whole(self, whole: Whole) -> None:
        if whole.sampled is not None:
            self._end_character(whole.sampled)
            return
        per = 2 * whole.sent.baudrate
        self._idle = whole.end_ns * per - S, per
        self.receiver.take(whole.byte, SOUND)
        self._whole = None
        # A received command may have changed the baud rate for the next character.
        if self._levels:
            self._find_start_bit()

    def _sample_whole(self) -> None:
        """Start sampling a character that was to be received as a whole, because another signal is on the wire now."""
        whole = self._whole
        if whole is not None and self.clock.now < whole.end_ns:
            self._levels.put(Frame.of(whole.start_ns, whole.sent, whole.byte))
            self._whole, self._reading = None, Reading(whole.sent, whole.start_ns, 1)
            whole.sampled = self._reading

    def _discard_future_start(self) -> None:
        """Discard a start bit in the future, because the new signal may bring an earlier one."""
        reading = self._reading
        if reading is not None and reading.space is not None and reading.edge_ns >= self.clock.now:
            reading.space.unread, self._reading = True, None

    def _find_start_bit(self) -> None:
        """Find the next falling edge.  Each frame is put on the wire as a whole, so the edge is already known.

        A receiver without a format first measures the duration of the low level (automatic baud rate).
        """
        for space in self._levels.falls(*self._idle):
            fmt = self._format(self._levels, space)
            if fmt is not None:
                self._begin(Reading(fmt, space.begin, space.per, space))
                return

    def _format(self, levels: Levels, space: Space) -> UartFormat | None:
        receiver = self.receiver
        if receiver.format is not None and receiver.second_look is None:
            return receiver.format
        edge_ns = Fraction(space.begin, space.per)
        low_ns = Fraction(space.end, space.per) - edge_ns
        return receiver.measure(low_ns, lambda since_ns: levels.at(edge_ns + since_ns))

    def _begin(self, reading: Reading) -> None:
        self._reading = reading
        self.clock.call_later(max(0, reading.end_ns - self.clock.now), lambda: self._end_character(reading))

    def _read_on(self, now_ns: int) -> None:
        while (reading := self._reading) is not None:
            self.samples += reading.read(self._levels, now_ns)
            if not reading.false_start:
                return
            self._idle, self._reading = (reading.next - reading.step, reading.per), None
            self._find_start_bit()

    def _end_character(self, reading: Reading) -> None:
        self._read_on(self.clock.now)
        if reading is not self._reading:  # The start bit was too short, so the receiver gets no character.
            return
        byte, errors = reading.fmt.read(reading.levels)
        again = self.receiver.resynchronises and LineError.FRAMING in errors
        self._idle = reading.idle - again * reading.step, reading.per
        self.receiver.take(byte, errors)
        self._reading = None
        # A received command may have changed the baud rate for the next character.
        self._find_start_bit()

    def _receive_at_once(self, frame: Frame) -> None:
        """Deliver a character without delay, as on an ideal line; the receiver samples each separately."""
        levels = Levels()
        levels.put(frame)
        [first, *_] = levels.falls(0, 1)
        fmt = self._format(levels, first)
        if fmt is None:
            return
        if frame.sent is not None and frame.sent[0].shape == fmt.shape:
            self.receiver.take(frame.sent[1], SOUND)
            return
        reading = Reading(fmt, first.begin, first.per)
        reading.read(levels)
        if not reading.false_start:
            self.receiver.take(*fmt.read(reading.levels))


@dataclass
class Uart:
    """A UART: transmitter with a holding register, receiver, and character format."""

    clock: Clock
    format: UartFormat | None = field(default_factory=UartFormat)
    on_receive: Callable[[int, LineError], None] = lambda byte, errors: None
    on_measure: Callable[[Fraction], UartFormat | None] = lambda low_ns: None
    """Return a format for a start bit of this length; called while `format` is None."""
    second_look: Callable[[Fraction, LevelAt], UartFormat | None] | None = None
    """Return another format for one character, or None; called at each start bit if `format` is set.

    Arguments: the time that the line is low, and the levels from the falling edge on.
    """
    resynchronises: bool = False  # A falling edge between the last data bit and a low stop bit begins the next.
    has_room: Callable[[], bool] = lambda: True  # False while the receiver is full: an instant sender then blocks.

    on_idle: Callable[[], None] = lambda: None

    def __post_init__(self) -> None:
        self.line: Wire = _Nowhere()
        self.peers: tuple[Uart, ...] = ()  # The ends whose characters arrive here.
        self.received: Signal[int, LineError] = Signal()  # Emitted with each received character, after `on_receive`.
        self.queue: deque[int | Break] = deque()
        self.sending, self.held = False, False
        self.when_empty = Moment(self.clock)  # The transmitter's holding register is empty.
        self.when_idle = Moment(self.clock)  # All queued characters have been sent.

    def take(self, byte: int, errors: LineError) -> None:
        self.on_receive(byte, errors)
        self.received.emit(byte, errors)

    def understands(self, sent: UartFormat) -> bool:
        return self.format is sent or (self.format is not None and self.format.shape == sent.shape)

    def measure(self, low_ns: Fraction, level_at: LevelAt) -> UartFormat | None:
        """Return the format for a character that begins with the line low for `low_ns`."""
        if self.format is None:
            return self.on_measure(low_ns)
        other = None if self.second_look is None else self.second_look(low_ns, level_at)
        return other or self.format

    def send(self, data: bytes) -> None:
        """Queue characters, each for the format that is set when its transmission begins."""
        self.queue.extend(data)
        self.pump()

    def send_break(self, seconds: float) -> None:
        """Send a break with the duration `seconds` when all queued characters have been sent."""
        self.queue.append(Break(to_ns(seconds)))
        self.pump()

    def pump(self) -> None:
        """Send queued characters and breaks while the wire is free."""
        line, queue = self.line, self.queue
        while queue and not self.sending and not self.held:
            assert self.format is not None
            if line.instant and not line.ready:
                return
            if taken_ns := line.carry(self.format, queue.popleft()):
                self.sending = True
                self.clock.call_later(taken_ns, self._sent)
        if not queue:
            self.when_empty.happens()

    def pump_peer(self) -> None:
        """On an instant line, resume the transmitter of the other end: this receiver has room again."""
        for peer in self.peers:
            if peer.queue:
                peer.pump()

    @property
    def instant(self) -> bool:
        """True if the transmission of a character takes no time on this connection."""
        return self.line.instant

    def _sent(self) -> None:
        self.sending = False
        self.pump()
        if self.sending:
            return
        self.on_idle()
        self.when_idle.happens()
