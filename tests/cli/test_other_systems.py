"""Windows and macOS, simulated on Linux: no POSIX modules, no signal handlers, no readers in the event loop."""

import io
import os
import signal
import socket
import subprocess
import sys
import threading
from unittest.mock import patch
from urllib.request import urlopen

import pytest

from .. import command
from ..command import AT_ONCE, PATIENCE_S, ended, listening, refused, run, running, serving

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="shows other systems on Linux")

ELSEWHERE = """
import asyncio, io, logging, select, signal, subprocess, sys, threading
import click, serial
EXTRA

def refuse(*_):
    raise NotImplementedError

for name in ("add_signal_handler", "add_reader", "remove_reader", "add_writer", "remove_writer"):
    setattr(asyncio.SelectorEventLoop, name, refuse)

def no_descriptor(_):
    raise io.UnsupportedOperation("fileno")

serial.Serial.fileno = no_descriptor
for name in ("termios", "fcntl", "pty", "tty", "grp", "pwd", "resource"):
    sys.modules[name] = None
del select.poll
sys.platform = "win32"
"""
MAIN = "from axistwin.cli.program import main; main()"


@pytest.fixture(params=[""])
def elsewhere(request):
    """Run the program in a process without the POSIX modules; the parameter names further missing modules."""
    with patch.object(command, "PROGRAM", (sys.executable, "-c", ELSEWHERE.replace("EXTRA", request.param) + MAIN)):
        yield


@pytest.fixture
def cable():
    import tty

    host, device = os.openpty()
    tty.setraw(host)
    tty.setraw(device)
    yield host, os.ttyname(device)
    os.close(host)
    os.close(device)


def read(descriptor, count):
    data = b""
    while len(data) < count:
        data += os.read(descriptor, count - len(data))
    return data


@pytest.mark.slow
@pytest.mark.parametrize("elsewhere", ["import nicegui, uvicorn"], indirect=True)
def test_ports_on_tcp_and_a_panel_until_ctrl_c(elsewhere):
    pytest.importorskip("nicegui", reason="the extra [panel] is not installed")
    with running("serve", "if1", "--tcp", ":0", "--rfc2217", ":0", "--panel", "0", *AT_ONCE) as program:
        address = program.stdout.readline().split()[-1]
        (_, url), _ = listening(program), listening(program)
        with socket.create_connection((url.host, url.port), timeout=PATIENCE_S) as client:
            client.sendall(b"(")
            assert client.recv(2) == b"U\r"
        with urlopen(address, timeout=PATIENCE_S) as page:
            assert page.status == 200
        assert ended(program, signal.SIGINT)[0] == 130


@pytest.mark.usefixtures("elsewhere")
def test_a_serial_device_until_terminated(cable):
    host, device = cable
    with serving("if1", "--serial", f"{device}?baud=9600", "--speed", "max") as (program, _):
        os.write(host, b"(")
        assert read(host, 2) == b"U\r"
        os.write(host, b"U61\rX100$\rN\r")
        assert read(host, 2) == b"0\r" and ended(program)[0] == 0


def test_a_pty_is_refused_in_one_line(monkeypatch):
    monkeypatch.setattr(sys, "platform", "win32")
    code, message = refused("serve", "if1", "--pty", "x")
    assert code == 2
    assert message.startswith("axistwin: a pty needs Linux: expected a TCP port or a serial device, e.g. rfc2217:")
    assert message.count("\n") == 1


@pytest.mark.usefixtures("elsewhere")
def test_a_recording_of_a_device(tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as device:
        threading.Thread(target=lambda: answer(device), daemon=True).start()
        where = "socket://{}:{}".format(*device.getsockname())
        with serving("--serial", where, "-o", tmp_path / "a.talk", command="record") as (program, [(_, url)]):
            with socket.create_connection((url.host, url.port), timeout=PATIENCE_S) as client:
                client.sendall(b"(")
                assert client.recv(2) == b"U\r"
            assert ended(program, signal.SIGINT)[0] == 130
    assert "< U" in (tmp_path / "a.talk").read_text(encoding="utf-8")


def answer(device):
    connection, _ = device.accept()
    with connection:
        if connection.recv(1) == b"(":
            connection.sendall(b"U\r")
        connection.recv(1)


@pytest.mark.parametrize("elsewhere", ["import filelock, pydantic.main"], indirect=True)
def test_a_terminal(elsewhere):
    with running("term", "if1", "--speed", "max", stdin=subprocess.PIPE) as program:
        out, message = program.communicate("X1000$\n:axes\n", timeout=PATIENCE_S)
    assert (program.returncode, message) == (0, "") and "1000" in out


def test_a_twin_in_a_python_program():
    words = """
import axistwin
with axistwin.serve("if1", speed="manual") as twin:
    host = serial.serial_for_url(twin.ports["if1"], timeout=300)
    twin.advance(1.5)
    host.write(b"(")
    twin.advance(0.1)
    print(host.read(2))
try:
    axistwin.serve("if1", scheme="pty").__enter__()
except axistwin.AxistwinError as error:
    print(error)
"""
    program = (sys.executable, "-c", ELSEWHERE.replace("EXTRA", "") + words)
    with patch.object(command, "PROGRAM", program), running() as process:
        out, message = process.communicate(timeout=PATIENCE_S)
    assert message == ""
    first, second = out.splitlines()
    assert first == "b'U\\r'" and second.startswith("a pty needs Linux")


def test_a_com_port_is_a_port():
    done = run("term", "COM3")
    assert done.code == 2 and done.err.startswith("axistwin: cannot open COM3 (")


@pytest.mark.parametrize(("encoding", "arrow"), [("latin-1", b"?"), ("cp1252", b"?"), ("utf-8", "→".encode())])
def test_every_character_is_written_in_some_way(tmp_path, monkeypatch, encoding, arrow):
    (tmp_path / "a.if1").write_text("X100$\n")
    written = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(written, encoding))
    with pytest.raises(SystemExit, match="0"):
        command.main(["run", "if1", str(tmp_path / "a.if1")])
    assert b"X 0 " + arrow + b" 100" in written.getvalue()
