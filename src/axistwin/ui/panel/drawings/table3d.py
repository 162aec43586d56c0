"""Drawing of an X-Y table in three dimensions; the user turns the view with the mouse, a finger or buttons."""

from math import cos, pi, radians, sin

from nicegui import ui
from nicegui.elements.scene import Scene

from axistwin.bench import Controller
from axistwin.ui.drawings.trail import Trail

LENGTH = 10.0  # Length of the longer axis, in units of the 3-D scene.
THINNEST = 3.0
DISTANCE = 1.55 * LENGTH
FIELD = 40.0  # Field of view of the camera in degrees.
BEHIND = 0.5  # Distance between bridge and tool, in units of the 3-D scene.
LIFT = 0.35  # Vertical travel of the tool, in units of the 3-D scene.
MOST_PLACES = 100
WIDTH, HEIGHT = 560, 360
AIR = "#eceef0"
STEEL, PAINT, BRASS, BED, DARK = "#bcc4cc", "#8d98a5", "#d5dae0", "#7d8792", "#1a2027"


class Table3D:
    """Three-dimensional drawing of an X-Y table: a plate, a bridge above the plate, and a head with a tool."""

    def __init__(self, controller: Controller, names: tuple[str, str]) -> None:
        self.names = names
        limits = [controller.axes[name].limits for name in names]
        assert limits[0] is not None and limits[1] is not None, "both axes have limited travel"
        self._limits = limits[0], limits[1]
        spans = [max(last - first, 1) for first, last in self._limits]
        self._size = tuple(max(LENGTH * span / max(spans), THINNEST) for span in spans)
        self._at: tuple[float, ...] = ()
        self._holes: set[tuple[int, int]] = set()
        self._trail: Trail | None = None
        camera = ui.scene.perspective_camera(fov=FIELD)
        self.scene = ui.scene(WIDTH, HEIGHT, grid=False, camera=camera, background_color=AIR).classes("scene")
        with self.scene:
            self._build()
        self._angle = 20.0
        self.turn(0.0)

    def show(self, controller: Controller, trail: Trail, tool: str) -> None:
        x, y = (self._place(which, controller.axes[name].position) for which, name in enumerate(self.names))
        z = -LIFT if tool and controller.pins[tool].level else 0.0
        if (x, y, z) != self._at:
            self._at = x, y, z
            self._bridge.move(x, 0, 0)
            self._head.move(0, y, 0)
            self._tool.move(0, 0, z)
        self._drill(trail, tool)

    def turn(self, degrees: float) -> None:
        self._angle += degrees
        round_it = radians(self._angle)
        x, y = DISTANCE * sin(round_it), -DISTANCE * cos(round_it)
        self.scene.move_camera(x=x, y=y, z=0.6 * DISTANCE, look_at_x=0, look_at_y=0, look_at_z=0.3, duration=0.3)

    def _drill(self, trail: Trail, tool: str) -> None:
        places = trail.places.get(tool, {})
        if trail is not self._trail or len(self._holes) > MOST_PLACES or not self._holes.issubset(places):
            self._trail = trail
            self._holes.clear()
            self.scene.delete_objects(lambda thing: thing.name == "hole")
        for place in list(places)[-MOST_PLACES:]:
            if place not in self._holes:
                self._holes.add(place)
                with self.scene:
                    hole = self.scene.cylinder(0.09, 0.09, 0.03, 16).material(DARK).rotate(pi / 2, 0, 0)
                    hole.with_name("hole").move(self._place(0, place[0]), self._place(1, place[1]), 0.11)

    def _place(self, which: int, position: int) -> float:
        first, last = self._limits[which]
        return ((position - first) / max(last - first, 1) - 0.5) * self._size[which]

    def _build(self) -> None:
        scene, (length, width) = self.scene, self._size
        scene.box(length + 2.2, width + 2.2, 0.5).material(BED).move(0, 0, -0.25)
        scene.box(length + 0.6, width + 0.6, 0.1).material("#d9dfe7").move(0, 0, 0.05)
        for side in (-1, 1):
            scene.box(length + 1.6, 0.18, 0.2).material(STEEL).move(0, side * (width / 2 + 0.7), 0.1)
        with scene.group() as self._bridge:
            self._build_bridge(scene, width)

    def _build_bridge(self, scene: Scene, width: float) -> None:
        for side in (-1, 1):
            scene.box(0.6, 0.35, 1.5).material(PAINT).move(BEHIND, side * (width / 2 + 0.7), 0.9)
        scene.box(0.5, width + 1.75, 0.45).material(PAINT).move(BEHIND, 0, 1.75)
        with scene.group() as self._head:
            scene.box(0.55, 0.8, 0.9).material(STEEL).move(0, 0, 1.6)
            with scene.group() as self._tool:
                scene.cylinder(0.22, 0.22, 0.9, 24).material(BRASS).rotate(pi / 2, 0, 0).move(0, 0, 1.2)
                scene.cylinder(0.08, 0.02, 0.6, 16).material(DARK).rotate(-pi / 2, 0, 0).move(0, 0, 0.48)
