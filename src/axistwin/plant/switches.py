"""Switches that an axis works: limit and home switches."""

from collections.abc import Callable, Sequence

from axistwin.plant.stepper import StepperAxis
from axistwin.sim.pins import Pin


class PositionSwitch:
    """On while `first <= position <= last`; None: no end on that side.  It switches on the very pulse."""

    def __init__(self, axis: StepperAxis, first: int | None, last: int | None) -> None:
        self.axis, self.first, self.last = axis, first, last
        self.on_change: Callable[[], None] = lambda: None
        self._plan = 0
        self.on = self._inside()
        axis.on_motion.append(self._look)

    def _inside(self) -> bool:
        position = self.axis.position
        return (self.first is None or position >= self.first) and (self.last is None or position <= self.last)

    def _look(self) -> None:
        """Switch if the position says so, and come back when it will say otherwise."""
        self._plan += 1
        inside = self._inside()
        if inside is not self.on:
            self.on = inside
            self.on_change()
        plan, clock = self._plan, self.axis.clock
        edges = [edge for end in (self.first, self.last) if end is not None for edge in (end - 1, end, end + 1)]
        due = [at_ns for edge in edges if (at_ns := self.axis.reaches_ns(edge)) is not None]
        if due:
            clock.call_later(min(due) - clock.now, lambda: self._look() if plan == self._plan else None)


def in_series(switches: Sequence[PositionSwitch], pin: Pin, *, closed: bool = True) -> None:
    """`pin` is at the level `closed` while every one of the switches is on, at the other while one is open."""

    def update() -> None:
        pin.set(all(switch.on for switch in switches) is closed)

    for switch in switches:
        switch.on_change = update
    update()
