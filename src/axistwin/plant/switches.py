"""Switches that an axis works: limit and home switches."""

from collections.abc import Callable, Sequence
from typing import Protocol

from axistwin.sim.pins import Pin


class WatchedAxis(Protocol):
    """What a switch knows of the axis that works it."""

    @property
    def position(self) -> int:
        """Where it stands, in its own unit."""

    def watch_edges(self, edges: Sequence[int], look: Callable[[], None]) -> Callable[[], None]:
        """Call `look()` whenever it may have crossed one of these; edge n lies between position n-1 and n.

        Returns what ends it.
        """


class PositionSwitch:
    """On while `first <= position <= last`; None: no end on that side.  A stepper works it on the very pulse."""

    def __init__(self, axis: WatchedAxis, first: int | None, last: int | None) -> None:
        self.axis, self.first, self.last = axis, first, last
        self.on_change: Callable[[], None] = lambda: None
        self.on = self._inside()
        edges = ([] if first is None else [first]) + ([] if last is None else [last + 1])
        axis.watch_edges(edges, self._look)

    def _inside(self) -> bool:
        position = self.axis.position
        return (self.first is None or position >= self.first) and (self.last is None or position <= self.last)

    def _look(self) -> None:
        """Switch if the position says so."""
        inside = self._inside()
        if inside is not self.on:
            self.on = inside
            self.on_change()


def in_series(switches: Sequence[PositionSwitch], pin: Pin, *, closed: bool = True) -> None:
    """`pin` is at the level `closed` while every one of the switches is on, at the other while one is open."""

    def update() -> None:
        pin.set(all(switch.on for switch in switches) is closed)

    for switch in switches:
        switch.on_change = update
    pin.wired = True
    update()
