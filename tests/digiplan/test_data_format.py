"""Serial communication: the serial data format, stop bits, data bits, parity, echo-back, baud rate."""

from fractions import Fraction

import pytest

from axistwin.core.units import MS, S
from axistwin.sim.frames import LineError

from ..scripts import scripts
from .talking import BITS_7_OR_8, PARITY, arrivals, ask, faults, gaps, play, ready, send, write

FORMATS = [(frame, parity) for frame in range(1, 9) for parity in range(1, 10)]


def bits_of(frame: int, parity: int) -> int:
    """Return the number of start, data, parity and stop bits of a format, from the table in Initialisation."""
    return 1 + BITS_7_OR_8[frame] + (PARITY[parity] != "N") + (2 - frame % 2)


@pytest.mark.parametrize(("terminator", "end"), [("U", "\r"), ("V", "\n"), ("V", "\r\n")])
@pytest.mark.parametrize(("frame", "parity"), FORMATS)
def test_a_host_in_the_same_format_finds_no_error(bench, frame, parity, terminator, end):
    """Parity: "the total number of bits at logic 1 (ignoring start and stop bits) should be odd"; bit 8 counts.

    Serial data format: start bit, 7 or 8 data bits, perhaps a parity bit, and 1 or 2 stop bits, without gaps.
    Initialisation: X1 from 1 to 8 and X2 from 1 to 9; X2 = 2, 5 and 6 echo.
    """
    if1 = ready(bench, f"{terminator}{frame}{parity}", line="2400 8N2")
    received = arrivals(bench, if1)
    for letter, answer in zip("KFIE", ("0", "0", "200", "C"), strict=True):
        reply = bytes(byte & 0x7F for byte in ask(bench, if1, letter, end=end)).decode()
        assert reply == (letter + end if parity in (2, 5, 6) else "") + answer + ("\r" if end == "\r" else "\r\n")
        gap_ns = round(Fraction(bits_of(frame, parity) * S, 2400))
        within_the_answer = gaps([at_ns for at_ns, _, _ in received[-len(answer) - 1 :]])
        assert all(abs(gap - gap_ns) <= 1 for gap in within_the_answer), (within_the_answer, gap_ns)
    assert {errors for _, _, errors in received} == {LineError.NONE}


@pytest.mark.parametrize(("frame", "bit_8"), [(1, 0), (2, 0), (3, 0), (4, 0), (5, 0), (6, 0), (7, 0x80), (8, 0x80)])
def test_bit_8_means_nothing_in_what_it_receives(bench, frame, bit_8):
    """Number of data bits: "All the characters needed to operate the interface may be represented by 7 bits".

    "the last bit being 0, 1 or data-dependent" in characters from the interface.
    """
    if1 = ready(bench, f"U{frame}1")
    for message in ["K\r", "\xcb\x8d", "F\r"] if frame > 2 else ["K\r"]:
        assert ask(bench, if1, message, end="") == bytes(byte | bit_8 for byte in b"0\r")


@pytest.mark.parametrize(("frame", "echo"), [
    (3, b"\xc5\x8d"), (4, b"\xc5\x8d"), (5, b"E\r"), (6, b"E\r"), (7, b"\xc5\x8d"), (8, b"\xc5\x8d")])  # fmt: skip
def test_bit_8_of_the_echo_of_a_character_with_bit_8_set(bench, frame, echo):
    """Number of data bits: data-dependent is "only significant in the echo-back mode" or for quick status."""
    assert ask(bench, ready(bench, f"U{frame}2"), "\xc5\x8d", end="")[:2] == echo


def test_a_host_whose_bit_8_is_always_1_can_initialise(bench):
    """Number of data bits: "some controllers send 8 bits", the last being 1: also in `(` and in the format message."""
    script = "1.5 s; <A8> -> U<CR>; sends <D5><B8><B1><8D>; 1.3 s; sends <C5><8D>; 0.2 s; "
    play(bench, bench.add("if1"), script + "receives <C3><8D>")


@pytest.mark.parametrize(("own", "message"), [("7E1", "U14"), ("7O1", "U13"), ("7E2", "U24"), ("7N2", "U21")])
def test_a_host_that_has_7_bits_can_initialise(bench, own, message):
    """Number of data bits: 7 bits with parity look like 8 bits to an interface still in its default format."""
    if1 = bench.add("if1", line=f"2400 {own}")
    bench.run(1.5)
    send(bench, if1, "(", seconds=0.1, end="")  # the host may find a parity error: bit 8 of `U` and CR is 0
    play(bench, if1, f"{message}; 1.3 s; E: C; F: 0")


def test_12_bits_at_1200_baud_are_100_characters_per_second(bench):
    """Baud rate: "assuming 12 bits per character ... this is equivalent to 100 characters per second"."""
    if1 = ready(bench, "U64", line="1200 8N2")  # 8 data bits, even parity, 2 stop bits
    received, begin = arrivals(bench, if1), bench.now
    if1.serial.write(b"I\r" * 50)  # 100 characters
    bench.run_until(lambda: not if1.serial.pending, 10)
    assert bench.now - begin == 990 * MS  # the last of the 100 characters has just begun
    bench.run(3)
    assert gaps([at_ns for at_ns, _, _ in received[-4:]]) == [10 * MS] * 3


@pytest.mark.parametrize("baud", [110, 300, 600, 1200, 2400, 4800, 9600])
def test_11_bit_characters_at_every_baud_rate(bench, baud):
    """Baud rate: "110, 300, 600, 1200, 2400, 4800 or 9600 bits per second"; a character in 8N2 has 11 bits."""
    if1 = ready(bench, line=f"{baud} 8N2")
    received = arrivals(bench, if1)
    assert ask(bench, if1, "I", 1) == b"200\r"
    assert all(abs(Fraction(11 * S, baud) - gap) <= 1 for gap in gaps(at_ns for at_ns, _, _ in received))
    play(bench, if1, "X12$; 1.5 s; X at 12; K; 1 s; receives 0<CR>; F; 1 s; receives 0<CR>")


# Parity, formats that differ (ruling 6), lost and doubled characters, cut wires, echo-back


@scripts({
    'Parity error: "this is set when a parity error is detected".  R33: the character is dropped':
    "U63; host 8E2; X5$; 0.2 s; host 8O2; X at 0; K: 128; F: 1; K: 0; F: 0",
    "Parity, R33: a character is dropped and not echoed, its flag is set, and the message continues":
    "U65; X12 -> X12; flip 01; sends 34$<CR>; 1 s; receives 4$<CR>; X at 124; F; 0.2 s; "
    "receives F<CR>1<CR>",
    'Echo back: "A parity check is a useful guard against transmission errors, but it\'s not infallible"':
    "U63; sends X; 0.01 s; flip 06; sends 11$<CR>; 1 s; X at 71; F: 0",  # 31h, bits 1 and 2 inverted: 37h
    'Parity: "As a check for transmission errors, a parity bit can be included"; without it no bit is checked':
    "U61; sends X; 0.01 s; flip 02; sends 11$<CR>; 1 s; X at 31; F: 0",
    "Parity: in 7 bits without it no bit is checked, either":
    "U21; sends X; 0.01 s; flip 02; sends 11$<CR>; 1 s; X at 31; F: 0",
    "8E1 to 8N2: E = 45h and CR = 0Dh have three 1's each, so even parity sends a 1 in place of the first stop bit":
    "U61; host 8E1; E; 0.01 s; receives C<CR>; host 8N2; 0.1 s; F: 0",
    '8E1 to 8N2: K = 4Bh has four 1\'s: a 0 in place of the first stop bit, "a valid stop bit is not detected"':
    "U61; host 8E1; K; 0.1 s; host 8N2; K: 128; F: 4",
    "8O1 to 8N2: the odd parity bit of E and CR (three 1's) is 0: two framing errors, the whole message is lost":
    "U61; host 8O1; E; 0.1 s; host 8N2; F: 4; E: C",
    "8N2 to 7E1: bit 8 = 0 lies on the parity bit: right for K (four 1's), wrong for CR (three 1's), so K waits":
    "U14; host 8N2; K; 0.1 s; host 7E1; <CR> -> 128<CR>; F: 1",
    "7N1 with pauses to 8N2: between characters the line is at mark, read as bit 8 = 1 and stop bits: no error":
    "U61; host 7N1; sends E; 0.011 s; sends <CR>; 0.011 s; receives C<CR>; host 8N2; 0.1 s; F: 0",
    "Half the baud rate: a receiver at 9600 baud reads a CR at 4800 baud as E6h and 80h, without an error":
    "U61; host 4800; sends <CR>; 0.1 s; host 9600; sends <CR>; 0.1 s; K: 128; F: 8",
    'Framing error: "set when a valid stop bit is not detected at the end of every character": a break':
    "U61; break 0.25 s; 0.3 s; K: 128; F: 4; K: 0; F: 0; E: C",
    "R33: a break within a message is not part of it": "U61; sends X1; break 0.05 s; 2$; 1 s; X at 12; F: 4",
    "Echo back: without an echo neither the host nor the interface detects a lost character":
    "U61; sends X1; 0.01 s; lose; sends 23$<CR>; 1 s; X at 13; F: 0",
    "Echo back: without an echo neither the host nor the interface detects a doubled character":
    "U61; sends X1; 0.01 s; double; sends 2$<CR>; 1 s; X at 122; F: 0",
    "A cut wire transfers no character and raises no fault": "U61; cut; X5$; 0.2 s; mend; K: 0; X at 0",
    "E = 1,0,1,0,0,0,1,0 cut within its third bit is read as 1,0,1,1,1,1,1,1 = FDh, an unknown character":
    "U61; sends E; 0.000365 s; cut; 0.01 s; mend; sends <CR>; 0.2 s; K: 128; F: 8",  # 3.5 bits
    "The interface does not detect the cut of the wire to the host; after the repair it answers the next request":
    "U61; cut back; X5$; 0.2 s; K; 0.2 s; mend back; K: 0; X at 5",
    'Echo back: "each character is returned to the controller for comparison with the transmitted data"':
    "U62; <SP>K  <CR> -> <SP>K  <CR>0<CR>; X 5 $; 0.2 s; receives X 5 $<CR>",
    "Appendix 3, sample 10: after the echo of LF three characters are read, C CR LF":
    "V62; E<LF> -> E<LF>C<CR><LF>; E<CR><LF> -> E<CR><LF>C<CR><LF>",
    'R6: a line feed in `U` format, appendix 3, Epson: "either "U" or "V" can be specified" although CR LF is sent':
    "U62; E<CR><LF> -> E<CR>C<CR><LF>; sends <LF>E<LF><CR>; 0.2 s; "
    "receives <LF>E<LF><CR>C<CR>; F<CR> -> F<CR>0<CR>",
    "R6: in the U format without echo a line feed is ignored, too":
    "U61; E<CR><LF> -> C<CR>; sends X<LF>5<LF>$<CR>; 0.2 s; X at 5; F: 0",
    'Acceleration rate: "it will not respond during this period"; the echo comes afterwards':
    "U62; ^7; 0.05 s; receives ^7<CR>; E; 0.9 s; 0.1 s; receives E<CR>C<CR>",
    'Control of data transfer: "the cancel character "# <CR>" should be sent before retransmission is attempted"':
    "U62; sends X; 0.01 s; receives X; flip 08; sends 100; 0.05 s; receives 900; #<CR> -> #<CR>; "
    "X100$; 1 s; receives X100$<CR>; X at 100; F<CR> -> F<CR>0<CR>",
    "Echo back: the controller compares the echo; an error on the way back is no fault of the interface":
    "U62; flip 01 back; E<CR> -> D<CR>C<CR>; F<CR> -> F<CR>0<CR>",
    'Initialisation: "note that all alpha characters are upper case"; R32: `k` in an example is K':
    "U61; sends k<CR>; 0.2 s; K: 128; F: 8; sends x5$<CR>; 0.2 s; X at 0",
    'Initialisation: the format is that of "all subsequent messages", until the power is switched off':
    "U61; #; 0.2 s; E: C; #; 0.2 s; E: C; #; 0.2 s; E: C; power off; power on; detect",
})  # fmt: skip
def test_characters_on_the_line(bench, script):
    """The first word of a script is the data format message."""
    message, _, acts = script.partition("; ")
    play(bench, ready(bench, message), acts)


def test_every_7_bit_character_with_the_wrong_parity_is_found(bench):
    """Parity: a single wrong bit is always found, because it makes the total wrong."""
    if1 = ready(bench, "U24")
    for character in (0x00, 0x11, 0x2A, 0x55, 0x7E, 0x7F):
        if1.serial.to_device.flip(0x10)
        if1.serial.write(bytes([character]))
        bench.run(0.01)
        assert faults(bench, if1) == (b"128\r", b"1\r"), hex(character)


def test_8n2_to_a_7n1_receiver(bench):
    """Bit 8 = 0 lies where the stop bit is expected: each character is a framing error; with bit 8 = 1 none is."""
    script = "host 8N2; X5$; 0.2 s; X at 0; sends <D8><B7><A4><8D>; 0.2 s; X at 7; host 7N1; F: 4"
    play(bench, ready(bench, "U11", line="2400 8N2"), script)


def test_7n1_back_to_back_to_an_8n2_receiver(bench, if1):
    """The next character's start bit is read as the first stop bit: a framing error."""
    play(bench, if1, "host 7N1; E; 0.1 s; host 8N2")
    send(bench, if1, "#", seconds=0.1)
    assert int(ask(bench, if1, "F")) & 4


def test_what_a_host_at_twice_the_baud_rate_reads(bench):
    """`U` CR at 4800, each bit sampled twice, reads 66h without a stop bit and E6h, E6h, 80h (worked out on paper)."""
    if1 = bench.add("if1", line="4800 8N2")
    bench.run(1.5)
    received = arrivals(bench, if1)
    if1.serial.write(b"(")
    if1.serial.host.baudrate = 9600
    bench.run(0.2)
    assert [byte for _, byte, _ in received] == [0x66, 0xE6, 0xE6, 0x80]
    assert [errors for _, _, errors in received] == [LineError.FRAMING, *[LineError.NONE] * 3]


@pytest.mark.parametrize("baud", [110, 2400, 9600])
def test_a_break_before_the_bracket_is_no_bracket(bench, baud):
    """Initialisation: the baud rate is measured only on `(`."""
    script = "1.5 s; break 0.25 s; 0.5 s; led is steady; sends (; 0.5 s; receives U<CR>"
    play(bench, bench.add("if1", line=f"{baud} 8N2"), script)


# Echo-back


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


@pytest.mark.parametrize("baud", [300, 2400, 9600])
def test_the_echo_comes_when_the_character_has_been_taken(bench, baud):
    """Connection methods: "echo-back only occurs after a character has been processed": within a strobe, when idle."""
    if1 = ready(bench, "U62", line=f"{baud} 8N2")
    received, begin = arrivals(bench, if1), bench.now
    write(if1, " ", end="")
    bench.run(1)
    there_and_back = 2 * 10 * S // baud  # twice the time to the end of the first stop bit
    assert there_and_back <= received[0][0] - begin <= there_and_back + 2 * MS
