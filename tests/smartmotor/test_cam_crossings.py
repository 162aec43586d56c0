"""9.2, 9.3, 9.5: crossings of the zero point, in both directions and with each kind of cam."""

import pytest

from .scenarios import start_cam, turn_through, turn_to
from .talking import send, value


def begin(bench, motor, f, words=""):
    """Start the cam of examples 1 and 2, turn to 3000 counts, and send changes."""
    start_cam(bench, motor, f)
    turn_to(bench, motor, 3000)
    send(bench, motor, words, 0)


def test_a_new_base_is_taken_backwards(bench, motor):
    """9.3: "in either direction": before the origin there are the dwell, 2000 counts, and a new cycle of 4000."""
    begin(bench, motor, "F=16", "BASE=4000 MC CI ")
    counts = [0, -1, -2000, -2500, -6000, -8000, -8500]
    assert turn_through(bench, motor, counts) == [0, 0, 0, 250, -500, -500, -250]


def test_a_new_dwell_is_taken_backwards_in_cam_modulo(bench, motor):
    """9.2: with a new D, CTR is BASE plus this D minus 1 at one count before zero."""
    begin(bench, motor, "F=128", "D=100 CI ")
    for count, physical, reported, counter in [(0, 0, 0, 0), (-1, 0, 500, 8099), (-1100, 250, 750, 7000)]:
        assert turn_to(bench, motor, count) == physical
        assert send(bench, motor, "RP RCTR", 0) == b"%d\r%d\r" % (reported, counter)
    turn_to(bench, motor, -8101)
    assert send(bench, motor, "RP RCTR", 0) == b"500\r8099\r"


def test_a_new_base_of_an_absolute_cam(bench, motor):
    """9.5 names no kind of cam, so in F=0 a new BASE takes effect too, at the zero point after each BASE."""
    begin(bench, motor, "F=0", "BASE=4000 MC CI ")
    assert turn_through(bench, motor, [7000, 8000, 9000, 11_000, 12_000, 13_000]) == [750, 0, 500, 1000, 0, 500]


def test_relative_positions_on_the_fly(bench, motor):
    """9.5: F is changed from 0 to 16 at the zero point; later positions are relative to the shaft's position there."""
    begin(bench, motor, "F=0", "D=100 F=16 MC CI ")
    assert turn_through(bench, motor, [7000, 8000, 9000, 16_000, 16_100, 17_100]) == [750, 0, 250, 500, 500, 750]


@pytest.mark.parametrize(("f", "later"), [("F=16", 750), ("F=144", 750)])
def test_o_in_a_relative_cam_redefines_the_position_and_moves_nothing(bench, motor, f, later):
    """4: O= shifts actual and commanded position together, so the shaft does not move."""
    begin(bench, motor, f, "O=0 ")
    assert motor.axes["shaft"].position == 250
    assert turn_to(bench, motor, 6000) == 1000
    assert value(bench, motor, "@P") == later


def test_parameters_that_g_has_taken_need_no_ci(bench, motor):
    """9.5: starting with MCn and G uses the buffered parameters; an earlier CI changes nothing at the zero point."""
    send(bench, motor, "MF4 F=16 D=2000 BASE=8000 SIZE=8 aw[0] 0 250 500 250 0 500 1000 750 500.", 0)
    send(bench, motor, "MC D=100 CI G D=300", 0)
    assert turn_through(bench, motor, [8000, 8100, 9100, 16_200, 17_200]) == [500, 500, 750, 1000, 1250]


def test_the_dwell_is_multiplied_too_and_may_end_between_two_counts(bench, motor):
    """9.4: MC2 doubles the encoder's pulses: a cycle of BASE=16 and D=5 takes 10.5 counts, two cycles take 21."""
    send(bench, motor, "MF4 F=16 D=5 BASE=16 SIZE=8 aw[0] 0 2 4 6 8 10 12 14 100. MC2 G", 0)
    first = [0, 2, 4, 6, 8, 10, 12, 14, 100, 100, 100]
    second = [101, 103, 105, 107, 109, 111, 113, 157, 200, 200]
    expected = [*first, *second, 200, 202]
    assert turn_through(bench, motor, list(range(23)), 1) == expected
    assert turn_through(bench, motor, list(range(22, -1, -1)), 1) == expected[::-1]


def test_ci_over_and_over_follows_d(bench, motor):
    """Each cycle sends D+1, MC and CI, as in example 4: the cycles take 8000, 8001 and 8002 counts."""
    start_cam(bench, motor, "F=16", dwell=0)
    end, position = 0, 0
    for dwell in range(5):
        end, position = end + 8000 + dwell, position + 500
        turn_to(bench, motor, end - 2000)
        send(bench, motor, f"D={dwell + 1} MC CI", 0)
        assert turn_to(bench, motor, end - 1) == position
        assert turn_to(bench, motor, end + 1000) == position + 250


@pytest.mark.parametrize("per_sample", [1, 777, 1999])
@pytest.mark.parametrize("way", [1, -1])
def test_the_zero_point_is_not_missed_at_speed(bench, motor, per_sample, way):
    """9.4: below ¼ BASE per sample no zero point is missed: after 10000 counts, five cycles take 8100 counts each."""
    start_cam(bench, motor, "F=16")
    turn_to(bench, motor, 3000 if way > 0 else 7000)
    send(bench, motor, "D=100 CI", 0)
    end = 10_000 + 5 * 8100 if way > 0 else -5 * 8100
    assert turn_to(bench, motor, end + 1000, per_sample) == (6 if way > 0 else -5) * 500 + 250


@pytest.mark.parametrize("per_sample", [50, 249])
def test_the_multiplier_counts_for_the_speed_limit(bench, motor, per_sample):
    """9.4: MC8 reaches ¼ BASE per sample at an eighth of the counts: a cycle of 10000 counts is passed in 1250."""
    start_cam(bench, motor, "F=16", mc="MC8")
    assert turn_to(bench, motor, 20 * 1250 + 125, per_sample) == 20 * 500 + 250
    assert turn_to(bench, motor, -20 * 1250 + 125, per_sample) == -20 * 500 + 250
