"""Drawing of an X-Y table from above: the bridge, the tool, its path, and the points where the tool was down.

Points of the present cycle are filled, those of earlier cycles hollow.
"""

from collections.abc import Callable, Iterator
from html import escape
from itertools import islice

from axistwin.bench import Controller
from axistwin.ui.drawings.drawing import Drawing
from axistwin.ui.drawings.figure import target
from axistwin.ui.drawings.scale import grouped, ticks
from axistwin.ui.drawings.switches import title_of
from axistwin.ui.drawings.trail import POINTS, Point, Trail

WIDTH, LEFT, TOP = 640.0, 84.0, 26.0
RIGHT, BELOW = 78.0, 50.0
LEAST, MOST = 160.0, 520.0  # Limits of the drawing's height; within them, both axes have the same scale.
PAST = 4.0  # How far the floor reaches beyond the travel.
PIECE = 64  # Number of points in one SVG element of the path; a new point changes only the last element.
PIECES = POINTS // PIECE
MOST_TICKS = 6
NO_TOOL = ""
RING = "m-3.5 0a3.5 3.5 0 1 0 7 0a3.5 3.5 0 1 0 -7 0"


class Table:
    """The drawing of an X-Y table, i.e. of two axes with limited travel."""

    def __init__(self, controller: Controller, names: tuple[str, str]) -> None:
        self.names = names
        limits = [controller.axes[name].limits for name in names]
        assert limits[0] is not None and limits[1] is not None, "both axes have limited travel"
        self.x_limits, self.y_limits = limits[0], limits[1]
        self._wide = WIDTH - LEFT - RIGHT
        span_x, span_y = (max(last - first, 1) for first, last in (self.x_limits, self.y_limits))
        self._high = min(max(self._wide * span_y / span_x, LEAST), MOST)
        self._units = [controller.axes[name].units for name in names]
        self._trail: Trail | None = None
        self._piece, self._shown = 0, (0, (0, 0))
        self._marked: tuple[str, int, Point | None, int] | None = None
        self.drawing = Drawing(f"table {controller.name}", "top-view", self._art())

    def show(
        self, controller: Controller, trail: Trail, tool: str, *, smooth: bool, beside: Point | None = None
    ) -> None:  # fmt: skip
        """Update the drawing; `beside`: the position of a second machine, whose head is drawn as a pale copy."""
        drawing = self.drawing
        drawing.flag("pale", "there", beside is not None)
        if beside is not None:
            drawing.place("pale", f"translate({self._x(beside[0]):.2f}px, {self._y(beside[1]):.2f}px)", smooth=smooth)
        x, y = (controller.axes[name].position for name in self.names)
        drawing.place("bridge", f"translate({self._x(x):.2f}px, 0)", smooth=smooth)
        drawing.place("head", f"translate({self._x(x):.2f}px, {self._y(y):.2f}px)", smooth=smooth)
        drawing.place("level", f"translate(0, {self._y(y):.2f}px)", smooth=smooth)
        self._show_target(controller)
        high = bool(tool) and controller.pins[tool].level
        drawing.flag("head", "down", high)
        drawing.write("tool", f"{title_of(tool, {})} {'on' if high else 'off'}" if tool else "")
        self._show_trail(trail)
        self._show_places(tool, trail.places.get(tool, {}))

    def _show_target(self, controller: Controller) -> None:
        ends = [target(controller.axes[name]) for name in self.names]
        here = [controller.axes[name].position for name in self.names]
        x, y = (now if end is None else end for end, now in zip(ends, here, strict=True))
        there = ends != [None, None]
        self.drawing.flag("aim", "there", there)
        for part, end in zip(("aim-x", "aim-y"), ends, strict=True):
            self.drawing.flag(part, "there", end is not None)
        if there:
            self.drawing.place("aim", f"translate({self._x(x):.2f}px, {self._y(y):.2f}px)", smooth=False)
            self.drawing.place("aim-x", f"translate({self._x(x):.2f}px, 0)", smooth=False)
            self.drawing.place("aim-y", f"translate(0, {self._y(y):.2f}px)", smooth=False)

    def _show_places(self, tool: str, places: dict[Point, bool]) -> None:
        now = tool, len(places), next(reversed(places), None), sum(places.values())
        if now != self._marked:
            self._marked = now
            at = {place: f"M{self._x(place[0]):.1f} {self._y(place[1]):.1f}" for place in places}
            self.drawing.put("places", "d", "".join(f"{at[place]}h0" for place, new in places.items() if new))
            self.drawing.put("earlier", "d", "".join(f"{at[place]}{RING}" for place, new in places.items() if not new))

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
        floor, right = TOP + self._high, LEFT + self._wide
        bed = (
            f'<rect class="floor" x="{LEFT - PAST}" y="{TOP - PAST}" width="{self._wide + 2 * PAST:.1f}" '
            f'height="{self._high + 2 * PAST:.1f}" rx="3"/>'
        )
        rails = "".join(
            f'<rect class="rail" x="{LEFT - 12}" y="{y:.1f}" width="{self._wide + 24:.1f}" height="10" rx="2"/>'
            f'<rect class="groove" x="{LEFT - 6}" y="{y + 4:.1f}" width="{self._wide + 12:.1f}" height="2"/>'
            for y in (TOP - 16, floor + 6)
        )
        trail = "".join(f'<polyline class="trail" data-part="trail{piece}"/>' for piece in range(PIECES))
        bridge = (
            f'<rect class="beam" x="-12" y="{TOP - 21}" width="24" height="{self._high + 42:.1f}" rx="3"/>'
            f'<rect class="groove" x="-5" y="{TOP - 2}" width="2" height="{self._high + 4:.1f}"/>'
            f'<rect class="groove" x="3" y="{TOP - 2}" width="2" height="{self._high + 4:.1f}"/>'
            f'<path class="here" d="M0 {floor + 23:.1f}l-5 9h10z"/>'
        )
        aims = (
            '<circle class="aim" r="8" data-part="aim"/>'
            f'<g class="aim" data-part="aim-x"><path d="M0 {floor + 23:.1f}l-5 9h10z"/></g>'
            f'<g class="aim" data-part="aim-y"><path d="M{LEFT - 17} 0l-9 -5v10z"/></g>'
        )
        x, y = self.names
        return (
            f'<svg viewBox="0 0 {WIDTH:g} {floor + BELOW:.0f}" role="img" aria-label="{x}, {y} from above">'
            f"{bed}{''.join(self._grid())}{rails}{trail}"
            f'<path class="earlier" data-part="earlier"/><path class="places" data-part="places"/>{aims}'
            f'<g class="moves" data-part="level"><path class="here" d="M{LEFT - 17} 0l-9 -5v10z"/>'
            f'<path class="hair" d="M{LEFT} 0h{self._wide:.1f}"/></g>'
            f'<g class="moves bridge" data-part="bridge">{bridge}</g>'
            f'<g class="moves head pale" data-part="pale">{_HEAD}</g><g class="moves head" data-part="head">{_HEAD}</g>'
            f'<text class="end" x="{right - 8:.1f}" y="{TOP + 18}" data-part="tool"></text></svg>'
        )

    def _grid(self) -> Iterator[str]:
        floor, right = TOP + self._high + PAST, LEFT + self._wide + PAST
        for x, told in self._ticks(0, self._x):
            yield f'<path class="grid" d="M{x:.1f} {TOP - PAST}V{floor:.1f}"/>'
            yield f'<text class="figures" x="{x:.1f}" y="{floor + 44:.1f}">{told}</text>'
        for y, told in self._ticks(1, self._y):
            yield f'<path class="grid" d="M{LEFT - PAST} {y:.1f}H{right:.1f}"/>'
            yield f'<text class="figures end" x="{LEFT - 32}" y="{y + 4:.1f}">{told}</text>'
        of = "" if self._units[0] is None else self._units[0].of
        yield f'<text class="figures start" x="{right + 20:.1f}" y="{floor + 44:.1f}">{escape(of)}</text>'
        yield f'<text class="word start" x="{right + 14:.1f}" y="{floor + 11:.1f}">{self.names[0]}</text>'
        yield f'<text class="word end" x="{LEFT - 32}" y="10">{self.names[1]}</text>'

    def _ticks(self, which: int, place: Callable[[float], float]) -> Iterator[tuple[float, str]]:
        """Yield places and labels of round numbers in the axis's unit."""
        units, limits = self._units[which], (self.x_limits, self.y_limits)[which]
        per = 1.0 if units is None else float(units.per)
        for number in ticks(limits[0] / per, limits[1] / per, MOST_TICKS):
            yield place(number * per), grouped(number)


def _share(position: float, limits: tuple[int, int]) -> float:
    """Return a position as a fraction of the travel, 0 to 1, or up to 0.03 beyond the limits."""
    first, last = limits
    return min(max((position - first) / max(last - first, 1), -0.03), 1.03)


_HEAD = (
    '<rect class="saddle" x="-16" y="-16" width="32" height="32" rx="4"/><circle class="light" r="9.5"/>'
    '<circle class="bit" r="3.5"/><path class="cross" d="M0 -13V-6M0 6V13M-13 0H-6M6 0H13"/>'
)
