"""Records a conversation while it happens, so that it can be played again and must be the same to the nanosecond.

Behind each thing the controller says stands the time at which its last character had come (`= clock`).

An act is recorded as soon as nothing can be added to it.  Into a file it is written at once (`recording_to`), so that
a recording may go on for days, and is there also when nobody came to end it.
"""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from decimal import Decimal
from logging import getLogger
from pathlib import Path

from axistwin.bench import Bench, endpoints, line_format
from axistwin.bench.actions import level_name
from axistwin.bench.acts import Act, Comment, Do, Expect, Hear, Say, Wait
from axistwin.bench.codec import CHARACTERS, Codec
from axistwin.bench.events import Arranged, Broke, Changed, Event, Failed, Handled, Heard, Said, observing
from axistwin.conversations.conversation import Conversation, write
from axistwin.errors import UsageError
from axistwin.plant.axes import Axis
from axistwin.sim.frames import UartFormat
from axistwin.units import MS, S

log = getLogger("axistwin")

LF_NS = 50 * MS
"""A line feed that comes later than this after a carriage return is something new."""
PAUSE_NS = 1 * S
"""A silence longer than this inside something said makes two things of it, and is told before the second."""


def _axes(bench: Bench) -> Iterator[tuple[str, str, Axis]]:
    for name, controller in bench.controllers.items():
        for axis, motor in controller.axes.items():
            yield name, axis, motor


class Recorder:
    """Makes acts of what happens.

    `add` is given each of them; None: they are kept in `acts`, which grows with what is said.  `grain_ns`: times are
    told in whole multiples of it.  `raw`: the controller gets characters only, so that what the host does with its line
    else is no act, but a comment.  `relayed`: the controller is a real one, which characters reach when they do; what
    holds them back here is no act.
    """

    def __init__(
        self,
        bench: Bench,
        headers: Mapping[str, str],
        add: Callable[[Act], object] | None = None,
        *,
        grain_ns: int = 1,
        raw: bool = False,
        relayed: bool = False,
    ) -> None:
        self.bench, self.grain_ns, self.raw, self.relayed = bench, grain_ns, raw, relayed
        self.acts: list[Act] = []
        self._add = add or self.acts.append
        for key, value in headers.items():
            if value:
                self._add(Comment(f"{key}: {value}"))
        self._told_ns = 0  # the acts so far have brought a player to here
        self._speaker = ""
        self._words = bytearray()
        self._last_ns = 0
        self._formats: dict[str, UartFormat] = {
            name: self._usual_format(name, headers.get("line") or None)
            for name in endpoints.names(bench)
            if not endpoints.at_a_bus(bench, name)
        }
        self._began_at = {(name, axis): motor.position for name, axis, motor in _axes(bench)}

    def take(self, event: Event) -> None:
        """Something has happened."""
        match event:
            case Heard():
                self._heard(event)
            case Said():
                self._act(event.time_ns, event.controller, Say(event.data, controller=self._name(event.controller)))
            case Broke():
                seconds = f"{Decimal(event.seconds).quantize(Decimal('1e-9')):f}"
                self._act(event.time_ns, event.controller, self._with_the_line(event.controller, "break", seconds))
            case Failed():
                self._done(event.time_ns, event.controller, event.act, event.words)
            case Arranged() if not self.relayed:
                self._act(
                    event.time_ns, event.controller, self._with_the_line(event.controller, event.act, event.value)
                )
            case Handled():
                self._done(event.time_ns, event.controller, event.act, event.value)
            case Changed():
                self._changed(event)

    def shows(self, controller: str, subject: str, value: str) -> None:
        """From now on something can be seen, such as a control line of the controller."""
        self._told()
        self._wait_until(self.bench.now)
        self._add(Expect(subject, value, controller=self._name(controller)))

    def catch_up(self) -> None:
        """Tell what the controller has said, if nothing more can belong to it."""
        if self.silent_ns > PAUSE_NS or self.bench.clock.quiet or (self._ended and self.silent_ns > LF_NS):
            self._told()

    def finish(self) -> None:
        """Tell the end: the time, and where the axes stand that have moved."""
        self._told()
        self._wait_until(self.bench.now)
        for name, axis, motor in _axes(self.bench):
            if motor.position != self._began_at[name, axis]:
                self._add(Expect(f"{axis}.position", str(motor.position), controller=self._name(name)))

    @property
    def silent_ns(self) -> int:
        """For how long nothing has come."""
        return self.bench.now - self._last_ns

    @property
    def codec(self) -> Codec:
        """How what is said is written."""
        first = next(iter(self.bench.controllers), None)
        return CHARACTERS if first is None else endpoints.codec_at(self.bench, first)

    def conversation(self) -> Conversation:
        """What has been recorded."""
        return Conversation(tuple(self.acts), codec=self.codec)

    @property
    def _ended(self) -> bool:
        """Whether the words end with a terminator, behind which there can be but a line feed."""
        return bytes(self._words[-1:]) in (b"\r", b"\n")

    def _heard(self, event: Heard) -> None:
        """Characters are one act as long as they are one message: up to its terminator."""
        silent_ns = event.time_ns - self._last_ns
        ended = event.controller not in self._formats  # on a bus each message is whole
        ended = ended or (self._ended and (event.data != b"\n" or silent_ns > LF_NS))
        if event.controller != self._speaker or ended or silent_ns > PAUSE_NS:
            self._told()
            self._pass_silence(event.time_ns)
        self._speaker = event.controller
        self._words += event.data
        self._last_ns = event.time_ns

    def _act(self, time_ns: int, controller: str, act: Act) -> None:
        """The host does something with its line, in the format that it has now."""
        self._told()
        self._wait_until(time_ns)
        if controller in self._formats:
            self._note_format(controller)
        self._add(act)

    def _told(self) -> None:
        """What the controller has said until here is an act."""
        if self._words:
            name, time_ns = self._name(self._speaker), self._grained(self._last_ns)
            self._add(Hear(bytes(self._words), controller=name))
            self._add(Expect("clock", f"{Decimal(time_ns) / S:.{9 if self.grain_ns == 1 else 6}f}"))
            self._words.clear()
            self._told_ns = max(time_ns, self._told_ns)

    def _changed(self, event: Changed) -> None:
        """What a controller does to a terminal is no act; what the host does to its lines is."""
        if event.pin.startswith("host."):
            self._told()
            self._wait_until(event.time_ns)
            target = event.pin.removeprefix("host.")
            self._add(self._with_the_line(event.controller, target, level_name(event.level)))

    def _done(self, time_ns: int, controller: str, target: str, value: str) -> None:
        """Somebody has done something to a machine."""
        self._told()
        self._wait_until(time_ns)
        self._add(Do(target, value, controller=self._name(controller)))

    def _with_the_line(self, controller: str, target: str, value: str) -> Act:
        """What the host does with its end of the line, beside saying something."""
        if self.raw:
            return Comment(f"{target} {value} by the host did not reach the controller")
        return Do(target, value, controller=self._name(controller))

    def _usual_format(self, name: str, line: str | None) -> UartFormat:
        """The format that a player's host will have."""
        usual = self.bench[name].product.line if name in self.bench.controllers else None
        return line_format(line, usual)[0] if usual is not None else self.bench.port(name).host.format

    def _note_format(self, name: str) -> None:
        present = self.bench.port(name).host.format
        if present != self._formats[name]:
            self._formats[name] = present
            self._add(self._with_the_line(name, "line", str(present)))

    def _pass_silence(self, until_ns: int) -> None:
        """A player waits for the controller, but not for ever: most of a long silence is told."""
        whole_ns = (until_ns - self._told_ns - PAUSE_NS) // S * S
        if whole_ns > 0:
            self._wait_until(self._told_ns + whole_ns)

    def _grained(self, time_ns: int) -> int:
        return time_ns // self.grain_ns * self.grain_ns

    def _wait_until(self, time_ns: int) -> None:
        time_ns = self._grained(time_ns)
        if time_ns > self._told_ns:
            self._add(Wait(time_ns - self._told_ns))
            self._told_ns = time_ns

    def _name(self, controller: str) -> str:
        return controller if endpoints.several(self.bench) else ""


class TalkFile:
    """A conversation that is written while it goes on, line by line.  Raises UsageError if it cannot be.

    When the disk is full, that is told once, and what follows is lost; `close` says it again.
    """

    def __init__(self, path: Path) -> None:
        if path.suffix != ".talk":
            raise UsageError(f"{path} is no name for a conversation: end it in .talk")
        if not path.parent.is_dir():
            raise UsageError(f"{path} cannot be written: there is no directory {path.parent}")
        self.path = path
        self.codec: Codec = CHARACTERS
        self._problem = ""
        try:
            self._file = path.open("w", encoding="utf-8", buffering=1)
        except OSError as error:
            raise self._cannot(error) from None

    def add(self, act: Act) -> None:
        """One more act."""
        if self._problem:
            return
        try:
            self._file.write(write((act,), self.codec))
        except OSError as error:
            self._problem = str(self._cannot(error))
            log.warning("%s: what follows is not recorded", self._problem)

    def close(self) -> None:
        """Nothing more comes."""
        try:
            self._file.close()
        except OSError as error:
            self._problem = self._problem or str(self._cannot(error))
        if self._problem:
            raise UsageError(f"{self._problem}: the recording is not whole")

    def _cannot(self, error: OSError) -> UsageError:
        return UsageError(f"{self.path} cannot be written: {(error.strerror or str(error)).lower()}")


@contextmanager
def recording(bench: Bench, headers: Mapping[str, str] | None = None) -> Iterator[Recorder]:
    """Record what happens on the bench meanwhile.  `headers`: the conversation's first comments."""
    recorder = Recorder(bench, _headers(bench) if headers is None else headers)
    with observing(bench, recorder.take):
        yield recorder
    recorder.finish()


@contextmanager
def recording_to(
    bench: Bench,
    path: Path,
    headers: Mapping[str, str] | None = None,
    *,
    grain_ns: int = 1,
    raw: bool = False,
    relayed: bool = False,
) -> Iterator[Recorder]:
    """Record into the file at `path`, act by act.  Raises UsageError if it cannot be written.

    Who waits for answers in real time calls the recorder's `catch_up` now and then, so that the last one is written.
    """
    file = TalkFile(path)
    try:
        headers = _headers(bench) if headers is None else headers
        recorder = Recorder(bench, headers, file.add, grain_ns=grain_ns, raw=raw, relayed=relayed)
        file.codec = recorder.codec
        with observing(bench, recorder.take):
            yield recorder
        recorder.finish()
    finally:
        file.close()


def _headers(bench: Bench) -> Mapping[str, str]:
    models = [controller.product.model for controller in bench.controllers.values()]
    return {"model": models[0]} if len(models) == 1 else {}
