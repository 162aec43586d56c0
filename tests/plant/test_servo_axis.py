"""The axis of a servo motor as the user sees it, with any source of its positions."""

from array import array
from dataclasses import asdict

import numpy as np
import pytest

from axistwin.core.errors import UsageError
from axistwin.plant.axes import servo_axis
from axistwin.plant.counts import Samples
from axistwin.plant.servo import FRAME23
from axistwin.plant.servo_axis import FAR, ServoAxis
from axistwin.plant.switches import PositionSwitch, in_series
from axistwin.sim.clock import Clock
from axistwin.sim.pins import UserPin

MS = 10**6


class Motor:
    """A source with a given list of positions, one for each millisecond."""

    def __init__(self, axis, positions):
        self.axis, self.positions, self.told, self.calls = axis, list(positions), 0, []
        axis.connect(self)

    @property
    def now(self):
        return min(self.axis.clock.now // MS, len(self.positions))

    def catch_up(self):
        self.refresh()

    def refresh(self):
        first, self.told = self.told, self.now
        if self.told > first:
            part = self.positions[first : self.told]
            self.axis.publish(Samples((first + 1) * MS, MS, part, part))

    def replan(self):
        self.calls.append((self.axis.outside_torque, self.axis.jammed, self.axis.ambient))

    def position(self):
        return ([0, *self.positions])[self.now]

    def commanded(self):
        return 2 * self.position()

    def velocity(self):
        return 1000.0 * (self.position() - ([0, 0, *self.positions])[self.now])

    def moving(self):
        return self.now < len(self.positions)

    def next_sample_ns(self):
        return (self.axis.clock.now // MS + 1) * MS if self.moving() else None

    def temperature(self):
        return 30.0

    def push(self, counts):
        self.positions[self.now - 1 :] = [position + counts for position in self.positions[self.now - 1 :]]
        self.axis.publish(Samples(self.axis.clock.now, 0, [self.position()], [0]))


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def axis(clock):
    return ServoAxis(clock, "shaft")


def test_a_shaft_that_nobody_turns_rests_and_can_be_pushed(clock, axis):
    assert (axis.position, axis.commanded, axis.velocity, axis.moving) == (0, 0, 0.0, False)
    clock.run_to(5 * MS)
    axis.encoder.displace(-3)
    assert (axis.position, axis.encoder.count) == (-3, -3) and axis.pulse_times().tolist() == [5 * MS] * 3


def test_the_source_tells_where_it_is(clock, axis):
    Motor(axis, [0, 10, 30])
    clock.run_to(2 * MS)
    assert (axis.position, axis.commanded, axis.velocity, axis.moving) == (10, 20, 10_000.0, True)
    clock.run_to(4 * MS)
    assert (axis.position, axis.moving, axis.temperature) == (30, False, 30.0)
    axis.disconnect()
    assert (axis.position, axis.commanded, axis.temperature) == (30, 0, 25.0)


def test_pulse_times_are_spread_evenly_over_the_sample(clock, axis):
    """4 counts between 1 and 2 ms come every quarter of a millisecond; then one count back by 3 ms, and 3 by 4 ms."""
    Motor(axis, [0, 4, 3, 6])
    clock.run_to(10 * MS)
    thirds = [3 * MS + MS // 3, 3 * MS + 2 * MS // 3, 4 * MS]
    assert axis.pulse_times().tolist() == [1_250_000, 1_500_000, 1_750_000, 2 * MS, 3 * MS, *thirds]
    assert axis.pulse_times(1_500_000, 3 * MS).tolist() == [1_500_000, 1_750_000, 2 * MS]
    assert axis.pulse_times(stop_ns=0).dtype == np.int64


def test_there_are_as_many_pulse_times_as_counts(clock, axis):
    positions = [round(50 * np.sin(n / 20)) for n in range(400)]
    Motor(axis, positions)
    clock.run_to(1000 * MS)
    times = axis.pulse_times()
    assert len(times) == np.abs(np.diff(positions, prepend=0)).sum() and (np.diff(times) > 0).all()


def test_it_does_not_matter_in_which_pieces_it_is_told(clock, axis):
    positions = [n * n // 7 for n in range(100)]
    Motor(axis, positions)
    other = ServoAxis(clock, "other")
    for first in range(0, 100, 9):
        part = array("q", positions[first : first + 9])
        other.publish(Samples((first + 1) * MS, MS, part, part))
    clock.run_to(200 * MS)
    assert axis.pulse_times().tolist() == other.pulse_times().tolist()


def test_a_long_past_is_forgotten_and_that_is_told(clock):
    axis = ServoAxis(clock, "shaft", history=20)  # 200 samples
    Motor(axis, range(1, 1001))
    for now in range(50, 1001, 50):
        clock.run_to(now * MS)
        axis.catch_up()
    assert axis.forgotten and len(axis.pulse_times(900 * MS)) == 101
    with pytest.raises(UsageError, match=r"counts before 0.8 s are no longer stored.*history=40"):
        axis.pulse_times()


def test_long_blocks_shorten_no_history(clock):
    """The history holds 200 samples: of three blocks of 150 samples, the last two are kept whole, 300 samples."""
    axis = ServoAxis(clock, "shaft", history=20)  # 200 samples
    for first in (1, 151, 301):
        part = array("q", range(first, first + 150))
        axis.publish(Samples(first * MS, MS, part, part))
    clock.run_to(500 * MS)
    assert axis.pulse_times(150 * MS + 1).tolist() == [n * MS for n in range(151, 451)]


def test_rests_cost_no_history(clock):
    axis = ServoAxis(clock, "shaft", history=2)
    axis.publish(Samples(1 * MS, MS, [1, 2], [0, 0]))
    for n in range(100):
        axis.publish(Samples((n * 1000 + 3) * MS, MS, [2] * 1000, [0] * 1000))
    clock.run_to(10**12)
    assert axis.pulse_times().tolist() == [1 * MS, 2 * MS]


def test_who_watches_is_told_what_has_been_in_order(clock, axis):
    Motor(axis, range(1, 11))
    clock.run_to(3 * MS)
    told = []
    end = axis.subscribe(
        lambda samples: told.append((samples.start_ns, list(samples.positions), list(samples.commanded)))
    )
    clock.run_to(6 * MS + 1)
    axis.catch_up()
    clock.run_to(7 * MS)
    _ = axis.pulse_times()
    end()
    clock.run_to(9 * MS)
    axis.catch_up()
    assert told == [(4 * MS, [4, 5, 6], [4, 5, 6]), (7 * MS, [7], [7])]


def test_torque_jam_and_heat_outlast_their_source(clock, axis):
    motor = Motor(axis, [0])
    axis.load(0.25)
    axis.jam()
    axis.ambient = 40
    assert motor.calls == [(0.25, False, 25.0), (0.25, True, 25.0), (0.25, True, 40.0)]
    axis.disconnect()
    assert (axis.outside_torque, axis.jammed, axis.ambient) == (0.25, True, 40.0)
    with pytest.raises(UsageError, match="invalid ambient temperature 200: expected -40 to 150 °C"):
        axis.ambient = 200


def test_switches_tell_the_window_in_which_nothing_changes(clock, axis):
    """The switches are closed, so the inputs low, from -100 to 500; beyond, the limit inputs are high (3.1)."""
    assert (axis.window_low, axis.window_high) == (-FAR, FAR)
    minus, plus = UserPin(clock, "D"), UserPin(clock, "C")
    in_series([PositionSwitch(axis, -100, None)], minus, closed=False)
    in_series([PositionSwitch(axis, None, 500)], plus, closed=False)
    assert (minus.level, plus.level) == (False, False)
    assert (axis.window_low, axis.window_high) == (-100, 500)
    axis.push(500)
    assert plus.level is False
    axis.push(1)
    assert (minus.level, plus.level) == (False, True)
    assert (axis.window_low, axis.window_high) == (501, FAR)
    axis.push(-602)
    assert (minus.level, plus.level) == (True, False)
    assert (axis.window_low, axis.window_high) == (-FAR, -101)


def test_a_switch_works_when_the_source_says_that_the_window_has_been_left(clock, axis):
    Motor(axis, [400, 600])
    plus = UserPin(clock, "C")
    in_series([PositionSwitch(axis, None, 500)], plus, closed=False)
    clock.run_to(2 * MS)
    assert plus.level is False  # not yet published
    axis.left_window()
    assert (plus.level, axis.window_low) == (True, 501)


@pytest.mark.parametrize(("given", "message"), [
    ({"limit": 1}, "axis shaft has no option 'limit': expected one of limits, motor, load"),
    ({"encoder": {}}, "axis shaft has no option 'encoder'"),
    ({"limits": (5, 1)}, "invalid limits=(5, 1) of axis shaft: expected two positions"),
    ({"motor": "frame99"}, "invalid option of axis shaft: unknown motor"),
    (
        {"motor": "frame23", "load": {"mass": 1}},
        "invalid option of axis shaft: unknown parameter 'mass' of the load",
    )])  # fmt: skip
def test_wrong_options_are_told(clock, given, message):
    with pytest.raises(UsageError) as caught:
        servo_axis(clock, "shaft", given, 100)
    assert str(caught.value).startswith(message)


def test_a_data_sheet_by_its_name(clock):
    axis = servo_axis(clock, "shaft", {"motor": "frame23", "load": {"inertia_kg_m2": 1e-5}}, 100)
    assert (axis.motor.counts_per_rev, axis.load_data.inertia_kg_m2) == (2000, 1e-5)
    assert servo_axis(clock, "shaft", {}, 100).motor is None


def test_its_travel_and_the_counts_of_a_turn_are_told():
    clock = Clock()
    motor = {**asdict(FRAME23), "counts_per_rev": 4000}
    axis = servo_axis(clock, "shaft", {"limits": (-100, 5000), "motor": motor}, 100)
    assert (axis.limits, axis.per_rev) == ((-100, 5000), 4000)
    ideal = servo_axis(clock, "shaft", {}, 100)
    assert (ideal.limits, ideal.per_rev, ideal.setpoint) == (None, 2000, 0)
