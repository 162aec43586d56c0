"""The dispatcher of the motor's processor: power-up, commands, the stored program and the kernel's events.

The kernel does the work of each sample, and `core.py` runs it ahead of the clock.  This module handles each event at
exactly the sample in which it occurs.
"""

from array import array
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

from axistwin.controllers.product import Refusal, Store
from axistwin.controllers.smartmotor.chapters import brakes, faults, flow, host_mode, io, limits, modes
from axistwin.controllers.smartmotor.chapters.faults import LATCHED
from axistwin.controllers.smartmotor.chapters.functions import CLEAR_INTEGRAL
from axistwin.controllers.smartmotor.chapters.inputs import Inputs
from axistwin.controllers.smartmotor.kernel import kernel
from axistwin.controllers.smartmotor.kernel import physics as machine
from axistwin.controllers.smartmotor.kernel import state as s
from axistwin.controllers.smartmotor.kernel.interpreter import CALL_C2, HIGHEST, LOWEST
from axistwin.controllers.smartmotor.kernel.physics import MACHINE
from axistwin.controllers.smartmotor.kernel.servo_law import clear_integral
from axistwin.controllers.smartmotor.language.language import Statement, command
from axistwin.controllers.smartmotor.language.program import Compilation, Program
from axistwin.controllers.smartmotor.options import Options
from axistwin.controllers.smartmotor.processor import Processor
from axistwin.controllers.smartmotor.serial import program_store
from axistwin.controllers.smartmotor.serial.channel import CLOCK, DIRECT_A, DIRECT_P, DIRECT_V, POSITION, Channel
from axistwin.controllers.smartmotor.terminals import IndexLine
from axistwin.core.units import to_ns
from axistwin.plant.servo_axis import IDEAL_COUNTS_PER_REV, ServoAxis
from axistwin.sim.pins import Pin, UserPin
from axistwin.sim.serial import Uart

DEFAULTS = {
    s.E: 1000, s.AMPS: 1023, s.TH: 70, s.THD: 12_000, s.MFMUL: 1, s.MFDIV: 1, s.PID_RATE: 1, s.MODE: s.M_BRAKE, s.BO: 1,
    s.BUFFERED_MODE: s.M_POSITION, s.DIRECTION: 1, s.RESOLUTION: 4, s.LIMIT_C: 1, s.LIMIT_D: 1, s.GO_PIN: 1,
    s.INDEX_ARMED: 1, s.MC_BASE: 1, s.MC_SIZE: 1, s.MC_FACTOR: 1,
}  # fmt: skip
"""Power-on values of parameters, if they are not 0 (chapter 2, and 16 of the base language)."""
IDEAL_TUNING = (42, 28, 550, 15, 1, 0, 0, 0)  # KP … KG of a motor without a data sheet.
UNPOWERED = s.LIMIT_C, s.LIMIT_D, s.SOFT_LIMITS, s.BT, s.VELOCITY, s.STOPPING, s.MASTER_LEFT, s.PWM, s.PENDING
INPUT_2 = 2  # The label that pin G calls with F=64.
RECORD_HANDLERS: Mapping[int, Callable[[Processor, int], None]] = {
    POSITION: host_mode.position,
    CLOCK: host_mode.clock,
    DIRECT_A: partial(modes.parameter, slot=s.A, low=0, high=HIGHEST),  # as A=exp
    DIRECT_V: partial(modes.parameter, slot=s.V, low=LOWEST, high=HIGHEST),  # as V=exp
    DIRECT_P: modes.position,
}
"""The function that receives the value of each kind of binary record."""


@dataclass(frozen=True)
class Fittings:
    """The parts connected to the processor; these also exist without power."""

    axis: ServoAxis
    index: IndexLine
    brake: Pin
    user_pins: Mapping[str, UserPin]
    uarts: tuple[Uart, Uart]
    store: Store
    machine: list[int]  # The integers of the physics that outlive the power (`servo.MACHINE`).


class Motor(Processor):
    """Executes commands and statements, and handles the events of the kernel."""

    def __init__(self, fittings: Fittings, options: Options, restart: Callable[[], None]) -> None:
        super().__init__(fittings.axis, fittings.user_pins, fittings.brake, fittings.uarts, fittings.store, options)
        self._fittings, self._restart = fittings, restart
        self.on_program: Callable[[Program], Program] = lambda program: program
        """Function that is called with each new program; it returns the program with the needed announcements."""
        self.on_statement: Callable[[int], None] = lambda number: None
        """Function that is called with the number of an announced statement before its execution."""
        self._compilation: Compilation | None = None
        self._program = Program.compile("")
        self._set_defaults()
        self._take_machine()
        self._inputs = Inputs(self)
        self.axis.connect(self._inputs)
        program_store.power_up(self)
        self.update_outputs()
        self.core.replan()
        self.clock.call_later(to_ns(options.boot_window_s), self._boot)

    def execute(self, channel: Channel, text: str) -> None:
        statement = command(text)
        self.catch_up(changing=not statement.read_only)
        self.host = channel
        self._perform(statement)
        self.host = None
        if self.why_refused is not None:
            why, self.why_refused = self.why_refused, None
            self.report_refused(channel, text, why)
        if not statement.read_only:
            self.update_outputs()

    def report_refused(self, channel: Channel, text: str, why: str) -> None:
        self.on_refused_command(Refusal(text.encode("ascii", "replace"), why, channel=channel.number))

    def execute_record(self, code: int, value: int) -> None:
        """Execute a binary command, e.g. the acceleration A; `code`: a key of `RECORD_HANDLERS`."""
        self.catch_up()
        RECORD_HANDLERS[code](self, value)
        self.update_outputs()

    def end_host_mode(self) -> None:
        self.i[s.HOST_FLAGS] |= host_mode.UNDERFLOW
        brakes.switch_off(self, s.M_ERROR)

    def report_host_mode(self, channel: Channel) -> None:
        """Answer the byte 0xF9 with the status of host mode."""
        self.catch_up()
        channel.send(host_mode.status(self))

    def reset(self) -> None:
        """Z: restart the motor as at power-up."""
        self._restart()

    @property
    def program(self) -> Program:
        """The motor's stored user program, in compiled form.  A compilation in progress is completed first."""
        if self._compilation is not None:
            self._compiled(self._compilation.result())
        return self._program

    def set_program(self, text: str) -> None:
        """End the running program, and replace it; a long text is compiled in short steps, in this nanosecond."""
        flow.end(self)
        self._compilation = Compilation(text)
        self._compile(self._compilation)

    def _compile(self, compilation: Compilation) -> None:
        if compilation is not self._compilation:
            return  # Nothing to do: the program is already compiled, or a newer program has been stored.
        if compilation.step():
            self._compiled(compilation.result())
        else:
            self.clock.call_later(0, partial(self._compile, compilation))

    def _compiled(self, program: Program) -> None:
        self._compilation = None
        self.use(self.on_program(program))

    def use(self, program: Program) -> None:
        """Replace the compiled program in the memory.  The place in a running program does not change."""
        self._program = program
        self.i[s.C2_PLACE] = program.labels.get(INPUT_2, -1)
        self.core.code = array("q", program.code)

    def update_outputs(self) -> None:
        """Set the brake, the windings and the output signals according to the present state of the motor."""
        if self.powered:
            brakes.update_outputs(self)
            limits.update_flags(self)

    def power_off(self) -> None:
        """Switch the power off, and let the shaft coast to rest.  Commands, program and protection stop."""
        self.catch_up()
        self._inputs.close()
        for channel in self.channels:
            channel.close()
        flow.end(self)
        self.powered = False
        i = self.i
        i[s.MODE], i[s.DRIVE], i[s.BRAKE], i[s.BO] = s.NO_POWER, s.DRIVE_OPEN, self.options.brake, 1
        for slot in (*UNPOWERED, *LATCHED):
            # While the power is off, no fault is reported.
            i[slot] = slot in LATCHED

    def leave(self) -> None:
        """Save the physical state of the motor, e.g. speed and temperatures, for the next power-up."""
        self.catch_up()
        self.core.stop()
        self.axis.f, self.axis.shaft = list(self.f), self.i[s.SHAFT] + self.i[s.SLIPPED]
        self.axis.energy_nj = self.i[s.ENERGY]
        self._fittings.machine[:] = [self.i[slot] for slot in MACHINE]
        self.axis.disconnect()

    def _set_defaults(self) -> None:
        i, options = self.i, self.options
        for slot, value in DEFAULTS.items():
            i[slot] = value
        i[s.STATEMENTS_PER_SAMPLE], i[s.DEBOUNCE] = options.statements_per_sample, options.debounce_samples
        i[s.CAM_TABLE] = options.cam_multiplier == "table"
        i[s.ARRAY_BASE] = s.DOUBLES if options.array_overlay else s.ALONE

    def _take_machine(self) -> None:
        """Set up motor and load; the shaft's present position becomes 0."""
        i, axis = self.i, self.axis
        i[s.COUNTS_PER_REV] = IDEAL_COUNTS_PER_REV
        machine.fit(i, self.f, axis.motor, axis.load_data)
        # After a short power-off, the shaft may still turn, and the motor may still be hot.
        if axis.f:
            self.f[:] = array("d", axis.f)
            for slot, value in zip(MACHINE, self._fittings.machine, strict=True):
                i[slot] = value
        i[s.SHAFT], i[s.ORIGIN] = axis.shaft, -axis.shaft
        i[s.ENERGY] = axis.energy_nj
        i[s.KP : s.KP + 8] = array("q", axis.motor.tuning if axis.motor else IDEAL_TUNING)
        modes.tune(self)
        turn = i[s.COUNTS_PER_REV]
        i[s.INDEX_LOW] = (axis.shaft - self.options.index_at) // turn * turn + self.options.index_at
        i[s.INDEX_HIGH] = i[s.INDEX_LOW] + turn

    def _boot(self) -> None:
        """Start the stored program, unless a character has been received since power-up."""
        if self.powered and not any(channel.received for channel in self.channels):
            self.catch_up()
            flow.begin(self)
            self.update_outputs()

    def _act(self, why: int) -> None:
        if not self.powered:
            if why & kernel.SWITCH:
                self._inputs.switches()
            return
        for reasons, handle in _EVENTS:
            if why & reasons:
                handle(self, why)
        self.update_outputs()

    def _perform(self, statement: Statement) -> None:
        answer = statement.perform(self)
        if self.i[s.BRAKE_READ]:
            io.give_up_brake_pin(self)
        if answer is not None:
            self.send(answer.encode("ascii") + b"\r")

    def _fetch(self, number: int) -> None:
        """Fetch the external values of a statement, or announce the statement (a negative number)."""
        if number >= 0:
            self.program.statements[number].fetch(self)
            return
        self.i[s.STATEMENT] = ~number
        self.on_statement(~number)

    def _call(self) -> None:
        """Call C1 or C2 at the end of a statement; if both calls are pending, C2 is not called (table 7.1)."""
        pending, self.i[s.PENDING] = self.i[s.PENDING], 0
        if pending & s.CALL_FAULT:
            if not flow.call(self, faults.FAULT_1, s.CALL_FAULT) and (self.i[s.BE] or self.i[s.BH]):
                flow.end(self)  # A fault ends the program if the fault subroutine C1 cannot be called.
        elif pending & s.CALL_INPUT:
            flow.call(self, INPUT_2, s.CALL_INPUT)

    def _go_edge(self) -> None:
        """Handle a falling edge of pin G.  The edge performs G if the pin is the go input, and calls C2 with F=64."""
        i = self.i
        if i[s.GO_PIN] and not self.pins["G"].is_output:
            modes.go(self)
        if not i[s.F] & CALL_C2 or INPUT_2 not in self.program.labels or flow.within(self, s.CALL_INPUT):
            return
        i[s.PENDING] |= s.CALL_INPUT
        # End a WAIT command in progress, so that the call of the subroutine C2 is not delayed.
        i[s.WAIT_UNTIL] = 0

    def _trajectory(self) -> None:
        if self.i[s.BT]:
            return
        if self.i[s.F] & CLEAR_INTEGRAL:
            clear_integral(self.i)
        if self.i[s.STOPPING]:
            faults.stopped(self)


_EVENTS: tuple[tuple[int, Callable[[Motor, int], None]], ...] = (
    (kernel.STATEMENT_WAITS, lambda motor, _: motor._perform(motor.program.statements[motor.i[s.STATEMENT]])),
    (kernel.VALUE_WAITS, lambda motor, _: motor._fetch(motor.i[s.STATEMENT])),
    (kernel.CALL_WAITS, lambda motor, _: motor._call()),
    (kernel.HOST_LAST, lambda motor, _: host_mode.complete(motor)),
    (kernel.HOST_UNDERFLOW, lambda motor, _: motor.end_host_mode()),
    (kernel.HOST_EXIT, lambda motor, _: modes.start(motor, motor.i[s.BUFFERED_MODE])),
    (kernel.SWITCH, lambda motor, _: motor._inputs.switches()),
    (kernel.PLUS | kernel.MINUS | kernel.ERROR | kernel.HEAT, faults.happen),
    (kernel.GO_EDGE, lambda motor, _: motor._go_edge()),
    (kernel.PIN_TAKEN, lambda motor, _: io.give_up_brake_pin(motor)),
    (kernel.TRAJECTORY, lambda motor, _: motor._trajectory()),
    (kernel.INDEX_MARK, lambda motor, _: motor._fittings.index.show()),
)
"""Reasons of the kernel for a stop, each with its handler, in the order of handling."""
