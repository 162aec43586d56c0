"""Several clients at one controller: requests one after the other, and every client receives every answer."""

import asyncio
import socket

import pytest

from axistwin.cli import main
from axistwin.drivers import connect
from axistwin.errors import UsageError
from axistwin.links import FULL, Gate, Hub, Seat, sharing

from .serving import Served, ask, dial, receive


@pytest.fixture
def served():
    with Served(share=True) as served:
        yield served


def test_every_client_receives_every_answer(served):
    url = served.open(served.add())
    with dial(url) as first, dial(url) as second:
        served.until(lambda: (served.server.client("if1") or "").count(":") == 2)
        assert ask(first) == b"C\r"
        assert ask(second) == receive(first, 2) == b"C\r" == receive(second, 2)
    served.until(lambda: not served.server.client("if1"))
    with dial(url) as third:
        assert ask(third) == b"C\r"


def test_a_second_program_sees_the_conversation_of_a_driver(served):
    if1 = served.add()
    url = served.open(if1)
    with dial(url) as other, connect(str(url), "if1") as driver:
        served.until(lambda: (served.server.client("if1") or "").count(":") == 2)
        driver.axes["X"].move_to(120)
        assert driver.axes["X"].wait(10).position == 120
        seen = receive(other, 20)
        assert seen.count(b"\r") > 2
        other.shutdown(socket.SHUT_RDWR)
        driver.axes["X"].move_to(0)
        assert driver.axes["X"].wait(10).position == 0


def test_one_client_too_many_is_refused(served, monkeypatch):
    monkeypatch.setattr(sharing, "MOST_SEATS", 1)
    url = served.open(served.add())
    with dial(url) as first:
        assert ask(first) == b"C\r"
        with dial(url) as second:
            assert second.recv(1) == b""
        assert ask(first) == b"C\r"


def test_only_tcp_ports_can_be_shared(served):
    board = served.add_board()
    for url in ("bus://127.0.0.1:0", "rfc2217://127.0.0.1:0"):
        with pytest.raises(UsageError, match=r"several clients cannot share the port .+: expected a raw TCP port"):
            served.open(board if url.startswith("bus") else served.add(), url)


def test_the_command_line_refuses_to_share_a_bus(capsys):
    with pytest.raises(SystemExit) as ended:
        main(["serve", "1811", "--share"])
    assert ended.value.code == 2
    assert "several clients cannot share the port" in capsys.readouterr().err


class Serial:
    pending = 0


class Plug:
    """A plug that records what is sent."""

    name, chunk, full, client = "if1", 64, False, None
    refuses_because = property(lambda self: self.gate.reason)

    def __init__(self):
        self.gate, self.sent, self.serial = Gate(), [], Serial()

    def connect(self, client):
        self.client = client
        return True

    def disconnect(self, client):
        self.client = None

    def send(self, data):
        self.sent.append(data)


class Client:
    def __init__(self, name):
        self.name, self.got, self.reads = name, b"", True

    def pause(self):
        self.reads = False

    def resume(self):
        self.reads = True

    def deliver(self, data, errors):
        self.got += data


@pytest.fixture
def hub(monkeypatch):
    """Return a hub with three seats, whose time the test controls: `hub._silent()` stands for 50 ms of silence."""
    monkeypatch.setattr(sharing, "SILENCE_S", 1000.0)
    monkeypatch.setattr(sharing, "LONGEST_S", 1000.0)

    def run(session):
        async def whole():
            hub = Hub(Plug())
            seats = [Seat(hub) for _ in range(3)]
            for seat, name in zip(seats, "abc", strict=True):
                assert seat.connect(Client(name))
            session(hub, *seats)
            for seat in seats:
                seat.disconnect(seat.client)
            assert hub.plug.client is None

        asyncio.run(whole())

    return run


def test_requests_wait_for_the_end_of_the_request_before(hub):
    def session(hub, a, b, c):
        a.send(b"(")
        b.send(b"N\rK")
        c.send(b"I\r")
        a.send(b"0$\r")
        a.send(b"E\r")  # other clients wait, so the next request of this client is served last
        assert hub.plug.sent == [b"(", b"0$\r"]
        hub.plug.serial.pending = 3
        hub._silent()
        assert len(hub.plug.sent) == 2
        hub.plug.serial.pending = 0
        for _ in range(3):
            hub.deliver(b"1\r", None)
            hub._silent()
        assert hub.plug.sent[2:] == [b"N\r", b"I\r", b"E\r"]
        assert a.client.got == b.client.got == c.client.got == b"1\r1\r1\r"
        b.send(b"\r")
        hub._silent()
        assert hub.plug.sent[-1] == b"K\r"
        c.send(b"I\r")
        hub._silent()  # silence ends a request without a terminator
        assert hub.plug.sent[-1] == b"I\r"

    hub(session)


def test_a_client_that_is_alone_is_not_delayed_and_one_that_waits_is_not_read(hub):
    def session(hub, a, b, c):
        a.send(b"K\r")
        a.send(b"N\r")
        assert hub.plug.sent == [b"K\r", b"N\r"]
        b.send(b"x" * (FULL + 1))
        assert not b.client.reads and b.full
        hub.resume()
        assert not b.client.reads and a.client.reads
        hub._silent()
        assert b.client.reads and len(hub.plug.sent[-1]) == FULL + 1

    hub(session)


def test_a_client_that_leaves_takes_its_requests_along(hub):
    def session(hub, a, b, c):
        a.send(b"(")
        b.send(b"N\r")
        c.send(b"I\r")
        a.disconnect(a.client)
        b.disconnect(b.client)
        hub._silent()
        assert hub.plug.sent == [b"(", b"I\r"]
        hub.plug.gate.close("paused")
        assert not Seat(hub).connect(Client("d"))

    hub(session)


def test_a_half_line_does_not_swallow_the_request_of_another_client(hub):
    def session(hub, a, b, c):
        a.send(b"X1")
        hub._silent()
        b.send(b"K\r")
        assert hub.plug.sent == [b"K\r"]
        hub._silent()
        a.send(b"0\r")
        assert hub.plug.sent == [b"K\r", b"X10\r"]
        hub._silent()
        a.send(b"#")  # no line: at once
        b.send(b"N\rX")
        hub._silent()
        assert hub.plug.sent[2:] == [b"#", b"N\r"]
        a.disconnect(a.client)
        c.disconnect(c.client)
        hub._silent()
        b.send(b"1")  # the only client
        assert b"".join(hub.plug.sent[4:]) == b"X1"

    hub(session)
