"""The interface card with its power on: characters, input edges and time in; characters, outputs and pulses out.

Three procedures run side by side: `_live` reads the input buffer character by character and obeys; `_work` carries out
a move, a run or a sequence, for as long as that takes; the `RampGenerator` gives pulses to the axes by itself.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache, partial

from simpy import Interrupt

from axistwin.controllers.commandset import Command
from axistwin.controllers.digiplan.chapters import initialise
from axistwin.controllers.digiplan.chapters.battery_backup import MessageFormat, Retained
from axistwin.controllers.digiplan.chapters.faults import CLOSED, DRIVES, LIMITS, Faults, LineFault, MotionFault
from axistwin.controllers.digiplan.chapters.initialise import State
from axistwin.controllers.digiplan.chapters.interpolation import out_of_range
from axistwin.controllers.digiplan.chapters.motion import RampGenerator
from axistwin.controllers.digiplan.chapters.outputs import Outputs
from axistwin.controllers.digiplan.chapters.sequence import perform, sequence
from axistwin.controllers.digiplan.chapters.serial_data import (
    CR,
    LF,
    Frame,
    InputBuffer,
    LinePins,
    Transmitter,
    uart_format,
)
from axistwin.controllers.digiplan.chapters.speed import too_fast
from axistwin.controllers.digiplan.commands import COMMANDS
from axistwin.controllers.digiplan.language import Accept, Message, parse
from axistwin.controllers.digiplan.options import Options
from axistwin.controllers.digiplan.step import RAMP_SETTINGS, EndOfWork, Fault, Parameters, Step
from axistwin.controllers.product import PulseAxis, Store
from axistwin.sim.clock import Clock, Event, Procedure, Process, interrupt, kill
from axistwin.sim.frames import UartFormat
from axistwin.sim.pins import Pin
from axistwin.sim.serial import LevelAt, Uart
from axistwin.units import to_ns

MOST_CHARACTERS = 2048  # of a message; 63 of the longest steps fit
LINE_FAULTS = {Fault.DATA: LineFault.DATA, Fault.RANGE: LineFault.RANGE}


@lru_cache(maxsize=512)
def read(text: str) -> Message:
    """A message of the host, read once however often it is sent."""
    return parse(text, COMMANDS)


def _asks_for_status(text: str) -> bool:
    """True if this message is a status request and nothing else."""
    message = read(text)
    return message.alone is not None and not message.problems and Accept.REQUEST in message.alone.accepted


class Interface:
    """An IF1 or IF2 that has power."""

    def __init__(
        self,
        clock: Clock,
        uart: Uart,
        lines: LinePins,
        pins: Mapping[str, Pin],
        outputs: Outputs,
        axes: Mapping[str, PulseAxis],
        options: Options,
        store: Store,
    ) -> None:
        self.clock, self.uart, self.lines, self.pins, self.options, self.store = (
            clock,
            uart,
            lines,
            pins,
            options,
            store,
        )
        self.outputs = outputs
        self._kept = Retained.recall(store)
        self.state = State.RESET
        self.frame, self.baudrate, self.locked = Frame(), 0, False
        self.lock: MessageFormat | None = None
        """Format of the lock command."""
        self.parameters = Parameters()
        self.sequence = ""
        """The stored sequence, as it was sent."""
        self.step_number = 0
        """The step that was begun last, as O tells it."""
        self.step = 0
        """The step of the sequence that is being carried out; 0: none is."""
        self.trouble = ""
        """While it is not ready: why what the host sends is dropped, and what helps."""
        self.on_trouble: Callable[[str], None] = lambda line: None
        self.on_step: Callable[[int], None] = lambda number: None
        """Told of each step when it begins."""
        self.motion = RampGenerator(clock, axes, pins)
        self.faults = Faults(pins, self._show_fault)
        self.buffer = InputBuffer(clock, uart, to_ns(options.strobe_ms / 1000))
        self.transmitter = Transmitter(clock, uart, lines)
        self.buffer.intercept = self._take_bracket
        self.buffer.on_fault = self.faults.raise_line
        self.buffer.on_full = self._tell_full
        self.buffer.on_cancel = self._cancel_at_once
        self._text: list[str] = []
        self._eighth: list[bool] = []  # bit 8 of each of them
        self._eighth_of_message: tuple[bool, ...] = ()  # of the message that is being obeyed, with its terminator
        self._swallowed: tuple[int, ...] = ()  # what the next character may be without being heard
        self._work: Process | None = None
        self._control: Event | None = None
        self._held: Process | None = None  # a message that begins once what is going on is done
        self._freed: Event | None = None
        self._turn: Event | None = None  # what waits behind that message
        self._offered: UartFormat | None = None  # the character that is coming is read in this format
        self._broken_in: UartFormat | None = None  # a `(` has come in this format
        self._leaving: frozenset[str] = frozenset()
        self._ramp_before: Parameters | None = None
        """While a new ramp is yet to be calculated: the parameters before the new ramp data."""
        self._deaf_until_ns = 0
        self._unwatch = [pins[name].subscribe(self._fault_input) for name in CLOSED]
        pins["led"].set(True)
        lines.dtr.set(True)
        self._live_process = clock.process(self._live())

    # Power

    def power_off(self) -> None:
        """Everything stops at once; an IF2 that is locked keeps what it knows."""
        for process in (self._live_process, self._held, self._work):
            if process is not None:
                kill(process)
        self.transmitter.stop()
        self.motion.stop()
        for unwatch in self._unwatch:
            unwatch()
        self.buffer.close()
        self.buffer.set_tolerant(False)
        self.uart.second_look = None
        self.save()

    def _live(self) -> Procedure:
        yield self.clock.timeout(to_ns(self.options.self_test_s))
        self.pins["led"].set(False)
        self._recall()
        if self.locked and not self.lines.dsr.level:
            self.uart.format = uart_format(self.baudrate, self.frame)
            self.buffer.open()
        else:
            self.state = State.WAIT
            yield from initialise.detect_baud_rate(self)
            yield from self._set_data_format()
        while True:
            self._become_ready()
            yield from self._obey_until_broken_in()
            yield from self._set_data_format()

    def _become_ready(self) -> None:
        self.state, self.trouble = State.READY, ""
        self._check_line()
        self.faults.show()
        if self.sequence:  # the lock has kept it
            self._begin_sequence()

    def _set_data_format(self) -> Procedure:
        """The baud rate is known: answer, and wait for the data format."""
        assert self.uart.format is not None
        self.baudrate = self.uart.format.baudrate
        self.state, self.trouble = State.FORMAT, ""
        self.buffer.checking = False
        self.buffer.set_tolerant(True)
        self.pins["led"].flash(initialise.FLASH_NS)
        yield from self.transmit(b"U\r")
        self.frame = yield from initialise.data_format(self)
        if self.uart.sending:
            yield self.uart.when_idle()
        self.uart.format = uart_format(self.baudrate, self.frame)
        self.buffer.set_tolerant(False)
        self._swallowed = (
            (LF, initialise.FALSE_CHARACTER) if self.frame.terminator == "U" else (initialise.FALSE_CHARACTER,)
        )
        if self.options.strict_format:
            self.buffer.close()
            yield self.clock.timeout(initialise.REINITIALISE_NS)
            self.buffer.open()
        if not self.locked:
            self._calculate_ramp()

    def drop(self, trouble: str) -> None:
        """What the host has sent is dropped: say why, once for each reason."""
        if trouble != self.trouble:
            self.trouble = trouble
            self.on_trouble(trouble)

    # Breaking into a locked interface

    @property
    def _can_be_broken_into(self) -> bool:
        """Locked, DSR held active by the host, and nothing in motion."""
        held = self.lines.dsr.level and not self.uart.sending
        return self.locked and held and self.state is State.READY and not self.motion.running

    def _look_for_bracket(self, low_ns: Fraction, level_at: LevelAt) -> UartFormat | None:
        """A character begins: return the default format at its baud rate, if it is a `(` and not in the own format."""
        self._offered = None
        rate = initialise.baud_rate(low_ns) if self._can_be_broken_into else None
        if rate is not None and uart_format(rate, Frame()).shape != uart_format(self.baudrate, self.frame).shape:
            other = uart_format(rate, Frame())
            seen = other.decode(level_at)
            if seen is not None and seen[0] & 0x7F == initialise.BAUD_DETECT:
                self._offered = other
        return self._offered

    def _take_bracket(self, byte: int) -> bool:
        """A character has come: return True if it was read in another format.  A `(` makes that the format."""
        other, self._offered = self._offered, None
        if other is not None and byte & 0x7F == initialise.BAUD_DETECT:
            self.uart.format = self._broken_in = other
            self.buffer.begin_with(initialise.BAUD_DETECT)
        return other is not None

    def _obey_until_broken_in(self) -> Procedure:
        """Obey until a `(` begins the initialisation again."""
        while True:
            yield from self._until_heard_again()
            character = self.buffer.take()
            if character is None:
                yield self.buffer.arrival()
            elif character & 0x7F == initialise.BAUD_DETECT and (self._broken_in or self._can_be_broken_into):
                yield from self._begin_again()
                return
            elif (procedure := self._hear(character)) is not None:
                yield from procedure

    def _begin_again(self) -> Procedure:
        """What is going on ends, and the data format is that of `(` again."""
        self.uart.format, self._broken_in = self._broken_in or uart_format(self.baudrate, Frame()), None
        self._text.clear()
        self._eighth.clear()
        self.cancel()
        yield self.clock.timeout(0)  # by then it has ended

    # Battery backup

    def _recall(self) -> None:
        kept = self._kept
        if kept.locked:
            self.locked, self.baudrate, self.frame, self.lock = True, kept.baudrate, kept.frame, kept.lock
            self.parameters, self.sequence = kept.parameters, kept.sequence
            self.transmitter.delay = self.parameters.character_delay

    def save(self) -> None:
        """Only what is locked is kept; a power cut during initialisation leaves it as it was."""
        if self.locked and self.state is State.READY:
            Retained(True, self.baudrate, self.frame, self.parameters, self.sequence, self.lock).save(self.store)

    @property
    def message_format(self) -> MessageFormat:
        """Format of the message that is being obeyed."""
        return MessageFormat.of(uart_format(self.baudrate, self.frame), self._eighth_of_message)

    def set_locked(self, locked: bool) -> None:
        """Commands [ and ]."""
        self.locked, self.lock = locked, self.message_format if locked else None
        self._check_line()
        if locked:
            self.save()
        else:
            Retained().save(self.store)

    def _check_line(self) -> None:
        """While locked, errors are not flagged and a `(` is looked for at any baud rate."""
        self.buffer.checking = not self.locked
        self.uart.second_look = self._look_for_bracket if self.locked else None

    def erase(self) -> None:
        """Command * during initialisation: parameters, sequence and lock are gone."""
        self.locked, self.lock, self.parameters, self.sequence = False, None, Parameters(), ""
        self.transmitter.delay = 0
        Retained().save(self.store)

    @property
    def kept_sequence(self) -> str:
        """The sequence in the memory, also while the self-test is going on; empty: none is."""
        return self._kept.sequence if self.state is State.RESET else self.sequence

    # Characters

    def next_character(self) -> Procedure:
        """Wait for a character; returns it."""
        while (character := self.buffer.take()) is None:
            yield self.buffer.arrival()
        return character

    def transmit(self, data: bytes) -> Procedure:
        """Send, and wait until the last character is on its way."""
        waiting = self.transmitter.send(data)
        if waiting is not None:
            yield from waiting

    def _hear(self, character: int) -> Procedure | None:
        """Process a character: echo it, and obey the message that it ends."""
        swallowed, self._swallowed = self._swallowed, ()
        if character & 0x7F in swallowed:
            return None
        if self.frame.echo:
            return self._echo(character)
        return self._collect(character)

    def _echo(self, character: int) -> Procedure:
        yield from self.transmit(bytes([self.frame.text(character)]))
        procedure = self._collect(character)
        if procedure is not None:
            yield from procedure

    def _collect(self, character: int) -> Procedure | None:
        code = character & 0x7F
        if code == self.frame.ends_message:
            text = "".join(self._text)
            self._text.clear()
            self._eighth_of_message = (*self._eighth, character > code)
            self._eighth.clear()
            return self._obey(text)
        if code not in (CR, LF) and len(self._text) <= MOST_CHARACTERS:
            self._text.append(chr(code))
            self._eighth.append(character > code)
        return None

    def _tell_full(self, full: bool) -> None:
        """The buffer is 80 % full, or below 20 % again."""
        self.lines.dtr.set(not full)
        if self.state is State.READY and self.frame.x_on_x_off:
            self.transmitter.send_flow_control(stop=full)

    # Messages

    def _obey(self, text: str) -> Procedure | None:
        if not text.strip(" "):
            return None
        message = read(text)
        if self.locked:
            return self._obey_locked(message)
        if message.alone is not None and message.alone.code == "#":
            self.cancel()
        if message.problems:
            self.faults.raise_line(LINE_FAULTS[message.problems[0].fault])
            return None
        if message.alone is not None and Accept.REQUEST in message.alone.accepted:
            return self._ask(message.alone)  # at any time
        return self._carry_out(message) if self._held is None else self._carry_out_behind(message)

    def _carry_out(self, message: Message) -> Procedure | None:
        """A message that changes something."""
        if message.alone is not None:
            return self._ask(message.alone)
        if message.steps and message.steps[0].hand_over and not message.sequence:
            return self._when_free(self._resume())
        if not message.start:
            self._keep(message.steps[0])
        elif not (self.busy and self.options.busy == "ignore"):
            return self._when_free(self._start(message))
        return None

    def _carry_out_behind(self, message: Message) -> Procedure:
        """The same, once the message that is being held has begun, unless a `#` throws both away.

        Status requests that come in behind it are answered meanwhile.
        """
        while self._held is not None:
            turn = self._turn = self._turn or self.clock.event()
            yield from self._answer_requests()
            if not turn.triggered:
                yield turn | self.buffer.arrival()
            if turn.triggered and turn.value:
                return
        yield from self._until_heard_again()
        procedure = self._carry_out(message)
        if procedure is not None:
            yield from procedure

    def _answer_requests(self) -> Procedure:
        """Process the status requests in the buffer, and leave what is between them."""
        while request := self.buffer.take_message(self.frame.ends_message, _asks_for_status):
            for character in request:
                procedure = self._hear(character)
                if procedure is not None:
                    yield from procedure

    def _obey_locked(self, message: Message) -> Procedure | None:
        """Anything but a status request and `]` is ignored without a trace."""
        if message.problems or message.alone is None or Accept.LOCKED not in message.alone.accepted:
            return None
        return self._ask(message.alone)

    def _ask(self, command: Command) -> Procedure | None:
        assert command.handler is not None
        answer = command.handler(self)
        return self.transmitter.send(answer) if isinstance(answer, bytes) else None

    def _keep(self, step: Step) -> None:
        """Parameters without `$`: they are kept, and used by the next move."""
        if self._in_range(step):
            self._settle(step)

    def _in_range(self, step: Step, moving: bool = False) -> bool:
        """Whether what is set, or the move to be begun, is possible; otherwise that is an out-of-range fault."""
        parameters = self.parameters.after(step)
        speed_is_wrong = "speed" in step.settings and too_fast(parameters)
        if speed_is_wrong or (moving and out_of_range(parameters, step)):
            self.faults.raise_line(LineFault.RANGE)
            return False
        return True

    def _settle(self, step: Step) -> None:
        before, self.parameters = self.parameters, self.parameters.after(step)
        self.transmitter.delay = self.parameters.character_delay
        if RAMP_SETTINGS & step.settings.keys():
            if not self._occupied:
                self._calculate_ramp()
            elif self._ramp_before is None:
                self._ramp_before = before

    @property
    def in_force(self) -> Parameters:
        """The parameters of a move that begins now: without ramp data whose ramp has not been calculated yet."""
        before = self._ramp_before
        if before is None:
            return self.parameters
        return replace(self.parameters, **{name: getattr(before, name) for name in RAMP_SETTINGS})

    def _calculate_ramp(self) -> None:
        """For up to a second no character is processed, answered or echoed; those that come in are kept."""
        self._ramp_before = None
        self._deaf_until_ns = self.clock.now + to_ns(self.options.recalculation_s)

    def _when_free(self, begin: Procedure) -> Procedure | None:
        """Begin it once what is going on is done; until then it is held, and status requests are answered."""
        if not self._occupied:
            return begin
        self._held = self.clock.process(self._hold(begin))
        return None

    def _hold(self, begin: Procedure) -> Procedure:
        while self._occupied:
            self._freed = self.clock.event()
            yield self._freed
        yield from self._until_heard_again()
        yield from begin
        self._let_go(cancelled=False)

    def _let_go(self, cancelled: bool) -> None:
        """Nothing is held any more."""
        self._held = None
        if self._turn is not None:
            turn, self._turn = self._turn, None
            turn.succeed(cancelled)

    def _drop_held(self) -> None:
        if self._held is not None:
            kill(self._held)
            self._let_go(cancelled=True)

    def _start(self, message: Message) -> Procedure:
        """A message with `$`: begin what it asks for."""
        yield from self._until_heard_again()
        if message.sequence:
            self._start_sequence(message)
            yield self._begun()
            return
        step = message.steps[0]
        if not self._in_range(step, moving=step.moves):
            return
        self._settle(step)
        yield from self._until_heard_again()
        if self._control is not None:
            control, self._control = self._control, None
            control.succeed(step)
        else:
            self._begin(perform(self, step))
        yield self._begun()

    def _until_heard_again(self) -> Procedure:
        if self._deaf_until_ns > self.clock.now:
            yield self.clock.timeout(self._deaf_until_ns - self.clock.now)

    def _start_sequence(self, message: Message) -> None:
        if self._control is not None:  # the host may send moves now, but no sequence
            self.faults.raise_line(LineFault.DATA)
            return
        if any(not self._in_range(step) for step in message.steps):
            return
        if message.steps:
            self.sequence = message.text
        if self.sequence:
            self._begin_sequence()

    def _begin_sequence(self) -> None:
        self._begin(sequence(self, read(self.sequence).steps))

    # Work

    def begin_step(self, number: int) -> None:
        """A step of the sequence begins."""
        self.step = self.step_number = number
        self.on_step(number)

    @property
    def busy(self) -> bool:
        """Moving, waiting for an input or pulsing an output, or about to; not while the host has control."""
        return self._occupied or self._held is not None

    @property
    def _occupied(self) -> bool:
        return self._work is not None and self._control is None

    @property
    def procedures(self) -> list[Process]:
        """Those that are under way."""
        there = (self._live_process, self._work, self.transmitter.urgent)
        return [process for process in there if process is not None]

    @property
    def deaf(self) -> bool:
        """Calculating a ramp: no character is processed."""
        return self._deaf_until_ns > self.clock.now

    def _begin(self, procedure: Procedure) -> None:
        self._work = self.clock.process(self._working(procedure))

    def _working(self, procedure: Procedure) -> Procedure:
        try:
            yield from procedure
        except (EndOfWork, Interrupt):
            self.motion.decelerate()
        while self.motion.running:
            try:
                yield self.motion.ended
            except Interrupt:
                self.motion.decelerate()
        self._work = self._control = None
        self._free()

    def _begun(self) -> Event:
        """The work gets its turn before the next character, so that a status request finds it begun."""
        return self.clock.timeout(0)

    def give_control(self) -> Event:
        """The host has control: the event brings a step to carry out, or None when control is given back."""
        self._control = self.clock.event()
        self._free()
        return self._control

    def _resume(self) -> Procedure:
        """A % from the host gives control back, once what it asked for is done."""
        yield from self._until_heard_again()
        if self._control is None:
            self.faults.raise_line(LineFault.DATA)
            return
        control, self._control = self._control, None
        control.succeed(None)
        yield self._begun()

    def _free(self) -> None:
        """Nothing is going on any more, or the host has control."""
        if self._ramp_before is not None:
            self._calculate_ramp()
        if self._freed is not None:
            freed, self._freed = self._freed, None
            freed.succeed()

    def _cancel_at_once(self) -> None:
        """`# <CR>` has come in, perhaps behind a message that must wait or an answer that may not be sent."""
        if self._turn is not None:
            self.buffer.drop_before_cancel()
            self._drop_held()
        elif self.transmitter.waiting and not self.locked:
            self.cancel()

    def cancel(self) -> None:
        """Command #, and what a fault does: motion stops, what is going on ends, and what is held does not begin."""
        self._drop_held()
        self.motion.decelerate()
        if self._work is not None:
            self._control = None
            if self._work is self.clock.active_process:  # an output that it switches is wired to a fault input
                self.clock.soon(partial(interrupt, self._work))
            else:
                interrupt(self._work)

    # Inputs and outputs

    def _fault_input(self, pin: Pin) -> None:
        """Current has ceased at the emergency stop, a limit switch or a drive; or it flows again."""
        if pin.level:
            self.faults.show()
        elif pin.name in LIMITS:
            self._limit(pin.name)
        elif pin.name in DRIVES:
            self._drive_fault(DRIVES[pin.name])
        else:
            self.faults.raise_motion(MotionFault.EMERGENCY_STOP)
            self.cancel()

    def _drive_fault(self, axis: str) -> None:
        """A drive fault halts the interface; the axis itself has no time to decelerate."""
        self.faults.raise_motion(MotionFault.DRIVE)
        self.motion.drop(axis)
        self.cancel()

    def may_move(self, directions: Mapping[str, int]) -> bool:
        """False if a fault or an open limit switch in one of these directions inhibits the motion.

        A limit switch that is open when a motion away from it begins does not stop that motion.
        """
        self._leaving = frozenset(name for name in LIMITS if not self.pins[name].level)
        return not self.faults.blocked(directions)

    def _limit(self, name: str) -> None:
        """A limit switch has opened: motion towards it stops, other motion too unless it is just leaving it."""
        self.faults.raise_motion(MotionFault.LIMIT)
        ahead = LIMITS[name] in self.motion.directions.values()
        behind = self.options.limits == "any motion" and name not in self._leaving
        if self.motion.running and (ahead or behind):
            self.cancel()

    def _show_fault(self, on: bool) -> None:
        if self.state is State.READY:
            self.pins["led"].set(on)
