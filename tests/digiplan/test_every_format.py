"""Configuring the interface: a host that keeps one format throughout establishes each of the 72 formats."""

import itertools

import pytest

from axistwin.core.units import S

from .talking import BITS_7_OR_8, PARITY, play, send

FORMATS = [f"U{frame}{parity}" for frame, parity in itertools.product(range(1, 9), range(1, 10))]


def establish(bench, message, gap_s, eighth=0, **options):
    """Initialise at 2400 baud: send `(`, wait for the answer, send the data format; then request F."""
    if1 = bench.add("if1", **options)
    host = if1.serial.host
    host.baudrate = 2400
    host.bytesize, host.stopbits = BITS_7_OR_8[int(message[1])], 2 - int(message[1]) % 2
    host.parity = PARITY[int(message[2])]
    bench.run(1.1)

    def say(text):
        for character in text:
            if1.serial.write(bytes([ord(character) | eighth]))
            if gap_s:
                bench.run(host.format.frame_ns / S + gap_s)

    say("(")
    bench.run(0.1)
    assert bytes(byte & 0x7F for byte in if1.serial.read()) == b"U\r"
    say(message + "\r")
    bench.run(1.2)
    say("F\r")
    bench.run(0.2)
    return if1, bytes(byte & 0x7F for byte in if1.serial.read())


def answer(message):
    """Return the expected answer to F without a fault, with the echo if the format has one."""
    return b"F\r0\r" if message[2] in "256" else b"0\r"


@pytest.mark.parametrize(("gap_s", "options"), [(0, {}), (0.01, {}), (0, {"line": "instant"})])
@pytest.mark.parametrize("message", FORMATS)
def test_a_host_that_keeps_its_format_establishes_it(bench, message, gap_s, options):
    """Initialisation: "the "U" format" with each X1 and X2; the host's own characters differ from 8 bits, no parity."""
    if1, reply = establish(bench, message, gap_s, **options)
    assert (reply, if1.registers["state"].read()) == (answer(message), "ready")


@pytest.mark.parametrize("line", ["2400 8N2", "instant"])
def test_the_data_format_may_follow_the_bracket_at_once(bench, line):
    """Initialisation: a host that sends 8 bits, even parity and two stop bits, and does not wait for the answer `U`."""
    play(bench, bench.add("if1", line=line), "1.1 s; host 8E2; (U44<CR> -> U<CR>; 1.2 s; F: 0")


@pytest.mark.parametrize("message", [text for text in FORMATS if text[1] in "78"])
def test_a_host_whose_bit_8_is_1_establishes_it_with_gaps(bench, message):
    """Number of data bits: "the last bit being 0, 1 or data-dependent"."""
    _, reply = establish(bench, message, 0.01, eighth=0x80)
    assert reply == answer(message)


def test_once_the_format_is_set_errors_are_found(bench):
    """Motion status: parity and framing errors set their flags only after the format has been set."""
    if1, reply = establish(bench, "U41", 0)
    assert reply == b"0\r"
    if1.serial.host.parity = "E"
    if1.serial.write(b"1")  # "1" has three ones and an even parity bit of 1, read as a stop bit; "3" has four: 0
    if1.serial.write(b"3")
    bench.run(0.1)
    if1.serial.host.parity = "N"
    assert send(bench, if1, "\rF") == b"12\r"  # a framing error, and a number that is no command
