"""The streaming buffer, which stores velocities, distances and markers that the host sends in advance."""

from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import islice
from typing import Any

from axistwin.controllers.compumotor.language import CCW, Opcode
from axistwin.controllers.compumotor.parts.ranges import BASE_CLOCKS, FULL
from axistwin.sim.clock import Clock, Procedure, Process, kill

WORD = 2
LEAST_FREE = 15
"""Number of bytes that must be free for the data of E0h, E1h or E3h."""
FASTEST = CCW - 1
"""Highest velocity number, without the direction bit."""

Entry = tuple[int, ...]
"""An entry of the buffer: a velocity, a distance, or a velocity and a distance."""


@dataclass(frozen=True, eq=False)
class Setting:
    """A streaming mode and its parameters.

    `alarm`: a number of bytes; `period_ms`: 0 in a mode without update rate.
    """

    mode: int
    base: int
    divisor: int
    alarm: int
    period_ms: int = 0

    @cached_property
    def clock(self) -> Fraction:
        """Effective clock frequency in Hz: the base clock, divided by the divisor."""
        return BASE_CLOCKS[self.base] / self.divisor

    @cached_property
    def maximum(self) -> Fraction:
        """Upper limit of the streamed velocity in pulses/s.

        The highest velocity number gives a velocity below this limit.
        """
        return self.clock / 2

    @cached_property
    def resolution(self) -> Fraction:
        """Smallest difference between two streamed velocities, in pulses/s.

        A streamed velocity number n means n times this step rate.
        """
        return self.clock / FULL

    @cached_property
    def period(self) -> Fraction:
        """Update period of the velocity stream, in seconds.

        The board outputs one velocity or distance in each period.  In velocity-distance mode, which has no update
        period, the value is 0.
        """
        return Fraction(self.period_ms, 1000)

    def rate(self, number: int) -> Fraction:
        """Convert a velocity from the controller's units to pulses/s.

        `number`: the velocity in units of `resolution`.
        """
        return Fraction(self.resolution.numerator * number, self.resolution.denominator)

    @property
    def parameters(self) -> bytes:
        """Parameter bytes of the command with which the host entered the streaming mode."""
        rate = self.period_ms.to_bytes(2, "big") if self.period_ms else b""
        return bytes([self.base, self.divisor]) + self.alarm.to_bytes(4, "big") + rate


@dataclass(frozen=True)
class Marker:
    """A command that the board executes when a given number, e.g. 7FF0h, occurs in the velocity stream.

    The host assigns the command and its parameter values to the number by command EEh.
    """

    command: Opcode
    values: tuple[Any, ...]


class Stream:
    """The streaming buffer, and the process that outputs its contents."""

    def __init__(
        self, clock: Clock, memory: int, send: Callable[[int, bytes], None], refresh: Callable[[], None]
    ) -> None:
        self._clock, self._memory, self._send, self._refresh = clock, memory, send, refresh
        self.setting: Setting | None = None
        """Present streaming mode with its parameters; None in indexer mode."""
        self.markers: dict[int, Marker] = {}
        self._entries: deque[Entry] = deque()
        self._used = 0
        self._alarm_on = False
        self.process: Process | None = None
        self.marker_process: Process | None = None

    @property
    def performing(self) -> bool:
        """True while the board outputs the contents of the streaming buffer."""
        return self.process is not None

    @property
    def free(self) -> int:
        """Number of free bytes in the streaming buffer."""
        return self._memory - self._used

    @property
    def empty(self) -> bool:
        """True if the streaming buffer has no entries."""
        return not self._entries

    def enter(self, setting: Setting | None) -> None:
        """Set the operating mode of the board: a streaming mode or indexer mode.

        `setting`: the streaming mode with its parameters, or None for indexer mode.  The streaming buffer is emptied.
        """
        self.setting = setting
        self.clear()

    def clear(self) -> None:
        """Remove all entries from the streaming buffer."""
        self._entries.clear()
        self._used, self._alarm_on = 0, False

    def store(self, mode: int, entries: Iterable[Entry]) -> str | None:
        """Store data in the streaming buffer.

        The data are lost if the present mode is not `mode`, or if the memory is full; then the reason is returned.
        """
        if self.setting is None:
            return ""
        if self.setting.mode != mode:
            return f"the data are for mode {mode:02X}, but the present mode is {self.setting.mode:02X}: send {mode:02X}"
        if self.free < LEAST_FREE:
            return "the streaming buffer is full, and the data are lost: wait until a part of it is performed"
        stored = tuple(entries)
        self._entries.extend(stored)
        self._used += WORD * sum(map(len, stored))
        self._alarm_on |= self._used > self.setting.alarm
        return None

    def take(self) -> Entry:
        """Remove and return the first entry of the streaming buffer."""
        entry = self._entries.popleft()
        self._used -= WORD * len(entry)
        self.alarm(self._used)
        return entry

    def without_alarm(self, most: int) -> list[Entry]:
        """Return the first entries of the streaming buffer as a list.  The removal of these entries does not cause
        the alarm "buffer empty".

        The list contains at most `most` entries.  The entries stay in the buffer until the caller removes them.  The
        board sends the alarm when the buffer is almost empty.  Each entry is one word.
        """
        assert self.setting is not None
        if self._alarm_on:
            most = min(most, (self._used - self.setting.alarm - 1) // WORD)
        return list(islice(self._entries, max(0, most)))

    def drop(self, count: int) -> None:
        """Remove the first `count` entries of the streaming buffer.

        Each of these entries is one word.
        """
        self._used -= WORD * count
        for _ in range(count):
            self._entries.popleft()

    def alarm(self, left: int) -> None:
        """Warn the host if the streaming buffer is almost empty.

        `left`: number of bytes in the buffer.  The alarm "buffer empty" is sent when `left` falls to the threshold of
        the alarm.
        """
        assert self.setting is not None
        if self._alarm_on and left <= self.setting.alarm:
            self._alarm_on = False
            self._send(self.setting.mode, self.setting.parameters)

    def start(self, procedure: Procedure) -> None:
        """Begin to output the contents of the streaming buffer."""
        self.process = self._clock.process(procedure)
        self._refresh()

    def finish(self) -> None:
        """Record that the output of the streaming buffer has ended.

        The process that outputs the contents of the buffer calls this method.
        """
        self.process = None
        self._refresh()

    def end(self) -> None:
        """End the stream; the motor keeps its velocity."""
        process, self.process = self.process, None
        if process is not None:
            if process is not self._clock.active_process:
                kill(process)
            self._refresh()

    def abandon(self) -> None:
        """Abort the output of the data in the streaming buffer.

        Also stop a command that a marker has started.  A marker is a special value in the buffer that starts a command.
        Called at power-off and before the test function.
        """
        for process in (self.process, self.marker_process):
            if process is not None and process is not self._clock.active_process:
                kill(process)
        self.process = None
