"""Write the changes of signals to a file while a bench runs: `.csv`, `.vcd` for GTKWave, or `.parquet`.

`docs/traces.md` describes the signals.

Tracing does not change the behaviour of a bench.  Changes are written in order of time, and changes in the same
nanosecond in order of the signals.  Changes are collected and written in pieces of limited size; the division into
pieces does not change the trace.

If the file cannot be written, the trace ends with a message, and the bench continues.
"""

import logging
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from time import monotonic
from typing import Self

from axistwin.bench import Bench, Controller, endpoints
from axistwin.bench.events import terminals
from axistwin.bench.faults.injector import Fault
from axistwin.controllers.product import Register
from axistwin.core.errors import UsageError
from axistwin.core.units import to_seconds
from axistwin.plant.servo_axis import ServoAxis
from axistwin.records.traces.axes import ServoTrace, StepperTrace
from axistwin.records.traces.batch import Batch, ChangeQueue, Part, Rows, Value, merged
from axistwin.records.traces.files import WAVES, Sink, TextSink, ending, sink_for, supported
from axistwin.records.traces.gtkwave import write_save_file
from axistwin.records.traces.output import LimitReachedError, Output
from axistwin.records.traces.provenance import provenance
from axistwin.records.traces.registers import PolledRegister, ReportedRegisters, written
from axistwin.records.traces.signals import DEFAULT, FAULTS, TEXT, Signal, catalogue, choose, pin_signal
from axistwin.records.traces.streams import Dialogue
from axistwin.sim.pins import Pin, UserPin

CHUNK = 1 << 15  # Approximate number of changes in a piece.
FLUSH_S = 2.0

_log = logging.getLogger("axistwin.trace")


class tracing:  # noqa: N801  # used as `with tracing(bench, path):`
    """Trace a bench into `path` within this context.

    `patterns` select the signals; `report` receives a message if the trace ends early.  `limit` is the largest size of
    the file in bytes: a trace that would become larger ends.  Raises UsageError for a pattern without a match, or if
    the file cannot be written.
    """

    def __init__(
        self, bench: Bench, path: Path, patterns: Sequence[str] = (DEFAULT,),
        report: Callable[[str], object] = _log.warning, limit: int | None = None,
    ) -> None:  # fmt: skip
        self.bench, self.path, self._report, self._limit = bench, path, report, limit
        self._began_ns = bench.now
        self._make = sink_for(path)
        self._flushed_s = 0.0
        self.incomplete = False  # True if the trace, or the save file of GTKWave, could not be written.
        self._chosen = supported(path, choose(catalogue(bench), patterns))

    def __enter__(self) -> Self:
        try:
            if self.path.exists() and not self.path.is_file():
                raise UsageError(f"{self.path} is not a file: expected the name of a file, e.g. run.csv")
            self._output = Output(self.path, self._limit)
        except OSError as error:
            raise UsageError(f"the trace {self.path} cannot be written: {error.strerror}") from None
        self._stack = ExitStack()
        self._stack.callback(self._output.close)
        self._tracer = Tracer(self.bench, self._chosen)
        self._stop_on_error(self._begin)
        return self

    def _begin(self) -> None:
        bench, tracer = self.bench, self._tracer
        tracer.sink = self._make(self._output, self._chosen, tracer.first(), bench.now, provenance(bench))
        tracer.failed = self._failed
        self._stack.enter_context(tracer)
        self._write_save_file()

    def catch_up(self) -> None:
        """Write the changes up to now; every two seconds also flush the file, for other programs."""
        now_s = monotonic()
        for_others = now_s - self._flushed_s >= FLUSH_S
        if self._tracer.sink is not None:
            self._stop_on_error(partial(self._tracer.catch_up, for_others=for_others))
        self._flushed_s = now_s if for_others else self._flushed_s

    def __exit__(self, *_: object) -> None:
        if self._tracer.sink is not None:
            self._stop_on_error(self._tracer.finish)
            self._write_save_file()
        self._stack.close()

    def _write_save_file(self) -> None:
        """Write a save file with the signals for GTKWave; an error is reported, the trace continues."""
        if ending(self.path) == WAVES:
            try:
                write_save_file(self.path, self._chosen, self._began_ns, self.bench.now)
            except OSError as error:
                self.incomplete = True
                self._report(f"no GTKWave save file beside {self.path.name}: {error.strerror}")

    def _stop_on_error(self, do: Callable[[], None]) -> None:
        try:
            do()
        except OSError as error:
            self._failed(error)

    def _failed(self, error: OSError) -> None:
        """Stop tracing, and report the error; the file keeps the changes that have been written."""
        self._tracer.sink = None
        self._stack.close()
        ends_s = to_seconds(self._tracer.written_ns)
        limited = isinstance(error, LimitReachedError)
        self.incomplete |= not limited
        reason = "" if limited else "writing failed: "
        self._report(f"the trace {self.path.name} ends at {ends_s:.6f} s, because {reason}{error.strerror}")


class Tracer:
    """Collects the changes of signals, and writes them to a sink in order of time."""

    def __init__(self, bench: Bench, signals: Sequence[Signal]) -> None:
        self.bench, self.signals = bench, signals
        self.sink: Sink | None = None
        self.consumer: Callable[[list[Part], list[bytes]], None] | None = None
        """Function that receives changes instead of a sink: signal by signal, not merged in order of time."""
        self.at_moves = False
        """True: pieces of moves and levels may end at the begin of a move, so that other events cost no time."""
        self.failed: Callable[[OSError], None] = lambda error: None
        self._places = {signal.full: n for n, signal in enumerate(signals)}
        self._waiting = ChangeQueue(signals)
        self.written_ns = bench.now  # All changes before this time have been written.
        self._moves, self._writing = 0, False
        self._steppers: list[StepperTrace] = []
        self._servos: list[ServoTrace] = []
        self._computing_ahead: list[ServoAxis] = []
        """Servo axes that must compute their latest samples before each write to the trace."""
        self._registers: list[PolledRegister] = []
        self._reported: list[ReportedRegisters] = []
        self._rows: list[Rows] = []  # Buffers for the signal changes that axes and controllers report.
        self._first: dict[str, Value] = {}
        self._begin: list[Callable[[ExitStack], object]] = []
        for controller in bench.controllers.values():
            self._add(controller)
        for name in endpoints.names(bench):
            self._add_streams(name)
        self._most_moves = min((stepper.train.moves.maxlen or CHUNK for stepper in self._steppers), default=CHUNK) // 2

    def first(self) -> list[Value]:
        """Return the value of each signal at the start of the trace, in the order of the signals."""
        return [self._first.get(signal.full, b"" if signal.kind == TEXT else 0) for signal in self.signals]

    def __enter__(self) -> Self:
        self._stack = ExitStack()
        for begin in self._begin:
            begin(self._stack)
        if not self.at_moves or self._registers or self._rows:
            self._stack.callback(self.bench.clock.subscribe(self._after_events))
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def catch_up(self, *, for_others: bool = True) -> None:
        """Write the changes before now; `for_others`: also flush the file for other programs."""
        self._write(self.bench.now)
        if self.sink is not None and for_others:
            self.sink.flush()

    def show_present(self) -> None:
        """Pass all signal changes up to the present time to the function `consumer`.

        Further changes may follow at this time, e.g. an action of a user.  A later call passes the changes at this time
        again, so a consumer drops samples that are equal to the sample before.
        """
        self._poll_registers()
        self._write(self.bench.now + 1)
        self.written_ns = self.bench.now
        parts = [part for servo in self._servos for part in servo.present(self.bench.now)]
        if self.consumer is not None and parts:
            self.consumer(parts, [])

    def finish(self) -> None:
        """Write the last changes and the end time; after Ctrl-C in a write, only the end time."""
        if not self._writing:
            self._poll_registers()
            self._write(self.bench.now + 1)
        if self.sink is not None:
            self.sink.end(self.bench.now)

    # Sources

    def _place(self, *name: str) -> int | None:
        return self._places.get(".".join(name))

    def _add(self, controller: Controller) -> None:
        name = controller.name
        for pin_name, pin in {**controller.pins, **terminals(controller)}.items():
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
            self._begin.append(
                lambda stack: stack.callback(pin.subscribe_edges(lambda _: add(clock.now, level, int(pin.level))))
            )
        volts = self._place(controller, f"{pin_name}_volts")
        if volts is not None and isinstance(pin, UserPin):
            self._first[f"{controller}.{pin_name}_volts"] = pin.volts
            self._begin.append(
                lambda stack: stack.callback(pin.volts_changes.subscribe(lambda _: add(clock.now, volts, pin.volts)))
            )

    def _add_streams(self, name: str) -> None:
        host, controller = self._place(name, "host_says"), self._place(name, "controller_says")
        if host is None and controller is None:
            return
        self._begin.append(partial(Dialogue(self._waiting.add, host, controller).observe, self.bench, name))

    def _add_faults(self, name: str) -> None:
        place = self._place(name, FAULTS)
        if place is None:
            return

        def changed(fault: Fault, what: str) -> None:
            if fault.spot.name.partition(".")[0] == name:
                self._waiting.add(self.bench.now, place, self._faults(name, fault if what == "ends" else None))

        self._first[f"{name}.{FAULTS}"] = self._faults(name, None)
        self._begin.append(lambda stack: stack.callback(self.bench.faults.subscribe(changed)))

    def _faults(self, name: str, over: Fault | None) -> bytes:
        """Return the active faults of a controller without `over`, which is just ending."""
        there = (fault for fault in self.bench.faults if fault.on and fault is not over)
        return ", ".join(sorted(fault.name for fault in there if fault.spot.name.partition(".")[0] == name)).encode()

    def _add_registers(self, controller: Controller, registers: dict[str, Register]) -> None:
        places = {key: self._places[f"{controller.name}.{key}"] for key in registers}
        self._first |= {f"{controller.name}.{key}": written(register.read()) for key, register in registers.items()}

        def follow(stack: ExitStack) -> None:
            reported = ReportedRegisters(tuple(places.values()), registers)
            end = controller.follow(tuple(registers), reported.rows.add)
            if end is None:
                polled = (
                    PolledRegister(places[key], register, self._waiting.add) for key, register in registers.items()
                )
                self._registers += polled
            else:
                self._reported.append(reported)
                self._rows.append(reported.rows)
                self._computing_ahead += [axis for axis in controller.axes.values() if isinstance(axis, ServoAxis)]
                stack.callback(end)

        self._begin.append(follow)

    def _add_stepper(
        self, scope: str, trace: StepperTrace, subscribe: Callable[[Callable[[], None]], Callable[[], None]]
    ) -> None:
        self._steppers.append(trace)
        self._first |= {
            f"{scope}.{name}": trace.first(name, self.bench.now) for name in ("direction", "pulses", "velocity")
        }
        self._begin.append(lambda stack: stack.callback(subscribe(self._count_move)))

    def _add_servo(self, scope: str, trace: ServoTrace) -> None:
        self._servos.append(trace)
        self._rows.append(trace.rows)
        self._computing_ahead.append(trace.axis)
        self._first |= {f"{scope}.{name}": trace.first(name) for name in ("position", "commanded")}
        self._begin.append(lambda stack: stack.callback(trace.axis.subscribe(trace.add_samples)))

    # Events

    def _count_move(self) -> None:
        self._moves += 1
        if self.at_moves and (self._moves >= self._most_moves or self._waiting.count >= CHUNK):
            self._write(self.bench.now)

    def _after_events(self) -> None:
        self._poll_registers()
        enough = self._waiting.count >= CHUNK or self._moves >= self._most_moves
        for rows in self._rows:
            enough |= rows.waiting >= CHUNK
        if enough and (self.sink is not None or self.consumer is not None):
            try:
                self._write(self.bench.now + 1)
            except OSError as error:
                self.failed(error)

    def _poll_registers(self) -> None:
        now_ns = self.bench.clock.now
        for register in self._registers:  # The loop avoids method calls, because the loop runs at every event.
            value = register.read()
            if value != register.known:
                register.record(now_ns, value)

    def _write(self, before_ns: int) -> None:
        for axis in self._computing_ahead:
            axis.catch_up()
        self._moves = 0
        self._write_span(before_ns)

    def _write_span(self, before_ns: int) -> None:
        since_ns = self.written_ns
        if sum(stepper.count(since_ns, before_ns) for stepper in self._steppers) > CHUNK and before_ns - since_ns > 1:
            self._write_span((since_ns + before_ns) // 2)
            self._write_span(before_ns)
        else:
            self._write_piece(before_ns)

    def _write_piece(self, before_ns: int) -> None:
        self._writing = True
        texts: list[bytes] = []
        parts = self._waiting.parts(before_ns, texts)
        sources: list[StepperTrace | ServoTrace | ReportedRegisters] = [*self._steppers, *self._servos, *self._reported]
        for source in sources:
            parts += source.parts(self.written_ns, before_ns)
        if self.consumer is not None and parts:
            self.consumer(parts, texts)
        elif self.sink is not None and parts:
            self._write_batch(self.sink, merged(parts, texts))
        self.written_ns, self._writing = before_ns, False

    def _write_batch(self, sink: Sink, batch: Batch) -> None:
        """Write a batch of changes to the file.

        If the batch would exceed the size limit of a text file, only the first changes are written.  Raises
        LimitReachedError.
        """
        try:
            sink.write(batch)
        except LimitReachedError:
            at = batch.middle()
            if not isinstance(sink, TextSink) or at == len(batch):
                raise
            self._write_batch(sink, batch.part(0, at))
            self.written_ns = int(batch.times[at])
            self._write_batch(sink, batch.part(at, len(batch)))
