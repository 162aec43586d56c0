"""Sending basic move instructions: Run mode instructions."""

import pytest

from axistwin.units import S

from .helpers import strokes
from .talking import ask, at_speed, constant, faults, moving, pulse_times_of, ramped, since_start, start_ns, tell


def test_the_x_axis_runs_continuously_at_5000(bench, if1):
    """Run mode: ""X @ 5000 G $ <CR>" will run the X axis continuously at 5000 steps/sec"."""
    tell(if1, "X @ 5000 G $")
    assert at_speed(bench, if1) == 5000
    bench.run(3600)
    assert if1.axes["X"].velocity == 5000 and if1.axes["X"].position > 18_000_000
    # up: 400 ... 4900, 46 levels of 10 ms: 1219 pulses in 460 ms; then one each 200 us
    begin = start_ns(if1.axes["X"])
    times = [int(time) - begin for time in if1.axes["X"].pulse_times(begin, begin + 2 * S)][:5000]
    assert times[1218] == 460_000_000 and times[1219] == 460_200_000
    assert times == pulse_times_of(ramped(10_000, 400, 5000, 100, 10_000))[:5000]


def test_the_y_axis_runs_in_the_negative_direction_at_the_previous_speed(bench, if1):
    """Run mode: ""Y- G $ <CR>" will run the Y axis in the negative direction at the previously-programmed speed"."""
    tell(if1, "@250")
    tell(if1, "Y- G $")
    assert at_speed(bench, if1, "Y") == -250
    assert since_start(if1.axes["Y"])[:1000] == constant(250, 1000)


@pytest.mark.parametrize("message", ["XG@300$", "X@300G$", "@300XG$", "X+G@300$", "XG$@300"])
def test_go_stands_behind_the_axis(bench, if1, message):
    """Run mode: "no distance is programmed and the Go command "G" is included"; `$` stands last."""
    tell(if1, message)
    bench.run(1)
    if message.endswith("$"):
        assert if1.axes["X"].velocity == 300
    else:
        assert not moving(if1)
        assert faults(bench, if1) == (b"128\r", b"8\r")


def test_the_cancel_code_stops_it(bench, if1):
    """Run mode: "To stop the motor, send the cancel code "# <CR>"": from 5000 in 46 levels: 1219 pulses."""
    tell(if1, "X@5000G$")
    bench.run(3)
    axis = if1.axes["X"]
    tell(if1, "#")
    assert bench.run_until(lambda: axis.velocity < 5000, 0.1)
    begin, before = bench.now, axis.position
    bench.run(2)
    assert axis.position == before + 1219
    assert begin + 0.457 * S <= int(axis.pulse_times()[-1]) <= begin + 0.46 * S
    assert ask(bench, if1, "N") == b"%d\r" % axis.position


def test_the_cancel_code_stops_it_while_a_reply_is_held(bench, if1):
    """Run mode: "To stop the motor, send the cancel code"; R9: it acts at once, though CTS holds back a reply (R4)."""
    if1.serial.host.rts = False
    tell(if1, "XG$")
    tell(if1, "E")
    bench.run(1)
    assert moving(if1)
    tell(if1, "#")
    bench.run(1)
    assert not moving(if1)


def test_several_axes_run_together(bench, if1):
    """Index mode: "More than one axis may be selected"."""
    tell(if1, "X+Y-ZG$")
    bench.run(10)
    assert [axis.velocity for axis in if1.axes.values()] == [400, -400, 400]
    tell(if1, "#")
    bench.run(1)
    x, y, z = (axis.position for axis in if1.axes.values())
    assert x == -y == z


def test_after_a_run_the_index_length_is_zero(bench, if1):
    """Run mode: "the interface will default to zero index length"."""
    tell(if1, "X70$")
    tell(if1, "XG$")
    bench.run(1)
    tell(if1, "#")
    bench.run(0.1)
    stopped = if1.axes["X"].position
    tell(if1, "X$")
    tell(if1, "Y$")
    bench.run(1)
    assert if1.axes["X"].position == stopped and if1.axes["Y"].position == 0
    tell(if1, "X70$")  # "Therefore the distance MUST be stated in a subsequent index instruction"
    bench.run(1)
    assert if1.axes["X"].position == stopped + 70


def test_it_is_busy_and_in_motion_while_it_runs(bench, if1):
    """Busy status and motion status: running at speed is 1 + 2."""
    tell(if1, "XG$")
    bench.run(0.1)
    assert ask(bench, if1, "E") == b"E\r"
    assert ask(bench, if1, "K") == b"3\r"


def test_a_run_can_be_followed_by_one_in_the_other_direction(bench, if1):
    """Run mode: after `#` the next message."""
    tell(if1, "XG$")
    bench.run(1)
    tell(if1, "#")
    tell(if1, "X-G$")
    bench.run(1)
    assert if1.axes["X"].velocity == -400
    tell(if1, "#")
    bench.run(1)
    there, back = strokes(if1.axes["X"])
    assert there > 0 > back


def test_go_without_an_axis_is_a_data_fault(bench, if1):
    """Run mode: "the axis to be moved is selected as before"."""
    for message in ("G$", "@500G$"):
        tell(if1, message)
        bench.run(0.2)
        assert not moving(if1), message
        assert faults(bench, if1) == (b"128\r", b"8\r"), message


def test_go_before_the_axis_is_a_data_fault(bench, if1):
    """Run mode: "the axis to be moved is selected as before", and then comes G; digest: "after axis/speed"."""
    tell(if1, "GX$")
    bench.run(0.2)
    assert not moving(if1)
    assert faults(bench, if1) == (b"128\r", b"8\r")


def test_a_run_at_the_lowest_speed(bench, if1):
    """Speed: "Speeds between 1 and 8 steps/sec will run at 6.25": one pulse each 160 ms."""
    tell(if1, "X@1G$")
    bench.run(16.05)
    assert since_start(if1.axes["X"])[:99] == [n * 160_000_000 for n in range(1, 100)]


def test_after_an_interpolated_run_the_index_lengths_are_zero(bench, if1):
    """Run mode: "the data used in a previous index will be lost if the run mode is used"."""
    tell(if1, "X2000/Y500@400G$")
    bench.run(1.0)
    tell(if1, "#")
    bench.run(0.1)
    x, y = if1.axes["X"].position, if1.axes["Y"].position
    assert (x > 0, 0 <= x - 4 * y < 4) == (True, True)  # the ratio of the lengths is the ratio of the speeds
    for text in ("X$", "X/Y$"):
        tell(if1, text)
        bench.run(1.0)
    assert (if1.axes["X"].position, if1.axes["Y"].position) == (x, y)
    assert ask(bench, if1, "F") == b"0\r"
    tell(if1, "X/YG$")  # and there is no ratio any more
    bench.run(0.2)
    assert ask(bench, if1, "F") == b"16\r"


def test_a_run_that_is_refused_leaves_the_index_length(bench, if1):
    """Run mode: the data are lost "if the run mode is used"; this run never begins."""
    tell(if1, "X50$")
    bench.run(0.3)
    if1.pins["limit_plus"].drive(False)
    bench.run(0.1)
    ask(bench, if1, "K")
    tell(if1, "XG$")
    bench.run(0.1)
    ask(bench, if1, "K")
    tell(if1, "X-$")
    bench.run(0.3)
    assert if1.axes["X"].position == 0
