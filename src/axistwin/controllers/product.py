"""The interface between a bench and a product, for all families."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol

from axistwin.controllers.commandset import CommandSet
from axistwin.controllers.diagnostics import Checker, Rule
from axistwin.controllers.front import Group
from axistwin.plant.axes import MakeAxis, stepper_axis
from axistwin.plant.joystick import JoystickInputs
from axistwin.sim.alarms import Alarms
from axistwin.sim.clock import Clock, Process
from axistwin.sim.frames import UartFormat
from axistwin.sim.pins import Pin
from axistwin.sim.progress import Line, LineWatcher
from axistwin.sim.registers import RegisterPort
from axistwin.sim.serial import Uart


class Store(Protocol):
    """Memory that persists without power."""

    def load(self) -> bytes | None:
        """Return the contents of the last `save`; None: there was none."""

    def save(self, contents: bytes) -> None:
        """Save the contents; never fails.  After a crash the memory holds the new or the previous
        contents, complete.
        """


@dataclass(frozen=True)
class Register:
    """A readable number or text inside a controller.  Reading it changes nothing.

    Its value changes only at events, unless it is `restless` or the device reports its changes (`Abilities.follow`).
    """

    read: Callable[[], int | str]
    also: tuple[str, ...] = ()
    """Other names, such as the command that reports it."""
    text: bool = False
    """True for a text, False for a number."""
    costly: bool = False
    """True if it is expensive to record; it is then recorded only on request by its full name."""
    restless: bool = False
    """True if it changes between events, so that it can be read but not followed."""


Follower = Callable[[Sequence[int], Sequence[int], Sequence[int]], None]
"""Callback with changes in order of time: the times, the indexes of the registers, and the new values."""


@dataclass(frozen=True)
class Listing:
    """A program in the memory of a controller."""

    title: str
    lines: tuple[str, ...]
    """The lines as a user writes them."""
    running: int | None = None
    """Index of the line that is running; None: no line is running."""
    silent: frozenset[int] = frozenset()
    """Lines that take no time and never run: labels, ends of blocks."""


@dataclass(frozen=True)
class ControlLines:
    """The four control lines of a plug."""

    dtr: Pin
    rts: Pin
    dsr: Pin
    cts: Pin


@dataclass(frozen=True)
class Handshake:
    """Control lines of a serial plug."""

    plug: ControlLines
    inside: ControlLines
    """The lines inside the device; they depend on the wiring of the plug."""


@dataclass(frozen=True)
class Abilities:
    """The optional parts of a device, with defaults for a device without them."""

    uart: Uart | None = None
    """The UART of its serial plug."""
    handshake: Handshake | None = None
    """The control lines of its serial plug."""
    rs485: Uart | None = None
    """A second serial channel, on a pair of wires."""
    bus: RegisterPort | None = None
    """Its two registers, if it is in a slot of a bus."""
    alarms: Alarms | None = None
    """Subscriptions to its fault flags."""
    registers: Callable[[], Mapping[str, Register]] = dict
    """Returns its readable registers by name."""
    follow: Callable[[Sequence[str], Follower], Callable[[], None]] | None = None
    """Calls a follower with every change of these registers, with delay; unchanged values may be included.

    Returns an unsubscribe function.  For a device that computes ahead of the clock.
    """
    programs: Callable[[], Mapping[str, Listing]] = dict
    """Returns its stored programs, with their running lines, by the product's names."""
    subscribe_lines: Callable[[LineWatcher, Line | None], Callable[[], None]] = lambda watcher, only: lambda: None
    """Calls `watcher(program, index)` when a line begins, or only when the line `only` begins.

    The callback may read the bench but must not change it.  Returns an unsubscribe function.
    """
    hint: Callable[[], str] = lambda: ""
    """Returns a status hint in one line: why it does not move, and the remedy; empty if there is none."""
    subscribe_hint: Callable[[Callable[[str], None]], Callable[[], None]] = lambda watcher: lambda: None
    """Calls `watcher(line)` when there is a new hint.  Returns an unsubscribe function."""
    busy: Callable[[], bool] = lambda: False
    """Returns True while it works on a host's request; new requests may have to wait."""
    procedures: Callable[[], Sequence[Process]] = tuple
    """Returns its procedures in progress: its power cannot go off in the middle of a procedure's step."""


class Device(Protocol):
    """The hardware of one controller, which exists with or without power."""

    @property
    def pins(self) -> dict[str, Pin]:
        """Its terminals by name."""

    @property
    def abilities(self) -> Abilities:
        """Its optional parts."""

    def power(self, on: bool) -> None:
        """Switch the power on or off."""


class Placed(NamedTuple):
    """A byte, and the column, from 0, of its text."""

    byte: int
    column: int
    width: int = 2
    """The length of the word that contains the byte."""


class Language(Protocol):
    """The text form of binary commands and messages, for people."""

    def read(self, text: str) -> bytes:
        """Return the bytes of a command.  Raises ProgramError with the column, from 1."""

    def placed(self, text: str) -> Sequence[Placed]:
        """Return the bytes of a command with their places.  Raises ProgramError with the column, from 1."""

    def message(self, text: str) -> bytes:
        """Return the bytes of a whole message."""

    def explain(self, command: bytes) -> str:
        """Return a command in words."""

    def explain_message(self, message: bytes) -> str:
        """Return a message in words."""


class BusHost(Protocol):
    """A host that sends commands to a board and takes its messages, with all handshakes."""

    @property
    def pending(self) -> int:
        """Number of commands that the board has not taken yet."""

    def write(self, command: bytes) -> None:
        """Send a command as soon as the board takes it."""

    def subscribe_received(self, callback: Callable[[bytes], None]) -> Callable[[], None]:
        """Call `callback` with each message.  Return an unsubscribe function."""

    def close(self) -> None:
        """End all use of the registers."""


@dataclass(frozen=True)
class Order:
    """A request of a host, and its effect."""

    label: str
    says: bytes
    """The characters with their terminator; for a board on a bus, a whole command."""
    doc: str


@dataclass(frozen=True)
class Product:
    """One model: its construction and its command set."""

    model: str
    title: str
    commands: CommandSet
    axes: tuple[str, ...]
    options: type[Any]
    """A dataclass: the keywords of `Bench.add` for this model, with the manual's figures as defaults."""
    build: Callable[[Clock, Mapping[str, Any], Any, Store], Device]
    """Makes the hardware from its axes (each made by `make_axis`), its options and its memory."""
    make_axis: MakeAxis = stepper_axis
    """Makes an axis from its options.  The bench fits the switches in the options later."""
    check: Checker | None = None
    rules: tuple[Rule, ...] = ()
    """The rules of `check`, in the order of the codes."""
    line: UartFormat | None = None
    """The host's default format; None: no serial port."""
    limit_pins: tuple[str, str] | None = None
    """Pins that the minus and plus limit switches of all axes hold closed."""
    closed_level: bool = True
    """Level of those pins while their switches are closed."""
    drive_fault_pins: Mapping[str, str] = field(default_factory=dict)
    """By axis, the pin that is low while its drive has a fault."""
    home_pin: str | None = None
    brake_pin: str | None = None
    """The pin that is high while the static brake must hold the shaft."""
    language: Language | None = None
    """The text form of its commands, if they are not characters on a line."""
    note: Callable[[], str] = lambda: ""
    """Returns a hint about this installation in one line; usually empty."""
    prepare: Callable[[float | None, int], None] = lambda speed, controllers: None
    """Prepares a number of controllers for a speed (None: maximum speed), so that no host has to wait later."""
    orders: Callable[[str], tuple[Order, ...]] = lambda program: ()
    """Returns the host's requests that run or stop a stored program; the argument is one of `programs`."""
    programs: tuple[str, ...] = ()
    """Names of the programs that it can store; several names each end in a number."""
    most_lines: int | None = None
    """Maximum number of lines in a program, if the manual specifies it."""
    attend: Callable[[RegisterPort], BusHost] | None = None
    """Makes a host for its registers, if it is on a bus."""
    joystick: JoystickInputs | None = None
    front: tuple[Group, ...] = ()
