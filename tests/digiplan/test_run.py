"""Sending basic move instructions: Run mode instructions."""

import pytest

from axistwin.units import S

from .talking import (
    ask,
    at_speed,
    command,
    constant,
    faults,
    moves,
    moving,
    play,
    pulse_times_of,
    ramped,
    scripts,
    since_start,
    start_ns,
    write,
)


def test_the_x_axis_runs_continuously_at_5000(bench, if1):
    """Run mode: ""X @ 5000 G $ <CR>" will run the X axis continuously at 5000 steps/sec"."""
    write(if1, "X @ 5000 G $")
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
    write(if1, "@250", "Y- G $")
    assert at_speed(bench, if1, "Y") == -250
    assert since_start(if1.axes["Y"])[:1000] == constant(250, 1000)


@pytest.mark.parametrize("message", ["XG@300$", "X@300G$", "@300XG$", "X+G@300$", "XG$@300"])
def test_go_stands_behind_the_axis(bench, if1, message):
    """Run mode: "no distance is programmed and the Go command "G" is included"; `$` stands last."""
    command(bench, if1, message, seconds=1)
    if message.endswith("$"):
        assert if1.axes["X"].velocity == 300
    else:
        assert not moving(if1)
        assert faults(bench, if1) == (b"128\r", b"8\r")


def test_the_cancel_code_stops_it(bench, if1):
    """Run mode: "To stop the motor, send the cancel code "# <CR>"": from 5000 steps/s 46 levels, 1219 pulses."""
    command(bench, if1, "X@5000G$", seconds=3)
    axis = if1.axes["X"]
    write(if1, "#")
    assert bench.run_until(lambda: axis.velocity < 5000, 0.1)
    begin, before = bench.now, axis.position
    bench.run(2)
    assert axis.position == before + 1219
    assert begin + 0.457 * S <= int(axis.pulse_times()[-1]) <= begin + 0.46 * S
    assert ask(bench, if1, "N") == b"%d\r" % axis.position


def test_the_cancel_code_stops_it_while_a_reply_is_held(bench, if1):
    """Run mode: "To stop the motor, send the cancel code"; R9: it acts at once, though CTS holds back a reply (R4)."""
    if1.serial.host.rts = False
    command(bench, if1, "XG$", "E", seconds=1)
    assert moving(if1)
    command(bench, if1, "#", seconds=1)
    assert not moving(if1)


def test_several_axes_run_together(bench, if1):
    """Index mode: "More than one axis may be selected"."""
    command(bench, if1, "X+Y-ZG$", seconds=10)
    assert [axis.velocity for axis in if1.axes.values()] == [400, -400, 400]
    command(bench, if1, "#", seconds=1)
    x, y, z = (axis.position for axis in if1.axes.values())
    assert x == -y == z


def test_after_a_run_the_index_length_is_zero(bench, if1):
    """Run mode: "the interface will default to zero index length"."""
    command(bench, if1, "X70$", "XG$", seconds=1)
    command(bench, if1, "#", seconds=0.1)
    stopped = if1.axes["X"].position
    command(bench, if1, "X$", "Y$", seconds=1)
    assert if1.axes["X"].position == stopped and if1.axes["Y"].position == 0
    write(if1, "X70$")  # "Therefore the distance MUST be stated in a subsequent index instruction"
    bench.run(1)
    assert if1.axes["X"].position == stopped + 70


@scripts(
    {
        "Busy status and motion status: running at speed is 1 + 2": "XG$; 0.1 s; E: E; K: 3",
        'Run mode: "the axis to be moved is selected as before", and then comes G; digest: "after axis/speed"':
        "GX$; 0.2 s; still; K: 128; F: 8",
    }
)  # fmt: skip
def test_run_mode(bench, if1, script):
    play(bench, if1, script)


def test_a_run_can_be_followed_by_one_in_the_other_direction(bench, if1):
    """Run mode: after `#` a run in the other direction begins when the motor is at rest."""
    command(bench, if1, "XG$", seconds=1)
    command(bench, if1, "#", "X-G$", seconds=1)
    assert if1.axes["X"].velocity == -400
    command(bench, if1, "#", seconds=1)
    there, back = moves(if1.axes["X"])
    assert there > 0 > back


def test_go_without_an_axis_is_a_data_fault(bench, if1):
    """Run mode: "the axis to be moved is selected as before"."""
    for message in ("G$", "@500G$"):
        command(bench, if1, message)
        assert not moving(if1), message
        assert faults(bench, if1) == (b"128\r", b"8\r"), message


def test_a_run_at_the_lowest_speed(bench, if1):
    """Speed: "Speeds between 1 and 8 steps/sec will run at 6.25": one pulse each 160 ms."""
    command(bench, if1, "X@1G$", seconds=16.05)
    assert since_start(if1.axes["X"])[:99] == [n * 160_000_000 for n in range(1, 100)]


def test_after_an_interpolated_run_the_index_lengths_are_zero(bench, if1):
    """Run mode: "the data used in a previous index will be lost if the run mode is used"."""
    command(bench, if1, "X2000/Y500@400G$", seconds=1.0)
    command(bench, if1, "#", seconds=0.1)
    x, y = if1.axes["X"].position, if1.axes["Y"].position
    assert (x > 0, 0 <= x - 4 * y < 4) == (True, True)  # the ratio of the lengths is the ratio of the speeds
    for text in ("X$", "X/Y$"):
        command(bench, if1, text, seconds=1.0)
    assert (if1.axes["X"].position, if1.axes["Y"].position) == (x, y)
    assert ask(bench, if1, "F") == b"0\r"
    write(if1, "X/YG$")  # there is no ratio left
    bench.run(0.2)
    assert ask(bench, if1, "F") == b"16\r"


def test_a_run_that_is_refused_leaves_the_index_length(bench, if1):
    """Run mode: the data are lost "if the run mode is used"; a run that is refused does not count."""
    command(bench, if1, "X50$", seconds=0.3)
    if1.pins["limit_plus"].drive(False)
    bench.run(0.1)
    ask(bench, if1, "K")
    command(bench, if1, "XG$", seconds=0.1)
    ask(bench, if1, "K")
    command(bench, if1, "X-$", seconds=0.3)
    assert if1.axes["X"].position == 0
