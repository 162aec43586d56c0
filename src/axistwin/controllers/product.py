"""What a bench needs to know of a product, and what a product is given.  The same for every family."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

from axistwin.controllers.commandset import CommandSet
from axistwin.controllers.diagnostics import Checker, Rule
from axistwin.controllers.front import Group
from axistwin.motion.profile import Profile
from axistwin.plant.axes import MakeAxis, stepper_axis
from axistwin.plant.joystick import JoystickInputs
from axistwin.sim.alarms import Alarms
from axistwin.sim.clock import Clock, Process
from axistwin.sim.frames import UartFormat
from axistwin.sim.pins import Pin, SensedPin
from axistwin.sim.progress import Line, LineWatcher
from axistwin.sim.registers import RegisterPort
from axistwin.sim.serial import Uart


class PulseAxis(Protocol):
    """What a stepper controller knows of an axis."""

    def start(self, profile: Profile, direction: int) -> None:
        """Give out pulses from now on."""

    def replace(self, profile: Profile) -> None:
        """From now on take the course of `profile`, which is told from the start."""

    def halt(self) -> None:
        """No more pulses."""

    @property
    def encoder_count(self) -> int | None:
        """Encoder pulses after quadrature, from anywhere; None: it has no encoder."""

    def wire_index(self, pin: SensedPin) -> None:
        """Connect the encoder's channel Z to a terminal, if there is an encoder."""

    def encoder_counted(self, within_ns: int) -> bool:
        """True if the encoder has counted within so many ns until now."""

    @property
    def encoder_direction(self) -> int:
        """+1 or -1: where the encoder has counted to last."""

    @property
    def on_push(self) -> list[Callable[[], None]]:
        """Called when the encoder has moved by itself."""


class Store(Protocol):
    """What keeps its contents without power."""

    def load(self) -> bytes | None:
        """What was saved last; None: nothing yet."""

    def save(self, contents: bytes) -> None:
        """Keep this; after a crash either this or the contents before is there, whole.  It never fails."""


class Device(Protocol):
    """The hardware of one controller, which is there whether it has power or not."""

    pins: dict[str, Pin]

    def power(self, on: bool) -> None:
        """Switch it on or off."""


class ControlLines(Protocol):
    """The four control lines of a plug."""

    dtr: Pin
    rts: Pin
    dsr: Pin
    cts: Pin


@runtime_checkable
class SerialDevice(Device, Protocol):
    """A device with a serial plug: what a host talks to is its UART."""

    uart: Uart


@runtime_checkable
class HandshakeDevice(SerialDevice, Protocol):
    """Its plug has four control lines, too."""

    dtr: Pin
    rts: Pin
    dsr: Pin
    cts: Pin
    lines: "ControlLines"
    """What the device itself finds there, which depends on how its plug is wired."""


@runtime_checkable
class Rs485Device(Device, Protocol):
    """A device with a second serial channel, on a pair of wires."""

    rs485: Uart


@runtime_checkable
class TroubledDevice(Device, Protocol):
    """A device that can tell why it does nothing."""

    def trouble(self) -> str:
        """In a line: what keeps it from moving, and what helps; mostly nothing."""


@runtime_checkable
class HintingDevice(TroubledDevice, Protocol):
    """One that tells so when it begins."""

    def watch_trouble(self, watcher: Callable[[str], None]) -> Callable[[], None]:
        """Call `watcher(line)` when there is something new to tell.  Returns what ends it."""


@runtime_checkable
class BusDevice(Device, Protocol):
    """A device in a slot of a bus: what a host talks to is a pair of registers."""

    bus: RegisterPort


@dataclass(frozen=True)
class Register:
    """A number or a text that a controller keeps, for those who look into it.  Reading it changes nothing.

    It stays as it is between two events, or else it is `restless`, or the device a `FollowedDevice`.
    """

    read: Callable[[], int | str]
    also: tuple[str, ...] = ()
    """Other names for it, such as the command that reports it."""
    text: bool = False
    """Whether it is a text; otherwise a number."""
    costly: bool = False
    """Whether it costs much to follow it, so that it is only followed if it is asked for by its full name."""
    restless: bool = False
    """Whether it changes between two events, so that one can look at it but not follow it."""


@runtime_checkable
class RegisteredDevice(Device, Protocol):
    """A device that one can look into."""

    def registers(self) -> Mapping[str, Register]:
        """What it keeps, by name."""


Follower = Callable[[Sequence[int], Sequence[int], Sequence[int]], None]
"""Told of changes in order of time: when each was, which of the registers it was, and its value from then on."""


@runtime_checkable
class FollowedDevice(RegisteredDevice, Protocol):
    """A device that computes ahead of the clock, so that it has to tell what has changed and when."""

    def follow(self, names: Sequence[str], follower: Follower) -> Callable[[], None]:
        """Tell a follower, beside others, of every change of these registers, late, and also of what is none.

        Returns what ends it.
        """


@dataclass(frozen=True)
class Listing:
    """A program that a controller keeps, as it stands in the memory."""

    title: str
    lines: tuple[str, ...]
    """As a user would write them."""
    running: int | None = None
    """The index of the line that is being carried out; None: none of them is."""
    silent: frozenset[int] = frozenset()
    """Lines that take no time, so that they never run: labels, ends of blocks."""


@runtime_checkable
class ProgrammedDevice(Device, Protocol):
    """A device that keeps programs and carries them out by itself."""

    def programs(self) -> Mapping[str, Listing]:
        """What is stored and what of it is being carried out now, by the names that the product gives."""

    def watch_lines(self, watcher: LineWatcher, only: Line | None = None) -> Callable[[], None]:
        """Call `watcher(program, index)` at the moment at which a line begins, or `only` this one.

        It may look and must change nothing.  Returns what ends it.
        """


@runtime_checkable
class AlarmDevice(Device, Protocol):
    """A device that tells when it raises a fault flag."""

    alarms: Alarms


@runtime_checkable
class BusyDevice(Device, Protocol):
    """A device that is at work for a while with what a host has asked for."""

    @property
    def busy(self) -> bool:
        """Whether it is; what comes meanwhile may have to wait."""


@runtime_checkable
class ProceduralDevice(Device, Protocol):
    """A device that works by procedures: its power cannot go while one of them is in the middle of something."""

    clock: Clock

    @property
    def procedures(self) -> Sequence[Process]:
        """Those that are under way."""


class Placed(Protocol):
    """A byte, and the column from 0 at which it is written."""

    @property
    def byte(self) -> int:
        """The byte."""

    @property
    def column(self) -> int:
        """Its column."""

    @property
    def width(self) -> int:
        """How many columns it takes up there."""


class Language(Protocol):
    """How commands and messages that are bytes stand in a text for people."""

    def read(self, text: str) -> bytes:
        """A command.  Raises ProgramError with the column, from 1."""

    def placed(self, text: str) -> Sequence[Placed]:
        """The same, with the place of each byte."""

    def message(self, text: str) -> bytes:
        """A whole message."""

    def explain(self, command: bytes) -> str:
        """A command in words."""

    def explain_message(self, message: bytes) -> str:
        """A message in words."""


class BusHost(Protocol):
    """Somebody who sends commands to a board and takes its messages, with the handshakes they need."""

    @property
    def pending(self) -> int:
        """Commands that the board has not taken yet."""

    def write(self, command: bytes) -> None:
        """Send a command as soon as the board takes it."""

    def hear(self, hearer: Callable[[bytes], None]) -> Callable[[], None]:
        """Call `hearer` with each message.  Returns what ends it."""

    def close(self) -> None:
        """Leave the registers alone."""


@dataclass(frozen=True)
class Order:
    """Something that a host can say, and what comes of it."""

    label: str
    says: bytes
    """Characters, ended as a host ends them; to a board on a bus, a whole command."""
    doc: str


def _no_orders(program: str) -> tuple[Order, ...]:  # noqa: ARG001  # whatever its name
    return ()


@dataclass(frozen=True)
class Product:
    """One model: how to build it and what it understands."""

    model: str
    title: str
    commands: CommandSet
    axes: tuple[str, ...]
    options: type[Any]
    """A dataclass: the keywords that `Bench.add` takes for this model, with the manual's figures as defaults."""
    build: Callable[[Clock, Mapping[str, Any], Any, Store], Device]
    """Makes the hardware, given its axes (each by `make_axis`), its options and its memory."""
    make_axis: MakeAxis = stepper_axis
    """Makes an axis of the options it is given.  The switches that they name are fitted when the device is there."""
    check: Checker | None = None
    """Finds what is wrong with a program for it."""
    rules: tuple[Rule, ...] = ()
    """What that can find, in the order of the codes."""
    line: UartFormat | None = None
    """The host's usual format, where nothing else is said; None: it has no serial port."""
    limit_pins: tuple[str, str] | None = None
    """Pins that the minus and the plus limit switches of all axes hold closed."""
    closed_level: bool = True
    """The level of those pins while their switches are closed."""
    drive_fault_pins: Mapping[str, str] = field(default_factory=dict)
    """By axis, the pin that is low while its drive has a fault."""
    home_pin: str | None = None
    brake_pin: str | None = None
    """The pin that is high while the static brake is to hold the shaft."""
    language: Language | None = None
    """How its commands are written, where they are not characters on a line."""
    note: Callable[[], str] = lambda: ""
    """What its users should know about this installation, in a line; mostly nothing."""
    prepare: Callable[[float | None, int], None] = lambda speed, controllers: None
    """Do what would keep a host waiting later, for so many controllers at a speed (None: as fast as it goes)."""
    orders: Callable[[str], tuple[Order, ...]] = _no_orders
    """What a host says to have the program of this name, one of `programs`, carried out or stopped."""
    programs: tuple[str, ...] = ()
    """The programs that it can keep, by name; where there are several, each name ends in its number."""
    most_lines: int | None = None
    """The lines that one of them has at most, where the manual says so."""
    attend: Callable[[RegisterPort], BusHost] | None = None
    """Makes a host for its registers, where it sits on a bus."""
    joystick: JoystickInputs | None = None
    """Where a joystick is connected, if it takes one."""
    front: tuple[Group, ...] = ()
    """What it shows to those who stand before it."""
