"""The page of `axistwin stand-in` that shows live motors and stops them."""

import http.client
import json
import os
import random
import socket
import struct
import subprocess
import sys
import threading
from contextlib import ExitStack
from urllib.parse import urlsplit
from urllib.request import urlopen

import pytest

from axistwin.core.errors import LinkError, UsageError
from axistwin.real.standin.stop_page import StopPage


@pytest.fixture
def page():
    stops, state = [], {"state": "LIVE: table.X", "live": True, "reason": "", "positions": {"table.X": 12}}
    made = StopPage("0", lambda: state, lambda: stops.append("stop"))
    made.stops, made.values = stops, state
    yield made
    made.close()


def read(page, path=""):
    with urlopen(page.url + path, timeout=300) as answer:
        return answer.headers["Content-Type"], answer.read().decode()


def post(page, **headers):
    client = http.client.HTTPConnection(urlsplit(page.url).netloc, timeout=300)
    client.request("POST", "/stop", body=b"x" * 10, headers={key.replace("_", "-"): headers[key] for key in headers})
    answer = client.getresponse()
    client.close()
    return answer.status, answer.headers["Location"]


def connect(page):
    url = urlsplit(page.url)
    return socket.create_connection((url.hostname, url.port), timeout=300)


def raw(page, data):
    with connect(page) as visitor:
        visitor.sendall(data)
        return visitor.makefile("rb").readline()


def test_the_page_shows_the_state_and_stops(page):
    kind, text = read(page)
    assert kind == "text/html; charset=utf-8"
    assert '<form method="post" action="/stop">' in text  # the form works without JavaScript
    assert json.loads(read(page, "state")[1]) == page.values and page.stops == []
    assert post(page) == (303, "/") and page.stops == ["stop"]
    client = http.client.HTTPConnection(urlsplit(page.url).netloc, timeout=300)
    client.request("GET", "/other")
    assert client.getresponse().status == 404
    client.close()


@pytest.mark.parametrize(
    "headers",
    [
        {"Origin": "http://evil.example"},
        {"Origin": "null"},  # a page in a sandbox
        {"Host": "evil.example"},  # a web site whose name points to this computer
        {"Host": "evil.example", "Origin": "http://evil.example"},
        {"Sec_Fetch_Site": "cross-site", "Sec_Fetch_Mode": "no-cors"},
        {"Host": "192.168.1.7:8080"},  # the page is for this computer only
    ],
)
def test_a_page_of_another_web_site_neither_stops_nor_reads(page, headers):
    assert post(page, **headers)[0] == 403 and page.stops == []
    lines = "".join(f"{key.replace('_', '-')}: {value}\r\n" for key, value in ({"Host": "localhost"} | headers).items())
    assert raw(page, f"GET /state HTTP/1.1\r\n{lines}\r\n".encode()).startswith(b"HTTP/1.1 403 ")


def test_the_own_page_stops_from_each_of_its_addresses(page):
    port = urlsplit(page.url).port
    for host in (f"127.0.0.1:{port}", f"localhost:{port}", f"[::1]:{port}"):
        assert post(page, Host=host, Origin=f"http://{host}", Sec_Fetch_Site="same-origin") == (303, "/")
    assert len(page.stops) == 3


@pytest.mark.parametrize(("name", "status"), [
    ("192.168.1.7", 200), ("[fe80::1]", 200), (socket.gethostname(), 200), ("localhost", 200), ("evil.example", 403)
])  # fmt: skip
def test_a_page_for_all_computers_is_found_by_address_and_by_the_name_of_this_computer(name, status):
    page = StopPage("0.0.0.0:0", dict, list)
    try:
        head = f"GET /state HTTP/1.1\r\nHost: {name}:{urlsplit(page.url).port}\r\n\r\n"
        assert raw(page, head.encode()).startswith(b"HTTP/1.1 %d " % status)
    finally:
        page.close()


@pytest.mark.parametrize("length", ["abc", "-1", "9" * 5000, "1e3", "\u0661"])
def test_a_wrong_length_costs_no_stop_and_no_traceback(page, length, capfd):
    head = f"POST /stop HTTP/1.1\r\nHost: localhost\r\nContent-Length: {length}\r\n\r\n"
    assert raw(page, head.encode()).startswith(b"HTTP/1.1 303 ") and page.stops == ["stop"]
    assert capfd.readouterr().err == ""


def test_garbage_is_refused_without_a_traceback(page, capfd):
    rng = random.Random(1)
    heads = [b"", b"GET", b"GET /", b"\r\n", b"GET / HTTP/1.1\r\n" + b"a: b\r\n" * 200, b"x" * 20_000]
    for head in [*heads, *(rng.randbytes(rng.randrange(400)) for _ in range(50))]:
        assert raw(page, head + b"\r\n\r\n")[:13] in (b"HTTP/1.1 400 ", b"HTTP/1.1 403 ", b"")
    assert json.loads(read(page, "state")[1]) == page.values
    assert capfd.readouterr().err == ""


@pytest.mark.slow
@pytest.mark.skipif(not os.path.isdir("/proc/self/fd"), reason="only on Linux")
def test_idle_visitors_take_away_neither_the_page_nor_the_descriptors(page):
    def files():
        return len(os.listdir("/proc/self/fd"))

    threads, before, visitors = threading.active_count(), files(), 150
    with ExitStack() as stack:
        for _ in range(visitors):
            stack.enter_context(connect(page))
        assert json.loads(read(page, "state")[1]) == page.values and post(page) == (303, "/")
        assert files() < before + visitors + visitors // 2
        assert threading.active_count() == threads
    assert page.stops == ["stop"]


def test_visitors_that_leave_at_once_cost_nothing(page, capfd):
    for _ in range(3):
        with ExitStack() as stack:
            for _ in range(50):
                visitor = stack.enter_context(connect(page))
                visitor.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
                visitor.sendall(b"GET /state HTTP/1.1\r\nHost: localhost\r\n\r\n")
        assert json.loads(read(page, "state")[1]) == page.values
    assert capfd.readouterr().err == ""


def test_the_stop_works_while_the_emulation_is_busy(page):
    """This thread calculates without a pause until the stop from another process comes."""
    code = f"from urllib.request import *; urlopen(Request({page.url!r} + 'stop', method='POST'), timeout=300)"
    with subprocess.Popen([sys.executable, "-c", code]) as process:
        while not page.stops and process.poll() is None:
            sum(range(1000))
    assert page.stops == ["stop"]


def test_a_wrong_address_and_a_port_in_use(page):
    with pytest.raises(UsageError, match="expected ADDRESS:PORT"):
        StopPage("127.0.0.1:x", dict, list)
    with pytest.raises(LinkError, match="choose another port"):
        StopPage(str(urlsplit(page.url).port), dict, list)
