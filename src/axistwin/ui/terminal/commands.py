"""The terminal's own commands: lines that begin with a colon and a lower-case word."""

import re
from collections.abc import Callable, Iterable
from typing import Protocol, TypeVar

from axistwin.bench import Say, Wait, actions
from axistwin.core.errors import AxistwinError, ProgramError, UsageError
from axistwin.core.numbers import NumberError, real, shortened
from axistwin.core.units import to_seconds
from axistwin.links.pacing import read_speed
from axistwin.plant.servo_axis import ServoAxis
from axistwin.scenes.reports.columns import columns
from axistwin.sim.pins import UserPin
from axistwin.ui.teaching.pupil import Pupil
from axistwin.ui.teaching.tutor import own_command
from axistwin.ui.terminal.screen import Screen
from axistwin.ui.terminal.virtual import VirtualEnd

T = TypeVar("T")

HELP = """\
Enter sends a line to the controller.  Commands of the terminal:
  :next                what to type next                         virtual
  :why                 why nothing moves                         virtual
  :explain 1670        meaning of a number, command, code, pin   virtual
  :init                initialise the controller                 virtual
  :task                what to do in a lesson
  :show                lines that solve the task of a lesson
  :tutor off           asides about what is typed, on or off     virtual
  :load FILE           load a program and start it               virtual
  :store WAIT=9 END    the same for a SmartMotor's program text  virtual
  :pins                level of every terminal                   virtual
  :axes                position of every axis                    virtual
  :drive input1 high   force a terminal high or low, or release  virtual
                       (a SmartMotor's to 2.5V, too; also ambient 40, master 4000 in 2, shaft.load 0.3)
  :speed 10            virtual time per wall-clock time, or max  virtual
  :wait 0.5            wait, in seconds
  :help                show this list
  :quit                leave, also Ctrl-D"""


MEANINGS = {
    found[1]: found[2].strip()
    for line in HELP.splitlines()
    if (found := re.match(r"  :([a-z]+)(?: \S+)*?  +(.*?)(?:  +virtual)?$", line))
}
"""The terminal's commands and their meanings, for completion."""


class End(Protocol):
    """Connection from the terminal to a virtual controller or to a port."""

    def send(self, data: bytes) -> None: ...

    async def run_until_quiet(self) -> None:
        """Wait until the controller is idle or has been silent for a while."""

    async def wait(self, seconds: float) -> None:
        """Wait for a number of seconds: virtual time for a virtual controller, real time for a port."""


class LocalCommands:
    """Executes the terminal's own commands; commands for pins, axes and time need a `virtual` controller."""

    def __init__(self, end: End, screen: Screen, virtual: VirtualEnd | None = None) -> None:
        self.end, self.screen, self._virtual = end, screen, virtual
        self.lesson: Pupil | None = None

    def knows(self, line: bytes) -> bool:
        """True for a command of the terminal, e.g. `:pins`: a colon and a lower-case letter."""
        return own_command(line.decode("latin-1")) is not None

    def asides(self, line: bytes) -> list[str]:
        """Return the tutor's comments on the next line to send.  Raises ProgramError for an unknown command."""
        if self._virtual is None or not self._virtual.tutor.on:
            return []
        tutor, data = self._virtual.tutor, self._virtual.read(line)
        return self._virtual.inspect(lambda: tutor.sending(data))

    def asides_about(self, error: ProgramError) -> list[str]:
        return [] if self._virtual is None or not self._virtual.tutor.on else self._virtual.tutor.unreadable(error)

    def check_lesson(self) -> bool:
        """Show the next task if the present task is done.  Return True at the end of the lesson."""
        if self.lesson is None or self._virtual is None:
            return False
        while self._virtual.inspect(self.lesson.check):
            self.screen.show("done." if self.lesson.finished else f"done.  {self.lesson.task}")
        if remark := self._virtual.inspect(self.lesson.remark):
            self.screen.show(remark)
        return self.lesson.finished

    async def obey(self, line: str) -> bool:
        """Execute a command of the terminal, and show its errors.  Return False for `:quit`, else True."""
        found = own_command(line)
        assert found is not None
        try:
            return await self._obey(*found)
        except AxistwinError as error:
            self.screen.show(f"{error}")
            return True

    async def _obey(self, name: str, words: str) -> bool:
        match name:
            case "quit":
                return False
            case "help":
                self.screen.show(*HELP.splitlines())
            case "wait":
                await self.end.wait(_seconds(words))
            case "pins":
                self.screen.show(*columns(self._inspect(_pins)))
            case "axes":
                self.screen.show(*columns(self._inspect(_axes)))
            case "why":
                self.screen.tell(*self._inspect(lambda end: end.tutor.why()))
            case "next":
                self.screen.tell(*self._inspect(lambda end: end.tutor.next()))
            case "explain":
                self.screen.tell(*self._inspect(lambda end: end.tutor.explain(words)))
            case "init":
                await self._initialise(self._virtual_end())
            case "tutor":
                self._virtual_end().tutor.on = _switch(words)
            case "store":
                self._virtual_end().store(words)
            case "task" if self.lesson is not None:
                self.screen.show(self.lesson.task)
            case "show" if self.lesson is not None:
                self.screen.show(*(f"type  {line}" for line in self.lesson.solution))
            case "task" | "show":
                raise UsageError(f":{name} works only in a lesson: start a lesson with axistwin learn MODEL")
            case "load":
                self._virtual_end().load(words)
            case "drive":
                target, _, value = words.partition(" ")
                self._virtual_end().do(target, value.strip())
            case "speed":
                self._virtual_end().set_speed(read_speed(words))
            case _:
                raise UsageError(f"unknown command :{name}: expected a command of the terminal, e.g. :help")
        return True

    def _virtual_end(self) -> VirtualEnd:
        if self._virtual is None:
            raise UsageError(
                "this command needs a virtual controller, but the terminal is connected to a port: "
                "start axistwin term with a model, e.g. if1"
            )
        return self._virtual

    def _inspect(self, read: Callable[[VirtualEnd], Iterable[T]]) -> list[T]:
        end = self._virtual_end()
        return end.inspect(lambda: list(read(end)))

    async def _initialise(self, end: VirtualEnd) -> None:
        acts = 0
        steps = end.tutor.initialisation()
        while (act := end.inspect(lambda: next(steps, None))) is not None:
            acts += 1
            if isinstance(act, Wait):
                await end.wait(to_seconds(act.ns))
            elif isinstance(act, Say):
                self.screen.show_sent(act.data)
                end.send(act.data)
        if not acts:
            self.screen.show("the controller is ready: no initialisation is needed")


def _switch(words: str) -> bool:
    if words not in ("on", "off"):
        raise UsageError(f"invalid value {shortened(words)} for the tutor: expected :tutor on or :tutor off")
    return words == "on"


def _seconds(words: str) -> float:
    try:
        seconds = real(words)
    except NumberError:
        seconds = -1.0
    if not 0 <= seconds < 1e6:
        raise UsageError(f"invalid time {shortened(words)}: expected a number of seconds, e.g. :wait 0.5")
    return seconds


def _pins(end: VirtualEnd) -> Iterable[tuple[str, ...]]:
    pins = end.controller.pins
    analog = any(isinstance(pin, UserPin) for pin in pins.values())
    for name, pin in pins.items():
        volts = actions.voltage(pin.volts) if isinstance(pin, UserPin) else ""
        how = "driven" if pin.driven else "flashing" if pin.flashing else ""
        yield name, actions.level_name(pin.level), *[volts] * analog, how


def _axes(end: VirtualEnd) -> Iterable[tuple[str, ...]]:
    for name, axis in end.controller.axes.items():
        if isinstance(axis, ServoAxis):
            yield (
                name,
                str(axis.position),
                f"{axis.velocity:.0f} counts/s" if axis.moving else "at rest",
                (f"commanded {axis.commanded}"),
            )
            continue
        lost = f"{axis.pulses - axis.position} pulses lost" if axis.pulses != axis.position else ""
        yield name, str(axis.position), f"{axis.velocity:g} pulses/s" if axis.velocity else "at rest", lost
