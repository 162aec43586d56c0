"""The motion of an axis of a device: velocity 1000, acceleration 10,000, so that a ramp takes 0.1 s and 50 steps."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from axistwin.core.units import S
from axistwin.devices import Device, Input, Positioner

from .made import device, on_a_bench


class Slide(Device):
    """One axis with its three switches."""

    model = "slide"
    axes = {"X": Positioner(velocity=1000, acceleration=10_000, minus="minus", plus="plus", home="home")}
    pins = {"minus": Input(True), "plus": Input(True), "home": Input()}

    def start(self):
        self.reached, self.found = [], None

    def limit_reached(self, axis, side):
        self.reached.append((axis, side))

    def search(self, velocity=1000):
        self.found = yield from self.axes["X"].find_home(velocity, 100)


class Servo(Slide):
    """The same axis with an encoder."""

    model = "servo"
    axes = {"X": Positioner(velocity=1000, acceleration=10_000, servo=True)}


class Strict(Slide):
    """The same servo, which may follow at most 100 counts behind."""

    model = "strict"
    axes = {"X": Positioner(velocity=1000, acceleration=10_000, servo=True, following_error=100)}


@pytest.fixture
def slide():
    return on_a_bench(Slide)


def parts(made):
    bench, controller = made
    return bench, controller.axes["X"], device(controller).axes["X"]


def settled(bench, x, patience=100):
    """Return the seconds, since a second after power-on, at which the axis is at rest."""
    assert bench.run_until(lambda: not x.moving, patience)
    return (bench.now - S) / S


def test_a_move(slide):
    bench, motor, x = parts(slide)
    x.move_to(5000)
    assert (x.moving, x.target, settled(bench, x)) == (True, 5000, 5.1)
    assert (x.position, motor.position, x.speed, len(motor.pulse_times())) == (5000, 5000, 0, 5000)
    x.move_by(-100)
    assert settled(bench, x) == pytest.approx(5.3, abs=1e-8) and x.position == 4900
    x.move_to(4900.4)
    assert not x.moving and x.target == 4900


def test_a_start_velocity(slide):
    bench, _, x = parts(slide)
    x.start_velocity = 200
    x.move_to(5000)
    assert settled(bench, x) == 5.064


def test_an_endless_motion_and_a_stop_with_a_ramp(slide):
    bench, _, x = parts(slide)
    x.run(500)
    bench.run(1)
    assert (x.position, x.speed) == (487, 500)  # 12.5 in 0.05 s, 475 in 0.95 s
    x.stop()
    assert (settled(bench, x), x.position) == (1.05, 500)
    x.run(0)
    assert not x.moving
    x.run(-500)
    bench.run(1)
    x.run(0)
    assert settled(bench, x) == 2.1 and x.position == 0


def test_a_change_of_velocity_in_motion(slide):
    bench, _, x = parts(slide)
    x.run(1000)
    bench.run(1)  # 950
    x.run(400)
    bench.run(1)  # 42 in 0.06 s, 376 at 400
    assert (x.position, x.speed) == (1368, 400)
    x.velocity = 200
    x.move_to(1500)  # 6 in 0.02 s to 200, 124 at 200, 2 in 0.02 s
    assert (settled(bench, x), x.position) == (pytest.approx(2.66, abs=1e-8), 1500)


def test_a_reversal(slide):
    bench, _, x = parts(slide)
    x.run(1000)
    bench.run(1)
    x.run(-1000)
    bench.run(0.1)
    assert (x.position, x.moving) == (1000, True)
    bench.run(0.1)
    assert (x.position, x.speed) == (950, -1000)


def test_a_reversal_where_the_position_is_the_velocity(slide):
    bench, _, x = parts(slide)
    x.define(-1500)
    x.run(1000)
    bench.run(1)
    x.run(-500)  # the stop ends at -500
    bench.run(1)
    assert (x.position, x.speed) == (-937, -500)  # 12.5 in 0.05 s, 425 in 0.85 s


@pytest.mark.parametrize(("target", "seconds"), [
    (2000, 2.1), (5000, 5.1), (1000, 1.1),                        # on the way
    (999, 1.12), (0, 2.2), (-1000, 3.2),                          # stop at 1000 after 1.1 s, then back 1, 1000, 2000
])  # fmt: skip
def test_a_target_in_motion(slide, target, seconds):
    bench, motor, x = parts(slide)
    x.move_to(3000)
    bench.run(1)  # 950
    x.move_to(target)
    assert settled(bench, x) == pytest.approx(seconds, abs=2e-8)
    assert (x.position, motor.position) == (target, target)


@pytest.mark.parametrize(("target", "seconds"), [(5000, 5.1), (-5000, 5.1), (0, 0)])
def test_the_second_target_of_the_same_instant(slide, target, seconds):
    bench, motor, x = parts(slide)
    x.move_to(300)
    x.move_to(target)
    assert (settled(bench, x), x.position, len(motor.pulse_times())) == (seconds, target, abs(target))


def test_a_stop_at_the_instant_of_the_start(slide):
    _, motor, x = parts(slide)
    x.run(1000)
    x.stop()
    assert not x.moving and not motor.velocity and x.position == 0


def test_a_distance_counts_from_the_target_of_a_move_else_from_here(slide):
    bench, _, x = parts(slide)
    x.move_to(2000)
    bench.run(1)
    x.move_by(500)
    assert x.target == 2500
    x.run(1000)
    x.move_by(500)
    assert x.target == 950 + 500


def test_an_abort(slide):
    bench, motor, x = parts(slide)
    x.move_to(3000)
    bench.run(1)
    x.abort()
    assert (x.moving, x.speed) == (False, 0)
    bench.run(1)
    assert (x.position, len(motor.pulse_times())) == (950, 950)


def test_the_done_event_is_that_of_the_latest_motion(slide):
    bench, _, x = parts(slide)
    times = []

    def wait():
        yield x.done
        times.append(bench.now)
        x.move_to(3000)
        yield x.done
        times.append(bench.now)

    device(slide[1]).begin(wait())
    bench.run(1)  # at rest the event is due at once
    x.move_to(1000)
    bench.run(10)
    assert times == [S, S + 1_100_000_000]


def test_a_position_given_in_motion_keeps_the_end(slide):
    bench, motor, x = parts(slide)
    x.move_to(5000)
    bench.run(1)
    x.define(0)
    assert (x.position, x.target) == (0, 4050)
    assert (settled(bench, x), x.position, motor.position) == (5.1, 4050, 5000)


def test_limits_stop_and_can_be_left():
    bench, controller = on_a_bench(Slide, X={"limits": (-100, 3000)})
    x, motor = device(controller).axes["X"], controller.axes["X"]
    x.move_to(5000)
    assert settled(bench, x) == pytest.approx(3.051, abs=1e-6)  # the pulse that opens the switch
    assert (motor.position, x.stopped_by, x.at_limit(+1), x.at_limit(-1)) == (3001, "plus limit", True, False)
    assert controller.hint == "axis X stands at its plus limit: move it in the minus direction"
    x.run(1000)
    bench.run(1)
    assert motor.position == 3001 and device(controller).reached == [("X", +1)] * 2
    x.move_to(2990)
    assert x.stopped_by == ""
    settled(bench, x)
    assert not x.at_limit(+1)
    x.run(-1000)
    settled(bench, x)
    assert (motor.position, x.stopped_by) == (-101, "minus limit")


@pytest.mark.parametrize(("home", "at"), [((200, 300), 199), ((200, 202), 199), ((0, 300), -1), ((-50, -20), None)])
def test_a_search_for_home_ends_where_the_switch_is_left(home, at):
    bench, controller = on_a_bench(Slide, X={"home": home, "limits": (-500, 500)})
    device(controller).begin(device(controller).search())
    bench.run(20)
    assert device(controller).found is (at is not None)
    assert controller.axes["X"].position == (501 if at is None else at)
    assert device(controller).axes["X"].position == (501 if at is None else 0)


def test_a_stop_ends_a_search_for_home():
    bench, controller = on_a_bench(Slide, X={"home": (2000, 2100)})
    device(controller).begin(device(controller).search())
    bench.run(1)
    device(controller).axes["X"].stop()
    bench.run(1)
    assert (device(controller).found, controller.axes["X"].position) == (False, 1000)


def test_a_servo_returns_when_the_shaft_is_free():
    bench, motor, x = parts(on_a_bench(Servo))
    motor.jam()
    x.move_to(1000)
    bench.run(2)
    assert (motor.position, x.position, x.commanded) == (0, 0, 1000)
    motor.jam(on=False)
    bench.run(2)
    assert (motor.position, x.position, x.commanded) == (1000, 1000, 1000)


def test_a_servo_stops_at_the_following_error_also_if_jammed_in_motion():
    bench, controller = on_a_bench(Strict)
    x, motor = device(controller).axes["X"], controller.axes["X"]
    motor.jam()
    x.move_to(1000)
    bench.run(0.15)
    assert x.moving and x.commanded == 100
    bench.run(0.002)  # the error is looked at every millisecond
    assert (x.moving, x.stopped_by, x.position, x.commanded) == (False, "following error", 0, 0)
    assert device(controller).reached == [("X", 0)]
    motor.jam(on=False)
    x.move_to(1000)
    bench.run(0.6)  # 550
    motor.jam()
    bench.run(1)
    assert (x.stopped_by, x.position, x.moving) == ("following error", 550, False)


def test_without_power_nothing_moves_and_the_next_position_is_0():
    bench, controller = on_a_bench(Servo)
    x, motor = device(controller).axes["X"], controller.axes["X"]
    x.move_to(1000)
    bench.run(0.6)
    motor.jam()
    bench.run(0.1)
    controller.power(False)
    bench.run(0.1)
    issued = motor.pulses
    motor.jam(on=False)
    bench.run(2)
    assert (motor.pulses, controller.busy) == (issued, False)
    controller.power(True)
    bench.run(1)
    x = device(controller).axes["X"]
    assert (x.position, x.commanded, x.moving) == (0, 0, False)


def test_targets_streamed_in_a_long_move_leave_no_events_behind(slide):
    bench, _, x = parts(slide)
    for number in range(100):
        x.move_to(10**9 - number)
        bench.run(0.01)
    assert len(bench.clock._queue) == 1


@given(st.floats(0.001, 1.099), st.integers(1, 10**5), st.integers(1, 10**6))
def test_the_same_target_again_at_any_time_changes_nothing(part, velocity, acceleration):
    bench, motor, x = parts(on_a_bench(Slide))
    x.velocity, x.acceleration = velocity, acceleration
    x.move_to(1000)
    bench.run((1000 / velocity + velocity / acceleration) * part)
    x.move_to(1000)
    settled(bench, x, 10**7)
    assert (x.position, len(motor.pulse_times(S))) == (1000, 1000)


@given(st.lists(st.tuples(st.integers(-500, 500), st.floats(0, 0.5)), min_size=1, max_size=8), st.integers(0, 2000))
def test_the_last_target_is_reached_whenever_targets_change(targets, start_velocity):
    bench, motor, x = parts(on_a_bench(Slide))
    x.start_velocity = start_velocity
    for target, seconds in targets:
        x.move_to(target)
        bench.run(seconds)
    settled(bench, x)
    assert x.position == motor.position == targets[-1][0]


def test_a_switch_far_away_leaves_nothing_on_the_clock_either():
    """A move of 10**9 steps would end in 11 days, and its limit switch is reached a little earlier."""
    bench, controller = on_a_bench(Slide, X={"limits": (-(10**9) + 50, 10**9 - 50)})
    axis = device(controller).axes["X"]
    for target in range(100):
        axis.move_to(10**9 + target)
        bench.run(0.01)
    assert len(bench.clock._queue) <= 2 and bench.clock.background == 0
