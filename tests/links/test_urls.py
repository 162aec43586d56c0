"""Ports as URLs."""

import pytest

from axistwin.core.errors import UsageError
from axistwin.links.urls import PortUrl, parse, parse_as


@pytest.mark.parametrize(("text", "url"), [
    ("tcp://127.0.0.1:5001", PortUrl("tcp", "127.0.0.1", 5001)),
    ("tcp://:0", PortUrl("tcp", "127.0.0.1", 0)),
    ("tcp://5001", PortUrl("tcp", "127.0.0.1", 5001)),
    ("tcp://0.0.0.0:5001", PortUrl("tcp", "0.0.0.0", 5001)),
    ("tcp://[::1]:5001", PortUrl("tcp", "::1", 5001)),
    ("rfc2217://localhost:2217", PortUrl("rfc2217", "localhost", 2217)),
    ("pty:/tmp/if1", PortUrl("pty", path="/tmp/if1")),
    ("pty:///tmp/if1", PortUrl("pty", path="/tmp/if1")),
    ("pty:if1", PortUrl("pty", path="if1")),
    ("pty:", PortUrl("pty")),
    ("serial:///dev/ttyUSB0?baud=9600", PortUrl("serial", path="/dev/ttyUSB0", baud=9600)),
    ("serial:///dev/ttyUSB0", PortUrl("serial", path="/dev/ttyUSB0"))])  # fmt: skip
def test_a_url_names_a_port(text, url):
    assert parse(text) == url


@pytest.mark.parametrize("text", [
    "tcp://127.0.0.1:5001", "rfc2217://[::1]:2217", "rfc2217://h:1?cts=dtr", "pty:/tmp/if1", "pty:",
    "serial:///dev/ttyS0?baud=110"])  # fmt: skip
def test_a_url_is_written_as_it_is_read(text):
    assert str(parse(text)) == text


@pytest.mark.parametrize(("scheme", "text"), [
    ("tcp", ":5001"), ("rfc2217", "h:1"), ("pty", "/x"), ("serial", "/dev/x")])  # fmt: skip
def test_an_option_names_the_scheme(scheme, text):
    assert parse_as(scheme, text).scheme == scheme


@pytest.mark.parametrize("text", [
    "", "tcp", "127.0.0.1:5001", "http://127.0.0.1:80", "tcp://127.0.0.1", "tcp://127.0.0.1:", "tcp://h:65536",
    "tcp://h:x", "tcp://h:-1", "tcp://h:²", "serial://", "serial:///dev/x?baud=0", "serial:///dev/x?baud=fast",
    "serial:///dev/x?bits=7"])  # fmt: skip
def test_a_bad_url_is_one_line_that_shows_a_good_one(text):
    with pytest.raises(UsageError, match=r"expected .*, e\.g\. \w+:") as caught:
        parse(text)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("text", ["tcp://h:1?cts=dtr", "rfc2217://h:1?cts=dsr", "rfc2217://h:1?baud=9600"])
def test_an_option_that_a_port_does_not_take_is_told(text):
    with pytest.raises(UsageError, match=r"expected \?cts=dtr for rfc2217"):
        parse(text)
