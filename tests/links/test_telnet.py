"""Telnet: separation of data and commands."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin.links.telnet import (
    IAC,
    LONGEST_SUBNEGOTIATION,
    SB,
    SE,
    Command,
    Negotiation,
    Parser,
    Subnegotiation,
    Verb,
    escape,
)

PIECES = st.lists(
    st.one_of(
        st.binary(max_size=8).map(escape),
        st.builds(Negotiation, st.sampled_from(Verb), st.integers(0, 255)).map(bytes),
        st.builds(Subnegotiation, st.integers(0, 254), st.binary(max_size=20)).map(bytes),
        st.binary(max_size=8),
        st.sampled_from([bytes([IAC]), bytes([IAC, SB]), bytes([IAC, SB, 44]), bytes([IAC, SE]), b"x" * 100]),
    )
).map(b"".join)


def joined(items):
    result = []
    for item in items:
        if isinstance(item, bytes) and result and isinstance(result[-1], bytes):
            result[-1] += item
        else:
            result.append(item)
    return result


@pytest.mark.parametrize(("data", "items"), [
    (b"E\r", [b"E\r"]), (b"a\xff\xffb", [b"a\xffb"]), (b"a\xff\xfb\x2cb", [b"a", Negotiation(Verb.WILL, 44), b"b"]),
    (b"\xff\xfa\x2c\x01\x00\x00\x25\x80\xff\xf0", [Subnegotiation(44, b"\x01\x00\x00\x25\x80")]),
    (b"\xff\xfa\x2c\x01\xff\xff\xff\xf0", [Subnegotiation(44, b"\x01\xff")]), (b"\xff\xf3a", [Command(0xF3), b"a"]),
    (b"a\xff", [b"a"]), (b"\xff\xfa\x2c\x05", []),
    (b"\xff\xfa\x2c\xff\xfd\x01b", [Command(SB), Negotiation(Verb.DO, 1), b"b"])])  # fmt: skip
def test_a_stream_is_taken_apart(data, items):
    assert Parser().feed(data) == items


def test_a_subnegotiation_without_end_is_forgotten():
    """After `LONGEST_SUBNEGOTIATION` bytes without an end, the following bytes are data again."""
    parser = Parser()
    parser.feed(bytes([IAC, SB]))
    for _ in range(10 * LONGEST_SUBNEGOTIATION):
        items = parser.feed(b"x")
    assert items == [b"x"]


@settings(max_examples=50)
@given(PIECES)
def test_fed_whole_or_byte_by_byte_it_means_the_same(data):
    whole, slow = Parser(), Parser()
    assert joined(whole.feed(data)) == joined([item for byte in data for item in slow.feed(bytes([byte]))])


@given(st.binary())
def test_escaped_data_comes_out_as_it_was(data):
    assert b"".join(Parser().feed(escape(data))) == data
