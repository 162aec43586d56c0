"""Limit and home switches, actuated by an axis."""

from collections.abc import Callable, Sequence

from axistwin.plant.axes import Axis
from axistwin.sim.pins import Pin


class PositionSwitch:
    """A switch that is on while the position of the axis is from `first` to `last`.

    None: no limit on that side.  With a stepper, the switch changes on the exact pulse.
    """

    def __init__(self, axis: Axis, first: int | None, last: int | None) -> None:
        self.axis, self.first, self.last = axis, first, last
        self.on_change: Callable[[], None] = lambda: None
        self.on = self._inside()
        edges = ([] if first is None else [first]) + ([] if last is None else [last + 1])
        axis.subscribe_edges(edges, self._update)

    def _inside(self) -> bool:
        position = self.axis.position
        return (self.first is None or position >= self.first) and (self.last is None or position <= self.last)

    def _update(self) -> None:
        inside = self._inside()
        if inside is not self.on:
            self.on = inside
            self.on_change()


def in_series(switches: Sequence[PositionSwitch], pin: Pin, *, closed: bool = True) -> None:
    """Connect switches in series to a pin, which has the level `closed` while all of them are on."""

    def update() -> None:
        pin.set(all(switch.on for switch in switches) is closed)

    for switch in switches:
        switch.on_change = update
    pin.wired = True
    update()
