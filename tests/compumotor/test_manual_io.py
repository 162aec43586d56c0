"""Manual, Appendix A: 00h to 14h (user bits, outputs, state bits, joystick, shutdown, direction), FDh and FFh."""

import re
from itertools import pairwise

import pytest

from axistwin.bench import action
from axistwin.core.errors import ProgramError, UsageError
from axistwin.core.units import MS

from ..scripts import scripts
from .programs import about, cruise, joystick_pulses, rising, steps
from .scripts import play
from .talking import CONTROL, FAIL, ask, complete, default, i32, messages, position, send, send_all, status_word


@scripts({
    '00h: "If this command is sent to the indexer nothing will happen!"':
    "00; says nothing; SB 50; pulses 0; output1 is high; output2 is high",
    '01h: "01, the parameter byte supplied, bytes three through sixteen are always zero"':
    "01 {00|01|80|FF} -> {00|01|80|FF}",
    '01h: "may be used to indicate a location within a sequence buffer"':
    "sequence 1: 01 A1, 2A 00 01, 01 A2; 41 01; 0.5 s; says 01 A1; 1 s; says 01 A2",
    '08h: "if one sends the command string 08h, 05h user bit zero will be set, user bit one will be cleared, and '
    'user bit two will be set"; 09h and 0Ah each change one bit; other parameters are ignored':
    "08 02; 0.01 s; SB 52; 08 05; 0.01 s; SB 55; 08 08; 0.01 s; SB 55; 08 FF; 0.01 s; SB 55; 09 01; 0.01 s; "
    "SB 57; 0A 02; 0.01 s; SB 53; 09 03; 0.01 s; SB 53; 0A 03; 0.01 s; SB 53; 0A 00; 0.01 s; SB 52; 08 00; "
    "0.01 s; SB 50",
    '0Fh: "OF 01 01 FF ... When the motor is moving, set user-definable bit number one"; state 00 ends this':
    "0F 01 01 FF; cruise 10000 100000; SB & 7 is 2; 0F 01 00 00; 78; 0.1 s; "
    "SB & 7 is 2 -- leave the bit in its previous state",
    "0Fh, state 03: an output that is low while a sequence is performed":
    "0F 03 03 00; sequence 1: 2A 00 01; 0.01 s; output1 is high; 41 01; 0.5 s; output1 is low; 0.6 s; "
    "output1 is high",
    '11h: "any command that cannot be performed when the motor is moving can also not be performed"':
    "default 10000 100000; 33 =70; idle; 11; 0.02 s; 30; 33 =100; 12 01; 13 01; 14 01; 2E =5; 0.2 s; 83: 70; "
    "shutdown is low; 10; 0.02 s; 33 =1; idle; 83: 71; at 71 -- CW is still +",
    'SHUTDOWN IN: "can cause the REMOTE SHUTDOWN signal on the MOTOR/DRIVER connector to become active"':
    "shutdown_in low; 11; 0.02 s; shutdown is high; 10; 0.02 s; shutdown is low",
    'DIRECTION IN: "preceded and followed by an active AT ZERO": the drive has 4 ms before the first pulse':
    "at_zero high; direction_in high; direction is low; 11; 0.02 s; direction is high; direction_in low; "
    "direction is low; 10; 0.02 s; direction_in high; direction is low",
    '11h: "may not be enabled if the remote power shutdown is active or if motion is occuring"':
    "cruise 10000 100000; 11; 0.02 s; remote_acknowledge is low; 78; 12 01; 11; 0.02 s; remote_acknowledge is low",
    "13h: the input is active low, and only when enabled; while it is active 12h is not performed":
    "shutdown_in low; 0.02 s; shutdown is low; 13 01; 0.02 s; shutdown is high; default 10000 100000; 33 =100; "
    "0.2 s; pulses 0; shutdown_in high; 0.02 s; shutdown is low; 12 01; 0.02 s; shutdown is low; 33 =100; idle; "
    "pulses 100",
    '14h: "After the direction redefinition move number one is still a + move", but its direction is CCW':
    "default 10000 100000; 33 =60; idle; direction is high -- the direction line is high for CW; 14 01; 33 =50; "
    "idle; direction is low; at 10; 84 -> 00; 80: 50; 83: 110",
    "the sense of direction stays while moving": "cruise 10000 100000; 14 01; 78; mark; 33 =50; idle; moved 50",
    "14h with 89h: with CCW = + the CCW switch is the + limit": "ccw_limit high; 0.01 s; 89 -> 0F; 14 01; 89 -> F0",
    "Test switch function: the switch starts a function of the board, which needs power":
    "power off; test_switch high; test_switch low; power on; 1.1 s; SB 50; pulses 0",
    "D: the Fail interrupt (JU19) comes with status bits 5 and 7; only a reset clears them":
    "1811 interrupts=('failed',); CB 40; IDB FF; CB 50; 10.5 s; interrupt; SB & A0 is A0; CB D0; 0.1 s; "
    "interrupt; CB 20; no interrupt",
    '0Bh to 0Dh, 97h: both outputs are set at power on; 0Dh writes bits 1 and 2, "all other bits ... are ignored"':
    "00; 0.01 s; output1 is high; output2 is high; 97 -> 06; 0C 02; 0.01 s; output1 is high; output2 is low; "
    "97 -> 02; 0C 00; 0.01 s; output1 is high; output2 is low; 97 -> 02; 0C 03; 0.01 s; output1 is high; "
    "output2 is low; 97 -> 02; 0D 04; 0.01 s; output1 is low; output2 is high; 97 -> 04; 0D F9; 0.01 s; "
    "output1 is low; output2 is low; 97 -> 00; 0D 02; 0.01 s; output1 is high; output2 is low; 97 -> 02; 0B 02; "
    "0.01 s; output1 is high; output2 is high; 97 -> 06; 0D 00; 0.01 s; output1 is low; output2 is low; 97 -> 00; "
    "0B 01; 0.01 s; output1 is high; output2 is low; 97 -> 02; 0B 03; 0.01 s; output1 is high; output2 is low; "
    "97 -> 02; 0B 00; 0.01 s; output1 is high; output2 is low; 97 -> 02",
    "a state that is not defined is ignored": "0F 03 08 01; 0F 05 01 01; output1 is high",
    "the shutdown input takes the say from the command":
    "13 01; 12 01; shutdown is low; shutdown_in low; shutdown is high; shutdown_in high; shutdown is low",
    "the step pin is high for half a period of the highest frequency: STEP is high for half a period of the "
    "highest frequency: in range 0, 546,133.3 Hz, this is 915 ns":
    "default 1000 at_once; 33 =2; idle; 33 =2; until moving; 0.001 s; step is high; 1e-06 s; step is low",
    "the test switch needs its jumper": "1811 test_switch=False; test_switch high; 1 s; at 0",
})  # fmt: skip
def test_outputs_joystick_and_shutdown(bench, script):
    play(bench, script)


def test_more_than_one_bit_may_show_the_same_state(bench, board):
    """0Fh: the joystick request input "by both a programmable output bit and a user-definable bit"."""
    send_all(bench, board, (0x0F, 4, 0x81, 1), (0x0F, 2, 0x81, 0))
    for level in (True, False, True):
        board.pins["remote_enable"].drive(level)
        bench.run(0.02)
        assert ask(bench, board, 0x95)[:3] == bytes([0x95, 0xFF if level else 0, 0])
        assert board.pins["output2"].level is level and bool(status_word(bench, board) & 4) is not level


@pytest.mark.parametrize(("state", "expected"), [
    (1, "111110"), (2, "111110"), (5, "110000"), (6, "000110"), (7, "001000"), (3, "000000")
], ids=["moving", "singular", "accelerating", "decelerating", "constant", "sequence"])  # fmt: skip
def test_states_of_a_preset_move(bench, board, state, expected):
    """0Fh: a trapezoid of 0.1 s, 0.2 s and 0.1 s; the bit is read every 80 ms."""
    send(bench, board, 0x0F, 0, state, 1)
    default(bench, board, 10_000, 100_000)
    send(bench, board, 0x33, *i32(3_000))
    assert bench.run_until(lambda: board.axes["motor"].velocity, 0.1)
    seen = ""
    for wait in (0.02, 0.06, 0.12, 0.12, 0.06, 0.06):
        bench.run(wait)
        seen += str(status_word(bench, board) & 1)
    assert seen == expected


def stick(bench, board, pulses, cw):
    """Make pulses of a joystick at 1 kHz, with AT ZERO active before and after."""
    pins = board.pins
    pins["at_zero"].drive(True)
    bench.run(0.005)
    pins["direction_in"].drive(cw)
    bench.run(0.005)
    joystick_pulses(bench, board, pulses, cw)
    assert ask(bench, board, 0x8C)[1] == (0xFF if pins["remote_acknowledge"].level else 0)
    pins["at_zero"].drive(True)
    bench.run(0.005)


def test_the_joystick_is_tracked(bench, board):
    """11h, Joystick Interface: "Command 80 reports the position from the last place the Joystick stopped the motor"."""
    board.pins["step_in"].drive(False)
    stick(bench, board, 3, True)
    assert board.axes["motor"].pulses == 0, "disabled after power on"
    send(bench, board, 0x11, seconds=0.02)
    assert board.pins["remote_acknowledge"].level
    stick(bench, board, 40, True)
    stick(bench, board, 15, False)
    assert [position(bench, board, opcode) for opcode in (0x80, 0x82, 0x83)] == [-15, 25, 25]
    assert ask(bench, board, 0x84)[1] == 0xFF
    send_all(bench, board, (0x30,), (0x10,), seconds=0.02)
    assert not board.pins["remote_acknowledge"].level
    assert position(bench, board) == 25, "30h is ignored"
    stick(bench, board, 5, True)
    assert board.axes["motor"].position == 25


def test_remote_power_shutdown(bench, board):
    """12h: ignored while moving; "no moves may be performed ... until remote power shutdown is turned off"."""
    default(bench, board, 10_000, 100_000)
    assert not board.pins["shutdown"].level
    cruise(bench, board)
    send(bench, board, 0x12, 1)
    assert not board.pins["shutdown"].level
    send(bench, board, 0x78)
    before = board.axes["motor"].pulses
    send(bench, board, 0x12, 0x80, seconds=0.01)
    assert board.pins["shutdown"].level
    for command in ((0x33, *i32(100)), (0x34, *i32(100)), (0x32, 0)):
        send(bench, board, *command, seconds=0.2)
    assert board.axes["motor"].pulses == before
    send(bench, board, 0x12, 0)
    complete(bench, board, 0x33, *i32(100))
    assert board.axes["motor"].pulses == before + 100


def test_part_number(bench, board):
    """FDh: the reply is 39 34 2D, six characters, 2D, two characters of the revision, and one or two letters."""
    data = ask(bench, board, 0xFD)
    assert data[0] == 0xFD and re.fullmatch(rb"94-[0-9]{6}-[0-9]{2}[A-Z]{1,2}\0*", data[1:])
    assert len(data) == 16


@pytest.mark.parametrize("by", ["command", "switch", "command while a sequence is defined"])
def test_the_test_switch_function(bench, board, by):
    """FFh, Functional check: 25,000 pulses at 5,000 Hertz CCW, the same CW, then the board monitor alarm: 10 s."""
    send(bench, board, 0x0D, 0)
    if by == "switch":
        board.pins["test_switch"].drive(True)
    else:
        if "sequence" in by:
            send(bench, board, 0xD9, 1)
        send(bench, board, 0xFF)
    bench.run(4.9)
    assert not status_word(bench, board) & FAIL and not board.pins["direction"].level
    assert board.axes["motor"].position == pytest.approx(-24_500, abs=100)
    bench.run(4.9)
    assert (board.pins["direction"].level, board.pins["led"].level) == (True, False)
    bench.run(0.4)
    assert status_word(bench, board) & FAIL and board.pins["led"].level
    times = steps(board)
    assert (len(times), board.axes["motor"].position) == (50_000, 0)
    periods = {b - a for a, b in pairwise(times[:25_000])}
    # 5,000 Hz is a multiple of 16.667 Hz
    assert periods == {200_000} and about(10, times[-1] - times[0], 50)
    bench.run(1)
    tell_nothing(bench, board)
    board.bus.write(CONTROL, 0x20)
    bench.run(1.01)
    assert status_word(bench, board) == 0x50 and not board.pins["led"].level


def tell_nothing(bench, board):
    """Send commands to a failed board: "no pulses will be output to the motor"."""
    default_ = (0x31, 0, 0, *i32(1_000), *i32(100_000))
    for command in (default_, (0x33, *i32(10)), (0x90,)):
        for value in command:
            board.bus.write(0, value)
        board.bus.write(CONTROL, 0x10)
        bench.run(0.1)
    assert status_word(bench, board) & FAIL and (board.axes["motor"].position, messages(bench, board)) == (0, [])


def test_triggers_are_read(bench, board):
    """94h: bits two to five are 1 for TTL high; triggers 1 and 6 are not in the reply."""
    rising(bench, board, 1)
    rising(bench, board, 6)
    for mask in range(0, 64, 4):
        for trigger in (2, 3, 4, 5):
            board.pins[f"trigger{trigger}"].drive(bool(mask >> trigger & 1))
        bench.run(5 * MS / 1_000_000_000)
        assert ask(bench, board, 0x94) == bytes([0x94, mask]).ljust(16, b"\0")


def test_the_stick_moves_the_motor_both_ways_once_the_joystick_is_enabled(bench, board):
    """11h with one axis of an 852: 5,000 pulses/s clockwise, then 1,000 pulses/s back; 80h reports the latter."""
    send(bench, board, 0x11, seconds=0.02)
    board.joystick.deflect(5000)
    bench.run(0.104)
    board.joystick.deflect(0)
    bench.run(0.05)
    there = position(bench, board)
    assert there == pytest.approx(500, abs=5)
    board.joystick.deflect(-1000)
    bench.run(0.108)
    board.joystick.deflect(0)
    bench.run(0.05)
    assert position(bench, board, 0x80) == pytest.approx(-100, abs=3)
    assert position(bench, board) == there + position(bench, board, 0x80)


@pytest.mark.parametrize("rate", [1000, -400])
def test_the_axis_is_as_fast_as_the_joystick_has_it(bench, board, rate):
    """11h: "the pulse frequency out of the 1810/11 ... is identical to the pulse frequency in from the Joystick"."""
    send(bench, board, 0x11, seconds=0.02)
    motor = board.axes["motor"]
    board.joystick.deflect(rate)
    bench.run(0.05)
    seen = set()
    for _ in range(100):
        bench.run(0.000_07)
        seen.add(motor.velocity)
    assert seen == {rate}
    times = motor.pulse_times()
    assert set((times[1:] - times[:-1]).tolist()) == {1_000_000_000 // abs(rate)}
    board.joystick.deflect(0)
    bench.run(0.05)
    assert motor.velocity == 0


def test_a_controller_without_a_joystick_says_so(bench):
    with pytest.raises(UsageError, match="has no joystick input"):
        _ = bench.add("if1").joystick


@pytest.mark.parametrize("rate", [700, -700, 0])
def test_somebody_at_the_joystick_in_a_conversation(board, rate):
    action(board, "joystick", f"{rate}")()
    assert board.joystick.rate == rate


def test_there_is_a_joystick_only_where_one_can_be_connected(bench):
    with pytest.raises(ProgramError, match="unknown name 'joystick'"):
        action(bench.add("if1"), "joystick", "5")
