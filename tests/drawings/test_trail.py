"""The trail of an X-Y table, calculated from the moves of its axes."""

import asyncio
from fractions import Fraction

import pytest

from axistwin import Bench, Session
from axistwin.sim.motion.profile import Profile, Segment
from axistwin.ui.drawings.trail import MOST_MOVES, PLACES, POINTS, Trail, Trails, table_axes

TRAVEL = {"limits": (-1000, 9000)}
HALF = Fraction(1, 2)


def table(**options):
    bench = Bench()
    return bench, bench.add("if2", "table", **{"X": TRAVEL, "Y": TRAVEL, **options})


@pytest.fixture
def moving():
    bench, controller = table()

    def go(axis, *segments, direction=+1):
        profile = Profile([Segment(Fraction(rate), seconds) for rate, seconds in segments])
        controller.axes[axis].start(profile, direction)

    return bench, controller, go


def trail_of(controller):
    return Trail(controller, ("X", "Y"))


def square(bench, go, update=lambda: None):
    for axis, rate, direction in (("X", 100, +1), ("Y", 50, +1), ("X", 100, -1)):
        go(axis, (rate, Fraction(1)), direction=direction)
        bench.run(1.5)
        update()


CORNERS = [(0, 0), (100, 0), (100, 50), (0, 50)]


def test_a_path_of_moves_has_their_ends_as_corners_after_any_number_of_updates(moving):
    bench, controller, go = moving
    once, often = trail_of(controller), trail_of(controller)
    square(bench, go, update=often.update)
    once.update()
    assert list(once.points) == list(often.points) == CORNERS


def test_in_the_middle_of_a_move_the_path_ends_at_the_table(moving):
    bench, controller, go = moving
    trail = trail_of(controller)
    go("X", (100, Fraction(1)))
    for _ in range(5):
        bench.run(0.1)
        trail.update()
    assert list(trail.points) == [(0, 0), (50, 0)] and trail.here == (50, 0)


def test_two_axes_at_one_rate_make_a_straight_line(moving):
    bench, controller, go = moving
    trail = trail_of(controller)
    go("X", (160, Fraction(1)))
    go("Y", (80, Fraction(1)), direction=-1)
    bench.run(2)
    trail.update()
    assert list(trail.points) == [(0, 0), (160, -80)]


def test_a_ramp_of_one_of_them_makes_a_curve(moving):
    """The axes move 40 and 20 pulses in the first half second, and 40 and 60 in the second."""
    bench, controller, go = moving
    trail = trail_of(controller)
    go("X", (80, Fraction(1)))
    go("Y", (40, HALF), (120, HALF))
    bench.run(2)
    trail.update()
    assert list(trail.points) == [(0, 0), (40, 20), (80, 80)]


def test_a_motor_that_loses_pulses_stays_behind(moving):
    bench, controller, go = moving
    trail = trail_of(controller)
    go("X", (100, Fraction(1)))
    bench.run(1.5)
    trail.update()
    controller.axes["Y"].jam()
    go("Y", (100, Fraction(1)))
    bench.run(1.5)
    trail.update()
    assert list(trail.points) == [(0, 0), (100, 0)]


def test_of_many_moves_only_the_latest_are_drawn(moving):
    bench, controller, go = moving
    trail = trail_of(controller)
    for number in range(MOST_MOVES + 50):
        go("X", (1000, Fraction(1, 100)))
        go("Y", (1000, Fraction(1, 100)), direction=+1 if number % 2 else -1)
        bench.run(0.02)
    trail.update()
    x = controller.axes["X"].position
    assert trail.points[-1] == (x, 0) and trail.points[0] == (x - 10 * MOST_MOVES, 0)
    assert len(trail.points) == MOST_MOVES + 1


def test_it_is_bounded(moving):
    bench, controller, go = moving
    trail = trail_of(controller)
    for number in range(POINTS + 100):
        go("XY"[number % 2], (1000, Fraction(1, 1000)))
        bench.run(0.002)
        trail.update()
    assert len(trail.points) == POINTS and trail.points[-1] == trail.here
    assert trail.begun == POINTS + 101


def test_where_an_output_has_been_high(moving):
    bench, controller, go = moving
    trail, output = trail_of(controller), controller.pins["output1"]
    for _ in range(3):
        go("X", (100, Fraction(1)))
        bench.run(1.5)
        output.set(True)
        bench.run(0.1)
        output.set(False)
    assert list(trail.places["output1"]) == [(100, 0), (200, 0), (300, 0)] and not trail.places["output2"]
    assert "input1" not in trail.places


def test_a_place_seen_again_or_the_power_begins_a_cycle_but_not_the_last_place(moving):
    bench, controller, go = moving
    places = trail_of(controller).places["output1"]

    def drill(by):
        go("X", (100, Fraction(1)), direction=by)
        bench.run(1.5)
        for _ in range(2):  # Twice, to clear the hole.
            controller.pins["output1"].set(True)
            controller.pins["output1"].set(False)

    drill(+1)
    drill(+1)
    assert places == {(100, 0): True, (200, 0): True}
    drill(-1)
    assert places == {(200, 0): False, (100, 0): True}
    controller.power(False)
    assert not any(places.values())


def test_of_those_places_the_latest_are_kept(moving):
    bench, controller, go = moving
    trail = trail_of(controller)
    for _ in range(PLACES + 10):
        go("X", (1000, Fraction(1, 1000)))
        bench.run(0.002)
        controller.pins["output1"].set(True)
        controller.pins["output1"].set(False)
    assert list(trail.places["output1"]) == [(1 + n, 0) for n in range(10, PLACES + 10)]


def test_a_table_is_made_by_two_axes_with_travel():
    assert table_axes(table()[1]) == ("X", "Y") and table_axes(table(Y={}, Z=TRAVEL)[1]) == ("X", "Z")
    assert table_axes(table(Y={})[1]) is None


def test_with_another_bench_it_begins_anew():
    async def back():
        session = Session(lambda: table()[0], None)
        trails = Trails(session)
        first = trails["table"]
        session.bench.run(0.5)
        await session.go_to(0.25)
        assert trails["table"] is not first and trails["table"].here == (0, 0)

    asyncio.run(back())
