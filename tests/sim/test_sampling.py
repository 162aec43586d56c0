"""Sampling a wire: the same results as a simple reference, at a constant cost per character."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin.core.errors import UsageError
from axistwin.sim.clock import Clock
from axistwin.sim.frames import FASTEST_BAUD, Break, UartFormat
from axistwin.sim.levels import Levels, Space
from axistwin.sim.serial import MANY, Uart
from axistwin.sim.wirings import Pair, join

from . import reference_line as reference

RATES = [110, 300, 1200, 9600, 19200, 38400, 115200, 1_000_000, 4_000_000]
BAUD = st.one_of(st.sampled_from(RATES), st.integers(50, FASTEST_BAUD))
FORMATS = st.builds(
    UartFormat, BAUD, st.sampled_from([5, 7, 8]), st.sampled_from("NEOMS"), st.sampled_from([1, 1.5, 2])
)
CHARACTERS = st.binary(max_size=12)
ITEMS = st.lists(st.one_of(st.integers(0, 255), st.integers(1, 10**8).map(Break)), max_size=12)
TIMES = st.integers(0, 20_000_000)


class Receiver:
    def __init__(self, clock, fmt):
        self.clock, self.found = clock, []
        self.uart = Uart(clock, fmt, on_receive=lambda byte, errors: self.found.append((clock.now, byte, errors)))


def on_the_wire(start_ns, fmt, items, *, own=False):
    """Return the signals of characters without gaps, and the end of the last character."""
    sent = []
    for item in items:
        if isinstance(item, Break):
            sent.append(reference.held(start_ns, item.duration_ns, own=own))
            start_ns += item.duration_ns
        else:
            sent.append(reference.character(start_ns, fmt, item, own=own))
            start_ns += fmt.frame_ns
    return sent, start_ns


def send(uart, items):
    uart.queue.extend(items)
    uart.pump()


def run_out(clock):
    while (due_ns := clock.next_event_ns()) is not None:
        clock.run_to(due_ns)


@settings(max_examples=50, deadline=None)
@given(FORMATS, FORMATS, ITEMS, st.booleans())
def test_whatever_is_sent_to_a_receiver_in_any_format_is_what_the_reference_finds(sender, fmt, items, resynchronises):
    clock = Clock()
    first, second = Uart(clock, sender), Receiver(clock, fmt)
    second.uart.resynchronises = resynchronises
    join(first, second.uart)
    send(first, items)
    run_out(clock)
    sent = on_the_wire(0, sender, items)[0]
    assert second.found == reference.receive(sent, fmt, resynchronises=resynchronises)


@settings(max_examples=30, deadline=None)
@given(st.lists(st.tuples(FORMATS, CHARACTERS), max_size=4), FORMATS)
def test_a_sender_that_changes_its_format_between_characters(parts, fmt):
    clock, sent, start_ns = Clock(), [], 0
    first, second = Uart(clock, fmt), Receiver(clock, fmt)
    join(first, second.uart)
    for sender, data in parts:
        more, end_ns = on_the_wire(start_ns, sender, data)
        sent += more
        first.format = sender
        first.send(data)
        clock.run_to(start_ns := end_ns)
    run_out(clock)
    assert second.found == reference.receive(sent, fmt)


@settings(max_examples=50, deadline=None)
@given(st.lists(st.tuples(FORMATS, TIMES, ITEMS), min_size=2, max_size=4), FORMATS)
def test_any_number_of_senders_that_talk_at_once_on_one_pair(senders, fmt):
    """The first sender is the receiver's own transmitter."""
    clock, sent = Clock(), []
    receiver = Receiver(clock, fmt)
    ends = [receiver.uart, *(Uart(clock, sender) for sender, _, _ in senders[1:])]
    line = Pair(ends).lines[0]
    for number, (end, (sender, start_ns, items)) in enumerate(zip(ends, senders, strict=True)):
        sender = fmt if number == 0 else sender
        sent += on_the_wire(start_ns, sender, items, own=number == 0)[0]
        clock.call_later(start_ns, lambda end=end, items=items: send(end, items))
    run_out(clock)
    assert receiver.found == reference.receive(sent, fmt) and line.samples <= 11 * 5 * len(sent)


@settings(max_examples=60, deadline=None)
@given(FORMATS, FORMATS, CHARACTERS, TIMES)
def test_a_wire_that_is_cut_at_any_moment(sender, fmt, data, cut_ns):
    clock = Clock()
    first, second = Uart(clock, sender), Receiver(clock, fmt)
    join(first, second.uart)
    send(first, data)
    clock.call_later(cut_ns, first.line.cut)
    run_out(clock)
    assert second.found == reference.receive(on_the_wire(0, sender, data)[0], fmt, cut_ns)


@settings(max_examples=30, deadline=None)
@given(FORMATS, FORMATS, CHARACTERS, st.integers(0, 255))
def test_characters_whose_bits_are_flipped_on_the_way(sender, fmt, data, mask):
    clock = Clock()
    first, second = Uart(clock, sender), Receiver(clock, fmt)
    join(first, second.uart)
    first.line.flip(mask, max(1, len(data)))
    send(first, data)
    run_out(clock)
    sent = [reference.character(n * sender.frame_ns, sender, byte, flipped=mask) for n, byte in enumerate(data)]
    assert second.found == reference.receive(sent, fmt)


@settings(max_examples=30, deadline=None)
@given(FORMATS, FORMATS, CHARACTERS, TIMES, st.integers(1, 10**7))
def test_a_wire_that_is_held_at_space_whatever_is_sent(sender, fmt, data, start_ns, duration_ns):
    """The receiver reads space until the short ends, even long after the last character."""
    clock = Clock()
    first, second = Uart(clock, sender), Receiver(clock, fmt)
    join(first, second.uart)
    clock.call_later(start_ns, lambda: first.line.short(duration_ns))
    send(first, data)
    run_out(clock)
    sent = [*on_the_wire(0, sender, data)[0], reference.held(start_ns, duration_ns)]
    assert second.found == reference.receive(sent, fmt)


@pytest.mark.parametrize("baudrate", RATES)
@pytest.mark.parametrize("receiver", [110, 9600, 38400])
def test_the_work_for_a_character_does_not_depend_on_the_baud_rates(baudrate, receiver):
    """A falling edge that can begin a character needs at most 11 samples, and a frame has at most 5 such edges."""
    clock = Clock()
    first, second = Uart(clock, UartFormat(baudrate)), Receiver(clock, UartFormat(receiver))
    join(first, second.uart)
    send(first, bytes(number * 37 % 256 for number in range(300)))
    most = 0
    while clock.next_event_ns() is not None:
        before = first.line.samples
        clock.step()
        most = max(most, first.line.samples - before)
    assert most <= 11 and first.line.samples <= 300 * 5 * 11


def test_what_a_receiver_cannot_see_is_not_kept():
    """A character at 110 baud lasts as long as 36,363 at 4 Mbaud; only those in the last half bit are kept."""
    clock = Clock()
    first, second = Uart(clock, UartFormat(4_000_000)), Receiver(clock, UartFormat(110, stopbits=2))
    join(first, second.uart)
    send(first, b"\0" * 10_000)
    most = 0
    while clock.next_event_ns() is not None:
        clock.step()
        most = max(most, len(first.line._levels))
    assert most <= MANY + 5


@pytest.mark.parametrize(("values", "message"), [
    ({"baudrate": 0}, "invalid baud rate 0: expected a whole number from 1 to 12000000, e.g. 9600"),
    ({"baudrate": -9600}, "invalid baud rate -9600: expected a whole number from 1 to 12000000, e.g. 9600"),
    ({"baudrate": 10**12}, f"invalid baud rate {10**12}: expected a whole number from 1 to 12000000, e.g. 9600"),
    ({"baudrate": 10**5000}, "invalid baud rate of more than 64 binary digits: expected a whole number"),
    ({"baudrate": 9600.5}, "invalid baud rate 9600.5: expected a whole number"),
    ({"bytesize": 900}, "invalid number of data bits 900: expected 5, 6, 7 or 8"),
    ({"parity": "X"}, "invalid parity 'X': expected one of N, E, O, M, S"),
    ({"stopbits": -3}, "invalid number of stop bits -3: expected 1, 1.5 or 2")])  # fmt: skip
def test_a_format_that_no_uart_has_is_refused(values, message):
    with pytest.raises(UsageError) as refused:
        UartFormat(**values)
    assert str(refused.value).startswith(message)


def test_a_break_of_years_costs_no_more_than_its_samples():
    """A character of 10 samples in a space of 31 years, at 12 Mbaud: the work does not grow with the break."""
    wire = Levels()
    wire._spaces.append(Space(0, 10**18, 1, True))
    assert wire.sample(0, 83, 1, 10) == 0 and len(wire) == 1
