"""Configuring the interface: Initialisation."""

import itertools

import pytest

from axistwin import Bench
from axistwin.units import MS, S

from .talking import arrivals, ask, command, detect, edges, faults, initialise, ready, send, write

BAUD_RATES = (110, 300, 600, 1200, 2400, 4800, 9600)
FRAMES = tuple(range(1, 9))
PARITIES = tuple(range(1, 10))


def test_the_led_comes_on_for_about_a_second_when_power_is_applied(bench):
    """Initialisation: "When power is first applied, the LED comes on for approximately 1 second"."""
    if1 = bench.add("if1")
    led = edges(if1.pins["led"])
    assert if1.pins["led"].level
    bench.run(5)
    assert led == [(1 * S, False)]


def test_the_led_stays_off_until_the_bracket_comes(bench):
    """R1: between the first second and `(` the LED is off; flashing starts at `(`."""
    if1 = bench.add("if1")
    bench.run(1.001)
    assert not if1.pins["led"].level and not if1.pins["led"].flashing


def test_characters_during_the_self_test_are_ignored(bench):
    """Initialisation: "during this time the interface runs through its internal initialisation routine"."""
    if1 = bench.add("if1")
    for _ in range(9):
        if1.serial.write(b"(")
        bench.run(0.1)
    bench.run(1)
    assert if1.serial.read() == b"" and not if1.pins["led"].flashing
    assert send(bench, if1, "(", seconds=0.1, end="") == b"U\r"


def test_the_self_test_may_take_another_time(bench):
    """Initialisation: "approximately 1 second": an option (ruling 2)."""
    if1 = bench.add("if1", self_test_s=0.25)
    led = edges(if1.pins["led"])
    bench.run(0.3)
    assert led == [(250 * MS, False)]
    assert send(bench, if1, "(", seconds=0.1, end="") == b"U\r"


@pytest.mark.parametrize("baud", BAUD_RATES)
def test_the_bracket_tells_the_baud_rate_and_u_comes_back_at_it(bench, baud):
    """Initialisation: "then transmits a "U" character at the new baud rate", "followed by a carriage return"."""
    if1 = bench.add("if1", line=f"{baud} 8N2")
    bench.run(1.5)
    received = arrivals(bench, if1)
    if1.serial.write(b"(")
    bench.run(1.0)
    assert [(byte, bool(errors)) for _, byte, errors in received] == [(0x55, False), (0x0D, False)]
    # Default format: 8 data bits, no parity, 2 stop bits, so 11 bits from character to character.
    assert received[1][0] - received[0][0] == pytest.approx(11 * S / baud, abs=1)


@pytest.mark.parametrize("frame", ["7E1", "7O1", "7N2", "8N1", "8E2", "8O1"])
def test_the_bracket_is_measured_whatever_frame_the_host_sends(bench, frame):
    """Initialisation: "The IF1 will receive this character and from it will determine the baud rate".

    28h is sent as 0,0,0,1...: with the start bit the line is low for four bits in every frame.
    """
    if1 = bench.add("if1", line=f"1200 {frame}")
    bench.run(1.5)
    received = arrivals(bench, if1)
    if1.serial.write(b"(")
    bench.run(0.2)
    assert [byte & 0x7F for _, byte, _ in received] == [0x55, 0x0D]


def test_missing_the_u_costs_nothing_but_another_bracket(bench):
    """Initialisation: "it can transmit another open bracket "(" ... This may be repeated as often as necessary"."""
    if1 = bench.add("if1")
    bench.run(1.5)
    if1.serial.from_device.lose(2)
    assert send(bench, if1, "(", seconds=0.1, end="") == b""
    for _ in range(20):
        assert send(bench, if1, "(", seconds=0.1, end="") == b"U\r"


def test_the_baud_rate_is_measured_on_the_first_bracket_only(bench):
    """Initialisation: "the interface only detects the baud rate on the first "(" received"."""
    if1 = bench.add("if1", line="9600 8N2")
    detect(bench, if1)
    if1.serial.host.baudrate = 4800
    assert send(bench, if1, "(", seconds=0.5, end="") == b""
    if1.serial.host.baudrate = 9600
    assert send(bench, if1, "\r(", seconds=0.5, end="") == b"U\r"


@pytest.mark.parametrize("character", [b"U", b"X", b"\r", b"\n", b"\x00", b"\xff", b"H", b"V61\r"])
def test_only_the_bracket_is_understood_before_the_baud_rate_is_known(bench, character):
    """Initialisation: "the controller should transmit the open bracket"; an H also begins with four low bits."""
    if1 = bench.add("if1", line="2400 8N2")
    bench.run(1.5)
    if1.serial.write(character)
    bench.run(0.2)
    assert if1.serial.read() == b"" and not if1.pins["led"].flashing
    if1.serial.host.baudrate = 9600
    assert send(bench, if1, "(", end="") == b"U\r"


def test_the_led_flashes_twice_per_second_from_the_bracket_on(bench):
    """Initialisation: "At this point the LED flashes twice per second"."""
    if1 = bench.add("if1")
    bench.run(1.5)
    led = edges(if1.pins["led"])
    if1.serial.write(b"(")
    bench.run(3.0)
    assert [level for _, level in led] == [n % 2 == 0 for n in range(len(led))]
    assert {after - before for (before, _), (after, _) in itertools.pairwise(led)} == {250 * MS}
    assert len(led) in (11, 12)


def test_the_led_ceases_flashing_on_the_data_format_message(bench):
    """Initialisation: "Following correct receipt of the data format message, the LED will cease flashing"."""
    if1 = bench.add("if1")
    detect(bench, if1)
    command(bench, if1, "U61", seconds=0.02)
    assert not if1.pins["led"].flashing and not if1.pins["led"].level


def test_u_format_messages_end_with_carriage_return_both_ways(bench):
    """Initialisation: "the interface expects only <CR> to terminate all subsequent messages"."""
    if1 = ready(bench, "U61")
    assert (ask(bench, if1, "E"), ask(bench, if1, "K")) == (b"C\r", b"0\r")


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_v_format_messages_end_with_line_feed_and_replies_with_both(bench, end):
    """Initialisation: "will terminate all returned data with <CR><LF>"; "<CR> before <LF> is optional"."""
    if1 = bench.add("if1")
    detect(bench, if1)
    command(bench, if1, "V61", seconds=1.2, end=end)
    assert (ask(bench, if1, "E", end=end), ask(bench, if1, "F", end=end)) == (b"C\r\n", b"0\r\n")


def test_in_v_format_carriage_return_alone_ends_nothing(bench):
    """Initialisation: "all following instructions must be terminated by <LF>"."""
    if1 = ready(bench, "V61")
    assert (ask(bench, if1, "E", end="\r"), ask(bench, if1, "", end="\n")) == (b"", b"C\r\n")


def test_the_answer_to_the_bracket_ends_in_carriage_return_alone_whatever_comes_later(bench):
    """Initialisation: "The "U" will be followed by a carriage return": the format is not yet known."""
    if1 = bench.add("if1")
    detect(bench, if1)  # asserts U CR
    assert send(bench, if1, "V6", seconds=0.1, end="") == b""


@pytest.mark.parametrize("stray", ["\r", "\n", "\r\n", " ", "   \r\n"])
def test_stray_terminators_and_spaces_before_the_format_message_do_no_harm(bench, stray):
    """Appendix 3, samples 4, 6 and 8 send them between `(` and the data format message."""
    if1 = bench.add("if1")
    detect(bench, if1)
    write(if1, stray, end="")
    command(bench, if1, "U61", seconds=1.2)
    assert (ask(bench, if1, "E"), ask(bench, if1, "F")) == (b"C\r", b"0\r")


def test_the_format_message_may_hold_spaces(bench):
    """Initialisation: "a message of the form "U X1 X2 <CR>""; spaces "will simply be ignored"."""
    if1 = bench.add("if1")
    detect(bench, if1)
    command(bench, if1, "U 6 1 ", seconds=1.2)
    assert ask(bench, if1, "E") == b"C\r"


WRONG = ["U", "U6", "U611", "U01", "U91", "U60", "U6A", "61", "X61", "u61", "U16U", "W61", "61U", "6U1", "U-1", "U6 "]


@pytest.mark.parametrize("wrong", WRONG)
def test_a_wrong_format_message_is_dropped_and_may_be_sent_again(bench, wrong):
    """Initialisation: "If an error is made in transmitting any character, the whole string may be retransmitted".

    R3: silent, no bit in F, and the LED goes on flashing.
    """
    if1 = bench.add("if1")
    detect(bench, if1)
    command(bench, if1, wrong, seconds=1.3)
    assert if1.serial.read() == b"" and if1.pins["led"].flashing
    command(bench, if1, "U61", seconds=1.3)
    assert not if1.pins["led"].flashing
    assert (ask(bench, if1, "K"), ask(bench, if1, "F")) == (b"0\r", b"0\r")


def test_the_order_of_the_format_message_is_fixed(bench):
    """Initialisation: the characters "MUST be sent in the ordered sequence shown": U13 differs from U31."""
    if1 = ready(bench, "U13")  # 7 data bits, odd parity, 1 stop bit
    assert (ask(bench, if1, "K"), ask(bench, if1, "F")) == (b"0\r", b"0\r")


def test_characters_directly_after_the_format_message_are_processed(bench):
    """R2: "allow a delay of at least 5mS"; a host that does not wait is accepted too, and answered later."""
    if1 = bench.add("if1", line="9600 8N2")
    detect(bench, if1)
    assert send(bench, if1, "U61\rE", seconds=1.3) == b"C\r"


def test_characters_are_lost_for_5_ms_where_that_is_asked_for(bench):
    """Initialisation: "allow a delay of at least 5mS for the UART to re-initialise"; R2: option for the strict mode."""
    if1 = bench.add("if1", line="9600 8N2", strict_format=True)
    detect(bench, if1)
    if1.serial.write(b"U61\rE\r")  # E and CR arrive 1.1 and 2.3 ms after the format message
    bench.run(1.3)
    assert (if1.serial.read(), ask(bench, if1, "E")) == (b"", b"C\r")


def test_in_the_strict_mode_characters_after_5_ms_are_processed(bench):
    """Initialisation: "allow a delay of at least 5mS"."""
    if1 = bench.add("if1", strict_format=True)
    detect(bench, if1)
    write(if1, "U61")
    bench.run_until(lambda: not if1.serial.pending, 1)
    bench.run(0.0012 + 0.001 + 0.005)  # the CR itself, a strobe, and the required delay
    assert send(bench, if1, "E", seconds=1.3) == b"C\r"


def test_a_line_feed_directly_after_the_u_message_is_swallowed(bench):
    """R2: sample 1 sends `U62` CR LF with echo on; its first echo must be `X`, so this LF is dropped."""
    if1 = bench.add("if1", line="9600 8N2")
    detect(bench, if1)
    assert send(bench, if1, "U62\r\nX", seconds=1.3, end="") == b"X"


def test_the_message_that_turns_echo_on_is_not_echoed(bench):
    """Appendix 3, sample 1: nothing is read between the format message and the first command, so nothing is echoed."""
    if1 = bench.add("if1")
    detect(bench, if1)
    assert send(bench, if1, "U62", seconds=1.3) == b""


def test_the_first_ramp_is_calculated_after_the_format_message(bench):
    """Appendix 3, sample 7: "Wait for initial ramp calculation", which takes one second (R12)."""
    if1 = bench.add("if1", line="9600 8N2")
    detect(bench, if1)
    answers = arrivals(bench, if1)
    if1.serial.write(b"U61\rE\r")
    begin = bench.now
    bench.run(1.5)
    first = answers[0][0]
    assert begin + 1 * S <= first <= begin + 1 * S + 20 * MS


def test_a_bracket_once_it_is_ready_is_a_data_fault(bench, if1):
    """R5: the baud rate is measured only once; the samples tell the user to power down before a second run."""
    assert (send(bench, if1, "(", seconds=0.1), faults(bench, if1)) == (b"", (b"128\r", b"8\r"))
    assert faults(bench, if1) == (b"0\r", b"0\r")


@pytest.mark.parametrize("message", ["U61", "V61", "U11", "*"])
def test_a_format_message_once_it_is_ready_is_a_data_fault(bench, if1, message):
    """R5: a second format message is a data fault; only a power cycle allows a new format."""
    command(bench, if1, message, seconds=0.1)
    assert (faults(bench, if1), ask(bench, if1, "E")) == ((b"128\r", b"8\r"), b"C\r")


@pytest.mark.parametrize("moment", [0.2, 1.2, 1.6, 2.0, 4.0])
def test_a_power_cycle_at_any_stage_begins_anew(bench, moment):
    """Initialisation: "When power is first applied"; appendix 3: "reset IF1 by powering down"."""
    if1 = bench.add("if1")
    bench.clock.call_later(int(1.55 * S), lambda: if1.serial.write(b"("))
    bench.clock.call_later(int(1.75 * S), lambda: if1.serial.write(b"U12\r"))
    bench.run(moment)
    if1.power_cycle()
    assert if1.pins["led"].level
    if1.serial.read()
    bench.run(3)
    if1.serial.read()
    if1.power_cycle()
    initialise(bench, if1, "V61")
    assert ask(bench, if1, "E", end="\n") == b"C\r\n"


def test_another_baud_rate_after_a_power_cycle(bench):
    """Baud rate: "The interface senses the baud rate automatically", after each power-up again."""
    if1 = ready(bench, line="9600 8N2")
    if1.power_cycle()
    if1.serial.host.baudrate = 300
    initialise(bench, if1)
    assert ask(bench, if1, "E", 1) == b"C\r"


def test_without_power_all_outputs_are_off_and_nothing_is_answered(bench, if1):
    """Power requirements: without +5 V no LED is lit, nothing is sent, and no output holds its line."""
    command(bench, if1, "S1$", seconds=0.1)
    if1.power(False)
    assert not if1.pins["led"].level and not if1.pins["output1"].level
    assert not if1.serial.dtr and not if1.serial.rts
    assert ask(bench, if1, "E", 2) == b""
    if1.power(True)
    assert ask(bench, if1, "(", 0.5, end="") == b""  # self-test
    bench.run(1)
    assert ask(bench, if1, "(", 0.5, end="") == b"U\r"


def test_messages_sent_during_the_ramp_calculation_are_acted_on_afterwards(bench):
    """Acceleration rate: "it will still accept any characters sent to it, and will act on any commands after"."""
    if1 = bench.add("if1")
    detect(bench, if1)
    command(bench, if1, "U61", "X7$", seconds=0.9)
    assert if1.axes["X"].position == 0
    bench.run(0.3)
    assert if1.axes["X"].position == 7


def test_two_interfaces_on_a_bench_are_independent():
    bench = Bench()
    first, second = bench.add("if1", line="1200 8N2"), bench.add("if2")
    bench.run(1.5)
    first.serial.write(b"(")
    second.serial.write(b"(")
    bench.run(0.2)
    assert (first.serial.read(), second.serial.read()) == (b"U\r", b"U\r")
    command(bench, first, "U61", seconds=1.3)
    assert not first.pins["led"].flashing and second.pins["led"].flashing


def test_a_fault_does_not_light_the_led_before_it_is_ready(bench):
    """Initialisation: off until `(`, flashing until the data format; only then "If the LED comes on again": a fault."""
    if1 = bench.add("if1")
    bench.run(1.2)
    if1.pins["estop"].drive(False)
    bench.run(0.1)
    assert not if1.pins["led"].level
    if1.serial.write(b"(")
    bench.run(0.1)
    assert if1.pins["led"].flashing
    assert if1.serial.read() == b"U\r"
    command(bench, if1, "U61", seconds=1.2)
    assert if1.pins["led"].level and not if1.pins["led"].flashing
    assert ask(bench, if1, "K") == b"32\r"


def test_a_bracket_to_an_initialised_interface_gets_no_answer_and_the_user_is_told_once():
    bench = Bench()
    if1, told = bench.add("if1"), []
    if1.subscribe_hint(told.append)
    bench.run(1.5)
    for message in (b"(", b"U61\r", b"(", b"(\r"):
        if1.serial.write(message)
        bench.run(2)
    assert if1.serial.read() == b"U\r"
    (hint,) = told
    assert "initialised already" in hint and "--reset-on-connect" in hint
