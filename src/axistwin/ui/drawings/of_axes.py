"""The drawings of the axes of a controller."""

from importlib import resources

from axistwin.bench import Controller
from axistwin.ui.drawings.figure import Figure
from axistwin.ui.drawings.scale import travel
from axistwin.ui.drawings.shaft import Shaft
from axistwin.ui.drawings.slide import Slide
from axistwin.ui.drawings.switches import Press


def figure(controller: Controller, axis: str, press: Press) -> Figure:
    """Return the drawing of an axis: a slide if its travel is limited, else a rotating shaft."""
    return Shaft(controller, axis) if travel(controller.axes[axis]) is None else Slide(controller, axis, press)


def used_axes(controller: Controller) -> list[str]:
    """Return the axes to draw: configured, moving, or away from 0; all if none is configured."""
    if not any(controller.given.get(axis) for axis in controller.axes):
        return list(controller.axes)
    return [axis for axis in controller.axes if _used(controller, axis)]


def _used(controller: Controller, name: str) -> bool:
    axis = controller.axes[name]
    return bool(controller.given.get(name)) or axis.position != 0 or axis.moving


def asset(name: str) -> str:
    """Return the text of the file `parts.js` or `drawings.css`.  HTML pages with drawings contain these texts."""
    return resources.files(__package__).joinpath(name).read_text(encoding="utf-8")
