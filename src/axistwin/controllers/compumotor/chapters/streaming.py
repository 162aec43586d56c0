"""Chapter Velocity-streaming mode: commands 42h, 50h to 53h, 7Bh, E0h, E1h, E3h, EEh.

The host says velocity by velocity, or distance by distance, what the motor is to do; a buffer holds what is to come.
A velocity number V gives effective clock * V / 65536 pulses/s: a phase accumulator of 16 bits, whose fraction of a
pulse is kept from one velocity to the next as long as the motor neither stands nor turns round.
"""

from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any

from axistwin.controllers.compumotor.chapters.pulses import Phase, VelocityProfile
from axistwin.controllers.compumotor.chapters.ranges import BASE_CLOCKS, FULL
from axistwin.controllers.compumotor.language import CCW, Accept, Opcode
from axistwin.motion.profile import Segment
from axistwin.sim.clock import Procedure, Process, kill
from axistwin.units import MS

if TYPE_CHECKING:
    from axistwin.controllers.compumotor.board import Board

VELOCITY_DISTANCE, VELOCITY_TIME, DISTANCE_TIME = 0x51, 0x52, 0x53
WORD = 2
LEAST_FREE = 15
"""Bytes that must be free for E0h, E1h and E3h."""
SHORTEST_NS = 2 * MS
"""A velocity-distance pair lasts at least so long, and a velocity of zero exactly."""
FASTEST = CCW - 1
"""A velocity number without its direction bit."""
END_OF_STREAM = 0x8001
NO_MARKERS_OF_DISTANCE = (0x8000, END_OF_STREAM)
MOST_MARKERS = 10
MOST_MARKER_PARAMETERS = 2
MARKER_ATTRIBUTES = Accept.STREAMING | Accept.DURING_STREAMING

Entry = tuple[int, ...]
"""Words of the buffer that belong together: velocity and distance, or either."""


@dataclass(frozen=True)
class Setting:
    """How a streaming mode has been entered.  `alarm` in bytes; `period_ms` 0: a mode without update rate."""

    mode: int
    base: int
    divisor: int
    alarm: int
    period_ms: int = 0

    @cached_property
    def clock(self) -> Fraction:
        """The effective clock in Hz."""
        return BASE_CLOCKS[self.base] / self.divisor

    @cached_property
    def maximum(self) -> Fraction:
        """The highest velocity in pulses/s, which no number quite reaches."""
        return self.clock / 2

    @cached_property
    def resolution(self) -> Fraction:
        """Pulses/s of a velocity number of 1."""
        return self.clock / FULL

    @property
    def parameters(self) -> bytes:
        """As they were sent."""
        rate = self.period_ms.to_bytes(2, "big") if self.period_ms else b""
        return bytes([self.base, self.divisor]) + self.alarm.to_bytes(4, "big") + rate

    def rate(self, number: int) -> Fraction:
        """Pulses/s of a velocity number, whatever its direction."""
        return self.resolution * (number & FASTEST)


@dataclass(frozen=True)
class Marker:
    """What is done where a special value stands in the stream."""

    command: Opcode
    values: tuple[Any, ...]


class Stream:
    """The streaming buffer, and who performs it."""

    def __init__(self, board: "Board", memory: int, marker_ns: int) -> None:
        self._board, self._memory, self._marker_ns = board, memory, marker_ns
        self.setting: Setting | None = None
        """None: indexer mode."""
        self.markers: dict[int, Marker] = {}
        self._entries: deque[Entry] = deque()
        self._used = 0
        self._alarm_on = False
        self._process: Process | None = None
        self._marker_process: Process | None = None

    @property
    def processes(self) -> tuple[Process | None, Process | None]:
        """What performs the buffer, and a marker."""
        return self._process, self._marker_process

    @property
    def performing(self) -> bool:
        """Whether the buffer is being performed."""
        return self._process is not None

    @property
    def free(self) -> int:
        """Bytes that are free."""
        return self._memory - self._used

    @property
    def empty(self) -> bool:
        """Whether there is nothing to perform."""
        return not self._entries

    # Filling

    def enter(self, setting: Setting | None) -> None:
        """Another mode, or the same anew; the buffer is empty."""
        self.setting = setting
        self.clear()

    def clear(self) -> None:
        """Nothing is in the buffer any more."""
        self._entries.clear()
        self._used, self._alarm_on = 0, False

    def store(self, mode: int, entries: Iterable[Entry]) -> None:
        """Data for this mode; lost in any other and where there is too little room."""
        if self.setting is None or self.setting.mode != mode or self.free < LEAST_FREE:
            return
        for entry in entries:
            self._entries.append(entry)
            self._used += WORD * len(entry)
        self._alarm_on |= self._used > self.setting.alarm

    def _take(self) -> Entry:
        assert self.setting is not None
        entry = self._entries.popleft()
        self._used -= WORD * len(entry)
        self.alarm(self._used)
        return entry

    def alarm(self, left: int) -> None:
        """Send the buffer empty alarm if it is on and so many bytes left are few enough; it is off then."""
        assert self.setting is not None
        if self._alarm_on and left <= self.setting.alarm:
            self._alarm_on = False
            self._board.send(self.setting.mode, self.setting.parameters)

    # Performing

    def start(self) -> None:
        """Perform what is in the buffer."""
        self._process = self._board.clock.process(self._perform())
        self._board.refresh()

    def end(self) -> None:
        """The performance ends before its time; the motor goes on as it does."""
        process, self._process = self._process, None
        if process is not None:
            if process is not self._board.clock.active_process:  # else it sees that it is no longer the one
                kill(process)
            self._board.refresh()

    def abandon(self) -> None:
        """The power is gone, or the test begins."""
        for process in (self._process, self._marker_process):
            if process is not None and process is not self._board.clock.active_process:
                kill(process)
        self._process = None

    def _perform(self) -> Procedure:
        board = self._board
        yield board.occupy(board.start_ns)
        marker: Marker | None = None
        while self._entries:
            entry = self._take()
            if (met := self._marker(entry[0])) is not None:
                marker = met  # of several in a row the last one counts
                continue
            self._execute(marker)
            marker = None
            duration_ns = self._give_out(entry)
            if not self.performing:  # what it has given out has led to its end
                return
            if duration_ns is None:
                break
            yield board.clock.timeout(duration_ns)
        else:
            self._execute(marker)
            board.pulses.hold()
        self._process = None
        board.refresh()

    def _give_out(self, entry: Entry) -> int | None:
        """What an entry asks for begins; how long until the next one, in ns.  None: the performance is over."""
        assert self.setting is not None
        if self.setting.mode == VELOCITY_DISTANCE:
            return self._velocity_for_distance(*entry)
        give_out = self._distance if self.setting.mode == DISTANCE_TIME else self._velocity
        going_on = give_out(*entry)
        return self.setting.period_ms * MS if going_on else None

    def _velocity_for_distance(self, number: int, distance: int) -> int | None:
        if number & FASTEST and not distance:
            return 0
        if not self._velocity(number):
            return None
        return max(SHORTEST_NS, self._board.pulses.ns_until(distance)) if number & FASTEST else SHORTEST_NS

    def _velocity(self, number: int) -> bool:
        assert self.setting is not None
        side = -1 if number & CCW else +1
        return self._run(self.setting.rate(number), side if self._board.pulses.cw_is_plus else -side)

    def _distance(self, word: int) -> bool:
        assert self.setting is not None
        if word == END_OF_STREAM:
            self._board.pulses.kill()
            return False
        distance = word - FULL if word & CCW else word
        wish = Fraction(abs(distance) * 1000, self.setting.period_ms)
        return self._run(min(wish, self.setting.rate(FASTEST)), -1 if distance < 0 else +1)

    def _run(self, rate: Fraction, sign: int) -> bool:
        """At this velocity from now on; False: there is no motion in that direction."""
        board, pulses = self._board, self._board.pulses
        assert self.setting is not None
        if not rate:
            pulses.kill()
        elif board.blocked(sign):
            pulses.kill()
            return False
        else:
            before = pulses.rate * pulses.sign * sign
            phase = Phase.CONSTANT
            if rate != before:
                phase = Phase.ACCELERATING if rate > before else Phase.DECELERATING
            pulses.run(VelocityProfile(((phase, (Segment(rate, None),)),), self.setting.maximum, of_move=False), sign)
        return True

    # Markers

    def _marker(self, word: int) -> Marker | None:
        assert self.setting is not None
        if self.setting.mode == DISTANCE_TIME and word in NO_MARKERS_OF_DISTANCE:
            return None
        return self.markers.get(word)

    def _execute(self, marker: Marker | None) -> None:
        """Takes its time beside the stream; while one is being executed another is lost."""
        busy = self._marker_process is not None and self._marker_process.is_alive
        if marker is not None and not busy:
            self._marker_process = self._board.clock.process(self._carry_out(marker))

    def _carry_out(self, marker: Marker) -> Procedure:
        assert marker.command.handler is not None
        yield self._board.clock.timeout(self._marker_ns)
        result = marker.command.handler(self._board, *marker.values)
        if isinstance(result, bytes):
            self._board.send(marker.command.opcode, result)


# Modes


def indexer_mode(board: "Board") -> None:
    """Command 50h: indexer mode; what is in the streaming buffer is lost."""
    _enter(board, None)


def enter(mode: int, board: "Board", base: int, divisor: int, alarm: int, period_ms: int = 0) -> None:
    """Commands 51h to 53h: a streaming mode; the sequences are lost.  Ignored while the motor is moving.

    `base`: 1 to 9, for 53h to 3; `divisor`: 1 to 16; `alarm` in bytes; `period_ms`: the update rate, 52h and 53h.
    """
    if not board.occupied:
        board.sequences.clear()
        _enter(board, Setting(mode, base, divisor, alarm, period_ms))


def _enter(board: "Board", setting: Setting | None) -> None:
    board.stream.enter(setting)
    board.mode = setting.mode if setting else 0x50
    board.mode_parameters = setting.parameters if setting else b""


# Data


def velocity_distance(board: "Board", *words: int) -> None:
    """Command E0h: three pairs of a velocity number and a distance in pulses.  A pair without distance is skipped."""
    board.stream.store(VELOCITY_DISTANCE, zip(words[::2], words[1::2], strict=True))


def velocity_time(board: "Board", *numbers: int) -> None:
    """Command E1h: seven velocity numbers, each for one period of the update rate."""
    board.stream.store(VELOCITY_TIME, ((number,) for number in numbers))


def distance_time(board: "Board", count: int, *distances: int) -> None:
    """Command E3h: `count` of seven signed distances, each for one period; 8001h ends the stream at velocity zero."""
    board.stream.store(DISTANCE_TIME, ((distance % FULL,) for distance in distances[:count]))


def define_marker(board: "Board", word: int, opcode: int, first: int, second: int) -> None:
    """Command EEh: where this word stands in the stream a command is executed instead; opcode 00 deletes it.

    Ignored if the command is not one for use while streaming or has more than two parameters, if there are ten
    markers already, and in distance-time mode for 8000h and 8001h.
    """
    if board.mode == DISTANCE_TIME and word in NO_MARKERS_OF_DISTANCE:
        return
    markers = board.stream.markers
    if opcode == 0:
        markers.pop(word, None)
    elif word in markers or len(markers) < MOST_MARKERS:
        marker = _marker(board, opcode, bytes([first, second]))
        if marker is not None:
            markers[word] = marker


def _marker(board: "Board", opcode: int, parameters: bytes) -> Marker | None:
    command = board.commands.get(opcode)
    if not isinstance(command, Opcode) or not command.implemented:
        return None
    if MARKER_ATTRIBUTES not in command.accepted or command.size > MOST_MARKER_PARAMETERS:
        return None
    values = command.decode(parameters)
    return None if values is None else Marker(command, values)


# Performing


def perform(board: "Board") -> None:
    """Command 42h: perform the streaming buffer.  Ignored if it is empty, during a move and while shut down.

    When it has run dry the motor stays at its velocity until the buffer is refilled and this is sent again.
    """
    if not (board.stream.empty or board.performing_singular or board.joystick.enabled or board.shut_down):
        board.motion.end, board.motion.streamed = None, True
        board.stream.start()


def kill_buffer(board: "Board") -> None:
    """Commands 7Bh, 7Fh: the buffer is empty, and no longer performed; the motor keeps its velocity.

    An alarm that is on is sent if the buffer was being performed.
    """
    if board.streaming:
        board.stream.end()
        board.pulses.hold()
        board.stream.alarm(0)
    board.stream.clear()
    board.refresh()


def velocity(board: "Board") -> bytes:
    """Command 85h in a streaming mode: a velocity number, with bit 15 set while moving CCW."""
    setting, pulses = board.stream.setting, board.pulses
    assert setting is not None
    number = min(round(pulses.rate / setting.resolution), FASTEST)
    return (number | (CCW if pulses.moving and pulses.physical < 0 else 0)).to_bytes(2, "big")
