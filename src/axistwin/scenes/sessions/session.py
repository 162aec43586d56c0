"""An interactive session: run, pause and step a bench, act on it, and go back in time.

All external input passes through the session, which records it with its time.  The bench itself repeats the acts of the
scene's hosts, script and faults.  To go back in time, the session builds a new bench and replays the recorded input up
to that time.  When time then passes, the rest of the recording is replayed, while hosts at real ports are blocked.  The
first new act of a user ends the replay, and the rest of the recording is deleted.
"""

import asyncio
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from enum import Enum, auto
from functools import partial
from logging import getLogger
from time import monotonic
from typing import TypeVar

from axistwin.bench import Bench, endpoints
from axistwin.bench.acts import Do, Say
from axistwin.core.errors import AxistwinError, UsageError
from axistwin.core.storage import FileStore
from axistwin.core.units import S, figures, to_ns, to_seconds
from axistwin.links.pacing import Pacer
from axistwin.links.server import Server
from axistwin.scenes.scene import Scene
from axistwin.scenes.sessions import programs, saving, steps
from axistwin.scenes.sessions.breaks import Break
from axistwin.scenes.sessions.external_input import ExternalInput, Replay
from axistwin.scenes.sessions.journal import Journal, Tail
from axistwin.scenes.tables import OperatorTable
from axistwin.sim.serial_port import Flow

log = getLogger("axistwin")

T = TypeVar("T")
Attach = Callable[[Bench], object]
DRAIN_EVERY = 1 << 12  # Number of clock advances between two readings of ports without a client.


class State(Enum):
    """State of a session.  In this class, a move is a `step` or a `go_to`."""

    IDLE = auto()  # Paused at the beginning, or after a completed move.
    RUNNING = auto()
    HALTED = auto()  # Paused by a user, a breakpoint or an error.
    MOVING = auto()
    MOVE_HALTED = auto()  # A breakpoint or an error is ending the move.
    MOVE_ABORTED = auto()  # A user is ending the move.


UNDO_S = 10.0  # Time in seconds during which the panel offers to undo a deletion of recorded actions.


@dataclass(frozen=True)
class Forgotten:
    """The deleted part of a recording, which `undo` can restore."""

    at_ns: int  # Virtual time at which the part was deleted.
    recorded_ns: int  # End of the recording.
    tail: Tail
    since_s: float  # Wall-clock time at which the part was deleted.
    by: str  # What deleted it.


class Session:
    """Controls one bench at a time, created by `build`.

    `speed`: times real time; None: as fast as possible.  `scene`: the scene of `build`, for `save`.  `served`: the
    scene was built without hosts for controllers with ports.  `run` needs a running event loop.
    """

    def __init__(
        self, build: Callable[[], Bench], speed: float | None = 1.0, *, scene: Scene | None = None, served: bool = False
    ) -> None:
        self._build, self._scene, self._served = build, scene, served
        self.bench = build()  # The present bench; going back in time replaces it.
        self.pacer = Pacer(self.bench.clock, speed)
        self.server: Server | None = None  # The server of real ports; None before `serve`.
        self.breaks: list[Break] = []
        self.halted_by = ""
        """Text of the breakpoint or error that has stopped the bench; "" if a user has paused the bench."""
        self.heading = ""  # Where a step or a `go_to` leads, e.g. "12.4 s".
        self.progress: float | None = None  # Progress of `go_to`, 0 to 1; None if not active.
        self.input = ExternalInput(self.pacer)
        """External input; its `serial(name)` and `bus(name)` are ports for hosts, whose actions are recorded."""
        self.input.attach(self.bench)
        self.waiting = False  # True after `wait`, until virtual time starts.
        self._attached: list[Attach] = []
        self._replay: Replay | None = None
        self._recorded_ns = 0
        self._forgotten: Forgotten | None = None
        self._state = State.IDLE
        self._target: Break | None = None
        self.pacer.subscribe(self._after_advance)
        self.pacer.on_failure = self._on_failure

    @property
    def title(self) -> str:
        """Title of the scene; without a title, the names of the controllers."""
        return (self._scene.title if self._scene is not None else "") or ", ".join(self.bench.controllers)

    @property
    def operator(self) -> OperatorTable:
        """Description of the operator panel; empty for a scene without an operator panel."""
        return OperatorTable() if self._scene is None else self._scene.operator

    @property
    def finished(self) -> bool:
        """True if the scene has a script or hosts, and all have ended."""
        bench = self.bench
        hosts = [*bench.senders.values(), *(host for each in bench.hosts.values() for host in each)]
        has_plan = bool(bench.planned or bench.hosts)
        return has_plan and bench.now >= bench.agenda_ns and not any(host.is_alive for host in hosts)

    @property
    def seconds(self) -> float:
        """Present virtual time in seconds; without due events the bench rests, so it can be in the past."""
        return to_seconds(self.bench.now)

    def each_bench(self, attach: Attach) -> None:
        """Call `attach` now with the present bench, and later with each new bench before its first event."""
        self._attached.append(attach)
        attach(self.bench)

    def show(self, bench: Bench) -> None:
        """Replace the present bench by another one with the same controllers."""
        self.bench = bench
        for attach in self._attached:
            attach(bench)
        self.input.attach(bench)

    def serve(self, *, flow: Flow = Flow.DTR, reset: bool = False, share: bool = False) -> Server:
        """Create the server of real ports.  Its clients stay connected when the bench is replaced."""
        self.pacer.sync()
        resets = self._power_cycle if reset else False
        self.server = Server(self.bench, pacer=self.pacer, flow=flow, reset=resets, access=self.input, share=share)
        self.input.serve(self.server)
        self.server.gate.admitted.subscribe(self.welcome)
        return self.server

    def client(self, name: str) -> str:
        """Return the address of the client at this endpoint; "" without a client."""
        return "" if self.server is None else self.server.client(name)

    @property
    def journal(self) -> Journal:
        """The journal, which records the external input of the session."""
        return self.input.journal

    # Actions of users

    def do(self, who: str, target: str, value: str) -> None:
        """Perform the action `! target value` of a conversation at the endpoint `who`.  Raises AxistwinError."""
        self._do(Do(target, value, controller=who))

    def say(self, name: str, data: bytes) -> None:
        """Send data to an endpoint, as a host does.

        The data are characters; for a board on a bus, one whole command.  Raises AxistwinError for an unknown name or
        an invalid command.
        """
        if endpoints.at_a_bus(self.bench, name):
            codec = endpoints.codec_at(self.bench, name)
            # Raise ProgramError if the bus command cannot be written as text in a conversation file.
            codec.read(codec.show(data))
        else:
            self.bench.port(name)  # Raise UsageError for the name of an unknown endpoint.
        self._do(Say(data, controller=name))

    def load(self, name: str, filename: str, text: str) -> None:
        """Switch a controller off and on, load a program into it, and start the program.

        SmartMotor source (.sms) is stored and run; command lines (.if1, .181x) are sent as by a host.  Raises
        AxistwinError, in most cases before the controller is changed; an error in the program has file, line and
        column.
        """
        file = programs.checked(self.bench, name, filename, text, self.input.texts)
        if name in self.bench.ports:
            self.do(name, "drop", "pending")
        self.do(name, "power", "off")
        until_ns = self.bench.now + to_ns(programs.OFF_S)
        self.pacer.advance_slice(lambda _: self.bench.clock.run_to(until_ns))
        self.input.texts[file] = text
        self.do(name, "load", file)

    def _do(self, act: Say | Do) -> None:
        self._check_free()
        do = self.input.prepare(act)
        self.forget_rest()
        do()

    def _power_cycle(self, name: str) -> None:
        line = self.bench.lines.get(name)
        for motor in (self.bench[name.removesuffix(".rs485")],) if line is None else line.motors:
            for level in ("off", "on"):
                self.input.prepare(Do("power", level, controller=motor.name))()

    def _check_free(self) -> None:
        if self.busy:
            raise UsageError(
                f"the session is busy at {self.seconds:.3f} s: wait until the method `step` or `go_to` has returned"
            )

    # Time

    @property
    def busy(self) -> bool:
        """True during `step` and `go_to`, when no actions are possible."""
        return self._state in (State.MOVING, State.MOVE_HALTED, State.MOVE_ABORTED)

    @property
    def running(self) -> bool:
        """True while virtual time passes."""
        return self._state is State.RUNNING

    @property
    def speed(self) -> float | None:
        """Speed as a multiple of real time; None: as fast as possible.  Setting an invalid speed raises UsageError."""
        return self.pacer.speed

    @speed.setter
    def speed(self, speed: float | None) -> None:
        self.pacer.speed = speed

    def wait(self) -> None:
        """Delay the start of virtual time until the first host or browser connects."""
        self.waiting = True

    def welcome(self) -> None:
        """Start virtual time if the session waits for a host or a browser."""
        if self.waiting and not self.busy:
            self.run()

    def inspect(self, read: Callable[[], T]) -> T:
        """Return the result of `read`, which reads the state of the bench at the present time."""
        return self.pacer.inspect(read) if self.running else read()

    def run(self) -> None:
        """Start virtual time."""
        self._check_free()
        self.waiting = False
        self.halted_by, self._state = "", State.RUNNING
        # At full speed, the simulation runs at least until the last planned action of the scene.
        self.pacer.agenda_ns = self.bench.agenda_ns
        self.pacer.start()

    def pause(self) -> None:
        """Stop virtual time, after executing all events that are due."""
        self._check_free()
        self.pacer.sync()
        self.pacer.stop()
        self._halt("")

    async def step(self, kind: str) -> bool:
        """Advance virtual time to the next event of the given kind, and pause.

        Return False if no such event occurs within 60 virtual seconds.  "event": a change of a pin, a message, a fault,
        or the start or end of a motion.  "character": the same, but each character of a message is an event.  "move":
        the start or end of a motion.  "statement": the start of a line of a stored program.  Raises UsageError.
        """
        self.pause()
        with steps.StepObserver(self.bench, kind) as observer, self._moving(f"the next {kind}"):
            end_ns = self.bench.now + steps.MAX_S * S
            while self._state is State.MOVING and not observer.seen:
                if not self.pacer.advance_slice(partial(self._step, observer, end_ns)):
                    observer.end_message()
                    break
                await asyncio.sleep(0)
            return observer.seen

    def add_break(self, sentence: str) -> Break:
        """Add a breakpoint at an event, e.g. "table.X passes 1000".  Raises UsageError."""
        self._check_free()
        self.breaks.append(Break(sentence, self.bench, self._hit))
        return self.breaks[-1]

    def remove_break(self, which: Break) -> None:
        """Remove a breakpoint.  A breakpoint that has already been removed is ignored."""
        which.on = False
        self.breaks[:] = [each for each in self.breaks if each is not which]

    def run_until(self, sentence: str) -> None:
        """Run until an event, e.g. "table.X passes 1000", or a breakpoint.  Raises UsageError if it is invalid."""
        self._check_free()
        self._set_target(Break(sentence, self.bench, self._hit, once=True))
        self.run()

    def _step(self, observer: steps.StepObserver, end_ns: int, over: Callable[[], bool]) -> bool:
        return steps.advance(
            self.bench,
            lambda: min(end_ns, observer.end_ns),
            lambda: observer.seen or self._state is not State.MOVING or self._replayed or over(),
        )

    def _run_to(self, time_ns: int, over: Callable[[], bool]) -> bool:
        return steps.run_to(self.bench.clock, time_ns, lambda: self._state is not State.MOVING or over())

    def _hit(self, which: Break) -> None:
        self.pacer.stop()
        if self._state not in (State.HALTED, State.MOVE_HALTED):
            self._halt(which.sentence if which.once else f"break: {which.sentence}")

    def _on_failure(self, error: AxistwinError) -> None:
        """Pause the session, because a planned action has failed.  During `go_to`, only log the error."""
        log.warning("%s", error)
        if self.progress is None:
            self.pacer.stop()
            self._halt(str(error))

    def _halt(self, why: str) -> None:
        self.halted_by, self._state = why, State.MOVE_HALTED if self.busy else State.HALTED
        self._set_target(None)

    def _set_target(self, target: Break | None) -> None:
        if self._target is not None:
            self._target.on = False
        self._target = target

    # Going back in time

    @property
    def recorded_seconds(self) -> float:
        """Virtual time at the end of the recording, in seconds.  `go_to` accepts any time up to this end."""
        return to_seconds(self._recorded)

    @property
    def repeating(self) -> bool:
        """True while recorded input is replayed and hosts at real ports are blocked."""
        return self._replay is not None

    def give_up(self) -> None:
        """Abort `step` or `go_to` at the present virtual time."""
        if self.busy:
            self._state = State.MOVE_ABORTED

    async def go_to(self, seconds: float) -> None:
        """Go to a recorded virtual time, and pause.  Raises UsageError for a time that is not recorded."""
        time_ns = to_ns(seconds)
        if not 0 <= time_ns <= self._recorded:
            raise UsageError(f"time {seconds:g} s is not recorded: expected 0 to {self.recorded_seconds:.3f} s")
        self.pause()
        with self._moving(f"{figures(seconds)} s"):
            if time_ns < self.bench.now:
                self._restart(self._recorded)
            await self._advance_to(time_ns)

    def restart(self) -> None:
        """Start again at virtual time 0, and delete the recording.  `undo` restores the recording."""
        self.pause()
        with self._moving("0 s"):
            for each in self.breaks:
                each.suspend()
            self._restart(self._recorded)
            for each in self.breaks:
                each.resume(self.bench)
        self.forget_rest("Restart")
        self.run()

    async def advance_to(self, seconds: float) -> None:
        """Run at full speed to a later virtual time.

        If the session was running, then continue at the previous speed; otherwise pause.  A breakpoint ends the move.
        Raises UsageError for an earlier time.
        """
        time_ns, was_running = to_ns(seconds), self.running
        if time_ns < self.bench.now:
            raise UsageError(f"time {seconds:g} s has already passed: expected a time after {self.seconds:.3f} s")
        self.pause()
        with self._moving(f"{figures(seconds)} s"):
            since_ns = self.bench.now
            while self._state is State.MOVING and self.bench.now != time_ns:
                self.progress = (self.bench.now - since_ns) / max(1, time_ns - since_ns)
                self.pacer.advance_slice(partial(self._run_to, time_ns))
                await asyncio.sleep(0)
            completed = self._state is State.MOVING
        if was_running and completed:
            self.run()

    def forget_rest(self, by: str = "Live from here") -> None:
        """Delete the recording after now, so that new input is accepted; `undo` restores it.  `by`: see `undoes`."""
        self._check_free()
        self.pacer.sync()
        if self._replay is not None:
            recorded_ns, at_ns = self._recorded, self.bench.now
            self._forgotten = Forgotten(at_ns, recorded_ns, self._replay.abandon(), monotonic(), by)
            self._end_replay()

    @property
    def undo_seconds(self) -> float:
        """Seconds of wall-clock time for which `undo` is still possible; 0 if it is impossible."""
        return 0.0 if self._forgotten is None else max(0.0, self._forgotten.since_s + UNDO_S - monotonic())

    @property
    def undoes(self) -> str:
        """What `undo` would undo, e.g. "Restart"; "" if nothing."""
        return "" if self._forgotten is None else self._forgotten.by

    async def undo(self) -> None:
        """Restore what was deleted last, and pause at the time of the deletion.  Raises UsageError."""
        self._check_free()
        found, self._forgotten = self._forgotten, None
        if found is None:
            raise UsageError("cannot undo a deletion: no part of the recording has been deleted since the last undo")
        self.pause()
        self.journal.restore(found.tail)
        with self._moving(f"{figures(to_seconds(found.at_ns))} s"):
            self._restart(found.recorded_ns)
            await self._advance_to(found.at_ns)

    @property
    def _recorded(self) -> int:
        ns = max(self._recorded_ns, self.bench.now)
        full_ns = self.journal.full_ns
        return ns if full_ns is None else min(ns, max(0, full_ns - 1))

    def _restart(self, recorded_ns: int) -> None:
        for controller in self.bench.controllers.values():
            if isinstance(controller.store, FileStore):
                controller.store.put_back()
        # If the new controllers cannot be built, the session keeps the old controllers.
        bench = self._build()
        self.input.mute()
        self.show(bench)
        self._recorded_ns = recorded_ns
        self._replay = Replay(self.bench.clock, self.journal, self.input.replay, recorded_ns, self._end_slice)

    def advance(self, time_ns: int) -> None:
        """Advance a paused session to a virtual time in nanoseconds.  Raises UsageError for a running session."""
        self._check_free()
        if self.running:
            raise UsageError("cannot advance a running session: pause the session first")
        self.pacer.advance_slice(lambda _: self.bench.clock.run_to(time_ns))

    async def _advance_to(self, time_ns: int) -> None:
        since_ns = self.bench.now
        for each in self.breaks:
            each.suspend()
        try:
            while self._state is not State.MOVE_ABORTED and (
                self.bench.now != time_ns or (self._replay is not None and self._replay.is_due_by(time_ns))
            ):
                self.progress = (self.bench.now - since_ns) / max(1, time_ns - since_ns)
                self.pacer.advance_slice(partial(steps.run_to, self.bench.clock, time_ns))
                await asyncio.sleep(0)
        finally:
            for each in self.breaks:
                each.resume(self.bench)

    @contextmanager
    def _moving(self, heading: str) -> Iterator[None]:
        self._state, self.waiting, self.heading = State.MOVING, False, heading
        try:
            yield
        finally:
            self.progress = None
            self._state = State.HALTED if self._state is State.MOVE_HALTED else State.IDLE

    @property
    def _replayed(self) -> bool:
        return self._replay is not None and self._replay.finished

    def _end_slice(self) -> None:
        self.pacer.speed = self.pacer.speed

    def _after_advance(self) -> None:
        """End a completed replay, and discard data for ports without a client, after each advance."""
        if self._replayed:
            self._end_replay()
        if self.pacer.passes % DRAIN_EVERY == 0:
            for name, port in self.bench.ports.items():
                if not self.client(name):
                    port.read()

    def _end_replay(self) -> None:
        self._replay, self._recorded_ns = None, self.bench.now
        self.input.unmute()

    # Saving

    def save(self) -> dict[str, str]:
        """Return the texts of a scene and its files, by name, with which `axistwin run` repeats the recording."""
        texts, end_ns = self.input.texts, self._recorded
        return saving.files(self._scene, self._served, self.bench, self.journal, texts, end_ns)
