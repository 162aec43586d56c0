"""Sending basic move instructions: Start/stop speed, Acceleration rate."""

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench
from axistwin.units import MS, S

from .talking import (
    arrivals,
    ask,
    at_speed,
    command,
    constant,
    faults,
    play,
    pulse_times_of,
    ramped,
    ready,
    scripts,
    since_start,
    start_ns,
    write,
)

INCREMENT = {1: 100, 2: 200, 3: 400, 4: 16}
MAXIMUM = {1: 25_000, 2: 50_000, 3: 99_999, 4: 4_000}
RESOLUTION = {1: Fraction(25, 4), 2: Fraction(25, 2), 3: Fraction(25), 4: Fraction(1)}


def first_rate(bench, if1) -> Fraction:
    """Return the rate at which a fast run starts, measured at its first pulse."""
    write(if1, "^1", "X@4000G$")
    bench.run_until(lambda: if1.axes["X"].moving, 5)
    bench.run(0.05)
    first = since_start(if1.axes["X"])[0]
    rate = round(S / first)
    assert first == S // rate
    return Fraction(rate)


@pytest.mark.parametrize(
    ("range_", "asked", "actual"),
    [
        (1, 3, 300),  # "300 s/s in range 1, 200 s/s in range 2, 400 s/s in range 3 and 288 s/s in range 4"
        (2, 3, 200),
        (3, 3, 400),
        (4, 3, 288),
        (1, 12, 1200),  # ""<12 <CR>" will set the start/stop rate at 1200 steps/sec in speed range 1"
        (1, 1, 100),
        (1, 38, 3800),
        (2, 1, 200),
        (2, 7, 600),
        (2, 9, 800),
        (3, 1, 400),
        (3, 7, 400),
        (3, 8, 800),
        (3, 39, 3600),
        (4, 1, 96),
        (4, 4, 400),
        (4, 38, 3792),  # 237 x 16
    ],
)
def test_the_start_stop_speed_is_a_multiple_of_the_ramp_increment(bench, if1, range_, asked, actual):
    """Start/stop: "the interface can only set up a rate which is a multiple of the ramp increment for that range"."""
    write(if1, f">{range_}<{asked}")
    assert first_rate(bench, if1) == actual
    assert faults(bench, if1)[1] == b"0\r"


def test_the_default_start_stop_speed_is_400(bench, if1):
    """Default values: "Start/Stop 400 steps/second"."""
    assert first_rate(bench, if1) == 400


@pytest.mark.parametrize("message", ["<0", "<41", "<100", "<4000", "^0", "^501", "^1000", "^99999999999"])
def test_outside_the_limits_is_out_of_range_and_not_taken(bench, if1, message):
    """Start/stop: "between 100 and 4000"; acceleration: "multiples of 1000 ... up to 500,000", not 0 (R10)."""
    command(bench, if1, message, seconds=1.1)
    assert faults(bench, if1) == (b"128\r", b"16\r")
    command(bench, if1, "X100@1000$", seconds=1)
    assert since_start(if1.axes["X"]) == pulse_times_of(ramped(100, 400, 1000, 100, 10_000))


@pytest.mark.parametrize("message", ["<1", "<40", "^1", "^500", "< 0 4", "^0010"])
def test_the_limits_themselves_are_no_fault(bench, if1, message):
    """Start/stop: 100 to 4000 steps/sec; acceleration: 1000 to 500,000 steps/sec2."""
    command(bench, if1, message, seconds=1.1)
    assert faults(bench, if1) == (b"0\r", b"0\r")


def test_below_the_start_stop_speed_the_clock_runs_at_a_fixed_frequency(bench, if1):
    """Start/stop: "Below this speed, no acceleration is applied and the clock will run at a fixed frequency"."""
    command(bench, if1, "<12", "X200@1200$", seconds=3)
    assert since_start(if1.axes["X"]) == constant(1200, 200)
    command(bench, if1, "X200@1100$", seconds=3)
    assert since_start(if1.axes["X"]) == constant(1100, 200)


def test_just_above_the_start_stop_speed_the_clock_is_accelerated(bench, if1):
    """Start/stop: "the rate at which the clock starts when accelerating the motor into the slew region".

    In range 4 a start/stop speed of 300 is set to 288, so 299 has a ramp: 16/10000 s = 1.6 ms at 288, without a pulse.
    """
    command(bench, if1, ">4<3", "X100@299$", seconds=3)
    expected = pulse_times_of([(288, Fraction(16, 10_000)), (299, (100 - Fraction(4608, 5000)) / 299)])
    assert expected[0] == int((Fraction(16, 10_000) + (1 - Fraction(288 * 16, 10_000)) / 299) * S)
    times = since_start(if1.axes["X"])
    assert times[:99] == expected[:99]
    assert times == pulse_times_of(ramped(100, 288, 299, 16, 10_000))


def test_the_ramp_of_the_defaults_to_1000(bench, if1):
    """Speed: "accelerates in increments" of 100 each 100/10,000 s: 400 ... 900 are six levels, 39 pulses, 60 ms."""
    command(bench, if1, "X1000@1000$", seconds=2)
    times = since_start(if1.axes["X"])
    # The 39th pulse ends the ramp up at 60 ms; 922 pulses at 1000/s; the ramp down takes 60 ms from 982 ms on.
    assert times[3] == 10 * MS and times[8] == 20 * MS and times[38] == 60 * MS
    assert times[39] == 61 * MS and times[960] == 982 * MS
    assert times[-1] == 1042 * MS and len(times) == 1000
    assert times == pulse_times_of(ramped(1000, 400, 1000, 100, 10_000))


def test_the_last_rise_may_be_smaller(bench, if1):
    """Speed: "accelerates in increments as shown up to the final speed": 400, 500, 506.25."""
    command(bench, if1, "X100@504$", seconds=1)
    down = 2 * Fraction(9)  # 10 ms at 400 and 10 ms at 500, up and down
    expected = [(400, Fraction(1, 100)), (500, Fraction(1, 100))]
    expected = [*expected, (Fraction(2025, 4), (100 - down) / Fraction(2025, 4)), *reversed(expected)]
    assert since_start(if1.axes["X"]) == pulse_times_of(expected)


@pytest.mark.parametrize(
    ("message", "distance", "start", "top", "increment", "acceleration"),
    [
        (">1<10^15@4800", 5000, 1000, 4800, 100, 15_000),  # the manual's example of parameters in one message
        ("^7@2000", 3000, 400, 2000, 100, 7_000),  # ""^7 <CR>" will set an acceleration rate of 7000 steps/sec2"
        ("^1@1500", 4000, 400, 1500, 100, 1_000),
        ("^500@25000", 9000, 400, 25_000, 100, 500_000),
        (">2^20@5000", 5000, 400, 5000, 200, 20_000),
        (">3<9^50@20000", 9000, 800, 20_000, 400, 50_000),
        (">3^500@99999", 20_000, 400, 100_000, 400, 500_000),
        (">4<1^3@350", 1000, 96, 350, 16, 3_000),
    ],
)
def test_ramps_in_all_ranges(bench, if1, message, distance, start, top, increment, acceleration):
    """Acceleration: "the rate at which the clock accelerates from the start/stop speed up to the programmed speed"."""
    command(bench, if1, message, f"Z{distance}$", seconds=12)
    times = since_start(if1.axes["Z"])
    assert len(times) == distance
    assert times == pulse_times_of(ramped(distance, start, top, increment, acceleration))


def test_all_of_it_may_stand_in_the_first_move_instruction(bench, if1):
    """Acceleration: data "may be sent as part of the initialisation routine or may be included with the first move"."""
    command(bench, if1, ">1 <10 ^15 @ 4800 X 5000 $", seconds=5)
    assert since_start(if1.axes["X"]) == pulse_times_of(ramped(5000, 1000, 4800, 100, 15_000))


def test_parameters_may_follow_the_distance(bench, if1):
    """Appendix 3, sample 7: the acceleration is the last parameter before `$`."""
    command(bench, if1, "X1000@1000^20$", seconds=5)
    assert since_start(if1.axes["X"]) == pulse_times_of(ramped(1000, 400, 1000, 100, 20_000))


@pytest.mark.parametrize("message", ["^10", "<4", ">1", "^25", "<12", ">3", ">1 <10 ^15 @ 4800"])
def test_a_new_ramp_takes_up_to_a_second_in_which_it_does_not_respond(bench, if1, message):
    """Acceleration: "this takes up to 1 second and it will not respond during this period".  R12: one second."""
    answers = arrivals(bench, if1)
    write(if1, message)
    bench.run_until(lambda: not if1.serial.pending, 1)
    received = bench.now + 10 * S // 9600  # the end of CR's first stop bit
    write(if1, "E")
    bench.run(1.5)
    begins = answers[0][0] - 10 * S // 9600
    assert received + 1 * S <= begins <= received + 1 * S + 5 * MS
    assert bytes(byte for _, byte, _ in answers) == b"C\r"


@pytest.mark.parametrize("seconds", [0.0, 0.1, 0.5])
def test_the_calculation_may_take_less(bench, seconds):
    """Acceleration: "up to 1 second": an option (R12)."""
    if1 = ready(bench, recalculation_s=seconds)
    command(bench, if1, "^10", seconds=0.02)
    assert ask(bench, if1, "E", seconds - 0.04 if seconds else 0) == b""
    bench.run(0.1)
    assert if1.serial.read() == b"C\r"


@scripts(
    {
        'Acceleration: "it will still accept any characters sent to it, and will act on any commands after"':
        "^20; S1$; X5$; I; 0.95 s; output1 is low; X at 0; 0.15 s; receives 200<CR>; output1 is high; X at 5",
        "R8: ramp data do not change the run in progress":
        "X@1000G$; 0.5 s; >4<40^500; 3 s; X runs at 1000; #; 3 s; K: 0; F: 0",
        "R8, R10: speed data in motion are checked at the terminator": "XG$; @25001; 0.1 s; K: 131; F: 16",
    }
)  # fmt: skip
def test_ramp_and_speed_data_at_any_time(bench, if1, script):
    play(bench, if1, script)


def test_a_move_with_new_ramp_data_begins_when_the_ramp_is_calculated(bench, if1):
    """Appendix 3, sample 7: `X1000@1000^10$`, and at once `E`, which is answered E (busy) after the calculation."""
    begin = bench.now
    write(if1, "X1000@1000^10$", "E")
    bench.run(1.5)
    assert begin + 1 * S <= start_ns(if1.axes["X"]) <= begin + 1 * S + 30 * MS
    assert if1.serial.read() == b"E\r"


def test_cancel_sent_during_the_calculation_is_acted_on_after_it(bench, if1):
    """Acceleration: characters received during the calculation, here cancel, are executed after it."""
    command(bench, if1, "X100^10$", "#", seconds=3)
    assert if1.axes["X"].position < 10
    assert ask(bench, if1, "E") == b"C\r"


# Parameters while a motor runs: R8


def test_a_speed_sent_while_moving_is_used_by_the_next_move(bench, if1):
    """R8: a speed sent during a motion is stored and used by the next move."""
    command(bench, if1, "X400$", "@200", seconds=2)
    assert since_start(if1.axes["X"]) == constant(400, 400)
    command(bench, if1, "Y100$", seconds=2)
    assert since_start(if1.axes["Y"]) == constant(200, 100)


def test_ramp_data_sent_while_moving_are_calculated_when_the_move_has_ended(bench, if1):
    """R8: with one ramp generator, the new ramp is calculated after the move; status is answered until then."""
    command(bench, if1, "X400$", "^20", seconds=0.1)
    moved_until = start_ns(if1.axes["X"]) + 1 * S
    assert ask(bench, if1, "K", 0.05) == b"3\r"
    bench.run((moved_until - bench.now) / S + 0.05)
    assert (if1.axes["X"].position, ask(bench, if1, "E", 0.8)) == (400, b"")
    bench.run(0.2)
    assert if1.serial.read() == b"C\r"
    command(bench, if1, "X200@1000$", seconds=2)
    assert since_start(if1.axes["X"]) == pulse_times_of(ramped(200, 400, 1000, 100, 20_000))


def test_a_move_behind_new_ramp_data_waits_for_the_ramp(bench, if1):
    """R8 and R9: the move in progress ends, then the ramp is calculated, and then the held move begins."""
    command(bench, if1, "X400$", "^20", "Y200@1000$", seconds=4)
    x, y = if1.axes["X"], if1.axes["Y"]
    x_ends = start_ns(x) + 1 * S
    assert x_ends + 1 * S <= start_ns(y) <= x_ends + 1 * S + 10 * MS
    assert since_start(y) == pulse_times_of(ramped(200, 400, 1000, 100, 20_000))


# Properties


@settings(max_examples=80, deadline=None)
@given(st.data())
def test_pulses_issued_are_the_distance_asked_for_and_every_pulse_is_in_its_place(data):
    """Index mode: at any speed, range, start/stop speed, acceleration and distance, every pulse has its exact time."""
    range_ = data.draw(st.integers(1, 4), "range")
    start, acceleration = data.draw(st.integers(1, 40), "start/stop"), data.draw(st.integers(1, 500), "acceleration")
    speed, distance = data.draw(st.integers(1, MAXIMUM[range_]), "speed"), data.draw(st.integers(1, 4000), "distance")
    bench = Bench()
    if1 = ready(bench, recalculation_s=0.01)
    command(bench, if1, f">{range_}<{start}^{acceleration}@{speed}Y-{distance}$")
    bench.run_until(lambda: not if1.axes["Y"].moving, 5000)
    bench.run(1000)
    increment, resolution = INCREMENT[range_], RESOLUTION[range_]
    top = resolution * max(1, (2 * speed + resolution) // (2 * resolution))
    begin = increment * max(1, start * 100 // increment)
    assert if1.axes["Y"].position == -distance
    assert since_start(if1.axes["Y"]) == pulse_times_of(ramped(distance, begin, top, increment, acceleration * 1000))


@settings(max_examples=60, deadline=None)
@given(st.integers(1, 100), st.integers(1, 500), st.integers(1, 25_000))
def test_a_short_index_is_symmetrical(distance, acceleration, speed):
    """Index mode: "a profile giving a symmetrical acceleration and deceleration": pulse n and pulse D - n mirror."""
    bench = Bench()
    if1 = ready(bench, recalculation_s=0.01)
    command(bench, if1, f"^{acceleration}@{speed}X{distance}$", seconds=60)
    times = since_start(if1.axes["X"])
    assert len(times) == distance
    assert all(
        abs(times[n] + times[distance - 2 - n] - times[-1]) <= 2  # each time is cut down to whole nanoseconds
        for n in range(distance - 1)
    )


def test_a_run_ends_its_ramp_at_the_same_time_as_an_index(bench, if1):
    """Run mode: a run has the same ramp as an index, and then the programmed speed."""
    write(if1, "X@1000G$")
    assert at_speed(bench, if1) == 1000
    assert since_start(if1.axes["X"])[:500] == pulse_times_of(ramped(1000, 400, 1000, 100, 10_000))[:500]
