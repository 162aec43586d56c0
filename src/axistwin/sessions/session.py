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
from axistwin.errors import AxistwinError, UsageError
from axistwin.links.pacing import Pacer
from axistwin.links.server import Server
from axistwin.scenes.scene import Scene
from axistwin.scenes.tables import OperatorTable
from axistwin.sessions import programs, saving, steps
from axistwin.sessions.breaks import Break
from axistwin.sessions.external_input import ExternalInput, Replay
from axistwin.sessions.journal import Journal, Tail
from axistwin.sim.serial_port import Flow
from axistwin.storage import FileStore
from axistwin.units import S, to_ns, to_seconds

log = getLogger("axistwin")

T = TypeVar("T")
Attach = Callable[[Bench], object]
DRAIN_EVERY = 1 << 12
"""Number of clock advances between two readings of ports without a client."""


class State(Enum):
    """State of a session: paused, running or moving to another virtual time.

    A session is moving while a `step` or a `go_to` is in progress.
    """

    IDLE = auto()
    """Paused at the beginning, or after a completed move."""
    RUNNING = auto()
    HALTED = auto()
    """Paused by a user, a breakpoint or an error."""
    MOVING = auto()
    MOVE_HALTED = auto()
    """A breakpoint or an error is ending the move."""
    MOVE_ABORTED = auto()
    """A user is ending the move."""


UNDO_S = 10.0
"""Time in seconds during which the panel offers to undo a deletion of recorded actions."""


@dataclass(frozen=True)
class Forgotten:
    """The deleted part of a recording, which `undo` can restore."""

    at_ns: int
    """Virtual time at which the part was deleted."""
    recorded_ns: int
    """End of the recording."""
    tail: Tail
    since_s: float
    """Wall-clock time at which the part was deleted."""


class Session:
    """An interactive session, which runs, pauses and replays a simulation of motion controllers.

    `build` creates a bench.

    `speed`: multiple of real time; None: as fast as possible.  `scene`: the scene that `build` builds; needed for
    `save`.  `served`: the scene was built without hosts for controllers with ports.  `run` needs a running event loop.
    """

    def __init__(
        self, build: Callable[[], Bench], speed: float | None = 1.0, *, scene: Scene | None = None, served: bool = False
    ) -> None:
        self._build, self._scene, self._served = build, scene, served
        self.bench = build()
        """The present bench; going back in time replaces it."""
        self.pacer = Pacer(self.bench.clock, speed)
        self.server: Server | None = None
        """The server of real ports; None before `serve`."""
        self.breaks: list[Break] = []
        self.halted_by = ""
        """Text of the breakpoint or error that has stopped the bench; "" if a user has paused the bench."""
        self.progress: float | None = None
        """Progress of `go_to`, 0 to 1; None if not active."""
        self.input = ExternalInput(self.pacer)
        """External input; its `serial(name)` and `bus(name)` are ports for hosts, whose actions are recorded."""
        self.input.attach(self.bench)
        self.waiting = False
        """True after `wait`, until virtual time starts."""
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
        """True if the scene's script and hosts have ended, and no event is due.

        Always False for a scene without a script and without hosts.
        """
        bench = self.bench
        has_plan = bool(bench.planned or bench.senders or bench.attendants)
        return has_plan and bench.clock.quiet and bench.now >= bench.agenda_ns

    @property
    def seconds(self) -> float:
        """Present virtual time in seconds.

        While no event is due, the bench is not advanced, so this time can be in the past.
        """
        return to_seconds(self.bench.now)

    def each_bench(self, attach: Attach) -> None:
        """Call the function `attach(bench)` now, and again after each restart of the simulation.

        The bench is the set of simulated controllers.  A restart of the simulation creates a new bench.  `attach` is
        called before the first event of the new bench.
        """
        self._attached.append(attach)
        attach(self.bench)

    def serve(self, *, flow: Flow = Flow.DTR, reset: bool = False, share: bool = False) -> Server:
        """Create the server that connects hosts outside this process to the ports of the session.

        The clients of the server stay connected when the bench is replaced.
        """
        self.pacer.sync()
        resets = self._power_cycle if reset else False
        self.server = Server(self.bench, pacer=self.pacer, flow=flow, reset=resets, access=self.input, share=share)
        self.input.serve(self.server)
        self.server.gate.admitted.subscribe(self.welcome)
        return self.server

    def client(self, name: str) -> str:
        """Return the address of the client that is connected to an endpoint, e.g. `127.0.0.1:4711`.

        Return "" if no client is connected.
        """
        return "" if self.server is None else self.server.client(name)

    @property
    def journal(self) -> Journal:
        """The journal, which records the external input of the session."""
        return self.input.journal

    # Actions of users

    def do(self, who: str, target: str, value: str) -> None:
        """Perform an action of a user, e.g. set the input `input1` of a controller to `high`.

        `who`: the name of the controller or of the shared line.  `target` and `value` are those of a program line
        `! target value` in a conversation.  Raises AxistwinError.
        """
        self._do(Do(target, value, controller=who))

    def say(self, name: str, data: bytes) -> None:
        """Send data to an endpoint, as a host does.

        The data are characters; for a board on a bus, one whole command.

        Raises AxistwinError for an unknown name or an invalid command.
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
        """Switch a controller, or each controller on a bus, off and on again."""
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
        """True while virtual time advances to an event (method `step`) or to a time (method `go_to`).

        The session then accepts no actions.
        """
        return self._state in (State.MOVING, State.MOVE_HALTED, State.MOVE_ABORTED)

    @property
    def running(self) -> bool:
        """True while virtual time passes."""
        return self._state is State.RUNNING

    @property
    def speed(self) -> float | None:
        """Speed as a multiple of real time; None: as fast as possible.

        Setting an invalid speed raises UsageError.
        """
        return self.pacer.speed

    @speed.setter
    def speed(self, speed: float | None) -> None:
        self.pacer.speed = speed

    def wait(self) -> None:
        """Delay the start of virtual time until the first host or browser connects."""
        self.waiting = True

    def welcome(self) -> None:
        """Start virtual time at the first connection of a host or browser.

        No effect unless the method `wait` has delayed the start.
        """
        if self.waiting and not self.busy:
            self.run()

    def inspect(self, read: Callable[[], T]) -> T:
        """Return the result of the function `read`, which reads the state of the simulation.

        In a running session, virtual time first catches up with the wall clock.
        """
        return self.pacer.inspect(read) if self.running else read()

    def run(self) -> None:
        """Start virtual time, which passes until a pause, a breakpoint or an error."""
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

        Return False if no such event occurs within 60 virtual seconds.

        "event": a change of a pin, a message, a fault, or the start or end of a motion.  "character": the same, but
        each character of a message is an event.  "move": the start or end of a motion.  "statement": the start of a
        line of a stored program.  Raises UsageError.
        """
        self.pause()
        with steps.StepObserver(self.bench, kind) as observer, self._moving():
            end_ns = self.bench.now + steps.MAX_S * S
            while self._state is State.MOVING and not observer.seen:
                if not self.pacer.advance_slice(partial(self._step, observer, end_ns)):
                    observer.end_message()
                    break
                await asyncio.sleep(0)
            return observer.seen

    def add_break(self, sentence: str) -> Break:
        """Add a breakpoint at an event, e.g. "table.X passes 1000".

        Raises UsageError.
        """
        self._check_free()
        self.breaks.append(Break(sentence, self.bench, self._hit))
        return self.breaks[-1]

    def remove_break(self, which: Break) -> None:
        """Remove a breakpoint.  A breakpoint that has already been removed is ignored."""
        which.on = False
        self.breaks[:] = [each for each in self.breaks if each is not which]

    def run_until(self, sentence: str) -> None:
        """Run until a given event, e.g. "table.X passes 1000", or until a breakpoint.

        Raises UsageError for an invalid sentence.
        """
        self._check_free()
        self._set_target(Break(sentence, self.bench, self._hit, once=True))
        self.run()

    def _step(self, observer: steps.StepObserver, end_ns: int, over: Callable[[], bool]) -> bool:
        """Advance virtual time to the next event of the kind that `observer` detects, e.g. the start of a motion.

        Stop earlier if the function `over` returns True.

        Return False if no event is left.
        """
        return steps.advance(
            self.bench,
            lambda: min(end_ns, observer.end_ns),
            lambda: observer.seen or self._state is not State.MOVING or self._replayed or over(),
        )

    def _run_to(self, time_ns: int, over: Callable[[], bool]) -> bool:
        """Advance virtual time to `time_ns`, or until the function `over` returns True.

        Return True if `time_ns` is reached.
        """
        return steps.run_to(self.bench.clock, time_ns, lambda: self._state is not State.MOVING or over())

    def _hit(self, which: Break) -> None:
        """Pause the session, because a breakpoint has been reached."""
        self.pacer.stop()
        if self._state not in (State.HALTED, State.MOVE_HALTED):
            self._halt(which.sentence if which.once else f"break: {which.sentence}")

    def _on_failure(self, error: AxistwinError) -> None:
        """Pause the session, because a planned action has failed.

        During `go_to`, only log the error.
        """
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
        """Virtual time at the end of the recording, in seconds.

        `go_to` accepts any time up to this end.
        """
        return to_seconds(self._recorded)

    @property
    def repeating(self) -> bool:
        """True while the session replays its recorded input.

        During the replay, hosts at real ports cannot exchange data with the controllers.
        """
        return self._replay is not None

    def give_up(self) -> None:
        """Abort `step` or `go_to` at the present virtual time."""
        if self.busy:
            self._state = State.MOVE_ABORTED

    async def go_to(self, seconds: float) -> None:
        """Go back or forward to a recorded virtual time, and pause.

        Raises UsageError for a time that is not recorded.
        """
        time_ns = to_ns(seconds)
        if not 0 <= time_ns <= self._recorded:
            raise UsageError(f"time {seconds:g} s is not recorded: expected 0 to {self.recorded_seconds:.3f} s")
        self.pause()
        with self._moving():
            if time_ns < self.bench.now:
                self._restart(self._recorded)
            await self._advance_to(time_ns)

    def restart(self) -> None:
        """Start again at virtual time 0, and delete the recording.

        `undo` restores the recording.
        """
        self.pause()
        with self._moving():
            for each in self.breaks:
                each.suspend()
            self._restart(self._recorded)
            for each in self.breaks:
                each.resume(self.bench)
        self.forget_rest()
        self.run()

    async def advance_to(self, seconds: float) -> None:
        """Run at full speed to a later virtual time.

        If the session was running, then continue at the previous speed; otherwise pause.

        A breakpoint ends the move.

        Raises UsageError for an earlier time.
        """
        time_ns, was_running = to_ns(seconds), self.running
        if time_ns < self.bench.now:
            raise UsageError(f"time {seconds:g} s has already passed: expected a time after {self.seconds:.3f} s")
        self.pause()
        with self._moving():
            since_ns = self.bench.now
            while self._state is State.MOVING and self.bench.now != time_ns:
                self.progress = (self.bench.now - since_ns) / max(1, time_ns - since_ns)
                self.pacer.advance_slice(partial(self._run_to, time_ns))
                await asyncio.sleep(0)
            completed = self._state is State.MOVING
        if was_running and completed:
            self.run()

    def forget_rest(self) -> None:
        """Delete the part of the recording after the present virtual time.

        The session then accepts new input.  `undo` restores the deleted part.
        """
        self._check_free()
        self.pacer.sync()
        if self._replay is not None:
            recorded_ns, at_ns = self._recorded, self.bench.now
            self._forgotten = Forgotten(at_ns, recorded_ns, self._replay.abandon(), monotonic())
            self._end_replay()

    @property
    def undo_seconds(self) -> float:
        """Number of seconds (real time) during which the panel still shows the button *Undo*.

        0 if the panel does not show the button.
        """
        return 0.0 if self._forgotten is None else max(0.0, self._forgotten.since_s + UNDO_S - monotonic())

    async def undo(self) -> None:
        """Undo the latest deletion of recorded actions.

        The session pauses at the virtual time of the deletion.  Raises UsageError.
        """
        self._check_free()
        found, self._forgotten = self._forgotten, None
        if found is None:
            raise UsageError("cannot undo a deletion: no part of the recording has been deleted since the last undo")
        self.pause()
        self.journal.restore(found.tail)
        with self._moving():
            self._restart(found.recorded_ns)
            await self._advance_to(found.at_ns)

    @property
    def _recorded(self) -> int:
        ns = max(self._recorded_ns, self.bench.now)
        full_ns = self.journal.full_ns
        return ns if full_ns is None else min(ns, max(0, full_ns - 1))

    def _restart(self, recorded_ns: int) -> None:
        """Rebuild the controllers at virtual time 0, and begin to replay the recording.

        `recorded_ns`: end of the recording.
        """
        for controller in self.bench.controllers.values():
            if isinstance(controller.store, FileStore):
                controller.store.put_back()
        # If the new controllers cannot be built, the session keeps the old controllers.
        bench = self._build()
        self.input.mute()
        self.bench = bench
        for attach in self._attached:
            attach(self.bench)
        self.input.attach(self.bench)
        self._recorded_ns = recorded_ns
        self._replay = Replay(self.bench.clock, self.journal, self.input.replay, recorded_ns, self._end_slice)

    def advance(self, time_ns: int) -> None:
        """Advance a paused session to a virtual time in nanoseconds.

        Raises UsageError for a running session.
        """
        self._check_free()
        if self.running:
            raise UsageError("cannot advance a running session: pause the session first")
        self.pacer.advance_slice(lambda _: self.bench.clock.run_to(time_ns))

    async def _advance_to(self, time_ns: int) -> None:
        """Advance virtual time to `time_ns` without stopping at breakpoints."""
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
    def _moving(self) -> Iterator[None]:
        """Mark the session as busy until the end of a `with` block."""
        self._state, self.waiting = State.MOVING, False
        try:
            yield
        finally:
            self.progress = None
            self._state = State.HALTED if self._state is State.MOVE_HALTED else State.IDLE

    @property
    def _replayed(self) -> bool:
        """True if a replay has reached its end, but `_end_replay` has not been called yet."""
        return self._replay is not None and self._replay.finished

    def _end_slice(self) -> None:
        """End the present slice (an uninterrupted advance of virtual time) early.

        The pacer, which advances virtual time, then calls `_after_advance`.
        """
        self.pacer.speed = self.pacer.speed

    def _after_advance(self) -> None:
        """End a completed replay.  Discard data that controllers have sent to ports without a client.

        Called after each advance of virtual time.
        """
        if self._replayed:
            self._end_replay()
        if self.pacer.passes % DRAIN_EVERY == 0:
            for name, port in self.bench.ports.items():
                if not self.client(name):
                    port.read()

    def _end_replay(self) -> None:
        """End the replay of the recorded input.

        Hosts at real ports can then exchange data with the controllers again.
        """
        self._replay, self._recorded_ns = None, self.bench.now
        self.input.unmute()

    # Saving

    def save(self) -> dict[str, str]:
        """Convert the recorded session to the files of a scene, and return the text of each file.

        The result is a dictionary from file name to text.  The command `axistwin run` then repeats the session.
        """
        texts, end_ns = self.input.texts, self._recorded
        return saving.files(self._scene, self._served, self.bench, self.journal, texts, end_ns)
