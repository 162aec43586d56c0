"""Addendum for position tracking: position maintenance (18h, B3h), deadband (B5h); machines with play, and pushed ones.

Expected velocities are multiples of 16.67 pps, the resolution of range 0.
"""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench
from axistwin.bench import Controller
from axistwin.core.units import MS

from ..scripts import scripts
from .programs import number, start, tracked
from .scripts import play
from .talking import default, i32, position, ready, send, send_all

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


@scripts({
    "k is in units of the velocity range: in range 1 the unit is 0.1 pps, so 20 × 100 units are 200 pps, and the "
    "maximum of 1,500 units is 150 pps":
    "tracked; 18 01; B3 01 14 10 =50000; displace -100; 0.0021 s; velocity about 200; B3 01 14 1F =1500; 0.002 s; "
    "velocity about 150",
    "no correction with k zero or without any velocity":
    "tracked; 18 01; B3 01 {00|14} 00 00 00 {C3|00} {50|00}; displace -10; nothing planned; 1 s; 99: 10",
    "off it does nothing and turned on it makes up what is missing":
    "tracked; displace -10; 1 s; 99: 10; at 0; 18 01; 5 s; 99: 0; 18 00; displace -10; 1 s; 99: 10",
    "turned off in a correction the motor stands":
    "tracked; 18 01; displace -1000; 0.1 s; 18 00; at rest; 99: over 700",
    "a closed loop move makes up for backlash: With a play of 50 counts, +1,000 (6,250 pulses) moves the load by "
    "950; 6,563 pulses (1,050.08) move it by 1,000. -500 are 3,125 pulses, to 3,438 (550.08), which moves the "
    "load to 550 only; at 3,131 (500.96) it is at 500":
    "tracked backlash=50; 35 =1000; idle; 83: 6250; 9A: 950; 99: 50; 18 01; 20 s; 83: 6563; 9A: 1000; 35 =-500; "
    "20 s; 83: 3131; 9A: 500",
    "a correction is no move: a correction causes no messages; 98h reports the move before; 80h counts the pulses "
    "of both":
    "tracked; 18 01; 35 =16; idle; A1 01; A3 01; A5 01; displace -16; 0.01 s; velocity over 0; 20 s; "
    "says nothing; 98: 16; 80: 200",
    "stop and kill do not end maintenance": "tracked; 18 01; displace -100; 0.1 s; {70|78}; 40 s; 99: 0",
    "a stopped closed loop move stays where it stopped until it is resumed":
    "tracked; 18 01; start 35 =4000; 1 s; {70|78}; 1 s; 99: 0; 9A: under 900; 37; 10 s; 99: 0; 9A: 4000",
    "a closed loop move may begin in a correction: the shaft is pushed by -1,000; during the correction a move of "
    "+100 is sent":
    "tracked; 18 01; displace -1000; 0.1 s; velocity over 0; A1 01; 35 =100; 0.02 s; says A1 00; 40 s; 99: 0; "
    "9A: 100",
    "open loop preset moves are refused":
    "tracked; 18 01; C8 01 00 =5000 =at_once =100; CB 02 00 =5000 =at_once =100; {33|34|40|40} {=100|=100|01|02}; "
    "1 s; pulses 0",
    "a continuous move may begin in a correction":
    "tracked; 18 01; displace -1000; 0.1 s; 32 01; 1 s; velocity -5000",
    "a jammed motor goes on trying: a jam costs whole rotor teeth of pulses; when the shaft is free again, the "
    "encoder returns to the position":
    "tracked; 18 01; jam; displace -10; 1 s; 99: 10; velocity 200; free; 10 s; 99: 0",
    "no correction into a limit but away from it":
    "tracked; 18 01; cw_limit high; 0.01 s; displace -10; 1 s; pulses 0; displace 20; 10 s; 99: 0; displace -10; "
    "0.1 s; cw_limit released; 10 s; 99: 0",
    "no correction while shut down": "tracked; 18 01; 12 01; displace -10; 1 s; pulses 0; 12 00; 5 s; 99: 0",
    "a search for home is not disturbed: the shaft is pushed while a search is being calculated; the correction "
    "comes after the search":
    "tracked; 18 01; 38 01 00 64 00; home low; 39 00; displace 100; 1 s; velocity 5000; 78; 1 s; 99: 0",
    "the joystick takes the motor where it wants":
    "tracked; 18 01; 11; 0.01 s; joystick 100 2 ms; at_zero high; at 100; 10; 1 s; at 100; 99: 0; 98: 16",
    "zero here is the desired position": "tracked; displace -10; 30; 99: 0; 9A: 0",
    "the deadband is left by a move and reached by its end: 1,000 pulses at 5,000 pps are 160 encoder pulses; the "
    "deadband of 5 begins at 155, that is at 968.75 pulses. Pulse 969 comes at 193.8 ms and is detected at 194 ms":
    "tracked; B5 00 00 00 05; 0F 00 80 FF; start 35 =160; clock; until SB & 1 is 0; until SB & 1 is 1; "
    "194 ms later",
    "a position that is defined anew is in the deadband: 30h, 2Fh make the present position the desired one, so "
    "that 99h is 0 and the bit follows at once (1)":
    "tracked; B5 00 00 00 05; 0F 00 80 FF; displace -10; SB & 1 is 0; 30; 99: 0; SB & 1 is 1",
    "a position that is defined anew is in the deadband: 30h, 2Fh make the present position the desired one, so "
    "that 99h is 0 and the bit follows at once (2)":
    "tracked; B5 00 00 00 05; 0F 00 80 FF; displace -10; SB & 1 is 0; 2F =7; 99: 0; SB & 1 is 1",
    "maintenance goes on to no error at all whatever the deadband":
    "tracked; 18 01; B5 00 00 00 32; displace -20; 10 s; 99: 0",
    "an 1810 has no deadband": "tracked 1810; B5 00 00 00 05; 0F 00 80 FF; 0.1 s; SB & 1 is 0",
    "a continuous move is not and where it ends is the desired position":
    "tracked; 18 01; 32 00; 1 s; 78; mark; at over 4000; 1 s; moved 0; 99: 0",
    "the deadband is shown: Only after B5h is the deadband shown, here five encoder pulses to each side":
    "tracked; 0F 00 80 FF; SB & 1 is 0; B5 AB CD 00 05; displace 0; SB & 1 is 1; displace 5; SB & 1 is 1; "
    "displace 1; SB & 1 is 0; displace -11; SB & 1 is 1; displace -1; SB & 1 is 0",
})  # fmt: skip
def test_position_maintenance(bench, script):
    play(bench, script)


@pytest.mark.parametrize("law", [(1, 20), (2, 100), (3, 1)])
@pytest.mark.parametrize("counts", [-100, 100])
def test_a_pushed_motor_comes_back(bench, board, law, counts):
    """100 encoder pulses are 625 motor pulses; backwards 619 are enough, because encoder counts are rounded down."""
    send(bench, board, 0xB3, *law, 0x00, *i32(50_000))
    push(board, counts)
    bench.run(40)
    assert number(bench, board, 0x99) == 0 and -625 <= board.axes["motor"].position * (1 if counts > 0 else -1) <= -619


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
