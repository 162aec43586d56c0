"""Chapter Limit switch inputs: an active limit ends motion in its direction at once, and prevents new motion."""

from collections.abc import Callable
from functools import partial

from axistwin.controllers.compumotor.parts.pulses import PulseGenerator
from axistwin.sim.clock import Clock
from axistwin.sim.pins import Pin


class Limits:
    """The two limit inputs, active high: +1 is the CW limit, -1 the CCW limit."""

    def __init__(self, clock: Clock, pulses: PulseGenerator, cw: Pin, ccw: Pin, filter_ns: int) -> None:
        self.clock, self._pulses, self._filter_ns = clock, pulses, filter_ns
        self._pins = {+1: cw, -1: ccw}
        self._changes = dict.fromkeys(self._pins, 0)
        self.on_hit: Callable[[int], None] = lambda sign: None
        """Function that is called with +1 or -1 when the + or - limit has become active."""
        self._unsubscribe = [pin.subscribe(partial(self._changed, side)) for side, pin in self._pins.items()]

    def close(self) -> None:
        for unsubscribe in self._unsubscribe:
            unsubscribe()
        self._changes = dict.fromkeys(self._pins, -1)

    def _side(self, sign: int) -> int:
        return sign if self._pulses.cw_is_plus else -sign

    def blocks(self, sign: int) -> bool:
        """True if the limit in the direction `sign` (+1 or -1) is active."""
        return self._pins[self._side(sign)].level

    def _changed(self, side: int, pin: Pin) -> None:
        self._changes[side] += 1
        if pin.level:
            self.clock.call_later(self._filter_ns, partial(self._act, side, self._changes[side]))

    def _act(self, side: int, change: int) -> None:
        if change != self._changes[side]:
            return
        if self._pulses.physical == side:
            self._pulses.kill()
        self.on_hit(self._side(side))
