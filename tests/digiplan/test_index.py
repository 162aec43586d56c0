"""Sending basic move instructions: Index mode instructions, and cancelling an index."""

import itertools
from fractions import Fraction

import pytest

from axistwin.core.units import MS

from ..scripts import scripts
from .talking import ask, command, play, pulse_times_of, ready, since_start, start_ns, write


@scripts({
    'Index mode: ""X4000 $ <CR>" will run the X motor 4000 steps at the programmed speed"':
    "X4000 $; 11 s; X 4000 pulses at 400; at 4000 0 0",
    'Index mode: ""Y2500 @ 1500 $ <CR>" will run the Y motor 2500 steps at 1500 steps/sec"':
    "Y2500 @ 1500 $; 3 s; at 0 2500 0; Y 2500 pulses from 400 to 1500 by 100 at 10000",
    'Index mode: "X-3000 $" "will run the X motor 3000 steps in the negative direction"':
    "X-3000 $; 8 s; X moves -3000; X 3000 pulses at 400",
    'Index mode: "the positive direction is assumed if no direction command is sent": the sign is not remembered':
    "X-30$; X$; X+30$; X-$; X+$; 2 s; X moves -30 30 30 -30 30",
    'Index mode: "X+ Y- $" "will run X positively and Y negatively the previously-programmed distance"':
    "Z50$; 1 s; X+ Y- $; 1 s; X moves 50; Y moves -50; X like Y; X 50 pulses at 400",
    'Index mode: "together with the initialise command "$""': "X40; 1 s; X at 0; still",
    'Index mode: "The maximum programmable distance is 9 decades, i.e. 999,999,999 steps"':
    "X999999999@25000^500$; 40010 s; X at 999999999; N: 999999999; X-$; 40010 s; X at 0",
    "R13: one distance register: of two distances the last one counts": "X100Y200$; 1 s; at 200 200 0",
    "Index and run mode examples: the speed may follow the distance (`Y2500 @ 1500 $`) or precede it":
    "X@200$; @250X40$; X$; 2 s; X moves 40 40; X 40 pulses at 250",
    'Command list, CR: "Initialise direct commands": before CR nothing moves':
    "sends X40$; 5 s; X at 0; sends <CR>; 1 s; X at 40",
    'Default values: "Index Length 0 steps": such an index has no pulse and ends at once':
    "X$; XYZ0$; 0.1 s; E: C; N: 0; X moves; Y moves; Z moves",
    'Index mode: "send the cancel code "# <CR>". This will stop any axis in motion"; the rest of the index is lost':
    "X+Y-Z4000$; 1 s; #; 0.01 s; still; X between 1 3999; X like Y; X like Z; N: X; N: Y; N: Z; mark; 20 s; "
    "moved 0 0 0",
    'Index mode: the cancel code is "# <CR>", so `#` alone has no effect':
    "X400$; 0.2 s; sends #; 0.2 s; moving; sends <CR>; 0.01 s; still",
    "Cancel: it does not change a deceleration in progress; the index takes 342 ms in all":
    "X300@1000$; 0.3 s; #; 1 s; X between 261 300; N: X",
    "Cancel: the index is cancelled, but the programmed distance is kept":
    "X400$; 0.5 s; #; 0.1 s; X between 1 399; mark; X$; 2 s; moved 400 0 0",
    "Cancel: at rest it does nothing and raises no fault": "#; ###; 0.1 s; K: 0; F: 0; X5$; 0.1 s; X at 5",
    "R9: `#` acts at once, and drops the held message":
    "XG$; Y100$; 1 s; X moving; Y at 0; #; 1 s; still; Y at 0; E: C; Z5$; 1 s; Z at 5",
    "R9: a message is held until the current work is done (appendix 3, sample 10)":
    "X40$; Y20$; 1 s; at 40 20 0; Y begins 0 to 5 ms after X",
    'Introduction: "up to three stepper motors", which all use the one distance':
    "{XYZ70|X70YZ|XY70Z|X70Y70Z70|ZYX70}$; 1 s; at 70 70 70; F: 0",
    "R9: messages that change something are executed in their order":
    "X40$; Y20$; {@100|[|Z5$|D2}; E; 0.09 s; receives E<CR>; X moving; until Y at 20; Y 20 pulses at 400; 0.2 s; "
    "E: {C|[|C|C}",
    "Cancel: at these speeds there is no ramp; # and CR take 2.2 ms, and a strobe 1 ms":
    "X4000@{400|200|7}$; 1 s; #; 0.005 s; still; mark; 5 s; moved 0 0 0",
    'Control of data transfer: "# <CR>" is sent before a spoilt message is sent again':
    "{X100$|X10|@@@|?*~|:X100:|S1R2}#; 0.1 s; Y5$; 0.5 s; at 0 5 0; K: 0; F: 0",
})  # fmt: skip
def test_index_and_cancel(bench, if1, script):
    play(bench, if1, script)


@pytest.mark.parametrize("message", ["X1000000000$", "X12345678901234567890$", "XYZ@400 70$"])
def test_ten_digits_are_refused(bench, if1, message):
    """Index mode: a distance has at most 9 decades; spaces are ignored, so the speed `@400 70` is 40070."""
    play(bench, if1, f"{message}; 1 s; at 0 0 0; K: 128; F: {'16' if '@' in message else '8|16'}")


def test_the_distance_at_speed_is_the_index_less_both_ramps(bench, if1):
    """Index mode: "the index length less the total acceleration and deceleration distance"."""
    command(bench, if1, "X300@1000$", seconds=1)
    times = since_start(if1.axes["X"])
    at_speed = [after for before, after in itertools.pairwise(times) if after - before == 1 * MS]
    assert len(at_speed) == 300 - 39 - 39 and times[-1] == 60 * MS + 222 * MS + 60 * MS


@pytest.mark.parametrize(
    ("distance", "levels_used", "left_over", "plateau"),
    [
        # 4, 5, 6, 7, 8, 9 pulses at 400 ... 900, each twice
        (1, 0, 1, 400), (7, 0, 7, 400), (8, 1, 0, 500), (9, 1, 1, 500), (17, 1, 9, 500), (18, 2, 0, 600),
        (50, 4, 6, 800),  # 8 + 10 + 12 + 14 = 44, and 6 at 800
        (77, 5, 17, 900), (78, 6, 0, 1000), (79, 6, 1, 1000),
    ],
)  # fmt: skip
def test_a_short_index_has_a_small_plateau_at_the_top(bench, if1, distance, levels_used, left_over, plateau):
    """Index mode: "a profile giving a symmetrical acceleration and deceleration with a small plateau at the top".

    R11: as many levels as fit; the steps left over run at the next level.
    """
    command(bench, if1, f"X{distance}@1000$", seconds=1)
    up = [(400 + 100 * k, Fraction(1, 100)) for k in range(levels_used)]
    assert since_start(if1.axes["X"]) == pulse_times_of([*up, (plateau, Fraction(left_over, plateau)), *reversed(up)])


@pytest.mark.parametrize(("letter", "reply"), [
    ("K", b"3\r"), ("I", b"200\r"), ("O", b"0\r"), ("E", b"E\r"), ("F", b"0\r"), ("Q", b"\3")])  # fmt: skip
def test_a_status_request_is_answered_while_a_second_move_is_held(bench, if1, letter, reply):
    """Report-back: "The interface can be interrogated to establish its status at any time"."""
    command(bench, if1, "X40$", "Y20$", seconds=0.02)
    assert ask(bench, if1, letter, 0.03) == reply
    play(bench, if1, "X moving; Y at rest; 0.2 s; at 40 20 0")


def test_it_is_busy_from_the_first_move_to_the_end_of_the_held_one(bench, if1):
    """Busy status: sample 10 sends a move during another one and takes "C" for the end of both."""
    write(if1, "X40$", "Y20$")
    answers = b""
    while b"C" not in answers and bench.seconds < 10:
        answers += ask(bench, if1, "E", seconds=0.004)
    play(bench, if1, "at 40 20 0")


def test_a_second_move_is_ignored_where_that_is_asked_for(bench):
    """R9, option `busy`: a move sent during a motion is ignored."""
    play(bench, ready(bench, busy="ignore"), "X40$; Y20$; E: E; 1 s; at 40 0 0; F: 0")


def test_status_does_not_disturb_the_pulses(bench, if1):
    """Report-back: "The interface can be interrogated to establish its status at any time": no pulse is delayed."""
    write(if1, "X1000@2000$", *"KNFIEQO" * 3)
    bench.run(3)
    if1.serial.read()
    play(bench, if1, "X 1000 pulses from 400 to 2000 by 100 at 10000")


# Cancel


@pytest.mark.parametrize(
    ("move", "top", "below", "pulses", "from_ms", "to_ms"),
    [
        ("X4000@1000$", 1000, 900, 39, 59, 60),  # 900, 800 ... 400 take 10 ms each
        ("X@5000G$", 5000, 4900, 1219, 457, 460),  # 4900, 4800 ... 400: 46 levels
        # 249 levels of 0.8 ms: 400 x 0.0008 x (1 + 2 + ... + 249) = 0.32 x 31,125 = 9,960 pulses
        (">3^500@99999XG$", 100_000, 99_600, 9_960, 196, 249 * 0.8),
    ],
)
def test_cancel_at_speed_decelerates_along_the_ramp(bench, if1, move, top, below, pulses, from_ms, to_ms):
    """Cancel, Run mode: "To stop the motor, send the cancel code "# <CR>"": level by level down to start/stop."""
    axis = if1.axes["X"]
    command(bench, if1, move, seconds=1)
    assert bench.run_until(lambda: axis.velocity == top, 3)
    bench.run(0.1)
    write(if1, "#")
    assert bench.run_until(lambda: axis.velocity < top, 0.1)
    begin, before = bench.now, axis.position
    assert (axis.velocity, ask(bench, if1, "K", 0.02)) == (below, b"9\r")
    bench.run(1)
    assert abs(axis.position - before - pulses) <= (top == 100_000)
    assert from_ms <= (int(axis.pulse_times()[-1]) - begin) / MS <= to_ms
    play(bench, if1, "E: C; K: 0; N: X")


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
    assert axis.position == before + 15 and begin + 29 * MS <= int(axis.pulse_times()[-1]) <= begin + 30 * MS


def test_cancel_in_v_format_needs_line_feed(bench):
    """Initialisation: in the V format <CR> means <CR><LF>, also for cancel."""
    script = "sends X400$<LF>; 0.2 s; sends #<CR>; 0.2 s; moving; sends <LF>; 0.01 s; still"
    play(bench, ready(bench, "V61"), script)
