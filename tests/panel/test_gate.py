"""Access control of the panel's web server."""

import asyncio

import httpx
import pytest

from axistwin.links import web_gate
from axistwin.ui.panel.gate import PERSON, Gate


async def page(scope, receive, send):
    await send({"type": "http.response.start", "status": 200, "headers": []})
    await send({"type": "http.response.body", "body": scope["person"].encode()})


def asked(token, *requests, base="http://127.0.0.1:8080"):
    """Return the answers to these requests of one browser, which stores cookies."""

    async def ask():
        transport = httpx.ASGITransport(Gate(page, token))
        async with httpx.AsyncClient(transport=transport, base_url=base) as browser:
            return [await browser.get(path, headers=headers) for path, headers in requests]

    return asyncio.run(ask())


@pytest.mark.parametrize(("host", "own"), [
    ("localhost", True), ("127.0.0.1", True), ("127.1.2.3", True), ("::1", True), ("panel.localhost", True),
    ("192.168.1.7", False), ("localhost.example.com", False), ("", False)])  # fmt: skip
def test_names_of_this_machine(host, own):
    assert web_gate.is_loopback(host) is own


@pytest.mark.parametrize("host", ["127.0.0.1:8080", "localhost:8080", "[::1]:8080", "localhost:9999"])
def test_on_loopback_whoever_asks_for_a_loopback_name_is_let_in(host):
    (answer,) = asked(None, ("/", {"host": host}))
    assert answer.status_code == 200


def test_a_name_of_the_web_that_points_here_is_refused():
    (answer,) = asked(None, ("/", {"host": "evil.example:8080"}))
    assert (answer.status_code, "expected a loopback name" in answer.text) == (403, True)


@pytest.mark.parametrize("origin", ["http://evil.example", "http://127.0.0.1:9999", "https://localhost", "null"])
def test_requests_of_other_pages_are_refused(origin):
    own, other = asked(None, ("/", {"origin": "http://127.0.0.1:8080"}), ("/", {"origin": origin}))
    assert (own.status_code, other.status_code) == (200, 403)


def test_a_picture_in_another_page_is_refused_and_a_link_there_is_not():
    picture = {"sec-fetch-site": "cross-site", "sec-fetch-mode": "no-cors"}
    link = {"sec-fetch-site": "cross-site", "sec-fetch-mode": "navigate"}
    refused, followed = asked(None, ("/", picture), ("/", link))
    assert (refused.status_code, followed.status_code) == (403, 200)


def test_a_page_may_not_be_framed_and_tells_nobody_its_address():
    (answer,) = asked(None, ("/", {}))
    assert answer.headers["x-frame-options"] == "DENY" and answer.headers["referrer-policy"] == "no-referrer"


def test_a_browser_is_known_again():
    first, second = asked(None, ("/", {}), ("/", {}))
    assert first.text == second.text == first.cookies[PERSON] and "HttpOnly" in first.headers["set-cookie"]
    assert "set-cookie" not in second.headers


def test_the_token_is_shown_once_and_then_known_by_a_cookie():
    elsewhere = "http://lab.example:8080"
    nothing, wrong, shown, known = asked(
        "abc", ("/", {}), ("/?token=abd", {}), ("/?token=abc&x=1", {}), ("/", {}), base=elsewhere
    )
    assert (nothing.status_code, wrong.status_code) == (403, 403)
    assert (shown.status_code, shown.headers["location"]) == (303, "/?x=1")
    assert known.status_code == 200


def test_a_cookie_that_is_none_is_no_token():
    (answer,) = asked("abc", ("/", {"cookie": b"axistwin-token-8080=\xff; broken"}))
    assert answer.status_code == 403


def test_a_web_socket_of_another_page_is_refused():
    told = []

    async def connect(headers):
        async def receive():
            return {"type": "websocket.connect"}

        async def send(message):
            told.append(message)

        scope = {"type": "websocket", "path": "/", "query_string": b"", "headers": headers}
        await Gate(accepting, None)(scope, receive, send)

    async def accepting(scope, receive, send):
        await send({"type": "websocket.accept"})

    own = [(b"host", b"localhost:8080"), (b"origin", b"http://localhost:8080")]
    asyncio.run(connect(own))
    asyncio.run(connect([own[0], (b"origin", b"http://evil.example")]))
    assert [message["type"] for message in told] == ["websocket.accept", "websocket.close"]
