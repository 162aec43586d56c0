"""Chapter Velocity-streaming mode: commands 42h, 50h to 53h, 7Bh, E0h, E1h, E3h, EEh.

The host sends velocities or distances in advance, and the streaming buffer stores these data.
Velocity number V gives effective clock * V / 65536 pulses/s, as from a phase accumulator of 16 bits.  The fraction of
a pulse is kept from one velocity to the next, until the motor stops or reverses.
"""

from fractions import Fraction
from functools import lru_cache

from axistwin.controllers.compumotor.language import CCW, Accept, Opcode
from axistwin.controllers.compumotor.parts.pulses import Phase, VelocityProfile
from axistwin.controllers.compumotor.parts.ranges import FULL
from axistwin.controllers.compumotor.parts.stream import FASTEST, Entry, Marker, Setting
from axistwin.controllers.compumotor.state import IN_MOTION, SHUT_DOWN, State, ns
from axistwin.core.units import MS
from axistwin.sim.clock import Procedure
from axistwin.sim.motion.profile import Segment

VELOCITY_DISTANCE, VELOCITY_TIME, DISTANCE_TIME = 0x51, 0x52, 0x53
SHORTEST_NS = 2 * MS  # The shortest duration of a velocity-distance pair, and the duration of a velocity of zero.
END_OF_STREAM = 0x8001
NO_MARKERS_OF_DISTANCE = (0x8000, END_OF_STREAM)
MOST_MARKERS = 10
MOST_MARKER_PARAMETERS = 2
MARKER_ATTRIBUTES = Accept.STREAMING | Accept.DURING_STREAMING


class StreamOutput:
    """Moves the motor according to the data in the streaming buffer, e.g. velocities from the host."""

    def __init__(self, board: State, setting: Setting) -> None:
        self._board, self._setting, self._stream, self._pulses = board, setting, board.stream, board.pulses
        self._period_ns = setting.period_ms * MS
        self._end = END_OF_STREAM if setting.mode == DISTANCE_TIME else None

    def perform(self) -> Procedure:
        """Move the motor at the velocities in the streaming buffer, until the buffer is empty.

        The output also ends when the motion is blocked, e.g. by a limit input.  If markers (numbers that start a
        command) follow each other directly, the board performs only the command of the last marker.
        """
        board, stream = self._board, self._stream
        yield board.occupy(board.start_ns)
        marker: Marker | None = None
        while not stream.empty:
            entry = stream.take()
            if (met := self._marker(entry[0])) is not None:
                marker = met
                continue
            self._execute(marker)
            marker = None
            duration_ns = self._output(entry)
            if not stream.performing:  # The streaming has ended, e.g. at a limit switch.
                return
            if duration_ns is None:
                break
            if not board.clock.skip(duration_ns):
                yield board.clock.timeout(duration_ns)
            if self._period_ns:
                self._run_ahead()
        else:
            self._execute(marker)
            self._pulses.hold()
        stream.finish()

    def _run_ahead(self) -> None:
        """Simulate update periods of one direction, without another event, in one step, for speed; same pulses."""
        board, pulses = self._board, self._pulses
        if board.clock.free_ns <= self._period_ns:
            return
        if board.outputs.in_use or board.joystick.enabled or board.blocked(pulses.sign):
            return
        while segments := self._ahead(min((board.clock.free_ns - 1) // self._period_ns, pulses.room)):
            pulses.append(segments)
            board.clock.skip(len(segments) * self._period_ns)

    def _ahead(self, most: int) -> list[Segment]:
        """Remove up to `most` velocities of the present direction; return a segment of one period for each."""
        segments: list[Segment] = []
        setting, markers = self._setting, self._stream.markers
        direction = CCW if self._sign(CCW) == self._pulses.sign else 0
        for (word,) in self._stream.without_alarm(most):
            if word & CCW != direction or not word & FASTEST or word == self._end or word in markers:
                break
            segments.append(_segment(setting, word))
        self._stream.drop(len(segments))
        return segments

    def _output(self, entry: Entry) -> int | None:
        """Output one entry of the buffer.  Return the ns until the next one; None at the end of the stream."""
        if self._setting.mode == VELOCITY_DISTANCE:
            return self._velocity_for_distance(*entry)
        (word,) = entry
        if word == self._end:
            self._pulses.kill()
            return None
        return self._period_ns if self._run(word) else None

    def _velocity_for_distance(self, number: int, distance: int) -> int | None:
        if number & FASTEST and not distance:
            return 0
        if not self._run(number):
            return None
        return max(SHORTEST_NS, self._pulses.ns_until(distance)) if number & FASTEST else SHORTEST_NS

    def _sign(self, word: int) -> int:
        """Return the direction of a word, +1 or -1: distances are signed + and -, velocities CW and CCW."""
        plus = self._end is not None or self._pulses.cw_is_plus
        return -1 if plus == bool(word & CCW) else +1

    def _run(self, word: int) -> bool:
        """Change to the next velocity, or distance in one period, `word`; return False if motion is blocked."""
        pulses, rate, sign = self._pulses, _rate(self._setting, word), self._sign(word)
        if not rate:
            pulses.kill()
        elif self._board.blocked(sign):
            pulses.kill()
            return False
        else:
            before = pulses.rate if pulses.sign == sign else -pulses.rate
            phase = Phase.CONSTANT
            if rate != before:
                phase = Phase.ACCELERATING if rate > before else Phase.DECELERATING
            pulses.run(_endless(phase, self._setting, word), sign)
        return True

    def _marker(self, word: int) -> Marker | None:
        if self._setting.mode == DISTANCE_TIME and word in NO_MARKERS_OF_DISTANCE:
            return None
        return self._stream.markers.get(word)

    def _execute(self, marker: Marker | None) -> None:
        """Start the command of a marker; the stream continues, and ignores other markers meanwhile."""
        if marker is None:
            return
        if self._stream.marker_process is None or not self._stream.marker_process.is_alive:
            self._stream.marker_process = self._board.clock.process(self._carry_out(marker))

    def _carry_out(self, marker: Marker) -> Procedure:
        board, command = self._board, marker.command
        assert command.handler is not None
        yield board.clock.timeout(ns(board.options.marker_ms))
        result = command.handler(board, *marker.values)
        if isinstance(result, bytes):
            board.send(command.opcode, result)


@lru_cache(maxsize=4096)
def _rate(setting: Setting, word: int) -> Fraction:
    """Return the step rate in pulses/s; in distance-time mode, `word` is the pulses in one update period."""
    if setting.mode != DISTANCE_TIME:
        return setting.rate(word & FASTEST)
    distance = FULL - word if word & CCW else word
    return min(Fraction(distance * 1000, setting.period_ms), setting.rate(FASTEST))


@lru_cache(maxsize=4096)
def _segment(setting: Setting, word: int) -> Segment:
    return Segment(_rate(setting, word), setting.period)


@lru_cache(maxsize=4096)
def _endless(phase: Phase, setting: Setting, word: int) -> VelocityProfile:
    return VelocityProfile(((phase, (Segment(_rate(setting, word), None),)),), setting.maximum, of_move=False)


def indexer_mode(board: State) -> None:
    """Command 50h: enter indexer mode; the contents of the streaming buffer are lost."""
    board.stream.enter(None)


def enter(mode: int, board: State, base: int, divisor: int, alarm: int, period_ms: int = 0) -> str | None:
    """Commands 51h to 53h: enter a streaming mode, and delete all stored sequences.

    Ignored while the motor is moving.  `base`: 1 to 9 (53h: 1 to 3); `divisor`: 1 to 16; `alarm` in bytes; `period_ms`:
    update period of 52h and 53h.
    """
    if board.occupied:
        return IN_MOTION
    board.sequences.buffers.clear()
    board.sequences.defining = None
    board.stream.enter(Setting(mode, base, divisor, alarm, period_ms))
    return None


def velocity_distance(board: State, *words: int) -> str | None:
    """Command E0h: add three pairs of velocity and distance to the streaming buffer.

    The distance is in pulses.  A pair with distance 0 is skipped.
    """
    return board.stream.store(VELOCITY_DISTANCE, zip(words[::2], words[1::2], strict=True))


def velocity_time(board: State, *numbers: int) -> str | None:
    """Command E1h: add seven velocities to the streaming buffer.

    The motor runs at each velocity for the same time, the update period.
    """
    return board.stream.store(VELOCITY_TIME, ((number,) for number in numbers))


def distance_time(board: State, count: int, *distances: int) -> str | None:
    """Command E3h: `count` of seven signed distances in pulses, each for one period; 8001h ends the stream."""
    return board.stream.store(DISTANCE_TIME, ((distance % FULL,) for distance in distances[:count]))


def define_marker(board: State, word: int, opcode: int, first: int, second: int) -> str | None:
    """Command EEh: assign a command to a number, e.g. 7FF0h.  The board executes the command when the number occurs in
    the velocity stream.

    Such a number is a marker among the streamed velocities or distances.  `word`: the number.  `opcode`: the command.
    Opcode 00 deletes the marker.  EEh is ignored if the command of the marker is not valid while streaming, or has more
    than two parameters.  EEh is also ignored while ten markers are in use, and in distance-time mode for the values
    8000h and 8001h.
    """
    if board.mode == DISTANCE_TIME and word in NO_MARKERS_OF_DISTANCE:
        return "8000h and 8001h cannot be markers in this mode: use another number, e.g. 8002h"
    markers = board.stream.markers
    if opcode == 0:
        markers.pop(word, None)
        return None
    if word not in markers and len(markers) >= MOST_MARKERS:
        return f"{MOST_MARKERS} markers are in use: delete one first, by EE with the opcode 00"
    marker = _marker(board, opcode, bytes([first, second]))
    if marker is None:
        return f"{opcode:02X} cannot be in a marker: use a command valid while streaming with at most two parameters"
    markers[word] = marker
    return None


def _marker(board: State, opcode: int, parameters: bytes) -> Marker | None:
    command = board.commands.get(opcode)
    if not isinstance(command, Opcode) or not command.implemented:
        return None
    if MARKER_ATTRIBUTES not in command.accepted or command.size > MOST_MARKER_PARAMETERS:
        return None
    values = command.decode(parameters)
    return None if values is None else Marker(command, values)


def perform(board: State) -> str | None:
    """Command 42h: convert the velocities or distances in the streaming buffer to motor pulses.

    Ignored if the buffer is empty, during a move, and during shutdown.  At the end of the buffer the motor keeps its
    velocity until the buffer is refilled and 42h is sent again.
    """
    if board.stream.empty:
        return "the streaming buffer is empty: send data (E0, E1 or E3) first"
    if board.shutdown.on:
        return SHUT_DOWN
    if board.host.busy or board.sequence.busy or board.joystick.enabled:
        return IN_MOTION
    assert board.stream.setting is not None, "42h is valid in streaming modes only"
    board.motion.end, board.motion.streamed = None, True
    board.stream.start(StreamOutput(board, board.stream.setting).perform())
    return None


def kill_buffer(board: State) -> None:
    """Commands 7Bh, 7Fh: empty the streaming buffer and end the stream; the motor keeps its velocity.

    If a stream is ended, an enabled buffer empty alarm is sent.
    """
    if board.stream.performing:
        board.stream.end()
        board.pulses.hold()
        board.stream.alarm(0)
    board.stream.clear()
    board.refresh()


def velocity(board: State) -> bytes:
    """Command 85h in a streaming mode: a velocity number, with bit 15 set while moving CCW."""
    setting, pulses = board.stream.setting, board.pulses
    assert setting is not None
    number = min(round(pulses.rate / setting.resolution), FASTEST)
    return (number | (CCW if pulses.moving and pulses.physical < 0 else 0)).to_bytes(2, "big")
