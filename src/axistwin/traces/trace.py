"""Writes what happens on a bench into a file while it happens: `.csv`, `.vcd` for GTKWave, or `.parquet`.

Only changes are written.  Which signals there are and what they are called is told in `signals.py` and
`docs/traces.md`.

A traced bench does exactly the same as one that is not.  Pulses and samples are worked out when something has come
together, in pieces of limited size; a trace does not depend on when that is, nor on how the bench is run: changes are
in order of time, and those of the same nanosecond in the order of the signals.

If the file cannot be written any more the trace is over, which is told; the bench runs on.
"""

import logging
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from time import monotonic
from types import TracebackType
from typing import Self

from axistwin.bench import Bench, Controller, endpoints
from axistwin.bench.events import terminals
from axistwin.controllers.product import Register
from axistwin.errors import UsageError
from axistwin.fault_injection.injector import Fault
from axistwin.plant.servo_axis import ServoAxis
from axistwin.sim.pins import Pin, UserPin
from axistwin.traces.axes import ServoTrace, StepperTrace
from axistwin.traces.batch import Part, Rows, Value, Waiting, merged
from axistwin.traces.files import Output, Sink, kept, sink_for
from axistwin.traces.provenance import provenance
from axistwin.traces.registers import Followed, Looked, written
from axistwin.traces.signals import DEFAULT, FAULTS, TEXT, Signal, catalogue, choose, pin_signal
from axistwin.traces.streams import Dialogue
from axistwin.units import to_seconds

CHUNK = 1 << 15
"""Changes written at a time, about."""
FLUSH_S = 2.0

_log = logging.getLogger("axistwin.trace")


class tracing:  # noqa: N801  # used as `with tracing(bench, path):`
    """Trace a bench into `path` meanwhile.

    `patterns` choose the signals; `tell` is told if the trace has to end early.

    Raises UsageError if there are no such signals, or no such file can be written.
    """

    def __init__(
        self,
        bench: Bench,
        path: Path,
        patterns: Sequence[str] = (DEFAULT,),
        tell: Callable[[str], object] = _log.warning,
    ) -> None:
        self.bench, self.path, self._tell = bench, path, tell
        self._make = sink_for(path)
        self._flushed_s = 0.0
        self._chosen = kept(path, choose(catalogue(bench), patterns))

    def __enter__(self) -> Self:
        if self.path.exists() and not self.path.is_file():
            raise UsageError(f"{self.path} cannot be written: it is no file")
        try:
            self._output = Output(self.path)
        except OSError as error:
            raise UsageError(f"{self.path} cannot be written: {error.strerror}") from None
        self._stack = ExitStack()
        self._stack.callback(self._output.close)
        self._tracer = Tracer(self.bench, self._chosen)
        self._guarded(self._begin)
        return self

    def _begin(self) -> None:
        bench, tracer = self.bench, self._tracer
        first = tracer.first()
        tracer.sink = self._make(self._output, self._chosen, first, bench.now, provenance(bench))
        tracer.failed = self._failed
        self._stack.enter_context(tracer)

    def catch_up(self) -> None:
        """Write what has happened by now; who waits for long motions in real time calls it now and then.

        Every two seconds others can read it, too.
        """
        now_s = monotonic()
        for_others = now_s - self._flushed_s >= FLUSH_S
        if self._tracer.sink is not None:
            self._guarded(partial(self._tracer.catch_up, for_others=for_others))
        self._flushed_s = now_s if for_others else self._flushed_s

    def __exit__(self, kind: type[BaseException] | None, _: BaseException | None, __: TracebackType | None) -> None:
        if self._tracer.sink is not None:
            self._guarded(self._tracer.finish)
        self._stack.close()

    def _guarded(self, do: Callable[[], None]) -> None:
        try:
            do()
        except OSError as error:
            self._failed(error)

    def _failed(self, error: OSError) -> None:
        """What has been written stays; nobody watches any more."""
        self._tracer.sink = None
        self._stack.close()
        ends_s = to_seconds(self._tracer.written_ns)
        self._tell(f"the trace {self.path.name} ends here, at {ends_s:.6f} s: {error.strerror}")


class Tracer:
    """Gathers changes of signals, and writes them in order of time."""

    def __init__(self, bench: Bench, signals: Sequence[Signal]) -> None:
        self.bench, self.signals = bench, signals
        self.sink: Sink | None = None
        self.taker: Callable[[list[Part], list[bytes]], None] | None = None
        """Who is given changes in the place of a sink: signal by signal, not all in order of time."""
        self.failed: Callable[[OSError], None] = lambda error: None
        self._places = {signal.full: n for n, signal in enumerate(signals)}
        self._waiting = Waiting(signals)
        self._upto_ns = bench.now
        self._strokes = 0
        self._writing = False
        self._steppers: list[StepperTrace] = []
        self._servos: list[ServoTrace] = []
        self._ahead: list[ServoAxis] = []
        """Whose controllers compute ahead of the clock."""
        self._registers: list[Looked] = []
        self._followed: list[Followed] = []
        self._rows: list[Rows] = []
        """What servos and followed registers have told."""
        self._first: dict[str, Value] = {}
        self._begin: list[Callable[[ExitStack], object]] = []
        for controller in bench.controllers.values():
            self._add(controller)
        for name in endpoints.names(bench):
            self._add_streams(name)
        self._most_strokes = (
            min((stepper.train.strokes.maxlen or CHUNK for stepper in self._steppers), default=CHUNK) // 2
        )

    def first(self) -> list[Value]:
        """What each signal is to begin with."""
        return [self._first.get(signal.full, b"" if signal.kind == TEXT else 0) for signal in self.signals]

    def __enter__(self) -> Self:
        """Watch."""
        self._stack = ExitStack()
        for begin in self._begin:
            begin(self._stack)
        self._stack.callback(self.bench.clock.subscribe(self._look))
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def catch_up(self, *, for_others: bool = True) -> None:
        """Write what has happened before now, if need be so that others can read it."""
        self._write(self.bench.now)
        if self.sink is not None and for_others:
            self.sink.flush()

    def finish(self) -> None:
        """Write what has happened up to now, inclusive; after a Ctrl-C in the middle of a piece, no more than that."""
        if not self._writing:
            self._look_at_registers()
            self._write(self.bench.now + 1)
        if self.sink is not None:
            self.sink.end(self.bench.now)

    @property
    def written_ns(self) -> int:
        """All that has happened before then has been written."""
        return self._upto_ns

    @property
    def _sources(self) -> list[StepperTrace | ServoTrace | Followed]:
        """What keeps its changes itself."""
        return [*self._steppers, *self._servos, *self._followed]

    # What there is

    def _place(self, *name: str) -> int | None:
        return self._places.get(".".join(name))

    def _add(self, controller: Controller) -> None:
        name = controller.name
        for pin_name, pin in terminals(controller).items():
            self._add_pin(name, pin_name, pin)
        self._add_faults(name)
        found = {key: register for key, register in controller.registers.items() if f"{name}.{key}" in self._places}
        if found:
            self._add_registers(controller, found)
        for axis_name, axis in controller.axes.items():
            scope = f"{name}.{axis_name}"
            wanted = {s.name: n for n, s in enumerate(self.signals) if s.scope == scope}
            if isinstance(axis, ServoAxis) and wanted:
                self._add_servo(scope, ServoTrace(axis, wanted))
            elif wanted and not isinstance(axis, ServoAxis):
                self._add_stepper(scope, StepperTrace(axis.train, wanted, self.bench.now), axis.on_motion.subscribe)

    def _add_pin(self, controller: str, pin_name: str, pin: Pin) -> None:
        add, clock = self._waiting.add, self.bench.clock
        level = self._place(controller, pin_signal(pin_name))
        if level is not None:
            self._first[f"{controller}.{pin_signal(pin_name)}"] = int(pin.level)
            self._begin.append(lambda stack: stack.callback(pin.watch(lambda _: add(clock.now, level, int(pin.level)))))
        volts = self._place(controller, f"{pin_name}_volts")
        if volts is not None and isinstance(pin, UserPin):
            self._first[f"{controller}.{pin_name}_volts"] = pin.volts
            self._begin.append(
                lambda stack: stack.callback(pin.watch_volts(lambda _: add(clock.now, volts, pin.volts)))
            )

    def _add_streams(self, name: str) -> None:
        host, controller = self._place(name, "host_says"), self._place(name, "controller_says")
        if host is None and controller is None:
            return
        dialogue = Dialogue(self._waiting.add, host, controller)
        self._begin.append(partial(dialogue.listen, self.bench, name))

    def _add_faults(self, name: str) -> None:
        place = self._place(name, FAULTS)
        if place is None:
            return

        def changed(fault: Fault, what: str) -> None:
            if fault.spot.name.partition(".")[0] == name:
                self._waiting.add(self.bench.now, place, self._faults(name, fault if what == "ends" else None))

        self._first[f"{name}.{FAULTS}"] = self._faults(name, None)
        self._begin.append(lambda stack: stack.callback(self.bench.faults.watch(changed)))

    def _faults(self, name: str, over: Fault | None) -> bytes:
        """Those that a controller has, without one that ends just now."""
        there = (fault for fault in self.bench.faults if fault.on and fault is not over)
        return ", ".join(sorted(fault.name for fault in there if fault.spot.name.partition(".")[0] == name)).encode()

    def _add_registers(self, controller: Controller, registers: dict[str, Register]) -> None:
        places = {key: self._places[f"{controller.name}.{key}"] for key in registers}
        self._first |= {f"{controller.name}.{key}": written(register.read()) for key, register in registers.items()}

        def follow(stack: ExitStack) -> None:
            followed = Followed(tuple(places.values()), registers)
            end = controller.follow(tuple(registers), followed.rows.add)
            if end is None:
                looked = (Looked(places[key], register, self._waiting.add) for key, register in registers.items())
                self._registers += looked
            else:
                self._followed.append(followed)
                self._rows.append(followed.rows)
                self._ahead += [axis for axis in controller.axes.values() if isinstance(axis, ServoAxis)]
                stack.callback(end)

        self._begin.append(follow)

    def _add_stepper(
        self, scope: str, trace: StepperTrace, subscribe: Callable[[Callable[[], None]], Callable[[], None]]
    ) -> None:
        self._steppers.append(trace)
        self._first |= {
            f"{scope}.{name}": trace.first(name, self.bench.now) for name in ("direction", "pulses", "velocity")
        }

        def watch(stack: ExitStack) -> None:
            stack.callback(subscribe(self._count_stroke))

        self._begin.append(watch)

    def _add_servo(self, scope: str, trace: ServoTrace) -> None:
        self._servos.append(trace)
        self._rows.append(trace.rows)
        self._ahead.append(trace.axis)
        self._first |= {f"{scope}.{name}": trace.first(name) for name in ("position", "commanded")}
        self._begin.append(lambda stack: stack.callback(trace.axis.watch(trace.take)))

    # As it happens

    def _count_stroke(self) -> None:
        self._strokes += 1

    def _look(self) -> None:
        """A nanosecond in which something has happened is over."""
        self._look_at_registers()
        much = self._waiting.count >= CHUNK or self._strokes >= self._most_strokes
        for rows in self._rows:
            much |= rows.waiting >= CHUNK
        if much and (self.sink is not None or self.taker is not None):
            try:
                self._write(self.bench.now + 1)
            except OSError as error:
                self.failed(error)

    def _look_at_registers(self) -> None:
        now_ns = self.bench.clock.now
        for register in self._registers:  # at every event: so no more is called than must be
            value = register.read()
            if value != register.known:
                register.take(now_ns, value)

    def _write(self, before_ns: int) -> None:
        """All changes since the last time, in pieces."""
        for axis in self._ahead:
            axis.catch_up()  # what it has done comes here first
        self._strokes = 0
        self._write_span(before_ns)

    def _write_span(self, before_ns: int) -> None:
        """In halves if there are too many pulses in it; all else that waits is limited anyway."""
        since_ns = self._upto_ns
        if sum(stepper.count(since_ns, before_ns) for stepper in self._steppers) > CHUNK and before_ns - since_ns > 1:
            self._write_span((since_ns + before_ns) // 2)
            self._write_span(before_ns)
        else:
            self._write_piece(before_ns)

    def _write_piece(self, before_ns: int) -> None:
        self._writing = True
        texts: list[bytes] = []
        parts = self._waiting.parts(before_ns, texts)
        for source in self._sources:
            parts += source.parts(self._upto_ns, before_ns)
        if self.taker is not None and parts:
            self.taker(parts, texts)
        elif self.sink is not None and parts:
            self.sink.write(merged(parts, texts))
        self._upto_ns, self._writing = before_ns, False
