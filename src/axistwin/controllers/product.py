"""The interface between a bench and a product, for all families."""

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
from axistwin.sim.signal import Signal


class PulseAxis(Protocol):
    """An axis as a stepper controller uses it."""

    def start(self, profile: Profile, direction: int) -> None:
        """Begin a move now."""

    def replace(self, profile: Profile) -> None:
        """Replace the profile of the present move; `profile` is given from the start of the move."""

    def halt(self) -> None:
        """Stop the pulses at once."""

    @property
    def encoder_count(self) -> int | None:
        """Encoder counts after quadrature, from an arbitrary zero; None: no encoder."""

    def wire_index(self, pin: SensedPin) -> None:
        """Connect the encoder's channel Z to a terminal, if there is an encoder."""

    def encoder_counted(self, within_ns: int) -> bool:
        """True if the encoder has counted in the last `within_ns`."""

    @property
    def encoder_direction(self) -> int:
        """Direction of the encoder's last motion: +1 or -1."""

    @property
    def on_push(self) -> Signal[[]]:
        """Emitted when the load has been pushed."""


class Store(Protocol):
    """Memory that persists without power."""

    def load(self) -> bytes | None:
        """Return the contents of the last `save`; None: there was none."""

    def save(self, contents: bytes) -> None:
        """Save the contents; never fails.  After a crash the memory holds the new or the previous
        contents, complete.
        """


class Device(Protocol):
    """The hardware of one controller, which exists with or without power."""

    pins: dict[str, Pin]

    def power(self, on: bool) -> None:
        """Switch the power on or off."""


class ControlLines(Protocol):
    """The four control lines of a plug."""

    dtr: Pin
    rts: Pin
    dsr: Pin
    cts: Pin


@runtime_checkable
class SerialDevice(Device, Protocol):
    """A device with a serial plug; a host communicates with its UART."""

    uart: Uart


@runtime_checkable
class HandshakeDevice(SerialDevice, Protocol):
    """A serial device with four control lines."""

    dtr: Pin
    rts: Pin
    dsr: Pin
    cts: Pin
    lines: "ControlLines"
    """The lines inside the device; they depend on the wiring of the plug."""


@runtime_checkable
class Rs485Device(Device, Protocol):
    """A device with a second serial channel, on a pair of wires."""

    rs485: Uart


@runtime_checkable
class TroubledDevice(Device, Protocol):
    """A device that reports the reason why it does not move."""

    def hint(self) -> str:
        """Return a status hint in one line: the reason and the remedy; empty if there is none."""


@runtime_checkable
class HintingDevice(TroubledDevice, Protocol):
    """A device that reports new status hints."""

    def subscribe_hint(self, watcher: Callable[[str], None]) -> Callable[[], None]:
        """Call `watcher(line)` when there is a new hint.  Return an unsubscribe function."""


@runtime_checkable
class BusDevice(Device, Protocol):
    """A device in a slot of a bus; a host communicates with its two registers."""

    bus: RegisterPort


@dataclass(frozen=True)
class Register:
    """A readable number or text inside a controller.  Reading it changes nothing.

    Its value changes only at events, unless it is `restless` or the device is a `FollowedDevice`.
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


@runtime_checkable
class RegisteredDevice(Device, Protocol):
    """A device with readable registers."""

    def registers(self) -> Mapping[str, Register]:
        """The registers by name."""


Follower = Callable[[Sequence[int], Sequence[int], Sequence[int]], None]
"""Callback with changes in order of time: the times, the indexes of the registers, and the new values."""


@runtime_checkable
class FollowedDevice(RegisteredDevice, Protocol):
    """A device that computes ahead of the clock and therefore reports changes with their times."""

    def follow(self, names: Sequence[str], follower: Follower) -> Callable[[], None]:
        """Call a follower with every change of these registers, with delay; unchanged values may be included.

        Return an unsubscribe function.
        """


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


@runtime_checkable
class ProgrammedDevice(Device, Protocol):
    """A device that stores programs and runs them."""

    def programs(self) -> Mapping[str, Listing]:
        """The stored programs, with their running lines, by the product's names."""

    def subscribe_lines(self, watcher: LineWatcher, only: Line | None = None) -> Callable[[], None]:
        """Call `watcher(program, index)` when a line begins, or only when the line `only` begins.

        The callback may read the bench but must not change it.  Return an unsubscribe function.
        """


@runtime_checkable
class AlarmDevice(Device, Protocol):
    """A device that reports its fault flags."""

    alarms: Alarms


@runtime_checkable
class BusyDevice(Device, Protocol):
    """A device that takes time for a host's request."""

    @property
    def busy(self) -> bool:
        """True while the device is busy; new requests may have to wait."""


@runtime_checkable
class ProceduralDevice(Device, Protocol):
    """A device that works by procedures: its power cannot go off in the middle of a procedure's step."""

    clock: Clock

    @property
    def procedures(self) -> Sequence[Process]:
        """The procedures in progress."""


class Placed(Protocol):
    """A byte, and its place in a text."""

    @property
    def byte(self) -> int:
        """The byte."""

    @property
    def column(self) -> int:
        """Its column, from 0."""

    @property
    def width(self) -> int:
        """Its width in columns."""


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


def _no_orders(program: str) -> tuple[Order, ...]:  # noqa: ARG001  # whatever its name
    return ()


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
    """Finds problems in a program."""
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
    orders: Callable[[str], tuple[Order, ...]] = _no_orders
    """Returns the host's requests that run or stop a stored program; the argument is one of `programs`."""
    programs: tuple[str, ...] = ()
    """Names of the programs that it can store; several names each end in a number."""
    most_lines: int | None = None
    """Maximum number of lines in a program, if the manual specifies it."""
    attend: Callable[[RegisterPort], BusHost] | None = None
    """Makes a host for its registers, if it is on a bus."""
    joystick: JoystickInputs | None = None
    """The inputs for a joystick, if it has them."""
    front: tuple[Group, ...] = ()
    """Its front panel."""
