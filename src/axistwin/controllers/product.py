"""Types that all families of controllers implement, so that a bench can build and use their controllers."""

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from axistwin.controllers.commandset import CommandSet
from axistwin.core.errors import with_article
from axistwin.plant.axes import MakeAxis, stepper_axis
from axistwin.sim.clock import Clock, Process
from axistwin.sim.frames import UartFormat
from axistwin.sim.pins import Pin
from axistwin.sim.progress import Line, LineWatcher
from axistwin.sim.registers import RegisterPort
from axistwin.sim.serial import Uart
from axistwin.sim.signal import Alarms

if TYPE_CHECKING:
    from axistwin.controllers.diagnostics import Checker, Rule
    from axistwin.controllers.front import Group
    from axistwin.plant.joystick import JoystickInputs


class Store(Protocol):
    """Non-volatile memory of a controller."""

    def load(self) -> bytes | None:
        """Return the contents of the controller's non-volatile memory, or None if the memory is empty."""

    def save(self, contents: bytes) -> None:
        """Save the contents; errors are not raised.  After a crash, the memory holds the new or the old contents."""


class Register(NamedTuple):
    """A number or text that can be read without side effects, and changes only at events.

    Exceptions are `restless`, or reported by `Abilities.follow`.
    """

    read: Callable[[], int | str]
    also: tuple[str, ...] = ()  # Other names, such as the command that reports the register.
    text: bool = False  # True for a text, False for a number.
    costly: bool = False
    """True if the register is slow to record, and is therefore recorded only if its full name is given."""
    restless: bool = False  # True if the value also changes between events, so that changes cannot be reported.


Follower = Callable[[Sequence[int], Sequence[int], Sequence[int]], None]
"""Function that is called with changes of registers: their times, register indexes and new values."""


class Listing(NamedTuple):
    """A program in the memory of a controller, as lines of text."""

    title: str
    lines: tuple[str, ...]  # The lines as a user writes them.
    running: int | None = None  # Index of the line that is running; None: no line is running.
    silent: frozenset[int] = frozenset()  # Indexes of lines that take no time and never run: labels, ends of blocks.
    ended_by: str = ""  # The fault that has ended the program before its last line; empty if no fault has.


class ControlLines(NamedTuple):
    """The control lines DTR, RTS, DSR and CTS of a serial connector."""

    dtr: Pin
    rts: Pin
    dsr: Pin
    cts: Pin


class Handshake(NamedTuple):
    """Control lines of a serial connector, at the connector and inside the device."""

    plug: ControlLines  # The lines at the connector.
    inside: ControlLines  # The lines inside the device, which depend on the wiring of the connector.


class Awaited(NamedTuple):
    """A digital input that must change its level before a waiting device continues."""

    work: str  # The work that waits: "the move", "step 3 of the sequence".
    pin: str
    level: str  # The level for which the device waits: "high" or "low".


class Refusal(NamedTuple):
    """A line or command of a host that the device has refused or ignored."""

    data: bytes  # The line without its terminator, or the whole command of a board on a bus.
    why: str = ""  # The cause, and the remedy if `rule` is None; "" if the line is wrong in every state of the device.
    rule: "Rule | None" = None
    channel: int = 0  # 1 for the second serial channel.


class Abilities(NamedTuple):
    """Optional abilities of a device; each default value means that the device lacks this ability."""

    uart: Uart | None = None  # UART of the serial connector.
    handshake: Handshake | None = None  # Control lines of the serial connector.
    rs485: Uart | None = None  # Second serial channel, on a pair of wires.
    bus: RegisterPort | None = None  # The two registers of a board on a bus.
    alarms: Alarms | None = None  # Fault flags of the device, to which observers can subscribe.
    registers: Callable[[], Mapping[str, Register]] = dict  # Function that returns the registers by name.
    follow: Callable[[Sequence[str], Follower], Callable[[], None]] | None = None
    """Function that reports every change of these registers to a follower, with a delay.

    Returns an unsubscribe function.  For a device that computes ahead of the clock.
    """
    programs: Callable[[], Mapping[str, Listing]] = dict
    """Function that returns the stored programs by name, each with its running line."""
    subscribe_lines: Callable[[LineWatcher, Line | None], Callable[[], None]] = lambda watcher, only: lambda: None
    """Function that subscribes `watcher(program, index)` to the beginning of all program lines, or of line `only`.

    The callback may read the bench but must not change it.  Returns an unsubscribe function.
    """
    hint: Callable[[], str] = lambda: ""
    """Function that returns the reason why the device does not move, and the remedy; "" if it can move."""
    subscribe_hint: Callable[[Callable[[str], None]], Callable[[], None]] = lambda watcher: lambda: None
    """Function that subscribes `watcher(hint)` to changes of the status hint."""
    subscribe_refusals: Callable[[Callable[[Refusal], None]], Callable[[], None]] = lambda watcher: lambda: None
    """Function that subscribes a watcher to the lines that the device refuses.  Returns an unsubscribe function."""
    awaited: Callable[[], Awaited | None] = lambda: None
    """Function that returns the input for which the device waits, or None."""
    ignoring: Callable[[], str] = lambda: ""
    """Function that returns the reason why the device ignores the host's commands; "" if it does not."""
    assign: Callable[[str, int], None] | None = None
    """Function that sets a variable or gain by name, at once and without a host."""
    busy: Callable[[], bool] = lambda: False
    """Function that returns True while the device works on a request of the host."""
    procedures: Callable[[], Sequence[Process]] = tuple
    """Function that returns the running procedures; the power can be switched off only between their steps."""


class Device(Protocol):
    """The hardware of one controller, with or without power."""

    @property
    def pins(self) -> dict[str, Pin]: ...

    @property
    def abilities(self) -> Abilities:
        """Optional interfaces of a controller, e.g. a UART or a bus port."""

    def power(self, on: bool) -> None: ...


class Placed(NamedTuple):
    """A byte of a command, with its column in the command text.  The first column is 0."""

    byte: int
    column: int
    width: int = 2  # Length of the word that contains the byte.


class Language(Protocol):
    """Converts commands and messages from bytes to text for users, and back."""

    def read(self, text: str) -> bytes:
        """Return the bytes of a command.  Raises ProgramError with the column, counted from 1."""

    def placed(self, text: str) -> Sequence[Placed]:
        """Return a command's bytes with their columns, from 0.  Raises ProgramError with the column, from 1."""

    def message(self, text: str) -> bytes:
        """Convert a message from text to bytes.  The bytes are padded to the full length of a message."""

    def explain(self, command: bytes) -> str: ...

    def explain_message(self, message: bytes) -> str: ...


class BusHost(Protocol):
    """A host of a board on a bus, which uses the board's handshake for commands and messages."""

    @property
    def pending(self) -> int: ...

    def write(self, command: bytes) -> None: ...

    def subscribe_received(self, callback: Callable[[bytes], None]) -> Callable[[], None]:
        """Call `callback` with each message that the host receives from the board.  Return an unsubscribe function."""

    def close(self) -> None: ...


class Order(NamedTuple):
    """A request that a host can send to a controller, e.g. to run a stored program."""

    label: str
    says: bytes  # Characters with their terminator, or one command of a board on a bus.
    doc: str


class Product(NamedTuple):
    """A controller model, with all data that its simulation needs."""

    model: str
    title: str
    commands: CommandSet
    axes: tuple[str, ...]
    options: type[Any]
    """A dataclass: the keywords of `Bench.add` for this model, with the manual's figures as defaults."""
    build: Callable[[Clock, Mapping[str, Any], Any, Store], Device]
    """Function that builds the hardware from the clock, the axes, the options and the memory."""
    family: str = ""
    """Name of the package of a family of ours, e.g. "digiplan", which other packages have modules for; else ""."""
    suffix: str = ""
    """Suffix of the program files in the device's own notation, e.g. ".if1"; "" if there are only conversations."""
    make_axis: MakeAxis = stepper_axis
    """Function that creates an axis from its options; the bench connects its switches later."""
    check: "Checker | None" = None
    check_for: "Callable[[Mapping[str, Any]], Checker] | None" = None
    """Function that returns `check` for given options, such as an address; None: they do not matter to it."""
    make_rules: Callable[[], "tuple[Rule, ...]"] = tuple  # Function that imports and returns `rules`.
    endings: tuple[bytes, bytes] = (b"\r", b"\r")  # Terminators of a host's lines and of answers; b"" for datagrams.
    line: UartFormat | None = None  # Default character format of the host; None: no serial port.
    limit_pins: Mapping[str, tuple[str, str]] = MappingProxyType({})
    """Pins of the minus and the plus limit input, by axis; axes with the same pins share them in series."""
    closed_level: bool = True  # Level of the `limit_pins` while their switches are closed.
    drive_fault_pins: Mapping[str, str] = MappingProxyType({})
    """Pins that are low while a drive has a fault, by the name of its axis."""
    home_pins: Mapping[str, str] = MappingProxyType({})  # Pins of the home input, by axis.
    brake_pin: str | None = None  # The pin that is high while the static brake must hold the shaft.
    language: Language | None = None  # Text form of the commands of a device on a bus; None: the commands are text.
    note: Callable[[], str] = lambda: ""
    """Function that returns a hint about this installation of axistwin; usually ""."""
    prepare: Callable[[float | None, int], None] = lambda speed, controllers: None
    """Function that does slow preparations, such as compiling, before a host is connected.

    Its arguments are the speed (None: maximum) and the number of controllers.  Controllers may run meanwhile, in
    another thread.
    """
    prepared: Callable[[float | None, int], bool] = lambda speed, controllers: True
    """True if `prepare` takes less than a second, e.g. because its results are in the user's cache."""
    orders: Callable[[str], tuple[Order, ...]] = lambda program: ()
    """Function that returns the requests with which a host runs or stops a stored program."""
    programs: tuple[str, ...] = ()
    """Names of the programs that the device can store; if there are several, each name ends in a number."""
    most_lines: int | None = None  # Largest number of lines in a program; None if the manual gives no limit.
    attend: Callable[[RegisterPort], BusHost] | None = None
    """Function that connects a host program to the registers of a board on a bus."""
    joystick: "JoystickInputs | None" = None
    driver: Any = None
    """What `axistwin.drivers.make` takes for this model; None: its name."""
    phrase: Callable[[Any, Mapping[str, Any]], bytes] | None = None
    """Function that makes the characters of a request from a command of the table and its parameters; None: unknown."""
    make_front: Callable[[], "tuple[Group, ...]"] = tuple  # Function that imports and returns `front`.

    @property
    def rules(self) -> "tuple[Rule, ...]":
        """Rules of `axistwin check` for this model, sorted by their codes, e.g. DP101."""
        return self.make_rules()

    def with_options(self, given: Mapping[str, Any]) -> "Product":
        """Return the model with the checker for these options."""
        return self if self.check_for is None else self._replace(check=self.check_for(given))

    @property
    def front(self) -> "tuple[Group, ...]":
        """Groups of display elements (lamps, words and numbers) on the front panel of this model."""
        return self.make_front()

    @property
    def indefinite(self) -> str:
        """Model name with its indefinite article: an IF1, an 1811, a SmartMotor; or the title, a DC motor stage."""
        named = (word for word in self.title.replace(",", " ").split() if word.lower() == self.model)
        return with_article(next(named, self.title))
