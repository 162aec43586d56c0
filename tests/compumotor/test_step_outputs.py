"""Specifications, MOTOR/DRIVER connector: STEP, CW STEP and CCW STEP; the test function's pulses; a failed board."""

import pytest

from axistwin.core.errors import UsageError

from ..scripts import scripts
from .scripts import play
from .talking import default, i32, messages, ready, send, send_all

AT_ONCE = 0x7FFF_FFFF
PINS = ("step", "cw_step", "ccw_step")


def levels(board):
    return tuple(board.pins[name].level for name in PINS)


@pytest.mark.parametrize("ccw_is_plus", [0, 1])
@pytest.mark.parametrize("distance", [3, -3])
def test_cw_step_and_ccw_step_are_active_low_for_their_direction_only(bench, board, distance, ccw_is_plus):
    """CW STEP: "Same as STEP output except active only for clockwise motion"; in range 0 pulses are 915 ns wide."""
    send(bench, board, 0x14, ccw_is_plus)
    default(bench, board, 1_000, AT_ONCE)
    assert levels(board) == (False, True, True)
    send(bench, board, 0x33, *i32(distance))
    assert bench.run_until(lambda: board.axes["motor"].velocity, 1)
    began = board.axes["motor"].train.move.start_ns
    cw = (distance > 0) is (ccw_is_plus == 0)
    found = []
    for time_ns in (999_999, 1_000_000, 1_000_914, 1_000_915):
        bench.run((began + time_ns - bench.now) / 1e9)
        found.append(levels(board))
    idle, active = (False, True, True), (True, not cw, cw)
    assert found == [idle, active, active, idle]


def test_without_power_the_open_collectors_let_go(bench, board):
    board.power(False)
    assert levels(board) == (False, True, True)


@pytest.mark.parametrize("cw", [True, False])
def test_step_is_step_in_while_the_joystick_is_enabled(bench, board, cw):
    """STEP IN: "one will see out of STEP exactly what one puts into this input when the Joystick is enabled"."""
    pins = board.pins
    pins["step_in"].drive(False)
    send(bench, board, 0x11)
    pins["direction_in"].drive(cw)
    pins["at_zero"].drive(False)
    found = []
    for level in (True, False, True):
        pins["step_in"].drive(level)
        bench.run(0.003)  # much longer than the pulse of any range
        found.append(levels(board))
    active = (True, not cw, cw)
    assert found == [active, (False, True, True), active]
    send(bench, board, 0x10, seconds=0.001)
    assert not pins["step"].level


@pytest.mark.parametrize("how", ["command", "switch"])
def test_a_pulse_of_the_test_function_lasts_one_to_two_microseconds(bench, board, how):
    """Functional check: "Each motor pulse will be seen as a one to two microsecond, high going, pulse"."""
    if how == "command":
        send(bench, board, 0xFF)
    else:
        board.pins["test_switch"].drive(True)
    assert bench.run_until(lambda: board.axes["motor"].velocity, 1)
    began, seen = board.axes["motor"].train.move.start_ns, []
    for time_ns in (199_999, 200_000, 201_499, 201_500, 399_999, 400_000, 401_499, 401_500):
        bench.run((began + time_ns - bench.now) / 1e9)
        seen.append(board.pins["step"].level)
    assert seen == [False, True, True, False] * 2 and levels(board) == (False, True, True)
    bench.run(0.000_198_5)
    assert levels(board) == (True, True, False)  # the function begins counter-clockwise


# A failed board


@pytest.mark.parametrize("pulled_up", [False, True])
def test_a_failed_boards_outputs_are_in_high_impedance(bench, pulled_up):
    """Status byte, bit 5: outputs of a failed board are in high impedance: their wiring decides their levels."""
    board = ready(bench, high_impedance=pulled_up)
    send(bench, board, 0xFF, seconds=10.1)
    assert board.pins["led"].level
    names = ("output1", "output2", "shutdown", "direction", "remote_acknowledge", "step")
    assert [board.pins[name].level for name in names] == [pulled_up] * 6
    assert (board.pins["cw_step"].level, board.pins["ccw_step"].level) == (True, True)
    board.bus.init()
    bench.run(1.01)
    assert levels(board) == (False, True, True)
    assert [board.pins[name].level for name in ("output1", "output2", "shutdown")] == [True, True, False]


# Joystick motion: 11h, A0h, A1h, A4h, A5h


def armed(bench, board, *codes):
    for code in codes or (0xA0, 0xA1, 0xA4, 0xA5):
        send(bench, board, code, 1)


def test_leaving_zero_velocity_is_the_start_of_a_move(bench, board):
    """11h: "from zero velocity to a nonzero velocity and back to zero velocity is considered a move"."""
    armed(bench, board)
    send(bench, board, 0x11)
    assert messages(bench, board) == []
    at_zero, found = board.pins["at_zero"], []
    for level in (False, True, False, True):
        at_zero.drive(level)
        found.append(messages(bench, board))
    assert found == [["a0 00", "a1 00"], ["a4 00", "a5 00"], ["a1 00"], ["a5 00"]]
    send(bench, board, 0x10)
    assert messages(bench, board) == []


def test_a_power_cut_under_the_joystick_sends_nothing(bench, board):
    armed(bench, board)
    send(bench, board, 0x11)
    board.pins["at_zero"].drive(False)
    messages(bench, board)
    said = []
    board.bus.subscribe_received(said.append)
    board.power(False)
    bench.run(1)
    assert said == []


# Options


@pytest.mark.parametrize("option", ["interrupt_command", "encoder_commands", "stop_after_stream"])
def test_a_reading_that_does_not_exist(bench, option):
    with pytest.raises(UsageError, match=f"{option}='none': expected one of"):
        bench.add("1811", **{option: "none"})


# What the board has set, and what is at the terminal


@scripts({
    '97h: "The state returned is the programmed state of the programmable output bits"':
    "output1 low; output2 low; 97 -> 06; 0C 01; output1 high; 97 -> 04",
    "a shutdown terminal that is overpowered stops no move: 12h and 13h decide on a shutdown, not the level of "
    "the terminal, which is an output":
    "shutdown high; default 1000 at_once; 33 =10; idle; at 10; shutdown low; 12 01; 33 =10; 0.1 s; at 10",
    'Remote power shutdown: not "if the motor is moving"; it acts if the input is still active at rest':
    "13 01; default 1000 at_once; 33 =500; 0.1 s; shutdown_in low; shutdown is low; idle; at 500; shutdown is high",
    "0Fh: the bit shows whether the motor moves; a value written by 08h or 09h stays until this state changes":
    "0F 00 01 01; SB & 1 is 0; {08|09} {01|00}; SB & 1 is 1; default 1000 at_once; 33 =5; idle; SB & 1 is 0",
    '2Fh: "within the absolute closed-loop positioning range": as in 9Ah, 80000000h to 7FFFFFFFh (1)':
    "2F =at_once; 9A -> 7F FF FF FF",
    '2Fh: "within the absolute closed-loop positioning range": as in 9Ah, 80000000h to 7FFFFFFFh (2)':
    "2F =-2147483648; 9A -> 80",
    'Specifications: "response will be within 200 microseconds for #1"':
    "AC 01 01; trigger1 low; 0.003 s; trigger1 high; 0.000199 s; trigger1 low; says nothing; trigger1 low; "
    "0.003 s; trigger1 high; 0.0003 s; trigger1 low; says AC 01; idle",
    "a joystick that is deflected when it is enabled begins a move":
    "A0 01; A1 01; A4 01; A5 01; at_zero low; says nothing; 11; says A0 00, A1 00",
    '10h: "Disabling of the Joystick occurs whether or not the motor is moving"; A4h: "arrives at zero velocity"':
    "A4 01; A5 01; 11; at_zero low; 0.05 s; {10|73}; says A4 00, A5 00; at_zero high; says nothing",
    "A0h: \"the current move will not cause an interrupt\"; the request is for the joystick's next move":
    "11; at_zero low; 0.01 s; A0 01; A1 01; A4 01; A5 01; at_zero high; says A4 00, A5 00; at_zero low; "
    "says A0 00, A1 00",
    "A2h, A3h: the joystick's pulses pass through the board, which has no constant velocity of its own to report":
    "A2 01; A3 01; 11; 0.02 s; stick 1000; 1 s; says nothing",
    'Trigger inputs: "a hold time of 500 microseconds to be recognized, and Trigger 6 requires 1 millisecond"':
    "1811 {trigger1_hold_us=500|trigger6_hold_us=1000}; AC {01|06} 01; {trigger1|trigger6} low; 0.003 s; "
    "{trigger1|trigger6} high; {0.000499|0.000999} s; {trigger1|trigger6} low; says nothing; {trigger1|"
    "trigger6} low; 0.003 s; {trigger1|trigger6} high; {0.000501|0.001001} s; {trigger1|trigger6} low; "
    "says AC {01|06}",
    '86h: "current acceleration"; at rest and at constant velocity that of the most recent move, before any move '
    "0 (1)": "default 1000 7000 17; 85 -> 00; 33 =5; idle; 85 -> 11",
    '86h: "current acceleration"; at rest and at constant velocity that of the most recent move, before any move '
    "0 (2)": "default 1000 7000 17; 86 -> 00; 33 =5; idle; 86 -> 11 00 00 1B 58",
})  # fmt: skip
def test_step_outputs(bench, script):
    play(bench, script)


@pytest.mark.parametrize(("pin", "code", "cw"), [("cw_limit", 0xA9, True), ("ccw_limit", 0xAB, False)])
def test_a_limit_under_the_joystick_is_told_and_stops_nothing(bench, board, pin, code, cw):
    """REMOTE ACKNOWLEDGE: "Striking a limit switch will not disable the Joystick"; limits are reported only."""
    send_all(bench, board, (code, 1), (0x11,), seconds=0.02)
    board.joystick.deflect(1_000 if cw else -1_000)
    bench.run(0.1)
    before = board.axes["motor"].position
    board.pins[pin].drive(True)
    bench.run(0.1)
    assert abs(board.axes["motor"].position - before) == pytest.approx(100, abs=1)
    assert board.pins["remote_acknowledge"].level and messages(bench, board) == [f"{code:02x} 00"]


def test_a_message_that_waits_and_an_empty_idb_are_both_in_the_status_byte(bench):
    """Installation: the first interrupt masks others on the line; status bits 3 to 5 show the present conditions."""
    board, edges = ready(bench, interrupts=("message_ready", "input_ready")), []
    board.bus.write(1, 0x40)
    board.bus.interrupt_line.subscribe(lambda pin: edges.append(pin.level))
    send(bench, board, 0x8C, seconds=0.05)
    assert board.bus.read(1) & 0x98 == 0x18
    board.bus.write(1, 0x40)
    assert board.bus.read(1) & 0x98 == 0x98 and edges == [False, True]
