"""Times of a board's periodic events: readings of inputs and reports of triggers.

The board handles one event after the other, and a step that is due at the same time is late.  So no two periodic events
are due at the same time: within a period each stop input has a slot of its own.  The other inputs and the reports share
the last slot: these inputs are read in odd periods, and the reports are sent in even periods.  Their intervals are
therefore rounded to an even number of periods.

    period   | stop 0 | stop 1 |   -    | report 0 | stop 0 | stop 1 |   -    | input 0 | stop 0 | ...

The firmware has periodic events too, on an AVR at multiples of 32,768 ticks and of 0.1 s.  At 16 MHz, both are
multiples of 512 ticks.  A slot has this length, or another power of two, and its event is due in its middle.
"""

from dataclasses import dataclass

from axistwin.real.standin.wiring import InputPin, Wiring

SLOT_S = 25e-6  # Shortest time between two events; an AVR at 16 MHz needs 17 µs for one.
LEAST_SLOTS = 4
REPORT_S = 0.1  # Approximate interval at which the board repeats the state of its triggers, as responses may be lost.


@dataclass(frozen=True)
class Timetable:
    """The times of a board's periodic events, in ticks of the board's clock.  `hz` is the frequency of the clock."""

    wiring: Wiring
    hz: float

    @property
    def slot(self) -> int:
        """Length in ticks of a time slot, in which the board executes one periodic task, e.g. a reading."""
        least = max(SLOT_S, self.wiring.stop_sample_s / self._slots) * self.hz
        return 1 << max(1, (int(least) - 1).bit_length())

    @property
    def period(self) -> int:
        """Interval, in clock ticks, at which the board reads each stop input."""
        return self.slot * self._slots

    @property
    def _slots(self) -> int:
        return max(LEAST_SLOTS, len(self._stops) + 1)

    @property
    def _stops(self) -> tuple[str, ...]:
        return tuple(given.to for given in self.wiring.inputs if given.stops is not None)

    @property
    def _others(self) -> tuple[str, ...]:
        return tuple(given.to for given in self.wiring.inputs if given.stops is None)

    @property
    def report(self) -> int:
        """Interval, in clock ticks, at which the board reports the state of each trigger."""
        return self._even_periods(REPORT_S)

    def _even_periods(self, seconds: float) -> int:
        return 2 * self.period * max(1, round(seconds * self.hz / (2 * self.period)))

    def interval(self, given: InputPin) -> int:
        return self.period if given.stops is not None else self._even_periods(self.wiring.sample_s)

    def reading(self, given: InputPin, soon: float) -> int:
        """Return the clock tick at which the board next reads an input.  The tick is at `soon` or later."""
        if given.stops is not None:
            return self._at(self._stops.index(given.to), 0, soon)
        return self._at(self._slots - 1, 2 * self._others.index(given.to) + 1, soon)

    def reporting(self, trigger: int, soon: float) -> int:
        """Return the clock tick, at `soon` or later, at which the board next reports trigger number `trigger`."""
        return self._at(self._slots - 1, 2 * trigger, soon)

    def _at(self, slot: int, periods: int, soon: float) -> int:
        """Return the tick in the middle of a slot, `periods` after the first pair of periods at `soon` or later."""
        pair = 2 * self.period
        return -(-int(soon) // pair) * pair + periods * self.period + slot * self.slot + self.slot // 2
