"""A user's view of a record: signals, time, cursors, trigger.  It exists until the session ends.

A live screen shows the newest data or the triggered edge.  A paused screen shows a copy of the record.  The bench runs
in both cases.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

from axistwin.errors import UsageError
from axistwin.panel.scope.cursors import nearest_edge, next_edge
from axistwin.panel.scope.recorder import Record, Recorder
from axistwin.panel.scope.tracks import Track
from axistwin.panel.scope.triggers import AUTO, OFF, SINGLE, Trigger
from axistwin.traces.signals import COUNT, LEVEL, REAL, TEXT, Signal, choose
from axistwin.units import US, S

SHORTEST_NS, LONGEST_NS = US, 10_000_000 * S
MOST_SHOWN = 16
FIRST_SHOWN = 8
PIXELS = (50, 4096)
"""Least and greatest width of a screen."""
SNAP = 8
"""Distance in pixels within which a cursor jumps to an edge."""
SPANS_NS = tuple(digit * 10**power for power in range(3, 17) for digit in (1, 2, 5) if digit * 10**power <= LONGEST_NS)
"""The time base's positions: 1 µs, 2 µs, 5 µs, … for the whole width."""


@dataclass
class Cursors:
    """Times of two cursors; keys move the `active` cursor."""

    a_ns: int | None = None
    b_ns: int | None = None
    active: str = "a"
    snap: bool = True

    def set(self, which: str, time_ns: int | None) -> None:
        """Set one cursor."""
        self.active = which
        if which == "a":
            self.a_ns = time_ns
        else:
            self.b_ns = time_ns

    @property
    def active_ns(self) -> int | None:
        """Return the time of the active cursor."""
        return self.a_ns if self.active == "a" else self.b_ns


@dataclass(eq=False)
class Screen:
    """One user's view of the data of a recorder."""

    recorder: Recorder
    names: tuple[str, ...] = ()
    span_ns: int = 2 * S
    lanes: bool = True
    """True: signals in separate lanes; False: overlaid."""
    pixels: int = 800
    trigger: Trigger = field(default_factory=Trigger)
    cursors: Cursors = field(default_factory=Cursors)
    frozen: Record | None = None
    hit_ns: int | None = None
    """Time of the triggered edge."""
    _to_ns: int = 0
    _searched_ns: int = 0
    _known: Record | None = None

    def __post_init__(self) -> None:
        self.recorder.watchers.append(self._look_for_first)

    # Which signals

    def choose(self, patterns: Sequence[str]) -> None:
        """Show the signals that match these patterns.  Raises UsageError for no match, and for too many signals."""
        self.show([signal.full for signal in choose(list(self.recorder.signals.values()), patterns)])

    def show(self, names: Sequence[str]) -> None:
        """Show these signals.  Raises UsageError for too many, and for an unknown signal."""
        signals = self.recorder.signals
        choose(list(signals.values()), [name for name in names if name not in signals])
        if len(names) > MOST_SHOWN:
            raise UsageError(f"{len(names)} signals are too many for one screen: choose {MOST_SHOWN} or fewer")
        self.recorder.want(self, names)
        self.names = tuple(names)
        if self.frozen is not None:
            new = [name for name in names if name not in self.frozen.tracks]
            self.frozen.tracks |= self.recorder.frozen(new).tracks

    # Which time

    @property
    def record(self) -> Record:
        """The record that is shown."""
        return self.frozen or self.recorder.record

    @property
    def tracks(self) -> dict[str, Track]:
        """Tracks of the signals that are shown."""
        return {name: self.record.tracks[name] for name in self.names if name in self.record.tracks}

    @property
    def edges(self) -> tuple[int, int]:
        """Return start and end of the window."""
        if self.frozen is not None:
            return self._to_ns - self.span_ns, self._to_ns
        self._look_for_last()
        if self.hit_ns is not None and not self._auto_is_over:
            from_ns = self.hit_ns - self._before_ns
            return from_ns, from_ns + self.span_ns
        to_ns = max(self.record.now_ns, self.span_ns)
        return to_ns - self.span_ns, to_ns

    def time_at(self, place: float) -> int:
        """Return the time at a fraction of the width, from 0 at the left to 1."""
        from_ns, to_ns = self.edges
        return from_ns + round((to_ns - from_ns) * place)

    def pause(self) -> None:
        """Pause the view."""
        if self.frozen is None:
            self._to_ns = self.edges[1]
            self.frozen = self.recorder.frozen(self.names)

    def live(self) -> None:
        """Continue the view; a trigger waits for the next edge."""
        self.frozen = None
        self.arm()

    def zoom(self, factor: float, place: float = 0.5) -> None:
        """Multiply the visible time by a factor, around a fraction of the width."""
        fixed_ns = self.time_at(place)
        self.span_ns = min(max(round(self.span_ns * factor), SHORTEST_NS), LONGEST_NS)
        self._to_ns = fixed_ns + round(self.span_ns * (1 - place))

    def pan(self, part: float) -> None:
        """Move the window by a fraction of the width; a move back pauses the view."""
        self.pause()
        moved_ns = self._to_ns + round(self.span_ns * part)
        self._to_ns = min(max(moved_ns, 0), self.record.now_ns + self.span_ns)

    def fit(self) -> None:
        """Show the complete record."""
        self.span_ns = min(max(self.record.now_ns, SHORTEST_NS), LONGEST_NS)
        self._to_ns = self.span_ns

    # Trigger

    def arm(self) -> None:
        """Arm the trigger for the next edge."""
        self.hit_ns, self._searched_ns = None, self.recorder.record.now_ns

    @property
    def waiting(self) -> bool:
        """True if the trigger waits for an edge."""
        return self.trigger.mode != OFF and self.frozen is None and (self.hit_ns is None or self._auto_is_over)

    @property
    def _before_ns(self) -> int:
        return round(self.span_ns * self.trigger.place)

    @property
    def _auto_is_over(self) -> bool:
        """True if three widths have passed without an edge."""
        late_ns = self.recorder.record.now_ns - (self.hit_ns or 0)
        return self.trigger.mode == AUTO and late_ns > 3 * self.span_ns

    def _look_for_last(self) -> None:
        """Return the newest edge that is followed by enough data."""
        track, upto_ns = self._triggering()
        if track is not None and upto_ns > self._searched_ns and self.trigger.mode != SINGLE:
            self.hit_ns = next(reversed(self.trigger.edges(track, self._searched_ns, upto_ns)), self.hit_ns)
            self._searched_ns = upto_ns + 1

    def _look_for_first(self) -> None:
        """Search for an edge in new data, before they become intervals."""
        if self.trigger.mode != SINGLE or self.frozen is not None:
            return
        track, upto_ns = self._triggering()
        if track is None or upto_ns <= self._searched_ns:
            return
        self.hit_ns = next(iter(self.trigger.edges(track, self._searched_ns, upto_ns)), None)
        self._searched_ns = upto_ns + 1
        if self.hit_ns is not None:
            self._to_ns = self.hit_ns - self._before_ns + self.span_ns
            self.frozen = self.recorder.frozen(self.names)

    def _triggering(self) -> tuple[Track | None, int]:
        """Return the trigger's signal, and the time up to which edges are followed by enough data."""
        record = self.recorder.record
        if record is not self._known:  # another bench
            self._known, self.hit_ns, self._searched_ns = record, None, 0
        if self.trigger.mode == OFF:
            self.hit_ns = None
            return None, 0
        return record.tracks.get(self.trigger.signal), record.now_ns - 1 - (self.span_ns - self._before_ns)

    # Cursors

    def put_cursor(self, which: str, place: float) -> None:
        """Set a cursor at a fraction of the width, or at a near edge."""
        time_ns = self.time_at(place)
        near = self.span_ns * SNAP // self.pixels
        edge = nearest_edge(self.tracks.values(), time_ns, near) if self.cursors.snap else None
        self.cursors.set(which, time_ns if edge is None else edge)

    def move_cursor(self, pixels: int) -> None:
        """Move the active cursor by some pixels; a cursor that is not set appears in the middle."""
        at_ns = self.cursors.active_ns
        moved_ns = self.time_at(0.5) if at_ns is None else at_ns + pixels * max(self.span_ns // self.pixels, 1)
        self.cursors.set(self.cursors.active, moved_ns)

    def jump_cursor(self, forward: bool) -> None:
        """Move the active cursor to the next or the previous edge."""
        at_ns = self.cursors.active_ns
        at_ns = self.time_at(0.5) if at_ns is None else at_ns
        edge = next_edge(self.tracks.values(), at_ns, self.record.now_ns if forward else 0)
        if edge is not None:
            self.cursors.set(self.cursors.active, edge)


def first_choice(signals: Sequence[Signal]) -> list[str]:
    """Return the signals of a new user: motion of axes, messages, and some levels."""
    motion: dict[str, str] = {}
    for signal in signals:
        if "." in signal.scope and (signal.kind == REAL or (signal.kind == COUNT and signal.scope not in motion)):
            motion[signal.scope] = signal.full
    said = [signal.full for signal in signals if signal.kind == TEXT and not signal.register]
    levels = [signal.full for signal in signals if signal.kind == LEVEL and "." not in signal.scope]
    return [*list(motion.values())[:4], *said[:2], *levels][:FIRST_SHOWN]


def searched(signals: Sequence[Signal], text: str) -> list[Signal]:
    """Return the signals that match a search: patterns with `*` or `?`, or a part of the name."""
    words = [word.strip() for word in text.split(",") if word.strip()]
    patterns = [word if any(sign in word for sign in "*?") else f"*{word}*" for word in words] or ["*"]
    return [s for s in signals if s.full in words or any(s.matches(pattern) for pattern in patterns)]
