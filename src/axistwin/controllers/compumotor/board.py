"""The dispatcher of a board with power: it reads command strings from the IDB and performs the commands.

Its procedures run concurrently: `_take` reads command strings from the IDB into the command queue, and `_obey_all`
performs the commands in order.  A SINGULAR command, a sequence and a stream each have a process of their own.
"""

from collections.abc import Callable, Mapping
from functools import lru_cache

from simpy.resources.store import Store

from axistwin.controllers.commandset import CommandSet
from axistwin.controllers.compumotor.chapters import selftest, tracking
from axistwin.controllers.compumotor.language import Accept, Opcode, decode
from axistwin.controllers.compumotor.options import Options
from axistwin.controllers.compumotor.parts.events import Happening
from axistwin.controllers.compumotor.parts.pulses import Phase
from axistwin.controllers.compumotor.parts.sequences import Stored
from axistwin.controllers.compumotor.state import State, ns
from axistwin.core.units import to_ns
from axistwin.plant.stepper import StepperAxis
from axistwin.sim.clock import Clock, Procedure, Process, kill
from axistwin.sim.pins import Pin
from axistwin.sim.registers import RegisterPort

FLOATING = ("output1", "output2", "shutdown", "direction", "remote_acknowledge")
"""Outputs that are in high impedance after a failure of the board."""


class Board(State):
    """Simulation of an 1810 or 1811 board.  Each power-on and each reset creates a new `Board`."""

    def __init__(
        self, clock: Clock, commands: CommandSet, port: RegisterPort, pins: Mapping[str, Pin], axis: StepperAxis,
        options: Options, restart: Callable[[], None], *, encoder: bool,
    ) -> None:  # fmt: skip
        """`encoder` is True for an 1811, which has an encoder interface."""
        super().__init__(clock, commands, port, pins, axis, options, encoder=encoder)
        self.handshake.on_reset = port.on_init = restart
        self.pulses.on_phase = self._phase_changed
        self.limits.on_hit = self._limit_hit
        self.joystick.on_move = self._joystick_moves
        self._queue: Store = Store(clock, options.command_queue)
        self._closing = [
            *(part.close for part in (self.limits, self.triggers, self.joystick, self.shutdown)),
            pins["remote_enable"].subscribe(lambda pin: self.refresh()),
        ]
        if encoder:
            self._closing.append(axis.on_push.subscribe(self._pushed))
        self._processes = [clock.process(self._obey_all()), clock.process(self._take())]

    def power_off(self) -> None:
        """Stop all motion and all procedures at once."""
        self._die()
        self.handshake.close()

    @property
    def procedures(self) -> list[Process]:
        """Simulation processes of the board that are in progress, e.g. a sequence."""
        singular = self.host.singular, self.sequence.singular
        stream = self.stream.process, self.stream.marker_process
        possible = (*self._processes, *singular, self.sequencer.process, *stream)
        return [process for process in possible if process is not None]

    @property
    def queued(self) -> int:
        """Number of commands that have been read from the IDB and not yet performed."""
        return len(self._queue.items)

    def fail(self) -> None:
        """Raise the board monitor alarm: LED on, outputs in high impedance; only a reset clears the alarm."""
        self._die()
        for name in FLOATING:
            self.pins[name].set(self.options.high_impedance)
        self.pins["led"].set(True)
        self.handshake.fail()

    def begin_test(self) -> None:
        """Stop all commands and begin the test function (FFh)."""
        if self.alive:
            self.alive = False
            self.events.armed.clear()
            self.triggers.clear()
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
            kill(process)
        self._processes = []

    def _take(self) -> Procedure:
        yield self.clock.timeout(to_ns(self.options.initialisation_s))
        drain_ns = ns(self.options.drain_ms)
        while True:
            self.handshake.ready()
            data = yield from self.handshake.next_command(drain_ns)
            yield self._queue.put(data)
            # Let the board perform an instantaneous command before it accepts the next command.
            yield self.clock.timeout(0)

    def _obey_all(self) -> Procedure:
        while self.alive:
            data = yield self._queue.get()
            if self.busy_until_ns > self.clock.now:
                yield self.clock.timeout(self.busy_until_ns - self.clock.now)
            yield from self._obey(data)

    def _obey(self, data: bytes) -> Procedure:
        found = decode(self.commands, data)
        if found is None or not found[0].implemented:
            self.refuse(data)
            return
        command, values = found
        if self.sequences.defining is not None and Accept.DEFINING not in command.accepted:
            if Accept.SEQUENCE in command.accepted:
                self.sequences.store(Stored(command, values, command.string(data[1:])))
            else:
                self.refuse(
                    data, "it cannot be in a sequence: send D8 first, which ends the definition of the sequence"
                )
        elif self.accepts(command):
            yield from self.carry_out(command, values, self.host, data)
        else:
            self.refuse(data, self._hindrance(command))

    def accepts(self, command: Opcode) -> bool:
        """True if the board accepts this command of the host now; the command's attributes decide."""
        needed = _needed(self.in_streaming_mode, self.sequencer.running, self.stream.performing)
        return needed in command.accepted and not self.excludes(command)

    def _hindrance(self, command: Opcode) -> str:
        """Return why the present state of the board does not allow a command, and the remedy."""
        accepted = command.accepted
        if not accepted & (Accept.INDEXER | Accept.STREAMING):
            return ""
        if self.in_streaming_mode and Accept.STREAMING not in accepted:
            return f"it is not valid in streaming mode {self.mode:02X}: send 50 (indexer mode) first"
        if not self.in_streaming_mode and Accept.INDEXER not in accepted:
            return "it is valid in a streaming mode only: send 51, 52 or 53 first"
        if self.sequencer.running and Accept.DURING_SEQUENCE not in accepted:
            return "a sequence is performed: wait for its end, or end it by 79 (kill sequence)"
        if self.stream.performing and Accept.DURING_STREAMING not in accepted:
            return "a stream is performed: wait for its end, or end it by 7B (kill the streaming buffer)"
        return "the move, search or joystick before has not ended: wait for its end, or end it by 73 or 70"

    def refresh(self) -> None:
        """Update outputs and position tracking after a change of state."""
        tracking.refresh(self)
        self.outputs.refresh()
        self.shutdown.refresh()

    def _pushed(self) -> None:
        self.outputs.refresh()
        tracking.wake(self)

    def _phase_changed(self, phase: Phase) -> None:
        tracking.phase_changed(self, phase)
        if phase is Phase.REST and not self.loop.owns_motion:
            self.events.happened(Happening.END, self.motion.begun)
        elif phase is Phase.CONSTANT and self.pulses.velocity_profile.of_move:
            self.events.happened(Happening.CONSTANT, self.motion.begun)
        self.refresh()

    def _limit_hit(self, sign: int) -> None:
        if sign == self.pulses.sign:
            self.motion.at_limit = True
            self.stream.end()
        self.events.happened(Happening.PLUS_LIMIT if sign > 0 else Happening.MINUS_LIMIT, self.motion.begun)

    def _joystick_moves(self, begins: bool) -> None:
        if not self.alive:
            return
        tracking.joystick_moves(self, begins)
        if begins:
            self.motion.begun += 1
        self.events.happened(Happening.START if begins else Happening.END, self.motion.begun)
        self.refresh()


@lru_cache(maxsize=8)
def _needed(in_streaming_mode: bool, during_sequence: bool, during_streaming: bool) -> Accept:
    needed = Accept.STREAMING if in_streaming_mode else Accept.INDEXER
    if during_sequence:
        needed |= Accept.DURING_SEQUENCE
    return needed | Accept.DURING_STREAMING if during_streaming else needed
