"""Report-back functions: motion status K, quick status Q, busy status E, input status I, communication status F."""

import pytest

from axistwin import Bench

from .talking import (
    ask,
    command,
    moves,
    number,
    play,
    positions,
    ready,
    scripts,
    send,
    status,
    status_word,
    times,
    until_idle,
    write,
)

# A slow ramp, to have time to look at it: 1000 steps/s2 from 400 to 5000 in steps of 100 are 46 levels of 100 ms,
# 4.6 s and 46 x (400 + 4900) / 2 x 0.1 = 12190 steps each way.
SLOW = "^1 @5000"
RAMP_S = 4.6


@pytest.fixture
def slow(bench, if1):
    """Return an IF1 that takes 4.6 s to reach its programmed speed."""
    command(bench, if1, SLOW, seconds=1.2)
    return if1


def test_the_motion_status_of_an_index_from_the_start_to_the_end(bench, slow):
    """Motion status: 1 in motion, 2 at programmed speed, 4 accelerating, 8 decelerating."""
    assert status_word(bench, slow) == 0
    command(bench, slow, "X40000$", seconds=0.1)
    for _ in range(8):
        assert status_word(bench, slow) == 5
        bench.run(0.45)
    # 4.1 s have passed; up until 4.6 s, then 40000 - 24380 = 15620 steps at 5000/s: 3.124 s; down from 7.724 s to
    # 12.324 s
    bench.run(0.8)
    for _ in range(4):
        assert status_word(bench, slow) == 3
        bench.run(0.5)
    bench.run(1.0)
    for _ in range(8):
        assert status_word(bench, slow) == 9
        bench.run(0.4)
    bench.run(1.5)
    assert (status_word(bench, slow), positions(slow)) == (0, (40000, 0, 0))


def test_a_move_without_a_ramp_is_at_programmed_speed_from_beginning_to_end(bench, if1):
    """Start/stop speed: below it "no acceleration is applied and the clock will run at a fixed frequency"."""
    write(if1, "X400@400$")
    for _ in range(9):
        assert status_word(bench, if1) == 3
        bench.run(0.05)
    bench.run(0.2)
    assert status_word(bench, if1) == 0


def test_a_short_index_is_at_programmed_speed_at_no_time(bench, slow):
    """Motion status: 2, "At Programmed Speed", is not set on the plateau of a short index, where K is 1."""
    write(slow, "X20000$")
    bench.run_until(lambda: slow.axes["X"].moving, 1.0)
    # 41 levels of 100 ms take 9840 steps, 42 would take 10290; 320 are left over at 4500/s: 71 ms from 4.1 s on
    assert sum(range(40, 450, 10)) == 9840
    bench.run(4.05)
    assert (status_word(bench, slow), status_word(bench, slow)) == (5, 1)
    bench.run(0.05)
    assert status_word(bench, slow) == 9


def test_the_return_of_a_backlash_correction_is_in_motion_and_no_more(bench, if1):
    """Motion status: K is 1, as the correction runs at start/stop speed, not at programmed speed, without a ramp."""
    write(if1, "B-200", "X100@200B$")  # 300 steps at 200/s, a pause of 3 ms, 200 back at 400/s
    bench.run(1.0)
    assert status_word(bench, if1) == 3
    bench.run(0.6)
    assert moves(if1.axes["X"])[0] == 300
    assert (status_word(bench, if1), status(bench, if1, "E")) == (1, "E")
    bench.run(0.5)
    assert (status_word(bench, if1), status(bench, if1, "E")) == (0, "C")


def test_a_cancelled_index_is_decelerating(bench, slow):
    """Index mode: "cancel"; the motion status is 9 until the motor is at rest."""
    command(bench, slow, "X90000$", seconds=6.0)
    command(bench, slow, "#", seconds=0.1)
    assert status_word(bench, slow) == 9
    bench.run(RAMP_S)
    assert status_word(bench, slow) == 0


def test_an_emergency_stop_while_decelerating_is_41(bench, slow):
    """Motion status: "41 would indicate the interface has had an emergency stop and is decelerating"."""
    command(bench, slow, "X90000$", seconds=6.0)
    slow.pins["estop"].drive(False)
    bench.run(0.5)
    assert ask(bench, slow, "K", 0.05) == b"41\r"
    bench.run(RAMP_S)
    assert ask(bench, slow, "K", 0.05) == b"32\r"


@scripts(
    {
        'Quick status: "73 decimal or 49 hex", "a limit input has appeared whilst an axis is ... decelerating"':
        "X90000$; 6 s; limit_plus low; 0.5 s; Q: 73",
        "Motion status: 1 + 8 + 64": "X90000$; 6 s; limit_plus low; 0.5 s; K: 73",
    }
)  # fmt: skip
def test_limit_while_decelerating(bench, slow, script):
    play(bench, slow, script)


@pytest.mark.parametrize("form", ["U31", "U41", "U71", "U81"])
def test_quick_status_is_one_raw_byte_without_an_end(bench, form):
    """Quick status: "a single 8 bit byte", "only applies in 8-bit mode with bit 8 = 1 or data"."""
    if1 = ready(bench, form)
    assert ask(bench, if1, "Q") == b"\0"
    command(bench, if1, "X9000@400$", seconds=0.1)
    assert ask(bench, if1, "Q") == b"\x03"
    command(bench, if1, "!", seconds=0.1)
    assert ask(bench, if1, "Q") == b"\x83"


@pytest.mark.parametrize("form", ["U11", "U21", "U51", "U61"])
def test_quick_status_without_a_free_eighth_bit_comes_with_bit_7_cleared(bench, form):
    """R18: with 7 bits, or bit 8 = 0, "a reply is better than a hang"."""
    if1 = ready(bench, form)
    command(bench, if1, "!", seconds=0.1)
    command(bench, if1, "X9000@400$", seconds=0.1)
    assert (ask(bench, if1, "K"), ask(bench, if1, "Q")) == (b"131\r", b"\x03")


def test_quick_status_has_no_end_in_the_v_format_either(bench):
    """Quick status: one byte without a terminator, in the V format too."""
    if1 = ready(bench, "V31")
    assert (ask(bench, if1, "Q", end="\n"), ask(bench, if1, "K", end="\n")) == (b"\0", b"0\r\n")


def test_figures_come_without_padding(bench, if1):
    """R17: the answer has no blank, although the manual prints " 527 <CR>"."""
    write(if1, "X527$")
    until_idle(bench, if1)
    assert ask(bench, if1, "N") == b"527\r"
    assert [ask(bench, if1, letter) for letter in "KFIO"] == [b"0\r", b"0\r", b"200\r", b"0\r"]


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


@pytest.mark.parametrize("text", ["KF", "K$", "X10K", "K10", "Q1", "E$", "N0", "k", "K,"])
def test_a_status_request_stands_alone(bench, if1, text):
    """Report-back: a request with anything else in the message is a data fault (R7)."""
    send(bench, if1, text, seconds=0.3)
    assert (number(bench, if1, "F"), positions(if1)) == (8, (0, 0, 0))


def test_spaces_in_a_status_request_are_ignored(bench, if1):
    """Spaces "will simply be ignored"."""
    assert ask(bench, if1, "  K ") == b"0\r"


# Busy status


@scripts(
    {
        'Busy status: "E <CR>" if it is busy and "C <CR>" if it is clear for new data or commands" (R20)':
        "E: C; X400@400$; E: E; 2 s; E: C",
        'Busy status: ""motionless" activities such as waiting for inputs and pulsing outputs"':
        "input1 low; H1X10@400$; 0.1 s; E: E; K: 0; input1 high; 0.2 s; E: C; K: 0; P3,40$; 0.1 s; E: E; "
        "K: 0; 0.3 s; E: C; K: 0",
        "Input status: 8 + 64 + 128 for inputs 1 to 3 without current": "I: 200",
        'Input status: "will read all inputs"; resetting needs a motion status request':
        "estop low; 0.1 s; I: 201; estop released; 0.1 s; I: 200; K: 32",
        'Clearing: "If the "F" command is not sent, movement will not be inhibited"':
        "!; X100@400$; 0.5 s; at 100 0 0; K: 128",
        'IN BATTERY-BACKUP MODE: "not in fact a fault condition but simply indicates that ... data has been locked"':
        "[; 0.1 s; K: 0; F: 32; F: 32; ]; 0.1 s; K: 0; F: 0",
    }
)  # fmt: skip
def test_requests_and_answers(bench, if1, script):
    play(bench, if1, script)


def test_busy_status_is_f_with_each_kind_of_fault(bench, if1):
    """Busy status: ""F <CR>" if there is a fault condition", that is any of K 16, 32, 64 and 128 (R20)."""
    for name, bit in (("x_fault", 16), ("y_fault", 16), ("estop", 32), ("limit_plus", 64), ("limit_minus", 64)):
        pin = if1.pins[name]
        pin.drive(not pin.level)
        bench.run(0.1)
        pin.release()
        bench.run(0.1)
        assert (name, status(bench, if1, "E")) == (name, "F")
        assert (name, status_word(bench, if1)) == (name, bit)
        assert (name, status(bench, if1, "E")) == (name, "C")
    command(bench, if1, "?", seconds=0.1)
    assert (status(bench, if1, "E"), number(bench, if1, "F"), status(bench, if1, "E")) == ("F", 8, "C")


def test_locked_comes_before_fault_and_fault_before_busy(bench, if1):
    """R20: E answers `[` if locked, otherwise F in a fault, otherwise E if busy, otherwise C."""
    write(if1, "?", "X4000@400$")
    assert status(bench, if1, "E") == "F"
    write(if1, "[")
    assert status(bench, if1, "E") == "["
    write(if1, "]")
    number(bench, if1, "F")
    assert status(bench, if1, "E") == "E"
    command(bench, if1, "#", seconds=0.1)
    assert status(bench, if1, "E") == "C"


def test_nothing_is_answered_during_a_ramp_calculation_but_everything_afterwards(bench, if1):
    """Report-back: "except for a period of about 1 second following receipt of new acceleration ... data"; sample 7."""
    command(bench, if1, "X400@400^20$", "E", seconds=0.95)
    assert if1.serial.read() == b"" and positions(if1) == (0, 0, 0)
    bench.run(0.15)
    assert if1.serial.read() == b"E\r" and positions(if1)[0] > 0


# Input status


@pytest.mark.parametrize(
    ("pin", "value"),
    [("estop", 1), ("x_fault", 2), ("y_fault", 4), ("input1", 8), ("limit_plus", 16), ("limit_minus", 32),
     ("input2", 64), ("input3", 128)],
)  # fmt: skip
def test_an_input_returns_its_value_when_there_is_no_current(bench, if1, pin, value):
    """Input status: "all inputs return their corresponding value when there is NO current in the diode"."""
    fault = pin.endswith("fault")  # the normal level is high, see the manual's table; of the others it is low
    normal = if1.pins[pin].level
    for name in ("input1", "input2", "input3"):
        if1.pins[name].drive(True)
    bench.run(0.01)
    assert number(bench, if1, "I") == 0
    if1.pins[pin].drive(not normal if fault else False)
    bench.run(0.01)
    assert number(bench, if1, "I") == value
    if1.pins[pin].drive(normal if fault else True)
    bench.run(0.01)
    assert number(bench, if1, "I") == 0


# Communication status


def test_each_communication_fault_has_its_bit(bench):
    """Motion status, table of data faults: 1 parity, 2 overrun, 4 framing, 8 data fault, 16 out-of-range."""
    if1 = ready(bench, "U44")  # even parity, 2 stop bits
    if1.serial.to_device.flip(1)
    if1.serial.write(b"A")
    bench.run(0.1)
    assert ask(bench, if1, "F") == b"1\r"
    if1.serial.host.stopbits = 1
    if1.serial.host.parity = "N"
    if1.serial.host.baudrate = 4800
    if1.serial.write(b"\0\0")
    bench.run(0.1)
    if1.serial.host.stopbits, if1.serial.host.parity, if1.serial.host.baudrate = 2, "E", 9600
    command(bench, if1, "#", seconds=0.1)
    assert number(bench, if1, "F") & 4
    command(bench, if1, "@30000", seconds=0.1)
    assert number(bench, if1, "F") == 16
    command(bench, if1, "%%%", seconds=0.1)
    assert number(bench, if1, "F") == 8


def test_faults_add_up_until_f_clears_them_all(bench, if1):
    """Clearing: "Failure to do this may result in incorrect fault data being received at a later time"."""
    for text in ("@30000", "!", "#"):
        write(if1, text)
    bench.run(0.1)
    assert status_word(bench, if1) == 128
    assert status_word(bench, if1) == 128  # K does not clear it
    assert ask(bench, if1, "Q") == b"\0"  # bit 8 is 0 in this format
    assert (status_word(bench, if1), number(bench, if1, "F"), number(bench, if1, "F")) == (128, 24, 0)
    assert status_word(bench, if1) == 0


def test_a_communication_fault_does_not_light_the_led(bench, if1):
    """R27: the LED is lit only for the conditions of the chapter: fault, limit and emergency stop."""
    command(bench, if1, "!", seconds=0.1)
    assert status_word(bench, if1) == 128
    assert not if1.pins["led"].level
