"""Drawing of an axis with limited travel: a carriage between two limit switches, with a scale."""

from collections.abc import Iterator
from html import escape

from axistwin.bench import Controller
from axistwin.plant.axes import Axis
from axistwin.plant.servo_axis import ServoAxis
from axistwin.ui.drawings.drawing import Drawing
from axistwin.ui.drawings.figure import SELDOM, STATES, error_rows, motion_rows, readout, readouts, show_motion, target
from axistwin.ui.drawings.scale import grouped, ticks
from axistwin.ui.drawings.switches import Press, action, on_slides, show_switch

LEFT, RIGHT = 30.0, 270.0  # X coordinates of the limit switches; the drawing is 300 wide.
TITLES = {"minus": "minus limit", "plus": "plus limit", "home": "home"}
OVERRUN = 18.0  # Distance from a limit switch to the end of the bed.
MOST_TICKS = 5
SHARED = ' title="in series with the switches of the other axes: all of them are one input"'


class Slide:
    """The drawing of one axis; an outlined carriage shows the commanded position if it differs from the position.

    `press` is called when the user clicks a limit switch or the home switch.
    """

    def __init__(self, controller: Controller, name: str, press: Press) -> None:
        axis = controller.axes[name]
        assert axis.limits is not None, "a slide has limited travel"
        self.name, self.limits, self._units = name, axis.limits, axis.units
        self._frames = 0
        self._switches = {part: pin for pin, part in on_slides(controller, self.name).items()}
        self._controller = controller
        self._in_series = sum(axis.limits is not None for axis in controller.axes.values()) > 1
        self.drawing = Drawing(
            f"axis {controller.name}.{name}", "slide", self._art(controller, axis),
            lambda pin: press(pin, action(self._controller.pins[pin])),
        )  # fmt: skip

    def show(self, controller: Controller, *, smooth: bool, beside: int | None = None) -> None:
        axis, drawing = controller.axes[self.name], self.drawing
        position, (first, last) = axis.position, self.limits
        wanted = show_motion(drawing, controller, self.name)
        drawing.place("carriage", self._at(position), smooth=smooth)
        drawing.place("ghost", self._at(wanted), smooth=smooth)
        drawing.flag("ghost", "there", wanted != position)
        drawing.flag("pale", "there", beside is not None)
        if beside is not None:
            drawing.place("pale", self._at(beside), smooth=smooth)
        there = target(axis)
        drawing.flag("aim", "there", there is not None)
        if there is not None:
            drawing.place("aim", self._at(there), smooth=False)
        self._controller = controller
        for part, beyond in (("minus", position < first), ("plus", position > last)):
            drawing.flag(part, "lit", beyond)
            if part in self._switches:
                self._show_switch(part, "open" if beyond else "free")
        if isinstance(axis, ServoAxis):
            self._show_servo(controller, axis)
        elif axis.home is not None:
            drawing.flag("home", "lit", axis.home[0] <= position <= axis.home[1])
            self._show_switch("home", "free")

    def _show_switch(self, part: str, free: str) -> None:
        show_switch(self.drawing, part, self._controller.pins[self._switches[part]], free)
        word, level = (self.drawing.shown[f"{part}-{each}", "text"] for each in ("word", "level"))
        # Screen readers and speech input need the words of the drawing in one piece in the name.
        shown = f"{word}, {level}"
        name = f"home {shown}, of {self.name}" if part == "home" else f"{TITLES[part]} of {self.name}: {shown}"
        self.drawing.put(part, "aria-label", name)

    def _show_servo(self, controller: Controller, axis: ServoAxis) -> None:
        drawing, pin = self.drawing, controller.product.brake_pin
        if self._frames % SELDOM == 0:
            drawing.write("temperature", f"{axis.temperature:.1f}")
        self._frames += 1
        if pin is not None:
            engaged = controller.pins[pin].level
            drawing.write("brake", "holds" if engaged else "released")
            drawing.flag("row-brake", "wrong", engaged)
        drawing.flag("row-edges", "unused", not (axis.master.moving or axis.master.count))
        drawing.write("edges", grouped(axis.master.count))

    def _x(self, position: float) -> float:
        first, last = self.limits
        return LEFT + (position - first) / max(last - first, 1) * (RIGHT - LEFT)

    def _at(self, position: int) -> str:
        return f"translate({min(max(self._x(position), LEFT - OVERRUN), RIGHT + OVERRUN):.2f}px, 0)"

    def _art(self, controller: Controller, axis: Axis) -> str:
        of = axis.unit
        told = f"{self.name}: a slide of {self.limits[0]} to {self.limits[1]} {of}"
        rows = [*motion_rows(axis), *error_rows(axis)]
        if isinstance(axis, ServoAxis):
            rows += [readout("brake", "Brake")] if controller.product.brake_pin is not None else []
            rows += [readout("edges", "External encoder", "edges")]
        return (
            f'<svg viewBox="0 0 300 94" role="group" aria-label="{told}"><g data-part="machine">{_BED}'
            f"{''.join(self._scale())}{self._home(axis)}{self._switch('minus', LEFT)}{self._switch('plus', RIGHT)}"
            f'<g class="moves pale" data-part="pale">{_CARRIAGE}</g>'
            f'<g class="moves ghost" data-part="ghost"><rect x="-19" y="27" width="38" height="32" rx="4"/></g>'
            f'<g class="aim" data-part="aim"><path d="M0 66l-5 8h10z"/></g>'
            f'<g class="moves carriage" data-part="carriage">{_CARRIAGE}</g></g></svg>{readouts(*rows)}{STATES}'
        )

    def _scale(self) -> Iterator[str]:
        first, last = self.limits
        per = 1.0 if self._units is None else float(self._units.per)
        begin, end = first / per, last / per
        minor = list(ticks(begin, end, 5 * MOST_TICKS))
        major = set(ticks(begin, end, MOST_TICKS))
        for place in minor:
            yield f'<path class="tick" d="M{self._x(place * per):.2f} 65v{5 if place in major else 2.5}"/>'
        of = "" if self._units is None else f" {self._units.of}"
        for place in sorted(major):
            unit = of if place == max(major) else ""
            yield f'<text class="figures" x="{self._x(place * per):.2f}" y="88">{grouped(place)}{escape(unit)}</text>'

    def _home(self, axis: Axis) -> str:
        if isinstance(axis, ServoAxis) or axis.home is None:
            return ""
        low, high = (min(max(self._x(end), LEFT), RIGHT) for end in axis.home)
        bar = f'<rect x="{low - 1:.2f}" y="60" width="{high - low + 2:.2f}" height="4" rx="1"/>'
        middle = min(max((low + high) / 2, LEFT + 72), RIGHT - 72)
        told = 'home <tspan class="word" data-part="home-word"></tspan>'
        text = f'<text x="{middle:.2f}" y="17">{told}</text> <title data-part="home-level"></title>'
        hit = f'<rect class="hit" x="{middle - 34:.2f}" y="0" width="68" height="24"/>'
        return f'<g class="home" {self._button("home")}>{hit}{bar}{text}</g>'

    def _switch(self, part: str, x: float) -> str:
        sign, side, anchor = ("\u2212", -1, "start") if part == "minus" else ("+", 1, "end")
        lever = f'<path d="M{x:.2f} 27v-7l{-7 * side} -4"/>'
        body = f'<rect x="{x - 9:.2f}" y="5" width="18" height="11" rx="2"/><circle cx="{x:.2f}" cy="10.5" r="3.4"/>'
        label = f'<text class="figures" x="{x + 14 * side:.2f}" y="14">{sign}</text>'
        hit = f'<rect class="hit" x="{min(x, x - 50 * side) - 14:.2f}" y="0" width="78" height="26"/>'
        at = x - 13 * side
        word = f'<text class="word {anchor}" x="{at:.2f}" y="14" data-part="{part}-word"></text>'
        level = f'<title data-part="{part}-level"></title>'
        return f'<g class="limit" {self._button(part)}>{hit}{lever}{body}{label} {word} {level}</g>'

    def _button(self, part: str) -> str:
        if part not in self._switches:
            return f'data-part="{part}"'
        shared = SHARED if part != "home" and self._in_series else ""
        act = f'data-act="{self._switches[part]}" aria-pressed="false"'
        return f'data-part="{part}" role="button" tabindex="0" {act} aria-label="{TITLES[part]} of {self.name}"{shared}'


_BED = (
    '<rect class="bed" x="6" y="33" width="288" height="28" rx="4"/>'
    '<path class="rail" d="M10 38h280M10 56h280"/><rect class="screw" x="10" y="44" width="280" height="6"/>'
    '<path class="thread" d="M10 47h280"/>'
)
_CARRIAGE = (
    '<rect class="saddle" x="-19" y="27" width="38" height="32" rx="4"/>'
    '<circle class="bolt" cx="-13" cy="33" r="2"/><circle class="bolt" cx="13" cy="33" r="2"/>'
    '<circle class="bolt" cx="-13" cy="53" r="2"/><circle class="bolt" cx="13" cy="53" r="2"/>'
    '<path class="nut" d="M-8 43h16v8h-16z"/><path class="pointer" d="M0 66l-5 8h10z"/>'
    '<path class="cut" d="M0 27v31"/>'
)
