"""Drawing of an X-Y table from above: the bridge, the tool, its path, and the points where the tool was down."""

from collections.abc import Iterator
from itertools import islice

from axistwin.bench import Controller
from axistwin.ui.drawings.drawing import Drawing
from axistwin.ui.drawings.scale import grouped, ticks
from axistwin.ui.drawings.trail import POINTS, Point, Trail

WIDTH, LEFT, TOP = 300.0, 40.0, 16.0
BELOW = 14.0
LEAST, MOST = 120.0, 250.0  # Limits of the drawing's height; within them, both axes have the same scale.
PIECE = 64  # Number of points in one SVG element of the path; a new point changes only the last element.
PIECES = POINTS // PIECE
MOST_TICKS = 5
NO_TOOL = ""


class Table:
    """The drawing of an X-Y table, i.e. of two axes with limited travel."""

    def __init__(self, controller: Controller, names: tuple[str, str]) -> None:
        self.names = names
        limits = [controller.axes[name].limits for name in names]
        assert limits[0] is not None and limits[1] is not None, "both axes have limited travel"
        self.x_limits, self.y_limits = limits[0], limits[1]
        self._wide = WIDTH - LEFT - 12
        span_x, span_y = (max(last - first, 1) for first, last in (self.x_limits, self.y_limits))
        self._high = min(max(self._wide * span_y / span_x, LEAST), MOST)
        self._trail: Trail | None = None
        self._piece, self._shown = 0, (0, (0, 0))
        self._marked: tuple[str, int, Point | None] | None = None
        self.drawing = Drawing(f"table {controller.name}", "top-view", self._art())

    def show(self, controller: Controller, trail: Trail, tool: str, *, smooth: bool) -> None:
        drawing = self.drawing
        x, y = (controller.axes[name].position for name in self.names)
        drawing.place("bridge", f"translate({self._x(x):.2f}px, 0)", smooth=smooth)
        drawing.place("head", f"translate({self._x(x):.2f}px, {self._y(y):.2f}px)", smooth=smooth)
        high = bool(tool) and controller.pins[tool].level
        drawing.flag("head", "down", high)
        drawing.write("tool", f"{tool} {'high' if high else 'low'}" if tool else "")
        self._show_trail(trail)
        self._show_places(tool, trail.places.get(tool, {}))

    def _show_places(self, tool: str, places: dict[Point, None]) -> None:
        now = tool, len(places), next(reversed(places), None)
        if now != self._marked:
            self._marked = now
            self.drawing.put("places", "d", "".join(f"M{self._x(x):.1f} {self._y(y):.1f}h0" for x, y in places))

    def _show_trail(self, trail: Trail) -> None:
        trail.update()
        if trail is not self._trail:
            self._forget()
            self._trail = trail
        now = trail.begun, trail.points[-1]
        if now == self._shown:
            return
        last = (trail.begun - 1) // PIECE
        for piece in range(max(self._piece, last - PIECES + 1), last + 1):
            self.drawing.put(f"trail{piece % PIECES}", "points", " ".join(self._corners(trail, piece)))
        self._piece, self._shown = last, now

    def _forget(self) -> None:
        self._piece, self._shown, self._marked = 0, (0, (0, 0)), None
        for piece in range(PIECES):
            self.drawing.put(f"trail{piece}", "points", "")

    def _corners(self, trail: Trail, piece: int) -> Iterator[str]:
        """Yield the points of one SVG element of the path, and the first point of the next element."""
        oldest = trail.begun - len(trail.points)
        first = max(piece * PIECE - oldest, 0)
        for x, y in islice(trail.points, first, max((piece + 1) * PIECE + 1 - oldest, 0)):
            yield f"{self._x(x):.1f},{self._y(y):.1f}"

    def _x(self, position: float) -> float:
        return LEFT + _share(position, self.x_limits) * self._wide

    def _y(self, position: float) -> float:
        return TOP + (1 - _share(position, self.y_limits)) * self._high

    def _art(self) -> str:
        bed = f'<rect class="plate" x="{LEFT}" y="{TOP}" width="{self._wide}" height="{self._high:.1f}" rx="2"/>'
        trail = "".join(f'<polyline class="trail" data-part="trail{piece}"/>' for piece in range(PIECES))
        bridge = f'<rect class="beam" x="-5" y="{TOP - 5}" width="10" height="{self._high + 10:.1f}" rx="2"/>'
        x, y = self.names
        return (
            f'<svg viewBox="0 0 {WIDTH:g} {TOP + self._high + BELOW:.0f}" role="img" aria-label="{x}, {y} from above">'
            f'{bed}{"".join(self._grid())}{trail}<path class="places" data-part="places"/>'
            f'<g class="moves bridge" data-part="bridge">{bridge}</g><g class="moves head" data-part="head">{_HEAD}</g>'
            f'<text class="word end" x="{WIDTH - 12}" y="9" data-part="tool"></text></svg>'
        )

    def _grid(self) -> Iterator[str]:
        floor = TOP + self._high
        for position in ticks(*self.x_limits, MOST_TICKS):
            x = self._x(position)
            yield f'<path class="grid" d="M{x:.1f} {TOP}V{floor:.1f}"/>'
            yield f'<text class="figures" x="{x:.1f}" y="{floor + 11:.1f}">{grouped(position)}</text>'
        for position in ticks(*self.y_limits, MOST_TICKS):
            y = self._y(position)
            yield f'<path class="grid" d="M{LEFT} {y:.1f}h{self._wide}"/>'
            yield f'<text class="figures end" x="{LEFT - 3}" y="{y + 3:.1f}">{grouped(position)}</text>'
        yield f'<text class="word" x="{WIDTH - 5}" y="{floor + 11:.1f}">{self.names[0]}</text>'
        yield f'<text class="word end" x="{LEFT - 3}" y="9">{self.names[1]}</text>'


def _share(position: float, limits: tuple[int, int]) -> float:
    """Return a position as a fraction of the travel, 0 to 1, or up to 0.03 beyond the limits."""
    first, last = limits
    return min(max((position - first) / max(last - first, 1), -0.03), 1.03)


_HEAD = (
    '<rect class="saddle" x="-9" y="-9" width="18" height="18" rx="3"/><circle class="light" r="5.5"/>'
    '<path class="cross" d="M-14 0h28M0 -14v28"/>'
)
