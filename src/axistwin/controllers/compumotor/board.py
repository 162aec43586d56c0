"""The board with its power on: command strings, input edges and time in; messages, levels and pulses out.

Procedures run side by side: `_take` reads command strings from the IDB into the command queue, `_live` obeys them in
order; a SINGULAR command and a sequence each run for as long as they take; the pulse generator works by itself.
"""

from collections.abc import Callable, Mapping
from typing import Any

import simpy

from axistwin.controllers.commandset import CommandSet
from axistwin.controllers.compumotor.chapters import selftest
from axistwin.controllers.compumotor.chapters.events import Events, Happening
from axistwin.controllers.compumotor.chapters.home import HomeDefinition
from axistwin.controllers.compumotor.chapters.joystick import Joystick, Shutdown
from axistwin.controllers.compumotor.chapters.limits import Limits
from axistwin.controllers.compumotor.chapters.moves import Library, Motion, Move
from axistwin.controllers.compumotor.chapters.outputs import Outputs
from axistwin.controllers.compumotor.chapters.profiles import Speed
from axistwin.controllers.compumotor.chapters.pulses import Phase, PulseGenerator
from axistwin.controllers.compumotor.chapters.sequence import Sequencer, Sequences, Stored
from axistwin.controllers.compumotor.chapters.singular import Owner
from axistwin.controllers.compumotor.chapters.stop import Triggers
from axistwin.controllers.compumotor.chapters.streaming import Stream
from axistwin.controllers.compumotor.chapters.tracking import ClosedLoop
from axistwin.controllers.compumotor.language import Accept, Opcode, decode
from axistwin.controllers.compumotor.options import Options
from axistwin.controllers.compumotor.registers import Handshake
from axistwin.controllers.product import PulseAxis
from axistwin.sim.clock import Clock, Event, Procedure, Process, kill
from axistwin.sim.pins import Pin
from axistwin.sim.registers import RegisterPort
from axistwin.units import MS, US, to_ns

LET_GO = ("output1", "output2", "shutdown", "direction", "remote_acknowledge")
"""Outputs that keep a level, and are in high impedance when the board has failed."""
INDEXER = 0x50
"""The mode after reset; modes are called by the opcodes that enter them."""


class Board:
    """An 1810 or 1811 that has power.  A reset makes another one."""

    def __init__(
        self,
        clock: Clock,
        commands: CommandSet,
        port: RegisterPort,
        pins: Mapping[str, Pin],
        axis: PulseAxis,
        options: Options,
        restart: Callable[[], None],
        *,
        encoder: bool,
    ) -> None:
        """`encoder`: it has the interface for one, as an 1811 has."""
        self.clock, self.commands, self.options = clock, commands, options
        self.pins: Mapping[str, Pin] = pins
        self.start_ns, self.step_ns = _ns(options.start_ms, MS), _ns(options.step_ms, MS)
        self.alive = True
        """Whether the processor attends to its work: not during the test, nor after a failure."""
        self.handshake = Handshake(
            clock, port, pins, options.interrupts, _ns(options.next_message_ms, MS), options.message_queue
        )
        self.handshake.on_reset = port.on_init = restart
        self._queue: simpy.Store = simpy.Store(clock, options.command_queue)
        self._busy_until_ns = 0
        # Motion
        self.pulses: PulseGenerator = PulseGenerator(clock, axis, pins["direction"])
        self.pulses.on_phase = self._phase_changed
        self.limits = Limits(clock, self.pulses, pins["cw_limit"], pins["ccw_limit"], _ns(options.limit_us, US))
        self.limits.on_hit = self._limit_hit
        self.library, self.motion = Library(clock, _ns(options.calculation_ms, MS)), Motion()
        self.start_stop = 0
        self.zero = self.home = 0
        """Absolute zero and HOME, in the pulse generator's count."""
        self.home_definition: HomeDefinition | None = None
        self.home_ns = max(1, _ns(options.home_ms, MS))
        # Modes and procedures
        self.mode, self.mode_parameters = INDEXER, b""
        self.sequences: Sequences = Sequences(options.buffer_bytes)
        self.sequencer: Sequencer = Sequencer(clock)
        self.stream = Stream(self, options.buffer_bytes, _ns(options.marker_ms, MS))
        self.host, self.sequence = Owner(clock), Owner(clock)
        """Each gives commands, and has a SINGULAR command of its own in progress."""
        # Everything else
        self.events = Events(self.send)
        self.triggers = Triggers(
            self,
            clock,
            {1: pins["trigger1"], 6: pins["trigger6"]},
            {
                1: _ns(max(options.trigger1_us, options.trigger1_hold_us), US),
                6: _ns(max(options.trigger6_us, options.trigger6_hold_us), US),
            },
        )
        self.joystick, self.shutdown = Joystick(dict(pins), self.pulses), Shutdown(self)
        self.joystick.on_move = self._joystick_moves
        self.outputs = Outputs(self)
        performed = encoder or options.encoder_commands == "performed"
        self.loop = ClosedLoop(self, axis if encoder else None, moves=performed)
        self._closing = [
            *(part.close for part in (self.limits, self.triggers, self.joystick, self.shutdown, self.loop)),
            pins["remote_enable"].subscribe(lambda pin: self.refresh()),
        ]
        self._processes = [clock.process(self._live()), clock.process(self._take())]

    # Power, reset, failure

    def power_off(self) -> None:
        """Everything stops at once and is forgotten."""
        self._die()
        self.handshake.close()

    @property
    def procedures(self) -> list[Process]:
        """Those that are under way."""
        there = (
            *self._processes,
            self.host.singular,
            self.sequence.singular,
            self.sequencer.process,
            *self.stream.processes,
        )
        return [process for process in there if process is not None]

    @property
    def queued(self) -> int:
        """Commands that have been taken and not yet obeyed."""
        return len(self._queue.items)

    def fail(self) -> None:
        """The board monitor alarm: the LED lights, the outputs are in high impedance, only a reset helps."""
        self._die()
        for name in LET_GO:
            self.pins[name].set(self.options.high_impedance)
        self.pins["led"].set(True)
        self.handshake.fail()

    def begin_test(self) -> None:
        """The test switch: drop everything else."""
        if self.alive:
            self.alive = False
            self.events.inhibit()
            self._stop_working()
            self.handshake.ready()
            self._processes = [self.clock.process(selftest.test(self))]

    def _die(self) -> None:
        self.alive = False
        self._stop_working()
        self.pulses.on_phase = lambda phase: None
        self.pulses.kill()
        for close in self._closing:
            close()
        self._closing.clear()

    def _stop_working(self) -> None:
        self.sequencer.end()
        self.stream.abandon()
        for owner in (self.host, self.sequence):
            owner.kill()
        for process in self._processes:
            if process is not self.clock.active_process:
                kill(process)
        self._processes = []

    # Commands

    def _take(self) -> Procedure:
        yield self.clock.timeout(to_ns(self.options.initialisation_s))
        drain_ns = _ns(self.options.drain_ms, MS)
        while True:
            self.handshake.ready()
            data = yield from self.handshake.next_command(drain_ns)
            yield self._queue.put(data)
            yield self.clock.timeout(0)  # what takes no time has been done when the host finds the IDB ready

    def _live(self) -> Procedure:
        while self.alive:
            data = yield self._queue.get()
            if self._busy_until_ns > self.clock.now:
                yield self.clock.timeout(self._busy_until_ns - self.clock.now)
            yield from self._obey(data)

    def _obey(self, data: bytes) -> Procedure:
        found = decode(self.commands, data)
        if found is None or not found[0].implemented:
            return
        command, values = found
        if self.sequences.defining is not None and Accept.DEFINING not in command.accepted:
            if Accept.SEQUENCE in command.accepted:
                self.sequences.store(Stored(command, values, command.string(data[1:])))
        elif self.hears(command):
            yield from self.carry_out(command, values, self.host)

    def hears(self, command: Opcode) -> bool:
        """Whether a command from the host is performed now: its attributes alone decide."""
        needed = Accept.STREAMING if self.in_streaming_mode else Accept.INDEXER
        if self.sequencer.running:
            needed |= Accept.DURING_SEQUENCE
        if self.streaming:
            needed |= Accept.DURING_STREAMING
        return needed in command.accepted and not self.excludes(command)

    def excludes(self, command: Opcode) -> bool:
        """True for a SINGULAR command that the host could give too, while one of the host is in progress.

        Such a command is a move, a search or the joystick, and the host's is one as well.
        """
        both = Accept.SINGULAR | Accept.INDEXER
        return both in command.accepted and self.host.busy

    def carry_out(self, command: Opcode, values: tuple[Any, ...], owner: Owner) -> Procedure:
        """Perform a command; what takes time goes on as the owner's SINGULAR command."""
        assert command.handler is not None
        result = command.handler(self, *values)
        if isinstance(result, bytes):
            yield self.occupy(_ns(self.options.reply_ms, MS))
            self.send(command.opcode, result)
        elif result is not None:
            owner.begin(result, self.refresh)
            self.refresh()

    @property
    def performing_singular(self) -> bool:
        """True while a SINGULAR command is in progress, whoever has given it."""
        return self.host.busy or self.sequence.busy

    def occupy(self, duration_ns: int) -> Event:
        """The processor is busy: no command is obeyed meanwhile.  Returns the event of its end."""
        self._busy_until_ns = max(self._busy_until_ns, self.clock.now + duration_ns)
        return self.clock.timeout(duration_ns)

    def send(self, opcode: int, data: bytes) -> None:
        """A message to the host: the opcode that caused it, and what it says."""
        self.handshake.send(bytes([opcode]) + data)

    # States

    @property
    def in_streaming_mode(self) -> bool:
        """Whether one of 51h, 52h, 53h is in force."""
        return self.mode != INDEXER

    @property
    def streaming(self) -> bool:
        """Whether the streaming buffer is being performed."""
        return self.stream.performing

    @property
    def moving(self) -> bool:
        """Whether the motor is moving, under the joystick too."""
        return self.pulses.moving or self.joystick.moving

    @property
    def occupied(self) -> bool:
        """Whether the motor is moving, or the joystick enabled, which counts as such."""
        return self.moving or self.joystick.enabled

    @property
    def shut_down(self) -> bool:
        """Whether the motor is without current."""
        return self.shutdown.on

    def blocked(self, sign: int) -> bool:
        """True if no motion may begin in the + or - direction: its limit is active, or the motor is shut down."""
        return self.shut_down or self.limits.blocks(sign)

    @property
    def maintaining(self) -> bool:
        """Whether the position is maintained in a closed loop (18h)."""
        return self.loop.on

    @property
    def step_level(self) -> bool:
        """The level of STEP: that of STEP IN while the joystick is enabled; in high impedance after a failure."""
        if self.handshake.failed:
            return self.options.high_impedance
        return self.pins["step_in"].level if self.joystick.enabled else self.pulses.step_level

    def steps(self, side: int) -> bool:
        """True while a STEP pulse in the physical direction +1 (CW) or -1 (CCW) is given out."""
        return not self.handshake.failed and self.pulses.physical == side and self.step_level

    @property
    def in_deadband(self) -> bool:
        """Whether the closed-loop error is within the deadband (B5h)."""
        return self.loop.in_deadband

    @property
    def absolute(self) -> int:
        """Position from absolute zero, in pulses."""
        return self.pulses.position - self.zero

    @property
    def at_home_switch(self) -> bool:
        """Whether the home input is active; TTL high unless 38h says otherwise."""
        active_high = self.home_definition is None or self.home_definition.active_high
        return self.pins["home"].level is active_high

    @property
    def channel_z(self) -> bool:
        """The encoder's channel Z, as JU16 lets it through."""
        return self.pins["channel_z"].level is not self.options.invert_z

    @property
    def free_bytes(self) -> int:
        """Memory left, in bytes: one memory, for the sequences or in a streaming mode for the stream."""
        return self.stream.free if self.in_streaming_mode else self.sequences.free

    # What happens

    def begin_move(self, move: Move, speed: Speed, end: int | None) -> None:
        """A move begins; `end`: where a preset move ends, in the pulse generator's count."""
        sign = -1 if end is not None and end < self.pulses.position else +1
        self.motion = Motion(move, speed, end, self.motion.begun + 1, sign)
        self.events.happened(Happening.START, self.motion.begun)

    def refresh(self) -> None:
        """Something may have changed that outputs show."""
        self.loop.look()
        self.outputs.refresh()
        self.shutdown.refresh()

    def _phase_changed(self, phase: Phase) -> None:
        self.loop.phase_changed(phase)
        if phase is Phase.REST and not self.loop.owns_course:
            self.events.happened(Happening.END, self.motion.begun)
        elif phase is Phase.CONSTANT and self.pulses.of_move:
            self.events.happened(Happening.CONSTANT, self.motion.begun)
        self.refresh()

    def _limit_hit(self, sign: int) -> None:
        if sign == self.pulses.sign:
            self.motion.at_limit = True
            self.stream.end()
        self.events.happened(Happening.PLUS_LIMIT if sign > 0 else Happening.MINUS_LIMIT, self.motion.begun)

    def _joystick_moves(self, begins: bool) -> None:
        """From zero velocity and back to it is a move (11h)."""
        if not self.alive:
            return
        if begins:
            self.motion.begun += 1
        self.events.happened(Happening.START if begins else Happening.END, self.motion.begun)
        self.refresh()


def _ns(amount: float, unit_ns: int) -> int:
    return round(amount * unit_ns)
