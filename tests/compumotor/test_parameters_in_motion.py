"""Addendum: parameters that are defined during a move, or during a position error, take effect at once."""

import pytest

from ..scripts import scripts
from .programs import ALL, AT_ONCE, LAW, RATIO, RESOLUTION, SIGMA, TEETH, number
from .scripts import play
from .talking import complete, default, i32, messages, position, ready, send, send_all


def machine(bench, *commands):
    """Return an 1811 after these commands; a revolution is 25,000 motor pulses or 4,000 encoder counts."""
    board = ready(bench, motor={"encoder": {"counts_per_rev": 4000, "pulses_per_rev": 25_000}})
    for command in commands:
        send(bench, board, *command)
    default(bench, board, 5_000, AT_ONCE)
    return board


@pytest.mark.parametrize("last", [RATIO, RESOLUTION, SIGMA, TEETH], ids=["B0", "B1", "B2", "B4"])
@pytest.mark.parametrize("termination", [0, 1])
def test_a_stall_is_watched_for_as_soon_as_all_four_are_defined(bench, last, termination):
    """19h: "after the motor to encoder resolution, the motor resolution, the backlash sigma, and the number of rotor
    teeth have been defined the indexer will watch for stall detect on ALL moves"; one tooth is 500 pulses, 100 ms.
    """
    board = machine(bench, *(command for command in (RATIO, RESOLUTION, SIGMA, TEETH) if command is not last))
    send_all(bench, board, (0xA6, 1), (0x19, termination))
    board.axes["motor"].jam()
    send(bench, board, 0x33, *i32(2_000))
    bench.run(0.2)  # stalled for more than a tooth, but not yet detected
    assert board.axes["motor"].velocity
    send(bench, board, *last, seconds=0.002_1)
    assert (board.axes["motor"].velocity == 0) is bool(termination) and messages(bench, board) == ["a6 00"]


@pytest.mark.parametrize("last", [RATIO, LAW, (0x18, 1)], ids=["B0", "B3", "18"])
def test_an_error_is_corrected_as_soon_as_all_is_defined(bench, last):
    """B3h: "No position maintenance will be performed until all of these parameters have been supplied"."""
    board = machine(bench, *(command for command in (RATIO, LAW, (0x18, 1)) if command is not last))
    board.axes["motor"].encoder.displace(10)
    bench.run(0.1)
    assert number(bench, board, 0x99) == -10
    complete(bench, board, *last)
    assert number(bench, board, 0x99) == 0


@scripts({
    # "if 0 is chosen no correction will take place"
    'B3h: "These parameters may be changed at any time", also in a correction: K is 10, then 20 (× 100 counts)':
    "tracked; jam; 18 01; B3 01 0A 00 =50000; displace -100; 0.01 s; velocity 1000; B3 01 14 00 =50000; 0.01 s; "
    "velocity 2000; B3 01 00 00 =50000; 0.01 s; at rest",
    'Reset: "encoder counts are zero"; after a power cycle each push is counted once, not twice':
    "tracked; power cycle; 1.01 s; displace 7; 9A: 7; power off; displace 7; power on; 1.01 s; 9A: 0",
    'B5h: "whenever the encoder is within 5 encoder pulses": with an error of 5 this is true; within 4 it is false':
    "tracked; 0F 00 80 01; displace 5; B5 FF FF 00 05; SB & 1 is 1; B5 FF FF 00 04; SB & 1 is 0; B5 FF FF FF FF; "
    "SB & 1 is 1; B5 FF FF 00 00; SB & 1 is 0; displace -5; SB & 1 is 1",
})  # fmt: skip
def test_parameters_in_motion(bench, script):
    play(bench, script)


@pytest.mark.parametrize(("counts", "pulses"), [(1, 1), (-1, -1), (3, 2), (-3, -2), (2, 1), (-2, -1)])
def test_half_a_motor_pulse_goes_away_from_where_the_move_begins(bench, counts, pulses):
    """B0h: one motor pulse is two encoder pulses; an odd number is rounded up to a whole motor pulse."""
    board = machine(bench, *ALL, (0xB0, 0, 1, 0, 2))
    complete(bench, board, 0x35, *i32(counts))
    assert position(bench, board) == pulses
