"""Drawing of a rotary axis: a disc with an index mark, a brake, and the wheel of an external encoder.

A hollow outer mark shows the target of a move, or at rest the commanded position if steps are lost; of a servo always
the commanded position: its angle to the index mark is the following error.  Positive is clockwise.
"""

from html import escape

from axistwin.bench import Bench, Controller
from axistwin.plant.axes import Axis
from axistwin.plant.master import Master
from axistwin.plant.servo_axis import ServoAxis
from axistwin.plant.stepper import StepperAxis
from axistwin.ui.drawings.drawing import Drawing
from axistwin.ui.drawings.figure import SELDOM, STATES, error_rows, motion_rows, readout, readouts, show_motion, target
from axistwin.ui.drawings.scale import grouped, signed

ASSUMED = 400  # Assumed number of pulses or counts per turn for an axis without a configured number,
USUAL = {"compumotor": 25_000}  # unless the manuals of its family assume another one.
WHEEL_EDGES = 2000  # Assumed number of edges per turn of an external encoder that is not mounted on a rotary axis.
MOST_TURNS = 2  # Largest rotation in one frame that is drawn as a smooth transition.


class Shaft:
    """The drawing of the shaft of one axis."""

    def __init__(self, controller: Controller, name: str) -> None:
        axis = controller.axes[name]
        self.name, self.per_rev = name, axis.per_rev or USUAL.get(controller.product.family, ASSUMED)
        self._said = axis.per_rev is not None
        self._before, self._frames = 0, 0
        self.drawing = Drawing(f"axis {controller.name}.{name}", "shaft", self._art(controller, axis))

    def show(self, controller: Controller, *, smooth: bool, beside: int | None = None) -> None:
        axis, drawing = controller.axes[self.name], self.drawing
        position = axis.position
        wanted = show_motion(drawing, controller, self.name)
        smooth = smooth and abs(position - self._before) <= MOST_TURNS * self.per_rev
        self._before = position
        drawing.place("disc", self._angle(position), smooth=smooth)
        there = target(axis)
        drawing.place("ghost", self._angle(wanted if there is None else there), smooth=smooth)
        drawing.flag("ghost", "there", isinstance(axis, ServoAxis) or there is not None or wanted != position)
        drawing.flag("pale", "there", beside is not None)
        if beside is not None:
            drawing.place("pale", self._angle(beside), smooth=smooth)
        if self._said:
            turns, rest = divmod(position, self.per_rev)
            drawing.write("turns", f"{grouped(turns)} + {360 * rest / self.per_rev:.1f}°")
            drawing.write("rpm", signed(round(60 * axis.velocity / self.per_rev)))
        self._show_brake(controller)
        if isinstance(axis, ServoAxis):
            self._show_servo(controller, axis, smooth=smooth)

    def _angle(self, position: int) -> str:
        return f"rotate({360 * position / self.per_rev:.1f}deg)"

    def _show_brake(self, controller: Controller) -> None:
        pin = controller.product.brake_pin
        if pin is not None:
            engaged = controller.pins[pin].level
            self.drawing.flag("brake", "engaged", engaged)
            self.drawing.place("caliper", "translate(-9px, 0)" if engaged else "translate(0, 0)")
            self.drawing.write("brake-word", "brake holds" if engaged else "brake released")

    def _show_servo(self, controller: Controller, axis: ServoAxis, *, smooth: bool) -> None:
        if self._frames % SELDOM == 0:
            self.drawing.write("temperature", f"{axis.temperature:.1f}")
        self._frames += 1
        master = axis.master
        used = master.moving or master.count != 0
        self.drawing.flag("wheel", "there", used)
        if used:
            self._show_wheel(controller.bench, master, smooth=smooth)

    def _show_wheel(self, bench: Bench | None, master: Master, *, smooth: bool) -> None:
        assert bench is not None, "the controller is part of a bench"
        drawing, edges, count = self.drawing, _edges_per_turn(master), master.count
        drawing.place("tyre", f"rotate({360 * count / edges:.1f}deg)", smooth=smooth)
        drawing.write("edges", grouped(count))
        drawing.write("sits-on", _sits_on(bench, master))

    def _art(self, controller: Controller, axis: Axis) -> str:
        rows = motion_rows(axis)
        if self._said:
            rows += [readout("turns", "Turns"), readout("rpm", "Speed", "rpm")]
        rows += error_rows(axis)
        note = "" if self._said else f'<p class="note">{grouped(self.per_rev)} {axis.unit} a turn assumed</p>'
        height = 150 if controller.product.brake_pin is None else 162
        return (
            f'<div class="drawn"><svg viewBox="0 0 150 {height}" role="img" aria-label="{escape(self.name)}: a shaft">'
            f'<g data-part="machine">{_DIAL}'
            f'<g transform="translate(75 75)"><g class="moves disc" data-part="disc">{_DISC}</g>'
            f'<g class="moves pale" data-part="pale"><path class="index" d="M0 -68l-7 14h14zM0 -54V0"/></g>'
            f'<g class="moves wanted" data-part="ghost"><path d="M0 -56l-5 -9h10z"/></g></g>'
            f"{_brake(controller)}</g></svg>{_WHEEL if isinstance(axis, ServoAxis) else ''}</div>"
            f"{note}{readouts(*rows)}{STATES}"
        )


def _brake(controller: Controller) -> str:
    if controller.product.brake_pin is None:
        return ""
    fitted = "brake" if controller.given.get("brake") else "brake signal"
    caliper = '<g class="moves" data-part="caliper"><path d="M123 60h24v30h-24v-8h9v-14h-9z"/></g>'
    word = '<text class="word" x="75" y="158" data-part="brake-word"></text>'
    return f'<g class="{fitted}" data-part="brake">{caliper}{word}</g>'


def _edges_per_turn(master: Master) -> float:
    followed = master.followed
    if isinstance(followed, StepperAxis | ServoAxis) and followed.per_rev:
        return float(followed.per_rev * master.ratio) or WHEEL_EDGES
    return WHEEL_EDGES


def _sits_on(bench: Bench, master: Master) -> str:
    for name, controller in bench.controllers.items():
        for axis_name, axis in controller.axes.items():
            if axis is master.followed:
                return f"on {name}.{axis_name}"
    return ""


_DIAL = (
    '<circle class="dial" cx="75" cy="75" r="68"/>'
    + "".join(f'<path class="tick" d="M75 9v{6 if turn % 90 == 0 else 3}" transform="rotate({turn} 75 75)"/>'
              for turn in range(0, 360, 30))
)  # fmt: skip
_DISC = (
    '<circle class="face" r="54"/><circle class="groove" r="44"/><circle class="hub" r="15"/>'
    '<circle class="bore" r="6"/>'
    '<path class="keyway" d="M-2 -9h4v4h-4z"/>'
    + "".join(f'<circle class="bolt" cy="-30" r="5" transform="rotate({turn})"/>' for turn in (60, 120, 180, 240, 300))
    + '<path class="index" d="M0 -53l-6 13h12z"/><path class="index line" d="M0 -40V-16"/>'
)
_WHEEL = (
    '<svg class="wheel" data-part="wheel" viewBox="0 0 110 150" role="img" aria-label="external encoder">'
    '<path class="link" d="M78 62C92 44 100 40 110 38"/><path class="web" d="M4 113h102"/>'
    '<g transform="translate(55 79)"><g class="moves" data-part="tyre"><circle class="rubber" r="32"/>'
    '<circle class="rim" r="25"/>'
    '<path class="spokes" d="M0 -25V25M-25 0H25M-17.7 -17.7L17.7 17.7M17.7 -17.7L-17.7 17.7"/>'
    '<circle class="hub" r="7"/><path class="index" d="M0 -31l-4 8h8z"/></g></g>'
    '<text class="figures" x="55" y="14">external encoder</text>'
    '<text class="figures" x="55" y="27" data-part="sits-on"></text>'
    '<text class="figures big" x="55" y="132" data-part="edges"></text>'
    '<text class="figures" x="55" y="145">edges</text></svg>'
)
