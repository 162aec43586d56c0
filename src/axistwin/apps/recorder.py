"""Records a conversation while it happens, so that it can be played again and must be the same to the nanosecond.

Behind each thing the controller says stands the time at which its last character had come (`= clock`).
"""

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from decimal import Decimal
from pathlib import Path

from axistwin.apps import partners
from axistwin.apps.conversation import Act, Comment, Conversation, Do, Expect, Hear, Say, Wait, write
from axistwin.apps.events import Broke, Changed, Event, Heard, Said, Turned, observing
from axistwin.apps.machine import level_name, voltage
from axistwin.apps.visible import CHARACTERS
from axistwin.bench import Bench, line_format
from axistwin.errors import UsageError
from axistwin.plant.axes import Axis
from axistwin.sim.pins import PULLED_UP_VOLTS, UserPin
from axistwin.sim.serial import UartFormat
from axistwin.units import S

PAUSE_NS = 1 * S
"""A silence longer than this inside something said makes two things of it, and is told before the second."""


def _axes(bench: Bench) -> Iterator[tuple[str, str, Axis]]:
    for name, controller in bench.controllers.items():
        for axis, motor in controller.axes.items():
            yield name, axis, motor


class Recorder:
    """The acts so far.  Everything at once, so it grows with what is said."""

    def __init__(self, bench: Bench, headers: Mapping[str, str]) -> None:
        self.bench = bench
        self.acts: list[Act] = [Comment(f"{key}: {value}") for key, value in headers.items() if value]
        self._told_ns = 0  # the acts so far have brought a player to here
        self._speaker = ""
        self._words = bytearray()
        self._last_ns = 0
        self._forced: set[tuple[str, str]] = set()
        self._formats: dict[str, UartFormat] = {
            name: self._usual_format(name, headers.get("line") or None)
            for name in partners.names(bench)
            if not partners.at_a_bus(bench, name)
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
                self._act(
                    event.time_ns, event.controller, Do("break", seconds, controller=self._name(event.controller))
                )
            case Changed():
                self._changed(event)
            case Turned():
                self._turned(event)

    def finish(self) -> None:
        """Tell the end: the time, and where the axes stand that have moved."""
        self._told()
        self._wait_until(self.bench.now)
        for name, axis, motor in _axes(self.bench):
            if motor.position != self._began_at[name, axis]:
                self._add(Expect(f"{axis}.position", str(motor.position), controller=self._name(name)))

    def conversation(self) -> Conversation:
        """What has been recorded."""
        codec = (
            partners.codec_at(self.bench, next(iter(self.bench.controllers))) if self.bench.controllers else CHARACTERS
        )
        return Conversation(tuple(self.acts), codec=codec)

    def _heard(self, event: Heard) -> None:
        """Characters are one act as long as they are one message: up to its terminator."""
        ended = event.controller not in self._formats
        ended = ended or (bytes(self._words[-1:]) in (b"\r", b"\n") and event.data != b"\n")
        if event.controller != self._speaker or ended or event.time_ns - self._last_ns > PAUSE_NS:
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
            name = self._name(self._speaker)
            self._add(Hear(bytes(self._words), controller=name))
            self._add(Expect("clock", f"{Decimal(self._last_ns) / S:.9f}"))
            self._words.clear()
            self._told_ns = self._last_ns

    def _changed(self, event: Changed) -> None:
        """What somebody does to a terminal is an act, what the controller does to it is not."""
        if isinstance(self.bench[event.controller].pins.get(event.pin), UserPin):
            return  # its voltage tells it
        released = self._let_go(event)
        if event.driven or released or event.pin.startswith("host."):
            self._do(event, "release" if released else level_name(event.level))

    def _turned(self, event: Turned) -> None:
        """The same with a terminal that has a voltage."""
        released = self._let_go(event)
        if event.driven or released:
            level = {0.0: "low", PULLED_UP_VOLTS: "high"}.get(event.volts, voltage(event.volts))
            self._do(event, "release" if released else level)

    def _let_go(self, event: Changed | Turned) -> bool:
        """Whether somebody has forced the terminal until now, and does not any more."""
        key = event.controller, event.pin
        released = key in self._forced and not event.driven
        if event.driven:
            self._forced.add(key)
        self._forced -= {key} if released else set()
        return released

    def _do(self, event: Changed | Turned, value: str) -> None:
        self._told()
        self._wait_until(event.time_ns)
        self._add(Do(event.pin.removeprefix("host."), value, controller=self._name(event.controller)))

    def _usual_format(self, name: str, line: str | None) -> UartFormat:
        """The format that a player's host will have."""
        usual = self.bench[name].product.line if name in self.bench.controllers else None
        return line_format(line, usual)[0] if usual is not None else self.bench.port(name).host.format

    def _note_format(self, name: str) -> None:
        present = self.bench.port(name).host.format
        if present != self._formats[name]:
            self._formats[name] = present
            self._add(Do("line", str(present), controller=self._name(name)))

    def _pass_silence(self, until_ns: int) -> None:
        """A player waits for the controller, but not for ever: most of a long silence is told."""
        whole_ns = (until_ns - self._told_ns - PAUSE_NS) // S * S
        if whole_ns > 0:
            self._wait_until(self._told_ns + whole_ns)

    def _wait_until(self, time_ns: int) -> None:
        if time_ns > self._told_ns:
            self._add(Wait(time_ns - self._told_ns))
            self._told_ns = time_ns

    def _name(self, controller: str) -> str:
        return controller if partners.several(self.bench) else ""

    def _add(self, act: Act) -> None:
        self.acts.append(act)


@contextmanager
def recording(bench: Bench, headers: Mapping[str, str] | None = None) -> Iterator[Recorder]:
    """Record what happens on the bench meanwhile.  `headers`: the conversation's first comments."""
    if headers is None:
        models = [controller.product.model for controller in bench.controllers.values()]
        headers = {"model": models[0]} if len(models) == 1 else {}
    recorder = Recorder(bench, headers)
    with observing(bench, recorder.take):
        yield recorder
    recorder.finish()


@contextmanager
def recording_to(bench: Bench, path: Path, headers: Mapping[str, str] | None = None) -> Iterator[None]:
    """Record into the file at `path`, which is written when this is over.  Raises UsageError if it cannot be."""
    if path.suffix != ".talk":
        raise UsageError(f"{path} is no name for a conversation: end it in .talk")
    if not path.parent.is_dir():
        raise UsageError(f"{path} cannot be written: there is no directory {path.parent}")
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise UsageError(f"{path} cannot be written: permission denied")
    with recording(bench, headers) as recorder:
        yield
    try:
        path.write_text(write(recorder.conversation().acts), encoding="utf-8")
    except OSError as error:
        raise UsageError(f"{path} cannot be written: {error.strerror}") from None
