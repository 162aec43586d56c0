"""An axis with one motion at a time: the latest request wins, and a motion ends with the exact position."""

import asyncio
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from enum import Enum, auto
from typing import TYPE_CHECKING

from axistwin.drivers.axis import Status
from axistwin.drivers.errors import BusyError, DriverError, RefusedError
from axistwin.drivers.steps import Procedure
from axistwin.plant.machine_units import MachineUnits

if TYPE_CHECKING:
    from axistwin.plant.axes import Axis
    from axistwin.real.integrations.station import Station


class Phase(Enum):
    """Activity of the axis, as far as requests and polls tell."""

    REST = auto()
    BEGINNING = auto()  # The request that begins a motion is in progress.
    BEGUN = auto()  # A motion has begun; it may have failed without an answer.
    STOPPING = auto()  # The controller has received a stop.


@dataclass
class Goal:
    """A requested motion.  `begin` starts it; `target`: the end position in counts, None for a run."""

    begin: Callable[[], Procedure[None]]
    target: int | None = None
    homing: bool = False
    failure: str = ""  # Why the motion failed; "" if it did not.
    begun: asyncio.Event = field(default_factory=asyncio.Event)  # Set when it has begun, failed or been replaced.


class DrivenAxis:
    """An axis of a station.  All positions are in counts.

    A motion is `busy` from its request to the reading of the exact position at rest.  A move that the controller cannot
    accept yet, because another axis of an IF1 is moving, waits.
    """

    def __init__(self, station: "Station", name: str, units: MachineUnits) -> None:
        self.station, self.name, self.units = station, name, units
        self.core = station.driver.core.axes[name]
        self.status = Status(0, 0, 0, False)  # Status of the last poll.
        self.error = "not connected yet"  # Why the last poll failed; "" if it did not.
        self.shaft: Axis | None = None  # The axis of the bench; None at a real controller.
        self.goal: Goal | None = None
        self.ended: Goal | None = None  # The motion that ended last; None if another host began it.
        self.busy = False
        self.changed: Callable[[], Awaitable[None]] = _nothing  # Called after each poll and each request.
        self._starting: Goal | None = None
        self._stopped: Goal | None = None  # The motion that a request has stopped, until the axis is at rest.
        self._phase = Phase.REST
        self._stop: Callable[[], Procedure[None]] | None = None  # Still to be sent; a poll repeats it after an error.
        self._rest, self._go = asyncio.Event(), asyncio.Event()
        self._rest.set()
        self._go.set()
        self._tasks: set[asyncio.Task[None]] = set()

    @property
    def paused(self) -> bool:
        return not self._go.is_set()

    def travel(self) -> tuple[float, float] | None:
        """Return the positions of the limit switches in the driver's counts, or None if they are not known."""
        if self.shaft is None or self.shaft.limits is None:
            return None
        shift = self.status.position - self.shaft.position
        return self.shaft.limits[0] + shift, self.shaft.limits[1] + shift

    # Requests

    async def move_to(self, target: int) -> None:
        """Move and return on arrival.  Raises RefusedError if it stops elsewhere, by a stop or by another request."""
        await self.request(Goal(lambda: self.core.move_to(target), target))

    async def move_at(self, velocity: float) -> None:
        """Run at a signed velocity; return when the run has been stopped.  Raises RefusedError if it fails."""
        await self.request(Goal(lambda: self.core.move_at(velocity)))

    async def home(self, direction: int) -> None:
        """Search for home; return at rest.  Raises RefusedError if it is not found, or a stop or request ends it."""
        await self.request(Goal(lambda: self.core.home(direction), homing=True))

    async def request(self, goal: Goal) -> None:
        """Begin a motion; return when the axis is at rest.  Raises RefusedError if the motion fails."""
        await self.begin(goal)
        await self._rest.wait()
        if reason := goal.failure:
            raise RefusedError(f"the motion failed: {reason}")

    async def begin(self, goal: Goal) -> None:
        """Request a motion.  The motion begins as soon as the axis is at rest."""
        self._give_up("another request replaced the motion")
        self.goal = self._starting = goal
        self._now_busy()
        await self.changed()
        self._spawn(goal)

    async def stop(self, *, abort: bool = False) -> None:
        """Send a stop; the axis stays busy until it is at rest.  After an error the next poll sends it again."""
        self._give_up("a client stopped the axis")
        self.goal = self._starting = None
        await self._end_motion(self.core.abort if abort else self.core.stop)
        self.station.wake()

    def _give_up(self, why: str) -> None:
        """Note the motion in progress as one that a request ends; a run ends in this way without a failure."""
        if (goal := self.goal) is not None:
            self._stopped = goal
            if goal.target is not None or goal.homing:
                goal.failure = goal.failure or why

    async def pause(self) -> None:
        """Stop the axis; `resume` continues a move, but no run and no search for home."""
        self._go.clear()
        goal = self.goal
        if goal is None or goal.target is None:
            await self.stop()
        elif self._starting is None:
            self._starting = goal
            self._spawn(goal)
            await self._end_motion(self.core.stop)

    def resume(self) -> None:
        self._go.set()

    async def set_position(self, position: int) -> None:
        """Define the present position, at rest.  Raises DriverError."""
        await self.station.driver.run(self.core.set_position(position))
        self.station.wake()
        await self.station.polled()

    async def clear_faults(self) -> None:
        """Clear the stored faults of the axis.  A fault remains as long as its cause is present."""
        await self.station.driver.run(self.core.clear_faults())
        self.ended = None
        self.station.wake()

    # Beginning

    def _spawn(self, goal: Goal) -> None:
        task = asyncio.get_running_loop().create_task(self._begin(goal))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def close(self) -> None:
        for task in self._tasks:
            task.cancel()

    async def _begin(self, goal: Goal) -> None:
        try:
            while self.goal is goal and not await self._begins(goal):
                await self.station.polled()
            if self.goal is None:  # Stop the axis if a client has requested a stop while the motion was being started.
                self._stop = self.core.stop
        except DriverError as error:
            goal.failure = str(error)
            if goal.target is None:
                self._stop = self.core.stop
        finally:
            if self._starting is goal:
                self._starting = None
            goal.begun.set()
            self.station.wake()

    async def _begins(self, goal: Goal) -> bool:
        """Begin a motion.  Returns False if it has to wait for the end of another motion, of this or another axis."""
        await self._go.wait()
        if self.goal is not goal:
            return True
        if self._in_motion:
            if self._phase is not Phase.STOPPING:
                await self._end_motion(self.core.stop)
            return False
        self._phase = Phase.BEGINNING
        try:
            await self.station.driver.run(goal.begin())
        except BusyError:
            self._phase = Phase.REST
            return False
        finally:
            if self._phase is Phase.BEGINNING:
                self._phase = Phase.BEGUN
        if self.paused:
            await self._end_motion(self.core.stop)
            return False
        return True

    async def _end_motion(self, request: Callable[[], Procedure[None]]) -> None:
        if self._in_motion:
            self._stop = request
            await self.station.driver.run(request())
            self._stop, self._phase = None, Phase.STOPPING

    @property
    def _in_motion(self) -> bool:
        return self._phase is not Phase.REST or self.status.moving

    def _now_busy(self) -> None:
        self.busy = True
        self._rest.clear()

    # Polls

    async def update(self, status: Status) -> None:
        before, self.status, self.error = self.status, status, ""
        if status.moving:
            await self._moving(slower=abs(status.velocity) < abs(before.velocity))
        else:
            if self._phase is not Phase.BEGINNING:
                self._stop, self._phase = None, Phase.REST
                if self.busy and self._starting is None:
                    self._end(status)
        await self.changed()
        if not self.busy:
            self._rest.set()

    async def _moving(self, *, slower: bool) -> None:
        """Process a poll of a moving axis.  A board ignores a stop before the motion has begun: then stop again."""
        if self._phase is Phase.REST:
            self._phase = Phase.BEGUN
        if not self.busy:  # Another host has begun the present motion of the axis.
            self.goal = None
            self._now_busy()
        if self._phase is Phase.STOPPING and not slower:
            self._stop = self.core.stop
        if self._stop is not None:
            await self._end_motion(self._stop)

    def _end(self, status: Status) -> None:
        self.ended = goal = self.goal or self._stopped
        self.goal = self._stopped = None
        self.busy = False
        if goal is not None and not goal.failure and status.missed:
            goal.failure = f"{self.name} stopped: {status.missed}"

    async def failed(self, error: DriverError) -> None:
        """Record an unanswered poll; a motion counts as busy until the controller answers again."""
        self.error = str(error)
        await self.changed()


async def _nothing() -> None: ...
