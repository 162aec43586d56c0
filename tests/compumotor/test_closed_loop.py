"""Addendum for position tracking: parameters, counts, closed-loop moves; and the loose sheets on 37h."""

import pytest

from axistwin.units import US

from .programs import ALL, AT_ONCE, RATIO, number, start, tracked
from .talking import RESET, ask, complete, default, i32, message, messages, position, ready, send, send_all, until_idle


@pytest.fixture
def board(bench):
    return tracked(bench)


def test_parameters_are_reported_as_they_were_given_and_zeros_before(bench):
    board = ready(bench)
    assert [ask(bench, board, opcode) for opcode in range(0x9C, 0xA0)] == [
        bytes([opcode]).ljust(16, b"\0") for opcode in range(0x9C, 0xA0)
    ]
    for command in ALL:
        send(bench, board, *command)
    assert ask(bench, board, 0x9C)[:6] == bytes.fromhex("9C 61A8 0FA0 00")
    assert ask(bench, board, 0x9D)[:6] == bytes.fromhex("9D 000061A8 00")
    assert ask(bench, board, 0x9E)[:6] == bytes.fromhex("9E 00000000 00")
    assert ask(bench, board, 0x9F)[:9] == bytes.fromhex("9F 01 14 00 0000C350 00")


@pytest.mark.parametrize(
    "wrong",
    [(0, 1, 0x00, *i32(1)), (4, 1, 0x00, *i32(1)), (1, 1, 0x60, *i32(1)), (1, 1, 0x00, *i32(-1)),
     (1, 1, 0x00, *i32(546_134))],
)  # fmt: skip
def test_a_law_out_of_range_is_ignored(bench, board, wrong):
    send(bench, board, 0xB3, *wrong)
    assert ask(bench, board, 0x9F)[:8] == bytes.fromhex("9F 01 14 00 0000C350")


def test_the_lower_nibble_of_the_laws_range_means_nothing(bench, board):
    """B3h, range byte: "0X -> 5X": any lower nibble is accepted."""
    send(bench, board, 0xB3, 3, 0xFF, 0x5F, *i32(7))
    assert ask(bench, board, 0x9F)[:8] == bytes.fromhex("9F 03 FF 5F 00000007")


def test_a_ratio_with_denominator_zero_is_ignored(bench, board):
    send(bench, board, 0xB0, 0, 1, 0, 0)
    assert ask(bench, board, 0x9C)[1:5] == bytes.fromhex("61A8 0FA0")


def test_a_closed_loop_move_goes_so_many_encoder_pulses(bench, board):
    """4,000 encoder pulses are 4,000 × 6.25 motor pulses, 5 s at 5,000 pps; after 2.5 s half of them are done."""
    start(bench, board, 0x35, *i32(4000))
    bench.run(2.5)
    assert number(bench, board, 0x98) == pytest.approx(2000, abs=10)
    assert number(bench, board, 0x99) == pytest.approx(2000, abs=15)  # the rest of the move
    until_idle(bench, board)
    assert position(bench, board) == board.axes["motor"].position == 25_000
    assert [number(bench, board, opcode) for opcode in (0x98, 0x99, 0x9A, 0x9B)] == [4000, 0, 4000, 0]
    assert position(bench, board, 0x81) == 0


def test_the_relative_count_is_of_the_last_move(bench, board):
    for distance in (4000, -400):
        complete(bench, board, 0x35, *i32(distance))
    assert (number(bench, board, 0x98), number(bench, board, 0x9A)) == (-400, 3600)


def test_pulses_are_rounded_to_the_nearest_a_half_away_from_zero(bench, board):
    """A move of 10 is 62.5 pulses: 63 are made.  A move of -50 is 312.5: 313 are made, to -250, encoder -40."""
    complete(bench, board, 0x35, *i32(10))
    assert (position(bench, board), number(bench, board, 0x9A)) == (63, 10)
    complete(bench, board, 0x35, *i32(-50))
    assert (position(bench, board), number(bench, board, 0x9A)) == (-250, -40)


def test_the_desired_position_is_the_sum_of_closed_loop_moves(bench, board):
    """The addendum's example: after +30 and -10 the desired position is +20; after absolute +55 it is +55."""
    desired = []
    for command in ((0x35, *i32(30)), (0x35, *i32(-10)), (0x36, *i32(55))):
        complete(bench, board, *command)
        desired.append(number(bench, board, 0x9A) + number(bench, board, 0x99))
    assert desired == [30, 20, 55]


def test_with_maintenance_off_the_desired_position_is_where_an_open_loop_move_ended(bench, board):
    """An open-loop move of 1,000 pulses ends at 160 encoder pulses, which is then the desired position."""
    start(bench, board, 0x33, *i32(1000))
    bench.run(0.1)
    assert number(bench, board, 0x99) < 0
    until_idle(bench, board)
    assert (number(bench, board, 0x99), number(bench, board, 0x9A)) == (0, 160)


def test_an_absolute_move_is_from_where_the_encoder_is(bench, board):
    """The shaft is pushed to +100, so an absolute move to +300 is 200 encoder pulses, or 1,250 motor pulses."""
    board.axes["motor"].encoder.displace(100)
    complete(bench, board, 0x36, *i32(300))
    assert (position(bench, board), number(bench, board, 0x9A), number(bench, board, 0x99)) == (1250, 300, 0)


def test_a_move_to_where_it_is_makes_no_pulse_but_is_the_desired_position(bench, board):
    board.axes["motor"].encoder.displace(100)
    assert number(bench, board, 0x99) == -100
    send(bench, board, 0x36, *i32(100), seconds=0.1)
    assert (number(bench, board, 0x99), board.axes["motor"].pulses) == (0, 0)


@pytest.mark.parametrize("missing", ALL)
def test_35_and_36_need_b0_to_b4_all_five(bench, missing):
    board = ready(bench, motor={"encoder": {}})
    default(bench, board, 5_000, AT_ONCE)
    for command in ALL:
        if command is not missing:
            send(bench, board, *command)
    for opcode in (0x35, 0x36):
        send(bench, board, opcode, *i32(1000), seconds=1)
    assert board.axes["motor"].pulses == 0


def test_35_and_36_need_the_default_move(bench, board):
    default(bench, board, 0, 0)
    for opcode in (0x35, 0x36):
        send(bench, board, opcode, *i32(1000), seconds=1)
    assert board.axes["motor"].pulses == 0


@pytest.mark.parametrize(("opcode", "ends"), [(0xD4, 2 * 625), (0xD5, 625)])
def test_defined_closed_loop_moves_need_the_ratio_only(bench, opcode, ends):
    board = ready(bench, motor={"encoder": {"counts_per_rev": 4000, "pulses_per_rev": 25_000}})
    send(bench, board, opcode, 7, 0x00, *i32(5_000), *i32(AT_ONCE), *i32(100))
    assert (
        ask(bench, board, 0x91, 7)[:15]
        == bytes([opcode, 7, 0]).join([b"\x91", b""]) + bytes((*i32(5_000), *i32(AT_ONCE), *i32(100)))[:11]
    )
    send(bench, board, 0x40, 7, seconds=1)
    assert board.axes["motor"].position == 0
    send(bench, board, *RATIO)
    for _ in range(2):
        complete(bench, board, 0x40, 7)
    assert board.axes["motor"].position == ends


@pytest.mark.parametrize(("counts", "begins"), [(32_768, True), (32_769, False), (-32_768, True), (-32_769, False)])
@pytest.mark.parametrize("opcode", [0x35, 0x36])
def test_no_closed_loop_move_is_longer_than_7fffffff_motor_pulses(bench, board, opcode, counts, begins):
    """At 65,535 to 1, 32,768 are 2,147,450,880 motor pulses; one encoder pulse more exceeds 2,147,483,647."""
    send_all(bench, board, (0xB0, 0xFF, 0xFF, 0, 1), (0xA1, 1), (opcode, *i32(counts)))
    assert messages(bench, board) == (["a1 00"] if begins else [])


def test_resume_goes_to_the_last_commanded_position_as_that_move_did(bench, board):
    """A pre-defined move at 2,000 pps (120 × 16.67) is killed after about 1 s; 37h makes the rest at 2,000 pps.

    After n motor pulses the encoder is at 4n / 25, rounded down; the rest is up to 4,000, one pulse each 0.5 ms.
    """
    motor = board.axes["motor"]
    send(bench, board, 0xD4, 1, 0x00, *i32(2_000), *i32(AT_ONCE), *i32(4000))
    start(bench, board, 0x40, 1)
    bench.run(1)
    send(bench, board, 0x78)
    stopped = motor.position
    assert 2_000 <= stopped <= 2_010
    assert number(bench, board, 0x99) == 0
    start(bench, board, 0x37)
    began = bench.now
    until_idle(bench, board)
    left = (25 * (4000 - 4 * stopped // 25) + 2) // 4
    assert number(bench, board, 0x9A) == 4000
    assert motor.position == stopped + left
    assert int(motor.pulse_times(began)[-1]) - began == left * 500 * US


def test_resume_with_nothing_commanded_is_ignored(bench, board):
    complete(bench, board, 0x33, *i32(100))
    send(bench, board, 0x37, seconds=1)
    assert board.axes["motor"].position == 100


def test_resume_goes_to_the_same_place_after_absolute_zero_has_been_redefined(bench, board):
    start(bench, board, 0x36, *i32(800))
    bench.run(0.3)
    send_all(bench, board, (0x78,), (0x30,))
    assert (number(bench, board, 0x9A), position(bench, board)) == (0, 0)
    complete(bench, board, 0x37)
    assert board.axes["motor"].encoder.count == 800


def test_2f_defines_the_closed_loop_position_only_and_there_is_no_error_then(bench, board):
    send_all(bench, board, (0x18, 1), (0x2F, *i32(-1_000_000)))
    assert (number(bench, board, 0x9A), position(bench, board), number(bench, board, 0x99)) == (-1_000_000, 0, 0)
    complete(bench, board, 0x36, *i32(-999_900))
    assert (board.axes["motor"].position, number(bench, board, 0x9A)) == (625, -999_900)


def test_2f_is_ignored_while_moving(bench, board):
    start(bench, board, 0x35, *i32(4000))
    complete(bench, board, 0x2F, *i32(1_000_000))
    assert number(bench, board, 0x9A) == 4000


def test_the_absolute_count_wraps_at_32_bits(bench, board):
    send(bench, board, 0x2F, *i32(0x7FFF_FFFF))
    complete(bench, board, 0x35, *i32(16))
    assert number(bench, board, 0x9A) == -0x8000_0000 + 15
    assert number(bench, board, 0x99) == 0


def test_the_sense_of_direction_is_that_of_both_counts(bench, board):
    """14h: from this command on, CCW is +; the counts keep their values."""
    complete(bench, board, 0x35, *i32(16))
    send(bench, board, 0x14, 1)
    assert number(bench, board, 0x9A) == 16
    complete(bench, board, 0x35, *i32(16))
    assert (number(bench, board, 0x9A), number(bench, board, 0x99)) == (32, 0)
    assert (board.axes["motor"].position, board.axes["motor"].encoder.count) == (0, 0)


def test_after_a_reset_counts_are_zero_and_nothing_is_defined(bench, board):
    complete(bench, board, 0x35, *i32(16))
    board.bus.write(1, RESET)
    bench.run(1.01)
    assert [number(bench, board, opcode) for opcode in (0x98, 0x99, 0x9A)] == [0, 0, 0]
    assert ask(bench, board, 0x9C)[1:5] == bytes(4)
    board.power(False)
    assert not board.axes["motor"].on_push


def test_an_1810_answers_the_requests_and_does_not_move(bench):
    board = tracked(bench, "1810")
    complete(bench, board, 0x33, *i32(625))
    assert [number(bench, board, opcode) for opcode in (0x98, 0x99, 0x9A)] == [0, 0, 0]
    for opcode in (0x35, 0x36):
        send(bench, board, opcode, *i32(1000))
    send(bench, board, 0x37, seconds=1)
    assert (board.axes["motor"].position, number(bench, board, 0x9A)) == (625, 0)


def test_an_1811_without_an_encoder_counts_nothing(bench):
    board = ready(bench)
    default(bench, board, 5_000, AT_ONCE)
    complete(bench, board, 0x33, *i32(625))
    assert number(bench, board, 0x9A) == 0
    assert message(bench, board) == b""


@pytest.mark.parametrize("sense", [0x00, 0x01])
def test_jumper_ju17_inverts_the_encoders_direction(bench, sense):
    """Jumper options: "JU17 ... Invert encoder Direction bit": 25,000 pulses then are -4000 counts instead of 4000."""
    encoder = {"counts_per_rev": 4000, "pulses_per_rev": 25_000}
    counts = []
    for inverted in (False, True):
        board = ready(bench, motor={"encoder": encoder}, invert_encoder=inverted)
        send(bench, board, 0x14, sense)
        default(bench, board, 25_000, 250_000)
        send(bench, board, 0x33, *i32(25_000), seconds=2)
        counts.append(number(bench, board, 0x9A))
    assert counts == [4000, -4000]
