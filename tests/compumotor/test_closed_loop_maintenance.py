"""Addendum for position tracking: position maintenance (18h, B3h), deadband (B5h); machines with play, and pushed ones.

Expected velocities are multiples of 16.67 pps, the resolution of range 0.
"""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench
from axistwin.bench import Controller
from axistwin.units import MS

from .programs import AT_ONCE, joystick_pulses, number, start, tracked
from .talking import complete, default, i32, messages, position, ready, send, send_all

USER_BIT = 0x01


@pytest.fixture
def board(bench: Bench) -> Controller:
    board = tracked(bench)
    send(bench, board, 0x18, 1)
    return board


def push(board: Controller, counts: int) -> None:
    board.axes["motor"].encoder.displace(counts)


@pytest.mark.parametrize(
    ("algorithm", "gain", "error", "rate"),
    [
        (1, 20, 100, 2_000),
        (1, 255, 200, 50_000),  # 51,000, clipped
        (2, 20, 100, 200),
        (2, 50, 90_000, 15_000),
        (3, 1, 100, 10_000),
        (3, 2, 150, 45_000),
        (3, 2, 160, 50_000),  # 51,200, clipped
        (1, 1, 1, 50 / 3),  # 1 pps would be rounded to 0
        (2, 1, 3, 50 / 3),
    ],
)
@pytest.mark.parametrize("sign", [+1, -1])
def test_the_three_laws(bench, board, algorithm, gain, error, rate, sign):
    send(bench, board, 0xB3, algorithm, gain, 0x00, *i32(50_000))
    push(board, -sign * error)
    bench.run(0.0021)
    assert board.axes["motor"].velocity == pytest.approx(sign * rate)


def test_k_is_in_units_of_the_velocity_range(bench, board):
    """In range 1 the unit is 0.1 pps, so 20 × 100 units are 200 pps, and the maximum of 1,500 units is 150 pps."""
    send(bench, board, 0xB3, 1, 20, 0x10, *i32(50_000))
    push(board, -100)
    bench.run(0.0021)
    assert board.axes["motor"].velocity == pytest.approx(200)
    send(bench, board, 0xB3, 1, 20, 0x1F, *i32(1_500), seconds=0.002)
    assert board.axes["motor"].velocity == pytest.approx(150)


@pytest.mark.parametrize("law", [(1, 20), (2, 100), (3, 1)])
@pytest.mark.parametrize("counts", [-100, 100])
def test_a_pushed_motor_comes_back(bench, board, law, counts):
    """100 encoder pulses are 625 motor pulses; backwards 619 are enough, because encoder counts are rounded down."""
    send(bench, board, 0xB3, *law, 0x00, *i32(50_000))
    push(board, counts)
    bench.run(40)
    assert number(bench, board, 0x99) == 0
    assert -625 <= board.axes["motor"].position * (1 if counts > 0 else -1) <= -619


def test_the_correction_in_time(bench, board):
    """An error of one encoder pulse with K = 100 gives 100 pps, from 2 ms after the push: a pulse every 10 ms.

    The seventh motor pulse makes an encoder pulse (7 × 0.16 = 1.12), so the correction ends at 72 ms.
    """
    send(bench, board, 0xB3, 1, 100, 0x00, *i32(50_000))
    pushed = bench.now
    push(board, -1)
    bench.run(1)
    assert [int(t) - pushed for t in board.axes["motor"].pulse_times(pushed)] == [
        2 * MS + 10 * MS * n for n in range(1, 8)
    ]
    assert number(bench, board, 0x99) == 0


def test_it_costs_nothing_while_there_is_no_error_and_no_motion(bench, board):
    assert bench.clock.next_event_ns() is None
    push(board, -10)
    assert bench.clock.next_event_ns() == bench.now + 2 * MS
    bench.run(20)
    assert bench.clock.next_event_ns() is None
    send(bench, board, 0x35, *i32(400), seconds=20)
    assert bench.clock.next_event_ns() is None


@pytest.mark.parametrize("law", [(1, 0, 0x00, *i32(50_000)), (1, 20, 0x00, *i32(0))])
def test_no_correction_with_k_zero_or_without_any_velocity(bench, board, law):
    send(bench, board, 0xB3, *law)
    push(board, -10)
    assert bench.clock.next_event_ns() is None
    bench.run(1)
    assert number(bench, board, 0x99) == 10


def test_off_it_does_nothing_and_turned_on_it_makes_up_what_is_missing(bench):
    board = tracked(bench)
    push(board, -10)
    bench.run(1)
    assert (number(bench, board, 0x99), board.axes["motor"].position) == (10, 0)
    send(bench, board, 0x18, 1, seconds=5)
    assert number(bench, board, 0x99) == 0
    send(bench, board, 0x18, 0)
    push(board, -10)
    bench.run(1)
    assert number(bench, board, 0x99) == 10


def test_turned_off_in_a_correction_the_motor_stands(bench, board):
    push(board, -1000)
    bench.run(0.1)
    send(bench, board, 0x18, 0)
    assert board.axes["motor"].velocity == 0
    assert number(bench, board, 0x99) > 700


def test_a_closed_loop_move_makes_up_for_backlash(bench):
    """With a play of 50 counts, +1,000 (6,250 pulses) moves the load by 950; 6,563 pulses (1,050.08) move it by 1,000.

    -500 are 3,125 pulses, to 3,438 (550.08), which moves the load to 550 only; at 3,131 (500.96) it is at 500.
    """
    board = tracked(bench, backlash=50)
    complete(bench, board, 0x35, *i32(1000))
    assert (position(bench, board), number(bench, board, 0x9A), number(bench, board, 0x99)) == (6250, 950, 50)
    send(bench, board, 0x18, 1, seconds=20)
    assert (position(bench, board), number(bench, board, 0x9A)) == (6563, 1000)
    send(bench, board, 0x35, *i32(-500), seconds=20)
    assert (position(bench, board), number(bench, board, 0x9A)) == (3131, 500)


def test_a_correction_is_no_move(bench, board):
    """A correction causes no messages; 98h reports the move before; 80h counts the pulses of both."""
    complete(bench, board, 0x35, *i32(16))
    for opcode in (0xA1, 0xA3, 0xA5):
        send(bench, board, opcode, 1)
    push(board, -16)
    bench.run(0.01)
    assert board.axes["motor"].velocity > 0
    bench.run(20)
    assert messages(bench, board) == []
    assert number(bench, board, 0x98) == 16
    assert position(bench, board, 0x80) == 200


@pytest.mark.parametrize("stop", [0x70, 0x78])
def test_stop_and_kill_do_not_end_maintenance(bench, board, stop):
    push(board, -100)
    bench.run(0.1)
    send(bench, board, stop, seconds=40)
    assert number(bench, board, 0x99) == 0


@pytest.mark.parametrize("stop", [0x70, 0x78])
def test_a_stopped_closed_loop_move_stays_where_it_stopped_until_it_is_resumed(bench, board, stop):
    start(bench, board, 0x35, *i32(4000))
    bench.run(1)
    send(bench, board, stop, seconds=1)
    assert number(bench, board, 0x99) == 0
    assert number(bench, board, 0x9A) < 900
    send(bench, board, 0x37, seconds=10)
    assert (number(bench, board, 0x99), number(bench, board, 0x9A)) == (0, 4000)


def test_a_closed_loop_move_may_begin_in_a_correction(bench, board):
    """The shaft is pushed by -1,000; during the correction a move of +100 is sent."""
    push(board, -1000)
    bench.run(0.1)
    assert board.axes["motor"].velocity > 0
    send_all(bench, board, (0xA1, 1), (0x35, *i32(100)), seconds=0.02)
    assert messages(bench, board) == ["a1 00"]
    bench.run(40)
    assert (number(bench, board, 0x99), number(bench, board, 0x9A)) == (0, 100)


@pytest.mark.parametrize("command", [(0x33, *i32(100)), (0x34, *i32(100)), (0x40, 1), (0x40, 2)])
def test_open_loop_preset_moves_are_refused(bench, board, command):
    for number_, opcode in ((1, 0xC8), (2, 0xCB)):
        send(bench, board, opcode, number_, 0x00, *i32(5_000), *i32(AT_ONCE), *i32(100))
    send(bench, board, *command, seconds=1)
    assert board.axes["motor"].pulses == 0


def test_a_continuous_move_is_not_and_where_it_ends_is_the_desired_position(bench, board):
    send(bench, board, 0x32, 0, seconds=1)
    send(bench, board, 0x78)
    stopped = board.axes["motor"].position
    assert stopped > 4_000
    bench.run(1)
    assert (board.axes["motor"].position, number(bench, board, 0x99)) == (stopped, 0)


def test_a_continuous_move_may_begin_in_a_correction(bench, board):
    push(board, -1000)
    bench.run(0.1)
    send(bench, board, 0x32, 1, seconds=1)
    assert board.axes["motor"].velocity == -5_000


def test_a_jammed_motor_goes_on_trying(bench, board):
    """A jam costs whole rotor teeth of pulses; when the shaft is free again, the encoder returns to the position."""
    board.axes["motor"].jam()
    push(board, -10)
    bench.run(1)
    assert number(bench, board, 0x99) == 10
    assert board.axes["motor"].velocity == 200
    board.axes["motor"].jam(False)
    bench.run(10)
    assert number(bench, board, 0x99) == 0


def test_no_correction_into_a_limit_but_away_from_it(bench, board):
    board.pins["cw_limit"].drive(True)
    bench.run(0.01)
    push(board, -10)
    bench.run(1)
    assert board.axes["motor"].pulses == 0
    push(board, 20)
    bench.run(10)
    assert number(bench, board, 0x99) == 0
    push(board, -10)
    bench.run(0.1)
    board.pins["cw_limit"].release()
    bench.run(10)
    assert number(bench, board, 0x99) == 0


def test_no_correction_while_shut_down(bench, board):
    send(bench, board, 0x12, 1)
    push(board, -10)
    bench.run(1)
    assert board.axes["motor"].pulses == 0
    send(bench, board, 0x12, 0, seconds=5)
    assert number(bench, board, 0x99) == 0


def test_a_search_for_home_is_not_disturbed(bench, board):
    """The shaft is pushed while a search is being calculated; the correction comes after the search."""
    send(bench, board, 0x38, 1, 0, 100, 0)
    board.pins["home"].drive(False)
    send(bench, board, 0x39, 0)
    push(board, 100)
    bench.run(1)
    assert board.axes["motor"].velocity == 5_000
    send(bench, board, 0x78, seconds=1)
    assert number(bench, board, 0x99) == 0


def test_the_joystick_takes_the_motor_where_it_wants(bench, board):
    send(bench, board, 0x11, seconds=0.01)
    joystick_pulses(bench, board, 100, period_s=0.002)
    board.pins["at_zero"].drive(True)
    assert board.axes["motor"].position == 100
    send(bench, board, 0x10, seconds=1)
    assert (board.axes["motor"].position, number(bench, board, 0x99), number(bench, board, 0x98)) == (100, 0, 16)


def test_zero_here_is_the_desired_position(bench):
    board = tracked(bench)
    push(board, -10)
    send(bench, board, 0x30)
    assert (number(bench, board, 0x99), number(bench, board, 0x9A)) == (0, 0)


def test_the_deadband_is_shown(bench):
    """Only after B5h is the deadband shown, here five encoder pulses to each side."""
    board = tracked(bench)
    send(bench, board, 0x0F, 0, 0x80, 0xFF)
    seen = [board.bus.read(1) & USER_BIT]
    send(bench, board, 0xB5, 0xAB, 0xCD, 0, 5)
    for counts in (0, 5, 1, -11, -1):
        push(board, counts)
        seen.append(board.bus.read(1) & USER_BIT)
    assert seen == [0, 1, 1, 0, 1, 0]


def test_the_deadband_is_left_by_a_move_and_reached_by_its_end(bench):
    """1,000 pulses at 5,000 pps are 160 encoder pulses; the deadband of 5 begins at 155, that is at 968.75 pulses.

    Pulse 969 comes at 193.8 ms and is detected at 194 ms.
    """
    board = tracked(bench)
    send_all(bench, board, (0xB5, 0, 0, 0, 5), (0x0F, 0, 0x80, 0xFF))
    start(bench, board, 0x35, *i32(160))
    began = bench.now
    assert bench.run_until(lambda: not board.bus.read(1) & USER_BIT, 1)
    assert bench.run_until(lambda: board.bus.read(1) & USER_BIT, 1)
    assert bench.now - began == 194 * MS


@pytest.mark.parametrize("define", [(0x30,), (0x2F, *i32(7))], ids=["30h", "2Fh"])
def test_a_position_that_is_defined_anew_is_in_the_deadband(bench, define):
    """30h, 2Fh make the present position the desired one, so that 99h is 0 and the bit follows at once."""
    board = tracked(bench)
    send_all(bench, board, (0xB5, 0, 0, 0, 5), (0x0F, 0, 0x80, 0xFF))
    push(board, -10)
    assert not board.bus.read(1) & USER_BIT
    send(bench, board, *define)
    assert (number(bench, board, 0x99), board.bus.read(1) & USER_BIT) == (0, 1)


@pytest.mark.parametrize("last", [(0x0F, 0, 0x80, 0xFF), (0xB5, 0, 0, 0, 5)], ids=["0Fh", "B5h"])
def test_the_deadband_is_followed_from_the_middle_of_a_move_on(bench, last):
    """0Fh, B5h in motion, without B0h: the bit is right at once, when the deadband is left, and at the end.

    At 100 pulses/s the deadband of 5 encoder pulses, 31.25 pulses here, is left after 0.3125 s.
    """
    board = ready(bench, motor={"encoder": {"counts_per_rev": 4000, "pulses_per_rev": 25000}})
    commands = {(0x0F, 0, 0x80, 0xFF), (0xB5, 0, 0, 0, 5)}
    default(bench, board, 100, 100_000)
    send(bench, board, *(commands - {last}).pop())
    start(bench, board, 0x33, *i32(200))
    send(bench, board, *last, seconds=0.2)
    assert board.bus.read(1) & USER_BIT
    bench.run(0.2)
    assert not board.bus.read(1) & USER_BIT
    bench.run(2)
    assert board.bus.read(1) & USER_BIT


def test_maintenance_goes_on_to_no_error_at_all_whatever_the_deadband(bench, board):
    send(bench, board, 0xB5, 0, 0, 0, 50)
    push(board, -20)
    bench.run(10)
    assert number(bench, board, 0x99) == 0


def test_an_1810_has_no_deadband(bench):
    board = tracked(bench, "1810")
    send_all(bench, board, (0xB5, 0, 0, 0, 5), (0x0F, 0, 0x80, 0xFF), seconds=0.1)
    assert not board.bus.read(1) & USER_BIT


@settings(max_examples=15, deadline=None)
@given(
    st.lists(st.tuples(st.sampled_from(["push", "go", "to"]), st.integers(-2000, 2000)), min_size=1, max_size=6),
    st.sampled_from([0, 3, 50]),
)
def test_whatever_happens_the_encoder_comes_to_the_sum_of_what_was_commanded(doings, backlash):
    bench = Bench()
    board = tracked(bench, backlash=backlash)
    default(bench, board, 20_000, 100_000)
    send_all(bench, board, (0xB3, 1, 100, 0x00, *i32(50_000)), (0x18, 1))
    desired = 0
    for doing, counts in doings:
        if doing == "push":
            push(board, counts)
        else:
            desired = counts if doing == "to" else desired + counts
            send(bench, board, 0x36 if doing == "to" else 0x35, *i32(counts))
        bench.run(2)
    assert bench.run_until(lambda: bench.clock.next_event_ns() is None, 200)
    assert (number(bench, board, 0x9A), number(bench, board, 0x99)) == (desired, 0)
    assert position(bench, board) == board.axes["motor"].pulses
    bench.run(0.01)
    assert bench.clock.next_event_ns() is None
