"""The page of `axistwin stand-in` that shows live motors and stops them."""

import http.client
import json
import subprocess
import sys
from urllib.parse import urlsplit
from urllib.request import urlopen

import pytest

from axistwin.errors import LinkError, UsageError
from axistwin.standin import StopPage


@pytest.fixture
def page():
    stops, state = [], {"state": "LIVE: table.X", "live": True, "reason": "", "positions": {"table.X": 12}}
    made = StopPage("0", lambda: state, lambda: stops.append("stop"))
    made.stops, made.values = stops, state
    yield made
    made.close()


def read(page, path=""):
    with urlopen(page.url + path, timeout=20) as answer:
        return answer.headers["Content-Type"], answer.read().decode()


def post(page):
    client = http.client.HTTPConnection(urlsplit(page.url).netloc, timeout=20)
    client.request("POST", "/stop", body=b"x" * 10)
    answer = client.getresponse()
    client.close()
    return answer.status, answer.headers["Location"]


def test_the_page_shows_the_state_and_stops(page):
    kind, text = read(page)
    assert kind == "text/html; charset=utf-8"
    assert '<form method="post" action="/stop">' in text  # the form works without JavaScript
    assert json.loads(read(page, "state")[1]) == page.values
    assert page.stops == []
    assert post(page) == (303, "/")
    assert page.stops == ["stop"]
    client = http.client.HTTPConnection(urlsplit(page.url).netloc, timeout=20)
    client.request("GET", "/other")
    assert client.getresponse().status == 404
    client.close()


def test_the_stop_works_while_the_emulation_is_busy(page):
    """This thread calculates without a pause until the stop from another process comes."""
    code = f"from urllib.request import *; urlopen(Request({page.url!r} + 'stop', method='POST'), timeout=20)"
    with subprocess.Popen([sys.executable, "-c", code]) as process:
        while not page.stops and process.poll() is None:
            sum(range(1000))
    assert page.stops == ["stop"]


def test_a_wrong_address_and_a_port_in_use(page):
    with pytest.raises(UsageError, match="expected ADDRESS:PORT"):
        StopPage("127.0.0.1:x", dict, list)
    with pytest.raises(LinkError, match="choose another port"):
        StopPage(str(urlsplit(page.url).port), dict, list)
