"""Writes what happens on a bench into a file while it happens: `.csv`, or `.vcd` for GTKWave.

Only changes are written.  Signals are called `controller.pin`, `controller.says` and `controller.hears` for the serial
connection as the *host* has it, and per axis `pulses` (net pulses issued), `direction` (1: positive) and, in a VCD,
`step`: high for 250 ns from each pulse on, which is shorter than half the period of the fastest controller.  A servo
axis has `position` and `commanded`, in counts, with a change at each sample that brings one.

Tracing schedules nothing: the pulses of a motion are worked out, in pieces of limited size, when something else
happens or at the end.  So a bench does exactly the same whether it is traced or not.
"""

import os
from bisect import bisect_left
from collections.abc import Iterator
from contextlib import ExitStack
from itertools import chain
from operator import itemgetter
from pathlib import Path
from types import TracebackType
from typing import Self

from axistwin.apps import partners
from axistwin.apps.events import Changed, Event, Heard, Said, Turned, observing, terminals
from axistwin.apps.trace_files import COUNT, LEVEL, STEP, STEP_NS, TEXT, VOLTS, Sink, Write, sink_for
from axistwin.bench import Bench, Controller
from axistwin.errors import UsageError
from axistwin.motion.train import Stroke, Train
from axistwin.plant.counts import Samples
from axistwin.plant.servo_axis import ServoAxis
from axistwin.sim.pins import UserPin

CHUNK = 1 << 14  # pulses worked out at a time, about

Change = tuple[int, Write, int]
"""When, what, to what."""


class tracing:  # noqa: N801  # used as `with tracing(bench, path):`
    """Trace a bench into `path` meanwhile.

    The file is there, whole, when the block is left in whatever way except by an error: then it is not there.
    """

    def __init__(self, bench: Bench, path: Path) -> None:
        self.bench, self.path = bench, path.resolve()  # a link is written through, not replaced
        self._make = sink_for(path)
        self._beside = self.path.with_name(self.path.name + ".part")

    def __enter__(self) -> Self:
        self._stack = ExitStack()
        if self.path.exists() and not self.path.is_file():
            raise UsageError(f"{self.path} cannot be written: it is no file")
        try:
            self._file = self._stack.enter_context(self._beside.open("w", encoding="utf-8", newline=""))
        except OSError as error:
            raise UsageError(f"{self.path} cannot be written: {error.strerror}") from None
        self._tracer = Tracer(self.bench, self._make(self._file, self.bench.now))
        self._stack.enter_context(self._tracer)
        return self

    def catch_up(self) -> None:
        """Write what has happened by now; who waits for long motions in real time calls it now and then."""
        self._tracer.catch_up()

    def __exit__(self, kind: type[BaseException] | None, _: BaseException | None, __: TracebackType | None) -> None:
        failed = kind is not None and issubclass(kind, Exception)  # a Ctrl-C is no failure
        if not failed:
            self._tracer.finish()
        self._stack.close()
        if failed:
            self._beside.unlink()
        else:
            os.replace(self._beside, self.path)


class Tracer:
    """Turns what happens into changes of signals, in order of time."""

    def __init__(self, bench: Bench, sink: Sink) -> None:
        self.bench, self.sink = bench, sink
        self._upto_ns = bench.now
        self._writing = False
        self._levels: dict[tuple[str, str], Write] = {}
        self._speakers: dict[tuple[str, bool], _Speaker] = {}
        self._volts: dict[tuple[str, str], Write] = {}
        self._axes: list[_AxisTrace | _ServoTrace] = []
        for controller in bench.controllers.values():
            self._add(controller)
        for name in partners.names(bench):
            if name not in bench.controllers:
                self._add_speakers(name)

    def _add(self, controller: Controller) -> None:
        add, name = self.sink.add, controller.name
        for pin_name, pin in terminals(controller).items():
            self._levels[name, pin_name] = add(name, pin_name.replace(".", "_"), LEVEL, int(pin.level))
            if isinstance(pin, UserPin):
                self._volts[name, pin_name] = add(name, f"{pin_name}_volts", VOLTS, pin.volts)
        if name in partners.names(self.bench):
            self._add_speakers(name)
        for axis_name, axis in controller.axes.items():
            scope = f"{name}.{axis_name}"
            if isinstance(axis, ServoAxis):
                self._axes.append(_ServoTrace(self.sink, scope, axis))
            else:
                self._axes.append(_AxisTrace(self.sink, scope, axis.train, self.bench.now))

    def _add_speakers(self, name: str) -> None:
        for by_host, who in ((True, "host_says"), (False, "controller_says")):
            write = self.sink.add(name, who, TEXT, 0)
            self._speakers[name, by_host] = _Speaker(write, partners.at_a_bus(self.bench, name))

    def __enter__(self) -> Self:
        """Watch."""
        self._stack = ExitStack()
        self._stack.enter_context(observing(self.bench, self._take))
        for controller in self.bench.controllers.values():
            for axis in controller.axes.values():
                axis.on_motion.append(self.catch_up)
                self._stack.callback(axis.on_motion.remove, self.catch_up)
        for trace in self._axes:
            if isinstance(trace, _ServoTrace):
                self._stack.callback(trace.axis.watch(trace.take))
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def finish(self) -> None:
        """Write what has happened up to now, inclusive; after a Ctrl-C in the middle of a piece, no more than that."""
        if not self._writing:
            self._write_pulses(self.bench.now + 1)
        self.sink.end(self.bench.now)

    def _take(self, event: Event) -> None:
        self.catch_up()
        if isinstance(event, Changed):
            self._levels[event.controller, event.pin](event.time_ns, int(event.level))
        elif isinstance(event, Turned):
            self._volts[event.controller, event.pin](event.time_ns, event.volts)
        elif isinstance(event, Said | Heard):
            self._speak(event)

    def _speak(self, event: Said | Heard) -> None:
        by_host = isinstance(event, Said)
        speaker = self._speakers[event.controller, by_host]
        speaker.say(event.time_ns, self._visible(event))
        self._speakers[event.controller, not by_host].listen(event.time_ns, speaker.over)

    def _visible(self, event: Said | Heard) -> bytes:
        """Characters as they are; what is said on a bus in hex."""
        if not partners.at_a_bus(self.bench, event.controller):
            return event.data
        return partners.codec_at(self.bench, event.controller).show(event.data).encode()

    def catch_up(self) -> None:
        """Write what has happened before now."""
        self._write_pulses(self.bench.now)

    def _write_pulses(self, before_ns: int) -> None:
        """All changes that pulses have made since the last time, in pieces."""
        for axis in self._axes:
            axis.catch_up()  # what it has done may come here first
        since_ns = self._upto_ns
        pieces = sum(axis.count(since_ns, before_ns) for axis in self._axes) // CHUNK + 1
        for piece in range(1, pieces + 1):
            until_ns = since_ns + (before_ns - since_ns) * piece // pieces
            changes = chain.from_iterable(axis.changes(self._upto_ns, until_ns) for axis in self._axes)
            self._writing = True
            for time_ns, write, value in sorted(changes, key=itemgetter(0)):
                write(time_ns, value)
            self._upto_ns, self._writing = until_ns, False


class _Speaker:
    """The message that one end of a serial connection is saying; `whole`: it is said at once, as on a bus."""

    def __init__(self, write: Write, whole: bool) -> None:
        self._write, self._message, self._shown = write, b"", b""
        self._whole = whole

    @property
    def over(self) -> bool:
        """Whether the terminator has been said."""
        return self._whole or self._message.endswith((b"\r", b"\n"))

    def say(self, time_ns: int, data: bytes) -> None:
        """More characters, or the first of the next message."""
        self._message = data if self.over and data != b"\n" else self._message + data
        self._show(time_ns, self._message)

    def listen(self, time_ns: int, answered: bool) -> None:
        """The other end speaks; if that was a whole message, the next words here are a new one."""
        if answered:
            self._message = b""
        self._show(time_ns, b"")

    def _show(self, time_ns: int, text: bytes) -> None:
        if text != self._shown:
            self._shown = text
            self._write(time_ns, text)


class _AxisTrace:
    """The signals of an axis."""

    def __init__(self, sink: Sink, scope: str, train: Train, now_ns: int) -> None:
        self.train = train
        self._direction = train.stroke.direction
        self.direction = sink.add(scope, "direction", LEVEL, int(self._direction > 0))
        self.step = sink.add(scope, "step", STEP, 0)
        self.pulses = sink.add(scope, "pulses", COUNT, train.stroke.position_at(now_ns))
        self._falls_ns: list[int] = []

    def catch_up(self) -> None:
        """A train knows all it has done."""

    def count(self, since_ns: int, before_ns: int) -> int:
        """How many pulses there are from `since_ns` to before `before_ns`."""
        return sum(last - first + 1 for _, first, last in self._stretches(since_ns, before_ns))

    def changes(self, since_ns: int, before_ns: int) -> list[Change]:
        """What changes in that time, not in order."""
        found: list[Change] = []
        for stroke, first, last in self._stretches(since_ns, before_ns):
            if stroke.start_ns >= since_ns and stroke.direction != self._direction:
                self._direction = stroke.direction
                found.append((stroke.start_ns, self.direction, int(stroke.direction > 0)))
            if last >= first:
                found += self._pulses(stroke, first, last)
        due = bisect_left(self._falls_ns, before_ns)
        found += [(fall_ns, self.step, 0) for fall_ns in self._falls_ns[:due]]
        del self._falls_ns[:due]
        return found

    def _pulses(self, stroke: Stroke, first: int, last: int) -> Iterator[Change]:
        import numpy as np

        times = np.empty(last - first + 1, np.int64)
        stroke.profile.fill_pulse_times(first, stroke.start_ns, times)
        self._falls_ns += (times + STEP_NS).tolist()
        for n, time_ns in enumerate(times.tolist(), start=first):
            yield time_ns, self.step, 1
            yield time_ns, self.pulses, stroke.origin + stroke.direction * n

    def _stretches(self, since_ns: int, before_ns: int) -> Iterator[tuple[Stroke, int, int]]:
        """The strokes in that time, each with the first and the last of its pulses that fall in it."""
        strokes: list[Stroke] = []
        for stroke in reversed(self.train.strokes):
            if stroke.start_ns < before_ns:
                strokes.append(stroke)
            if stroke.start_ns < since_ns:  # one that begins here may follow on the last pulse of another
                break
        for stroke in reversed(strokes):
            before = stroke.profile.pulses_by(since_ns - 1 - stroke.start_ns)
            yield stroke, before + 1, stroke.profile.pulses_by(before_ns - 1 - stroke.start_ns)


class _ServoTrace:
    """The signals of a servo axis.  It is told what has been, and keeps it until it is written."""

    def __init__(self, sink: Sink, scope: str, axis: ServoAxis) -> None:
        self.axis = axis
        self._position = axis.position
        self._commanded = axis.commanded
        self.position = sink.add(scope, "position", COUNT, self._position)
        self.commanded = sink.add(scope, "commanded", COUNT, self._commanded)
        self._changes: list[Change] = []

    def take(self, samples: Samples) -> None:
        """What has been."""
        time_ns = samples.start_ns
        for position, commanded in zip(samples.positions, samples.commanded, strict=True):
            if position != self._position:
                self._position = int(position)
                self._changes.append((time_ns, self.position, self._position))
            if commanded != self._commanded:
                self._commanded = int(commanded)
                self._changes.append((time_ns, self.commanded, self._commanded))
            time_ns += samples.period_ns

    def catch_up(self) -> None:
        """Hear what has been by now."""
        self.axis.catch_up()

    def count(self, _since_ns: int, before_ns: int) -> int:
        """How many changes wait to be written."""
        return bisect_left(self._changes, before_ns, key=itemgetter(0))

    def changes(self, _since_ns: int, before_ns: int) -> list[Change]:
        """Those before a time."""
        due = bisect_left(self._changes, before_ns, key=itemgetter(0))
        found, self._changes = self._changes[:due], self._changes[due:]
        return found
