"""Several clients at one controller: requests one after the other, and every client receives every answer."""

import asyncio
import socket

import pytest

from axistwin import Bench
from axistwin.cli.program import main
from axistwin.core.errors import UsageError
from axistwin.drivers import connect
from axistwin.links import sharing
from axistwin.links.plug import FULL
from axistwin.links.sharing import Hub, Seat
from axistwin.links.single_client import Gate
from axistwin.scenes.diagnostics.refused_lines import RefusedLines

from .serving import Served, ask, dial, initialise, receive


@pytest.fixture
def served():
    with Served(share=True) as served:
        yield served


@pytest.mark.slow
def test_every_client_receives_every_answer(served):
    url = served.open(served.add())
    with dial(url) as first, dial(url) as second:
        served.until(lambda: (served.server.client("if1") or "").count(":") == 2)
        assert ask(first) == b"C\r" and ask(second) == receive(first, 2) == b"C\r" == receive(second, 2)
    served.until(lambda: not served.server.client("if1"))
    with dial(url) as third:
        assert ask(third) == b"C\r"


def test_a_second_program_sees_the_conversation_of_a_driver(served):
    url = served.open(served.add())
    with dial(url) as other, connect(str(url), "if1") as driver:
        served.until(lambda: (served.server.client("if1") or "").count(":") == 2)
        driver.axes["X"].move_to(120)
        assert driver.axes["X"].wait(10).position == 120
        assert receive(other, 20).count(b"\r") > 2
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


def test_a_refused_line_of_a_shared_port_is_told_whole(served):
    url, told = served.open(served.add()), []
    served.do(lambda: RefusedLines(told.append).watch(served.bench))
    with dial(url) as first, dial(url) as second:
        served.until(lambda: (served.server.client("if1") or "").count(":") == 2)
        first.sendall(b"x")
        assert ask(second) == b"C\r" == receive(first, 2)
        assert ask(first, b"1\rF\r") == b"8\r"  # data fault
    assert [text.partition(": unknown")[0] for text in told] == ["if1: refused x1"]


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
        self.name, self.got, self.reads, self.connected = name, b"", True, True

    def drop(self):
        self.connected = False

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

    def run(session, plug=None, **options):
        async def whole():
            hub = Hub(plug or Plug(), **options)
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
        b.send(b"K\r" * FULL)
        assert not b.client.reads and b.full
        hub.resume()
        assert not b.client.reads and a.client.reads
        hub._silent()
        assert b.client.reads and len(hub.plug.sent[-1]) == 2 * FULL

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


def test_a_half_line_waits_in_the_seat_of_its_client(hub):
    def session(hub, a, b, c):
        a.send(b"X1")
        b.send(b"K\r")
        assert hub.plug.sent == [b"K\r"]
        hub._silent()
        a.send(b"0\r")
        assert hub.plug.sent == [b"K\r", b"X10\r"]
        hub._silent()
        a.send(b"X2")
        b.send(b"N\rX")
        a.disconnect(a.client)
        c.disconnect(c.client)
        hub._silent()
        b.send(b"1")  # the only client
        assert hub.plug.sent[2:] == [b"N\r"]
        late = Seat(hub)
        assert late.connect(Client("d"))
        late.send(b"E\r")
        hub._silent()
        b.send(b"\r")
        hub._silent()
        assert hub.plug.sent[3:] == [b"E\r", b"X1\r"]
        late.disconnect(late.client)

    hub(session)


@pytest.mark.parametrize("end", [b"\r", b"\n"])
def test_an_end_of_line_that_one_client_leaves_out_is_put_before_the_request_of_another(hub, end):
    def session(hub, a, b, c):
        a.send(b"X1#")  # discards X1, and acts at once
        hub._silent()
        b.send(b"K" + end)
        hub._silent()
        b.send(b"%")
        b.send(b"N" + end)
        hub._silent()
        c.send(b"K" + end)
        assert hub.plug.sent == [b"X1#", end + b"K" + end, b"%", b"N" + end, b"K" + end]

    hub(session)


def test_a_client_that_sends_no_end_of_line_is_disconnected(hub, caplog):
    def session(hub, a, b, c):
        a.send(b"K\rX")
        a.send(b"1" * 511)
        assert a.client.connected
        a.send(b"1")
        assert not a.client.connected and hub.plug.sent == [b"K\r"]

    hub(session)
    assert caplog.messages == [
        "if1: a sends more than 512 characters without an end of line and is disconnected: end each line with CR"
    ]


def test_what_of_a_smartmotor_waits(hub):
    def session(hub, a, b, c):
        for data in (b"RP a=1", b" ", b'PRINT("a ', b'b")', b"\r", b'PRINT("c\n', b"\x80", b"\xf9"):
            a.send(data)
            hub._silent()
        assert hub.plug.sent == [b"RP ", b"a=1 ", b'PRINT("a b")\r', b'PRINT("c\n', b"\x80", b"\xf9"]
        a.send(b"\x80")
        a.send(b"data")  # of a message in host mode
        b.send(b"RP\r")
        hub._silent()
        assert hub.plug.sent[6:] == [b"\x80", b"data", b"RP\r"]

    hub(session, motors=True)


class Machine(Plug):
    """A plug of a real IF1 in virtual time, which answers within 0.2 s."""

    def __init__(self):
        super().__init__()
        self.bench = Bench()
        self.if1 = initialise(self.bench, self.bench.add("if1", line="instant"))

    def send(self, data):
        self.if1.serial.write(data)
        self.bench.run(0.2)
        if answer := self.if1.serial.read():
            self.client.deliver(answer, None)


@pytest.mark.parametrize("half", [b"X1", b"X1000 ", b"#", b"%", b"X1#", b"K\n"])
@pytest.mark.parametrize("leaves", [False, True])
def test_an_if1_answers_a_client_that_arrives_in_the_half_line_of_another(hub, half, leaves):
    ready = b"F\r" if half == b"%" else b"C\r"  # the host has control

    def session(hub, a, b, c):
        b.disconnect(b.client)
        c.disconnect(c.client)
        a.send(half)
        hub._silent()
        if leaves:
            a.disconnect(a.client)
        assert b.connect(Client("b"))
        first = b.client
        b.send(b"N\r")
        hub._silent()
        b.send(b"E\r")
        assert first.got.removeprefix(b"0\r" if half == b"K\n" else b"") == b"0\r" + ready
        hub._silent()
        if not leaves:
            first.got = b""
            a.send(b"000$\r" if half == b"X1" else b"\r")
            hub._silent()
            b.send(b"E\r")
            assert first.got == (b"E\r" if half == b"X1" else ready)

    hub(session, plug=Machine())
