"""The bus socket: well-behaved and faulty hosts."""

import socket
import struct

import pytest

from axistwin.core.errors import UsageError
from axistwin.core.units import S
from axistwin.links.bus import LONGEST_LINE, MAX_BLOCK

from .serving import HOST_TIMEOUT_S, Served

READY, MESSAGE = 0x10, 0x08


class Host:
    """A client of the bus socket, line by line; `room` is the size of the system's receive buffer, or None."""

    def __init__(self, url, room=None):
        self.socket = socket.socket()
        if room:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, room)
        self.socket.settimeout(HOST_TIMEOUT_S)
        self.socket.connect((url.host, url.port))
        self._lines = self.socket.makefile("rb")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._lines.close()
        self.socket.close()

    def send(self, text):
        self.socket.sendall(text.encode())

    def line(self):
        return self._lines.readline().decode().rstrip("\n")

    def ask(self, request):
        self.send(request + "\n")
        return self.line()

    def wait(self, bit):
        for _ in range(100_000):
            if int(self.ask("r 1"), 16) & bit:
                return
        raise AssertionError("the bit is never set")

    def command(self, text, control="10"):
        self.wait(READY)
        assert self.ask(f"w 0 {text}") == "ok" and self.ask(f"w 1 {control}") == "ok"

    def message(self, control="80"):
        self.wait(MESSAGE)
        data = self.ask("r 0 16")
        assert self.ask(f"w 1 {control}") == "ok"
        return bytes.fromhex(data)


@pytest.fixture
def port(served):
    return served.open(served.add_board(), "bus://:0")


def hold_little(transport):
    transport.get_extra_info("socket").setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4096)


def flood(connection, data):
    """Send data repeatedly until the connection is blocked.  Return the number of bytes sent."""
    sent = 0
    while sent < 10_000_000:
        try:
            sent += connection.send(data)
        except TimeoutError:
            return sent
    raise AssertionError("everything is taken")


def vanish(host):
    """Reset the connection, as when a program is killed."""
    host.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    host.__exit__()


def test_a_move_by_hand(served, port):
    with Host(port) as host:
        host.command("31 00 00 00 00 61 a8 00 03 d0 90")
        host.command("33 00 00 61 a8")
        served.until(lambda: served.bench["1811"].axes["motor"].position == 25_000)
        host.command("83")
        assert host.message() == bytes.fromhex("83 00 00 00 00 61 a8").ljust(16, b"\0")


def test_one_byte_at_a_time_is_the_same(served, port):
    with Host(port) as host:
        host.wait(READY)
        for byte in ("40", "7"):
            assert host.ask(f"w 0 {byte}") == "ok"
        assert host.ask("w 1 10") == "ok"
        host.wait(READY)
        host.command("01 42")
        host.wait(MESSAGE)
        assert [host.ask("r 0") for _ in range(3)] == ["01", "42", "00"]


def test_reading_takes_no_virtual_time(served, port):
    with Host(port) as host:
        host.wait(READY)
        before_ns = served.do(lambda: served.bench.now)
        for request in ("r 1", "r 0", "r 0 256", "i", "s 0"):
            assert not host.ask(request).startswith("error")
        assert served.do(lambda: served.bench.now) == before_ns


def test_time_follows_the_wall_clock():
    with Served(speed=1000) as served:
        board = served.add_board()
        with Host(served.open(board, "bus://:0")) as host:
            host.wait(READY)
            assert served.do(lambda: served.bench.now) >= 1 * S


def test_the_interrupt_line_is_told_as_it_changes(served, port):
    with Host(port) as host:
        host.wait(READY)
        assert host.ask("i") == "0" and host.ask("s 1") == "ok"
        host.command("01 07", control="50")
        assert host.line() == "! 1" and host.ask("i") == "1"
        assert host.message(control="c0")[:2] == b"\x01\x07" and host.line() == "! 0"
        assert host.ask("s 0") == "ok"
        host.command("01 08", control="50")
        host.wait(MESSAGE)
        assert host.ask("i") == "1"  # no change is reported


def test_an_answer_comes_before_the_change_it_causes(served, port):
    with Host(port) as host:
        host.wait(READY)
        host.command("01 07")
        host.wait(MESSAGE)
        assert host.ask("s 1") == "ok" and [host.ask("w 1 40"), host.line()] == ["ok", "! 1"]


def test_init_is_the_reset_line(served, port):
    with Host(port) as host:
        host.wait(READY)
        assert host.ask("init") == "ok"
        host.wait(READY)


def test_a_board_without_power_drives_nothing(served, port):
    served.act(lambda: served.bench["1811"].power(False))
    with Host(port) as host:
        assert [host.ask("r 0"), host.ask("r 1"), host.ask("w 1 20")] == ["ff", "ff", "ok"]


@pytest.mark.parametrize(("request_", "answer"), [
    ("x", "error: unknown request 'x': expected r, w, i, s or init, e.g. r 0"),
    ("r", "error: unknown request 'r'"),
    ("r 2", "error: invalid offset '2': expected a number from 0 to 1"),
    ("r -1", "error: invalid offset '-1'"),
    ("r ²", "error: invalid offset"),
    ("r 0 0", "error: invalid number of bytes '0': expected a number from 1 to 256"),
    ("r 0 257", "error: invalid number of bytes '257': expected a number from 1 to 256"),
    ("w 0", "error: unknown request"),
    ("w 0 100", "error: invalid byte '100': expected two hex digits"),
    ("w 0 33 xx", "error: invalid byte 'xx'"),
    ("w 0 " + "00 " * (MAX_BLOCK + 1), "error: cannot write 257 bytes in one request: expected at most 256"),
    ("s 2", "error: unknown request"),
    ("init now", "error: unknown request"),
    ("x" * (LONGEST_LINE + 1), "error: the bus request is too long: expected at most 1024 characters, e.g. `r 0 16`"),
    (
        "x" * 10 * LONGEST_LINE,
        "error: the bus request is too long: expected at most 1024 characters, e.g. `r 0 16`",
    )])  # fmt: skip
def test_what_is_wrong_is_answered_by_one_line(port, request_, answer):
    with Host(port) as host:
        assert host.ask(request_).startswith(answer) and host.ask("i") == "0"


def test_nothing_is_written_if_one_of_the_bytes_is_wrong(port):
    with Host(port) as host:
        host.wait(READY)
        assert host.ask("w 0 01 zz").startswith("error")
        host.command("01 05")
        assert host.message()[:2] == b"\x01\x05"


def test_blanks_and_the_line_ends_of_other_systems(port):
    with Host(port) as host:
        host.send("\r\n\n  i  \r\n")
        assert host.line() == "0"


@pytest.mark.parametrize("end", ["\n", "\r\n", "xxx\n", "x" * LONGEST_LINE + "\n"])
def test_a_line_that_is_too_long_spoils_no_other_however_it_is_cut_up(served, port, end):
    with Host(port) as host:
        host.send("x" * (LONGEST_LINE + 1))
        while (master := served.server._slots["1811"].client) is None or not served.do(lambda: master._too_long):
            pass
        host.send(end)
        assert host.line() == "error: the bus request is too long: expected at most 1024 characters, e.g. `r 0 16`"
        assert host.ask("i") == "0"


def test_rubbish(port):
    with Host(port) as host:
        host.socket.sendall(bytes(range(256)) * 64 + b"\n")
        host.send("i\n")
        while (line := host.line()) != "0":
            assert line.startswith("error: ")


def test_many_requests_at_once_are_answered_in_order(port):
    with Host(port) as host:
        host.wait(READY)
        host.send("r 1\ni\nx\n" * 1000)
        for _ in range(1000):
            assert [host.line(), host.line(), host.line()[:5]] == ["50", "0", "error"]


@pytest.mark.slow
def test_a_host_that_does_not_read_is_not_read_from(served, port):
    """The server stops reading from a host that does not read: pending answers are bounded, and none is lost."""
    with Host(port, room=4096) as host:
        host.wait(READY)
        host.socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4096)
        host.socket.settimeout(0.2)
        client, sent = served.server._slots["1811"].client, 0
        served.do(lambda: hold_little(client._transport))
        while not client.stalled:
            sent += flood(host.socket, b"r 0 256\n" * 8)
        assert served.do(lambda: client._transport.get_write_buffer_size()) < 200_000
        host.socket.settimeout(HOST_TIMEOUT_S)
        answers = [host.line() for _ in range(sent // 8)]
        assert {len(answer) for answer in answers} == {3 * 256 - 1}


def test_a_second_host_is_refused_until_the_first_has_gone(served, port):
    with Host(port) as first:
        assert first.ask("i") == "0"
        with Host(port) as second:
            assert second.socket.recv(10) == b""
        assert first.ask("i") == "0"
    with Host(port) as third:
        assert third.ask("i") == "0"


def test_hosts_that_vanish(served, port):
    for text in ("", "r 1", "s 1\nw 0 33 00", "w 0 33\nw 1 10\n" * 50):
        host = Host(port)
        host.send(text)
        vanish(host)
    with Host(port) as host:
        host.wait(READY)
    assert not served.bench["1811"].bus.interrupt_line._changes


def test_reset_on_connect():
    """The first host leaves a message, which the second host does not receive."""
    with Served(reset=True) as served:
        port = served.open(served.add_board(), "bus://:0")
        for _ in range(2):
            with Host(port) as host:
                host.wait(READY)
                assert host.ask("r 1") == "50"
                host.command("01 01")
                host.wait(MESSAGE)


def test_ports_and_controllers_that_do_not_go_together(served, port):
    with pytest.raises(UsageError, match="has no bus port"):
        served.open(served.add(), "bus://:0")
    with pytest.raises(UsageError, match="has no serial port"):
        served.open(served.bench["1811"], "tcp://:0")
