"""Chapter Velocity-streaming mode: the buffer and its alarm, markers, an empty buffer, stops, and reports meanwhile."""

from fractions import Fraction

import pytest

from axistwin.core.units import MS

from ..scripts import scripts
from .programs import accumulated, distances, enter, free, pairs, steps, velocities, words
from .scripts import play
from .talking import ask, in_all_ways, message, messages, position, ready, send, status_word, until_idle

USER_BIT_0 = 0x01


def moving_at(board, rate):
    return board.axes["motor"].velocity == rate


# Room


@pytest.mark.parametrize(("mode", "put", "bytes_each"), [
    (0x51, lambda bench, board: pairs(bench, board, (1, 9), (1, 9), (1, 9)), 12),
    (0x52, lambda bench, board: velocities(bench, board, *[1] * 7), 14),
    (0x53, lambda bench, board: distances(bench, board, *[1] * 7), 14)])  # fmt: skip
def test_data_need_fifteen_free_bytes(bench, board, mode, put, bytes_each):
    enter(bench, board, mode, 1, 1, rate=None if mode == 0x51 else 2)
    left = 600
    while left >= 15:
        assert free(bench, board) == left
        put(bench, board)
        left -= bytes_each
    put(bench, board)
    assert free(bench, board) == left == 12


@scripts({
    "fourteen free bytes are too few and fifteen enough":
    "1811 {buffer_bytes=28|buffer_bytes=29}; 52 01 01 =never #2; velocities 1 1 1 1 1 1 1 1 1 1 1 1 1 1; E2: {14|"
    "1}",
    "an empty buffer is not performed": "0F 00 04 01; 52 01 01 =never #2; 42; SB & 1 is 0",
    "a marker among pairs and among distances":
    "51 03 01 =never; EE #77 01 05 00; pairs 1500 10 77 1000 0 0; 42; idle; at 10; 53 03 01 =never #10; "
    "EE #32769 01 06 00; EE #32768 01 06 00; distances 10 77 10 32769 77; 42; idle; at 30; says 01 05, 01 05",
    "what a velocity leads to at once may end the performance: a stall is detected when the zero velocity is "
    "output, after 3 ms at 3,500 pulses/s: ten pulses, one tooth":
    "1811 motor={'encoder':{'counts_per_rev':400}}; B0 00 01 00 01; B1 00 00 01 90; B2 00 00 00 00; "
    "B4 00 00 00 32; 19 01; 52 03 01 =never #3; velocities 5250 0 5250; jam; 42; 1 s; at rest; E2: 590",
})  # fmt: skip
def test_room(bench, script):
    play(bench, script)


# Alarm


def test_the_alarm_comes_once_when_the_bytes_left_are_down_to_its_value(bench, board):
    """56 bytes are 28 values, one each 20 ms: 20 bytes are left when the 18th is taken, 340 ms after the first."""
    enter(bench, board, 0x52, 1, 1, alarm=20, rate=20)
    velocities(bench, board, *range(100, 128))
    send(bench, board, 0x42)
    assert bench.run_until(lambda: board.axes["motor"].velocity > 0, 1)
    began = bench.now
    alarm = bytes([0x52, 1, 1, 0, 0, 0, 20, 0, 20]).ljust(16, b"\0")
    assert message(bench, board, 1) == alarm and bench.now - began == 340 * MS
    assert free(bench, board) == 600 - 20 and message(bench, board, 1) == b""


@scripts({
    "no alarm unless the buffer has held more":
    "52 01 01 =14 #2; velocities 9 9 9 9 9 9 9; 42; 0.1 s; says nothing; velocities 9 9 9 9 9 9 9 9 9 9 9 9 9 9; "
    "42; 0.1 s; says 52 01 01 00 00 00 0E 00 02; velocities 9 9 9 9 9 9 9 9 9 9 9 9 9 9; 42; 0.1 s; "
    "says 52 01 01 00 00 00 0E 00 02",
    "no alarm for a value above the buffer nor for a killed one":
    "51 03 01 =65535; pairs 1500 10 1500 10 0 0; 42; 0.2 s; 51 03 01 =4; pairs 1500 10 1500 10 0 0; 7B; 0.2 s; "
    "says nothing; E2: 600",
    "the alarm of pairs and of distances":
    "51 03 02 =0; pairs 1500 10 1500 10 0 0; 42; idle; says 51 03 02; 53 03 02 =0 #3; distances 5 32769; 42; "
    "idle; says 53 03 02 00 00 00 00 00 03",
})  # fmt: skip
def test_alarm(bench, script):
    play(bench, script)


# Running dry


@pytest.mark.parametrize("mode", [0x51, 0x52, 0x53])
def test_when_it_runs_dry_the_motor_stays_at_its_velocity_until_it_is_performed_again(bench, board, mode):
    put = {
        0x51: lambda rate: pairs(bench, board, (1_500, 10), (1_500, 10), (rate * 3 // 2, 10)),
        0x52: lambda rate: velocities(bench, board, 1_500, rate * 3 // 2),
        0x53: lambda rate: distances(bench, board, 10, rate // 100),
    }[mode]
    send(bench, board, 0x0F, 0, 4, 1)
    enter(bench, board, mode, 3, 1, rate=None if mode == 0x51 else 10)
    put(2_000)
    send(bench, board, 0x42)
    assert board.bus.read(1) & USER_BIT_0  # performing
    bench.run(2)
    assert moving_at(board, 2_000) and not board.bus.read(1) & USER_BIT_0
    assert ask(bench, board, 0x8D)[1] == 0xFF  # 8Dh is valid only when no stream is performed
    put(4_000)
    bench.run(2)
    assert moving_at(board, 2_000)
    send(bench, board, 0x42, seconds=2)
    assert moving_at(board, 4_000)
    send(bench, board, 0x78)
    assert moving_at(board, 0)


# Stops


@scripts({
    "stop and kill end the pulses and the performance at once":
    "52 03 01 =never #100; velocities 1500 1500 1500 1500 1500 1500 1500; 42; 0.25 s; {70|78}; at rest; 1 s; "
    "at rest; E2: 592; 42; 1 s; velocity 1000",
    "kill of the buffer keeps the velocity and empties it":
    "52 03 01 =never #100; velocities 1500 3000 4500; 42; 0.15 s; 7B; 1 s; velocity 2000; E2: 600; "
    "velocities 1500 0; 42; 0.05 s; velocity 1000; 1 s; at rest",
    "a limit ends the stream and lets only the other direction begin":
    "1811 motor={'limits':(-10000,50)}; 52 03 01 =never #100; velocities 1500 1500 1500 1500 1500 1500 0; 42; "
    "1 s; at 51; E2: 588; 42; 0.1 s; at 51; 7B; velocities 34268 0; 42; idle; at -49",
})  # fmt: skip
def test_stops(bench, script):
    play(bench, script)


def test_a_trigger_kills_the_buffer_with_a_message(bench, board):
    board.pins["trigger6"].drive(False)
    enter(bench, board, 0x52, 3, 1, rate=100)
    send(bench, board, 0x7F, 6, 1, 1)
    velocities(bench, board, 1_500, 3_000, 4_500)
    send(bench, board, 0x42, seconds=0.15)
    board.pins["trigger6"].drive(True)
    bench.run(1)
    assert moving_at(board, 2_000)
    assert free(bench, board) == 600 if not (found := messages(bench, board)) else found == ["7f 06"]


# Markers


def performed(bench, board, *numbers, rate=10):
    enter(bench, board, 0x52, 3, 1, rate=rate)
    velocities(bench, board, *numbers)
    send(bench, board, 0x42)
    assert bench.run_until(lambda: board.axes["motor"].velocity != 0, 1)
    return bench.now


def marker(bench, board, word, opcode, first=0, second=0):
    send(bench, board, 0xEE, *words(word), opcode, first, second)


def test_a_marker_takes_no_time_and_its_command_three_milliseconds(bench, board):
    send(bench, board, 0x0C, 1)
    enter(bench, board, 0x52, 3, 1, rate=10)
    marker(bench, board, 0xFFFF, 0x0B, 1)
    began = performed(bench, board, 1_500, 1_500, 0xFFFF, 3_000, 0)
    assert bench.run_until(lambda: board.pins["output1"].level, 1) and bench.now - began == 23 * MS
    assert moving_at(board, 2_000)
    until_idle(bench, board)
    assert board.axes["motor"].position == 40


NO_MARKERS = {
    "three parameters are missing": (0x7C, 1, 1), "invalid while the buffer is performed": (0x86,),
    "invalid in a streaming mode": (0x41, 1), "undefined": (0x07,), "there is no output 3": (0x0B, 3),
    "with a surplus byte": (0x0B, 1, 1),
}  # fmt: skip
MARKERS = {
    "a report": (20, [(0x7FFF, 0x84)], (0x8000 | 1_500, 0x7FFF, 0x8000 | 1_500, 0), ["84 ff"], -40),
    "the last one in a row counts, and the end of the stream": (
        10, [(0x7FF0 + n, 0x01, n) for n in (1, 2, 3)], (1_500, 0x7FF1, 0x7FF2, 1_500, 0, 0x7FF1, 0x7FF3),
        ["01 02", "01 03"], 20),
    "the null command deletes a marker": (10, [(1_500, 0x01, 7), (1_500, 0x00)], (1_500, 0), [], 10),
    "ten and no more: 1,510 is a velocity": (
        10, [(1_500 + n, 0x01, n) for n in range(11)], (1_508, 1_510, 1_509, 0), ["01 08", "01 09"], 10),
    **{name: (10, [(1_500, *command)], (1_500, 0), [], 10) for name, command in NO_MARKERS.items()},
}  # fmt: skip
"""Rate, definitions of markers, stream, messages, final position; 1,500 are 10 pulses at rate 10, and 20 at rate 20."""


@pytest.mark.parametrize(("rate", "defined", "stream", "sent", "ends_at"), MARKERS.values(), ids=MARKERS)
def test_markers_in_a_stream(bench, board, rate, defined, stream, sent, ends_at):
    enter(bench, board, 0x52, 3, 1, rate=rate)
    for definition in defined:
        marker(bench, board, *definition)
    performed(bench, board, *stream, rate=rate)
    until_idle(bench, board)
    assert (messages(bench, board), board.axes["motor"].position) == (sent, ends_at)


@pytest.mark.parametrize(("rate", "seen"), [(2, ["01 01"]), (4, ["01 01", "01 02"])])
def test_a_marker_met_while_another_is_executed_is_lost(bench, board, rate, seen):
    enter(bench, board, 0x52, 3, 1, rate=rate)
    for number in (1, 2):
        marker(bench, board, 0x7FF0 + number, 0x08, 0)
        marker(bench, board, 0x7FF0 + number, 0x01, number)  # the marker is defined again
    performed(bench, board, 1_500, 0x7FF1, 1_500, 0x7FF2, 1_500, 0, 0, rate=rate)
    until_idle(bench, board)
    assert messages(bench, board)[: len(seen) + 1] == seen


# Reports


def test_reports_while_streaming(bench, board):
    enter(bench, board, 0x52, 3, 1, rate=200)
    velocities(bench, board, 1_500, 3_000, 3_000, 1_500, 0)
    send(bench, board, 0x42, seconds=0.1)
    reports = {opcode: ask(bench, board, opcode) for opcode in (0x80, 0x81, 0x82, 0x83, 0x84, 0x8C)}
    at = [int.from_bytes(reports[opcode][1:size], "big") for opcode, size in ((0x80, 5), (0x82, 7), (0x83, 7))]
    assert 90 < at[0] < at[1] < at[2] < 140
    assert reports[0x81] == b"\x81".ljust(16, b"\0") and reports[0x84][1] == 0
    assert reports[0x8C][1] == 0xFF
    send(bench, board, 0x86)  # ignored while the buffer is performed
    statuses = []
    bench.run(0.1)
    for _ in range(3):
        statuses.append(ask(bench, board, 0x88)[1] & 0xF8)
        bench.run(0.2)
    assert statuses == [0x50, 0x30, 0x90]  # moving, and: accelerating, constant, decelerating
    bench.run(0.2)
    assert ask(bench, board, 0x88)[1] & 0xF8 == 0
    assert position(bench, board, 0x80) == board.axes["motor"].position == 1_200


# Several velocities in one run


RISING, FALLING, BACK = range(600, 660), range(660, 600, -1), range(0x8000 + 300, 0x8000 + 340)


@pytest.mark.parametrize("limits", [{}, {"limits": (-10_000, 10_000)}])
@in_all_ways(0.4, 0.001, 400)
def test_a_stream_is_the_same_however_it_is_run(bench, run, limits):
    """Velocity number 1 is 5/3 pulses/s: 1,310,720/3 Hz, divided by 4, over 65,536.  The marker sets user bit 0."""
    board = ready(bench, motor=limits)
    enter(bench, board, 0x52, 2, 4, alarm=100, rate=2)
    send(bench, board, 0xEE, 0xFF, 0xFF, 0x09, 0x00, 0x00)
    velocities(bench, board, *RISING, 0xFFFF, *FALLING, *BACK, *[0] * 7)
    send(bench, board, 0x42)
    run(bench)

    moves = board.axes["motor"].train.moves
    there_ns = moves[1].start_ns
    back_ns = there_ns + 120 * 2 * MS
    there, back = ([Fraction(5, 3) * (v % 0x8000) for v in part] for part in ((*RISING, *FALLING), BACK))
    assert steps(board) == accumulated(there, there_ns, 2 * MS) + accumulated(back, back_ns, 2 * MS)
    # 16 velocities, then a new move with the next 16: 120 CW, 40 CCW
    begins = [there_ns + n * 16 * 2 * MS for n in range(8)] + [back_ns + n * 16 * 2 * MS for n in range(3)]
    assert [move.start_ns for move in list(moves)[1:]] == begins
    assert messages(bench, board) == ["52 02 04 00 00 00 64 00 02"] and status_word(bench, board) & USER_BIT_0
    assert free(bench, board) == 600


def test_the_alarm_comes_with_its_velocity_in_a_long_run(bench):
    """60 velocities are 126 bytes with the rest of the last command; 100 bytes are left as the 13th begins."""
    board = ready(bench)
    enter(bench, board, 0x52, 2, 4, alarm=100, rate=2)
    velocities(bench, board, *RISING)
    times: list[int] = []
    board.bus.subscribe_received(lambda message: times.append(bench.now))
    send(bench, board, 0x42, seconds=1)
    assert times == [board.axes["motor"].train.moves[1].start_ns + 12 * 2 * MS]
