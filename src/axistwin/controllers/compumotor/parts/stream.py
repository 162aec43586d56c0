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
LEAST_FREE = 15  # Number of bytes that must be free for the data of E0h, E1h or E3h.
FASTEST = CCW - 1  # Highest velocity number, without the direction bit.

Entry = tuple[int, ...]  # An entry of the buffer: a velocity, a distance, or a velocity and a distance.


@dataclass(frozen=True, eq=False)
class Setting:
    """A streaming mode.  `alarm`: a number of bytes; `period_ms`: 0 in a mode without update rate."""

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
        """Upper limit of the streamed velocity in pulses/s, just above that of the highest number."""
        return self.clock / 2

    @cached_property
    def resolution(self) -> Fraction:
        """Rate of velocity number 1, in pulses/s."""
        return self.clock / FULL

    @cached_property
    def period(self) -> Fraction:
        """Update period in seconds, in which one velocity or distance is output; 0 in velocity-distance mode."""
        return Fraction(self.period_ms, 1000)

    def rate(self, number: int) -> Fraction:
        """Convert a velocity `number`, in units of `resolution`, to pulses/s."""
        return Fraction(self.resolution.numerator * number, self.resolution.denominator)

    @property
    def parameters(self) -> bytes:
        rate = self.period_ms.to_bytes(2, "big") if self.period_ms else b""
        return bytes([self.base, self.divisor]) + self.alarm.to_bytes(4, "big") + rate


@dataclass(frozen=True)
class Marker:
    """The command that is executed when a marker's value occurs in the stream."""

    command: Opcode
    values: tuple[Any, ...]


class Stream:
    """The streaming buffer, and the process that outputs its contents."""

    def __init__(
        self, clock: Clock, memory: int, send: Callable[[int, bytes], None], refresh: Callable[[], None]
    ) -> None:
        self._clock, self._memory, self._send, self._refresh = clock, memory, send, refresh
        self.setting: Setting | None = None  # Present streaming mode with its parameters; None in indexer mode.
        self.markers: dict[int, Marker] = {}
        self._entries: deque[Entry] = deque()
        self._used = 0
        self._alarm_on = False
        self.process: Process | None = None
        self.marker_process: Process | None = None

    @property
    def performing(self) -> bool:
        return self.process is not None

    @property
    def free(self) -> int:
        return self._memory - self._used

    @property
    def empty(self) -> bool:
        return not self._entries

    def enter(self, setting: Setting | None) -> None:
        """Enter a streaming mode, or None for indexer mode, with an empty buffer."""
        self.setting = setting
        self.clear()

    def clear(self) -> None:
        self._entries.clear()
        self._used, self._alarm_on = 0, False

    def store(self, mode: int, entries: Iterable[Entry]) -> str | None:
        """Store data; return the reason if they are lost, in another mode than `mode` or with a full memory."""
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
        entry = self._entries.popleft()
        self._used -= WORD * len(entry)
        self.alarm(self._used)
        return entry

    def without_alarm(self, most: int) -> list[Entry]:
        """Return at most `most` words of the buffer whose removal, by the caller, causes no alarm "buffer empty"."""
        assert self.setting is not None
        if self._alarm_on:
            most = min(most, (self._used - self.setting.alarm - 1) // WORD)
        return list(islice(self._entries, max(0, most)))

    def drop(self, count: int) -> None:
        """Remove the first `count` entries of the streaming buffer.  Each of these entries is one word."""
        self._used -= WORD * count
        for _ in range(count):
            self._entries.popleft()

    def alarm(self, left: int) -> None:
        """Send the buffer empty alarm once, if the alarm is on and `left` bytes are within its threshold."""
        assert self.setting is not None
        if self._alarm_on and left <= self.setting.alarm:
            self._alarm_on = False
            self._send(self.setting.mode, self.setting.parameters)

    def start(self, procedure: Procedure) -> None:
        self.process = self._clock.process(procedure)
        self._refresh()

    def finish(self) -> None:
        """Record the end of the stream; called by the process that performs the buffer."""
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
        """End the stream and the command of a marker, at power-off or for the test function."""
        for process in (self.process, self.marker_process):
            if process is not None and process is not self._clock.active_process:
                kill(process)
        self.process = None
