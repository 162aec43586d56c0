"""The interface card while it has power: obeys messages, and controls outputs and axes.

Three procedures run concurrently: `_live` reads the input buffer character by character and obeys messages; `work`
carries out a move, a run or a sequence; the `RampGenerator` sends pulses to the axes.
"""

from functools import lru_cache

from axistwin.controllers.commandset import Command
from axistwin.controllers.digiplan.chapters import initialise
from axistwin.controllers.digiplan.chapters.battery_backup import Retained
from axistwin.controllers.digiplan.chapters.breaking_in import BreakIn
from axistwin.controllers.digiplan.chapters.data_format import CR, LF, uart_format
from axistwin.controllers.digiplan.chapters.data_transfer import BLANK
from axistwin.controllers.digiplan.chapters.faults import LineFault
from axistwin.controllers.digiplan.chapters.interpolation import out_of_range
from axistwin.controllers.digiplan.chapters.sequence import perform, sequence
from axistwin.controllers.digiplan.chapters.speed import too_fast
from axistwin.controllers.digiplan.commands import COMMANDS
from axistwin.controllers.digiplan.language import CANCEL, LONGEST_MESSAGE, Accept, Message, parse
from axistwin.controllers.digiplan.state import Hardware, Stage, State
from axistwin.controllers.digiplan.step import Fault, Parameters, Step
from axistwin.core.units import to_ns
from axistwin.sim.clock import Event, Procedure, Process, kill

INITIALISED = (
    "the interface is initialised already, so that it does not answer (: switch its power off and on, e.g. for each "
    "client by axistwin serve --reset-on-connect"
)
LOCKED = "the interface is locked by [ and obeys only status requests and ]: send ] first"
IN_CONTROL = "a sequence has given control to the host: send % first, which continues it, or # to cancel it"
BUSY = "a move or a sequence is in progress (option busy): wait until E reports C"
REQUESTS = [command.code for command in COMMANDS if Accept.REQUEST in command.accepted]
LINE_FAULTS = {Fault.DATA: LineFault.DATA, Fault.RANGE: LineFault.RANGE}


@lru_cache(maxsize=512)
def read(text: str) -> Message:
    """Parse a message of the host.  Results are cached."""
    return parse(text, COMMANDS)


def is_request(text: str) -> bool:
    message = read(text)
    return message.alone is not None and not message.problems and Accept.REQUEST in message.alone.accepted


def is_heeded(text: str) -> bool:
    """True if the text stays in the buffer when all that waits is deleted."""
    return not text or is_request(text) or text.rstrip(" ").endswith(CANCEL)


class Interface(State):
    """An IF1 or IF2 that has power."""

    def __init__(self, card: Hardware) -> None:
        self._kept = Retained.recall(card.store)
        super().__init__(card)
        self._break_in = BreakIn(self)
        self.stops.on_stop = self._drop_waiting
        self.buffer.on_full = self._report_full
        self.buffer.on_terminator = self._cancel_at_once
        self._text: list[str] = []
        self._told = False
        self._last_typed = 0  # Code of the last character of the message in progress that is no CR, LF or space.
        self._cancelled = False  # True if `# <CR>` has acted in the buffer: what is before it begins no motion.
        # For each character of the incoming message: True if the highest of the character's eight bits is 1.
        self._eighth: list[bool] = []
        self.pins["led"].set(True)
        self.lines.dtr.set(True)
        self._live_process = self.clock.process(self._live())

    def power_off(self) -> None:
        """Stop all motion, transmission and other work; a locked IF2 saves its memory."""
        kill(self._live_process)
        self.work.stop()
        self.transmitter.stop()
        self.motion.stop()
        self.stops.close()
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
            self.stage = Stage.WAIT
            yield from initialise.detect_baud_rate(self)
            yield from initialise.set_data_format(self)
        while True:
            self._become_ready()
            yield from self._obey_until_broken_in()
            yield from initialise.set_data_format(self)

    def _become_ready(self) -> None:
        self.stage, self.hint = Stage.READY, ""
        self._break_in.enable(self.locked)
        self.faults.show()
        self._begin_sequence()  # The interface starts the stored sequence automatically after each initialisation.

    def _obey_until_broken_in(self) -> Procedure:
        while True:
            if self.muted:
                yield from self.until_unmuted()
            if self.work.held is not None:
                yield from self._behind_held()
            character = self.buffer.take()
            if character is None:
                yield self.buffer.arrival()
            elif self._break_in.begins_with(character):
                self._text.clear()
                self._eighth.clear()
                self.work.cancel()
                yield self.clock.timeout(0)  # Let the cancelled move or sequence end before the new initialisation.
                return
            elif (procedure := self._process(character)) is not None:
                yield from procedure

    @property
    def procedures(self) -> list[Process]:
        """Simulation processes that the interface is running, e.g. the process of a move or a sequence."""
        return [
            process
            for process in (self._live_process, self.work.process, self.transmitter.urgent, self.transmitter.rest)
            if process
        ]

    def _recall(self) -> None:
        kept = self._kept
        if kept.locked:
            self.locked, self.baudrate, self.frame, self.lock = True, kept.baudrate, kept.frame, kept.lock
            self.parameters, self.sequence = kept.parameters, kept.sequence
            self.transmitter.delay = self.parameters.character_delay

    def save(self) -> None:
        """Store the memory if the interface is locked; during initialisation, leave the stored memory unchanged."""
        if self.locked and self.stage is Stage.READY:
            Retained(True, self.baudrate, self.frame, self.parameters, self.sequence, self.lock).save(self.store)

    def set_locked(self, locked: bool) -> None:
        """Lock or unlock the communication (commands `[` and `]`), and update the battery-backed memory."""
        self.locked, self.lock = locked, self.message_format if locked else None
        self._break_in.enable(locked)
        if locked:
            self.save()
        else:
            Retained().save(self.store)

    def erase(self) -> None:
        """Command * during initialisation: erase parameters, sequence and lock."""
        self.locked, self.lock, self.parameters, self.sequence = False, None, Parameters(), ""
        self.transmitter.delay = 0
        Retained().save(self.store)

    @property
    def kept_sequence(self) -> str:
        """The stored sequence, "" if there is none; available even during the self-test."""
        return self._kept.sequence if self.stage is Stage.RESET else self.sequence

    def _process(self, character: int) -> Procedure | None:
        ignored, self.ignored = self.ignored, ()
        if character & 0x7F in ignored:
            return None
        if character & 0x7F not in BLANK:
            self._last_typed = character & 0x7F
        return self._echo(character) if self.frame.echo else self._collect(character)

    def _echo(self, character: int) -> Procedure:
        yield from self.transmit(bytes([self.frame.text(character)]))
        yield from self._collect(character) or ()

    def _collect(self, character: int) -> Procedure | None:
        code = character & 0x7F
        if code == self.frame.ends_message:
            text = "".join(self._text)
            self._last_typed = 0
            self._text.clear()
            self.eighth = (*self._eighth, character > code)
            self._eighth.clear()
            return self._obey(text)
        if code == initialise.BAUD_DETECT and not self.locked and not self._told:
            self._told = True
            self.on_hint(INITIALISED)
        if code not in (CR, LF) and len(self._text) < LONGEST_MESSAGE:
            self._text.append(chr(code))
            self._eighth.append(character > code)
        return None

    def _report_full(self, full: bool) -> None:
        """Stop the host when the buffer is 80 % full, and let the host continue at 20 %: by DTR, or X-off and X-on."""
        self.lines.dtr.set(not full)
        if self.stage is Stage.READY and self.frame.x_on_x_off:
            self.transmitter.send_flow_control(stop=full)

    def _cancel_at_once(self, terminator: int) -> None:
        """Perform the command `# <CR>` when it is received, although other messages or an answer are before it."""
        waits = self.work.held is not None or (self.transmitter.busy and not self.locked)
        last = self.buffer.last_typed or self._last_typed
        if not waits or terminator != self.frame.ends_message or last != ord(CANCEL):
            return
        self._cancelled = True
        self._drop_waiting()

    def _obey(self, text: str) -> Procedure | None:
        if not text.strip(" "):
            return None
        message = read(text)
        command = message.alone
        if self.locked:  # A locked interface performs only status requests and the command "]".
            heeded = command is not None and not message.problems and Accept.LOCKED in command.accepted
            if command is not None and heeded:
                return self._answer(command)
            if command is None or command.code != "[":  # a second [ changes nothing
                self.refuse(text, LOCKED)
            return None
        if command is not None and command.code == CANCEL:
            self._cancelled = False
            self.work.cancel()
        if message.problems:
            self.faults.raise_line(LINE_FAULTS[message.problems[0].fault])
            self.refuse(text)
            return None
        if command is not None and Accept.REQUEST in command.accepted:
            return self._answer(command)  # The interface answers status requests immediately, e.g. during a move.
        return self._carry_out(message)

    def _answer(self, command: Command) -> Procedure | None:
        assert command.handler is not None
        answer = command.handler(self)
        return self.transmitter.send(answer) if isinstance(answer, bytes) else None

    def _carry_out(self, message: Message) -> Procedure | None:
        if message.alone is not None:
            return self._answer(message.alone)
        if message.steps and message.steps[0].hand_over and not message.sequence:
            return self.work.when_free(self._give_control_back())
        if not message.start:
            if self._in_range(message, message.steps[0]):
                self.set_parameters(message.steps[0])  # A message without "$" at its end only sets parameters.
        elif self.work.occupied and self.options.busy == "ignore":
            self.refuse(message.text, BUSY)
        elif not (self._cancelled and self.buffer.has_cancel):
            return self.work.when_free(self._start(message))
        return None

    def _drop_waiting(self) -> None:
        if self.work.held is not None:
            self.buffer.drop_messages(self.frame.ends_message, is_heeded)
        self.work.cancel()

    def _behind_held(self) -> Procedure:
        """Answer status requests until the held message has begun, or a host that wants echoes begins a request."""
        while True:
            yield from self.until_unmuted()
            yield from self._answer_requests()
            if self.work.held is None or self._begins_request():
                return
            yield self.work.released() | self.buffer.arrival()

    def _begins_request(self) -> bool:
        """True if a host that waits for each echo may be typing a status request or `#` behind a held message."""
        characters = self.buffer.characters
        if not (self.frame.echo and characters):
            return False
        text = ("".join(self._text) + chr(characters[0] & 0x7F)).strip(" \r\n")
        if text in ("", *REQUESTS) or text.endswith(CANCEL):
            return True
        if self.buffer.has_cancel:
            self.buffer.drop_before_cancel()
        return characters[0] & 0x7F == ord(CANCEL)

    def _answer_requests(self) -> Procedure:
        """Answer the status requests in the buffer.  Other messages stay in the buffer for later execution."""
        if self._text:
            return
        while request := self.buffer.take_message(self.frame.ends_message, is_request):
            for character in request:
                yield from self._process(character) or ()

    def _in_range(self, message: Message, step: Step, *, moving: bool = False) -> bool:
        """True if the parameters are valid, for a move if `moving`; otherwise set the bit RANGE that F reports."""
        parameters = self.parameters.after(step)
        problem = too_fast(parameters) if "speed" in step.settings else None
        problem = problem or (out_of_range(parameters, step) if moving else None)
        if problem is not None:
            self.faults.raise_line(LineFault.RANGE)
            self.refuse(message.text, problem.message, problem.rule)
        return problem is None

    def _start(self, message: Message) -> Procedure:
        yield from self.until_unmuted()
        if message.sequence:
            self._start_sequence(message)
            yield self._begun()
            return
        step = message.steps[0]
        if not self._in_range(message, step, moving=bool(step.major)):
            return
        self.set_parameters(step)
        yield from self.until_unmuted()
        control, self.begun = self.work.take_control(), message.text
        if control is None:
            self.work.begin(perform(self, step))
        else:
            control.succeed(step)
        yield self._begun()

    def _start_sequence(self, message: Message) -> None:
        if self.work.control is not None:  # While a sequence is paused, no other sequence can be started.
            self.faults.raise_line(LineFault.DATA)
            self.refuse(message.text, IN_CONTROL)
            return
        if any(not self._in_range(message, step) for step in message.steps):
            return
        if message.steps:
            self.sequence = message.text
        self._begin_sequence()

    def _begin_sequence(self) -> None:
        if self.sequence:
            self.work.begin(sequence(self, read(self.sequence).steps))

    def _give_control_back(self) -> Procedure:
        yield from self.until_unmuted()
        control = self.work.take_control()
        if control is None:
            self.faults.raise_line(LineFault.DATA)
            self.refuse("%")
            return
        control.succeed(None)
        yield self._begun()

    def _begun(self) -> Event:
        """Return an event after which the next status request reports busy, because the work has begun."""
        return self.clock.timeout(0)
