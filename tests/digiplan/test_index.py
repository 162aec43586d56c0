"""Sending basic move instructions: Index mode instructions, and cancelling an index."""

import itertools
from fractions import Fraction

import pytest

from axistwin.units import MS, S

from .helpers import strokes
from .talking import ask, constant, faults, moving, pulse_times_of, ramped, ready, since_start, start_ns, tell


def test_the_x_motor_runs_4000_steps_at_the_programmed_speed(bench, if1):
    """Index mode: ""X4000 $ <CR>" will run the X motor 4000 steps at the programmed speed"."""
    tell(if1, "X4000 $")
    bench.run(11)
    assert since_start(if1.axes["X"]) == [n * 2_500_000 for n in range(1, 4001)]  # 400 per second
    assert (if1.axes["Y"].position, if1.axes["Z"].position) == (0, 0)


def test_the_y_motor_runs_2500_steps_at_1500(bench, if1):
    """Index mode: ""Y2500 @ 1500 $ <CR>" will run the Y motor 2500 steps at 1500 steps/sec"."""
    tell(if1, "Y2500 @ 1500 $")
    bench.run(3)
    times = since_start(if1.axes["Y"])
    # 400 ... 1400: eleven levels of 10 ms, 99 pulses each way; 2302 pulses at 1500/s
    assert times == pulse_times_of(ramped(2500, 400, 1500, 100, 10_000))
    assert times[98] == 110 * MS
    assert times[-1] == int((Fraction(22, 100) + Fraction(2302, 1500)) * S)


def test_minus_changes_the_direction(bench, if1):
    """Index mode: "X-3000 $" "will run the X motor 3000 steps in the negative direction"."""
    tell(if1, "X-3000 $")
    bench.run(8)
    assert strokes(if1.axes["X"]) == [-3000]
    assert since_start(if1.axes["X"]) == constant(400, 3000)


def test_plus_may_be_sent_and_is_assumed_if_nothing_is(bench, if1):
    """Index mode: "the positive direction is assumed if no direction command is sent": the sign is not remembered."""
    tell(if1, "X-30$")
    tell(if1, "X$")
    tell(if1, "X+30$")
    tell(if1, "X-$")
    tell(if1, "X+$")
    bench.run(2)
    assert strokes(if1.axes["X"]) == [-30, 30, 30, -30, 30]


def test_more_than_one_axis_may_be_selected(bench, if1):
    """Index mode: "X+ Y- $" "will run X positively and Y negatively the previously-programmed distance"."""
    tell(if1, "Z50$")
    bench.run(1)
    tell(if1, "X+ Y- $")
    bench.run(1)
    assert strokes(if1.axes["X"]) == [50] and strokes(if1.axes["Y"]) == [-50]
    assert start_ns(if1.axes["X"]) == start_ns(if1.axes["Y"])
    assert since_start(if1.axes["X"]) == since_start(if1.axes["Y"]) == constant(400, 50)


@pytest.mark.parametrize("message", ["XYZ70$", "X70YZ$", "XY70Z$", "XYZ@400 70$", "X70Y70Z70$", "ZYX70$"])
def test_three_axes_at_once(bench, if1, message):
    """Introduction: "up to three stepper motors"; one distance for all."""
    tell(if1, message)
    bench.run(1)
    moved = [axis.position for axis in if1.axes.values()]
    if message == "XYZ@400 70$":  # spaces are ignored, so this is a speed of 40070: out of range
        assert moved == [0, 0, 0]
        assert faults(bench, if1) == (b"128\r", b"16\r")
    else:
        assert moved == [70, 70, 70]


def test_of_two_distances_the_last_one_counts(bench, if1):
    """R13: one distance register: `X1000Y2000$` runs both 2000."""
    tell(if1, "X100Y200$")
    bench.run(1)
    assert (if1.axes["X"].position, if1.axes["Y"].position) == (200, 200)


def test_speed_may_stand_before_or_after_the_distance(bench, if1):
    """Index and run mode examples: `Y2500 @ 1500 $`, `X @ 5000 G $`."""
    tell(if1, "X@200$")
    tell(if1, "@250X40$")
    tell(if1, "X$")
    bench.run(2)
    assert strokes(if1.axes["X"]) == [40, 40]
    assert since_start(if1.axes["X"]) == constant(250, 40)


def test_nothing_happens_before_the_terminator(bench, if1):
    """Command list: CR: "Initialise direct commands"."""
    tell(if1, "X40$", "")
    bench.run(5)
    assert if1.axes["X"].position == 0
    tell(if1, "")
    bench.run(1)
    assert if1.axes["X"].position == 40


def test_without_the_initialise_command_nothing_moves(bench, if1):
    """Index mode: "together with the initialise command "$""."""
    tell(if1, "X40")
    bench.run(1)
    assert if1.axes["X"].position == 0 and not moving(if1)


def test_index_length_0_is_no_pulse(bench, if1):
    """Default values: "Index Length 0 steps": done at once."""
    tell(if1, "X$")
    tell(if1, "XYZ0$")
    bench.run(0.1)
    assert ask(bench, if1, "E") == b"C\r"
    assert ask(bench, if1, "N") == b"0\r"
    assert [len(axis.pulse_times()) for axis in if1.axes.values()] == [0, 0, 0]


def test_the_longest_index_is_999999999_steps(bench, if1):
    """Index mode: "The maximum programmable distance is 9 decades, i.e. 999,999,999 steps"."""
    tell(if1, "X999999999@25000^500$")
    bench.run(40_010)
    assert if1.axes["X"].position == 999_999_999
    assert ask(bench, if1, "N") == b"999999999\r"
    tell(if1, "X-$")
    bench.run(40_010)
    assert if1.axes["X"].position == 0


@pytest.mark.parametrize("digits", ["1000000000", "12345678901234567890"])
def test_ten_digits_are_refused(bench, if1, digits):
    """Index mode: 9 decades."""
    tell(if1, f"X{digits}$")
    bench.run(1)
    assert if1.axes["X"].position == 0
    answer = faults(bench, if1)
    assert answer[0] == b"128\r" and answer[1] in (b"8\r", b"16\r")


def test_the_distance_at_speed_is_the_index_less_both_ramps(bench, if1):
    """Index mode: "the index length less the total acceleration and deceleration distance"."""
    tell(if1, "X300@1000$")
    bench.run(1)
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
    tell(if1, f"X{distance}@1000$")
    bench.run(1)
    up = [(400 + 100 * k, Fraction(1, 100)) for k in range(levels_used)]
    assert since_start(if1.axes["X"]) == pulse_times_of([*up, (plateau, Fraction(left_over, plateau)), *reversed(up)])


def test_moves_sent_one_after_the_other_are_made_one_after_the_other(bench, if1):
    """R9: a message is held until the current work is done (appendix 3, sample 10)."""
    tell(if1, "X40$")
    tell(if1, "Y20$")
    bench.run(1)
    assert (if1.axes["X"].position, if1.axes["Y"].position) == (40, 20)
    x, y = if1.axes["X"], if1.axes["Y"]
    assert int(x.pulse_times()[-1]) <= start_ns(y) <= int(x.pulse_times()[-1]) + 5 * MS


@pytest.mark.parametrize(
    ("letter", "reply"), [("K", b"3\r"), ("I", b"200\r"), ("O", b"0\r"), ("E", b"E\r"), ("F", b"0\r"), ("Q", b"\3")]
)
def test_a_status_request_is_answered_while_a_second_move_is_held(bench, if1, letter, reply):
    """Report-back: "The interface can be interrogated to establish its status at any time"."""
    tell(if1, "X40$")
    tell(if1, "Y20$")
    bench.run(0.02)
    assert ask(bench, if1, letter, 0.03) == reply
    assert if1.axes["X"].moving and not if1.axes["Y"].moving
    bench.run(0.2)
    assert (if1.axes["X"].position, if1.axes["Y"].position) == (40, 20)


def test_it_is_busy_from_the_first_move_to_the_end_of_the_held_one(bench, if1):
    """Busy status; sample 10 sends a move during another and takes "C" for the end of both."""
    seen = []
    if1.serial.subscribe_received(lambda byte, _: seen.append((chr(byte), bench.now)))
    tell(if1, "X40$")
    tell(if1, "Y20$")
    while ("C" not in [letter for letter, _ in seen]) and bench.seconds < 10:
        tell(if1, "E")
        bench.run(0.004)
    assert (if1.axes["X"].position, if1.axes["Y"].position) == (40, 20)
    assert [letter for letter, _ in seen if letter != "\r"].count("C") == 1


@pytest.mark.parametrize("message", ["@100", "[", "Z5$", "D2"])
def test_what_changes_something_waits_behind_a_held_move(bench, if1, message):
    """R9: messages act in their order."""
    tell(if1, "X40$")
    tell(if1, "Y20$")
    tell(if1, message)
    tell(if1, "E")
    bench.run(0.09)
    assert if1.serial.read() == b"E\r" and if1.axes["X"].moving
    bench.run(0.1)
    assert if1.axes["Y"].position == 20 or if1.axes["Y"].moving
    assert since_start(if1.axes["Y"]) == constant(400, 20)[: len(since_start(if1.axes["Y"]))]
    assert ask(bench, if1, "E") == (b"[\r" if message == "[" else b"C\r")


def test_a_second_move_is_ignored_where_that_is_asked_for(bench):
    """R9, the option: whoever does not check that motion is complete has his move ignored."""
    if1 = ready(bench, busy="ignore")
    tell(if1, "X40$")
    tell(if1, "Y20$")
    tell(if1, "E")
    bench.run(0.05)
    assert if1.serial.read() == b"E\r"
    bench.run(1)
    assert (if1.axes["X"].position, if1.axes["Y"].position) == (40, 0)
    assert ask(bench, if1, "F") == b"0\r"


def test_status_does_not_disturb_the_pulses(bench, if1):
    """Report-back: "The interface can be interrogated to establish its status at any time"."""
    tell(if1, "X1000@2000$")
    for message in "KNFIEQO" * 3:
        tell(if1, message)
    bench.run(3)
    assert since_start(if1.axes["X"]) == pulse_times_of(ramped(1000, 400, 2000, 100, 10_000))


# Cancel


def test_cancel_stops_any_axis_in_motion(bench, if1):
    """Index mode: "send the cancel code "# <CR>". This will stop any axis in motion"."""
    tell(if1, "X+Y-Z4000$")
    bench.run(1)
    tell(if1, "#")
    bench.run(0.01)
    assert not moving(if1)
    x, y, z = (axis.position for axis in if1.axes.values())
    assert 0 < x < 4000 and x == -y == z
    assert ask(bench, if1, "N") == b"%d\r" % x
    bench.run(20)
    assert if1.axes["X"].position == x  # the rest of the index is lost


def test_cancel_at_speed_decelerates_along_the_ramp(bench, if1):
    """Cancel: from 1000 by 900, 800 ... 400, each for 10 ms: 39 pulses in 60 ms."""
    tell(if1, "X4000@1000$")
    bench.run(1)
    axis = if1.axes["X"]
    tell(if1, "#")
    assert bench.run_until(lambda: axis.velocity < 1000, 0.1)
    begin, before = bench.now, axis.position
    assert axis.velocity == 900
    assert ask(bench, if1, "K", 0.02) == b"9\r"
    bench.run(1)
    assert axis.position == before + 39
    assert begin + 59 * MS <= int(axis.pulse_times()[-1]) <= begin + 60 * MS
    assert ask(bench, if1, "E") == b"C\r"
    assert ask(bench, if1, "K") == b"0\r"
    assert ask(bench, if1, "N") == b"%d\r" % axis.position


@pytest.mark.parametrize("speed", [400, 200, 7])
def test_cancel_at_or_below_the_start_stop_speed_stops_at_once(bench, if1, speed):
    """Cancel: there is no ramp to go down."""
    tell(if1, f"X4000@{speed}$")
    bench.run(1)
    begin = bench.now
    tell(if1, "#")
    bench.run_until(lambda: not moving(if1), 0.1)
    stopped = if1.axes["X"].position
    assert bench.now <= begin + 5 * MS  # two characters and a strobe
    bench.run(5)
    assert if1.axes["X"].position == stopped


def test_cancel_while_accelerating_goes_down_from_there(bench, if1):
    """Cancel: in the 700 level, 600, 500 and 400 are left: 15 pulses."""
    tell(if1, "X4000@1000$")
    axis = if1.axes["X"]
    bench.run_until(lambda: axis.moving, 0.1)
    tell(if1, "#", "")
    bench.run(0.0335 - 0.0012 - 0.0005 - 0.00115)  # its CR is taken between 30 and 40 ms
    tell(if1, "")
    assert bench.run_until(lambda: axis.train.move.profile.end_ns < 100 * MS, 0.1)
    begin, before = bench.now, axis.position
    assert 30 * MS < begin - start_ns(axis) < 40 * MS
    bench.run(1)
    assert axis.position == before + 15
    assert begin + 29 * MS <= int(axis.pulse_times()[-1]) <= begin + 30 * MS


def test_cancel_while_decelerating_changes_nothing(bench, if1):
    """Cancel: it is stopping already."""
    tell(if1, "X300@1000$")
    bench.run(0.3)  # 342 ms in all
    tell(if1, "#")
    bench.run(1)
    assert if1.axes["X"].position <= 300
    assert ask(bench, if1, "N") == b"%d\r" % if1.axes["X"].position


def test_cancelled_index_can_be_asked_for_again(bench, if1):
    """Cancel: the index is cancelled, the programmed distance is not."""
    tell(if1, "X400$")
    bench.run(0.5)
    tell(if1, "#")
    bench.run(0.1)
    rest = if1.axes["X"].position
    tell(if1, "X$")
    bench.run(2)
    assert if1.axes["X"].position == rest + 400


def test_cancel_when_nothing_moves_does_nothing(bench, if1):
    """Cancel: no fault."""
    tell(if1, "#")
    tell(if1, "###")
    bench.run(0.1)
    assert faults(bench, if1) == (b"0\r", b"0\r")
    tell(if1, "X5$")
    bench.run(0.1)
    assert if1.axes["X"].position == 5


@pytest.mark.parametrize("typed", ["X100$", "X10", "@@@", "?*~", ":X100:", "S1R2"])
def test_what_was_typed_before_the_cancel_character_is_thrown_away(bench, if1, typed):
    """Control of data transfer: "# <CR>" is sent before a spoilt message is sent again."""
    tell(if1, typed + "#")
    bench.run(0.1)
    tell(if1, "Y5$")
    bench.run(0.5)
    assert (if1.axes["X"].position, if1.axes["Y"].position) == (0, 5)
    assert faults(bench, if1) == (b"0\r", b"0\r")


def test_cancel_needs_its_terminator(bench, if1):
    """Index mode: "the cancel code "# <CR>""."""
    tell(if1, "X400$")
    bench.run(0.2)
    tell(if1, "#", "")
    bench.run(0.2)
    assert moving(if1)
    tell(if1, "")
    bench.run(0.01)
    assert not moving(if1)


def test_cancel_in_v_format_needs_line_feed(bench):
    """Initialisation: <CR> is to be read as <CR><LF>."""
    if1 = ready(bench, "V61")
    tell(if1, "X400$", "\n")
    bench.run(0.2)
    tell(if1, "#", "\r")
    bench.run(0.2)
    assert moving(if1)
    tell(if1, "", "\n")
    bench.run(0.01)
    assert not moving(if1)


def test_cancel_reaches_past_a_held_message(bench, if1):
    """R9: `#` acts at once; what was held is thrown away with it."""
    tell(if1, "XG$")
    tell(if1, "Y100$")
    bench.run(1)
    assert if1.axes["X"].moving and if1.axes["Y"].position == 0
    tell(if1, "#")
    bench.run(1)
    assert not moving(if1) and if1.axes["Y"].position == 0
    assert ask(bench, if1, "E") == b"C\r"
    tell(if1, "Z5$")
    bench.run(1)
    assert if1.axes["Z"].position == 5


def test_cancel_in_full_speed_ranges(bench, if1):
    """Cancel: from 100,000 down in steps of 400, each for 400/500,000 s."""
    tell(if1, ">3^500@99999XG$")
    bench.run(3)
    axis = if1.axes["X"]
    assert axis.velocity == 100_000
    tell(if1, "#")
    assert bench.run_until(lambda: axis.velocity < 100_000, 0.1)
    before = axis.position
    bench.run(1)
    # 249 levels of 0.8 ms: 400 x 0.0008 x (1 + 2 + ... + 249) = 0.32 x 31,125 = 9,960 pulses
    assert abs(axis.position - before - 9_960) <= 1
