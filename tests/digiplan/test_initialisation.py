"""Configuring the interface: Initialisation."""

import pytest

from axistwin import Bench
from axistwin.core.units import MS, S

from ..scripts import scripts
from .talking import arrivals, ask, command, edges, gaps, initialise, play


@scripts({
    'Initialisation: "during this time the interface runs through its internal initialisation routine"':
    "sends (; 0.3 s; sends (; 0.3 s; sends (; 0.3 s; 1.1 s; led is low; led is steady; ( -> U<CR>",
    'Initialisation: "it can transmit another open bracket "(" ... This may be repeated as often as necessary"':
    "1.5 s; cut back; sends (; 0.1 s; mend back; ( -> U<CR>; ( -> U<CR>; ( -> U<CR>",
    'Initialisation: "the interface only detects the baud rate on the first "(" received"':
    "detect; host 4800; sends (; 0.5 s; host 9600; sends <CR>(; 0.5 s; receives U<CR>",
    'Initialisation: "Following correct receipt of the data format message, the LED will cease flashing"':
    "detect; led is flashing; U61; 0.02 s; led is low; led is steady",
    'Initialisation: "the interface expects only <CR> to terminate all subsequent messages"':
    "detect; U61; 1.2 s; E: C; K: 0",
    'Initialisation: "will terminate all returned data with <CR><LF>"; "<CR> before <LF> is optional"':
    "detect; sends V61<LF>; 1.2 s; E<LF> -> C<CR><LF>; F<CR><LF> -> 0<CR><LF>",
    'Initialisation: "all following instructions must be terminated by <LF>"; <CR> alone ends nothing':
    "detect; sends V61<CR><LF>; 1.2 s; sends E<CR>; 0.2 s; <LF> -> C<CR><LF>",
    'Initialisation: "The "U" will be followed by a carriage return" alone: the format is not yet known':
    "detect; sends V6; 0.1 s; ( -> U<CR>",
    'Initialisation, R2: "allow a delay of at least 5mS"; a host that does not wait is answered later':
    "detect; U61; E; 1.3 s; receives C<CR>",
    "R2: sample 1 sends `U62` CR LF with echo on; its first echo must be `X`, so this LF is dropped":
    "detect; sends U62<CR><LF>X; 1.3 s; receives X",
    "Appendix 3, sample 1: nothing is read between the format message and the first command: it is not echoed":
    "detect; U62; 1.3 s",
    'Appendix 3, sample 7: "Wait for initial ramp calculation", which takes one second (R12)':
    "detect; U61; E; 1 s; 0.022 s; receives C<CR>",
    'Baud rate: "The interface senses the baud rate automatically", after each power-up again':
    "detect; U61; 1.2 s; E: C; power off; power on; host 300; detect; U61; 1.5 s; E; 1 s; receives C<CR>",
    "Power requirements: without +5 V no LED is lit, nothing is sent, and no output holds its line":
    "detect; U61; 1.2 s; S1$; 0.1 s; output1 is high; DTR is on; power off; led is low; output1 is low; "
    "DTR is off; RTS is off; E; 2 s; power on; led is high; sends (; 0.5 s; 1 s; sends (; 0.5 s; receives U<CR>",
    'Acceleration rate: "it will still accept any characters sent to it, and will act on any commands after"':
    "detect; U61; X7$; 0.9 s; X at 0; 0.3 s; X at 7",
    'Initialisation: off until `(`, flashing until the data format; only then "If the LED comes on again": a fault':
    "1.2 s; estop low; 0.1 s; led is low; ( -> U<CR>; led is flashing; U61; 1.2 s; "
    "led is high; led is steady; K: 32",
})  # fmt: skip
def test_from_power_up_on(bench, script):
    play(bench, bench.add("if1"), script)


@pytest.mark.parametrize(("options", "off_ns", "seconds"), [({}, S, 5), ({"self_test_s": 0.25}, 250 * MS, 0.3)])
def test_the_led_stays_off_until_the_bracket_comes(bench, options, off_ns, seconds):
    """Initialisation: "When power is first applied, the LED comes on for approximately 1 second": option (ruling 2).

    R1: between the first second and `(` the LED is off; flashing starts at `(`.
    """
    if1 = bench.add("if1", **options)
    led = edges(if1.pins["led"])
    play(bench, if1, f"led is high; {seconds} s; led is steady")
    assert led == [(off_ns, False)]
    play(bench, if1, "( -> U<CR>")


@pytest.mark.parametrize("line", [
    *(f"{baud} 8N2" for baud in (110, 300, 600, 1200, 2400, 4800, 9600)),
    *(f"1200 {frame}" for frame in ("7E1", "7O1", "7N2", "8N1", "8E2", "8O1"))])  # fmt: skip
def test_the_bracket_tells_the_baud_rate_and_u_comes_back_at_it(bench, line):
    """Initialisation: "then transmits a "U" character at the new baud rate", "followed by a carriage return".

    "The IF1 will receive this character and from it will determine the baud rate": 28h is sent as 0,0,0,1...: with the
    start bit the line is low for four bits in every frame.  In the default format of the answer, 8N2, a character has
    11 bits.
    """
    if1 = bench.add("if1", line=line)
    bench.run(1.5)
    received = arrivals(bench, if1)
    if1.serial.write(b"(")
    bench.run(1.0)
    assert [byte & 0x7F for _, byte, _ in received] == [0x55, 0x0D]
    assert received[1][0] - received[0][0] == pytest.approx(11 * S / int(line.split()[0]), abs=1)
    assert "8N2" not in line or not any(errors for _, _, errors in received)


@pytest.mark.parametrize("character", ["U", "X", "<CR>", "<LF>", "<00>", "<FF>", "H", "V61<CR>"])
def test_only_the_bracket_is_understood_before_the_baud_rate_is_known(bench, character):
    """Initialisation: "the controller should transmit the open bracket"; an H also begins with four low bits."""
    script = f"1.5 s; sends {character}; 0.2 s; led is steady; host 9600; ( -> U<CR>"
    play(bench, bench.add("if1", line="2400 8N2"), script)


def test_the_led_flashes_twice_per_second_from_the_bracket_on(bench):
    """Initialisation: "At this point the LED flashes twice per second"."""
    if1 = bench.add("if1")
    bench.run(1.5)
    led = edges(if1.pins["led"])
    if1.serial.write(b"(")
    bench.run(3.0)
    assert [level for _, level in led] == [n % 2 == 0 for n in range(len(led))]
    assert set(gaps(at_ns for at_ns, _ in led)) == {250 * MS} and len(led) in (11, 12)


@pytest.mark.parametrize("message", ["<CR>U61", "<LF>U61", "<CR><LF>U61", "<SP>U61", "<SP>  <CR><LF>U61", "U 6 1<SP>"])
def test_stray_terminators_and_spaces_before_the_format_message_do_no_harm(bench, message):
    """Initialisation: "a message of the form "U X1 X2 <CR>""; spaces "will simply be ignored".

    Appendix 3, samples 4, 6 and 8 send terminators and spaces between `(` and the data format message.
    """
    play(bench, bench.add("if1"), f"detect; sends {message}<CR>; 1.2 s; E: C; F: 0")


WRONG = ["U", "U6", "U611", "U01", "U91", "U60", "U6A", "61", "X61", "u61", "U16U", "W61", "61U", "6U1", "U-1",
         "U6<SP>"]  # fmt: skip


@pytest.mark.parametrize("wrong", WRONG)
def test_a_wrong_format_message_is_dropped_and_may_be_sent_again(bench, wrong):
    """Initialisation: "If an error is made in transmitting any character, the whole string may be retransmitted".

    The characters "MUST be sent in the ordered sequence shown".  R3: silent, no bit in F, and the LED goes on flashing.
    """
    script = f"detect; sends {wrong}<CR>; 1.3 s; led is flashing; U61; 1.3 s; led is steady; K: 0; F: 0"
    play(bench, bench.add("if1"), script)


def test_an_overflow_before_the_data_format_leaves_no_bit_in_f(bench):
    """R3: silent, no bit in F; 61 characters are lost while the answer to `(` waits for the control lines."""
    flood = "detect; host RTS off; sends (; 0.01 s; fill 61; host RTS on; 0.1 s; receives U<CR>; U61; 1.3 s; K: 0; F: 0"
    play(bench, bench.add("if1"), flood)


@scripts({
    'Initialisation: "allow a delay of at least 5mS for the UART to re-initialise": E 1.1 ms, CR 2.3 ms later':
    "detect; U61; E; 1.3 s; E: C",
    # the format message ends after 3 x 11 + 10 bits, 4.5 ms, and is read by the strobe at 5 ms; E takes 1.04 ms
    'Initialisation: "allow a delay of at least 5mS": an E that ends 0.1 ms before the end of this delay is lost':
    "detect; U61; 0.00886 s; sends E; 0.01 s; sends <CR>; 1.3 s; F: 0",
    'Initialisation: "allow a delay of at least 5mS": after four characters, a strobe and this delay E is received':
    "detect; U61; 0.00906 s; E; 1.3 s; receives C<CR>",
})  # fmt: skip
def test_characters_are_lost_for_5_ms_where_that_is_asked_for(bench, script):
    """R2: option for the strict mode."""
    play(bench, bench.add("if1", line="9600 8N2", strict_format=True), script)


@pytest.mark.parametrize("message", ["(", "U61", "V61", "U11", "*"])
def test_a_bracket_or_a_format_once_it_is_ready_is_a_data_fault(bench, if1, message):
    """R5: the baud rate is measured only once; the samples tell the user to power down before a second run."""
    play(bench, if1, f"{message}; 0.1 s; K: 128; F: 8; K: 0; F: 0; E: C")


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
