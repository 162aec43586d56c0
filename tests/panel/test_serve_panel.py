"""`axistwin serve --panel` as a process: its URL, its end, and rejected options."""

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

from axistwin.panel import Address, listening_socket

from ..command import PATIENCE_S, ended, refused, running

WITHOUT = (
    "import sys; sys.modules['nicegui'] = None\nfrom axistwin.cli import main; main(['serve', 'if1', '--panel', '0'])"
)
PANEL = re.compile(r"panel on (http://\S+)\n")


@contextmanager
def started(*words):
    """Start `axistwin serve`; yield the process and the URL of its panel."""
    with running("serve", *words) as program:
        line = program.stdout.readline()
        assert PANEL.fullmatch(line), line + program.stderr.read()
        yield program, PANEL.fullmatch(line)[1]


def get(address, **headers):
    """Request a URL; return status, headers and text of the answer."""
    place = urlsplit(address)
    connection = http.client.HTTPConnection(place.hostname, place.port, timeout=PATIENCE_S)
    try:
        connection.request("GET", f"{place.path}?{place.query}", headers=headers)
        answer = connection.getresponse()
        return answer.status, answer.headers, answer.read().decode()
    finally:
        connection.close()


@contextmanager
def browser(address):
    """Fetch the page, and keep the connection open."""
    place = urlsplit(address)
    with socket.create_connection((place.hostname, place.port), timeout=PATIENCE_S) as connection:
        connection.sendall(f"GET / HTTP/1.1\r\nHost: {place.netloc}\r\n\r\n".encode())
        assert connection.recv(12) == b"HTTP/1.1 200"
        yield


def test_interrupted_it_ends_at_once_and_without_a_word_also_with_a_browser():
    """At full speed: in real time, a loaded computer would cause a message about delays."""
    with started("if1", "--panel", 0, "--speed", "max") as (program, address), browser(address):
        assert ended(program, signal.SIGINT) == (130, "")


def test_a_scene_without_ports_may_be_looked_at_but_not_served_otherwise(tmp_path):
    scene = tmp_path / "scene.toml"
    scene.write_text('[[controller]]\nmodel = "if1"\nname = "a"\nhost = "a.if1"\n')
    (tmp_path / "a.if1").write_text("X10$\n")
    code, words = refused("serve", scene)
    assert (code, "add ports to a controller" in words) == (2, True)
    with started(scene, "--panel", 0, "--speed", "max") as (program, address), browser(address):
        assert ended(program, signal.SIGTERM) == (0, "")


def test_a_port_that_is_taken():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        code, words = refused("serve", "if1", "--panel", port)
    assert code == 2
    assert words.count("\n") == 1
    assert f"cannot show a panel on 127.0.0.1:{port}: address already in use" in words


def test_frames_leave_without_delay():
    with listening_socket(Address("127.0.0.1", 0, None)) as sock, socket.create_connection(sock.getsockname()):
        connection, _ = sock.accept()
        with connection:
            assert connection.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)


@pytest.mark.parametrize("place", ["here", "127.0.0.1:", "127.0.0.1:99999", "8080/"])
def test_a_place_that_is_none(place):
    code, words = refused("serve", "if1", "--panel", place)
    assert code == 2
    assert f"invalid panel address {place!r}: expected PORT or HOST:PORT, e.g. 8080" in words


def test_without_its_extra_one_line_says_what_to_install():
    result = subprocess.run([sys.executable, "-c", WITHOUT], capture_output=True, text=True, timeout=PATIENCE_S)
    assert result.returncode == 2
    assert result.stderr.count("\n") == 1
    assert 'in a clone pip install ".[panel]"' in result.stderr


def test_a_token_is_for_a_panel_and_has_letters_and_digits():
    code, words = refused("serve", "if1", "--panel-token", "abc")
    assert (code, "--panel-token needs a panel" in words) == (2, True)
    code, words = refused("serve", "if1", "--to", "4.2")
    assert (code, "--to needs a panel" in words) == (2, True)
    code, words = refused("serve", "if1", "--panel", 0, "--panel-token", "a&b")
    assert (code, "letters and digits only" in words) == (2, True)


def test_beyond_this_machine_a_token_is_made_up_and_wanted_and_the_page_of_a_scene_is_called_virtual():
    with started("examples/winder/scene.toml", "--panel", "0.0.0.0:0") as (program, address):
        place = urlsplit(address)
        here = f"http://127.0.0.1:{place.port}/"
        assert len(place.query.removeprefix("token=")) > 20
        assert get(here)[0] == 403
        status, headers, _ = get(f"{here}?{place.query}")
        assert (status, headers["location"]) == (303, "/")
        status, _, text = get(here, Cookie=headers["set-cookie"].partition(";")[0])
        assert status == 200
        assert "<title>VIRTUAL: Winder</title>" in text
        assert program.poll() is None


def test_state_speed_and_ports_are_as_without_a_panel_also_with_a_token_of_ones_own_on_loopback(tmp_path):
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
                assert get(here, Cookie=get(address)[1]["set-cookie"].partition(";")[0])[0] == 200
            assert answers == [b"U\r", b"C\r" if first else b"[\r", b"[\r"]
            assert ended(program)[0] == 0


@contextmanager
def page_socket(address):
    """Open the connection of a page: a WebSocket with the Socket.IO protocol."""
    client = re.search(r"client_id\W+([\w-]+)", get(address)[2])[1]
    query = f"client_id={client}&document_id=1&tab_id=1&next_message_id=0&implicit_handshake=true"
    with connect(f"ws://{urlsplit(address).netloc}/_nicegui_ws/socket.io/?EIO=4&transport=websocket&{query}") as page:
        page.recv(PATIENCE_S)
        page.send("40")
        yield page


@pytest.mark.parametrize(
    "message",
    ['42["connect","x"]', '42["event"]', '42["handshake",{}]', '42["ack",[]]', '42["event",' + "[" * 3000, "45", b"\0"],
    ids=lambda message: repr(message[:20]),
)
def test_a_bad_message_to_the_panel_ends_nothing(serving, message):
    program, address = serving
    with page_socket(address) as page, suppress(ConnectionClosed):
        page.send(message)
    assert get(address)[0] == 200
    assert program.poll() is None


@pytest.fixture(scope="module")
def serving():
    with started("if1", "--panel", 0) as served:
        yield served
