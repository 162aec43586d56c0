"""Sending basic move instructions: Start/stop speed, Acceleration rate."""

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench
from axistwin.core.units import MS, S

from ..scripts import scripts
from .talking import arrivals, ask, command, play, pulse_times_of, ramped, ready, since_start, start_ns, write

INCREMENT = {1: 100, 2: 200, 3: 400, 4: 16}
MAXIMUM = {1: 25_000, 2: 50_000, 3: 99_999, 4: 4_000}
RESOLUTION = {1: Fraction(25, 4), 2: Fraction(25, 2), 3: Fraction(25), 4: Fraction(1)}


@pytest.mark.parametrize(
    ("range_", "asked", "actual"),
    [
        # "300 s/s in range 1, 200 s/s in range 2, 400 s/s in range 3 and 288 s/s in range 4"
        (1, 3, 300), (2, 3, 200), (3, 3, 400), (4, 3, 288),
        (1, 12, 1200),  # ""<12 <CR>" will set the start/stop rate at 1200 steps/sec in speed range 1"
        (1, 1, 100), (1, 38, 3800), (2, 1, 200), (2, 7, 600), (2, 9, 800), (3, 1, 400), (3, 7, 400), (3, 8, 800),
        (3, 39, 3600), (4, 1, 96), (4, 4, 400), (4, 38, 3792),  # 237 x 16
        (1, None, 400),  # Default values: "Start/Stop 400 steps/second"
    ],
)  # fmt: skip
def test_the_start_stop_speed_is_a_multiple_of_the_ramp_increment(bench, if1, range_, asked, actual):
    """Start/stop: "the interface can only set up a rate which is a multiple of the ramp increment for that range"."""
    play(bench, if1, f">{range_}{f'<{asked}' if asked else ''}; ^1; X@4000G$; until X moving; 0.05 s")
    assert since_start(if1.axes["X"])[0] == S // actual
    play(bench, if1, "F: 0")


def test_just_above_the_start_stop_speed_the_clock_is_accelerated(bench, if1):
    """Start/stop: "the rate at which the clock starts when accelerating the motor into the slew region".

    In range 4 a start/stop speed of 300 is set to 288, so 299 has a ramp: 16/10000 s = 1.6 ms at 288, without a pulse.
    """
    command(bench, if1, ">4<3", "X100@299$", seconds=3)
    expected = pulse_times_of([(288, Fraction(16, 10_000)), (299, (100 - Fraction(4608, 5000)) / 299)])
    assert expected[0] == int((Fraction(16, 10_000) + (1 - Fraction(288 * 16, 10_000)) / 299) * S)
    times = since_start(if1.axes["X"])
    assert times[:99] == expected[:99] and times == pulse_times_of(ramped(100, 288, 299, 16, 10_000))


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


@scripts({
    'Start/stop: "Below this speed, no acceleration is applied and the clock will run at a fixed frequency"':
    "<12; X200@1200$; 3 s; X 200 pulses at 1200; X200@1100$; 3 s; X 200 pulses at 1100",
    'Acceleration: "may be sent as part of the initialisation routine or may be included with the first move"':
    ">1 <10 ^15 @ 4800 X 5000 $; 5 s; X 5000 pulses from 1000 to 4800 by 100 at 15000",
    "Acceleration: the manual's example of parameters in one message, before the move":
    ">1<10^15@4800; Z5000$; 5 s; Z 5000 pulses from 1000 to 4800 by 100 at 15000",
    "Appendix 3, sample 7: the acceleration is the last parameter before `$`":
    "X1000@1000^20$; 5 s; X 1000 pulses from 400 to 1000 by 100 at 20000",
    'Acceleration: ""^7 <CR>" will set an acceleration rate of 7000 steps/sec2"':
    "^7@2000; Z3000$; 12 s; Z 3000 pulses from 400 to 2000 by 100 at 7000",
    'Acceleration: "the rate at which the clock accelerates from the start/stop speed up to the programmed speed"':
    "^1@1500; Z4000$; 12 s; Z 4000 pulses from 400 to 1500 by 100 at 1000",
    "Acceleration: the steepest ramp": "^500@25000; Z9000$; 12 s; Z 9000 pulses from 400 to 25000 by 100 at 500000",
    "Acceleration: range 2": ">2^20@5000; Z5000$; 12 s; Z 5000 pulses from 400 to 5000 by 200 at 20000",
    "Acceleration: range 3": ">3<9^50@20000; Z9000$; 12 s; Z 9000 pulses from 800 to 20000 by 400 at 50000",
    "Acceleration: range 3 up to its maximum":
    ">3^500@99999; Z20000$; 12 s; Z 20000 pulses from 400 to 100000 by 400 at 500000",
    "Acceleration: range 4": ">4<1^3@350; Z1000$; 12 s; Z 1000 pulses from 96 to 350 by 16 at 3000",
    'Acceleration: "it will still accept any characters sent to it, and will act on any commands after"':
    "^20; S1$; X5$; I; 0.95 s; output1 is low; X at 0; 0.15 s; receives 200<CR>; output1 is high; X at 5",
    "Acceleration: a cancel received during the calculation is executed after it":
    "X100^10$; #; 3 s; X between 0 9; E: C",
    "R8: ramp data do not change the run in progress":
    "X@1000G$; 0.5 s; >4<40^500; 3 s; X runs at 1000; #; 3 s; K: 0; F: 0",
    "R8, R10: speed data in motion are checked at the terminator": "XG$; @25001; 0.1 s; K: 131; F: 16",
    "R8: a speed sent during a motion is stored and used by the next move":
    "X400$; @200; 2 s; X 400 pulses at 400; Y100$; 2 s; Y 100 pulses at 200",
    "R8: with one ramp generator, the new ramp is calculated after the move; status is answered until then":
    "X400$; ^20; 0.1 s; K: 3; until X at 400; 0.05 s; E; 0.8 s; still; 0.2 s; receives C<CR>; X200@1000$; 2 s; "
    "X 200 pulses from 400 to 1000 by 100 at 20000",
    "R8 and R9: the move in progress ends, then the ramp is calculated, and then the held move begins":
    "X400$; ^20; Y200@1000$; 4 s; Y begins 1000 to 1010 ms after X; Y 200 pulses from 400 to 1000 by 100 at 20000",
    'Start/stop: "between 100 and 4000"; acceleration: "multiples of 1000 ... up to 500,000", not 0 (R10)':
    "{<0|<41|<100|<4000|^0|^501|^1000|^99999999999}; 1.1 s; K: 128; F: 16; X100@1000$; 1 s; "
    "X 100 pulses from 400 to 1000 by 100 at 10000",
    "Start/stop: 100 to 4000 steps/sec; acceleration: 1000 to 500,000 steps/sec2 (1)":
    "{<1|<40|^1|^500|^0010}; 1.1 s; K: 0; F: 0",
    "Start/stop: 100 to 4000 steps/sec; acceleration: 1000 to 500,000 steps/sec2 (2)": "< 0 4; 1.1 s; K: 0; F: 0",
})  # fmt: skip
def test_ramp_and_speed_data_at_any_time(bench, if1, script):
    play(bench, if1, script)


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


def test_a_move_with_new_ramp_data_begins_when_the_ramp_is_calculated(bench, if1):
    """Appendix 3, sample 7: `X1000@1000^10$`, and at once `E`, which is answered E (busy) after the calculation."""
    begin = bench.now
    write(if1, "X1000@1000^10$", "E")
    bench.run(1.5)
    assert begin + 1 * S <= start_ns(if1.axes["X"]) <= begin + 1 * S + 30 * MS and if1.serial.read() == b"E\r"


# Properties


@settings(max_examples=80)
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
