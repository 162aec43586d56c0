"""Decisions of docs/fidelity.md on single commands: definitions, requests, events, streaming, closed loop."""

import pytest

from .programs import (
    ALL,
    AT_ONCE,
    NEVER,
    continuous,
    cruise,
    enter,
    listing,
    number,
    relative,
    rising,
    sequence,
    start,
    tracked,
    velocities,
    words,
)
from .talking import ask, complete, default, i32, message, messages, position, ready, send, send_all, write

STREAMED = 0x0400  # of the effective clock 4,369,066.67 / 4 Hz, this is 17,066.67 pulses/s

# Definitions


def test_move_zero_is_there_from_reset_on(bench, board):
    """91h, 31h: "After power up or reset the default velocity and acceleration are set to zero"; its type is CEh."""
    assert ask(bench, board, 0x91, 0) == bytes([0x91, 0xCE]).ljust(16, b"\0")
    enter(bench, board, 0x52, 1, 4, rate=10)
    assert ask(bench, board, 0x91, 0) == bytes([0x91, 0xCE]).ljust(16, b"\0")


@pytest.mark.parametrize("command", [(0x32, 0), (0x33, *i32(5)), (0x34, *i32(5)), (0x39, 0)])
@pytest.mark.parametrize(("velocity", "acceleration"), [(0, 0), (0, 5_000), (5_000, 0)])
def test_a_default_move_without_velocity_or_acceleration_is_not_performed(
    bench, board, velocity, acceleration, command
):
    """32h: "If the default move has not been defined no move will be performed"; acceleration 0 counts as undefined."""
    send_all(bench, board, (0xA1, 1), (0x38, 1, 0, 50, 0))
    default(bench, board, velocity, acceleration)
    send(bench, board, *command, seconds=1)
    assert messages(bench, board) == []
    assert board.axes["motor"].pulses == 0
    assert ask(bench, board, 0x91, 0)[4:12] == bytes((*i32(velocity), *i32(acceleration)))


@pytest.mark.parametrize("definition", [relative(1, 5_000, 0, 100), continuous(1, 5_000, 0)])
def test_a_move_with_acceleration_0_is_kept_and_not_performed(bench, board, definition):
    """C8h: acceleration 0 is stored; specifications: 0.00001 steps/s² "to infinity", so it is not performed."""
    send(bench, board, *definition)
    assert ask(bench, board, 0x91, 1) == bytes([0x91, *definition]).ljust(16, b"\0")
    send(bench, board, 0x40, 1, seconds=1)
    assert board.axes["motor"].pulses == 0
    assert ask(bench, board, 0x8C)[1] == 0


@pytest.mark.parametrize("number_", [1, 0x32, 0x33, 0xFF])
def test_an_undefined_move_has_no_parameters_and_does_nothing(bench, board, number_):
    """91h: a response "match[es] the ... original define move command"; without one, 91h reports no parameters."""
    for command in ((0x91, number_), (0x40, number_), (0xD7, number_)):
        send(bench, board, *command)
    bench.run(0.1)
    assert messages(bench, board) == []
    assert board.axes["motor"].pulses == 0


def test_the_highest_velocity_of_the_specifications(bench, board):
    """The highest velocity of 1,092,267 steps/s is 1,092,266.67 (resolution 33.333): half of 4,369,066.67 / 2."""
    default(bench, board, 1_092_267, AT_ONCE, ranges=0x50)
    send(bench, board, 0x32, 0, seconds=0.1)
    assert board.axes["motor"].velocity == pytest.approx(13_107_200 / 12, rel=1e-12)
    assert ask(bench, board, 0x85)[1:6] == bytes((0x50, *i32(1_092_267)))


def test_the_lowest_velocity_of_the_specifications(bench, board):
    """The lowest velocity, 0.017 steps/s, is 17 in range 3, whose resolution is 0.016667: one step per minute."""
    default(bench, board, 17, AT_ONCE, ranges=0x30)
    send(bench, board, 0x32, 0, seconds=601)
    assert len(board.axes["motor"].pulse_times()) == 10


def test_the_lowest_acceleration_of_the_specifications(bench, board):
    """0.00001 steps/s² is 1 in ranges 3 and 2: the first level, 1/60 steps/s, lasts until 0.025 is reached, 1,667 s."""
    default(bench, board, 1_000, 1, ranges=0x32)
    send(bench, board, 0x32, 0)
    levels = []
    for seconds in (1, 1_665, 2):
        bench.run(seconds)
        levels.append(board.axes["motor"].velocity * 60)
    assert levels == pytest.approx([1, 1, 2], rel=1e-9)


# Strings


@pytest.mark.parametrize(
    ("surplus", "taken"), [((0,), True), ((0,) * 14, True), ((1,), False), ((*(0,) * 13, 1), False)]
)
def test_surplus_bytes_are_zeros_or_the_command_is_ignored(bench, board, surplus, taken):
    """Syntax: "Unrequired parameter bytes may be filled with zeros. Using any other character ..." """
    assert ask(bench, board, 0x01, 7, *surplus)[:2] == (b"\x01\x07" if taken else b"")


def test_surplus_zeros_are_not_kept_in_a_sequence(bench, board):
    sequence(bench, board, 1, (0x09, 2, *(0,) * 14))
    assert int.from_bytes(ask(bench, board, 0xE2)[1:5], "big") == 598
    assert listing(bench, board, 1) == ["92 09 02", "92 00"]


def test_a_seventeenth_byte_finds_the_fifo_full(bench, board):
    """Reading and writing: the buffers are "16 bytes deep": a non-zero 17th byte is ignored, a 16th one is invalid."""
    write(board, 0x01, 7, *(0,) * 14, 1)
    assert message(bench, board)[:2] == b"\x01\x07"
    write(board, 0x01, 7, *(0,) * 13, 1)
    assert message(bench, board) == b""


# Requests whose lists of attributes are lost


@pytest.mark.parametrize("request_", [(0x83,), (0x88,), (0x89,), (0x8C,), (0x90,), (0xE2,), (0x91, 0)])
def test_requests_with_lost_lists_are_as_their_siblings(bench, board, request_):
    """83h, 88h, 89h, 8Ch, 90h, 91h and E2h are valid as 80h to 8Bh are: in both modes and during a sequence."""
    sequence(bench, board, 1, (0x28, 0))
    assert ask(bench, board, *request_)[0] == request_[0]
    send(bench, board, 0x41, 1)
    assert ask(bench, board, *request_)[0] == request_[0]
    send(bench, board, 0x79)
    enter(bench, board, 0x52, 1, 4, rate=1_000)
    assert ask(bench, board, *request_)[0] == request_[0]
    velocities(bench, board, *(STREAMED,) * 7)
    send(bench, board, 0x42)
    answered = ask(bench, board, *request_)[:1] == bytes(request_[:1])
    assert answered is (request_[0] != 0x91)  # 91h is not valid for defined moves in this mode


@pytest.mark.parametrize("request_", [(0x88,), (0x89,), (0x8C,), (0x90,), (0xE2,), (0x91, 0), (0x80,), (0x97,)])
def test_no_request_but_83h_stands_in_a_sequence(bench, board, request_):
    """G.2 prints 83h in a sequence; 80h and others are not marked "within-a-SEQUENCE-buffer"."""
    sequence(bench, board, 1, request_, (0x83,))
    assert listing(bench, board, 1) == ["92 83", "92 00"]


@pytest.mark.parametrize("opcode", [0x74, 0x75, 0x76, 0x7D])
def test_trigger_commands_with_lost_lists_stand_in_sequences_and_beside_them(bench, board, opcode):
    """74h to 76h and 7Dh are valid in sequences and beside them, like 77h, 7Ch and 7Eh, whose lists are printed."""
    sequence(bench, board, 1, (opcode, 6, 1, 1), (0x28, 0))
    send(bench, board, 0x41, 1, seconds=0.05)
    rising(bench, board, 6)
    assert messages(bench, board) == [f"{opcode:02x} 06"]
    send_all(bench, board, (0x79,), (opcode, 6, 0, 0), (0x41, 1), (opcode, 6, 0, 0))


@pytest.mark.parametrize("high", [True, False])
def test_8ah_before_38h_tells_the_ttl_level(bench, board, high):
    """8Ah: "active" is what 38h defines; before 38h a high input is active, in 88h too."""
    board.pins["home"].drive(high)
    assert ask(bench, board, 0x8A)[1] == (0xFF if high else 0)
    assert bool(ask(bench, board, 0x88)[1] & 4) is high
    send(bench, board, 0x38, 0, 0, 50, 0)
    assert ask(bench, board, 0x8A)[1] == (0 if high else 0xFF)


# 01h


def test_01h_stands_in_sequences_and_markers(bench, board):
    """01h: "to indicate a location within a sequence buffer"; its list is cut off at the end of the printed page."""
    sequence(bench, board, 1, (0x28, 0), (0x01, 9))
    send(bench, board, 0x41, 1)
    assert ask(bench, board, 0x01, 1)[:2] == b"\x01\x01"
    send(bench, board, 0x48)
    assert messages(bench, board) == ["01 09"]


def test_01h_as_its_list_is_printed(bench):
    """Option interrupt_command="printed": 01h is valid in both modes, and neither in nor beside sequences."""
    board = ready(bench, interrupt_command="printed")
    sequence(bench, board, 1, (0x28, 0), (0x01, 9))
    assert listing(bench, board, 1) == ["92 28", "92 00"]
    send(bench, board, 0x41, 1)
    assert ask(bench, board, 0x01, 1) == b""
    send(bench, board, 0x79)
    assert ask(bench, board, 0x01, 2)[:2] == b"\x01\x02"
    enter(bench, board, 0x52, 1, 4, rate=10)
    assert ask(bench, board, 0x01, 3)[:2] == b"\x01\x03"
    send(bench, board, 0xEE, *words(0x7FFF), 0x01, 4, 0)
    velocities(bench, board, 0x7FFF, 0x7FFF)
    send(bench, board, 0x42)
    assert ask(bench, board, 0x01, 5) == b""
    bench.run(1)
    assert messages(bench, board) == []


# Streaming


def run_dry(bench, board):
    enter(bench, board, 0x52, 1, 4, rate=10)
    velocities(bench, board, STREAMED)
    send(bench, board, 0x42, seconds=0.2)
    assert board.axes["motor"].velocity == pytest.approx(17_066.67, abs=0.01)


def moved(bench, board):
    default(bench, board, 10_000, 100_000)
    complete(bench, board, 0x33, *i32(100))


def test_70h_after_a_stream_has_run_dry_is_a_ramp_of_the_last_move(bench, board):
    """70h: "at the most recent acceleration/deceleration rate": from 17,066.67 pps at 100,000 pps² in 0.17 s."""
    moved(bench, board)
    run_dry(bench, board)
    send(bench, board, 0x70)
    began = bench.now
    assert bench.run_until(lambda: not board.axes["motor"].velocity, 1)
    assert 0.166 < (bench.now - began) / 1e9 <= 0.172


def test_70h_after_a_stream_without_any_move_since_reset_ends_the_pulses(bench, board):
    """70h uses the most recent acceleration; without any move since reset there is none, so the pulses end at once."""
    run_dry(bench, board)
    send(bench, board, 0x70)
    assert not board.axes["motor"].velocity


def test_70h_after_a_stream_may_be_ignored(bench):
    """Option; 70h: "motion due to the performance of a move"; 7Bh names only a streamed zero and 78h."""
    board = ready(bench, stop_after_stream="ignored")
    moved(bench, board)
    run_dry(bench, board)
    send(bench, board, 0x70, seconds=1)
    assert board.axes["motor"].velocity == pytest.approx(17_066.67, abs=0.01)
    send(bench, board, 0x78)
    assert not board.axes["motor"].velocity
    send(bench, board, 0x33, *i32(30_000))  # 70h still stops a move
    bench.run(0.5)
    complete(bench, board, 0x70)
    assert position(bench, board, 0x81) > 0


@pytest.mark.parametrize(
    ("alarm", "performed", "before", "at_7bh"),
    [(4, True, [], ["52 01 04 00 00 00 04 03 e8"]), (4, False, [], []),
     (12, True, ["52 01 04 00 00 00 0c 03 e8"], [])],
    ids=["on", "not on", "sent"],
)  # fmt: skip
def test_7bh_sends_an_alarm_that_is_on(bench, board, alarm, performed, before, at_7bh):
    """51h: an alarm is sent if the bytes left go below its value after "3) Begin velocity streaming", not before.

    51h: "the alarm will only be sent once", so 7Bh after it sends no second one.
    """
    enter(bench, board, 0x52, 1, 4, alarm=alarm, rate=1_000)
    velocities(bench, board, *(STREAMED,) * 7)
    if performed:
        send(bench, board, 0x42, seconds=0.5)
    for expected in (before, at_7bh, []):
        assert messages(bench, board) == expected
        send(bench, board, 0x7B)


def test_a2h_and_a3h_tell_nothing_of_a_stream_and_a5h_each_end_of_motion(bench, board):
    """A2h: only moves are reported; A4h: "when the motor arrives at zero velocity", so A5h reports each stop."""
    for code in (0xA1, 0xA2, 0xA3, 0xA5):
        send(bench, board, code, 1)
    enter(bench, board, 0x52, 1, 4, alarm=NEVER, rate=10)
    velocities(bench, board, STREAMED, STREAMED, 0, STREAMED, STREAMED, STREAMED, 0)
    send(bench, board, 0x42, seconds=1)
    assert messages(bench, board) == ["a5 00", "a5 00"]
    send(bench, board, 0xA5, 0)  # not valid in a streaming mode
    velocities(bench, board, STREAMED, STREAMED, STREAMED, STREAMED, STREAMED, STREAMED, 0)
    send(bench, board, 0x42, seconds=1)
    assert messages(bench, board) == ["a5 00"]


# Closed loop


@pytest.mark.parametrize("way", [+1, -1])
def test_81h_after_a_correction_has_the_sign_of_the_move(bench, way):
    """X25: positive means short of the end.  Pushed on by 100 counts, the motor corrects by about 620 pulses back."""
    board = tracked(bench)
    motor = board.axes["motor"]
    send(bench, board, 0x18, 1)
    complete(bench, board, 0x35, *i32(way * 4_000))
    motor.encoder.displace(way * 100)
    bench.run(5)
    assert number(bench, board, 0x99) == 0
    assert 24_374 <= way * motor.position <= 24_382
    assert position(bench, board, 0x81) == 25_000 - way * motor.position


@pytest.mark.parametrize(("ratio", "target", "begins"), [
    ((1, 2), 0x7FFF_FFFF, True), ((1, 2), -0x8000_0000, True), ((1, 1), 0x7FFF_FFFF, True),
    ((1, 1), -0x7FFF_FFFF, True), ((1, 1), -0x8000_0000, False), ((2, 1), 0x3FFF_FFFF, True),
    ((2, 1), 0x4000_0000, False),
])  # fmt: skip
@pytest.mark.parametrize("opcode", [0xD4, 0xD5])
def test_closed_loop_moves_are_limited_by_their_motor_pulses(bench, opcode, ratio, target, begins):
    """D4h, D5h: the distance "must be less than or equal to 7FFFFFFFh divided by the ... ratio", starting at 0."""
    board = tracked(bench)
    send_all(bench, board, (0xB0, *words(*ratio)), (opcode, 7, 0x00, *i32(5_000), *i32(AT_ONCE), *i32(target)))
    assert ask(bench, board, 0x91, 7)[12:16] == bytes(i32(target))
    send_all(bench, board, (0xA1, 1), (0x40, 7))
    assert messages(bench, board) == (["a1 00"] if begins else [])


def test_d5h_is_measured_from_where_the_encoder_is(bench):
    """D5h is measured from the encoder: from -1 to 7FFFFFFFh the distance is 80000000h, which is too large."""
    board = tracked(bench)
    send_all(bench, board, (0xB0, *words(1, 1)), (0xA1, 1))
    send(bench, board, 0xD5, 7, 0x00, *i32(5_000), *i32(AT_ONCE), *i32(0x7FFF_FFFF))
    for here in (-1, 0):
        send_all(bench, board, (0x2F, *i32(here)), (0x40, 7))
        assert messages(bench, board) == ([] if here else ["a1 00"])


def test_36h_and_9ah_agree_beyond_32_bits(bench):
    """9Ah has 32 bits: 16 beyond 7FFFFFFFh is -80000000h + 15, and an absolute move to that position moves nothing."""
    board = tracked(bench)
    send(bench, board, 0x2F, *i32(0x7FFF_FFFF))
    complete(bench, board, 0x35, *i32(16))
    here = -0x8000_0000 + 15
    assert number(bench, board, 0x9A) == here
    for more, pulses in ((0, 100), (16, 200), (0, 100)):
        complete(bench, board, 0x36, *i32(here + more))
        assert (number(bench, board, 0x9A), number(bench, board, 0x99)) == (here + more, 0)
        assert board.axes["motor"].position == pulses


def test_37h_beyond_32_bits_goes_where_the_move_was_to_end(bench):
    board = tracked(bench)
    send(bench, board, 0x2F, *i32(0x7FFF_FFFF))
    start(bench, board, 0x35, *i32(1_600))
    bench.run(1)
    send(bench, board, 0x78)
    complete(bench, board, 0x37)
    assert number(bench, board, 0x9A) == -0x8000_0000 + 1_599


@pytest.mark.parametrize(("target", "stops"), [(3, 2), (-3, -2), (5, 3), (-5, -3)])
def test_an_absolute_closed_loop_move_stops_at_the_same_place_from_either_side(bench, target, stops):
    """At two counts per pulse, 3 is 1.5 pulses: rounded away from absolute zero, whichever side the move comes from."""
    found = set()
    for first in (0, 10 * (1 if target > 0 else -1)):
        board = ready(bench, motor={"encoder": {"counts_per_rev": 200, "pulses_per_rev": 100}})
        for command in (*ALL, (0xB0, *words(1, 2))):
            send(bench, board, *command)
        default(bench, board, 5_000, AT_ONCE)
        for place in (first, target):
            complete(bench, board, 0x36, *i32(place))
        found.add(board.axes["motor"].position)
    assert found == {stops}


def test_relative_closed_loop_moves_there_and_back_end_where_they_began(bench):
    """A relative move of half a pulse and its reverse are rounded alike, so they end where they began."""
    board = tracked(bench)
    send(bench, board, 0xB0, *words(1, 2))
    for distance, place in ((3, 2), (-3, 0), (-3, -2), (3, 0)):
        complete(bench, board, 0x35, *i32(distance))
        assert board.axes["motor"].position == place


@pytest.mark.parametrize("ratio", [(0, 1), (1, 0), (0, 0)])
def test_a_ratio_is_of_two_positive_numbers(bench, ratio):
    """B0h: "interpreted as positive sixteen bit numbers"."""
    board = tracked(bench)
    send(bench, board, 0xB0, *words(*ratio))
    assert ask(bench, board, 0x9C)[1:5] == bytes.fromhex("61A8 0FA0")


@pytest.mark.parametrize("end_on_stall", [0, 1])
def test_a_jammed_motor_in_a_correction_is_pushed_until_it_is_free(bench, end_on_stall):
    """19h: it ends moves only; 18h: a correction "always attempts to maintain a zero deadband".

    100 counts times K = 20 are 2,000 pulses/s, as long as the shaft is held.
    """
    board = tracked(bench)
    motor = board.axes["motor"]
    send_all(bench, board, (0x18, 1), (0x19, end_on_stall), (0xA7, 1))
    motor.jam(True)
    motor.encoder.displace(100)
    bench.run(2)
    assert motor.velocity == -2_000
    assert number(bench, board, 0x99) == -100
    assert ask(bench, board, 0x8C)[1] == 0xFF
    assert messages(bench, board) == []
    motor.jam(False)
    bench.run(5)
    assert (number(bench, board, 0x99), motor.velocity) == (0, 0)


def test_18h_ends_the_correction_of_a_jammed_motor(bench):
    board = tracked(bench)
    send(bench, board, 0x18, 1)
    board.axes["motor"].jam(True)
    board.axes["motor"].encoder.displace(100)
    bench.run(1)
    send(bench, board, 0x18, 0)
    assert not board.axes["motor"].velocity


# An 1810


def closed_loop_move(bench, board, opcode=0xD4):
    send(bench, board, opcode, 7, 0x00, *i32(5_000), *i32(AT_ONCE), *i32(100))


@pytest.mark.parametrize("opcode", [0xD4, 0xD5])
def test_an_1810_keeps_closed_loop_definitions_and_performs_none(bench, opcode):
    """Addendum: "The software used in the 1810 is identical": definitions are kept; only B5h "will be ignored"."""
    board = tracked(bench, "1810")
    closed_loop_move(bench, board, opcode)
    assert ask(bench, board, 0x91, 7)[1] == opcode
    send(bench, board, 0x40, 7, seconds=1)
    assert board.axes["motor"].pulses == 0
    send(bench, board, 0x2F, *i32(1_000))
    assert number(bench, board, 0x9A) == 1_000


def test_an_1810_may_perform_them_with_an_encoder_that_stays_at_0(bench):
    board = tracked(bench, "1810", options={"encoder_commands": "performed"})
    closed_loop_move(bench, board)
    for command in ((0x40, 7), (0x35, *i32(100)), (0x36, *i32(100))):
        complete(bench, board, *command)
    assert board.axes["motor"].position == 3 * 625
    assert number(bench, board, 0x9A) == 0
    send_all(bench, board, (0x0F, 3, 0x80, 1), (0xB5, *i32(1_000)))
    assert not board.pins["output1"].level


@pytest.mark.parametrize("distance", [25_000, -25_000])
def test_a_move_without_an_encoder_is_a_stall_after_one_tooth(bench, distance):
    """B0h: 1 to 1; the encoder stays at 0, and one of 50 teeth is 500 of 25,000 pulses; 19h ends the move there."""
    board = tracked(bench, "1810", options={"encoder_commands": "performed"})
    send_all(bench, board, (0xB0, 0, 1, 0, 1), (0x19, 1), (0x33, *i32(distance)), seconds=6)
    assert board.axes["motor"].position == (500 if distance > 0 else -500)


def test_an_1810_may_ignore_them_all(bench):
    board = tracked(bench, "1810", options={"encoder_commands": "ignored"})
    closed_loop_move(bench, board)
    send(bench, board, 0x2F, *i32(1_000))
    assert ask(bench, board, 0x91, 7) == b""
    assert number(bench, board, 0x9A) == 0


@pytest.mark.parametrize("reading", ["ignored", "kept", "performed"])
def test_an_1811_obeys_them_whatever_an_1810_would(bench, reading):
    board = tracked(bench, options={"encoder_commands": reading})
    complete(bench, board, 0x35, *i32(100))
    assert (board.axes["motor"].position, number(bench, board, 0x9A)) == (625, 100)


def test_a_continuous_move_of_the_host_is_not_refused_by_its_own_end(bench, board):
    cruise(bench, board)
    send(bench, board, 0x32, 1, seconds=1)
    assert board.axes["motor"].velocity == -10_000
