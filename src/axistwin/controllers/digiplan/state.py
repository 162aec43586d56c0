"""State of an interface with power: the fields and operations that the commands use."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import replace
from enum import Enum
from typing import NamedTuple

from axistwin.controllers.diagnostics import Rule
from axistwin.controllers.digiplan.chapters.data_format import Frame, MessageFormat
from axistwin.controllers.digiplan.chapters.data_transfer import InputBuffer, Transmitter
from axistwin.controllers.digiplan.chapters.faults import Faults, MotionFault, StopInputs
from axistwin.controllers.digiplan.chapters.motion import RampGenerator
from axistwin.controllers.digiplan.chapters.outputs import Outputs
from axistwin.controllers.digiplan.options import Options
from axistwin.controllers.digiplan.step import RAMP_SETTINGS, Parameters, Step
from axistwin.controllers.digiplan.work import Work
from axistwin.controllers.product import ControlLines, Refusal, Store
from axistwin.core.units import to_ns
from axistwin.plant.stepper import StepperAxis
from axistwin.sim.clock import Clock, Procedure
from axistwin.sim.pins import Pin
from axistwin.sim.serial import Uart


class Stage(Enum):
    """Stage of the initialisation: RESET --1 s--> WAIT --"("--> FORMAT --"U61<CR>"--> READY."""

    RESET = "self-test"
    WAIT = "waiting for ("
    FORMAT = "waiting for the data format"
    READY = "ready"


class Hardware(NamedTuple):
    """Components of an interface card that exist even while its power is off, e.g. its terminals."""

    clock: Clock
    uart: Uart
    lines: ControlLines
    pins: Mapping[str, Pin]
    outputs: Outputs
    axes: Mapping[str, StepperAxis]
    options: Options
    store: Store


class State(ABC):
    """State of an IF1 or IF2 while the power is on: components, settings and status."""

    def __init__(self, card: Hardware) -> None:
        clock, uart, lines, pins, options = card.clock, card.uart, card.lines, card.pins, card.options
        self.clock, self.uart, self.lines, self.pins = clock, uart, lines, pins
        self.outputs, self.options, self.store = card.outputs, options, card.store
        self.stage = Stage.RESET
        self.frame, self.baudrate, self.locked = Frame(), 0, False
        self.lock: MessageFormat | None = None
        self.eighth: tuple[bool, ...] = ()  # Bit 8 of each character of the message in progress, terminator included.
        self.ignored: tuple[int, ...] = ()  # Characters that are ignored if received next.
        self.parameters = Parameters()
        self.sequence = ""
        self.step_number = 0  # Number of the latest step of a sequence that has begun, as O reports it.
        self.step = 0  # Number of the present step of the running sequence; 0 if no sequence runs.
        self.ended_by = MotionFault.NONE  # The faults that have ended the latest sequence before its last step.
        self.on_step: Callable[[int], None] = lambda number: None
        self.waiting: Step | None = None  # The step that waits for inputs.
        self.hint = ""  # Reason why the host's characters are dropped before the stage READY, and the remedy.
        self.on_hint: Callable[[str], None] = lambda hint: None
        self.on_refusal: Callable[[Refusal], None] = lambda refusal: None
        """Function that is called with each message of the host that is not carried out."""
        self.begun = ""  # Text of the message that has begun the present move.
        self._ramp_before: Parameters | None = None  # Parameters before new ramp data, until the ramp is calculated.
        self._muted_until_ns = 0
        self.motion = RampGenerator(clock, card.axes, pins)
        self.faults = Faults(pins, self._show_fault)
        self.buffer = InputBuffer(clock, uart, to_ns(options.strobe_ms / 1000))
        self.transmitter = Transmitter(clock, uart, lines)
        self.work = Work(clock, self.motion, self._calculate_new_ramp)
        self.stops = StopInputs(self.faults, self.motion, self.work.cancel, options.limits)
        self.buffer.on_fault = self.faults.raise_line

    @abstractmethod
    def set_locked(self, locked: bool) -> None:
        """Lock or unlock the communication with the host, and update the battery-backed memory."""

    @abstractmethod
    def erase(self) -> None: ...

    def drop(self, hint: str) -> None:
        """Report the reason for dropping characters of the host, unless that reason was reported last."""
        if hint != self.hint:
            self.hint = hint
            self.on_hint(hint)

    def refuse(self, text: str, why: str = "", rule: Rule | None = None) -> None:
        self.on_refusal(Refusal(text.encode("latin-1"), why, rule))

    def transmit(self, data: bytes) -> Procedure:
        """Send `data`, and wait until transmission of its last character begins."""
        yield from self.transmitter.send(data) or ()

    @property
    def message_format(self) -> MessageFormat:
        """Serial format of the host's latest message, e.g. its baud rate and parity."""
        bytesize, parity, _ = self.frame.uart
        return MessageFormat(self.baudrate, bytesize, parity, (any(self.eighth[:-1]), *self.eighth[-1:]))

    def _show_fault(self, on: bool) -> None:
        if self.stage is Stage.READY:
            self.pins["led"].set(on)

    def set_parameters(self, step: Step) -> None:
        """Store the values of a direct message; new ramp data take effect when no work is in progress."""
        before, self.parameters = self.parameters, self.parameters.after(step)
        self.transmitter.delay = self.parameters.character_delay
        if RAMP_SETTINGS & step.settings.keys():
            if not (self.work.occupied or self.motion.running):
                self.calculate_ramp()
            elif self._ramp_before is None:
                self._ramp_before = before

    @property
    def in_force(self) -> Parameters:
        """Parameters of a move that begins now; new ramp data apply only after the ramp's calculation."""
        before = self._ramp_before
        if before is None:
            return self.parameters
        return replace(self.parameters, **{name: getattr(before, name) for name in RAMP_SETTINGS})

    def calculate_ramp(self) -> None:
        """Begin to calculate the ramp; the interface processes no characters for up to a second."""
        self._ramp_before = None
        self._muted_until_ns = self.clock.now + to_ns(self.options.recalculation_s)

    def _calculate_new_ramp(self) -> None:
        if self._ramp_before is not None and not self.motion.running:
            self.calculate_ramp()

    @property
    def muted(self) -> bool:
        """True while the interface calculates a ramp and therefore processes no characters."""
        return self._muted_until_ns > self.clock.now

    def until_unmuted(self) -> Procedure:
        if self.muted:
            yield self.clock.timeout(self._muted_until_ns - self.clock.now)
