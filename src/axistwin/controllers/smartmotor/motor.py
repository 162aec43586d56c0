"""The motor's processor with its power on: it hears, obeys, runs its program and moves.

Everything per sample is the kernel's, which `core.py` runs ahead of the clock; here is what follows from an event, at
the very sample in which it happens.
"""

from array import array
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

from axistwin.controllers.product import Store
from axistwin.controllers.smartmotor.chapters import brakes, faults, flow, io, limits, modes
from axistwin.controllers.smartmotor.chapters.brakes import Control
from axistwin.controllers.smartmotor.chapters.faults import LATCHED
from axistwin.controllers.smartmotor.chapters.functions import CALL_C2, CHANNEL_1, CLEAR_INTEGRAL
from axistwin.controllers.smartmotor.chapters.inputs import IndexLine, Inputs
from axistwin.controllers.smartmotor.chapters.nonvolatile import Nonvolatile
from axistwin.controllers.smartmotor.kernel import host_mode, machine
from axistwin.controllers.smartmotor.kernel.core import Core
from axistwin.controllers.smartmotor.kernel.host_mode import Reception
from axistwin.controllers.smartmotor.kernel.kernel import (
    CALL_WAITS,
    ERROR,
    GO_EDGE,
    HEAT,
    HOST_EXIT,
    HOST_LAST,
    HOST_UNDERFLOW,
    INDEX_MARK,
    MINUS,
    PIN_TAKEN,
    PLUS,
    STATEMENT_WAITS,
    SWITCH,
    TRAJECTORY,
    VALUE_WAITS,
)
from axistwin.controllers.smartmotor.kernel.machine import MACHINE
from axistwin.controllers.smartmotor.kernel.position import actual_position
from axistwin.controllers.smartmotor.kernel.servo_law import clear_integral
from axistwin.controllers.smartmotor.kernel.state import (
    ALONE,
    AMPS,
    ARRAY_BASE,
    BC,
    BE,
    BH,
    BI,
    BLOCKED,
    BO,
    BRAKE,
    BRAKE_READ,
    BS,
    BT,
    BUFFERED_MODE,
    BX,
    CALL_FAULT,
    CALL_INPUT,
    CAM_TABLE,
    COUNTS_PER_REV,
    DEBOUNCE,
    DIRECTION,
    DOUBLES,
    DRIVE,
    DRIVE_OPEN,
    GO_PIN,
    INDEX,
    INDEX_ARMED,
    INDEX_FORCED,
    INDEX_HIGH,
    INDEX_LOW,
    KP,
    LIMIT_C,
    LIMIT_D,
    M_BRAKE,
    M_ERROR,
    M_POSITION,
    MASTER_LEFT,
    MC_BASE,
    MC_FACTOR,
    MC_SIZE,
    MFDIV,
    MFMUL,
    MODE,
    NO_POWER,
    NOTHING_YET,
    ORIGIN,
    PENDING,
    PID_RATE,
    PROGRAM,
    PWM,
    RESOLUTION,
    RUNNING,
    SHAFT,
    SLIPPED,
    SOFT_LIMITS,
    STATEMENT,
    STATEMENTS_PER_SAMPLE,
    STOPPING,
    TH,
    THD,
    VELOCITY,
    WAIT_UNTIL,
    WATCH_INDEX,
    E,
    F,
)
from axistwin.controllers.smartmotor.language.language import Statement, command
from axistwin.controllers.smartmotor.language.program import Compilation, Program
from axistwin.controllers.smartmotor.options import Options
from axistwin.controllers.smartmotor.serial import program_store
from axistwin.controllers.smartmotor.serial.channel import Channel, ChannelError
from axistwin.plant.servo_axis import IDEAL_COUNTS_PER_REV, ServoAxis
from axistwin.sim.clock import Clock
from axistwin.sim.pins import Pin, UserPin
from axistwin.sim.serial import Uart
from axistwin.units import to_ns

DEFAULTS = {
    E: 1000, AMPS: 1023, TH: 70, THD: 12_000, MFMUL: 1, MFDIV: 1, PID_RATE: 1, BUFFERED_MODE: M_POSITION, MODE: M_BRAKE,
    BO: 1, DIRECTION: 1, RESOLUTION: 4, LIMIT_C: 1, LIMIT_D: 1, GO_PIN: 1, INDEX_ARMED: 1, MC_BASE: 1, MC_SIZE: 1,
    MC_FACTOR: 1,
}  # fmt: skip
"""Power-on values that are not 0 (chapter 2, and 16 of the base language)."""
IDEAL_TUNING = (42, 28, 550, 15, 1, 0, 0, 0)
"""What a motor without a data sheet reports for KP … KG."""
UNPOWERED = LIMIT_C, LIMIT_D, SOFT_LIMITS, BT, VELOCITY, STOPPING, MASTER_LEFT, PWM, PENDING
"""What is nothing without power."""
INPUT_2 = 2
"""The label that pin G calls with F=64."""


@dataclass(frozen=True)
class Fittings:
    """What the processor is soldered to; it is there without power, too."""

    clock: Clock
    axis: ServoAxis
    pins: Mapping[str, Pin]
    index: IndexLine
    user_pins: Mapping[str, UserPin]
    uarts: tuple[Uart, Uart]
    store: Store
    machine: list[int]
    """The integers of the physics that outlive the power (`servo.MACHINE`)."""


class Motor:
    """A SmartMotor that has its power on."""

    def __init__(self, fittings: Fittings, options: Options, restart: Callable[[], None]) -> None:
        self.clock, self.options, self.store = fittings.clock, options, fittings.store
        self.axis, self.pins, self._fittings = fittings.axis, fittings.user_pins, fittings
        self.brake_line, self.index_line = fittings.pins["brake"], fittings.index
        self.core = Core(self.clock, self._act, options.host_buffer)
        self.i, self.v, self.f, self.ring = self.core.i, self.core.v, self.core.f, self.core.ring
        self.reception = Reception()
        self.brake_control, self.mtb_enabled = Control.SERVO, True
        self.reset, self.powered = restart, True
        self.refused = False
        """Whether a movement has been refused because of a fault."""
        self.on_fault: Callable[[str], None] = lambda name: None
        """Told of each fault of table 4.1 when it happens, by the name of its flag."""
        self.on_program: Callable[[Program], Program] = lambda program: program
        """Asked which statements a program is to announce, when it comes into the memory."""
        self.on_statement: Callable[[int], None] = lambda number: None
        """Told of such a statement before it is carried out."""
        self.statement_before = NOTHING_YET
        """The one that it was told of last, since the program was started."""
        self._asking: Channel | None = None
        self._set_defaults()
        self._take_machine()
        self.nonvolatile = Nonvolatile.load(self.store)
        self._compilation: Compilation | None = None
        self._program = Program.compile("")
        first, second = fittings.uarts
        self.channels = Channel(self, 0, first), Channel(self, 1, second)
        self._inputs = Inputs(self)
        self.axis.connect(self._inputs)
        program_store.power_up(self)
        self.settle()
        self.core.replan()
        self.clock.call_later(to_ns(options.boot_window_s), self._start_by_itself)

    # What handlers use

    def catch_up(self) -> None:
        """Bring the state to the last sample by now; afterwards it may be changed."""
        self.core.catch_up()

    def replan(self) -> None:
        """The state has been changed; `catch_up` has seen to it that what follows is worked out anew."""
        self.settle()

    def obey(self, channel: Channel, text: str) -> None:
        """A host's command, without its terminator."""
        statement = command(text)
        self.core.catch_up(changing=not statement.looks_only)
        self._asking = channel
        self._perform(statement)
        self._asking = None
        if not statement.looks_only:
            self.settle()

    @property
    def obeys_host(self) -> bool:
        """True while a host's command is being carried out."""
        return self._asking is not None

    def say(self, data: bytes, channel: int | None = None) -> None:
        """Speak where the statement in progress speaks: to the host who asked, or to where the program's words go."""
        if self._asking is not None and channel is None:
            self._asking.say(data)
            return
        to = self.channels[(1 if self.i[F] & CHANNEL_1 else 0) if channel is None else channel]
        if self._asking is not None or not to.silent:
            to.say(data)
        if self._asking is None and to.full:
            self.i[PROGRAM] = BLOCKED
            to.when_empty(self._go_on)

    def syntax_error(self) -> None:
        """Something that is no command, or cannot be done: flag Bs, and what RCHN tells of the host's channel."""
        self.i[BS] = 1
        if self._asking is not None:
            self._asking.flag(ChannelError.SCAN)

    def overflow(self) -> None:
        """More has come than there is room for: flag Bc."""
        self.i[BC] = 1
        if self._asking is not None:
            self._asking.flag(ChannelError.OVERFLOW)

    @property
    def at_index(self) -> bool:
        """Whether the shaft stands on the encoder's index mark."""
        self.core.catch_up(changing=False)
        return bool(self.i[BX])

    def watch_index(self) -> None:
        """From now on somebody wants to be told of every change of the index line."""
        self.catch_up()
        self.i[WATCH_INDEX] = 1

    def force_index(self, on: bool, *, rising: bool) -> None:
        """Somebody holds the index line; when it goes high the position is captured as at the mark, flag Bi."""
        self.catch_up()
        i = self.i
        i[INDEX_FORCED] = on
        i[BX] |= on
        if rising and i[INDEX_ARMED]:
            i[INDEX], i[INDEX_ARMED], i[BI] = actual_position(i), 0, 1

    def edges(self) -> int:
        """Edges of the external encoder so far, exactly now."""
        return self._inputs.edges()

    @property
    def program(self) -> Program:
        """The program in the memory.  What of it has not been compiled yet is compiled now."""
        if self._compilation is not None:
            self._compiled(self._compilation.result())
        return self._program

    def set_program(self, text: str) -> None:
        """Another program is in the memory; the one that was running has ended.

        It is compiled in this nanosecond, in pieces: a long one is no single step of the simulation.
        """
        flow.end(self)
        self._compilation = Compilation(text)
        self._compile(self._compilation)

    def _compile(self, compilation: Compilation) -> None:
        if compilation is not self._compilation:
            return  # it is complete, or there is another one
        if compilation.go_on():
            self._compiled(compilation.result())
        else:
            self.clock.call_later(0, partial(self._compile, compilation))

    def _compiled(self, program: Program) -> None:
        self._compilation = None
        self.use(self.on_program(program))

    def use(self, program: Program) -> None:
        """The program is this one from now on; if it is running, its place in it is known."""
        self._program = program
        self.core.code = array("q", program.code)

    def settle(self) -> None:
        """Brake, windings and signals follow what has been done."""
        if self.powered:
            brakes.settle(self)
            limits.settle(self)

    def power_off(self) -> None:
        """The power is gone: nobody hears, obeys or protects any more; the shaft turns on by itself until it rests."""
        self.catch_up()
        self._inputs.close()
        for channel in self.channels:
            channel.close()
        flow.end(self)
        self.powered = False
        i = self.i
        i[MODE], i[DRIVE], i[BRAKE], i[BO] = NO_POWER, DRIVE_OPEN, self.options.brake, 1
        for slot in (*UNPOWERED, *LATCHED):
            i[slot] = slot in LATCHED  # no flag can rise

    def leave(self) -> None:
        """There will be another processor for this machine, which takes it as it is now."""
        self.catch_up()
        self.core.stop()
        self.axis.f, self.axis.shaft = list(self.f), self.i[SHAFT] + self.i[SLIPPED]
        self._fittings.machine[:] = [self.i[slot] for slot in MACHINE]
        self.axis.disconnect()

    # Power-up

    def _set_defaults(self) -> None:
        i, options = self.i, self.options
        for slot, value in DEFAULTS.items():
            i[slot] = value
        i[STATEMENTS_PER_SAMPLE], i[DEBOUNCE] = options.statements_per_sample, options.debounce_samples
        i[CAM_TABLE] = options.cam_multiplier == "table"
        i[ARRAY_BASE] = DOUBLES if options.array_overlay else ALONE

    def _take_machine(self) -> None:
        """Motor and load as they are; the position begins at 0 wherever the shaft is."""
        i, axis = self.i, self.axis
        i[COUNTS_PER_REV] = IDEAL_COUNTS_PER_REV
        machine.fit(i, self.f, axis.motor, axis.load_data)
        if axis.f:  # it has been running before
            self.f[:] = array("d", axis.f)
            for slot, value in zip(MACHINE, self._fittings.machine, strict=True):
                i[slot] = value
        i[SHAFT], i[ORIGIN] = axis.shaft, -axis.shaft
        i[KP : KP + 8] = array("q", axis.motor.tuning if axis.motor else IDEAL_TUNING)
        modes.tune(self)
        turn = i[COUNTS_PER_REV]
        i[INDEX_LOW] = (axis.shaft - self.options.index_at) // turn * turn + self.options.index_at
        i[INDEX_HIGH] = i[INDEX_LOW] + turn

    def _start_by_itself(self) -> None:
        """The stored program starts if nobody has spoken meanwhile."""
        if self.powered and not any(channel.heard for channel in self.channels):
            self.catch_up()
            program_store.boot(self)
            self.settle()

    # What the kernel has stopped for

    def _act(self, why: int) -> None:
        if not self.powered:
            if why & SWITCH:
                self._inputs.switches()
            return
        if why & STATEMENT_WAITS:
            self._perform(self.program.statements[self.i[STATEMENT]])
        if why & VALUE_WAITS:
            self._fetch(self.i[STATEMENT])
        if why & CALL_WAITS:
            self._call()
        if why & HOST_LAST:
            host_mode.complete(self)
        if why & HOST_UNDERFLOW:
            brakes.switch_off(self, M_ERROR)
        if why & HOST_EXIT:
            modes.start(self, self.i[BUFFERED_MODE])
        if why & SWITCH:
            self._inputs.switches()
        if why & (PLUS | MINUS | ERROR | HEAT):
            faults.happen(self, why)
        if why & GO_EDGE:
            self._go_edge()
        if why & PIN_TAKEN:
            io.give_up_brake_pin(self)
        if why & TRAJECTORY:
            self._trajectory()
        if why & INDEX_MARK:
            self.index_line.show()
        self.settle()

    def _perform(self, statement: Statement) -> None:
        answer = statement.perform(self)
        if self.i[BRAKE_READ]:
            io.give_up_brake_pin(self)
        if answer is not None:
            self.say(answer.encode("ascii") + b"\r")

    def _fetch(self, number: int) -> None:
        """A statement wants its outside values, or is announced only."""
        if number >= 0:
            self.program.statements[number].fetch(self)
            return
        self.i[STATEMENT] = ~number
        self.on_statement(~number)

    def _call(self) -> None:
        """At the end of a statement: C1 comes before C2, which then is not called at all (table 7.1)."""
        pending, self.i[PENDING] = self.i[PENDING], 0
        if pending & CALL_FAULT:
            if not flow.call(self, faults.FAULT_1, CALL_FAULT) and (self.i[BE] or self.i[BH]):
                flow.end(self)  # no room for the call: a motor protection fault ends the program all the same
        elif pending & CALL_INPUT:
            flow.call(self, INPUT_2, CALL_INPUT)

    def _go_edge(self) -> None:
        """Pin G has gone low: G, if it has that role, and C2 with F=64."""
        i = self.i
        if i[GO_PIN] and not self.pins["G"].is_output:
            modes.go(self)
        if not i[F] & CALL_C2 or INPUT_2 not in self.program.labels or flow.within(self, CALL_INPUT):
            return
        i[PENDING] |= CALL_INPUT
        i[WAIT_UNTIL] = 0  # "the only motor instruction that will be truncated"

    def _trajectory(self) -> None:
        """Bt has changed."""
        if self.i[BT]:
            return
        if self.i[F] & CLEAR_INTEGRAL:
            clear_integral(self.i)
        if self.i[STOPPING]:
            faults.stopped(self)

    def _go_on(self) -> None:
        """What was said has left: the program goes on."""
        if self.powered and self.i[PROGRAM] == BLOCKED:
            self.catch_up()
            self.i[PROGRAM] = RUNNING
