"""Frames, dictionary, channel and clock fit, each without a board."""

import json
import random
import zlib

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin.core.errors import LinkError
from axistwin.real.standin import frames
from axistwin.real.standin.channel import Channel
from axistwin.real.standin.clock_fit import ClockFit
from axistwin.real.standin.dictionary import Dictionary

from .small_board import DESCRIBED


@pytest.mark.parametrize(("low", "high", "size"), [
    (-32, 95, 1), (-4096, 12287, 2), (-524288, 1572863, 3), (-67108864, 201326591, 4), (-2147483648, 2147483647, 5)
])  # fmt: skip
def test_sizes_of_integers_as_the_protocol_lists_them(low, high, size):
    assert [len(frames.integer(low)), len(frames.integer(high))] == [size, size]


@given(st.integers(-(1 << 31), (1 << 32) - 1))
def test_integers_are_decoded_as_they_were_encoded(value):
    data = frames.integer(value)
    assert frames.read_integer(data, 0) == (value if value < 1 << 31 else value - (1 << 32), len(data))


def test_the_crc():
    assert frames.crc16(b"123456789") == 0x6F91  # CRC-16/MCRF4XX


@settings(max_examples=50)
@given(st.lists(st.binary(max_size=frames.MOST_CONTENT), max_size=8), st.lists(st.integers(1, 40), max_size=30))
def test_blocks_are_found_in_any_pieces(contents, pieces):
    stream = b"".join(frames.block(number, content) for number, content in enumerate(contents))
    reader, found = frames.Reader(), []
    for piece in [*pieces, len(stream)]:
        found += reader.feed(stream[:piece])
        stream = stream[piece:]
    assert found == [(number & 15, content) for number, content in enumerate(contents)]
    assert reader.damaged == 0


@given(st.binary(max_size=200))
def test_a_block_is_found_after_any_bytes(noise):
    reader = frames.Reader()
    list(reader.feed(noise))
    list(reader.feed(bytes([frames.SYNC]) * 64))
    assert (3, b"hello") in list(reader.feed(frames.block(3, b"hello")))


def test_a_dictionary_is_unpacked():
    read = Dictionary.unpack(zlib.compress(json.dumps(DESCRIBED).encode()))
    assert read.clock_hz == 16e6 and read.pins["P31"] == 31
    assert read.encode("queue_step", oid=1, interval=4000, count=2, add=-3) == bytes([10, 1, 0x9F, 0x20, 2, 0x7D])
    shutdown = frames.integer(45) + frames.integer(77) + frames.integer(2)
    assert read.decode(shutdown) == ("shutdown", {"clock": 77, "static_string_id": "Timer too close"})


@pytest.mark.parametrize("data", [b"", b"x", zlib.compress(b"[]"), zlib.compress(b'{"commands": 3}')])
def test_a_damaged_dictionary_is_refused(data):
    with pytest.raises(LinkError, match="dictionary"):
        Dictionary.unpack(data)


@settings(max_examples=50)
@given(st.binary(max_size=40))
def test_any_response_can_be_decoded(content):
    _name, values = Dictionary(DESCRIBED).decode(content)
    assert isinstance(values, dict)


def test_a_command_that_the_firmware_lacks_is_refused():
    with pytest.raises(LinkError, match="no command 'config_pwm_out'"):
        Dictionary(DESCRIBED).encode("config_pwm_out", oid=1)


class Echo:
    """The board's end of a channel: it accepts blocks in order, and acknowledges them."""

    def __init__(self, expected):
        self.reader, self.expected, self.taken = frames.Reader(), expected, []

    def receive(self, data):
        out = b""
        for sequence, content in self.reader.feed(data):
            if sequence == self.expected & 15:
                self.expected += 1
                self.taken.append(content)
            out += frames.block(self.expected, b"")
        return out


def damaged(data, chance, rng):
    """Return the bytes; a fraction `chance` of them is lost, doubled or changed."""
    out = bytearray()
    for byte in data:
        fate = rng.random() / chance if chance else 1
        out += (
            (b"", bytes([byte, byte]), bytes([byte ^ 1 << rng.randrange(8)]))[int(fate * 3)]
            if fate < 1
            else bytes([byte])
        )
    return bytes(out)


@pytest.mark.parametrize("expected", [0, 1, 2, 9, 15])
@pytest.mark.parametrize("chance", [0.0, 0.003, 0.01])
def test_commands_arrive_once_and_in_order(expected, chance):
    rng = random.Random(expected)
    channel, board, now = Channel(), Echo(expected), 0.0
    channel.send(b"hello")
    wanted = [bytes([n % 251, n // 251]) * 9 for n in range(150)]
    for _ in range(100):  # both ends agree on the number of the first block
        now += 0.001
        list(channel.receive(board.receive(channel.due(now)), now))
    assert channel.idle
    board.taken.clear()
    channel.again = 0
    for content in wanted:
        channel.send(content)
    while not channel.idle:
        now += 0.001
        assert now < 60
        answer = board.receive(damaged(channel.due(now), chance, rng))
        list(channel.receive(damaged(answer, chance, rng), now))
    assert b"".join(board.taken) == b"".join(wanted) and (channel.again > 0) is (chance > 0)


def test_the_time_without_acknowledgement():
    channel = Channel()
    channel.send(b"x")
    channel.due(1.0)
    channel.due(2.5)
    assert channel.silent_s(2.5) == 1.5


@pytest.mark.parametrize("drift", [-200e-6, 0.0, 200e-6])
def test_a_drifting_clock_is_fitted(drift):
    rng, fit, hz = random.Random(3), ClockFit(16e6), 16e6 * (1 + drift)
    start, errors = 0xFFFF_0000, []
    for n in range(1200):
        sent = float(n)
        trip = 0.0005 + rng.random() * 0.00005 + (0.02 if rng.random() < 0.1 else 0)
        fit.add(sent, sent + trip, (start + int((sent + trip / 2) * hz)) & 0xFFFF_FFFF)
        if fit.ready:
            true = int((sent + 1.0) * hz)
            errors.append((fit.ticks(sent + 1.0) - fit.ticks(0)) - (true if n else 0))
    spread = max(errors[100:]) - min(errors[100:])
    assert fit.error_s < 50e-6 and abs(fit.hz / hz - 1) < 2e-6
    assert spread / hz < 1200 * 2e-6


def test_a_late_reading_of_the_clock_moves_a_steady_line_by_20_us():
    """Readings of a 16 MHz clock each 20 ms; then one that is late by 5 ms although its round trip seems short."""
    fit = ClockFit(16e6)
    for n in range(60):
        fit.add(n * 0.02, n * 0.02 + 0.001, n * 320_000)
    fit.steady = True
    expected = fit.ticks(2.0)
    fit.add(2.0, 2.001, 32_000_000 - 80_000)
    assert abs(fit.ticks(2.0005) - (expected + 8000)) == pytest.approx(20e-6 * 16e6, rel=0.01)
    assert abs(fit.hz - 16e6) <= 16e6 * 21e-6
