"""The trail of two axes: the path of the latest moves, and the points at which outputs became high.

The trail is calculated from the stored moves of the axes, and only while a page shows it.  If steps are lost, the
moves since the last update are drawn with that offset.
"""

from collections import deque
from collections.abc import Iterable, Sequence
from functools import partial

from axistwin.bench import Bench, Controller
from axistwin.plant.axes import Axis
from axistwin.plant.stepper import StepperAxis
from axistwin.scenes.sessions.session import Session
from axistwin.sim.manual_actions import ManualAct
from axistwin.sim.pins import Pin
from axistwin.ui.drawings.scale import travel

POINTS = 2048  # Largest number of stored corners of the path; they take at most 64 KiB.
PLACES = 512  # Largest number of stored points for each output.
PIECES = 8  # Number of straight lines that approximate a path in which both axes move, which may be curved.
MOST_MOVES = 200  # Largest number of moves drawn at one update; older moves are left out, and a new path begins.

Point = tuple[int, int]


def table_axes(controller: Controller) -> tuple[str, str] | None:
    """Return the first two axes with limited travel, which form an X-Y table; None if there are fewer than two."""
    with_travel = [name for name, axis in controller.axes.items() if travel(axis)]
    return (with_travel[0], with_travel[1]) if len(with_travel) > 1 else None


class Trail:
    """The path that the tool of an X-Y table has drawn."""

    def __init__(self, controller: Controller, names: tuple[str, str]) -> None:
        self._axes = controller.axes[names[0]], controller.axes[names[1]]
        self._seen_ns = 0
        self.points: deque[Point] = deque([(0, 0)], maxlen=POINTS)
        self.begun = 1  # Total number of points of the path, including deleted points.
        self.places: dict[str, dict[Point, bool]] = {}
        """Points at which each output has become high, in order of time; False for those of earlier cycles.

        A cycle begins at power-up, and when an output becomes high at an earlier point again.
        """
        for name, pin in controller.pins.items():
            if pin.is_output:
                self.places[name] = {}
                pin.subscribe(partial(self._switched, name))
        controller.manual_actions.subscribe(self._handled)

    @property
    def here(self) -> Point:
        return self._axes[0].position, self._axes[1].position

    def update(self) -> None:
        now_ns = self._axes[0].clock.now
        if now_ns == self._seen_ns:
            return
        since_ns = max(_remembered(axis) for axis in self._axes)
        # If an axis has made too many moves since the previous update, draw only the newest moves.
        if since_ns > self._seen_ns:
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
            if places.get(self.here) and self.here != next(reversed(places)):
                self._begin_cycle()
            places.pop(self.here, None)
            places[self.here] = True
            if len(places) > PLACES:
                del places[next(iter(places))]

    def _handled(self, act: str, *_values: object) -> None:
        if act == ManualAct.POWER:
            self._begin_cycle()

    def _begin_cycle(self) -> None:
        for places in self.places.values():
            places.update(dict.fromkeys(places, False))

    def _moments(self, now_ns: int) -> list[int]:
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
    (x1, y1), (x2, y2) = (middle[0] - first[0], middle[1] - first[1]), (last[0] - middle[0], last[1] - middle[1])
    return x1 * y2 == x2 * y1 and x1 * x2 + y1 * y2 > 0


def _remembered(axis: Axis) -> int:
    if not isinstance(axis, StepperAxis) or len(axis.train.moves) <= MOST_MOVES:
        return 0
    return axis.train.moves[-MOST_MOVES].start_ns


def _ends(axis: Axis, since_ns: int, now_ns: int) -> Iterable[int]:
    if not isinstance(axis, StepperAxis):
        return
    for move in reversed(axis.train.moves):
        for time_ns in (move.start_ns, move.end_ns):
            if time_ns is not None and since_ns < time_ns < now_ns:
                yield time_ns
        if move.start_ns <= since_ns:
            break


def _course(axis: Axis, times_ns: Sequence[int]) -> list[int]:
    """Return an axis's positions at these times; of a servo, whose past is not stored, the present one."""
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
    """The paths of all X-Y tables of a session; all browser pages show the same ones."""

    def __init__(self, session: Session) -> None:
        self._those: dict[str, Trail] = {}
        session.each_bench(self._attach)

    def _attach(self, bench: Bench) -> None:
        tables = ((controller, table_axes(controller)) for controller in bench.controllers.values())
        self._those = {controller.name: Trail(controller, names) for controller, names in tables if names is not None}

    def __getitem__(self, name: str) -> Trail:
        return self._those[name]
