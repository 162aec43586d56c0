"""`axistwin shadow` as a program: a scripted machine, its host, and the twin in a process of its own."""

import json
import os
import select
import signal
import socket
import sys
import threading
import urllib.request
from contextlib import contextmanager

import pytest
import serial

from ..command import refused, running, serving
from ..links.serving import ask, dial

PATIENT = ("--tolerance", "1000000")
"""No time is a finding: these tests run on loaded machines."""


@contextmanager
def machine(answers):
    """A controller at a TCP port, which answers each line by this table, in turn; yield its URL."""
    with socket.create_server(("127.0.0.1", 0)) as server:

        def serve():
            connection, _ = server.accept()
            with connection:
                line = b""
                while byte := connection.recv(1):
                    line += byte
                    line = line.lstrip(b"\n")
                    if line in answers:
                        connection.sendall(answers[line].pop(0))
                    line = b"" if byte in (b"\r", b"(") else line

        thread = threading.Thread(target=serve)
        thread.start()
        yield f"tcp://127.0.0.1:{server.getsockname()[1]}"
    thread.join(60)


def healthy(*last):
    return {b"(": [b"U\r"], b"E\r": [b"C\r", b"C\r", *last], b"F\r": [b"0\r"]}


def talked(url, *requests):
    with dial(url) as host:
        assert ask(host, b"(", b"U\r") == b"U\r"
        host.sendall(b"U61\r")
        return [ask(host, request, b"C\r") for request in requests]


def finished(program):
    program.send_signal(signal.SIGTERM)
    out, _ = program.communicate()
    return program.returncode, out


QUICK = ("--option", "self_test_s=0.05", "--option", "recalculation_s=0.01")


def test_a_machine_that_agrees(tmp_path):
    log = tmp_path / "table.jsonl"
    with machine(healthy()) as real:
        arguments = (real, "--model", "if1", *QUICK, *PATIENT, "--log", log)
        with serving(*arguments, command="shadow") as (program, [(_, url)]):
            assert talked(url, b"E\r", b"E\r") == [b"C\r", b"C\r"]
            code, out = finished(program)
    assert code == 0 and "2 answers, no findings" in out
    assert json.loads(log.read_text().splitlines()[-1])["state"] == "agrees"


def test_a_machine_that_answers_something_else():
    with (
        machine(healthy(b"B\r", b"C\r")) as real,
        serving(real, "--model", "if1", *QUICK, *PATIENT, command="shadow") as (program, [(_, url)]),
    ):
        assert talked(url, b"E\r", b"E\r", b"E\r", b"E\r")[2:] == [b"B\r", b"C\r"]
        code, out = finished(program)
    assert code == 1 and "answer: E answers B\\r, the twin C\\r (Busy status)" in out


class Once(list):
    """An answer, and an event when it has been given."""

    def __init__(self, answer):
        super().__init__([answer])
        self.given = threading.Event()

    def pop(self, index):
        self.given.set()
        return super().pop(index)


@pytest.mark.slow
def test_the_controller_is_asked_and_its_host_hears_only_its_own_answers():
    answers = {b"I\r": [b"192\r"] * 3, b"N\r": Once(b"0\r"), b"E\r": [b"C\r", b"C\r"]}
    with (
        machine(answers) as real,
        serving(real, "--model", "if1", *QUICK, *PATIENT, "--ask", command="shadow") as (program, [(_, url)]),
        dial(url) as host,
    ):
        assert answers[b"N\r"].given.wait(60)
        assert ask(host, b"E\r", b"C\r") == b"C\r"
        code, out = finished(program)
    assert code == 0 and "3 answers, no findings" in out


@pytest.mark.slow
def test_a_panel_is_served_while_the_relay_goes_on():
    pytest.importorskip("nicegui")
    with (
        machine(healthy()) as real,
        serving(real, "--model", "if1", *QUICK, *PATIENT, "--panel", "0", command="shadow") as (program, [(_, url)]),
    ):
        address = program.stdout.readline().removeprefix("panel on ").strip()
        with urllib.request.urlopen(address, timeout=60) as page:
            assert "SHADOW: if1" in page.read().decode()
        assert talked(url, b"E\r") == [b"C\r"]
        code, out = finished(program)
    assert code == 0 and "1 answers, no findings" in out


def test_the_port_of_the_panel_is_in_use():
    pytest.importorskip("nicegui")
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        assert "cannot show a panel" in refused("shadow", "/dev/null", "--model", "if1", "--panel", port)[1]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((), "expected either REAL or --listen"),
        (("/dev/null",), "expected either --model or --scene"),
        (("/dev/null", "--model", "if1", "--scene", "x.toml"), "expected either --model or --scene"),
        (("/dev/null", "--model", "if9"), "no model 'if9'"),
        (("/dev/null", "--model", "1811"), "expected bus://HOST:PORT"),
        (("bus://127.0.0.1:1", "--model", "if1"), "expected a serial port"),
        (("/dev/null", "--model", "if1", "--option", "nonsense=1"), "has no option 'nonsense'"),
        (("/dev/null", "--model", "if1", "--log", "no/where.jsonl"), "there is no directory no"),
        (("socket://127.0.0.1:1", "--model", "if1"), "cannot open socket://127.0.0.1:1"),
        (("tcp://127.0.0.1:99999", "--model", "if1"), "(no port number): expected a port, e.g. socket"),
        (("bus://127.0.0.1:1", "--model", "1811"), "cannot open bus://127.0.0.1:1"),
        (("bus://127.0.0.1:1", "--model", "1811", "--port", "tcp://127.0.0.1:0"), "expected e.g. bus://127.0.0.1:1812"),
        (("--listen", "/dev/none1", "/dev/none2", "--model", "if1", "--ask"), "--listen only receives"),
        (("--listen", "/dev/none1", "/dev/none2", "--model", "if1"), "cannot open /dev/none1"),
    ],
)  # fmt: skip
def test_wrong_use(arguments, words):
    code, message = refused("shadow", *arguments)
    assert code == 2 and words in message


@pytest.mark.filterwarnings("ignore:set.* is deprecated:DeprecationWarning")  # pyserial's reader thread
@pytest.mark.slow
def test_a_host_at_rfc2217_hears_the_machine_byte_for_byte():
    with (
        machine(healthy()) as real,
        serving(real, "--model", "if1", *QUICK, *PATIENT, "--port", "rfc2217://127.0.0.1:0", command="shadow") as (
            program,
            [(_, url)],
        ),
    ):
        with serial.serial_for_url(str(url), timeout=60) as host:
            host.write(b"(")
            assert host.read(2) == b"U\r"
            host.write(b"U61\rE\r")
            assert host.read(2) == b"C\r"
        assert finished(program)[0] == 0


@pytest.mark.skipif(sys.platform != "linux", reason="pseudo terminals as serial devices")
def test_listening_sends_nothing():
    with pseudo_terminal() as (host_side, host_name), pseudo_terminal() as (controller_side, controller_name):
        with running("shadow", "--listen", host_name, controller_name, "--model", "if1", *QUICK) as program:
            assert [program.stdout.readline() for _ in range(2)] == [
                f"listening at {host_name}\n", f"listening at {controller_name}\n",
            ]  # fmt: skip
            os.write(host_side, b"E\r")
            os.write(controller_side, b"C\r")
            code, out = finished(program)
        assert code == 0 and "no findings" in out
        for side in (host_side, controller_side):
            assert select.select([side], [], [], 0) == ([], [], [])


@contextmanager
def pseudo_terminal():
    """Yield the end of a line that a test writes to, and the name of the serial device at the other end."""
    import tty

    near, far = os.openpty()
    tty.setraw(far)
    try:
        yield near, os.ttyname(far)
    finally:
        os.close(near)
        os.close(far)
