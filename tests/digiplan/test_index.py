"""Sending basic move instructions: Index mode instructions, and cancelling an index."""

import itertools
from fractions import Fraction

import pytest

from axistwin.units import MS, S

from .talking import (
    ask,
    command,
    constant,
    faults,
    moves,
    moving,
    play,
    pulse_times_of,
    ramped,
    ready,
    scripts,
    send,
    since_start,
    start_ns,
    write,
)


def test_the_x_motor_runs_4000_steps_at_the_programmed_speed(bench, if1):
    """Index mode: ""X4000 $ <CR>" will run the X motor 4000 steps at the programmed speed"."""
    command(bench, if1, "X4000 $", seconds=11)
    assert since_start(if1.axes["X"]) == [n * 2_500_000 for n in range(1, 4001)]  # 400 per second
    assert (if1.axes["Y"].position, if1.axes["Z"].position) == (0, 0)


def test_the_y_motor_runs_2500_steps_at_1500(bench, if1):
    """Index mode: ""Y2500 @ 1500 $ <CR>" will run the Y motor 2500 steps at 1500 steps/sec"."""
    command(bench, if1, "Y2500 @ 1500 $", seconds=3)
    times = since_start(if1.axes["Y"])
    # 400 ... 1400: eleven levels of 10 ms, 99 pulses each way; 2302 pulses at 1500/s
    assert times == pulse_times_of(ramped(2500, 400, 1500, 100, 10_000))
    assert times[98] == 110 * MS
    assert times[-1] == int((Fraction(22, 100) + Fraction(2302, 1500)) * S)


def test_minus_changes_the_direction(bench, if1):
    """Index mode: "X-3000 $" "will run the X motor 3000 steps in the negative direction"."""
    command(bench, if1, "X-3000 $", seconds=8)
    assert moves(if1.axes["X"]) == [-3000]
    assert since_start(if1.axes["X"]) == constant(400, 3000)


@scripts(
    {
        'Index mode: "the positive direction is assumed if no direction command is sent": the sign is not remembered':
        "X-30$; X$; X+30$; X-$; X+$; 2 s; X moves -30 30 30 -30 30",
        'Index mode: "together with the initialise command "$""': "X40; 1 s; X at 0; still",
        'Index mode: "The maximum programmable distance is 9 decades, i.e. 999,999,999 steps"':
        "X999999999@25000^500$; 40010 s; X at 999999999; N: 999999999; X-$; 40010 s; X at 0",
        "Cancel: at rest it does nothing and raises no fault": "#; ###; 0.1 s; K: 0; F: 0; X5$; 0.1 s; X at 5",
        "R9: `#` acts at once, and drops the held message":
        "XG$; Y100$; 1 s; X moving; Y at 0; #; 1 s; still; Y at 0; E: C; Z5$; 1 s; Z at 5",
    }
)  # fmt: skip
def test_index_and_cancel(bench, if1, script):
    play(bench, if1, script)


def test_more_than_one_axis_may_be_selected(bench, if1):
    """Index mode: "X+ Y- $" "will run X positively and Y negatively the previously-programmed distance"."""
    command(bench, if1, "Z50$", seconds=1)
    command(bench, if1, "X+ Y- $", seconds=1)
    assert moves(if1.axes["X"]) == [50] and moves(if1.axes["Y"]) == [-50]
    assert start_ns(if1.axes["X"]) == start_ns(if1.axes["Y"])
    assert since_start(if1.axes["X"]) == since_start(if1.axes["Y"]) == constant(400, 50)


@pytest.mark.parametrize("message", ["XYZ70$", "X70YZ$", "XY70Z$", "XYZ@400 70$", "X70Y70Z70$", "ZYX70$"])
def test_three_axes_at_once(bench, if1, message):
    """Introduction: "up to three stepper motors", which all use the one distance."""
    command(bench, if1, message, seconds=1)
    moved = [axis.position for axis in if1.axes.values()]
    if message == "XYZ@400 70$":  # spaces are ignored, so the speed reads 40070, out of range
        assert (moved, faults(bench, if1)) == ([0, 0, 0], (b"128\r", b"16\r"))
    else:
        assert moved == [70, 70, 70]


def test_of_two_distances_the_last_one_counts(bench, if1):
    """R13: one distance register: `X1000Y2000$` runs both 2000."""
    command(bench, if1, "X100Y200$", seconds=1)
    assert (if1.axes["X"].position, if1.axes["Y"].position) == (200, 200)


def test_speed_may_stand_before_or_after_the_distance(bench, if1):
    """Index and run mode examples: the speed may follow the distance (`Y2500 @ 1500 $`) or precede it."""
    command(bench, if1, "X@200$", "@250X40$", "X$", seconds=2)
    assert moves(if1.axes["X"]) == [40, 40]
    assert since_start(if1.axes["X"]) == constant(250, 40)


def test_nothing_happens_before_the_terminator(bench, if1):
    """Command list, CR: "Initialise direct commands": before CR nothing moves."""
    command(bench, if1, "X40$", seconds=5, end="")
    assert if1.axes["X"].position == 0
    command(bench, if1, "", seconds=1)
    assert if1.axes["X"].position == 40


def test_index_length_0_is_no_pulse(bench, if1):
    """Default values: "Index Length 0 steps": such an index has no pulse and ends at once."""
    command(bench, if1, "X$", "XYZ0$", seconds=0.1)
    assert (ask(bench, if1, "E"), ask(bench, if1, "N")) == (b"C\r", b"0\r")
    assert [len(axis.pulse_times()) for axis in if1.axes.values()] == [0, 0, 0]


@pytest.mark.parametrize("digits", ["1000000000", "12345678901234567890"])
def test_ten_digits_are_refused(bench, if1, digits):
    """Index mode: a distance has at most 9 decades."""
    command(bench, if1, f"X{digits}$", seconds=1)
    assert if1.axes["X"].position == 0
    answer = faults(bench, if1)
    assert answer[0] == b"128\r" and answer[1] in (b"8\r", b"16\r")


def test_the_distance_at_speed_is_the_index_less_both_ramps(bench, if1):
    """Index mode: "the index length less the total acceleration and deceleration distance"."""
    command(bench, if1, "X300@1000$", seconds=1)
    times = since_start(if1.axes["X"])
    at_speed = [after for before, after in itertools.pairwise(times) if after - before == 1 * MS]
    assert len(at_speed) == 300 - 39 - 39
    assert times[-1] == 60 * MS + 222 * MS + 60 * MS


@pytest.mark.parametrize(
    ("distance", "levels_used", "left_over", "plateau"),
    [
        # 4, 5, 6, 7, 8, 9 pulses at 400 ... 900, each twice
        (1, 0, 1, 400),
        (7, 0, 7, 400),
        (8, 1, 0, 500),
        (9, 1, 1, 500),
        (17, 1, 9, 500),
        (18, 2, 0, 600),
        (50, 4, 6, 800),  # 8 + 10 + 12 + 14 = 44, and 6 at 800
        (77, 5, 17, 900),
        (78, 6, 0, 1000),
        (79, 6, 1, 1000),
    ],
)
def test_a_short_index_has_a_small_plateau_at_the_top(bench, if1, distance, levels_used, left_over, plateau):
    """Index mode: "a symmetrical acceleration and deceleration with a small plateau at the top".

    R11: as many levels as fit; the steps left over run at the next level.
    """
    command(bench, if1, f"X{distance}@1000$", seconds=1)
    up = [(400 + 100 * k, Fraction(1, 100)) for k in range(levels_used)]
    assert since_start(if1.axes["X"]) == pulse_times_of([*up, (plateau, Fraction(left_over, plateau)), *reversed(up)])


def test_moves_sent_one_after_the_other_are_made_one_after_the_other(bench, if1):
    """R9: a message is held until the current work is done (appendix 3, sample 10)."""
    command(bench, if1, "X40$", "Y20$", seconds=1)
    assert (if1.axes["X"].position, if1.axes["Y"].position) == (40, 20)
    x, y = if1.axes["X"], if1.axes["Y"]
    assert int(x.pulse_times()[-1]) <= start_ns(y) <= int(x.pulse_times()[-1]) + 5 * MS


@pytest.mark.parametrize(
    ("letter", "reply"), [("K", b"3\r"), ("I", b"200\r"), ("O", b"0\r"), ("E", b"E\r"), ("F", b"0\r"), ("Q", b"\3")]
)
def test_a_status_request_is_answered_while_a_second_move_is_held(bench, if1, letter, reply):
    """Report-back: "The interface can be interrogated to establish its status at any time"."""
    command(bench, if1, "X40$", "Y20$", seconds=0.02)
    assert ask(bench, if1, letter, 0.03) == reply
    assert if1.axes["X"].moving and not if1.axes["Y"].moving
    bench.run(0.2)
    assert (if1.axes["X"].position, if1.axes["Y"].position) == (40, 20)


def test_it_is_busy_from_the_first_move_to_the_end_of_the_held_one(bench, if1):
    """Busy status: sample 10 sends a move during another one and takes "C" for the end of both."""
    seen = []
    if1.serial.subscribe_received(lambda byte, _: seen.append((chr(byte), bench.now)))
    write(if1, "X40$", "Y20$")
    while ("C" not in [letter for letter, _ in seen]) and bench.seconds < 10:
        write(if1, "E")
        bench.run(0.004)
    assert (if1.axes["X"].position, if1.axes["Y"].position) == (40, 20)
    assert [letter for letter, _ in seen if letter != "\r"].count("C") == 1


@pytest.mark.parametrize("message", ["@100", "[", "Z5$", "D2"])
def test_what_changes_something_waits_behind_a_held_move(bench, if1, message):
    """R9: messages that change something are executed in their order."""
    write(if1, "X40$", "Y20$", message, "E")
    bench.run(0.09)
    assert if1.serial.read() == b"E\r" and if1.axes["X"].moving
    bench.run(0.1)
    assert if1.axes["Y"].position == 20 or if1.axes["Y"].moving
    assert since_start(if1.axes["Y"]) == constant(400, 20)[: len(since_start(if1.axes["Y"]))]
    assert ask(bench, if1, "E") == (b"[\r" if message == "[" else b"C\r")


def test_a_second_move_is_ignored_where_that_is_asked_for(bench):
    """R9, option `busy`: a move sent during a motion is ignored."""
    if1 = ready(bench, busy="ignore")
    assert send(bench, if1, "X40$", "Y20$", "E", seconds=0.05) == b"E\r"
    bench.run(1)
    assert (if1.axes["X"].position, if1.axes["Y"].position) == (40, 0)
    assert ask(bench, if1, "F") == b"0\r"


def test_status_does_not_disturb_the_pulses(bench, if1):
    """Report-back: "The interface can be interrogated to establish its status at any time": no pulse is delayed."""
    write(if1, "X1000@2000$")
    for message in "KNFIEQO" * 3:
        write(if1, message)
    bench.run(3)
    assert since_start(if1.axes["X"]) == pulse_times_of(ramped(1000, 400, 2000, 100, 10_000))


# Cancel


def test_cancel_stops_any_axis_in_motion(bench, if1):
    """Index mode: "send the cancel code "# <CR>". This will stop any axis in motion"."""
    command(bench, if1, "X+Y-Z4000$", seconds=1)
    command(bench, if1, "#", seconds=0.01)
    assert not moving(if1)
    x, y, z = (axis.position for axis in if1.axes.values())
    assert 0 < x < 4000 and x == -y == z
    assert ask(bench, if1, "N") == b"%d\r" % x
    bench.run(20)
    assert if1.axes["X"].position == x  # the rest of the index is lost


def test_cancel_at_speed_decelerates_along_the_ramp(bench, if1):
    """Cancel: from 1000 the levels 900, 800 ... 400 take 10 ms each: 39 pulses in 60 ms."""
    command(bench, if1, "X4000@1000$", seconds=1)
    axis = if1.axes["X"]
    write(if1, "#")
    assert bench.run_until(lambda: axis.velocity < 1000, 0.1)
    begin, before = bench.now, axis.position
    assert (axis.velocity, ask(bench, if1, "K", 0.02)) == (900, b"9\r")
    bench.run(1)
    assert axis.position == before + 39
    assert begin + 59 * MS <= int(axis.pulse_times()[-1]) <= begin + 60 * MS
    assert (ask(bench, if1, "E"), ask(bench, if1, "K")) == (b"C\r", b"0\r")
    assert ask(bench, if1, "N") == b"%d\r" % axis.position


@pytest.mark.parametrize("speed", [400, 200, 7])
def test_cancel_at_or_below_the_start_stop_speed_stops_at_once(bench, if1, speed):
    """Cancel: at these speeds there is no ramp."""
    command(bench, if1, f"X4000@{speed}$", seconds=1)
    begin = bench.now
    write(if1, "#")
    bench.run_until(lambda: not moving(if1), 0.1)
    stopped = if1.axes["X"].position
    assert bench.now <= begin + 5 * MS  # the time of two characters and a strobe
    bench.run(5)
    assert if1.axes["X"].position == stopped


def test_cancel_while_accelerating_goes_down_from_there(bench, if1):
    """Cancel: during the level of 700, the levels 600, 500 and 400 remain: 15 pulses."""
    write(if1, "X4000@1000$")
    axis = if1.axes["X"]
    bench.run_until(lambda: axis.moving, 0.1)
    command(bench, if1, "#", seconds=0.0335 - 0.0012 - 0.0005 - 0.00115, end="")  # its CR is read between 30 and 40 ms
    write(if1, "")
    assert bench.run_until(lambda: axis.train.move.profile.end_ns < 100 * MS, 0.1)
    begin, before = bench.now, axis.position
    assert 30 * MS < begin - start_ns(axis) < 40 * MS
    bench.run(1)
    assert axis.position == before + 15
    assert begin + 29 * MS <= int(axis.pulse_times()[-1]) <= begin + 30 * MS


def test_cancel_while_decelerating_changes_nothing(bench, if1):
    """Cancel: it does not change a deceleration in progress."""
    command(bench, if1, "X300@1000$", seconds=0.3)  # the index takes 342 ms in all
    command(bench, if1, "#", seconds=1)
    assert if1.axes["X"].position <= 300
    assert ask(bench, if1, "N") == b"%d\r" % if1.axes["X"].position


def test_cancelled_index_can_be_asked_for_again(bench, if1):
    """Cancel: the index is cancelled, but the programmed distance is kept."""
    command(bench, if1, "X400$", seconds=0.5)
    command(bench, if1, "#", seconds=0.1)
    rest = if1.axes["X"].position
    command(bench, if1, "X$", seconds=2)
    assert if1.axes["X"].position == rest + 400


@pytest.mark.parametrize("typed", ["X100$", "X10", "@@@", "?*~", ":X100:", "S1R2"])
def test_what_was_typed_before_the_cancel_character_is_thrown_away(bench, if1, typed):
    """Control of data transfer: "# <CR>" is sent before a spoilt message is sent again."""
    command(bench, if1, typed + "#", seconds=0.1)
    command(bench, if1, "Y5$", seconds=0.5)
    assert (if1.axes["X"].position, if1.axes["Y"].position) == (0, 5)
    assert faults(bench, if1) == (b"0\r", b"0\r")


def test_cancel_needs_its_terminator(bench, if1):
    """Index mode: the cancel code is "# <CR>", so `#` alone has no effect."""
    command(bench, if1, "X400$")
    command(bench, if1, "#", end="")
    assert moving(if1)
    command(bench, if1, "", seconds=0.01)
    assert not moving(if1)


def test_cancel_in_v_format_needs_line_feed(bench):
    """Initialisation: in the V format <CR> means <CR><LF>, also for cancel."""
    if1 = ready(bench, "V61")
    command(bench, if1, "X400$", end="\n")
    command(bench, if1, "#", end="\r")
    assert moving(if1)
    command(bench, if1, "", seconds=0.01, end="\n")
    assert not moving(if1)


def test_cancel_in_full_speed_ranges(bench, if1):
    """Cancel: from 100,000 steps/s the speed falls by 400 every 400/500,000 s."""
    command(bench, if1, ">3^500@99999XG$", seconds=3)
    axis = if1.axes["X"]
    assert axis.velocity == 100_000
    write(if1, "#")
    assert bench.run_until(lambda: axis.velocity < 100_000, 0.1)
    before = axis.position
    bench.run(1)
    # 249 levels of 0.8 ms: 400 x 0.0008 x (1 + 2 + ... + 249) = 0.32 x 31,125 = 9,960 pulses
    assert abs(axis.position - before - 9_960) <= 1
