"""The screen of a user's oscilloscope: its signals, time span, cursors and trigger.

A live screen shows the newest data, or the edge found by the trigger.  A paused screen shows a copy of the record,
while the bench continues to run.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import isnan
from weakref import WeakSet

from axistwin.core.errors import UsageError
from axistwin.core.units import US, S
from axistwin.records.traces.signals import COUNT, LEVEL, REAL, TEXT, Signal, choose
from axistwin.ui.panel.scope.cursors import nearest_edge, next_edge, value_at
from axistwin.ui.panel.scope.meaning import PLAIN
from axistwin.ui.panel.scope.recorder import Record, Recorder
from axistwin.ui.panel.scope.tracks import Track, Words
from axistwin.ui.panel.scope.triggers import AUTO, OFF, SINGLE, Trigger

SHORTEST_NS, LONGEST_NS = US, 10_000_000 * S
MOST_SHOWN = 16
FIRST_SHOWN = 6
PIXELS = (50, 4096)  # Least and greatest width of a screen in pixels.
SNAP = 8  # Distance, in pixels, within which a cursor snaps to an edge.
SPANS_NS = tuple(digit * 10**power for power in range(3, 17) for digit in (1, 2, 5) if digit * 10**power <= LONGEST_NS)
"""Time bases: 1 µs, 2 µs, 5 µs, 10 µs, … for the whole width of the screen."""


@dataclass
class Cursors:
    """Times of both cursors, None for one that is not set; keys move the `active` cursor."""

    a_ns: int | None = None
    b_ns: int | None = None
    active: str = "a"
    snap: bool = True

    def set(self, which: str, time_ns: int | None) -> None:
        """Set the cursor `which` ("a" or "b") to a time, and make this cursor active."""
        self.active = which
        if which == "a":
            self.a_ns = time_ns
        else:
            self.b_ns = time_ns

    @property
    def named(self) -> dict[str, int]:
        """Times of the cursors by name, e.g. `{"A": 5000}` if only cursor A is set."""
        return {name: at for name, at in (("A", self.a_ns), ("B", self.b_ns)) if at is not None}

    @property
    def active_ns(self) -> int | None:
        return self.a_ns if self.active == "a" else self.b_ns


@dataclass(eq=False)
class Screen:
    """The oscilloscope screen of one user, which shows recorded signals."""

    recorder: Recorder
    names: tuple[str, ...] = ()
    span_ns: int = 2 * S
    lanes: bool = True  # True if each signal has its own lane; False if the signals are overlaid.
    folded: dict[str, bool] = field(default_factory=dict)
    """Signals whose lane the user has folded (True: low, without values) or unfolded; others fold while they are flat.
    """
    titles: dict[str, str] = field(default_factory=dict)  # Titles that the user has given to signals.
    pixels: int = 800
    trigger: Trigger = field(default_factory=Trigger)
    cursors: Cursors = field(default_factory=Cursors)
    frozen: Record | None = None
    pointer: float | None = None  # Horizontal place of the mouse, from 0 (left) to 1 (right); None outside the screen.
    hit_ns: int | None = None  # Time of the edge found by the trigger; None without an edge.
    _to_ns: int = 0
    _searched_ns: int = 0
    _known: Record | None = None
    _moved: WeakSet[Track] = field(default_factory=WeakSet)

    def __post_init__(self) -> None:
        self.recorder.watchers.append(self._find_first)

    # Signals

    def title(self, name: str) -> str:
        """Return the title of a signal's lane, e.g. `Input 1`."""
        return self.titles.get(name) or self.recorder.meanings.get(name, PLAIN).title or name

    def called(self, name: str) -> str:
        """Return title and note of a signal's lane, e.g. `Input 1 Drill down`."""
        return f"{self.title(name)} {self.recorder.meanings.get(name, PLAIN).note}".strip()

    def choose(self, patterns: Sequence[str]) -> None:
        """Show all signals that match patterns.  Raises UsageError for too many, or for a pattern without a match."""
        self.show([signal.full for signal in choose(list(self.recorder.signals.values()), patterns)])

    def show(self, names: Sequence[str]) -> None:
        """Show signals by name.  Raises UsageError for too many signals, or for an unknown one."""
        signals = self.recorder.signals
        choose(list(signals.values()), [name for name in names if name not in signals])
        if len(names) > MOST_SHOWN:
            raise UsageError(f"{len(names)} signals are too many for one screen: choose {MOST_SHOWN} or fewer")
        self.recorder.want(self, names)
        self.names = tuple(names)
        if self.frozen is not None:
            added = self.recorder.frozen([name for name in names if name not in self.frozen.tracks])
            self.frozen.tracks |= added.tracks
            self.frozen.begins |= {name: added.begins[name] for name in added.tracks}

    @property
    def folded_now(self) -> frozenset[str]:
        """The signals whose lane is folded: by the user, or flat beside others that have changed."""
        if not self.lanes:
            return frozenset()
        flat = {name for name in self.names if (track := self.record.tracks.get(name)) is None or self._is_flat(track)}
        if len(flat) == len(self.names):
            flat = set()
        return frozenset(name for name in self.names if self.folded.get(name, name in flat))

    def _is_flat(self, track: Track) -> bool:
        if track not in self._moved:
            if track.flat:
                return True
            self._moved.add(track)  # A lane that has unfolded stays so.
        return False

    def move_lane(self, place: int, to: int) -> None:
        names = list(self.names)
        if 0 <= place < len(names):
            name = names.pop(place)
            names.insert(min(max(to, 0), len(names)), name)
            self.names = tuple(names)

    # Time

    @property
    def record(self) -> Record:
        return self.frozen or self.recorder.record

    @property
    def tracks(self) -> dict[str, Track]:
        return {name: self.record.tracks[name] for name in self.names if name in self.record.tracks}

    @property
    def edges(self) -> tuple[int, int]:
        if self.frozen is not None:
            return self._to_ns - self.span_ns, self._to_ns
        self._find_last()
        if self.hit_ns is not None and not self._auto_has_timed_out:
            from_ns = self.hit_ns - self._before_ns
            return from_ns, from_ns + self.span_ns
        to_ns = max(self.record.now_ns, self.span_ns)
        return to_ns - self.span_ns, to_ns

    def time_at(self, place: float) -> int:
        """Return the time at a horizontal `place` on the screen, from 0 (left) to 1 (right)."""
        from_ns, to_ns = self.edges
        return from_ns + round((to_ns - from_ns) * place)

    def pause(self) -> None:
        """Freeze the oscilloscope screen.  The screen then shows a copy of the recorded signals."""
        if self.frozen is None:
            self._to_ns = self.edges[1]
            self.frozen = self.recorder.frozen(self.names)

    def live(self) -> None:
        self.frozen = None
        self.arm()

    def zoom(self, factor: float, place: float = 0.5) -> None:
        """Multiply the screen's time span by `factor`; the time at `place` stays there."""
        fixed_ns = self.time_at(place)
        self.span_ns = min(max(round(self.span_ns * factor), SHORTEST_NS), LONGEST_NS)
        self._to_ns = fixed_ns + round(self.span_ns * (1 - place))

    def pan(self, part: float) -> None:
        """Pause the screen, and shift the visible time by a fraction of its length."""
        self.pause()
        self._to_ns = min(max(self._to_ns + round(self.span_ns * part), 0), self.record.now_ns + self.span_ns)

    def jump(self, forward: bool) -> bool:
        """Pause the oscilloscope, and show the next or the previous change of a signal; False if there is none."""
        from_ns, to_ns = self.edges
        last_ns = self.record.now_ns if forward else 1  # At 0 signals begin, they do not change.
        edge = next_edge(self.tracks.values(), to_ns if forward else from_ns, last_ns)
        if edge is not None:
            self.pause()
            self._to_ns = max(edge + round(self.span_ns * (0.9 if forward else 0.1)), self.span_ns)
        return edge is not None

    @property
    def begin_ns(self) -> int:
        """Earliest time in ns for which all signals on the oscilloscope screen have recorded values."""
        return max((self.record.begins.get(name, 0) for name in self.tracks), default=0)

    def fit(self) -> None:
        self.span_ns = min(max(self.record.now_ns, SHORTEST_NS), LONGEST_NS)
        self._to_ns = self.span_ns

    # Trigger

    def arm(self) -> None:
        self.hit_ns, self._searched_ns = None, self.recorder.record.now_ns

    @property
    def waiting(self) -> bool:
        return self.trigger.mode != OFF and self.frozen is None and (self.hit_ns is None or self._auto_has_timed_out)

    @property
    def _before_ns(self) -> int:
        return round(self.span_ns * self.trigger.place)

    @property
    def _auto_has_timed_out(self) -> bool:
        """True if mode `AUTO` has found no edge for three times the visible time span."""
        late_ns = self.recorder.record.now_ns - (self.hit_ns or 0)
        return self.trigger.mode == AUTO and late_ns > 3 * self.span_ns

    def _find_last(self) -> None:
        track, upto_ns = self._triggering()
        if track is not None and upto_ns > self._searched_ns and self.trigger.mode != SINGLE:
            self.hit_ns = next(reversed(self.trigger.edges(track, self._searched_ns, upto_ns)), self.hit_ns)
            self._searched_ns = upto_ns + 1

    def _find_first(self) -> None:
        """Search new data for the first edge in mode `SINGLE`, before these data are merged into intervals."""
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
        record = self.recorder.record
        if record is not self._known:  # A new recording makes the trigger time of the old recording invalid.
            self._known, self.hit_ns, self._searched_ns = record, None, 0
        if self.trigger.mode == OFF:
            self.hit_ns = None
            return None, 0
        return record.tracks.get(self.trigger.signal), record.now_ns - 1 - (self.span_ns - self._before_ns)

    # Cursors

    def put_cursor(self, which: str, place: float, lane: str | None = None) -> None:
        """Set a cursor at a horizontal position of the screen, or at a signal edge near this position.

        `place`: horizontal position, from 0 (left) to 1 (right).  `lane`: the only signal whose edges count; None: all
        shown signals.
        """
        time_ns = self.time_at(place)
        near = self.span_ns * SNAP // self.pixels
        tracks = [track for name, track in self.tracks.items() if lane in (None, name)]
        edge = nearest_edge(tracks, time_ns, near) if self.cursors.snap else None
        self.cursors.set(which, time_ns if edge is None else edge)

    def move_cursor(self, pixels: int) -> None:
        """Move the active cursor by pixels; one that is not set is put in the middle of the screen."""
        at_ns = self.cursors.active_ns
        moved_ns = self.time_at(0.5) if at_ns is None else at_ns + pixels * max(self.span_ns // self.pixels, 1)
        self.cursors.set(self.cursors.active, moved_ns)

    def changed_at(self, time_ns: int) -> str:
        """Return what changes at exactly this time, e.g. `Input 1 pressed`; "" if nothing does.  Numbers come last."""
        for name in sorted(self.tracks, key=lambda name: self.tracks[name].kind in (COUNT, REAL)):
            track, meaning = self.tracks[name], self.recorder.meanings.get(name, PLAIN)
            if isnan(value := value_at(track, time_ns)) or time_ns not in track.rows(time_ns, time_ns + 1).begin:
                continue
            if isinstance(track, Words):
                return f"{self.title(name)}: {track.at(time_ns)}"
            if track.kind in (COUNT, REAL):
                return f"{self.title(name)} {meaning.number(value)} {meaning.shown_unit}".rstrip()
            return f"{self.title(name)} {meaning.word(value)}"
        return ""

    def jump_cursor(self, forward: bool) -> None:
        at_ns = self.cursors.active_ns
        at_ns = self.time_at(0.5) if at_ns is None else at_ns
        edge = next_edge(self.tracks.values(), at_ns, self.record.now_ns if forward else 0)
        if edge is not None:
            self.cursors.set(self.cursors.active, edge)


def first_choice(signals: Sequence[Signal]) -> list[str]:
    """Return the signals of a newly opened screen: positions, messages and some levels; of one axis also velocity."""
    of_axes = [signal for signal in signals if "." in signal.scope and signal.kind in (REAL, COUNT)]
    axes = list(dict.fromkeys(signal.scope for signal in of_axes))
    motion = []
    for scope in axes[:4]:
        own = [signal for signal in of_axes if signal.scope == scope]
        motion += [signal.full for signal in own if signal.kind == REAL][:1] if len(axes) == 1 else []
        motion += [signal.full for signal in own if signal.name in ("position", "pulses")][-1:]
    said = [signal.full for signal in signals if signal.kind == TEXT and not signal.register]
    levels = [signal.full for signal in signals if signal.kind == LEVEL and "." not in signal.scope]
    return [*motion, *said[:2], *levels][: FIRST_SHOWN - 1]


def searched(signals: Sequence[Signal], text: str, called: Callable[[str], str] = lambda name: "") -> list[Signal]:
    """Return the signals that match a search field: patterns or parts of names, separated by commas.

    `called`: returns a signal's name on the page, parts of which are found, too.
    """
    words = [word.strip() for word in text.split(",") if word.strip()]
    patterns = [word if any(sign in word for sign in "*?") else f"*{word}*" for word in words] or ["*"]
    parts = [word.lower() for word in words]
    return [
        s
        for s in signals
        if s.full in words
        or any(s.matches(pattern) for pattern in patterns)
        or any(part in called(s.full).lower() for part in parts)
    ]
