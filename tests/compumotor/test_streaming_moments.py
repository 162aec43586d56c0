"""Streaming: its start, the width of its pulses, and a loss of power while a stream is performed."""

import pytest

from axistwin import Bench
from axistwin.core.units import MS

from ..scripts import scripts
from .programs import distances, enter, pairs, velocities
from .scripts import play
from .talking import CONTROL, RESET, ready, send, write

MODES = {
    0x51: lambda bench, board: pairs(bench, board, (0x1000, 500), (0x2000, 500), (0x1000, 500)),
    0x52: lambda bench, board: velocities(bench, board, 0x1000, 0x2000, 0x1000, 0x2000, 0x1000, 0x2000, 0x1000),
    0x53: lambda bench, board: distances(bench, board, 500, 1000, 500, 1000, 500, 1000, 500),
}


def streaming(bench, board, mode, **options):
    enter(bench, board, mode, 1, 16, rate=None if mode == 0x51 else 10, **options)
    MODES[mode](bench, board)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("start_ms", [3, 0, 20])
def test_the_first_velocity_comes_as_a_calculated_move_does(bench, mode, start_ms):
    """Pre-defined moves: "within five milliseconds of receipt": 1 ms to read the command, and 3 ms to begin."""
    board = ready(bench, start_ms=start_ms)
    streaming(bench, board, mode)
    written = bench.now
    write(board, 0x42)
    assert bench.run_until(lambda: board.axes["motor"].velocity, 1) and bench.now - written == (1 + start_ms) * MS


def slowly_streaming(mode, divisor):
    """Return a new bench and a board that has begun to stream few pulses."""
    bench = Bench()
    board = ready(bench)
    enter(bench, board, mode, 1, divisor, rate=100)
    velocities(bench, board, 16) if mode == 0x52 else distances(bench, board, 50)
    send(bench, board, 0x42, seconds=0.05)
    return bench, board


@pytest.mark.parametrize(("divisor", "width_ns"), [(1, 228), (4, 915), (16, 3_662)])
@pytest.mark.parametrize("mode", [0x52, 0x53])
def test_a_pulse_is_half_a_period_of_the_highest_frequency_wide(mode, divisor, width_ns):
    """STEP: "always one half the period of the maximum frequency out", which is half of the effective clock: 229 ns
    wide at 2.18 MHz, 1/273,067 s wide at 4.369 MHz/16.
    """
    bench, board = slowly_streaming(mode, divisor)
    begin = bench.now
    bench.run(0.3)
    rise = next(int(at_ns) for at_ns in board.axes["motor"].pulse_times() if at_ns > begin)
    bench, board = slowly_streaming(mode, divisor)  # the same run again, up to the known pulse
    bench.clock.run_to(rise - 1)
    assert not board.pins["step"].level
    bench.clock.run_to(rise + width_ns - 2)
    assert board.pins["step"].level
    bench.clock.run_to(rise + width_ns + 2)
    assert not board.pins["step"].level


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("way", ["power", "reset", "test"])
def test_a_stream_does_not_outlive_its_board(bench, board, mode, way):
    """Control byte: reset is "equivalent to cycling power"; S1: it "will stop whatever it is doing"."""
    streaming(bench, board, mode)
    send(bench, board, 0x42, seconds=0.005)
    assert board.axes["motor"].velocity
    if way == "test":
        send(bench, board, 0xFF, seconds=10.1)
        assert len(board.axes["motor"].pulse_times(bench.now - 10_050 * MS)) == pytest.approx(50_000, abs=300)
        return
    if way == "power":
        board.power(False)
    else:
        board.bus.write(CONTROL, RESET)
    stands = board.axes["motor"].position
    bench.run(2)
    assert board.axes["motor"].position == stands


@scripts({
    'EEh: a command takes "two to four milliseconds to execute"; a reset within this time prevents it':
    "52 01 10 =never #10; EE FF FF 09 02 00; EE FF FE 94 00 00; velocities 65534 4096 65535 8192 4096 0 0; 42; "
    "until moving; {0.001|0.002} s; CB 20; 1.1 s; SB 50; says nothing; 90 -> 50",
})  # fmt: skip
def test_moments_of_a_stream(bench, script):
    play(bench, script)
