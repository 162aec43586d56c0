"""Record a conversation so that a replay is identical to the nanosecond.

After each reply of the controller a `= clock` line gives the time of its last character.

An act is recorded as soon as it is complete.  `recording_to` writes each act to its file at once, so a recording may
take days and survives a program that is killed.
"""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from decimal import Decimal
from logging import getLogger
from pathlib import Path

from axistwin.bench import Bench, endpoints, events, line_format
from axistwin.bench.actions import level_name
from axistwin.bench.acts import Act, Comment, Do, Expect, Hear, Say, Wait
from axistwin.bench.codec import CHARACTERS, Codec
from axistwin.bench.events import observing
from axistwin.bench.talk.conversation import Conversation, write
from axistwin.core.errors import AxistwinError, UsageError
from axistwin.core.storage import write_error
from axistwin.core.units import MS, S
from axistwin.plant.axes import Axis
from axistwin.sim.frames import UartFormat

log = getLogger("axistwin")

LF_NS = 50 * MS  # Longest time between a carriage return and a line feed of the same message.
PAUSE_NS = 1 * S  # Longest pause within a reply; after a longer pause, a new line of the conversation begins.


def _axes(bench: Bench) -> Iterator[tuple[str, str, Axis]]:
    for name, controller in bench.controllers.items():
        for axis, motor in controller.axes.items():
            yield name, axis, motor


class Recorder:
    """Converts the events of a simulation to lines of a conversation.

    `add` receives each act; None: the acts are collected in `acts`, without a limit.  Times are rounded down to
    multiples of `grain_ns`.  `raw`: only characters reach the controller, so other acts of the host become comments.
    `relayed`: the controller is a real one; changes of flow control are then not recorded.
    """

    def __init__(
        self, bench: Bench, headers: Mapping[str, str], add: Callable[[Act], object] | None = None, *,
        grain_ns: int = 1, raw: bool = False, relayed: bool = False,
    ) -> None:  # fmt: skip
        self.bench, self.grain_ns, self.raw, self.relayed = bench, grain_ns, raw, relayed
        self.acts: list[Act] = []
        self._add = add or self.acts.append
        for key, value in headers.items():
            if value:
                self._add(Comment(f"{key}: {value}"))
        self._recorded_ns = 0  # Virtual time in ns at the end of the last line of the recorded conversation.
        self._speaker = ""
        self._reply = bytearray()
        self._last_ns = 0
        self._formats: dict[str, UartFormat] = {
            name: self._usual_format(name, headers.get("line") or None)
            for name in endpoints.names(bench)
            if not endpoints.at_a_bus(bench, name)
        }
        self._began_at = {(name, axis): motor.position for name, axis, motor in _axes(bench)}

    def record(self, event: events.Event) -> None:
        match event:
            case events.Received():
                self._received(event)
            case events.Sent():
                said = Say(event.data, controller=self._name(event.controller))
                self._record_now(event.time_ns, said, event.controller)
            case events.LineBreak():
                seconds = f"{Decimal(event.seconds).quantize(Decimal('1e-9')):f}"
                self._record_now(event.time_ns, self._line_act(event.controller, "break", seconds), event.controller)
            case events.FaultChanged():
                self._record_action(event.time_ns, event.controller, event.act, event.words)
            case events.SettingChanged() if not self.relayed:
                line_act = self._line_act(event.controller, event.act, event.value)
                self._record_now(event.time_ns, line_act, event.controller)
            case events.ManualAction():
                self._record_action(event.time_ns, event.controller, event.act, event.value)
            case events.LevelChanged():
                self._changed(event)

    def record_state(self, controller: str, subject: str, value: str) -> None:
        """Record the present value of a control line or another subject; later changes are recorded, too."""
        self._record_now(self.bench.now, Expect(subject, value, controller=self._name(controller)))

    def catch_up(self) -> None:
        if self.silent_ns > PAUSE_NS or self.bench.clock.quiet or (self._is_terminated and self.silent_ns > LF_NS):
            self._flush_reply()

    def finish(self) -> None:
        """Write the last lines of the recording: the time, and the positions of all axes that have moved."""
        self._flush_reply()
        self._wait_until(self.bench.now)
        for name, axis, motor in _axes(self.bench):
            if motor.position != self._began_at[name, axis]:
                self._add(Expect(f"{axis}.position", str(motor.position), controller=self._name(name)))

    @property
    def silent_ns(self) -> int:
        return self.bench.now - self._last_ns

    @property
    def codec(self) -> Codec:
        first = next(iter(self.bench.controllers), None)
        return CHARACTERS if first is None else endpoints.codec_at(self.bench, first)

    def conversation(self) -> Conversation:
        return Conversation(tuple(self.acts), codec=self.codec)

    @property
    def _is_terminated(self) -> bool:
        return bytes(self._reply[-1:]) in (b"\r", b"\n")

    def _received(self, event: events.Received) -> None:
        """Add to the reply, after recording a complete one: at its terminator, a pause, or another sender."""
        silent_ns = event.time_ns - self._last_ns
        is_bus_message = event.controller not in self._formats
        ended = is_bus_message or (self._is_terminated and (event.data != b"\n" or silent_ns > LF_NS))
        if event.controller != self._speaker or ended or silent_ns > PAUSE_NS:
            self._flush_reply()
            self._record_silence(event.time_ns)
        self._speaker = event.controller
        self._reply += event.data
        self._last_ns = event.time_ns

    def _record_now(self, time_ns: int, act: Act, at: str = "") -> None:
        """Record an act; of a host, after a change of its line's format `at` this endpoint."""
        self._flush_reply()
        self._wait_until(time_ns)
        if at in self._formats:
            self._note_format(at)
        self._add(act)

    def _flush_reply(self) -> None:
        if self._reply:
            name, time_ns = self._name(self._speaker), self._round_down(self._last_ns)
            self._add(Hear(bytes(self._reply), controller=name))
            self._add(Expect("clock", f"{Decimal(time_ns) / S:.{9 if self.grain_ns == 1 else 6}f}"))
            self._reply.clear()
            self._recorded_ns = max(time_ns, self._recorded_ns)

    def _changed(self, event: events.LevelChanged) -> None:
        if event.pin.startswith("host."):
            target = event.pin.removeprefix("host.")
            self._record_now(event.time_ns, self._line_act(event.controller, target, level_name(event.level)))

    def _record_action(self, time_ns: int, controller: str, target: str, value: str) -> None:
        self._record_now(time_ns, Do(target, value, controller=self._name(controller)))

    def _line_act(self, controller: str, target: str, value: str) -> Act:
        if self.raw:
            return Comment(f"{target} {value} by the host did not reach the controller")
        return Do(target, value, controller=self._name(controller))

    def _usual_format(self, name: str, line: str | None) -> UartFormat:
        usual = self.bench[name].product.line if name in self.bench.controllers else None
        return line_format(line, usual)[0] if usual is not None else self.bench.port(name).host.format

    def _note_format(self, name: str) -> None:
        present = self.bench.port(name).host.format
        if present != self._formats[name]:
            self._formats[name] = present
            self._add(self._line_act(name, "line", str(present)))

    def _record_silence(self, until_ns: int) -> None:
        """Record a long silence as a `+` line, because a replay waits only for a limited time."""
        whole_ns = (until_ns - self._recorded_ns - PAUSE_NS) // S * S
        if whole_ns > 0:
            self._wait_until(self._recorded_ns + whole_ns)

    def _round_down(self, time_ns: int) -> int:
        return time_ns // self.grain_ns * self.grain_ns

    def _wait_until(self, time_ns: int) -> None:
        time_ns = self._round_down(time_ns)
        if time_ns > self._recorded_ns:
            self._add(Wait(time_ns - self._recorded_ns))
            self._recorded_ns = time_ns

    def _name(self, controller: str) -> str:
        return controller if endpoints.several(self.bench) else ""


class TalkFile:
    """Writes the lines of a recording to a conversation file (`.talk`) while the simulation runs.

    The constructor raises UsageError if it cannot create the file.  If writing fails later, a warning is logged once
    and later lines are lost; `close` raises AxistwinError.
    """

    def __init__(self, path: Path) -> None:
        if path.suffix != ".talk":
            raise UsageError(f"invalid file name {path}: expected a name that ends in .talk")
        if not path.parent.is_dir():
            raise UsageError(f"{path} cannot be written: there is no directory {path.parent}")
        self.path = path
        self.codec: Codec = CHARACTERS
        self._write_error: OSError | None = None
        try:
            self._file = path.open("w", encoding="utf-8", buffering=1)
        except OSError as error:
            raise self._cannot(error=error) from None

    def add(self, act: Act) -> None:
        if self._write_error:
            return
        try:
            self._file.write(write((act,), self.codec))
        except OSError as error:
            self._write_error = error
            log.warning("%s: later acts are not recorded", self._cannot(error))

    def close(self) -> None:
        """Close the file.  Raises AxistwinError if the recording is incomplete, e.g. because the disk is full."""
        try:
            self._file.close()
        except OSError as error:
            self._write_error = self._write_error or error
        if self._write_error is not None:
            raise write_error(f"the recording is incomplete: {self.path} cannot be written", self._write_error)

    def _cannot(self, error: OSError) -> AxistwinError:
        return write_error(f"{self.path} cannot be written", error)


@contextmanager
def recording(bench: Bench) -> Iterator[Recorder]:
    """Context manager that records the events of a simulation."""
    recorder = Recorder(bench, _headers(bench))
    with observing(bench, recorder.record):
        yield recorder
    recorder.finish()


@contextmanager
def recording_to(
    bench: Bench, path: Path, headers: Mapping[str, str] | None = None, *, grain_ns: int = 1, raw: bool = False,
    relayed: bool = False,
) -> Iterator[Recorder]:  # fmt: skip
    """Record a conversation to a file, line by line.  Raises UsageError if the file cannot be written.

    A caller that is paced to real time calls the recorder's `catch_up` at intervals, to write the last reply.
    """
    file = TalkFile(path)
    try:
        headers = _headers(bench) if headers is None else headers
        recorder = Recorder(bench, headers, file.add, grain_ns=grain_ns, raw=raw, relayed=relayed)
        file.codec = recorder.codec
        with observing(bench, recorder.record):
            yield recorder
        recorder.finish()
    finally:
        file.close()


def _headers(bench: Bench) -> Mapping[str, str]:
    models = [controller.product.model for controller in bench.controllers.values()]
    return {"model": models[0]} if len(models) == 1 else {}
