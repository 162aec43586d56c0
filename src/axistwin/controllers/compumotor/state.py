"""The state of a board with its power on, and the primitives that all chapters use.

Each field is a part with its own state.  The chapters read and change the parts; the dispatcher (`board`) calls the
chapters.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from axistwin.controllers.commandset import CommandSet
from axistwin.controllers.compumotor.language import Accept, Opcode
from axistwin.controllers.compumotor.options import Options
from axistwin.controllers.compumotor.parts.events import Events, Happening
from axistwin.controllers.compumotor.parts.joystick import Joystick, Shutdown
from axistwin.controllers.compumotor.parts.library import HomeDefinition, Library, Motion, Move
from axistwin.controllers.compumotor.parts.limits import Limits
from axistwin.controllers.compumotor.parts.outputs import Outputs
from axistwin.controllers.compumotor.parts.owner import Owner
from axistwin.controllers.compumotor.parts.profiles import Speed
from axistwin.controllers.compumotor.parts.pulses import Phase, PulseGenerator
from axistwin.controllers.compumotor.parts.sequences import Sequencer, Sequences
from axistwin.controllers.compumotor.parts.stream import Stream
from axistwin.controllers.compumotor.parts.tracking import Encoder, Tracking
from axistwin.controllers.compumotor.parts.triggers import Triggers
from axistwin.controllers.compumotor.registers import Handshake
from axistwin.controllers.product import Refusal
from axistwin.core.units import MS, US
from axistwin.plant.stepper import StepperAxis
from axistwin.sim.clock import Clock, Event, Procedure
from axistwin.sim.pins import Pin
from axistwin.sim.registers import RegisterPort

INDEXER = 0x50  # Indexer mode, the mode after reset.  The code of a mode is the opcode that enters it.
_SINGULAR_IN_INDEXER_MODE = Accept.SINGULAR | Accept.INDEXER
IN_MOTION = (
    "the motor is moving, or the joystick is enabled: wait until 88h reports rest, or send 10 (disable joystick)"
)
SHUT_DOWN = "the motor is shut down: send 12 00 first, or end the signal at the shutdown input"
IN_DEADBAND = 0x80  # State code for 0Fh: the closed-loop error is within the deadband.


class State(ABC):
    """State of an 1810 or 1811 whose power is on.  The state consists of parts such as the pulse generator."""

    def __init__(
        self, clock: Clock, commands: CommandSet, port: RegisterPort, pins: Mapping[str, Pin], axis: StepperAxis,
        options: Options, *, encoder: bool,
    ) -> None:  # fmt: skip
        """`encoder` is True for an 1811, which has an encoder interface."""
        self.clock, self.commands, self.options, self.pins = clock, commands, options, pins
        self.start_ns, self.step_ns = ns(options.start_ms), ns(options.step_ms)
        self.alive = True  # False during the test function and after a failure: no commands are performed.
        self.busy_until_ns = 0
        self.on_refusal: Callable[[Refusal], None] = lambda refusal: None
        """Function that is called with each command of the host that the board ignores."""
        self.handshake = Handshake(clock, port, pins, options)
        self.pulses = PulseGenerator(clock, axis, pins["direction"])
        self.limits = Limits(clock, self.pulses, pins["cw_limit"], pins["ccw_limit"], ns(options.limit_us, US))
        self.library, self.motion = Library(clock, ns(options.calculation_ms)), Motion()
        self.start_stop = 0
        self.zero = self.home = 0  # Absolute zero and HOME, in the pulse generator's count.
        self.home_definition: HomeDefinition | None = None
        self.sequences, self.sequencer = Sequences(options.buffer_bytes), Sequencer(clock)
        self.stream = Stream(clock, options.buffer_bytes, self.send, self.refresh)
        self.host, self.sequence = Owner(clock), Owner(clock)  # Sources of commands, each with a SINGULAR one.
        self.events = Events(self.send)
        self.triggers = Triggers(
            clock,
            {1: pins["trigger1"], 6: pins["trigger6"]},
            {
                1: ns(max(options.trigger1_us, options.trigger1_hold_us), US),
                6: ns(max(options.trigger6_us, options.trigger6_hold_us), US),
            },
        )
        self.joystick = Joystick(pins, self.pulses)
        self.shutdown = Shutdown(pins, self.pulses, self.joystick)
        performed = encoder or options.encoder_commands == "performed"
        self.loop = Tracking(self.pulses, Encoder(axis if encoder else None, options.invert_encoder), moves=performed)
        self.outputs = Outputs(pins, self.handshake, {
            0x01: lambda: self.moving,
            0x02: lambda: self.host.busy or self.sequence.busy,
            0x03: lambda: self.sequencer.running,
            0x04: lambda: self.stream.performing,
            0x05: lambda: self.pulses.phase is Phase.ACCELERATING,
            0x06: lambda: self.pulses.phase is Phase.DECELERATING,
            0x07: lambda: self.pulses.phase is Phase.CONSTANT,
            IN_DEADBAND: lambda: self.loop.in_deadband,
            0x81: lambda: pins["remote_enable"].level,
        })  # fmt: skip

    @abstractmethod
    def refresh(self) -> None: ...

    @abstractmethod
    def begin_test(self) -> None:
        """Stop all commands and begin the test function (FFh)."""

    @abstractmethod
    def fail(self) -> None:
        """Raise the board monitor alarm."""

    def occupy(self, duration_ns: int) -> Event:
        """Keep the processor busy for `duration_ns`.  Return an event that occurs when this time has elapsed."""
        self.busy_until_ns = max(self.busy_until_ns, self.clock.now + duration_ns)
        return self.clock.timeout(duration_ns)

    def send(self, opcode: int, data: bytes) -> None:
        """Send a message to the host: an opcode, followed by `data`."""
        self.handshake.send(bytes([opcode]) + data)

    def excludes(self, command: Opcode) -> bool:
        """True if `command` must wait for the host's SINGULAR command: if it is a move, a search or the joystick."""
        return self.host.busy and _SINGULAR_IN_INDEXER_MODE in command.accepted

    def carry_out(self, command: Opcode, values: tuple[Any, ...], owner: Owner, data: bytes = b"") -> Procedure:
        """Perform a command; one that takes time continues in a process.  `data`: the command string of the host."""
        assert command.handler is not None
        result = command.handler(self, *values)
        if isinstance(result, bytes):
            yield self.occupy(ns(self.options.reply_ms))
            self.send(command.opcode, result)
        elif isinstance(result, str):
            self.refuse(data, result)
        elif result is not None:
            owner.begin(result, partial(self._ended, data))
            self.refresh()

    def _ended(self, data: bytes, why: str | None) -> None:
        if why is not None:
            self.refuse(data, why)
        self.refresh()

    def refuse(self, data: bytes, why: str = "") -> None:
        """Report a command of the host that the board ignores.  `why`: as in `Refusal`."""
        if data:
            self.on_refusal(Refusal(data, why))

    def begin_move(self, move: Move, speed: Speed, end: int | None) -> None:
        """Record the start of a move.  `end`: end position of a preset move, in the pulse generator's count."""
        sign = -1 if end is not None and end < self.pulses.position else +1
        self.motion = Motion(move, speed, end, self.motion.begun + 1, sign)
        self.events.happened(Happening.START, self.motion.begun)

    def blocked(self, sign: int) -> bool:
        """True if a limit or the shutdown prevents motion in the direction `sign`, +1 or -1."""
        return self.shutdown.on or self.limits.blocks(sign)

    @property
    def mode(self) -> int:
        """Present mode, given as the opcode of its command, e.g. 51h."""
        return self.stream.setting.mode if self.stream.setting else INDEXER

    @property
    def in_streaming_mode(self) -> bool:
        """True in the streaming modes 51h, 52h and 53h."""
        return self.stream.setting is not None

    @property
    def moving(self) -> bool:
        return self.pulses.moving or self.joystick.moving

    @property
    def occupied(self) -> bool:
        return self.moving or self.joystick.enabled

    @property
    def step_level(self) -> bool:
        """Level of the STEP output: that of STEP IN while the joystick is enabled; high impedance after a failure."""
        if self.handshake.failed:
            return self.options.high_impedance
        return self.pins["step_in"].level if self.joystick.enabled else self.pulses.step_level

    def steps(self, side: int) -> bool:
        """True while the board outputs a STEP pulse on the side CW (+1) or CCW (-1)."""
        return not self.handshake.failed and self.pulses.physical == side and self.step_level

    @property
    def absolute(self) -> int:
        """Position from absolute zero, in pulses."""
        return self.pulses.position - self.zero


def ns(amount: float, unit_ns: int = MS) -> int:
    return round(amount * unit_ns)
