"""Addendum for position tracking: slip (9Bh), stall detection (A6h, A7h), and moves that a stall ends (19h).

One of 50 rotor teeth is 500 of 25,000 pulses, which take 100 ms at 5,000 pps.
"""

import pytest

from axistwin.core.units import MS

from ..scripts import scripts
from .programs import number, start, tracked
from .scripts import play
from .talking import complete, i32, in_all_ways, messages, position, send


@pytest.fixture
def board(bench):
    return tracked(bench)


@scripts({
    "the backlash comes on top": "tracked; B2 =250; 19 01; jam; 33 =25000; idle; 83: 750",
    "without 19h it goes on stalling and that is told once":
    "tracked; A7 01; jam; 33 =-25000; idle; says A7 00; 83: -25000; 9B: 50",
    "continuous moves are watched too": "tracked; 19 01; start 32 00; 3 s; jam; until at rest; 83: 15500 to 15520",
    "with maintenance the place of the stall is the desired position":
    "tracked; 18 {01|00}; 19 01; jam; 35 =4000; idle; 1 s; 83: 500; 99: {0|4000}",
    "a stalled closed loop move is resumed: a stall loses 500 pulses; after RESUME the encoder is at the end of "
    "the move": "tracked; 18 01; 19 01; jam; 35 =4000; idle; free; 37; 20 s; 9A: 4000; 99: 0; 83: 25500; 9B: 1",
    "A load holds the shaft from 1 s to 1.2 s: 1,000 pulses, two teeth, are lost; 160 encoder pulses are missing":
    "tracked; start 35 =4000; 1 s; jam; 0.2 s; free; idle; 99: 160; 9B: 2; 18 01; 20 s; 99: 0; 83: 26000",
    "each move is watched from its own beginning: an earlier slip remains in 9Bh until 30h, but stops no later "
    "move":
    "tracked; 19 01; A7 01; jam; 33 =1000; idle; free; says A7 00; 33 =1000; idle; says nothing; 83: 1500; 9B: 1; "
    "30; 9B: 0",
    "a joystick that was enabled and not moved is no move": "tracked; 33 =1000; idle; 11; 10; 0.01 s; 98: 160",
    "a stall under the joystick is told and stops nothing: the joystick's pulses pass through the board, as at a "
    'limit: "will not disable the Joystick"':
    "tracked; 19 01; A6 01; 11; jam; joystick 1000; says A6 00; 83: 1000; remote_acknowledge is high",
    "slip is truncated: 9Bh truncates the slip of 499 pulses to whole teeth; a tooth is 500, 490.2, 250, 247.5 or "
    "50 pulses": "tracked; B4 00 00 {00|00|00|00|01} {32|33|64|65|F4}; jam; 33 =499; idle; 9B: {0|1|1|2|9}",
    "a push is slip too and what reports it wants ratio resolution and teeth: a push of -800 encoder pulses, "
    "5,000 motor pulses, is a slip of ten teeth":
    "tracked; displace -800; 9B: 10; B1 00 00 00 00; 9B: 0; B1 00 00 61 A8; 9B: 10",
    "a jammed motor is stopped after one tooth":
    "tracked; 19 01; A6 01; A7 01; jam; start 35 =4000; clock; until at rest; 100 ms later; says A6 00, A7 00; "
    "83: 500; 9A: 0; 9B: 1",
    '11h: from zero velocity and back "is considered a move"; 98h: "the number of encoder pulses ... during the '
    'last move". An encoder pulse is 6.25 motor pulses':
    "tracked; 33 =1000; idle; 98: 160; 11; joystick {100|-100}; at_zero high; 0.004 s; 80: {100|-100}; 98: {16|"
    "-16}; joystick {25|-25}; at_zero high; 0.004 s; 80: {25|-25}; 98: {4|-4}; at_zero low; 98: 0; 10; 98: 0; "
    "9A: {180|140}",
    '11h: from zero velocity and back "is considered a move"; an earlier slip, here of 499 pulses, is no stall':
    "tracked; A7 01; jam; 33 =499; idle; 11; joystick {499|-499}; at_zero high; 0.004 s; says nothing; "
    "joystick {500|-500}; at_zero high; 0.004 s; says A7 00; joystick {2000|-2000}; at_zero high; 0.004 s; "
    "says A7 00; free; joystick {1000|-1000}; at_zero high; 0.004 s; says nothing",
    "a stall by the joystick between two updates is found at its end: Of 100 encoder pulses to the revolution, a "
    "tooth of 50 is two motor pulses":
    "tracked; B0 00 01 00 01; B1 =100; A7 01; 11; jam; joystick 2 0.1 ms; at_zero high; free; at_zero high; "
    "0.004 s; says A7 00",
    "there is no watch before all four are defined (1)":
    "tracked; power cycle; 1.01 s; B1 00 00 61 A8; B2 00 00 00 00; B3 01 14 00 00 00 C3 50; B4 00 00 00 32; "
    "19 01; A7 01; 31 00 00 =5000 =at_once; jam; 33 =2000; idle; says nothing; 83: 2000",
    "there is no watch before all four are defined (2)":
    "tracked; power cycle; 1.01 s; B0 61 A8 0F A0; B2 00 00 00 00; B3 01 14 00 00 00 C3 50; B4 00 00 00 32; "
    "19 01; A7 01; 31 00 00 =5000 =at_once; jam; 33 =2000; idle; says nothing; 83: 2000",
    "there is no watch before all four are defined (3)":
    "tracked; power cycle; 1.01 s; B0 61 A8 0F A0; B1 00 00 61 A8; B3 01 14 00 00 00 C3 50; B4 00 00 00 32; "
    "19 01; A7 01; 31 00 00 =5000 =at_once; jam; 33 =2000; idle; says nothing; 83: 2000",
    "there is no watch before all four are defined (4)":
    "tracked; power cycle; 1.01 s; B0 61 A8 0F A0; B1 00 00 61 A8; B2 00 00 00 00; B3 01 14 00 00 00 C3 50; "
    "19 01; A7 01; 31 00 00 =5000 =at_once; jam; 33 =2000; idle; says nothing; 83: 2000",
    "a load that the motor cannot bear: the motor has 1 N·m at any rate; a load of 2 N·m from 1 s to 1.3 s loses "
    "1,500 pulses, three teeth":
    "tracked motor={'torque':((0,1),(10000,1)),'pull_in':6000,'pulses_per_rev':25000}; A7 01; start 33 =25000; "
    "1 s; load -2.0; 0.3 s; load 0.0; idle; says A7 00; 83: 25000; at 23500; 9A: 3760; 9B: 3",
})  # fmt: skip
def test_stalls(bench, script):
    play(bench, script)


def test_too_fast_for_the_motor(bench):
    """The motor has no torque above 4,000 pps: at 5,000 pps it stalls, and after one tooth the move is stopped."""
    motor = {"torque": ((0, 1), (4_000, 1), (4_001, 0)), "pull_in": 4_000, "pulses_per_rev": 25_000}
    board = tracked(bench, motor=motor, load={"torque": 0.5})
    send(bench, board, 0x19, 1)
    complete(bench, board, 0x35, *i32(4000))
    assert (position(bench, board), number(bench, board, 0x9A)) == (500, 0)


def test_backlash_is_no_stall_if_it_has_been_defined(bench):
    """A play of 100 encoder pulses is 625 motor pulses, more than a tooth; defined as backlash it is no stall."""
    board = tracked(bench, backlash=100)
    send(bench, board, 0xA7, 1)
    for sigma, told in ((0, ["a7 00"]), (625, [])):
        send(bench, board, 0xB2, *i32(sigma))
        for distance in (2_000, -2_000):
            complete(bench, board, 0x33, *i32(distance))
        assert messages(bench, board) == told * 2


@in_all_ways(5, 0.0007, 8000)
def test_a_wrong_ratio_becomes_a_stall_at_the_same_update_however_it_is_run(bench, board, run):
    """4,100 encoder pulses are defined, 4,000 come: 100/4,100 of a pulse slips per pulse, 500 pulses are a tooth.

    After k updates of 10 pulses the encoder has counted 1.6 k, rounded down, so that the slip is
    (1000 k + 25,000 of the fraction) / 4,100.  It reaches 500 first for k = 2033, where the fraction is 0.8.
    """
    for command in ((0xB0, 0x61, 0xA8, 0x10, 0x04), (0x19, 1), (0xA7, 1)):
        send(bench, board, *command)
    start(bench, board, 0x32, 0)
    run(bench)
    assert messages(bench, board) == ["a7 00"]
    assert (position(bench, board), number(bench, board, 0x9A)) == (20_330, 3252)


def test_the_watch_of_a_long_move_costs_a_few_events(bench, board):
    """Nothing can stall this motor, so one update covers the run; the last one is at most 2 ms before its end."""
    start(bench, board, 0x32, 0)
    bench.run(0.002)
    events = next(bench.clock._eid)
    bench.run(1000)
    assert next(bench.clock._eid) - events < 10 and bench.clock.next_event_ns() - bench.now <= 2 * MS


def test_backlash_jams_and_pushes_in_a_watched_move(bench):
    """A jam of 1 s in a move of 5 s is 5,000 pulses, ten teeth: less than the defined backlash, then more."""
    for sigma, stalls in ((5_000, []), (4_000, ["a7 00"])):
        board = tracked(bench, backlash=40)
        for command in ((0xB2, *i32(sigma)), (0xA7, 1)):
            send(bench, board, *command)
        start(bench, board, 0x33, *i32(25_000))
        bench.run(1)
        board.axes["motor"].jam()
        bench.run(1)
        board.axes["motor"].jam(False)
        bench.run(10)
        assert messages(bench, board) == stalls
