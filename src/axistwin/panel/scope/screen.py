"""What somebody sees of a record: which signals, which time, cursors, trigger.  It is kept while the session lasts.

The screen is live, and shows what is newest or what the trigger is fixed to, or it is paused, and shows a record that
does not go on.  The bench goes on in either case.
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
"""How wide a screen may be."""
SNAP = 8
"""So many pixels around an edge a cursor jumps to it."""
SPANS_NS = tuple(digit * 10**power for power in range(3, 17) for digit in (1, 2, 5) if digit * 10**power <= LONGEST_NS)
"""The time base's positions: 1 µs, 2 µs, 5 µs, … for the whole width."""


@dataclass
class Cursors:
    """Two moments in time; `active` is moved by keys."""

    a_ns: int | None = None
    b_ns: int | None = None
    active: str = "a"
    snap: bool = True

    def set(self, which: str, time_ns: int | None) -> None:
        """One of them."""
        self.active = which
        if which == "a":
            self.a_ns = time_ns
        else:
            self.b_ns = time_ns

    @property
    def active_ns(self) -> int | None:
        """Where the active one is."""
        return self.a_ns if self.active == "a" else self.b_ns


@dataclass(eq=False)
class Screen:
    """One person's view of what a recorder records."""

    recorder: Recorder
    names: tuple[str, ...] = ()
    span_ns: int = 2 * S
    lanes: bool = True
    """Signals below one another, or all over one another."""
    pixels: int = 800
    trigger: Trigger = field(default_factory=Trigger)
    cursors: Cursors = field(default_factory=Cursors)
    frozen: Record | None = None
    hit_ns: int | None = None
    """The edge that the window is fixed to."""
    _to_ns: int = 0
    _searched_ns: int = 0
    _known: Record | None = None

    def __post_init__(self) -> None:
        self.recorder.watchers.append(self._look_for_first)

    # Which signals

    def choose(self, patterns: Sequence[str]) -> None:
        """Those that patterns mean.  Raises UsageError for a pattern that means none, and for too many signals."""
        self.show([signal.full for signal in choose(list(self.recorder.signals.values()), patterns)])

    def show(self, names: Sequence[str]) -> None:
        """These.  Raises UsageError for too many, or for one that there is not."""
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
        """What is shown."""
        return self.frozen or self.recorder.record

    @property
    def tracks(self) -> dict[str, Track]:
        """The signals that are shown, as far as something is known of them."""
        return {name: self.record.tracks[name] for name in self.names if name in self.record.tracks}

    @property
    def edges(self) -> tuple[int, int]:
        """From when to when the window goes."""
        if self.frozen is not None:
            return self._to_ns - self.span_ns, self._to_ns
        self._look_for_last()
        if self.hit_ns is not None and not self._auto_is_over:
            from_ns = self.hit_ns - self._before_ns
            return from_ns, from_ns + self.span_ns
        to_ns = max(self.record.now_ns, self.span_ns)
        return to_ns - self.span_ns, to_ns

    def time_at(self, place: float) -> int:
        """At this part of the width, from 0 at the left to 1."""
        from_ns, to_ns = self.edges
        return from_ns + round((to_ns - from_ns) * place)

    def pause(self) -> None:
        """Keep what is seen as it is now."""
        if self.frozen is None:
            self._to_ns = self.edges[1]
            self.frozen = self.recorder.frozen(self.names)

    def live(self) -> None:
        """Follow what happens again; a trigger waits for the next edge."""
        self.frozen = None
        self.arm()

    def zoom(self, factor: float, place: float = 0.5) -> None:
        """So many times the time, around a part of the width."""
        fixed_ns = self.time_at(place)
        self.span_ns = min(max(round(self.span_ns * factor), SHORTEST_NS), LONGEST_NS)
        self._to_ns = fixed_ns + round(self.span_ns * (1 - place))

    def pan(self, part: float) -> None:
        """Later by so much of the width, or earlier; to look at the past the screen pauses."""
        self.pause()
        moved_ns = self._to_ns + round(self.span_ns * part)
        self._to_ns = min(max(moved_ns, 0), self.record.now_ns + self.span_ns)

    def fit(self) -> None:
        """All that is known."""
        self.span_ns = min(max(self.record.now_ns, SHORTEST_NS), LONGEST_NS)
        self._to_ns = self.span_ns

    # Trigger

    def arm(self) -> None:
        """Wait for the next edge."""
        self.hit_ns, self._searched_ns = None, self.recorder.record.now_ns

    @property
    def waiting(self) -> bool:
        """Whether the trigger has not found what it is to find."""
        return self.trigger.mode != OFF and self.frozen is None and (self.hit_ns is None or self._auto_is_over)

    @property
    def _before_ns(self) -> int:
        return round(self.span_ns * self.trigger.place)

    @property
    def _auto_is_over(self) -> bool:
        """Whether there has been no edge for three times the width."""
        late_ns = self.recorder.record.now_ns - (self.hit_ns or 0)
        return self.trigger.mode == AUTO and late_ns > 3 * self.span_ns

    def _look_for_last(self) -> None:
        """The newest edge behind which enough is known."""
        track, upto_ns = self._triggering()
        if track is not None and upto_ns > self._searched_ns and self.trigger.mode != SINGLE:
            found = self.trigger.last(track, self._searched_ns, upto_ns)
            self.hit_ns = self.hit_ns if found is None else found
            self._searched_ns = upto_ns + 1

    def _look_for_first(self) -> None:
        """Called whenever something comes, so that it is found before it is old."""
        if self.trigger.mode != SINGLE or self.frozen is not None:
            return
        track, upto_ns = self._triggering()
        if track is None or upto_ns <= self._searched_ns:
            return
        self.hit_ns = self.trigger.first(track, self._searched_ns, upto_ns)
        self._searched_ns = upto_ns + 1
        if self.hit_ns is not None:
            self._to_ns = self.hit_ns - self._before_ns + self.span_ns
            self.frozen = self.recorder.frozen(self.names)

    def _triggering(self) -> tuple[Track | None, int]:
        """The trigger's signal, and up to when edges in it have enough behind them."""
        record = self.recorder.record
        if record is not self._known:  # another bench
            self._known, self.hit_ns, self._searched_ns = record, None, 0
        if self.trigger.mode == OFF:
            self.hit_ns = None
            return None, 0
        return record.tracks.get(self.trigger.signal), record.now_ns - 1 - (self.span_ns - self._before_ns)

    # Cursors

    def put_cursor(self, which: str, place: float) -> None:
        """At a part of the width, or at an edge beside it."""
        time_ns = self.time_at(place)
        near = self.span_ns * SNAP // self.pixels
        edge = nearest_edge(self.tracks.values(), time_ns, near) if self.cursors.snap else None
        self.cursors.set(which, time_ns if edge is None else edge)

    def move_cursor(self, pixels: int) -> None:
        """The active one, by so many pixels; one that is not there comes into the middle."""
        at_ns = self.cursors.active_ns
        moved_ns = self.time_at(0.5) if at_ns is None else at_ns + pixels * max(self.span_ns // self.pixels, 1)
        self.cursors.set(self.cursors.active, moved_ns)

    def jump_cursor(self, forward: bool) -> None:
        """The active one, to the next edge, or the one before."""
        at_ns = self.cursors.active_ns
        at_ns = self.time_at(0.5) if at_ns is None else at_ns
        edge = next_edge(self.tracks.values(), at_ns, self.record.now_ns if forward else 0)
        if edge is not None:
            self.cursors.set(self.cursors.active, edge)


def first_choice(signals: Sequence[Signal]) -> list[str]:
    """What somebody sees who has chosen nothing: how axes move, what is said, and some levels."""
    motion: dict[str, str] = {}
    for signal in signals:
        if "." in signal.scope and (signal.kind == REAL or (signal.kind == COUNT and signal.scope not in motion)):
            motion[signal.scope] = signal.full
    said = [signal.full for signal in signals if signal.kind == TEXT and not signal.register]
    levels = [signal.full for signal in signals if signal.kind == LEVEL and "." not in signal.scope]
    return [*list(motion.values())[:4], *said[:2], *levels][:FIRST_SHOWN]


def searched(signals: Sequence[Signal], text: str) -> list[Signal]:
    """Those that a search means: patterns with `*` or `?`, or a part of the name."""
    words = [word.strip() for word in text.split(",") if word.strip()]
    patterns = [word if any(sign in word for sign in "*?") else f"*{word}*" for word in words] or ["*"]
    return [s for s in signals if s.full in words or any(s.matches(pattern) for pattern in patterns)]
