"""Numbers of the manual's examples; the fidelity report lists expected and obtained values."""

from itertools import pairwise

import pytest

from axistwin.core.units import MS

from .programs import enter, free, listing, relative, sequence, steps, velocities
from .talking import ask, complete, default, i32, messages, position, ready, send, send_all, until_idle

PARABOLA_UP = bytes.fromhex(
    "072E 0E11 14A9 1AF7 20F9 26B0 2C1C 313D 3613 3A9E 3EDE 42D3"
    "467D 49DC 4CF0 4FB8 5236 5469 5651 57ED 593F 5A46 5B01 5B72"
)
PARABOLA = [int.from_bytes(PARABOLA_UP[at : at + 2], "big") for at in range(0, len(PARABOLA_UP), 2)]
PARABOLA = [*PARABOLA, 0x5B97, *reversed(PARABOLA)]


def test_the_velocity_of_move_12h(bench, board, printed):
    """G.1: `00 04 00 00` is "Velocity = 262,144 pulses/second"; the resolution of its range is 8.333 pulses/second."""
    send_all(bench, board, (0xCE, 0x12, 0, 0, 4, 0, 0, *i32(10_000_000), 0), (0x40, 0x12), seconds=1)
    printed(
        "G.1 Pre-defined moves", "00 04 00 00, pulses/second", 262_144, float(board.axes["motor"].velocity), within=8.4
    )


def test_a_predefined_move_begins_within_five_milliseconds(bench, board, printed):
    """G.1: "motor motion will begin within five milliseconds of receipt of the command"."""
    send(bench, board, *relative(1, 100_000, 50_000_000, 1_000), seconds=0.1)
    asked_ns = bench.now
    complete(bench, board, 0x40, 1)
    began = (board.axes["motor"].train.moves[-1].start_ns - asked_ns) / MS
    printed("G.1 Pre-defined moves", "from the command to the motion, ms (at most five)", 2.5, began, within=2.5)


def test_fifty_moves_and_fifteen_sequences(bench, board, printed):
    """G.1: "Up to 50 moves may be pre-defined"; G.2: "up to fifteen sequence buffers"."""
    for number in range(1, 61):
        send(bench, board, *relative(number, 1_000, 1_000_000, number))
    kept = [n for n in range(1, 61) if ask(bench, board, 0x91, n)[1:2] == b"\xc8"]
    printed("G.1 Pre-defined moves", "moves that are kept of 60", 50, len(kept))
    for number in range(1, 18):
        sequence(bench, board, number, (0x83,))
    kept = 0
    for number in range(1, 18):
        send(bench, board, 0x41, number, seconds=0.02)
        kept += bool(messages(bench, board))
    printed("G.2 Sequence buffers", "sequences that are kept of 17", 15, kept)


def test_the_sequence_of_the_example(bench, board, printed):
    """G.2: moves 12h and 05, then "fifteen times" move 08, a wait "for two seconds" and a report of the position."""
    for number, distance in ((0x12, 1_000), (0x05, 500), (0x08, 100)):
        send(bench, board, *relative(number, 50_000, 10_000_000, distance))
    commands = (0x40, 0x12), (0x0B, 1), (0x40, 5), (0x0C, 1), (0x20, 3, 0, 0x0F), (0x40, 8), (0x2A, 0, 2), (0x83,)
    send(bench, board, 0x0C, 1)
    sequence(bench, board, 8, *commands)
    assert listing(bench, board, 8) == [f"92 {bytes(command).hex(' ')}" for command in (*commands, (0,))]
    edges = []
    board.pins["output1"].subscribe(lambda pin: edges.append((pin.level, board.axes["motor"].position)))
    send(bench, board, 0x41, 8, seconds=35)
    assert edges == [(True, 1_000), (False, 1_500)]
    found = [m for m in messages(bench, board) if m.startswith("83")]
    printed("G.2 Sequence buffers", "positions that are reported", 15, len(found))
    printed("G.2 Sequence buffers", "where the motor stands, pulses", 3_000, position(bench, board))
    waits = [after - before for before, after in pairwise(steps(board)) if after - before > 1_000 * MS]
    # between two moves the second one is also calculated and started: some milliseconds
    printed("G.2 Sequence buffers", "the shortest of the waits, s", 2, min(waits) / 1e9, within=0.05)


def test_five_with_and_without_zeros(bench, board, printed):
    """F: "perform move number 5" as 40 05, and as 40 05 filled up with zeros, has "the same result"."""
    send(bench, board, *relative(5, 10_000, 1_000_000, 321))
    moved = []
    for surplus in (0, 14):
        complete(bench, board, 0x40, 5, *(0,) * surplus)
        moved.append(position(bench, board, 0x80))
    printed("F Command language syntax", "40 05 and 40 05 00 ... 00: pulses", [321, 321], moved)


def test_the_worked_parabola(bench, board, printed):
    """E.1.b: 50 pairs "at two milliseconds per pair, that gives us 100 milliseconds", "about 25,000 steps"."""
    assert len(PARABOLA) == 49
    enter(bench, board, 0x52, 1, 4, alarm=0, rate=2)
    printed("E.1.b Velocity-streaming mode", "E2: free bytes, about 600", 600, free(bench, board))
    velocities(bench, board, *PARABOLA, *[0] * 7)
    complete(bench, board, 0x42)
    at = steps(board)
    printed(
        "E.1.b Velocity-streaming mode", "from the first pulse to the last, ms", 100, (at[-1] - at[0]) / MS, within=4
    )
    # 25,000 steps and 375,632 Hz in the text need a clock of 1.05 MHz; 4.3690667 MHz / 4 gives 26,041 and 390,783
    printed("E.1.b Velocity-streaming mode", "steps at 4.3690667 MHz / 4, for 'about 25,000'", 26_041, len(at))
    top = 1e9 * 20 / (at[len(at) // 2 + 10] - at[len(at) // 2 - 10])
    printed(
        "E.1.b Velocity-streaming mode", "5B97h at that clock, Hz, for '375.632 Khz'", 390_783, round(top), within=40
    )
    printed("E.1.b Velocity-streaming mode", "the message begins with", "52", messages(bench, board)[0][:2])


def test_a_bogus_velocity_sets_status_bit_three(bench, board, printed):
    """E.1.b: EE FF FF 09 02 00: "set user status bit number three each time the velocity FF FF is encountered"."""
    enter(bench, board, 0x52, 1, 4, rate=2)
    send(bench, board, 0xEE, 0xFF, 0xFF, 0x09, 0x02, 0x00)
    before = board.bus.read(1) & 7
    velocities(bench, board, 0x0100, 0xFFFF, 0x0100, 0, 0, 0, 0)
    complete(bench, board, 0x42)
    found = [before, board.bus.read(1) & 7]
    printed("E.1.b Bogus velocity values", "user bits before and after FF FF", [0, 4], found)


def test_user_bit_one_tells_that_the_motor_moves(bench, board, printed):
    """0Fh: "OF O1 O1 FF": bit one is set when the motor is moving and clear when it is not."""
    send(bench, board, 0x0F, 0x01, 0x01, 0xFF)
    default(bench, board, 1_000, 1_000_000)
    found = [board.bus.read(1) & 2]
    send(bench, board, 0x33, *i32(1_000), seconds=0.1)
    found.append(board.bus.read(1) & 2)
    until_idle(bench, board)
    found.append(board.bus.read(1) & 2)
    printed("0Fh Show state", "0F 01 01 FF: bit 1 before, during and after a move", [0, 2, 0], found)


def test_user_bits_five(bench, board, printed):
    """08h: "the three user defined status bits ... will reflect the parameter byte"."""
    found = []
    for bits in range(8):
        send(bench, board, 0x08, bits)
        found.append(board.bus.read(1) & 7)
    printed("08h Write user bits", "SB bits 0 to 2 for 00 to 07", list(range(8)), found)


@pytest.mark.parametrize(("model", "seconds"), [("1810", 1.0), ("1811", 1.0)])
def test_power_up_takes_about_one_second(bench, printed, model, seconds):
    """Status byte: initialisation takes "about one second"."""
    board = bench.add(model)
    assert bench.run_until(lambda: board.bus.read(1) == 0x50, 2)
    printed("Status byte", f"{model}: seconds from power-up to 50h", seconds, bench.seconds, within=0.01)


def test_a_standard_revolution_in_100_ms(bench, printed):
    """E.1.b: one revolution of 25,000 pulses in 100 ms "requires an average acceleration of 400 revolutions per second
    squared, and a maximum velocity of 20 revolutions per second".
    """
    board = ready(bench)
    default(bench, board, 20 * 25_000, 400 * 25_000)
    complete(bench, board, 0x33, *i32(25_000))
    at = steps(board)
    printed("E.1.b Velocity-streaming mode", "25,000 pulses at 400 rev/s²: ms", 100, (at[-1] - at[0]) / MS, within=4)
