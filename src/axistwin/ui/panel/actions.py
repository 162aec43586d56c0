"""Queue of all users' actions on one session: during a step or a `go_to`, later actions wait until it has ended."""

import asyncio
from collections import deque
from collections.abc import Awaitable, Callable
from enum import StrEnum
from functools import partial

from axistwin.scenes.sessions.session import Session
from axistwin.sim.signal import Signal


class State(StrEnum):
    """State of a session, e.g. `quiet` while paused; for tests it is in `document.body.dataset.state`."""

    BUSY = "busy"  # A step, a `go_to` or a message of the browser is being handled.
    RUNNING = "running"  # Virtual time passes.
    QUIET = "quiet"  # The bench is paused, or has no further events, and the page shows its present state.


class ActionQueue:
    """The actions that all users of a session request.  A *move* is a `step` or a `go_to`."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._waiting: deque[Callable[[bool], object]] = deque()
        """Waiting actions as functions: True performs the action, False discards it."""
        self._moving = False
        self._quiet: Signal[[]] = Signal()
        self._last = State.QUIET
        session.pacer.subscribe(self._after_advance)

    @property
    def busy(self) -> bool:
        return self._moving or self._session.busy

    @property
    def state(self) -> State:
        if self.busy or self._waiting:
            return State.BUSY
        return State.RUNNING if self._session.running and not self._idle else State.QUIET

    @property
    def _idle(self) -> bool:
        session, clock = self._session, self._session.bench.clock
        if session.speed is not None:
            return False
        return (clock.quiet and clock.now >= session.pacer.agenda_ns) or clock.next_event_ns() is None

    def do(self, act: Callable[[], object]) -> None:
        if self.busy:
            self._waiting.append(lambda perform: act() if perform else None)
        else:
            act()

    def move(self, begin: Callable[[], Awaitable[object]]) -> Awaitable[object]:
        """Begin a step or `go_to`, after the present one.  Return its result; None if `stop` has dropped it."""
        turn: asyncio.Future[bool] = asyncio.get_running_loop().create_future()
        if self.busy:
            self._waiting.append(partial(self._grant, turn))
        else:
            self._grant(turn, True)
        return self._move(begin, turn)

    def stop(self) -> None:
        self._session.give_up()
        while self._waiting:
            self._waiting.popleft()(False)

    def subscribe(self, observer: Callable[[], None]) -> Callable[[], None]:
        """Call `observer` at the state `QUIET`, and after each step or `go_to`.  Returns an unsubscribe function."""
        return self._quiet.subscribe(observer)

    def _grant(self, turn: asyncio.Future[bool], perform: bool) -> None:
        self._moving = self._moving or perform
        turn.set_result(perform)

    async def _move(self, begin: Callable[[], Awaitable[object]], turn: asyncio.Future[bool]) -> object:
        if not await turn:
            return None
        try:
            return await begin()
        finally:
            self._moving = False
            while self._waiting and not self.busy:
                self._waiting.popleft()(True)
            self._quiet.emit()

    def _after_advance(self) -> None:
        before, self._last = self._last, self.state
        if self._last is State.QUIET and before is not State.QUIET:
            self._quiet.emit()
