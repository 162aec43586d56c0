"""The drawings of all machines of a session, as data for the page."""

from functools import partial
from typing import Any

from axistwin.bench import Controller
from axistwin.scenes.sessions.condition import operated
from axistwin.scenes.sessions.session import Session
from axistwin.ui.drawings.drawing import Change, Drawing
from axistwin.ui.drawings.figure import Figure
from axistwin.ui.drawings.of_axes import figure
from axistwin.ui.drawings.scale import Flow
from axistwin.ui.drawings.switches import Switches
from axistwin.ui.drawings.table import Table
from axistwin.ui.drawings.trail import Trails, table_axes


class Pictures:
    """The drawings of one session: axes, X-Y tables, switches and lamps."""

    def __init__(self, session: Session) -> None:
        self._session, self._flow, self._trails = session, Flow(), Trails(session)
        self._of = {name: _Machine(session, controller) for name, controller in session.bench.controllers.items()}

    def overview(self, name: str) -> list[dict[str, Any]]:
        """Return name, CSS classes and contents of each drawing of a controller, and its axis if it has one."""
        return [
            {"name": drawing.name, "kind": drawing.kind, "art": drawing.art, "axis": axis}
            for axis, drawing in self._of[name].drawings()
        ]

    def drawn(self, name: str) -> set[str]:
        acts = {act for _, drawing in self._of[name].drawings() for act in drawing.acts}
        return acts | {*self._of[name].switches.outputs}

    def changes(self, wanted: str = "") -> dict[str, list[Change]]:
        """Return the changes since the last call, by drawing; `wanted`: the input that the user must change."""
        smooth = self._flow.is_smooth(self._session.bench)
        for name, machine in self._of.items():
            machine.show(self._session.bench.controllers[name], self._trails, wanted, smooth=smooth)
        taken = {drawing.name: drawing.take() for machine in self._of.values() for _, drawing in machine.drawings()}
        return {name: changes for name, changes in taken.items() if changes}

    def click(self, drawing: str, part: str) -> None:
        for machine in self._of.values():
            for _, each in machine.drawings():
                if each.name == drawing:
                    each.click(part)


class _Machine:
    def __init__(self, session: Session, controller: Controller) -> None:
        press = partial(session.do, controller.name)
        self._figures: dict[str, Figure] = {axis: figure(controller, axis, press) for axis in controller.axes}
        names = {pin: operated(session, controller.name, pin) for pin in controller.pins}
        self.switches = Switches(controller, press, {pin: found[0] for pin, found in names.items() if found})
        axes = table_axes(controller)
        self._table = None if axes is None else Table(controller, axes)
        outputs = [name for name, pin in controller.pins.items() if pin.is_output]
        self._tool = outputs[0] if outputs else ""

    def drawings(self) -> list[tuple[str, Drawing]]:
        """Return the drawings, each with its axis; "" for a drawing of several axes or none."""
        table = [] if self._table is None else [("", self._table.drawing)]
        figures = [(axis, shown.drawing) for axis, shown in self._figures.items()]
        return [*table, *figures, ("", self.switches.drawing)]

    def show(self, controller: Controller, trails: Trails, wanted: str, *, smooth: bool) -> None:
        for shown in self._figures.values():
            shown.show(controller, smooth=smooth)
        if self._table is not None:
            self._table.show(controller, trails[controller.name], self._tool, smooth=smooth)
        name, _, pin = wanted.rpartition(".")
        self.switches.show(controller, pin if name == controller.name else "")
