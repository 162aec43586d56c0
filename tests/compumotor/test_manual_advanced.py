"""Manual, chapter Programming: E.1.a Indexer mode, G Advanced features (pre-defined moves, sequences, move zero)."""

from itertools import pairwise

import pytest

from axistwin.units import MS

from ..scripts import scripts
from .programs import about, listing, relative, sequence, steps
from .scripts import play
from .talking import ask, complete, default, i32, messages, position, send, send_all, until_idle

EXAMPLE = (0xC8, 0x12, 0x00, 0x00, 0x04, 0x00, 0x00)
"""G.1: move 12h, ranges 00, 262,144 pulses/second; the acceleration and the distance are lost in print."""


def test_the_move_of_the_example(bench, board):
    """G.1: `00 04 00 00` is 262,144 pulses/second.

    With 2,621,440 pps² and 50,000 pulses each ramp takes 0.1 s and 13,107 pulses; the rest, 23,786 pulses, takes
    0.0907 s: 0.2907 s in all.
    """
    send_all(bench, board, (*EXAMPLE, *i32(2_621_440), *i32(50_000)), (0x40, 0x12))
    assert bench.run_until(lambda: ask(bench, board, 0x8D)[1] == 0xFF, 1)
    assert ask(bench, board, 0x85)[:6] == bytes([0x85, 0, 0, 4, 0, 0])
    assert board.axes["motor"].velocity == pytest.approx(262_144, rel=1e-4)  # "+/- 0.01% of set rate"
    until_idle(bench, board)
    times = steps(board)
    assert len(times) == 50_000 == board.axes["motor"].position
    assert about(0.2907, times[-1] - times[0])


def test_a_predefined_move_is_under_way_within_five_milliseconds(bench, board):
    """G.1: "motor motion will begin within five milliseconds of receipt of the command"."""
    send(bench, board, *relative(1, 10_000, 0x7FFF_FFFF, 100), seconds=0.1)
    assert ask(bench, board, 0x93)[1] == 0xFF
    asked = bench.now
    complete(bench, board, 0x40, 1)
    # the first pulse comes one period, 0.1 ms, after the beginning
    assert steps(board)[0] - asked <= 5 * MS + 100_000


def test_a_move_that_is_not_calculated_is_under_way_within_half_of_thirty_milliseconds(bench, board):
    """G.1: "it can do it in less than half that time" of 30 ms."""
    send(bench, board, *relative(1, 10_000, 0x7FFF_FFFF, 100))
    asked = bench.now
    complete(bench, board, 0x40, 1)
    assert steps(board)[0] - asked <= 15 * MS + 100_000


@scripts(
    {
        'G.1: "They will still be there when the indexer is returned to indexer mode"; sequences are lost (E.1.b)':
        "relative 9 10000 100000 700; sequence 1: 40 09; 51 01 04 00 00 00 00; 90 -> 51 01 04; 40 09; 0.5 s; "
        "pulses 0 -- inaccessible in that mode; 50; 41 01; 0.5 s; pulses 0 -- the sequence is lost; 40 09; idle; "
        "at 700",
        'G.3: 33 and 34 "are the only preset moves which may be executed while in velocity streaming mode"':
        "52 01 04 00 00 00 00 00 02; default 10000 100000; 33 =-400; idle; 34 =50; idle; 32 00; 0.5 s; at 50",
        "a continuous move goes on until killed stopped or at a limit (1)":
        "cruise 10000 100000; 20 s; velocity 10000; {70|78}; 0.2 s; at rest",
        "a continuous move goes on until killed stopped or at a limit (2)":
        "cruise 10000 100000; 20 s; velocity 10000; cw_limit high; 0.2 s; at rest",
        'E.1.a: ramps "may be respecified for each change in velocity of a constant velocity move"':
        "continuous 1 10000 100000; continuous 2 20000 1000000; continuous 3 5000 50000; 0.2 s; 40 01; clock; "
        "until velocity 10000; 92 to 108 ms later; 0.02 s; 40 02; clock; until velocity 20000; 2 to 18 ms later; "
        "0.02 s; 40 03; clock; until velocity 5000; 292 to 308 ms later; 0.02 s",
        'G.3: "Unfortunately, move zero cannot be called by the "Perform move X" command"':
        "default 10000 100000; 40 00; 0.5 s; pulses 0; 33 =400; idle; 34 =-100; idle; at -100; steps 900",
    }
)  # fmt: skip
def test_moves_and_sequences(bench, script):
    play(bench, script)


def test_the_sequence_of_the_example(bench, board):
    """G.2: moves 12h and 05 with an output set between them; then fifteen times move 08, two seconds, and a report.

    The positions are 1,000 + 500, and 100 more before each report: 1,600 to 3,000.
    """
    send_all(bench, board, relative(0x12, 10_000, 100_000, 1_000), relative(0x05, 10_000, 100_000, 500))
    send_all(bench, board, relative(0x08, 10_000, 100_000, 100), (0x0C, 1))
    edges = []
    board.pins["output1"].subscribe(lambda pin: edges.append((pin.level, board.axes["motor"].position)))
    sequence(
        bench, board, 8,
        (0x40, 0x12), (0x0B, 1), (0x40, 0x05), (0x0C, 1), (0x20, 3, 0, 15), (0x40, 0x08), (0x2A, 0, 2), (0x83,),
    )  # fmt: skip
    assert listing(bench, board, 8) == [
        "92 40 12", "92 0b 01", "92 40 05", "92 0c 01", "92 20 03 00 0f", "92 40 08", "92 2a 00 02", "92 83", "92 00",
    ]  # fmt: skip
    send(bench, board, 0x41, 8, seconds=15 * 2.2 + 2)
    assert edges == [(True, 1_000), (False, 1_500)]
    found = messages(bench, board)
    assert [int.from_bytes(bytes.fromhex(m)[1:7].ljust(6, b"\0"), "big") for m in found] == list(
        range(1_600, 3_100, 100)
    )
    assert {m[:2] for m in found} == {"83"}
    ends = [t for t, u in zip(steps(board), [*steps(board)[1:], 10**12], strict=True) if u - t > 1_000 * MS]
    waits = [b - a for a, b in pairwise(ends)]
    assert len(waits) == 14
    # two seconds, and a triangle of 2·√(100 / 100,000) = 63 ms
    assert all(about(2.063, w, 15) for w in waits)


def test_fifteen_sequences_share_about_six_hundred_bytes(bench, board):
    """G.2: "up to fifteen sequence buffers", "about 600 decimal bytes long"; deleting one by DAh makes room."""

    def free():
        data = ask(bench, board, 0xE2)
        assert data[:3] == b"\xe2\0\0"
        return int.from_bytes(data[3:5], "big")

    empty = free()
    assert empty == pytest.approx(600, abs=30)
    for number in range(1, 16):
        sequence(bench, board, number, (0x0B, 1 + number % 2))
    used = empty - free()
    assert used >= 15 * 2
    for number in range(1, 16):
        assert listing(bench, board, number) == [f"92 0b {1 + number % 2:02x}", "92 00"]
    for number in range(1, 16):
        send(bench, board, 0xDA, number)
    assert free() == empty
    sequence(bench, board, 16, (0x09, 0))
    assert free() == empty


@pytest.mark.parametrize(("distance", "seconds"), [(25_000, 0.35), (-25_000, 0.35), (10_000, 0.2), (4_000, 0.1265)])
def test_trapezoids_and_triangles(bench, board, distance, seconds):
    """E.1.a: a move has three parts, or no constant part if its velocity is not reached.

    At 100,000 pps and 1,000,000 pps² a ramp takes 0.1 s and 5,000 pulses, so 10,000 pulses are the last triangle;
    4,000 take 2·√(4,000/1,000,000) = 0.1265 s.
    """
    default(bench, board, 100_000, 1_000_000)
    complete(bench, board, 0x33, *i32(distance))
    times = steps(board)
    assert len(times) == abs(distance)
    assert board.axes["motor"].position == distance, "no overshoot or creeping"
    # a ramp's first pulse comes √(2/a) = 1.4 ms late
    assert about(seconds, times[-1] - times[0], 6)


def test_the_ramp_is_updated_every_two_milliseconds(bench, board):
    """E.1.a: at 100,000 pps² the velocity changes by 200 pps every 2 ms."""
    default(bench, board, 10_000, 100_000)
    send(bench, board, 0x32, 0)
    assert bench.run_until(lambda: board.axes["motor"].velocity, 0.1)
    began = bench.now
    seen = []
    for _ in range(60):
        seen.append(board.axes["motor"].velocity)
        bench.run(0.002)
    assert bench.now - began == 120 * MS
    changes = [b - a for a, b in pairwise(seen) if b != a]
    assert changes == pytest.approx([200] * len(changes), abs=17)  # within the resolution, 16.667 Hz
    assert 48 <= len(changes) <= 50


def test_the_start_stop_velocity(bench, board):
    """Command D6h: a slower move jumps to its velocity; a faster one ramps from the start/stop velocity."""
    send(bench, board, 0xD6, *i32(5_000))
    motor = board.axes["motor"]
    seen = set()
    motor.on_motion.subscribe(lambda *_: seen.add(motor.velocity))
    default(bench, board, 3_000, 100)
    complete(bench, board, 0x33, *i32(300))
    times = steps(board)
    assert {b - a for a, b in pairwise(times)} <= {333_333, 333_334}
    start = bench.now
    default(bench, board, 10_000, 100_000)
    complete(bench, board, 0x33, *i32(2_000))
    times = steps(board, start)
    periods = [b - a for a, b in pairwise(times)]
    assert max(periods) <= 200_001, "never slower than 5,000 pps"
    assert position(bench, board) == 2_300
    # two ramps of 50 ms (375 pulses each), 125 ms between
    assert about(0.225, times[-1] - times[0])
