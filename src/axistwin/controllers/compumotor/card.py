"""The hardware of an 1810 or 1811: connectors and bus registers, with or without power (appendix C)."""

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from importlib import import_module

from axistwin.controllers.commandset import CommandSet
from axistwin.controllers.compumotor.board import Board
from axistwin.controllers.compumotor.chapters.requests import move_bits
from axistwin.controllers.compumotor.checker.texts import Words
from axistwin.controllers.compumotor.commands import COMMANDS_1810, COMMANDS_1811, installed
from axistwin.controllers.compumotor.host import Host
from axistwin.controllers.compumotor.options import Options
from axistwin.controllers.compumotor.parts.events import ALARMS
from axistwin.controllers.compumotor.registers import JUMPERS
from axistwin.controllers.product import Abilities, Awaited, Listing, Order, Product, Refusal, Register, Store
from axistwin.plant.joystick import JoystickInputs
from axistwin.plant.stepper import StepperAxis
from axistwin.sim.clock import Clock, Process
from axistwin.sim.pins import CalculatedPin, Pin, SensedPin
from axistwin.sim.progress import Progress
from axistwin.sim.registers import RegisterPort
from axistwin.sim.signal import Alarms, Signal

PULLED_UP = (
    *(f"trigger{number}" for number in range(1, 7)),
    "home", "shutdown_in",
    "remote_enable", "at_zero", "step_in", "direction_in",
)  # fmt: skip
"""Inputs with pull-up resistors, which are high when nothing is connected."""
LOW = ("cw_limit", "ccw_limit", "channel_z", "test_switch")
"""Inputs that are low on a bare board: JU5 and JU6 short the limit inputs to ground."""
SEQUENCES = tuple(f"sequence {number}" for number in range(1, 16))
OUTPUTS = ("shutdown", "output1", "output2", "direction", "remote_acknowledge", "led")


ENCODER_STEP_NS = 229


class Card:
    """An 1810 or 1811, with or without power."""

    def __init__(
        self, clock: Clock, commands: CommandSet, axis: StepperAxis, options: Options, *, encoder: bool
    ) -> None:
        """`encoder` is True for an 1811, which has an encoder interface."""
        self.clock, self._axis, self._options, self._encoder = clock, axis, options, encoder
        self._commands = installed(commands, options)
        self._board: Board | None = None
        self.bus = RegisterPort(clock)
        self.alarms = Alarms(*ALARMS.values())
        self._refusals: Signal[[Refusal]] = Signal()
        self._progress = Progress()
        self.pins = {name: Pin(clock, name, level=True) for name in PULLED_UP}
        self.pins |= {name: Pin(clock, name) for name in LOW}
        self.pins |= {name: Pin(clock, name, output=True) for name in OUTPUTS}
        for name in JUMPERS:
            self.pins[name] = Pin(clock, name, output=True)
            # By default, a trace omits the interrupt signals JU18 to JU20, which change with each command.
            self.pins[name].restless = True
        driven: dict[str, Callable[[], bool]] = {
            "step": lambda: self._board is not None and self._board.step_level,
            "cw_step": lambda: not self._steps(+1),
            "ccw_step": lambda: not self._steps(-1),
        }
        if encoder:
            self.pins["channel_z"] = channel_z = SensedPin(clock, "channel_z")
            axis.wire_index(channel_z)
            driven["encoder_step"] = lambda: self._board is not None and axis.encoder_counted(ENCODER_STEP_NS)
            driven["encoder_direction"] = self._encoder_direction
        self.pins |= {name: CalculatedPin(clock, name, read) for name, read in driven.items()}
        self.pins["home_enable"] = self.pins["home"]  # HOME ENABLE and HOME LIMIT are two names of the same input.
        if options.test_switch:
            self.pins["test_switch"].subscribe(self._press)
        self.abilities = Abilities(
            bus=self.bus, alarms=self.alarms, registers=self.registers, programs=self.programs,
            subscribe_lines=self._progress.subscribe, subscribe_refusals=self._refusals.subscribe, busy=self._busy,
            awaited=self.awaited, procedures=self._procedures,
        )  # fmt: skip

    def _steps(self, side: int) -> bool:
        """True while the board has power and CW STEP (+1) or CCW STEP (-1) outputs a pulse, which is a low level."""
        return self._board is not None and self._board.steps(side)

    def _encoder_direction(self) -> bool:
        """Return the level of DIRECTION OUT: high in the encoder's positive direction; JU17 inverts it."""
        return self._board is not None and (self._axis.encoder_direction > 0) is not self._options.invert_encoder

    def _busy(self) -> bool:
        board = self._board
        return board is not None and (
            board.moving or board.stream.performing or board.sequencer.running or bool(board.queued)
        )

    def _procedures(self) -> Sequence[Process]:
        return () if self._board is None else self._board.procedures

    def power(self, on: bool) -> None:
        self.bus.powered = on
        if not on and self._board is not None:
            self._board.power_off()
            self._board = None
            for name in OUTPUTS:
                self.pins[name].set(False)
        elif on and self._board is None:
            self._board = Board(
                self.clock, self._commands, self.bus, self.pins, self._axis, self._options, self._restart,
                encoder=self._encoder,
            )  # fmt: skip
            self._board.events.on_fault = self.alarms.emit
            self._board.on_refusal = self._refusals.emit
            self._board.sequencer.on_command = lambda number, at: self._progress.report(SEQUENCES[number - 1], at)

    def awaited(self) -> Awaited | None:
        """Return the trigger input for which a sequence waits (2Ch)."""
        sequencer = None if self._board is None else self._board.sequencer
        if sequencer is None or sequencer.trigger is None:
            return None
        trigger, high = sequencer.trigger
        work = f"step {sequencer.at + 1} of sequence {sequencer.number}"
        return Awaited(work, f"trigger{trigger}", "high" if high else "low")

    def programs(self) -> Mapping[str, Listing]:
        """Return the text of each stored sequence.  The dictionary is empty while the power is off."""
        return {} if self._board is None else _listings(self._commands, self._board)

    def registers(self) -> Mapping[str, Register]:
        """Return the registers that a user can read, e.g. the status byte, the data buffers and the mode.

        `sequence` and `command` are the numbers, from 1, of the sequence and the command being performed; 0: none.
        `acceleration`: of default moves, 0 before 31h.  Without power the numbers are 0 and the texts empty.
        """
        bus = self.bus

        def number(read: Callable[[Board], int], *names: str) -> Register:
            return Register(lambda: 0 if self._board is None else read(self._board), names)

        def text(read: Callable[[Board], str], *names: str, unpowered: str = "") -> Register:
            return Register(lambda: unpowered if self._board is None else read(self._board), names, text=True)

        return {
            "status": number(lambda _: bus.status, "SB"),
            "input": text(lambda _: _hex(bus.input.contents), "IDB"),
            "output": text(lambda _: _hex(bus.output.contents), "ODB"),
            "move": number(move_bits, "88h"),
            "mode": number(lambda board: board.mode),
            "phase": text(_phase, unpowered="off"),
            "acceleration": number(lambda board: board.library.default.acceleration),
            "queue": number(lambda board: board.queued),
            "sequence": number(lambda board: board.sequencer.number if board.sequencer.running else 0),
            "command": number(lambda board: board.sequencer.at + 1 if board.sequencer.running else 0),
        }

    def _restart(self) -> None:
        """Restart the board after a reset by the host or the bus, as if its power had been switched off and on.

        If one of the board's own procedures causes the reset (by an edge that has subscribers), the reset takes effect
        when the procedure next yields, in the same nanosecond.
        """
        self.clock.call_outside(self._procedures(), self._power_cycle)

    def _power_cycle(self) -> None:
        if self._board is not None:
            self.power(False)
            self.power(True)

    def _press(self, pin: Pin) -> None:
        if pin.level and self._board is not None:
            self._board.begin_test()


BEING_DEFINED = ", being defined"  # End of the title of a sequence that stores the host's commands.


def _listings(commands: CommandSet, board: Board) -> Mapping[str, Listing]:
    performed = board.sequencer.number if board.sequencer.running else 0
    found = {}
    for number in board.sequences:
        name, defined = SEQUENCES[number - 1], number == board.sequences.defining
        lines = tuple(_line(commands, stored.string) for stored in board.sequences[number] or ())
        running = board.sequencer.at if number == performed else None
        found[name] = Listing(f"{name}{BEING_DEFINED}" if defined else name, lines, running)
    return found


@lru_cache(maxsize=1024)
def _line(commands: CommandSet, string: bytes) -> str:
    return f"{string.hex(' ').upper()} ; {Words(commands).explain(string)}"


def _orders(program: str) -> tuple[Order, ...]:
    return (
        Order("perform", bytes((0x41, SEQUENCES.index(program) + 1)), f"Perform {program} from its first command"),
        Order("suspend", b"\x72", "Wait for CONTINUE after the present command"),
        Order("continue", b"\x48", "End a wait for CONTINUE, or an endless loop"),
        Order("discontinue", b"\x71", "End the sequence after its present command"),
        Order("kill", b"\x79", "End the sequence and its present command at once"),
    )


def _product(model: str, title: str, commands: CommandSet, *, encoder: bool) -> Product:
    def build(clock: Clock, axes: Mapping[str, StepperAxis], options: Options, _: Store) -> Card:
        return Card(clock, commands, axes["motor"], options, encoder=encoder)

    return Product(
        model, title, commands, axes=("motor",), options=Options, build=build, family="compumotor", suffix=".181x",
        limit_pins={"motor": ("ccw_limit", "cw_limit")}, closed_level=False,
        drive_fault_pins={"motor": "shutdown_in"}, home_pins={"motor": "home"},
        joystick=JoystickInputs(at_zero="at_zero", step="step_in", direction="direction_in"),
        make_front=lambda: getattr(import_module(f"{__package__}.front"), "FRONT_1811" if encoder else "FRONT"),
        check=lambda sessions: import_module(f"{__package__}.checker.program").check(commands, sessions),
        make_rules=lambda: import_module(f"{__package__}.rules").RULES,
        language=Words(commands, model), programs=SEQUENCES, orders=_orders, attend=Host,
    )  # fmt: skip


BOARD_1810 = _product("1810", "Compumotor 1810 Multibus motor controller", COMMANDS_1810, encoder=False)
BOARD_1811 = _product(
    "1811", "Compumotor 1811 Multibus motor controller with encoder interface", COMMANDS_1811, encoder=True
)


def _phase(board: Board) -> str:
    return "joystick" if board.joystick.moving else board.pulses.phase.name.lower()


@lru_cache(1024)
def _hex(data: bytes) -> str:
    return data.hex(" ").upper()
