"""Daisy chains and shared pairs: receivers, times, and simultaneous senders."""

from itertools import product

import pytest

from axistwin.sim.clock import Clock
from axistwin.sim.frames import LineError, UartFormat
from axistwin.sim.serial import Uart
from axistwin.sim.serial_port import SerialPort
from axistwin.sim.wirings import daisy_chain, direct, shared_pair

FORMAT = UartFormat(9600, 8, "N", 1)
FRAME = FORMAT.frame_ns  # 10 bits at 9600 baud: 1,041,667 ns
MS = 10**6


class Device:
    """A device with a UART that records its characters and their times, with an optional echo."""

    def __init__(self, clock, echo=False, fmt=FORMAT):
        self.clock, self.echo, self.heard = clock, echo, []
        self.uart = Uart(clock, fmt, on_receive=self.take)

    def take(self, byte, errors):
        self.heard.append((self.clock.now, byte, errors))
        if self.echo:
            self.uart.send(bytes([byte]))

    @property
    def bytes(self):
        return bytes(byte for _, byte, _ in self.heard)

    @property
    def errors(self):
        return [errors for _, _, errors in self.heard]


@pytest.fixture
def clock():
    return Clock()


def host(clock, wiring):
    return SerialPort(clock, wiring, line=FORMAT)


def test_a_character_goes_through_a_chain_in_as_many_frames_as_there_are_wires(clock):
    devices = [Device(clock, echo=True) for _ in range(3)]
    port = host(clock, daisy_chain([device.uart for device in devices]))
    port.write(b"R")
    clock.run_to(100 * MS)
    assert [device.heard[0][0] for device in devices] == [FRAME, 2 * FRAME, 3 * FRAME]
    assert port.read() == b"R"


def test_a_device_in_a_chain_that_does_not_echo_hides_the_others(clock):
    first, second = Device(clock), Device(clock, echo=True)
    port = host(clock, daisy_chain([first.uart, second.uart]))
    port.write(b"R")
    clock.run_to(100 * MS)
    assert (first.bytes, second.bytes, port.read()) == (b"R", b"", b"")
    first.uart.send(b"x")  # the character reaches the second device, whose echo reaches the host
    clock.run_to(200 * MS)
    assert (second.bytes, port.read()) == (b"x", b"x")


def test_a_chain_that_takes_no_time(clock):
    devices = [Device(clock, echo=True) for _ in range(3)]
    port = host(clock, daisy_chain([device.uart for device in devices], instant=True))
    port.write(b"RP\r")
    assert (port.read(), clock.now) == (b"RP\r", 0)


def test_on_a_shared_pair_everybody_hears_everybody_else(clock):
    devices = [Device(clock) for _ in range(3)]
    port = host(clock, shared_pair([device.uart for device in devices]))
    port.write(b"RP\r")
    clock.run_to(10 * MS)
    assert [device.bytes for device in devices] == [b"RP\r"] * 3 and port.read() == b""
    devices[1].uart.send(b"17\r")
    clock.run_to(20 * MS)
    assert (devices[0].bytes, devices[1].bytes, devices[2].bytes) == (b"RP\r17\r", b"RP\r", b"RP\r17\r")
    assert port.read() == b"17\r"


def test_a_shared_pair_that_takes_no_time(clock):
    devices = [Device(clock) for _ in range(2)]
    port = host(clock, shared_pair([device.uart for device in devices], instant=True))
    port.write(b"RP\r")
    devices[0].uart.send(b"1\r")
    assert (devices[1].bytes, port.read()) == (b"RP\r1\r", b"1\r")


@pytest.mark.parametrize(("one", "other"), list(product((0x00, 0x0D, 0x55, 0x96, 0xFF), repeat=2)))
def test_two_that_begin_at_once_are_heard_as_the_and_of_their_bits(clock, one, other):
    """A space overrides a mark; at 9600 8N1 the bits of both characters coincide, so the result is their AND."""
    first, second, third = (Device(clock) for _ in range(3))
    port = host(clock, shared_pair([first.uart, second.uart, third.uart]))
    first.uart.send(bytes([one]))
    second.uart.send(bytes([other]))
    clock.run_to(10 * MS)
    assert (port.read(), third.bytes) == (bytes([one & other]),) * 2 and third.errors == [LineError.NONE]


def test_a_second_one_that_begins_in_the_middle_of_a_character_garbles_both(clock):
    """FFh is one low bit and nine high ones; 00h begins 5 bits later and makes the last four data bits low.

    Read from the first falling edge: start, 1 1 1 1 0 0 0 0 = 0Fh, and a space where the stop bit is expected.  The
    wire then stays low until 14 bits after the first edge.
    """
    first, second, third = (Device(clock) for _ in range(3))
    host(clock, shared_pair([first.uart, second.uart, third.uart]))
    first.uart.send(b"\xff")
    clock.call_later(5 * FORMAT.frame_ns // 10, lambda: second.uart.send(b"\x00"))
    clock.run_to(20 * MS)
    assert [(byte, errors) for _, byte, errors in third.heard] == [(0x0F, LineError.FRAMING)]


def test_who_talks_while_another_does_hears_it_garbled_and_never_itself(clock):
    first, second = Device(clock), Device(clock)
    port = host(clock, shared_pair([first.uart, second.uart]))
    first.uart.send(b"\x0f")
    port.write(b"\x55")
    clock.run_to(10 * MS)
    assert (first.bytes, port.read(), second.bytes) == (b"\x05", b"\x05", b"\x05")
    first.uart.send(b"ok")
    clock.run_to(20 * MS)
    assert (first.bytes, port.read()) == (b"\x05", b"ok")


def test_talk_one_after_the_other_is_not_garbled(clock):
    first, second = Device(clock), Device(clock)
    port = host(clock, shared_pair([first.uart, second.uart]))
    port.write(b"a")
    clock.call_later(FRAME, lambda: first.uart.send(b"b"))
    clock.call_later(2 * FRAME, lambda: port.write(b"c"))
    clock.run_to(10 * MS)
    assert (first.bytes, second.bytes, port.read()) == (b"ac", b"abc", b"b") and second.errors == [LineError.NONE] * 3


def test_a_break_on_a_shared_pair(clock):
    first, second = Device(clock), Device(clock)
    port = host(clock, shared_pair([first.uart, second.uart]))
    port.send_break(0.01)
    clock.run_to(20 * MS)
    port.write(b"a")
    clock.run_to(30 * MS)
    assert [(byte, errors) for _, byte, errors in second.heard] == [
        (0, LineError.FRAMING | LineError.BREAK), (ord("a"), LineError.NONE),
    ]  # fmt: skip


def test_a_port_without_control_lines_counts_as_on(clock):
    port = host(clock, direct(Device(clock).uart))
    assert (port.handshake, port.dtr, port.rts) == (False, True, True)


def test_an_end_that_nothing_is_connected_to_sends_all_the_same(clock):
    device = Device(clock)
    device.uart.send(b"abc")
    clock.run_to(2 * FRAME)
    assert (device.uart.sending, len(device.uart.queue)) == (True, 0)
    clock.run_to(3 * FRAME)
    assert device.uart.sending is False
