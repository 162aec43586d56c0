"""A simulated board that makes the pulses of a bench, at each speed of its virtual time."""

from axistwin.core.units import MS
from axistwin.real.standin.driver import Driver

from .metal import Metal

PERIOD_NS = 10 * MS


class ServedBoard:
    """A driver and a board that advance with the bench."""

    def __init__(self, bench, axes):
        self.metal = Metal(axes=axes, inputs=(), outputs=(), tick_s=PERIOD_NS / 2e9).start()
        self.lines, self._bench = [], bench
        self._driver = Driver(bench, [self.metal.board], self.lines.append)
        self._take(self.metal.now)
        self._driver.begin(self.metal.now)
        bench.clock.call_later(PERIOD_NS, self._turn)

    def _take(self, now):
        for event in self.metal.events:
            self._driver.handle(self.metal.board, event)
        self.metal.events.clear()

    def _turn(self):
        self.metal.run(PERIOD_NS / 1e9, self._take)
        self._driver.collect()
        self._bench.clock.call_later(PERIOD_NS, self._turn)

    def moves(self, pins):
        """Return the moves in order, with their pulses; `pins`: step pin of each axis.

        A move ends at a pause, or where an axis reverses: a fast host leaves no pause between two moves.
        """
        pulses = self.metal.small.pulses
        every = sorted((tick, axis, way) for axis, pin in pins.items() for tick, way in pulses[pin])
        found, last = [], 0
        for tick, axis, way in every:
            pause = tick - last > 320_000  # 20 ms: longer than between two pulses of a move
            if pause or found[-1].get(axis, 0) * way < 0:
                found.append({})
            found[-1][axis] = found[-1].get(axis, 0) + way
            last = tick
        return found
