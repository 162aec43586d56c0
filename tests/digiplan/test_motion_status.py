"""Report-back functions: motion status K, quick status Q, busy status E, input status I, communication status F."""

import pytest

from axistwin import Bench

from ..scripts import scripts
from .talking import ask, number, play, ready, times, write

# A slow ramp, to have time to look at it: 1000 steps/s2 from 400 to 5000 in steps of 100 are 46 levels of 100 ms,
# 4.6 s and 46 x (400 + 4900) / 2 x 0.1 = 12190 steps each way.
SLOW = "^1 @5000; 1.2 s; "


@scripts({
    # Up until 4.6 s, then 40000 - 24380 = 15620 steps at 5000/s: 3.124 s; down from 7.724 s to 12.324 s
    "Motion status: 1 in motion, 2 at programmed speed, 4 accelerating, 8 decelerating":
    "K: 0; X40000$; until moving; K: 5; 1 s; K: 5; 1 s; K: 5; 1 s; K: 5; 1.2 s; K: 5; 0.2 s; K: 3; 1 s; K: 3; "
    "1.7 s; K: 3; 0.3 s; K: 9; 1 s; K: 9; 1 s; K: 9; 1 s; K: 9; 1 s; K: 9; 0.3 s; K: 0; at 40000 0 0",
    # 41 levels of 100 ms take 40 + 50 ... + 440 = 9840 steps, 42 would take 10290; 320 are left over at 4500/s:
    # 71 ms from 4.1 s on
    'Motion status: 2, "At Programmed Speed", is not set on the plateau of a short index, where K is 1':
    "X20000$; until moving; 4.05 s; K: 5; K: 1; 0.05 s; K: 9",
    'Index mode: "cancel"; the motion status is 9 until the motor is at rest':
    "X90000$; 6 s; #; 0.1 s; K: 9; 4.6 s; K: 0",
    'Motion status: "41 would indicate the interface has had an emergency stop and is decelerating"':
    "X90000$; 6 s; estop low; 0.5 s; K: 41; 4.6 s; K: 32",
    'Quick status: "73 decimal or 49 hex", "a limit input has appeared whilst an axis is ... decelerating"':
    "X90000$; 6 s; limit_plus low; 0.5 s; Q: 73",
    "Motion status: 1 + 8 + 64": "X90000$; 6 s; limit_plus low; 0.5 s; K: 73",
})  # fmt: skip
def test_motion_status_on_a_slow_ramp(bench, if1, script):
    play(bench, if1, SLOW + script)


@scripts({
    'Start/stop speed: "no acceleration is applied and the clock will run at a fixed frequency": always 3':
    "X400@400$; K: 3; 0.3 s; K: 3; 0.3 s; K: 3; 0.1 s; K: 3; 0.2 s; K: 0",
    # 300 steps at 200/s, a pause of 3 ms, 200 back at 400/s
    "Motion status: K is 1 in the return of a backlash correction, at start/stop and not at programmed speed":
    "B-200; X100@200B$; 1 s; K: 3; until X at 300; 0.05 s; K: 1; E: E; 0.5 s; K: 0; E: C",
    'R17: the answer has no blank, although the manual prints " 527 <CR>"':
    "X527$; idle; N; 0.2 s; receives 527<CR>; K: 0; F: 0; I: 200; O: 0",
    'Spaces: in a status request, too, spaces "will simply be ignored"': "sends   K <CR>; 0.2 s; receives 0<CR>",
    'Busy status: "E <CR>" if it is busy and "C <CR>" if it is clear for new data or commands" (R20)':
    "E: C; X400@400$; E: E; 2 s; E: C",
    'Busy status: ""motionless" activities such as waiting for inputs and pulsing outputs"':
    "input1 low; H1X10@400$; 0.1 s; E: E; K: 0; input1 high; 0.2 s; E: C; K: 0; P3,40$; 0.1 s; E: E; "
    "K: 0; 0.3 s; E: C; K: 0",
    'Busy status: ""F <CR>" if there is a fault condition", that is any of K 16, 32, 64 and 128 (R20)':
    "x_fault low; 0.1 s; x_fault released; 0.1 s; E: F; K: 16; E: C; y_fault low; 0.1 s; y_fault released; "
    "0.1 s; E: F; K: 16; E: C; estop low; 0.1 s; estop released; 0.1 s; E: F; K: 32; E: C; limit_plus low; "
    "0.1 s; limit_plus released; 0.1 s; E: F; K: 64; E: C; limit_minus low; 0.1 s; limit_minus released; "
    "0.1 s; E: F; K: 64; E: C; ?; 0.1 s; E: F; F: 8; E: C",
    "R20: E answers `[` if locked, otherwise F in a fault, otherwise E if busy, otherwise C":
    "?; X4000@400$; E: F; [; E: [; ]; F: 8; E: E; #; 0.1 s; E: C",
    'Report-back: "except for a period of about 1 second following receipt of new acceleration ... data"; sample 7':
    "X400@400^20$; E; 0.95 s; at 0 0 0; 0.15 s; receives E<CR>; X between 1 399",
    "Input status: 8 + 64 + 128 for inputs 1 to 3 without current": "I: 200",
    'Input status: "will read all inputs"; resetting needs a motion status request':
    "estop low; 0.1 s; I: 201; estop released; 0.1 s; I: 200; K: 32",
    'Clearing: "If the "F" command is not sent, movement will not be inhibited"':
    "!; X100@400$; 0.5 s; at 100 0 0; K: 128",
    'IN BATTERY-BACKUP MODE: "not in fact a fault condition but simply indicates that ... data has been locked"':
    "[; 0.1 s; K: 0; F: 32; F: 32; ]; 0.1 s; K: 0; F: 0",
    'Clearing: "Failure to do this may result in incorrect fault data being received at a later time"':
    "@30000; !; #; 0.1 s; K: 128; K: 128; Q: 0; K: 128; F: 24; F: 0; K: 0",  # bit 8 of Q is 0 in this format
    "R27: the LED is lit only for the conditions of the chapter, not for a communication fault":
    "!; 0.1 s; K: 128; led is low",
    "Report-back: a request with anything else in the message is a data fault (R7)":
    "sends {KF|K$|X10K|K10|Q1|E$|N0|k|K,}<CR>; 0.3 s; at 0 0 0; F: 8",
})  # fmt: skip
def test_requests_and_answers(bench, if1, script):
    play(bench, if1, script)


@pytest.mark.parametrize("form", ["U31", "U41", "U71", "U81"])
def test_quick_status_is_one_raw_byte_without_an_end(bench, form):
    """Quick status: "a single 8 bit byte", "only applies in 8-bit mode with bit 8 = 1 or data"."""
    play(bench, ready(bench, form), "Q: 0; X9000@400$; 0.1 s; Q: 3; !; 0.1 s; Q: 131")


@pytest.mark.parametrize("form", ["U11", "U21", "U51", "U61"])
def test_quick_status_without_a_free_eighth_bit_comes_with_bit_7_cleared(bench, form):
    """R18: with 7 bits, or bit 8 = 0, "a reply is better than a hang"."""
    play(bench, ready(bench, form), "!; 0.1 s; X9000@400$; 0.1 s; K: 131; Q: 3")


def test_quick_status_has_no_end_in_the_v_format_either(bench):
    """Quick status: one byte without a terminator, in the V format too."""
    if1 = ready(bench, "V31")
    assert (ask(bench, if1, "Q", end="\n"), ask(bench, if1, "K", end="\n")) == (b"\0", b"0\r\n")


def test_status_requests_need_no_dollar_and_do_not_disturb_motion(bench):
    """Report-back: "The interface can be interrogated to establish its status at any time"."""

    def pulses(asked: str) -> list[int]:
        bench = Bench()
        if1 = ready(bench)
        write(if1, "X3000@2000$")
        for letter in asked:
            bench.run(0.05)
            write(if1, letter)
        bench.run(10.0)
        assert len(if1.serial.read()) > len(asked) // 2
        return times(if1.axes["X"])

    assert pulses("KFIOQEN" * 4) == pulses("K")


# Input status


@pytest.mark.parametrize(("pin", "value"), [
    ("estop", 1), ("x_fault", 2), ("y_fault", 4), ("input1", 8), ("limit_plus", 16), ("limit_minus", 32),
    ("input2", 64), ("input3", 128)])  # fmt: skip
def test_an_input_returns_its_value_when_there_is_no_current(bench, if1, pin, value):
    """Input status: "all inputs return their corresponding value when there is NO current in the diode"."""
    # the normal level of the fault inputs is high, see the manual's table; of the others it is low
    level = not if1.pins[pin].level if pin.endswith("fault") else False
    play(bench, if1, "input1 high; input2 high; input3 high; 0.01 s; I: 0")
    for driven, answer in ((level, value), (not level, 0)):
        if1.pins[pin].drive(driven)
        play(bench, if1, f"0.01 s; I: {answer}")


# Communication status


def test_each_communication_fault_has_its_bit(bench):
    """Motion status, table of data faults: 1 parity, 2 overrun, 4 framing, 8 data fault, 16 out-of-range."""
    if1 = ready(bench, "U44")  # even parity, 2 stop bits
    if1.serial.to_device.flip(1)
    play(bench, if1, "sends A; 0.1 s; F: 1; host stopbits 1; host parity N; host baudrate 4800")
    if1.serial.write(b"\0\0")
    bench.run(0.1)
    play(bench, if1, "host stopbits 2; host parity E; host baudrate 9600; #; 0.1 s")
    assert number(bench, if1, "F") & 4
    play(bench, if1, "@30000; 0.1 s; F: 16; %%%; 0.1 s; F: 8")
