"""The work in progress (a move, run or sequence), and the message that is held until the work has finished."""

from collections.abc import Callable
from functools import partial

from axistwin.controllers.digiplan.chapters.motion import RampGenerator
from axistwin.controllers.digiplan.step import EndOfWork
from axistwin.sim.clock import Clock, Event, Interrupt, Moment, Procedure, Process, interrupt, kill


class Work:
    """Carries out moves, runs and sequences, one at a time.  A sequence can give control to the host."""

    def __init__(self, clock: Clock, motion: RampGenerator, on_free: Callable[[], None]) -> None:
        self.clock, self.motion, self._on_free = clock, motion, on_free
        self.process: Process | None = None
        self.control: Event | None = None  # Event that continues the sequence, while the host has control.
        self.held: Process | None = None
        self.released = Moment(clock)  # The held message has begun or is deleted.
        self._freed: Event | None = None

    @property
    def occupied(self) -> bool:
        """True while a move, run or sequence is in progress.  False while the host has control of the sequence."""
        return self.process is not None and self.control is None

    @property
    def busy(self) -> bool:
        """True while a move, run or sequence is in progress or a message waits; not while the host has control."""
        return self.occupied or self.held is not None or self.motion.running

    def begin(self, procedure: Procedure) -> None:
        self.process = self.clock.process(self._run(procedure))

    def _run(self, procedure: Procedure) -> Procedure:
        try:
            yield from procedure
        except (EndOfWork, Interrupt):
            self.motion.decelerate()
        while self.motion.running:
            try:
                yield self.motion.ended
            except Interrupt:
                self.motion.decelerate()
        self.process = self.control = None
        self._free()

    def _free(self) -> None:
        self._on_free()
        if self._freed is not None:
            freed, self._freed = self._freed, None
            freed.succeed()

    def cancel(self) -> None:
        self.drop_held()
        self.motion.decelerate()
        if self.process is not None:
            self.control = None
            # `interrupt` has no effect on a running process.  Call `interrupt` when the process has reached a `yield`.
            if self.process is self.clock.active_process:
                self.clock.soon(partial(interrupt, self.process))
            else:
                interrupt(self.process)

    def stop(self) -> None:
        for process in (self.held, self.process):
            if process is not None:
                kill(process)

    def give_control(self) -> Event:
        """Give control to the host.  The returned event gets the host's next step, or None to continue the sequence."""
        self.control = self.clock.event()
        self._free()
        return self.control

    def take_control(self) -> Event | None:
        """End the host's control; return the event that continues the sequence, or None without such control."""
        control, self.control = self.control, None
        return control

    def when_free(self, begin: Procedure) -> Procedure | None:
        """Return `begin` if no work is in progress; otherwise hold it until the work has finished, and return None."""
        if not self.occupied:
            return begin
        self.held = self.clock.process(self._hold(begin))
        return None

    def _hold(self, begin: Procedure) -> Procedure:
        while self.occupied:
            self._freed = self.clock.event()
            yield self._freed
        yield from begin
        self._release()

    def drop_held(self) -> None:
        if self.held is not None:
            kill(self.held)
            self._release()

    def _release(self) -> None:
        self.held = None
        self.released.happens()
