"""The periodic events of a board: none is due at the same time as another."""

from itertools import combinations
from math import gcd

import pytest

from axistwin.real.standin.timetable import Timetable
from axistwin.real.standin.wiring import BoardPin, InputPin, Wiring

from .metal import X

US = 16  # ticks in a microsecond


def table(stops, others, hz=16e6):
    inputs = [InputPin(f"table.stop{n}", BoardPin(f"P{n}"), stops=0) for n in range(stops)]
    inputs += [InputPin(f"table.input{n}", BoardPin(f"P{9 + n}")) for n in range(others)]
    return Timetable(Wiring("board", (X,), tuple(inputs)), hz)


@pytest.mark.parametrize(("stops", "period_us"), [
    (0, 128), (2, 128), (3, 128), (4, 160), (7, 256)], ids=lambda value: str(value))  # fmt: skip
def test_each_stop_input_is_read_once_in_a_period(stops, period_us):
    """512 ticks are 32 µs, and a period has at least four slots: one for each stop input and one for the rest."""
    found = table(stops, 1)
    assert found.period == period_us * US
    for given in found.wiring.inputs[:stops]:
        assert found.interval(given) == period_us * US and 0 <= found.reading(given, 1e9) - 1e9 <= 3 * period_us * US


@pytest.mark.parametrize(("stops", "others"), [(2, 1), (3, 4), (6, 2)])
def test_no_two_events_are_due_within_a_slot(stops, others):
    """Two periodic events come closest by their difference, modulo the greatest common divisor of their intervals."""
    found, soon = table(stops, others), 123_456_789.5
    events = [(found.reading(given, soon), found.interval(given)) for given in found.wiring.inputs]
    events += [(found.reporting(trigger, soon), found.report) for trigger in range(4)]
    for (first, every), (second, other) in combinations(events, 2):
        shared = gcd(every, other)
        apart = (first - second) % shared
        assert min(apart, shared - apart) >= 512


def test_the_events_avoid_those_of_the_firmware():
    """At 16 MHz these are at multiples of 32,768 and of 1,600,000 ticks: all multiples of 512."""
    found = table(3, 1)
    times = [found.reading(given, 1e6) for given in found.wiring.inputs] + [found.reporting(1, 1e6)]
    assert {time % 512 for time in times} == {256}


def test_a_fast_clock_has_longer_slots():
    """At 520 MHz 25 µs are 13,000 ticks; the next power of two is 16,384, so the period is 126 µs."""
    assert table(3, 1, 520e6).period == 4 * 16_384
