"""Serial communication: the serial data format, stop bits, data bits, parity, echo-back, baud rate."""

import itertools
from fractions import Fraction

import pytest

from axistwin.sim import LineError
from axistwin.units import MS, S

from .talking import (
    BITS_7_OR_8,
    PARITY,
    arrivals,
    ask,
    command,
    detect,
    each_character,
    faults,
    host_format,
    ready,
    send,
    write,
)

FORMATS = [(frame, parity) for frame in range(1, 9) for parity in range(1, 10)]


def bits_of(frame: int, parity: int) -> int:
    """Return the number of start, data, parity and stop bits of a format, from the table in Initialisation."""
    return 1 + BITS_7_OR_8[frame] + (PARITY[parity] != "N") + (2 - frame % 2)


@pytest.mark.parametrize(("frame", "parity"), FORMATS)
def test_a_character_takes_all_its_bits(bench, frame, parity):
    """Serial data format: start bit, 7 or 8 data bits, perhaps a parity bit, and 1 or 2 stop bits, without gaps."""
    if1 = ready(bench, f"U{frame}{parity}", line="2400 8N2")
    received = arrivals(bench, if1)
    write(if1, "I")
    bench.run(0.2)
    answer = received[-4:]  # the answer is 200 CR, perhaps after an echo
    assert bytes(byte & 0x7F for _, byte, _ in answer) == b"200\r"
    times = [time for time, _, _ in answer]
    expected = round(Fraction(bits_of(frame, parity) * S, 2400))
    gaps = [after - before for before, after in itertools.pairwise(times)]
    assert all(abs(gap - expected) <= 1 for gap in gaps), (gaps, expected)


@pytest.mark.parametrize(("frame", "parity"), FORMATS)
def test_a_host_in_the_same_format_finds_no_error(bench, frame, parity):
    """Parity: "the total number of bits at logic 1 (ignoring start and stop bits) should be odd"; bit 8 counts."""
    if1 = ready(bench, f"U{frame}{parity}", line="2400 8N2")
    received = arrivals(bench, if1)
    for message in "KFINE":
        write(if1, message)
        bench.run(0.1)
    assert [errors for _, _, errors in received] == [LineError.NONE] * len(received)
    assert bytes(byte & 0x7F for _, byte, _ in received if byte & 0x70 == 0x30) == b"002000"
    assert faults(bench, if1)[0].endswith((b"0\r", b"\xb0\x8d"))


@pytest.mark.parametrize(
    ("frame", "reply"),
    [(1, b"0\r"), (2, b"0\r"), (3, b"0\r"), (4, b"0\r"), (5, b"0\r"), (6, b"0\r"), (7, b"\xb0\x8d"), (8, b"\xb0\x8d")],
)
def test_bit_8_of_what_it_sends(bench, frame, reply):
    """Number of data bits: "the last bit being 0, 1 or data-dependent" in characters from the interface."""
    if1 = ready(bench, f"U{frame}1")
    assert ask(bench, if1, "K") == reply


@pytest.mark.parametrize(
    ("frame", "echo"),
    [(3, b"\xc5\x8d"), (4, b"\xc5\x8d"), (5, b"E\r"), (6, b"E\r"), (7, b"\xc5\x8d"), (8, b"\xc5\x8d")],
)
def test_bit_8_of_the_echo_of_a_character_with_bit_8_set(bench, frame, echo):
    """Number of data bits: data-dependent is "only significant in the echo-back mode" or for quick status."""
    if1 = ready(bench, f"U{frame}2")
    assert ask(bench, if1, "\xc5\x8d", end="")[:2] == echo


@pytest.mark.parametrize("frame", range(3, 9))
def test_bit_8_means_nothing_in_what_it_receives(bench, frame):
    """Number of data bits: "All the characters needed to operate the interface may be represented by 7 bits"."""
    if1 = ready(bench, f"U{frame}1")
    answer = ask(bench, if1, "\xc5\x8d", end="")
    assert bytes(byte & 0x7F for byte in answer) == b"C\r"
    assert bytes(byte & 0x7F for byte in ask(bench, if1, "F")) == b"0\r"


def test_a_host_whose_bit_8_is_always_1_can_initialise(bench):
    """Number of data bits: "some controllers send 8 bits", the last being 1: also in `(` and in the format message."""
    if1 = bench.add("if1")
    bench.run(1.5)
    assert send(bench, if1, "\xa8", seconds=0.1, end="") == b"U\r"
    if1.serial.write(bytes(byte | 0x80 for byte in b"U81\r"))
    bench.run(1.3)
    assert ask(bench, if1, "\xc5\x8d", end="") == bytes(byte | 0x80 for byte in b"C\r")


@pytest.mark.parametrize("own", ["7E1", "7O1", "7E2", "7N2"])
def test_a_host_that_has_7_bits_can_initialise(bench, own):
    """Number of data bits: 7 bits with parity look like 8 bits to an interface still in its default format."""
    message = {"7E1": "U14", "7O1": "U13", "7E2": "U24", "7N2": "U21"}[own]
    if1 = bench.add("if1", line=f"2400 {own}")
    bench.run(1.5)
    send(bench, if1, "(", seconds=0.1, end="")  # the host may find a parity error: bit 8 of `U` and CR is 0
    command(bench, if1, message, seconds=1.3)
    assert (ask(bench, if1, "E"), ask(bench, if1, "F")) == (b"C\r", b"0\r")


def test_12_bits_at_1200_baud_are_100_characters_per_second(bench):
    """Baud rate: "assuming 12 bits per character ... this is equivalent to 100 characters per second"."""
    if1 = ready(bench, "U64", line="1200 8N2")  # 8 data bits, even parity, 2 stop bits
    received = arrivals(bench, if1)
    begin = bench.now
    if1.serial.write(b"I\r" * 50)  # 100 characters
    bench.run_until(lambda: not if1.serial.pending, 10)
    assert bench.now - begin == 990 * MS  # the last of the 100 characters has just begun
    bench.run(3)
    answers = received[-4:]
    assert [after[0] - before[0] for before, after in itertools.pairwise(answers)] == [10 * MS] * 3


@pytest.mark.parametrize("baud", [110, 300, 600, 1200, 2400, 4800, 9600])
def test_11_bit_characters_at_every_baud_rate(bench, baud):
    """Baud rate: in bits per second; a character in 8N2 has 11 bits."""
    if1 = ready(bench, line=f"{baud} 8N2")
    received = arrivals(bench, if1)
    write(if1, "I")
    bench.run(1)
    times = [time for time, _, _ in received]
    assert [byte for _, byte, _ in received] == list(b"200\r")
    assert all(abs(Fraction(11 * S, baud) - (b - a)) <= 1 for a, b in itertools.pairwise(times))


# Parity


def test_wrong_parity_is_a_parity_error_and_the_characters_are_dropped(bench):
    """Parity error: "this is set when a parity error is detected".  R33: the character is dropped."""
    if1 = ready(bench, "U63")
    if1.serial.host.parity = "E"
    command(bench, if1, "X5$")
    if1.serial.host.parity = "O"
    assert (if1.axes["X"].position, faults(bench, if1)) == (0, (b"128\r", b"1\r"))
    assert faults(bench, if1) == (b"0\r", b"0\r")


def test_one_character_with_a_parity_error_is_dropped_and_the_message_goes_on(bench):
    """R33: the character is dropped and not echoed, its flag is set, and the message continues."""
    if1 = ready(bench, "U65")  # odd parity, echo
    each_character(bench, if1, "X1234$\r", lambda n: if1.serial.to_device.flip(0x01) if n == 3 else None)
    bench.run(1)
    assert (if1.serial.read(), if1.axes["X"].position, ask(bench, if1, "F")) == (b"X124$\r", 124, b"F\r1\r")


def test_two_flipped_bits_are_not_found_by_parity(bench):
    """Echo back: "A parity check is a useful guard against transmission errors, but it's not infallible"."""
    if1 = ready(bench, "U63")
    each_character(bench, if1, "X11$\r", lambda n: if1.serial.to_device.flip(0x06) if n == 1 else None)
    bench.run(1)
    assert if1.axes["X"].position == 71  # 31h with bits 1 and 2 inverted reads 37h, so 71 instead of 11
    assert ask(bench, if1, "F") == b"0\r"


@pytest.mark.parametrize("message", ["U61", "U21"])
def test_without_parity_a_flipped_bit_is_not_found(bench, message):
    """Parity: "As a check for transmission errors, a parity bit can be included"; without parity no bit is checked."""
    if1 = ready(bench, message)
    each_character(bench, if1, "X11$\r", lambda n: if1.serial.to_device.flip(0x02) if n == 1 else None)
    bench.run(1)
    assert (if1.axes["X"].position, ask(bench, if1, "F")) == (31, b"0\r")


def test_every_7_bit_character_with_the_wrong_parity_is_found(bench):
    """Parity: a single wrong bit is always found, because it makes the total wrong."""
    if1 = ready(bench, "U24")
    for character in (0x00, 0x11, 0x2A, 0x55, 0x7E, 0x7F):
        if1.serial.to_device.flip(0x10)
        if1.serial.write(bytes([character]))
        bench.run(0.01)
        assert faults(bench, if1) == (b"128\r", b"1\r"), hex(character)


# What the formats do to each other, bit by bit (ruling 6)


def test_8e1_to_an_8n2_receiver_where_the_parity_bits_are_1(bench, if1):
    """E = 45h and CR = 0Dh have three 1's each, so even parity sends a 1 where the first stop bit is expected."""
    if1.serial.host.parity, if1.serial.host.stopbits = "E", 1
    write(if1, "E")
    bench.run(0.01)
    if1.serial.host.parity, if1.serial.host.stopbits = "N", 2
    bench.run(0.1)
    assert (if1.serial.read(), ask(bench, if1, "F")) == (b"C\r", b"0\r")


def test_8e1_to_an_8n2_receiver_where_a_parity_bit_is_0(bench, if1):
    """K = 4Bh has four 1's: a 0 where the first stop bit is expected, "a valid stop bit is not detected"."""
    if1.serial.host.parity, if1.serial.host.stopbits = "E", 1
    command(bench, if1, "K", seconds=0.1)
    if1.serial.host.parity, if1.serial.host.stopbits = "N", 2
    assert (if1.serial.read(), faults(bench, if1)) == (b"", (b"128\r", b"4\r"))


def test_8o1_to_an_8n2_receiver(bench, if1):
    """The odd parity bit of E and CR (three 1's) is 0: two framing errors, and the whole message is lost."""
    if1.serial.host.parity, if1.serial.host.stopbits = "O", 1
    command(bench, if1, "E", seconds=0.1)
    if1.serial.host.parity, if1.serial.host.stopbits = "N", 2
    assert (if1.serial.read(), ask(bench, if1, "F"), ask(bench, if1, "E")) == (b"", b"4\r", b"C\r")


def test_8n2_to_a_7e1_receiver(bench):
    """Bit 8 = 0 lies on the parity bit: right for K (four 1's), wrong for CR (three 1's), which is dropped."""
    if1 = ready(bench, "U14")
    host = if1.serial.host
    host.bytesize, host.parity, host.stopbits = 8, "N", 2
    assert send(bench, if1, "K", seconds=0.1) == b""
    host_format(if1, "U14")
    assert ask(bench, if1, "") == b"128\r"  # the K still waited for its CR
    assert ask(bench, if1, "F") == b"1\r"


def test_8n2_to_a_7n1_receiver(bench):
    """Bit 8 = 0 lies where the stop bit is expected: each character is a framing error; with bit 8 = 1 none is."""
    if1 = ready(bench, "U11", line="2400 8N2")
    host = if1.serial.host
    host.bytesize, host.stopbits = 8, 2
    command(bench, if1, "X5$")
    assert if1.axes["X"].position == 0
    if1.serial.write(bytes(byte | 0x80 for byte in b"X7$\r"))
    bench.run(0.2)
    assert if1.axes["X"].position == 7
    host_format(if1, "U11")
    assert ask(bench, if1, "F") == b"4\r"


def test_7n1_back_to_back_to_an_8n2_receiver(bench, if1):
    """The next character's start bit is read as the first stop bit: a framing error."""
    host = if1.serial.host
    host.bytesize, host.stopbits = 7, 1
    command(bench, if1, "E", seconds=0.1)
    host_format(if1, "U61")
    send(bench, if1, "#", seconds=0.1)
    assert int(ask(bench, if1, "F")) & 4


def test_7n1_with_pauses_to_an_8n2_receiver(bench, if1):
    """Between characters the line is at mark, which is read as bit 8 = 1 and stop bits: no error."""
    host = if1.serial.host
    host.bytesize, host.stopbits = 7, 1
    each_character(bench, if1, "E\r", lambda n: bench.run(0.01))
    host_format(if1, "U61")
    bench.run(0.1)
    assert (if1.serial.read(), ask(bench, if1, "F")) == (b"C\r", b"0\r")


def test_half_the_baud_rate(bench, if1):
    """A receiver at 9600 baud reads a CR at 4800 baud as E6h and 80h, without an error: a data fault."""
    if1.serial.host.baudrate = 4800
    if1.serial.write(b"\r")
    bench.run(0.1)
    if1.serial.host.baudrate = 9600
    command(bench, if1, "", seconds=0.1)
    assert faults(bench, if1) == (b"128\r", b"8\r")


def test_what_a_host_at_twice_the_baud_rate_reads(bench):
    """`U` CR at 4800, each bit sampled twice, reads 66h without a stop bit and E6h, E6h, 80h (worked out on paper)."""
    if1 = bench.add("if1", line="4800 8N2")
    bench.run(1.5)
    received = arrivals(bench, if1)
    if1.serial.write(b"(")
    if1.serial.host.baudrate = 9600
    bench.run(0.2)
    framing, none = LineError.FRAMING, LineError.NONE
    assert [(byte, errors) for _, byte, errors in received] == [
        (0x66, framing),
        (0xE6, none),
        (0xE6, none),
        (0x80, none),
    ]


def test_a_break_is_a_framing_error(bench, if1):
    """Framing error: "set when a valid stop bit is not detected at the end of every character"."""
    if1.serial.send_break(0.25)
    bench.run(0.3)
    assert (faults(bench, if1), faults(bench, if1)) == ((b"128\r", b"4\r"), (b"0\r", b"0\r"))
    assert ask(bench, if1, "E") == b"C\r"


def test_a_break_within_a_message_is_not_part_of_it(bench, if1):
    """R33: a character with a framing error is dropped, and the message continues."""
    if1.serial.write(b"X1")
    if1.serial.send_break(0.05)
    command(bench, if1, "2$", seconds=1)
    assert (if1.axes["X"].position, ask(bench, if1, "F")) == (12, b"4\r")


@pytest.mark.parametrize("baud", [110, 2400, 9600])
def test_a_break_before_the_bracket_is_no_bracket(bench, baud):
    """Initialisation: the baud rate is measured only on `(`."""
    if1 = bench.add("if1", line=f"{baud} 8N2")
    bench.run(1.5)
    if1.serial.send_break(0.25)
    bench.run(0.5)
    assert if1.serial.read() == b"" and not if1.pins["led"].flashing
    assert send(bench, if1, "(", seconds=0.5, end="") == b"U\r"


# Lost, doubled, cut


def test_a_lost_character_is_simply_not_there(bench, if1):
    """Echo back: without an echo neither the host nor the interface detects a lost character."""
    each_character(bench, if1, "X123$\r", lambda n: if1.serial.to_device.lose() if n == 2 else None)
    bench.run(1)
    assert (if1.axes["X"].position, ask(bench, if1, "F")) == (13, b"0\r")


def test_a_doubled_character_is_there_twice(bench, if1):
    """Echo back: without an echo neither the host nor the interface detects a doubled character."""
    each_character(bench, if1, "X12$\r", lambda n: if1.serial.to_device.double() if n == 2 else None)
    bench.run(1)
    assert (if1.axes["X"].position, ask(bench, if1, "F")) == (122, b"0\r")


def test_a_cut_line_is_silent_until_it_is_mended(bench, if1):
    """A cut wire transfers no character and raises no fault."""
    if1.serial.to_device.cut()
    assert ask(bench, if1, "X5$") == b""
    if1.serial.to_device.mend()
    assert (ask(bench, if1, "K"), if1.axes["X"].position) == (b"0\r", 0)


def test_a_line_cut_in_the_middle_of_a_character_reads_as_mark_from_there(bench, if1):
    """E = 1,0,1,0,0,0,1,0 cut within its third bit is read as 1,0,1,1,1,1,1,1 = FDh, an unknown character."""
    command(bench, if1, "E", seconds=3.5 / 9600, end="")  # start bit, two bits and half of the third
    if1.serial.to_device.cut()
    bench.run(0.01)
    if1.serial.to_device.mend()
    assert (ask(bench, if1, ""), faults(bench, if1)) == (b"", (b"128\r", b"8\r"))


def test_a_cut_receive_line_loses_the_reply_and_nothing_else(bench, if1):
    """The interface does not detect the cut; after the repair the next request is answered."""
    if1.serial.from_device.cut()
    assert (ask(bench, if1, "X5$"), ask(bench, if1, "K")) == (b"", b"")
    if1.serial.from_device.mend()
    assert (ask(bench, if1, "K"), if1.axes["X"].position) == (b"0\r", 5)


# Echo-back


def test_echo_back_returns_every_character_before_the_reply(bench):
    """Echo back: "each character is returned to the controller for comparison with the transmitted data"."""
    if1 = ready(bench, "U62")
    assert (ask(bench, if1, " K  "), ask(bench, if1, "X 5 $")) == (b" K  \r0\r", b"X 5 $\r")


@pytest.mark.parametrize(("end", "echo"), [("\n", b"E\nC\r\n"), ("\r\n", b"E\r\nC\r\n")])
def test_the_terminators_are_echoed_as_they_are_sent(bench, end, echo):
    """Appendix 3, sample 10: after the echo of LF three characters are read, C CR LF."""
    if1 = ready(bench, "V62")
    assert ask(bench, if1, "E", end=end) == echo


def test_a_line_feed_in_u_format_is_echoed_and_ignored(bench):
    """R6: appendix 3, Epson: "either "U" or "V" can be specified" although CR LF is sent."""
    if1 = ready(bench, "U62")
    assert (ask(bench, if1, "E", end="\r\n"), ask(bench, if1, "\nE", end="\n\r")) == (b"E\rC\r\n", b"\nE\n\rC\r")
    assert ask(bench, if1, "F") == b"F\r0\r"


def test_a_line_feed_in_u_format_without_echo_is_ignored(bench, if1):
    """R6: in the U format a line feed is ignored."""
    assert (ask(bench, if1, "E", end="\r\n"), ask(bench, if1, "X\n5\n$")) == (b"C\r", b"")
    assert (if1.axes["X"].position, ask(bench, if1, "F")) == (5, b"0\r")


def test_characters_that_mean_nothing_are_echoed_too(bench):
    """Echo back: "each character is returned"."""
    if1 = ready(bench, "U32")
    odd = bytes(set(range(256)) - {0x0D, 0x8D})
    echo = b""
    for byte in odd:
        if1.serial.write(bytes([byte]))
        bench.run(0.005)
        echo += if1.serial.read()
    assert echo == odd


@pytest.mark.parametrize("parity", [1, 3, 4, 7, 8, 9])
def test_the_other_formats_do_not_echo(bench, parity):
    """Initialisation, table: echo back only with X2 = 2, 5 and 6."""
    if1 = ready(bench, f"U6{parity}")
    assert (ask(bench, if1, "X5$"), ask(bench, if1, "E")) == (b"", b"C\r")


@pytest.mark.parametrize("baud", [300, 2400, 9600])
def test_the_echo_comes_when_the_character_has_been_taken(bench, baud):
    """Connection methods: "echo-back only occurs after a character has been processed": within a strobe, when idle."""
    if1 = ready(bench, "U62", line=f"{baud} 8N2")
    received = arrivals(bench, if1)
    begin = bench.now
    write(if1, " ", end="")
    bench.run(1)
    there_and_back = 2 * 10 * S // baud  # twice the time to the end of the first stop bit
    assert there_and_back <= received[0][0] - begin <= there_and_back + 2 * MS


def test_no_echo_during_the_ramp_calculation(bench):
    """Acceleration rate: "it will not respond during this period"; the echo comes afterwards."""
    if1 = ready(bench, "U62")
    assert (send(bench, if1, "^7", seconds=0.05), send(bench, if1, "E", seconds=0.9)) == (b"^7\r", b"")
    bench.run(0.1)
    assert if1.serial.read() == b"E\rC\r"


def test_a_wrong_echo_is_put_right_with_the_cancel_character(bench):
    """Control of data transfer: "the cancel character "# <CR>" should be sent before retransmission is attempted"."""
    if1 = ready(bench, "U62")
    each_character(bench, if1, "X100", lambda n: if1.serial.to_device.flip(0x08) if n == 1 else None)
    bench.run(0.05)
    assert (if1.serial.read(), ask(bench, if1, "#"), ask(bench, if1, "X100$", 1)) == (b"X900", b"#\r", b"X100$\r")
    assert (if1.axes["X"].position, ask(bench, if1, "F")) == (100, b"F\r0\r")


def test_an_echo_spoilt_on_its_way_back_is_no_fault_of_the_interface(bench):
    """Echo back: the controller compares the echo; an error on the way back is no fault of the interface."""
    if1 = ready(bench, "U62")
    if1.serial.from_device.flip(0x01)
    assert (ask(bench, if1, "E"), ask(bench, if1, "F")) == (b"D\rC\r", b"F\r0\r")


def test_lower_case_is_not_understood(bench, if1):
    """Initialisation: "note that all alpha characters are upper case"; R32: `k` in an example is K."""
    assert (ask(bench, if1, "k"), faults(bench, if1)) == (b"", (b"128\r", b"8\r"))
    command(bench, if1, "x5$")
    assert if1.axes["X"].position == 0


def test_the_format_stays_until_power_off(bench, if1):
    """Initialisation: the format is that of "all subsequent messages", until the power is switched off."""
    for _ in range(3):
        assert (ask(bench, if1, "#"), ask(bench, if1, "E")) == (b"", b"C\r")
    if1.power_cycle()
    detect(bench, if1)
