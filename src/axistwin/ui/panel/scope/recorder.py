"""Record the signals on all users' screens, each signal once.  A new record begins when the bench is replaced."""

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field

import numpy as np

from axistwin.bench import Bench
from axistwin.core.errors import UsageError
from axistwin.records.traces.batch import Part, Value
from axistwin.records.traces.provenance import provenance
from axistwin.records.traces.signals import REAL, TEXT, Signal, catalogue
from axistwin.records.traces.trace import Tracer
from axistwin.sim.pins import Pin
from axistwin.ui.panel.scope.meaning import Meaning, meanings, presets
from axistwin.ui.panel.scope.tracks import Times, Track, Words

MOST_SIGNALS = 32  # Largest number of recorded signals; each takes up to `tracks.MOST_BYTES`.
STOPS, MOST_STOPS = ("estop",), 100  # Inputs of an emergency stop, which are low while it is pressed.
GROWING = ("host_says", "controller_says")


@dataclass
class Record:
    """The recorded values of signals up to the time `now_ns`."""

    now_ns: int = 0
    tracks: dict[str, Track] = field(default_factory=dict)
    about: dict[str, str] = field(default_factory=dict)  # Description of the recorded bench: scene, models and options.
    begins: dict[str, int] = field(default_factory=dict)  # Time at which the recording of each signal began.


class Recorder:
    """Records all signals that the oscilloscope screens of a session show.  Call `attach` for each bench."""

    def __init__(self, named: Mapping[str, str] | None = None) -> None:
        """Create a recorder without a bench.  `named`: names on the operator panel, by "controller.pin"."""
        self._named = dict(named or {})
        self.record = Record()
        self.signals: dict[str, Signal] = {}
        self.meanings: dict[str, Meaning] = {}  # Meaning of each signal that has a unit or messages in words.
        self.presets: Mapping[str, list[str]] = {}
        self.version = 0  # Number that increases whenever data are added to the record.
        self.watchers: list[Callable[[], None]] = []
        self._bench: Bench | None = None
        self._tracer: Tracer | None = None
        self._stack = ExitStack()
        self._wanted: dict[object, tuple[str, ...]] = {}
        self._recorded: list[Signal] = []
        self._pressed: deque[tuple[int, str]] = deque(maxlen=MOST_STOPS)

    def attach(self, bench: Bench) -> None:
        self._stack.close()
        self._bench, self._tracer, self._recorded = bench, None, []
        self.signals = {signal.full: signal for signal in catalogue(bench)}
        self.meanings = meanings(bench, self.signals.values(), self._named)
        self.presets = presets(bench, list(self.signals.values()))
        self.record = Record(bench.now, {}, provenance(bench))
        self._pressed.clear()
        for controller in bench.controllers.values():
            for name in STOPS:
                if name in controller.pins:
                    controller.pins[name].subscribe(self._stopped)
        self._follow_wishes()

    @property
    def alarms(self) -> list[tuple[int, str]]:
        """The latest abnormal events: presses of an emergency stop, and injected faults."""
        faults = self._bench.faults if self._bench is not None else ()
        began = [(fault.began_ns, f"fault {fault.name}") for fault in faults if fault.began_ns is not None]
        return sorted([*self._pressed, *began])

    def _stopped(self, pin: Pin) -> None:
        if not pin.level:
            self._pressed.append((pin.clock.now, "emergency stop"))

    def want(self, who: object, names: Sequence[str]) -> None:
        """Record the signals of the screen `who`.  Raises UsageError if there are too many signals."""
        others = {name for key, wanted in self._wanted.items() if key != who for name in wanted}
        if len(others | set(names)) > MOST_SIGNALS:
            raise UsageError(
                f"too many oscilloscope signals: "
                f"expected at most {MOST_SIGNALS} different signals for all users together"
            )
        self._wanted[who] = tuple(names)
        self._follow_wishes()

    def leave(self, who: object) -> None:
        """Stop recording for a closed screen; without any other open screen, the recording continues."""
        if len(self._wanted) > 1:
            self._wanted.pop(who, None)
            self._follow_wishes()

    def catch_up(self) -> Record:
        if self._tracer is not None and self._bench is not None:
            self._tracer.show_present()
            self.record.now_ns = self._bench.now
        return self.record

    def frozen(self, names: Sequence[str]) -> Record:
        """Return a copy of the record that contains only the signals `names`.  Later changes do not affect the copy."""
        tracks = {name: self.record.tracks[name].frozen() for name in names if name in self.record.tracks}
        return Record(self.record.now_ns, tracks, self.record.about, dict(self.record.begins))

    def _follow_wishes(self) -> None:
        wanted = {name for names in self._wanted.values() for name in names}
        signals = [signal for name, signal in self.signals.items() if name in wanted]
        if self._bench is None or signals == self._recorded:
            return
        self.catch_up()
        self._stack.close()
        for signal in self._recorded:
            if signal not in signals:
                self.record.tracks[signal.full].interrupt(self._bench.now)
        self._recorded = signals
        self._forget({signal.full for signal in signals})
        if signals:
            self._begin(self._bench)

    def _forget(self, needed: set[str]) -> None:
        """Delete recordings that no screen shows, the oldest first, down to `MOST_SIGNALS`."""
        tracks = self.record.tracks
        spare = [name for name in tracks if name not in needed]
        for name in spare[: max(len(spare) + len(needed) - MOST_SIGNALS, 0)]:
            del tracks[name], self.record.begins[name]

    def _begin(self, bench: Bench) -> None:
        tracer = self._tracer = Tracer(bench, self._recorded)
        for signal, value in zip(self._recorded, tracer.first(), strict=True):
            track = self.record.tracks.setdefault(signal.full, _track(signal))
            self.record.begins.setdefault(signal.full, bench.now)
            _add(track, np.array([bench.now], np.int64), [value])
        tracer.consumer = self._take
        self.record.now_ns = bench.now
        self.version += 1
        self._stack.enter_context(tracer)

    def _take(self, parts: list[Part], texts: list[bytes]) -> None:
        added = [self._add(part, texts) for part in parts if len(part.times)]
        if any(added):
            self.version += 1
            for watcher in tuple(self.watchers):
                watcher()

    def _add(self, part: Part, texts: list[bytes]) -> bool:
        signal = self._recorded[part.signal]
        track = self.record.tracks[signal.full]
        self.record.now_ns = max(self.record.now_ns, int(part.times[-1]))
        if isinstance(track, Words):
            return track.say(part.times, [texts[n] for n in part.values])
        return track.add(part.times, part.values.view(float) if signal.kind == REAL else part.values.astype(float))


def _track(signal: Signal) -> Track:
    return Words(signal.kind, signal.name in GROWING) if signal.kind == TEXT else Track(signal.kind)


def _add(track: Track, times: Times, values: Sequence[Value]) -> None:
    if isinstance(track, Words):
        track.say(times, [value for value in values if isinstance(value, bytes)])
    else:
        track.add(times, np.array(values, float))
