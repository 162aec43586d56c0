"""Steps: advance to the next visible event, the next program line, or the next start or end of a motion."""

from collections.abc import Callable
from contextlib import ExitStack
from typing import Self

from axistwin.bench import Bench, endpoints
from axistwin.bench.events import Event, Received, Sent, observing
from axistwin.core.errors import UsageError
from axistwin.core.units import MS
from axistwin.plant.servo_axis import ServoAxis
from axistwin.sim.clock import Clock

KINDS = "event", "character", "statement", "move"
PAUSE_NS = 50 * MS  # Longest pause in ns between two characters of one message.
NEVER_NS = 1 << 63
MAX_S = 60  # Longest virtual time of a step in seconds.


class StepObserver:
    """Detects the end of a step within a `with` block; `kind`: the kind of step."""

    def __init__(self, bench: Bench, kind: str) -> None:
        if kind not in KINDS:
            raise UsageError(f"unknown kind of step {kind!r}: expected one of {', '.join(KINDS)}")
        self.bench, self.kind = bench, kind
        self._seen = False
        self._talk: tuple[str, bool] | None = None
        """Endpoint of the present message, and True for a message of the host."""
        self.end_ns = NEVER_NS  # Time at which the present message ends unless another character follows.
        self._moving = self._movements()

    def __enter__(self) -> Self:
        self._stack = ExitStack()
        if self.kind in ("event", "character"):
            self._stack.enter_context(observing(self.bench, self._see_event if self.kind == "event" else self._see))
        elif self.kind == "statement":
            for controller in self.bench.controllers.values():
                self._stack.callback(controller.subscribe_lines(self._see))
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    @property
    def seen(self) -> bool:
        return self._seen or (self.kind != "statement" and self._movements() != self._moving)

    def end_message(self) -> None:
        """End the step if a message is in progress, because the message has ended."""
        self._seen = self._seen or self._talk is not None

    def _see_event(self, event: Event) -> None:
        if not isinstance(event, Sent | Received) or endpoints.at_a_bus(self.bench, event.controller):
            self._seen = True
            return
        talk = event.controller, isinstance(event, Sent)
        self._seen = event.data[-1:] in (b"\r", b"\n") or self._talk not in (None, talk)
        self._talk, self.end_ns = talk, event.time_ns + PAUSE_NS

    def _see(self, *_: object) -> None:
        self._seen = True

    def _movements(self) -> list[tuple[bool, int]]:
        """Return for each axis whether it moves; for a stepper axis, also the start time of its move."""
        return [
            (axis.moving, 0 if isinstance(axis, ServoAxis) else axis.train.move.start_ns)
            for controller in self.bench.controllers.values()
            for axis in controller.axes.values()
        ]


def advance(bench: Bench, end_ns: Callable[[], int], done: Callable[[], object]) -> bool:
    """Execute events in order of time until `done()` returns True.

    Return False if no event is due by the time `end_ns()`.  While a servo moves, each of its samples is an event.
    """
    clock = bench.clock
    axes = (axis for controller in bench.controllers.values() for axis in controller.axes.values())
    servos = [axis for axis in axes if isinstance(axis, ServoAxis)]
    while not done():
        times_ns = [clock.next_event_ns(), *(axis.next_sample_ns() for axis in servos)]
        due_ns = min((time_ns for time_ns in times_ns if time_ns is not None), default=None)
        if due_ns is None or due_ns > end_ns():
            return False
        clock.run_to(due_ns)
    return True


def run_to(clock: Clock, end_ns: int, over: Callable[[], bool]) -> bool:
    """Execute events up to `end_ns`, or until `over` is True.  Return True if `end_ns` is reached."""
    while not over():
        due_ns = clock.next_event_ns()
        if due_ns is None or due_ns > end_ns:
            clock.run_to(end_ns)
            return True
        clock.step()
    clock.run_to(clock.now)
    return False
