"""`axistwin serve --panel` as a process: its URL, its end, and rejected options."""

import asyncio
import http.client
import re
import signal
import socket
import subprocess
import sys
from contextlib import contextmanager, suppress
from urllib.parse import urlsplit

import pytest
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from axistwin import Bench
from axistwin.scenes.sessions.session import Session
from axistwin.ui.panel import web
from axistwin.ui.panel.address import Address, listening_socket
from axistwin.ui.panel.web import Panel

from ..command import PATIENCE_S, ended, refused, running
from .showing import stage

WITHOUT = (
    "import sys; sys.modules['nicegui'] = None\n"
    "from axistwin.cli.program import main; main(['serve', 'if1', '--panel', '0'])"
)
PANEL = re.compile(r"panel on (http://\S+)\n")


@contextmanager
def started(*words):
    with running("serve", *words) as program:
        line = program.stdout.readline()
        assert PANEL.fullmatch(line), line + program.stderr.read()
        yield program, PANEL.fullmatch(line)[1]


def get(address, **headers):
    place = urlsplit(address)
    connection = http.client.HTTPConnection(place.hostname, place.port, timeout=PATIENCE_S)
    try:
        connection.request("GET", f"{place.path}?{place.query}", headers=headers)
        answer = connection.getresponse()
        return answer.status, answer.headers, answer.read().decode()
    finally:
        connection.close()


@contextmanager
def page_socket(address, **headers):
    """Fetch the page, and open its connection: a WebSocket with the Socket.IO protocol."""
    client = re.search(r"client_id\W+([\w-]+)", get(address, **headers)[2])[1]
    query = f"client_id={client}&document_id=1&tab_id=1&next_message_id=0&implicit_handshake=true"
    url = f"ws://{urlsplit(address).netloc}/_nicegui_ws/socket.io/?EIO=4&transport=websocket&{query}"
    with connect(url, additional_headers=headers, max_queue=None) as page:
        page.recv(PATIENCE_S)
        page.send("40")
        yield page


def test_a_port_that_is_taken():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        code, words = refused("serve", "if1", "--panel", port)
    assert code == 2
    assert words.count("\n") == 1 and f"cannot show a panel on 127.0.0.1:{port}: address already in use" in words


def test_frames_leave_without_delay():
    with listening_socket(Address("127.0.0.1", 0, None)) as sock, socket.create_connection(sock.getsockname()):
        connection, _ = sock.accept()
        with connection:
            assert connection.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)


BEGIN, NONE = b"GET /none HTTP/1.1\r\nHost: localhost\r\n", "HTTP/1.1 404"


@pytest.mark.parametrize(("idle_s", "requests", "answers"), [
    (0.1, [b"", BEGIN + b"\r\n", b"GET / HT", b""], ["", NONE, "", ""]),
    (1000, [BEGIN + b"X: " + b"x" * web.MOST_HEAD, BEGIN + b"\r\n"], ["", NONE])
], ids=["idle, half and too many", "an endless head"])  # fmt: skip
def test_a_bounded_number_of_connections_for_a_bounded_time(monkeypatch, idle_s, requests, answers):
    stage.close()  # a process can have only one NiceGUI server at a time

    async def answered(reader):
        with suppress(ConnectionError):
            return (await asyncio.wait_for(reader.read(12), PATIENCE_S)).decode()

    async def visit():
        panel = Panel("", Session(Bench), Address("127.0.0.1", 0, None))
        port = urlsplit(await panel.open()).port
        visitors = []
        for request in requests:
            visitors.append(await asyncio.open_connection("127.0.0.1", port))
            visitors[-1][1].write(request)
        found = [await answered(reader) for reader, _ in visitors]
        for _, writer in visitors:
            writer.close()
        await panel.close()
        return found

    monkeypatch.setattr(web, "MOST_CONNECTIONS", 3)
    monkeypatch.setattr(web, "IDLE_S", idle_s)
    assert asyncio.run(visit()) == answers


@pytest.mark.parametrize("place", ["here", "127.0.0.1:", "127.0.0.1:99999", "8080/"])
def test_a_place_that_is_none(place):
    code, words = refused("serve", "if1", "--panel", place)
    assert code == 2
    assert f"invalid panel address {place!r}: expected PORT or HOST:PORT, e.g. 8080" in words


def test_without_its_extra_one_line_says_what_to_install():
    result = subprocess.run([sys.executable, "-c", WITHOUT], capture_output=True, text=True, timeout=PATIENCE_S)
    assert result.returncode == 2 and result.stderr.count("\n") == 1
    assert 'in a clone pip install ".[panel]"' in result.stderr


def test_a_token_is_for_a_panel_and_has_letters_and_digits():
    code, words = refused("serve", "if1", "--panel-token", "abc")
    assert (code, "--panel-token needs a panel" in words) == (2, True)
    code, words = refused("serve", "if1", "--to", "4.2")
    assert (code, "--to (run to a given time, then pause) needs the panel: add --panel" in words) == (2, True)
    code, words = refused("serve", "if1", "--panel", 0, "--panel-token", "a&b")
    assert (code, "letters and digits only" in words) == (2, True)


@pytest.mark.slow
def test_a_scene_without_ports_is_shown_with_a_token_and_ends_without_a_word_also_with_a_page(tmp_path):
    """At full speed: in real time, a loaded computer would cause a message about delays."""
    scene = tmp_path / "scene.toml"
    scene.write_text('title = "Two rows"\n[[controller]]\nmodel = "if1"\nname = "a"\nhost = "a.if1"\n')
    (tmp_path / "a.if1").write_text("X10$\n")
    code, words = refused("serve", scene)
    assert (code, "has a port for an external host" in words) == (2, True)
    with started(scene, "--panel", "0.0.0.0:0", "--speed", "max") as (program, address):
        place = urlsplit(address)
        here = f"http://127.0.0.1:{place.port}/"
        assert len(place.query.removeprefix("token=")) > 20 and get(here)[0] == 403
        status, headers, _ = get(f"{here}?{place.query}")
        assert (status, headers["location"]) == (303, "/")
        cookie = headers["set-cookie"].partition(";")[0]
        status, _, text = get(here, Cookie=cookie)
        assert (status, "<title>VIRTUAL: Two rows</title>" in text) == (200, True)
        with page_socket(here, Cookie=cookie) as page:
            while '"update"' not in str(page.recv(PATIENCE_S)):
                pass  # until the page is built
            assert ended(program, signal.SIGINT) == (130, "")


MESSAGES = (
    '42["connect","x"]', '42["event"]', '42["handshake",{}]', '42["ack",[]]', '42["event",' + "[" * 3000, "45", b"\0",
)  # fmt: skip


@pytest.mark.slow
def test_state_speed_and_ports_are_as_without_a_panel_also_after_bad_messages_and_with_a_token_of_ones_own(tmp_path):
    options = ("--speed", "max", "--line", "instant", "--state", tmp_path, "--panel-token", "letmein")
    for first in (True, False):
        with started("if2", "--panel", 0, *options) as (program, address):
            assert urlsplit(address).query == "token=letmein"
            port = int(program.stdout.readline().rpartition(":")[2])
            with socket.create_connection(("127.0.0.1", port), timeout=PATIENCE_S) as host:
                answers = []
                for text in (b"(", b"U61\rE\r", b"[\rE\r"):
                    host.sendall(text)
                    answers.append(host.recv(16))
            if first:
                here = address.partition("?")[0]
                assert get(here)[0] == 403
                cookie = get(address)[1]["set-cookie"].partition(";")[0]
                for message in MESSAGES:
                    with page_socket(here, Cookie=cookie) as page, suppress(ConnectionClosed):
                        page.send(message)
                    assert get(here, Cookie=cookie)[0] == 200, message
            assert answers == [b"U\r", b"C\r" if first else b"[\r", b"[\r"]
            assert ended(program)[0] == 0
