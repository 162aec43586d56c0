"""The state of the motor's processor and the primitives that every chapter uses.

`i` holds the integers named in `kernel/state.py`, `v` the variables of the language.  Chapters change both.
Chapters do not import the dispatcher (`motor.py`): the functions of the dispatcher that chapters need are abstract
here.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Protocol

from axistwin.controllers.product import Refusal, Store
from axistwin.controllers.smartmotor.kernel import state as s
from axistwin.controllers.smartmotor.kernel.core import Core
from axistwin.controllers.smartmotor.nonvolatile import Nonvolatile
from axistwin.controllers.smartmotor.options import Options
from axistwin.controllers.smartmotor.serial.channel import Channel, ChannelError, Dispatcher
from axistwin.plant.servo_axis import ServoAxis
from axistwin.sim.clock import Clock
from axistwin.sim.pins import Pin, UserPin
from axistwin.sim.serial import Uart
from axistwin.sim.signal import Signal

CHANNEL_1 = 4  # Bit of F that sends the output of a program to channel 1 (manual, table 7.1).


class Control(Enum):
    """The signal that controls the static brake (manual, section 5.2)."""

    SERVO = "BRKSRV"
    TRAJECTORY = "BRKTRJ"
    RELEASED = "BRKRLS"
    ENGAGED = "BRKENG"


@dataclass
class Reception:
    """Values that the motor has received for the next trajectory point in host mode (manual, section 10.1)."""

    position: int | None = None  # A position without its clock value.
    clock: int | None = None  # The last point's clock value.
    delta: int | None = None  # The difference between the last two clock values.


class StoredProgram(Protocol):
    """The interface through which commands access a stored program."""

    @property
    def labels(self) -> Mapping[int, int]: ...

    @property
    def statements(self) -> Sequence[object]:
        """The statements of the program, in the order of its text."""

    def number_at(self, head: int) -> int:
        """Return the number of the statement whose compiled code begins at the index `head`."""


class Processor(Dispatcher, ABC):
    """The state of a processor that is switched on, and the operations of all chapters on it."""

    def __init__(
        self, axis: ServoAxis, pins: Mapping[str, UserPin], brake_line: Pin, uarts: tuple[Uart, Uart], store: Store,
        options: Options,
    ) -> None:  # fmt: skip
        self.clock: Clock = brake_line.clock
        self.axis, self.pins, self.brake_line, self.store, self.options = axis, pins, brake_line, store, options
        self.core = Core(self.clock, self._act, options.host_buffer)
        self.i, self.v, self.f, self.ring = self.core.i, self.core.v, self.core.f, self.core.ring
        self.channels = Channel(self, 0, uarts[0]), Channel(self, 1, uarts[1])
        self.nonvolatile = Nonvolatile.load(store)
        self.reception = Reception()
        self.brake_control, self.mtb_enabled = Control.SERVO, True
        self.powered = True
        self.refused = False  # True if a fault has prevented the last requested movement.
        self.host: Channel | None = None  # Channel whose command is being executed, or None.
        self.why_refused: str | None = None  # Why the present command is refused, as in `Refusal`, or None.
        self.statement_before = s.NOTHING_YET  # The statement that was announced last since the program was started.
        self.on_pin_use: Signal[[]] = Signal()  # Event: A and B become encoder inputs, or step and direction.
        self.on_fault: Callable[[str], None] = lambda name: None
        """Function that is called with the name of the flag when a fault of table 4.1 occurs."""
        self.on_refusal: Callable[[str], None] = lambda reason: None
        """Function that is called with the reason at the first motion that a fault prevents."""
        self.on_refused_command: Callable[[Refusal], None] = lambda refusal: None
        """Function that is called with each refused command of a host."""

    @property
    @abstractmethod
    def program(self) -> StoredProgram: ...

    @abstractmethod
    def set_program(self, text: str) -> None: ...

    @abstractmethod
    def reset(self) -> None: ...

    @abstractmethod
    def _act(self, why: int) -> None: ...

    def catch_up(self, *, changing: bool = True) -> None:
        """Advance the state to the last sample up to now.  `changing`: True if the caller will change the state."""
        self.core.catch_up(changing=changing)

    def edges(self) -> int:
        return self.axis.master.count + self.i[s.PIN_EDGES]

    def syntax_error(self, why: str = "") -> None:
        """Set Bs, also for RCHN, after a command that is invalid or cannot be executed.  `why`: as in `Refusal`."""
        self._flag(s.BS, ChannelError.SCAN)
        self.refuse(why)

    def refuse(self, why: str = "") -> None:
        """Report the present command of the host, after its execution, as refused.  `why`: as in `Refusal`."""
        if self.host is not None:
            self.why_refused = why

    def overflow(self) -> None:
        """Set Bc, and the error of RCHN, after an overflow of received data."""
        self._flag(s.BC, ChannelError.OVERFLOW)

    def _flag(self, slot: int, error: ChannelError) -> None:
        self.i[slot] = 1
        if self.host is not None:
            self.host.flag(error)

    def send(self, data: bytes, channel: int | None = None) -> None:
        """Send the output of the statement in progress: to the host of a command, or to the program's channel.  A
        program is blocked while too much output is waiting.
        """
        if self.host is not None and channel is None:
            self.host.send(data)
            return
        to = self.channels[(1 if self.i[s.F] & CHANNEL_1 else 0) if channel is None else channel]
        if self.host is not None or not to.silent:
            to.send(data)
        if self.host is None and to.full:
            self.i[s.PROGRAM] = s.BLOCKED
            to.when_empty(self._unblock)

    def _unblock(self) -> None:
        if self.powered and self.i[s.PROGRAM] == s.BLOCKED:
            self.catch_up()
            self.i[s.PROGRAM] = s.RUNNING
