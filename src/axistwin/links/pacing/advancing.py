"""Advance a bench; then report failed actions, apply changes of the speed, and send pending output."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Protocol, TypeVar

from axistwin.errors import AxistwinError
from axistwin.links.pacing.slices import Slice
from axistwin.sim.clock import Clock
from axistwin.sim.signal import Signal

T = TypeVar("T")


class Port(Protocol):
    """Interface of a port that stores its output while virtual time advances, and sends the output afterwards."""

    def flush(self) -> None:
        """Send the pending output of the port."""


class Advancer(ABC):
    """Advances the clock of one bench.  `plan` counts events that start or stop virtual time, or change its speed."""

    def __init__(self, clock: Clock) -> None:
        self.clock = clock
        self.advancing = False
        """True while the bench is being advanced; an action at this time is an action of the bench itself."""
        self.passes = 0
        """Number of advances.  Inputs between two advances have the same number: they arrive at the same time."""
        self.on_failure: Callable[[AxistwinError], None] | None = None
        """Function that is called with the error of a failed planned action; None: the error is raised."""
        self.on_defect: Callable[[Exception], None] | None = None
        """Function that is called with any other error of the bench (a bug of axistwin) before it is raised."""
        self._to_flush: list[Port] = []
        self._advanced: Signal[[]] = Signal()
        self.plan = 0
        self.agenda_ns = 0
        """At full speed virtual time reaches at least this value, even if no event is due."""

    def request_flush(self, port: Port) -> None:
        """Flush this port after the bench has been advanced."""
        self._to_flush.append(port)

    def subscribe(self, callback: Callable[[], None]) -> Callable[[], None]:
        """Call `callback()` after each advance of virtual time; return an unsubscribe function."""
        return self._advanced.subscribe(callback)

    def advance_slice(self, advance: Callable[[Callable[[], bool]], T]) -> T:
        """Advance the bench by one slice with `advance(over)`, outside the pacer's own advances; then flush the ports.

        `advance` must return at the end of a nanosecond, soon after `over()` is True.  Return the result of `advance`.
        """
        limit = Slice()
        found: list[T] = []
        # Call `advance` until it returns without an error.
        while not found:
            self.run(lambda: found.append(advance(limit.over)))
        self.flush()
        return found[0]

    def run(self, advance: Callable[[], None]) -> None:
        """Advance the bench; then call `follow_plan` if an event has changed `plan`."""
        plan, self.advancing = self.plan, True
        self.passes += 1
        try:
            while not self._succeeds(advance) and plan == self.plan:
                pass
            while plan != self.plan and not self._succeeds(self.finish):
                pass
        except Exception as error:
            if self.on_defect is not None:
                self.on_defect(error)
            raise
        finally:
            self.advancing = False
        if plan != self.plan:
            self.flush()
            self.follow_plan()

    def _succeeds(self, advance: Callable[[], None]) -> bool:
        try:
            advance()
        except AxistwinError as error:
            if self.on_failure is None:
                raise
            self.on_failure(error)
            return False
        return True

    def finish(self) -> None:
        """Execute all events that are due at the present virtual time."""
        self.clock.run_to(self.clock.now)

    @abstractmethod
    def follow_plan(self) -> None:
        """Carry out the latest request to start virtual time, to stop virtual time, or to change its speed."""

    def flush(self) -> None:
        """Send the pending output of all ports, then call the functions registered with `subscribe`."""
        while self._to_flush:
            ports, self._to_flush = self._to_flush, []
            for port in ports:
                port.flush()
        self._advanced.emit()
