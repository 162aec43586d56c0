"""Interactions of two chapters: limits, shutdown, STOP and long listings while another command is performed."""

import pytest

from ..scripts import scripts
from .programs import continuous, cruise, enter, listing, sequence, velocities
from .scripts import play
from .talking import ask, default, i32, ready, send, send_all, status_word, write

# Limits


def levels(bench, board, seconds):
    """Return the successive velocities, sampled once per millisecond."""
    seen = []
    for _ in range(round(seconds * 1000)):
        bench.run(0.001)
        velocity = board.axes["motor"].velocity
        if not seen or seen[-1] != velocity:
            seen.append(velocity)
    return seen


@scripts({
    'Functional check: if "the limit switches are not connected and not bypassed", the motor turns less':
    "14 {00|01|00|01}; {cw_limit|cw_limit|ccw_limit|ccw_limit} high; FF; 5.1 s; at {-25000|-25000|25000|25000}; "
    "SB & 20 is 20",
    "the test function at both limits fails at once":
    "cw_limit high; ccw_limit high; FF; 0.01 s; at 0; SB & 20 is 20",
    '78h: "equivalent to hitting a limit switch": the move is killed, and the reversal does not continue':
    "cruise {10000|-10000} 100000; A1 01; 32 {01|00}; 0.05 s; {cw_limit|ccw_limit} high; 0.0002 s; mark; 1 s; "
    "moved 0; says A1 00",
    "a limit at the end of an earlier move does not end a later reversal":
    "cruise 10000 100000; cw_limit high; 0.01 s; cw_limit low; cruise 10000 100000; 32 01; 1 s; velocity -10000",
    '70h: "the deceleration to zero is at the most recent acceleration", also during a ramp between two velocities':
    "cruise 10000 100000; default {20000|5000} 100000; 32 00; 0.02 s; 70; 8F -> FF; 0.2 s; at rest",
    '85h: "indicating the current velocity": a stream with 1000h of 4.369 MHz/16 leaves 17,066.67 pulses/s':
    "52 01 10 =never #2; velocities 4096 4096 4096 4096 4096 4096 4096; 42; 0.1 s; 50; 85 -> 00 00 00 42 AB; 78; "
    "85 -> 00",
    "92h is SINGULAR: until its last message is queued no other SINGULAR command is performed; 73h ends 92h (1)":
    "1811 message_queue=2; default 5000 100000; sequence 1: 01 01, 01 01, 01 01, 01 01, 01 01; 92 01; 33 =100; "
    "1 s; at 0; 73; says 92 01 01, 92 01 01, 92 01 01; 33 =100; idle; at 100",
    "92h is SINGULAR: until its last message is queued no other SINGULAR command is performed; 73h ends 92h (2)":
    "1811 message_queue=64; default 5000 100000; sequence 1: 01 01, 01 01, 01 01, 01 01, 01 01; 92 01; 33 =100; "
    "1 s; at 100",
    "48h: the first one ends the waiting 28h of a 21h loop; the loop is repeated until another 48h comes":
    "sequence 1: 21 02, 28 01, 29 00 00 00 64, 01 09; 41 01; says 28 00; 48; 0.01 s; 48; says 01 09",
    '12h: "after remote power shutdown is turned on no moves may be performed", nor the next leg of a search':
    "1811 motor={'home':(2000,6000)}; default 5000 20000; 13 01; 38 01 01 14 00; 39 00; 0.3 s; shutdown_in low; "
    "until shutdown is high; mark; at over 2000; 2 s; moved 0; 82: marked",
})  # fmt: skip
def test_limits(bench, script):
    play(bench, script)


# Work in progress


def wait_in_a_sequence(bench, board):
    sequence(bench, board, 1, (0x2A, 0, 1))
    send(bench, board, 0x41, 1)


def stream_zeros(bench, board):
    enter(bench, board, 0x52, 3, 1, rate=50)
    velocities(bench, board, 0)
    send(bench, board, 0x42)


@pytest.mark.parametrize("begin", [
    cruise, wait_in_a_sequence, stream_zeros,
    lambda bench, board: send_all(bench, board, (0x84,), (0x84,))
], ids=["motion", "sequence", "stream", "waiting command"])  # fmt: skip
def test_a_board_is_busy_while_it_works(bench, board, begin):
    assert board.busy is False
    begin(bench, board)
    assert board.busy is True
    send_all(bench, board, (0x79,), (0x78,), seconds=0.1)
    assert board.busy is False


# Remote power shutdown


@scripts({
    'Shutdown: not "if the motor is moving"; it acts at the zero velocity of a reversal, and the reversal ends':
    "13 01; cruise 10000 100000; shutdown_in low; 0.01 s; shutdown is low; 32 01; 0.5 s; shutdown is high; at rest",
    "a move that is being calculated is not begun when the motor is shut down":
    "13 01; default 5000 100000; 33 =100; shutdown_in low; 1 s; at 0; shutdown_in high; 33 =100; idle; at 100",
    "Indexer mode: a preset move that is already decelerating to its end still ends on its last pulse":
    "default 10000 100000; 33 =3000; until 8F & FF is FF; 70; idle; at 3000; 81: 0",
    '70h: "deceleration of any motion due to the performance of a move"; in an overshoot it ends the search (1)':
    "1811 motor={'home':(2000,6000)}; default 5000 20000; 38 01 01 14 00; 0F 00 06 01; 39 00; until SB & 1 is 1; "
    "IDB 70; CB 10; idle; mark; at 2601 to 2699; 2 s; moved 0; 82: marked",
    '70h: "deceleration of any motion due to the performance of a move"; in an overshoot it ends the search (2)':
    "1811 motor={'home':(2000,6000)}; default 5000 20000; 38 01 01 14 00; 0F 00 06 01; trigger1 low; 74 01 01 00; "
    "39 00; until SB & 1 is 1; trigger1 high; idle; mark; at 2601 to 2699; 2 s; moved 0; 82: marked",
})  # fmt: skip
def test_remote_power_shutdown(bench, script):
    play(bench, script)


@pytest.mark.parametrize("limit", [False, True])
def test_shutdown_wants_the_motor_to_stand_and_the_input_disabled(bench, board, limit):
    """13h: while the input is enabled, 12h has "no effect", whatever the level of the input."""
    board.pins["shutdown_in"].drive(limit)
    send_all(bench, board, (0x13, 1), (0x12, int(limit)))
    assert board.pins["shutdown"].level is not limit
    send(bench, board, 0x13, 0)
    assert not board.pins["shutdown"].level  # 12h was ignored


# STOP


@pytest.mark.parametrize("opcode", [0x73, 0x77])
@pytest.mark.parametrize(("velocity", "minus", "seconds", "held"), [
    (20_000, 0, 0.05, 15_000), (5_000, 0, 0.025, 7_500), (10_000, 1, 0.05, 5_000), (10_000, 1, 0.15, -5_000)
], ids=["faster", "slower", "reversal, down", "reversal, up"])  # fmt: skip
def test_each_ramp_of_a_continuous_move_can_be_discontinued(bench, board, opcode, velocity, minus, seconds, held):
    """73h: "the velocity being output at the time the command is issued is the last velocity output"."""
    cruise(bench, board)
    send(bench, board, 0x0F, 0, 2, 1)  # user bit 0 shows that a SINGULAR command is performed
    if opcode == 0x77:
        board.pins["trigger1"].drive(False)
        send(bench, board, 0x77, 1, 1, 0)
    default(bench, board, velocity, 100_000)
    send(bench, board, 0x32, minus)
    assert bench.run_until(lambda: ask(bench, board, 0x8D)[1] == 0, 1)  # the ramp has begun
    bench.run(seconds - 0.005)
    assert status_word(bench, board) & 1
    if opcode == 0x77:
        board.pins["trigger1"].drive(True)
    else:
        write(board, 0x73)
    bench.run(0.001_5)
    kept = board.axes["motor"].velocity
    assert kept == pytest.approx(held, abs=700) and not status_word(bench, board) & 1
    bench.run(1)
    assert board.axes["motor"].velocity == kept


# Start/stop velocity


@pytest.mark.parametrize(("start_stop", "first", "then"), [
    (1000, 500, {2000: [500, 1000, 1200, 1400, 1600, 1800, 2000]}),
    (1000, 2000, {500: [2000, 1800, 1600, 1400, 1200, 1000, 500], 800: [500, 800]}),
    *((start_stop, 2000, {3000: [2000, 2200, 2400, 2600, 2800, 3000], 2000: [3000, 2800, 2600, 2400, 2200, 2000]})
      for start_stop in (0, 1000))], ids=["up from below it", "down to below it", "above 0", "above it"])  # fmt: skip
def test_a_continuous_move_ramps_from_or_to_the_start_stop_velocity(bench, board, start_stop, first, then):
    """D6h: "acceleration … is begun at the start/stop velocity": the ramp is 1,000, and 200 more every 2 ms.

    "deceleration ends at the start/stop velocity"; to a velocity below, the indexer will "jump".  Indexer mode: a ramp
    above it is "updated every two milliseconds", and takes no other level.
    """
    send(bench, board, 0xD6, *i32(start_stop))
    default(bench, board, first, 100_000)
    send(bench, board, 0x32, 0, seconds=0.1)
    for velocity, expected in then.items():
        default(bench, board, velocity, 100_000)
        send(bench, board, 0x32, 0)
        assert levels(bench, board, 0.05) == expected


def test_stop_ramps_down_to_the_start_stop_velocity(bench, board):
    """D6h: "deceleration ends at the start/stop velocity"; from this velocity or less, STOP ends the motion at once."""
    send(bench, board, 0xD6, *i32(1000))
    default(bench, board, 2000, 100_000)
    send(bench, board, 0x32, 0, seconds=0.1)
    write(board, 0x70)
    assert levels(bench, board, 0.05) == [1800, 1600, 1400, 1200, 1000, 0]
    for velocity in (1000, 500):
        default(bench, board, velocity, 100_000)
        send(bench, board, 0x32, 0, seconds=0.1)
        assert board.axes["motor"].velocity == velocity
        write(board, 0x70)
        assert levels(bench, board, 0.05) == [0]


def test_a_preset_move_between_start_stop_velocities(bench, board):
    """D6h: the ramps have 2 ms at each of 1,000, 1,200 … 1,800: 14 pulses each; between them the velocity is 2,000."""
    send(bench, board, 0xD6, *i32(1000))
    default(bench, board, 2000, 100_000)
    write(board, 0x33, *i32(228))
    assert levels(bench, board, 0.15)[:13] == [0, 1000, 1200, 1400, 1600, 1800, 2000, 1800, 1600, 1400, 1200, 1000, 0]
    assert board.axes["motor"].position == 228


# Requests


# Lists that are longer than the message queue


@pytest.mark.parametrize("queue", [1, 2, 64])
def test_a_long_sequence_is_listed_to_its_end(bench, queue):
    """92h: "responses are sent as long as there are commands in the sequence buffer", the last is the null command."""
    board = ready(bench, message_queue=queue)
    sequence(bench, board, 1, *((0x01, number) for number in range(100)))
    assert listing(bench, board, 1) == [*(f"92 01 {n:02x}".removesuffix(" 00") for n in range(100)), "92 00"]


# CONTINUE


# Velocities below the resolution


def test_a_velocity_that_rounds_to_zero_is_kept_and_not_performed(bench, board):
    """C8h, range 0: "velocity resolution is 16.667 Hertz": 8 pulses/s rounds to 0, 9 pulses/s to 16.667."""
    for number, velocity in ((1, 8), (2, 9)):
        send(bench, board, *continuous(number, velocity, 100_000))
    send(bench, board, 0x40, 1, seconds=0.5)
    assert board.axes["motor"].velocity == 0 and ask(bench, board, 0x91, 1)[4:8] == bytes(i32(8))
    send(bench, board, 0x40, 2, seconds=0.5)
    assert board.axes["motor"].velocity == pytest.approx(16.667, abs=0.001)


# Details that other tests do not cover


@scripts({
    "a listing leaves the user bits alone: 08h to 0Ah alone set the user bits; 92h discards waiting messages and "
    "leaves the user bits alone": "08 {00|05}; 01 01; 0.01 s; 92 01; says 92 00; SB & 7 is {0|5}",
    '20h: "repeat the following X commands Y times": if fewer than X follow, these are repeated':
    "sequence 1: 01 01, 20 05 00 03, 01 02; 41 01; says 01 01, 01 02, 01 02, 01 02",
    'E3h: 8001h is "a special signal … to go to zero velocity"; EEh: a marker of another mode does not change that':
    "52 01 04 =never #10; EE 80 00 09 02 00; EE 80 01 09 02 00; 53 01 04 =never #100; "
    "distances 100 -32768 -32767; 42; 0.5 s; SB & 7 is 0; at -32668",
})  # fmt: skip
def test_details(bench, script):
    play(bench, script)
