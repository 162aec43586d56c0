"""Addendum for position tracking: parameters, counts, closed-loop moves; and the loose sheets on 37h."""

import pytest

from axistwin.core.units import US

from ..scripts import scripts
from .programs import ALL, AT_ONCE, number, start, tracked
from .scripts import play
from .talking import RESET, ask, complete, default, i32, ready, send, until_idle


@pytest.fixture
def board(bench):
    return tracked(bench)


@scripts({
    "a law out of range is ignored":
    "tracked; B3 {00|04|01|01|01} 01 {00|00|60|00|00} {00|00|00|FF|00} {00|00|00|FF|08} {00|00|00|FF|55} {01|01|"
    "01|FF|56}; 9F -> 01 14 00 00 00 C3 50",
    'B3h, range byte: "0X -> 5X": any lower nibble is accepted':
    "tracked; B3 03 FF 5F =7; 9F -> 03 FF 5F 00 00 00 07",
    "a ratio with denominator zero is ignored": "tracked; B0 00 01 00 00; 9C -> 61 A8 0F A0",
    "a closed loop move goes so many encoder pulses: 4,000 encoder pulses are 4,000 × 6.25 motor pulses, 5 s at "
    "5,000 pps; after 2.5 s half of them are done":
    "tracked; start 35 =4000; 2.5 s; 98: 1990 to 2010; 99: 1985 to 2015; idle; 83: 25000; at 25000; 98: 4000; "
    "99: 0; 9A: 4000; 9B: 0; 81: 0",
    "the relative count is of the last move": "tracked; 35 =4000; idle; 35 =-400; idle; 98: -400; 9A: 3600",
    "A move of 10 is 62.5 pulses: 63 are made. A move of -50 is 312.5: 313 are made, to -250, encoder -40":
    "tracked; 35 =10; idle; 83: 63; 9A: 10; 35 =-50; idle; 83: -250; 9A: -40",
    "with maintenance off the desired position is where an open loop move ended: an open-loop move of 1,000 "
    "pulses ends at 160 encoder pulses, which is then the desired position":
    "tracked; start 33 =1000; 0.1 s; 99: under 0; idle; 99: 0; 9A: 160",
    "an absolute move is from where the encoder is: the shaft is pushed to +100, so an absolute move to +300 is "
    "200 encoder pulses, or 1,250 motor pulses": "tracked; displace 100; 36 =300; idle; 83: 1250; 9A: 300; 99: 0",
    "a move to where it is makes no pulse but is the desired position":
    "tracked; displace 100; 99: -100; 36 =100; 0.1 s; 99: 0; pulses 0",
    "35h and 36h need the default move": "tracked; default 0 0; 35 =1000; 1 s; 36 =1000; 1 s; pulses 0",
    "defined closed loop moves need the ratio only":
    "1811 motor={'encoder':{'counts_per_rev':4000,'pulses_per_rev':25000}}; {D4|D5} 07 00 =5000 =at_once =100; "
    "91 07 -> {D4|D5} 07 00 =5000 =at_once =100; 40 07; 1 s; at 0; B0 61 A8 0F A0; 40 07; idle; 40 07; idle; "
    "at {1250|625}",
    "no closed loop move is longer than 7fffffff motor pulses: at 65,535 to 1, 32,768 are 2,147,450,880 motor "
    "pulses; one encoder pulse more exceeds 2,147,483,647 (1)":
    "tracked; B0 FF FF 00 01; A1 01; {35|36|35|36} ={32768|32768|-32768|-32768}; says A1 00",
    "no closed loop move is longer than 7fffffff motor pulses: at 65,535 to 1, 32,768 are 2,147,450,880 motor "
    "pulses; one encoder pulse more exceeds 2,147,483,647 (2)":
    "tracked; B0 FF FF 00 01; A1 01; {35|36|35|36} ={32769|32769|-32769|-32769}; says nothing",
    "resume with nothing commanded is ignored": "tracked; 33 =100; idle; 37; 1 s; at 100",
    "resume goes to the same place after absolute zero has been redefined":
    "tracked; start 36 =800; 0.3 s; 78; 30; 9A: 0; 83: 0; 37; idle; encoder at 800",
    "2Fh defines the closed loop position only and there is no error then":
    "tracked; 18 01; 2F =-1000000; 9A: -1000000; 83: 0; 99: 0; 36 =-999900; idle; at 625; 9A: -999900",
    "2Fh is ignored while moving": "tracked; start 35 =4000; 2F =1000000; idle; 9A: 4000",
    "the absolute count wraps at 32h bits": "tracked; 2F =at_once; 35 =16; idle; 9A: -2147483633; 99: 0",
    "14h: from this command on, CCW is +; the counts keep their values":
    "tracked; 35 =16; idle; 14 01; 9A: 16; 35 =16; idle; 9A: 32; 99: 0; at 0; encoder at 0",
    "an 1810 answers the requests and does not move":
    "tracked 1810; 33 =625; idle; 98: 0; 99: 0; 9A: 0; 35 =1000; 36 =1000; 37; 1 s; at 625; 9A: 0",
    "an 1811 without an encoder counts nothing": "default 5000 at_once; 33 =625; idle; 9A: 0; next nothing",
    "parameters are reported as they were given and zeros before":
    "9C -> 00; 9D -> 00; 9E -> 00; 9F -> 00; B0 61 A8 0F A0; B1 00 00 61 A8; B2 00 00 00 00; "
    "B3 01 14 00 00 00 C3 50; B4 00 00 00 32; 9C -> 61 A8 0F A0; 9D -> 00 00 61 A8; 9E -> 00; "
    "9F -> 01 14 00 00 00 C3 50",
})  # fmt: skip
def test_closed_loop_moves(bench, script):
    play(bench, script)


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


def test_the_desired_position_is_the_sum_of_closed_loop_moves(bench, board):
    """The addendum's example: after +30 and -10 the desired position is +20; after absolute +55 it is +55."""
    desired = []
    for command in ((0x35, *i32(30)), (0x35, *i32(-10)), (0x36, *i32(55))):
        complete(bench, board, *command)
        desired.append(number(bench, board, 0x9A) + number(bench, board, 0x99))
    assert desired == [30, 20, 55]


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
    assert 2_000 <= stopped <= 2_010 and number(bench, board, 0x99) == 0
    start(bench, board, 0x37)
    began = bench.now
    until_idle(bench, board)
    left = (25 * (4000 - 4 * stopped // 25) + 2) // 4
    assert number(bench, board, 0x9A) == 4000
    assert motor.position == stopped + left and int(motor.pulse_times(began)[-1]) - began == left * 500 * US


def test_after_a_reset_counts_are_zero_and_nothing_is_defined(bench, board):
    complete(bench, board, 0x35, *i32(16))
    board.bus.write(1, RESET)
    bench.run(1.01)
    assert [number(bench, board, opcode) for opcode in (0x98, 0x99, 0x9A)] == [0, 0, 0]
    assert ask(bench, board, 0x9C)[1:5] == bytes(4)
    board.power(False)
    assert not board.axes["motor"].on_push


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
