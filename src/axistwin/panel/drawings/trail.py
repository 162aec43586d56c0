"""Where two axes have been together: the path of the latest moves, and the places at which outputs have been high.

It is worked out from what the axes remember of their motion, when somebody looks; a bench that nobody looks at does
nothing for it.  What a motor has lost meanwhile is found when it is looked at, too: a path from before is then drawn as
far off.
"""

from collections import deque
from collections.abc import Iterable, Sequence
from functools import partial

from axistwin.bench import Bench, Controller
from axistwin.plant.axes import Axis
from axistwin.plant.stepper import StepperAxis
from axistwin.sessions.session import Session
from axistwin.sim.pins import Pin

POINTS = 2048
"""So many corners of the path are kept: 64 KiB at most."""
PLACES = 512
"""So many places for each output."""
PIECES = 8
"""A stretch in which both axes move may be curved: it is drawn in so many pieces."""
MOST_MOVES = 200
"""Of more moves of an axis since the last look only the latest are drawn, as a new path."""

Point = tuple[int, int]


def table_axes(controller: Controller) -> tuple[str, str] | None:
    """The first two of its axes that have travel, which make a table; None: there are not two."""
    with_travel = [name for name, axis in controller.axes.items() if axis.limits is not None]
    return (with_travel[0], with_travel[1]) if len(with_travel) > 1 else None


class Trail:
    """The path of one table on one bench."""

    def __init__(self, controller: Controller, names: tuple[str, str]) -> None:
        self._axes = controller.axes[names[0]], controller.axes[names[1]]
        self._seen_ns = 0
        self.points: deque[Point] = deque([(0, 0)], maxlen=POINTS)
        self.begun = 1
        """How many points there have been, those that are no longer kept included."""
        self.places: dict[str, dict[Point, None]] = {}
        """By output, where it has been switched to high; the latest last."""
        for name, pin in controller.pins.items():
            if pin.is_output:
                self.places[name] = {}
                pin.subscribe(partial(self._switched, name))

    @property
    def here(self) -> Point:
        """Where the table stands."""
        return self._axes[0].position, self._axes[1].position

    def look(self) -> None:
        """Add where it has been since the last look."""
        now_ns = self._axes[0].clock.now
        if now_ns == self._seen_ns:
            return
        since_ns = max(_remembered(axis) for axis in self._axes)
        if since_ns > self._seen_ns:  # nobody knows the way there
            self._seen_ns = since_ns
            self._begin_at(*(_course(axis, (since_ns,))[0] for axis in self._axes))
        times_ns = self._moments(now_ns)
        for point in zip(*(_course(axis, times_ns) for axis in self._axes), strict=True):
            self._add(point)
        self._seen_ns = now_ns

    def _begin_at(self, x: int, y: int) -> None:
        self.points.clear()
        self.points.append((x, y))
        self.begun += POINTS

    def _switched(self, name: str, pin: Pin) -> None:
        places = self.places[name]
        if pin.level:
            places.pop(self.here, None)
            places[self.here] = None
            if len(places) > PLACES:
                del places[next(iter(places))]

    def _moments(self, now_ns: int) -> list[int]:
        """When something begins or ends since the last look, and some times between if both axes move there."""
        ends = sorted({now_ns, *(end for axis in self._axes for end in _ends(axis, self._seen_ns, now_ns))})
        found, before = [], self._seen_ns
        for end in ends:
            both = all(first != last for first, last in (_course(axis, (before, end)) for axis in self._axes))
            pieces = PIECES if both else 1
            found += [before + (end - before) * piece // pieces for piece in range(1, pieces + 1)]
            before = end
        return found

    def _add(self, point: Point) -> None:
        points = self.points
        if point == points[-1]:
            return
        if len(points) > 1 and _straight(points[-2], points[-1], point):
            points[-1] = point
        else:
            points.append(point)
            self.begun += 1


def _straight(first: Point, middle: Point, last: Point) -> bool:
    """Whether one comes through the middle on the way from the first to the last."""
    (x1, y1), (x2, y2) = (middle[0] - first[0], middle[1] - first[1]), (last[0] - middle[0], last[1] - middle[1])
    return x1 * y2 == x2 * y1 and x1 * x2 + y1 * y2 > 0


def _remembered(axis: Axis) -> int:
    """The beginning of the oldest move that is drawn."""
    if not isinstance(axis, StepperAxis) or len(axis.train.moves) <= MOST_MOVES:
        return 0
    return axis.train.moves[-MOST_MOVES].start_ns


def _ends(axis: Axis, since_ns: int, now_ns: int) -> Iterable[int]:
    """When moves of this axis begin and end, after `since_ns` and before now."""
    if not isinstance(axis, StepperAxis):
        return
    for move in reversed(axis.train.moves):
        for time_ns in (move.start_ns, move.end_ns):
            if time_ns is not None and since_ns < time_ns < now_ns:
                yield time_ns
        if move.start_ns <= since_ns:
            break


def _course(axis: Axis, times_ns: Sequence[int]) -> list[int]:
    """Where the axis was at these times, in order.  Of a servo only the present is known."""
    if not isinstance(axis, StepperAxis):
        return [axis.position] * len(times_ns)
    lost, found = axis.lost, []
    moves = reversed(axis.train.moves)
    move = next(moves)
    for time_ns in reversed(times_ns):
        while move.start_ns > time_ns and (earlier := next(moves, None)) is not None:
            move = earlier
        found.append(move.position_at(time_ns) - lost)
    return found[::-1]


class Trails:
    """The trail of each table on the bench that is there, for all who look at it."""

    def __init__(self, session: Session) -> None:
        self._those: dict[str, Trail] = {}
        session.each_bench(self._attach)

    def _attach(self, bench: Bench) -> None:
        """Begin anew with this bench."""
        tables = ((controller, table_axes(controller)) for controller in bench.controllers.values())
        self._those = {controller.name: Trail(controller, names) for controller, names in tables if names is not None}

    def __getitem__(self, name: str) -> Trail:
        """Of the controller of this name."""
        return self._those[name]
