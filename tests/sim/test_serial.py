"""Characters on the wire: times, formats, and results of a receiver in another format."""

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin.sim.clock import Clock
from axistwin.sim.frames import LineError, UartFormat
from axistwin.sim.serial import Uart
from axistwin.sim.wirings import join

NONE, PARITY, FRAMING, BREAK = LineError.NONE, LineError.PARITY, LineError.FRAMING, LineError.BREAK

FORMATS = st.builds(
    UartFormat,
    st.sampled_from([110, 300, 1200, 9600, 115200]),
    st.sampled_from([7, 8]),
    st.sampled_from("NEOMS"),
    st.sampled_from([1, 1.5, 2]),
)


class Wire:
    def __init__(self, sender="9600 8N1", receiver="9600 8N1", instant=False):
        self.clock = Clock()
        self.received = []
        self.first = Uart(self.clock, _format(sender))
        self.second = Uart(self.clock, _format(receiver), on_receive=self._receive)
        join(self.first, self.second, instant=instant)

    def _receive(self, byte, errors):
        self.received.append((byte, errors))

    def send(self, data, seconds=1):
        self.first.send(data)
        self.clock.run_to(self.clock.now + round(seconds * 1e9))
        return self.received


def _format(text):
    if not isinstance(text, str):
        return text
    baudrate, frame = text.split()
    return UartFormat(int(baudrate), int(frame[0]), frame[1], float(frame[2:]))


def test_a_character_is_received_at_the_end_of_its_first_stop_bit_and_the_next_begins_after_the_last():
    """9600 8N2: 10 bits to the end of the first stop bit, 11 bits from character to character."""
    wire, times = Wire("9600 8N2", "9600 8N2"), []
    wire.second.on_receive = lambda byte, errors: times.append(wire.clock.now)
    wire.send(b"ab")
    bit = Fraction(10**9, 9600)
    assert times == [round(10 * bit), round(11 * bit) + round(10 * bit)] == [1_041_667, 2_187_500]


@pytest.mark.parametrize(("baudrate", "milliseconds"), [
    (110, 100), (300, 36.667), (600, 18.333), (1200, 9.167), (2400, 4.583), (4800, 2.292), (9600, 1.146)])  # fmt: skip
def test_an_eleven_bit_character_takes_its_time(baudrate, milliseconds):
    assert UartFormat(baudrate, 8, "N", 2).frame_ns / 1e6 == pytest.approx(milliseconds, abs=5e-4)


def test_the_frame_of_the_letter_g_is_sent_least_significant_bit_first():
    """G is 47h = 100 0111b, with four ones; odd parity adds a fifth."""
    levels = UartFormat(9600, 7, "O", 1).frame(ord("G"))
    assert [int(level) for level in levels] == [0, 1, 1, 1, 0, 0, 0, 1, 1]


def test_even_parity_sent_to_a_receiver_without_is_where_the_stop_bit_should_be():
    """8E1 to 8N2: the parity bit of `A` (two ones) is 0, a missing stop bit; that of `C` is 1."""
    assert Wire("9600 8E1", "9600 8N2").send(b"A", 0.01) == [(ord("A"), FRAMING)]
    assert Wire("9600 8E1", "9600 8N2").send(b"C", 0.01) == [(ord("C"), NONE)]


def test_no_parity_sent_to_a_receiver_with_even_parity_shows_it_the_stop_bit():
    """8N2 to 8E1: the stop bit, 1, is read as parity, which is right for characters with an odd number of ones only."""
    assert Wire("9600 8N2", "9600 8E1").send(b"AC", 0.01) == [(ord("A"), PARITY), (ord("C"), NONE)]


def test_odd_against_even_parity_is_a_parity_error_in_every_character():
    assert Wire("9600 8O1", "9600 8E1").send(b"AC", 0.01) == [(ord("A"), PARITY), (ord("C"), PARITY)]


def test_one_stop_bit_is_enough_for_a_receiver_that_expects_two():
    assert Wire("9600 8N1", "9600 8N2").send(b"ABC", 0.01) == [(byte, NONE) for byte in b"ABC"]


def test_seven_bits_with_even_parity_read_as_eight_have_the_parity_on_top():
    assert Wire("9600 7E1", "9600 8N1").send(b"AC", 0.01) == [(ord("A"), NONE), (ord("C") | 0x80, NONE)]


def test_half_the_baud_rate_reads_each_bit_twice():
    """`U` at 4800 is 0 1010 1010 1; at 9600 each bit is read twice: start 00, data 11 00 11 00 ..., cut into frames.

    The start bit is the first 0; data bits 1 to 8 are 0 11 00 11 0, and the stop bit is the second half of a 0.
    """
    assert Wire("4800 8N1", "9600 8N1").send(b"U", 0.01)[0] == (0b0110_0110, FRAMING)


def test_a_break_is_a_zero_without_a_stop_bit_and_then_silence():
    wire = Wire()
    wire.first.send_break(0.25)
    assert wire.send(b"a") == [(0, FRAMING | BREAK), (ord("a"), NONE)]


def test_a_lost_character_takes_its_time_and_does_not_arrive():
    wire = Wire()
    wire.first.line.lose(2)
    assert wire.send(b"abc") == [(ord("c"), NONE)]


def test_a_doubled_character_arrives_twice():
    wire = Wire()
    wire.first.line.double()
    assert [byte for byte, _ in wire.send(b"ab")] == list(b"aab")


def test_a_flipped_bit_is_found_by_parity_and_only_by_parity():
    with_parity, without = Wire("9600 8E1", "9600 8E1"), Wire()
    for wire in (with_parity, without):
        wire.first.line.flip(0b100)
    assert with_parity.send(b"a") == [(ord("a") ^ 0b100, PARITY)] and without.send(b"a") == [(ord("a") ^ 0b100, NONE)]


def test_a_line_cut_in_the_middle_of_a_character_reads_as_ones_from_there_on():
    """`0` is 30h, sent 0 0000 1100 1; cut after the start bit and three bits, the rest reads as ones."""
    wire = Wire()
    wire.first.send(b"0")
    wire.clock.run_to(round(4 * 1e9 / 9600))
    wire.first.line.cut()
    assert wire.send(b"xyz", 0.1) == [(0b1111_1000, NONE)]
    wire.first.line.mend()
    assert wire.send(b"z")[1:] == [(ord("z"), NONE)]


def test_a_receiver_without_a_format_measures_the_first_low_time():
    """In `(`, 28h, the start bit and three zeros are low: 4 bits, 3.333 ms at 1200 baud."""
    wire, lows = Wire("1200 8N2", None), []

    def measure(low_ns):
        lows.append(low_ns)
        return UartFormat(1200, 8, "N", 2)

    wire.second.on_measure = measure
    assert wire.send(b"(") == [(ord("("), NONE)] and lows == [Fraction(4 * 10**9, 1200)]


def test_an_instant_line_takes_no_time_but_waits_for_room():
    wire = Wire(instant=True)
    wire.second.has_room = lambda: len(wire.received) < 3
    assert [byte for byte, _ in wire.send(b"abcd", 0)] == list(b"abc")
    wire.second.has_room = lambda: True
    wire.second.pump_peer()
    assert [byte for byte, _ in wire.received] == list(b"abcd") and wire.clock.now == 0


@settings(max_examples=60, deadline=None)
@given(FORMATS, st.binary(max_size=12))
def test_whatever_the_format_equal_ends_understand_each_other(fmt, data):
    mask = (1 << fmt.bytesize) - 1
    assert Wire(fmt, fmt).send(data, 3) == [(byte & mask, NONE) for byte in data]


@settings(max_examples=60, deadline=None)
@given(FORMATS, st.integers(0, 255))
def test_reading_bit_by_bit_gives_what_was_sent(fmt, byte):
    frame = fmt.frame(byte)

    def level_at(since_ns):
        bit = int(since_ns / fmt.bit_ns)
        return frame[bit] if bit < len(frame) else True

    assert fmt.decode(level_at) == (byte & ((1 << fmt.bytesize) - 1), NONE)


@settings(max_examples=60, deadline=None)
@given(FORMATS, FORMATS, st.binary(max_size=8))
def test_any_mismatch_gives_characters_or_nothing_and_never_hangs(sender, receiver, data):
    wire = Wire(sender, receiver)
    received = wire.send(data, 5)
    assert all(0 <= byte < 256 for byte, _ in received)
    assert wire.clock.next_event_ns() is None


def test_a_receiver_that_resynchronises_finds_the_start_bit_in_its_own_stop_bit():
    """7N1 without gaps to 8N1: the next start bit lies where the stop bit is expected."""
    lost, found = Wire("9600 7N1", "9600 8N1"), Wire("9600 7N1", "9600 8N1")
    found.second.resynchronises = True
    assert [byte & 0x7F for byte, _ in lost.send(b"U11")] != [0x55, 0x31, 0x31]
    assert found.send(b"U11") == [(0xD5, FRAMING), (0xB1, FRAMING), (0xB1, NONE)]


def test_a_receiver_that_resynchronises_does_not_mistake_a_parity_bit_for_a_start_bit():
    """8E2 to 8N2: a parity bit of 0 after a bit 8 of 0 makes no falling edge."""
    wire = Wire("9600 8E2", "9600 8N2")
    wire.second.resynchronises = True
    assert wire.send(b"U3") == [(0x55, FRAMING), (0x33, FRAMING)]


@pytest.mark.parametrize("instant", [False, True])
def test_a_second_look_reads_one_character_in_another_format(instant):
    """A receiver at 9600 baud also detects a character at 1200 baud whose first four bits are low."""
    wire = Wire("1200 8N1", "9600 8N1", instant)
    slow, seen = UartFormat(1200), []

    def look(low_ns, level_at):
        seen.append((low_ns, slow.decode(level_at)))
        return slow if low_ns == 4 * slow.bit_ns else None

    wire.second.second_look = look
    assert wire.send(b"(") == [(0x28, NONE)] and seen == [(4 * slow.bit_ns, (0x28, NONE))]
    wire.first.format = wire.second.format
    assert wire.send(b"(")[1:] == [(0x28, NONE)]
