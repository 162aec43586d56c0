"""Requests of a web page: a browser sends them to any port, and their text could move an axis."""

import re
import socket

import pytest

from .serving import ask, dial, receive

HEADERS = (
    b"Host: 127.0.0.1:5001\r\nOrigin: http://example.org\r\nContent-Type: text/plain\r\nContent-Length: 99\r\n\r\n"
)
LINES = [
    b"POST / HTTP/1.1\r\n", b"GET /X+400$ HTTP/1.1\r\n", b"OPTIONS / HTTP/1.1\r\n",
    b"PUT /" + b"a" * 200 + b" HTTP/1.1\r\n",
]  # fmt: skip


def closed(connection):
    """Wait until the server has closed the connection; return what it has sent."""
    found = b""
    try:
        while data := connection.recv(4096):
            found += data
    except ConnectionError:
        pass
    return found


@pytest.mark.parametrize("line", LINES)
@pytest.mark.parametrize("scheme", ["tcp", "rfc2217"])
def test_a_web_page_moves_nothing(served, caplog, scheme, line):
    if1 = served.add()
    url = served.open(if1, f"{scheme}://:0")
    with dial(url) as browser:
        browser.sendall(line + HEADERS + b"\rX+400$\r")
        closed(browser)
    with dial(url) as host:
        assert ask(host, b"E\r", b"C\r") == b"C\r" and if1.axes["X"].position == 0
    (told,) = [record.getMessage() for record in caplog.records if "HTTP" in record.getMessage()]
    assert re.fullmatch(r"if1: closed 127\.0\.0\.1:\d+, which sent an HTTP request, as a web page does", told)


def test_a_web_page_writes_no_register_of_a_board(served, caplog):
    board = served.add_board()
    with dial(served.open(board, "bus://127.0.0.1:0")) as browser:
        browser.sendall(LINES[0] + HEADERS + b"w 0 33 00 00 01 90\nw 1 10\n")
        assert closed(browser) == b""
    assert [record for record in caplog.records if "HTTP" in record.getMessage()]


def test_a_request_in_single_bytes_is_closed_at_its_first_slash(served):
    with dial(served.open(served.add())) as browser:
        browser.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        for byte in b"POST /":
            browser.send(bytes((byte,)))
        assert closed(browser) == b""


@pytest.mark.parametrize("said", [b"P", b"POS", b"POST", b"GET", b"OPTIONS "])
def test_a_host_whose_first_characters_are_those_of_a_method_is_not_delayed(served, said):
    with dial(served.open(served.add())) as host:
        host.sendall(said)
        host.sendall(b"\rF\r")
        assert receive(host, 2) == b"8\r"  # one data fault: the characters have reached the interface
        assert ask(host, b"E\r", b"C\r") == b"C\r"


def test_the_text_of_a_request_later_in_a_connection_is_for_the_controller(served):
    with dial(served.open(served.add())) as host:
        assert ask(host, b"E\r", b"C\r") == b"C\r"
        host.sendall(b"POST / HTTP/1.1\rF\r")
        assert receive(host, 2) == b"8\r"
