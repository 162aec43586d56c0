"""Times of a board's periodic events: readings of inputs and reports of triggers.

The board handles one event after the other, and a step that is due at the same time is late.  No two periodic events
are due at the same time: within a period each stop input has a slot of its own.  All other inputs share a slot and the
reports another, in different periods.

    period   | stop 0 | stop 1 | input 0 | report 0 | stop 0 | stop 1 | input 1 | report 1 | ...
"""

from dataclasses import dataclass

from axistwin.standin.wiring import InputPin, Wiring

SLOT_S = 25e-6
"""Shortest time between two events; an AVR at 16 MHz needs 17 µs for one."""
REPORT_S = 0.1
"""Approximate interval at which the board repeats the state of its triggers, as responses may be lost."""


@dataclass(frozen=True)
class Timetable:
    """The periodic events of a board; `hz` is the frequency of its clock.  All times are in ticks of this clock."""

    wiring: Wiring
    hz: float

    @property
    def slot(self) -> int:
        """Time between two events."""
        return round(max(self.wiring.stop_sample_s * self.hz / self._slots, SLOT_S * self.hz))

    @property
    def period(self) -> int:
        """Interval at which the board reads each stop input."""
        return self.slot * self._slots

    @property
    def _slots(self) -> int:
        return len(self._stops) + 2

    @property
    def _stops(self) -> tuple[str, ...]:
        return tuple(given.to for given in self.wiring.inputs if given.stops is not None)

    @property
    def _others(self) -> tuple[str, ...]:
        return tuple(given.to for given in self.wiring.inputs if given.stops is None)

    @property
    def report(self) -> int:
        """Interval of the reports of a trigger."""
        return self._whole(REPORT_S)

    def _whole(self, seconds: float) -> int:
        """Return the number of ticks of about this many seconds, in whole periods."""
        return max(1, round(seconds * self.hz / self.period)) * self.period

    def interval(self, given: InputPin) -> int:
        """Return the time between two readings of an input."""
        return self.period if given.stops is not None else self._whole(self.wiring.sample_s)

    def reading(self, given: InputPin, soon: float) -> int:
        """Return the time of a reading of this input, at `soon` or later."""
        if given.to in self._stops:
            return self._at(self._stops.index(given.to), 0, soon)
        return self._at(len(self._stops), self._others.index(given.to), soon)

    def reporting(self, trigger: int, soon: float) -> int:
        """Return the time of a report of this trigger, at `soon` or later; `trigger`: its number on the board."""
        return self._at(len(self._stops) + 1, trigger, soon)

    def _at(self, slot: int, periods: int, soon: float) -> int:
        """Return the time in this slot, this number of whole periods after the period that follows `soon`."""
        return (-(-int(soon) // self.period) + periods) * self.period + slot * self.slot
