"""Raw TCP: well-behaved and faulty clients."""

import asyncio
import socket
import struct

import pytest

from axistwin.core.errors import LinkError, UsageError
from axistwin.links.plug import CHUNK, FULL
from axistwin.links.tcp import STALLED, resolved
from axistwin.links.urls import PortUrl
from axistwin.sim.frames import LineError
from axistwin.sim.serial_port import Flow

from .serving import Served, ask, dial, receive


@pytest.fixture
def port(served):
    return served.open(served.add())


@pytest.fixture
def neighbour(served):
    """Return a client of another controller on the same bench, which must not be affected."""
    with dial(served.open(served.add())) as connection:
        assert ask(connection) == b"C\r"
        yield connection
        assert ask(connection) == b"C\r"


def vanish(connection):
    """Reset the connection, as when a program is killed or its machine restarted."""
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    connection.close()


def test_a_host_initialises_an_if1_and_moves(served):
    if1 = served.add(initialised=False)
    with dial(served.open(if1)) as host:
        assert ask(host, b"(", b"U\r") == b"U\r" and ask(host, b"U61\rE\r") == b"C\r"
        host.sendall(b"X123$\r")
        served.until(lambda: if1.axes["X"].position >= 123)
        assert ask(host, b"N\r", b"123\r") == b"123\r"


def test_with_true_character_times_the_answer_is_the_same(served):
    if1 = served.add(line="1200 8N2", initialised=False)
    with dial(served.open(if1)) as host:
        assert ask(host, b"(", b"U\r") == b"U\r" and ask(host, b"U61\rE\r") == b"C\r"
        assert if1.serial.host.baudrate == 1200


def test_a_port_listens_on_this_machine_only_and_tells_its_number(served):
    url = served.open(served.add(), "tcp://:0")
    assert url.host == "127.0.0.1" and url.port > 0


@pytest.mark.parametrize(("host", "looked_up"), [("127.0.0.1", False), ("localhost", True), ("::1", True)])
def test_only_a_name_or_an_ipv6_address_is_looked_up(host, looked_up):
    class Loop(asyncio.SelectorEventLoop):
        async def getaddrinfo(self, *arguments, **options):
            asked.append(arguments)
            return await super().getaddrinfo(*arguments, **options)

    asked, loop = [], Loop()
    try:
        family, address = loop.run_until_complete(resolved(PortUrl("tcp", host, 5001)))
    finally:
        loop.close()
    assert address[1] == 5001 and family in (socket.AF_INET, socket.AF_INET6)
    assert asked == ([(host, 5001)] if looked_up else [])


def test_a_port_in_use_is_one_line(served, port):
    with pytest.raises(LinkError, match=rf"cannot listen on {port}: address already in use; choose") as caught:
        served.open(served.add(), str(port))
    assert "\n" not in str(caught.value)


def test_an_address_that_is_not_ours_is_one_line(served):
    with pytest.raises(LinkError, match=r"cannot listen on tcp://192\.0\.2\.1:5001: "):
        served.open(served.add(), "tcp://192.0.2.1:5001")


def test_only_controllers_on_the_bench_have_ports(served):
    served.add()
    with pytest.raises(UsageError, match="no controller 'if2' on the bench"):
        served.do(lambda: served.bench["if2"])


# One plug


def test_a_second_client_is_refused_and_the_first_one_does_not_notice(served, port, caplog):
    with dial(port) as first:
        assert ask(first) == b"C\r"
        with dial(port) as second:
            assert receive(second, 1) == b""
        assert ask(first) == b"C\r"
    assert "if1: refused 127.0.0.1:" in caplog.text


def test_a_client_may_come_when_the_one_before_has_gone(port):
    for _ in range(20):
        with dial(port) as host:
            assert ask(host) == b"C\r"


def test_two_ports_of_one_controller_share_its_plug(served, port):
    other = served.open(served.bench["if1"])
    with dial(port) as first:
        assert ask(first) == b"C\r"
        with dial(other) as second:
            assert receive(second, 1) == b""
    with dial(other) as second:
        assert ask(second) == b"C\r"


def test_a_client_that_has_ended_its_side_still_gets_its_answer(port):
    with dial(port) as host:
        host.sendall(b"E\r")
        host.shutdown(socket.SHUT_WR)
        assert receive(host, 2) == b"C\r"


def test_a_new_client_starts_with_empty_buffers(served):
    """Received and pending characters of the previous client are discarded."""
    if1 = served.add()
    url = served.open(if1)
    served.do(lambda: if1.serial.to_device.cut())
    with dial(url) as first:
        first.sendall(b"X100$\r" * 10)
        served.until(lambda: served.server._plugs["if1"].client)
    served.until(lambda: served.server._plugs["if1"].client is None or served.server._plugs["if1"].client.hung_up())
    served.do(lambda: if1.serial.to_device.mend())
    with dial(url) as second:
        assert ask(second) == b"C\r"


def test_reset_on_connect_gives_each_client_a_controller_just_switched_on():
    with Served(reset=True) as served:
        url = served.open(served.add())
        for _ in range(2):
            with dial(url) as host:
                assert ask(host, b"(", b"U\r") == b"U\r" and ask(host, b"U61\rE\r") == b"C\r"


# Faulty clients


def test_a_client_that_vanishes_in_the_middle_of_a_message(port, neighbour):
    host = dial(port)
    host.sendall(b"X10")
    vanish(host)
    with dial(port) as host:
        assert ask(host, b"#\rE\r") == b"C\r"


def test_a_client_that_vanishes_in_the_middle_of_a_character():
    with Served(speed=1.0) as served:
        if1 = served.add(line="110 8N2", initialised=False)
        host = dial(served.open(if1))
        host.sendall(b"XY")
        served.until(lambda: if1.serial.pending == 1)  # the X is being transmitted
        vanish(host)
        served.until(lambda: if1.serial.pending == 0)


def test_a_client_that_stalls_loses_characters_and_no_more(served, port, neighbour):
    """The client never reads the echo; the pending characters are bounded."""
    with dial(port) as host:
        host.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        assert ask(host) == b"C\r"
        client = served.server._plugs["if1"].client
        for _ in range(200):
            served.do(lambda: client.deliver(b"x" * 20_000, LineError.NONE))
        assert served.do(lambda: client._transport.get_write_buffer_size()) < 2 * STALLED and client.dropped > 0
        assert ask(neighbour) == b"C\r"


def test_a_client_that_floods_is_not_read_from_until_there_is_room():
    """The wire transmits about 870 characters per second; the queue is bounded."""
    with Served(speed=10, flow=Flow.NONE) as served:
        if1, quiet = served.add(line=None, initialised=False), served.add()
        url, other = served.open(if1), served.open(quiet)
        with dial(url) as host, dial(other) as neighbour:
            host.settimeout(0.2)
            with pytest.raises(TimeoutError):
                host.sendall(b"E\r" * 5_000_000)
            assert served.do(lambda: if1.serial.pending) < FULL + CHUNK + 1
            assert ask(neighbour) == b"C\r"
        with dial(url):  # the characters of the disconnected client are sent
            served.until(lambda: served.server._plugs["if1"].client is not None and not if1.serial.pending)


def test_rubbish_is_answered_with_nothing(port, neighbour):
    with dial(port) as host:
        host.sendall(bytes(range(256)) * 64)
        assert ask(host, b"\r#\rF\rE\r", b"8\rC\r") == b"8\rC\r"


def test_clients_that_come_and_go_at_once_leave_nothing_behind(port, neighbour):
    for _ in range(50):
        vanish(dial(port))
    with dial(port) as host:
        assert ask(host) == b"C\r"


# Flow control


def test_while_dtr_is_off_the_link_holds_the_host_back(served, port):
    """Moves fill the buffer during the first move; DTR stops the host, and no character is lost."""
    if1 = served.bench["if1"]
    with dial(port) as host:
        host.sendall(b"X100$\r" * 50)
        served.until(lambda: if1.axes["X"].position == 5000)
        assert ask(host, b"F\r", b"0\r") == b"0\r"


def test_a_host_that_is_not_held_back_overruns_the_buffer():
    """At 9600 baud, the characters sent during a ramp calculation of one second overrun the buffer."""
    with Served(flow=Flow.NONE) as served:
        if1 = served.add(line=None)
        with dial(served.open(if1)) as host:
            host.sendall(b"^10\r" + b"X1\r" * 100)
            served.until(lambda: not if1.serial.pending)
            assert ask(host, b"#\rF\r", b"8\r") == b"8\r"


# Many


def test_fifty_controllers_on_fifty_ports():
    with Served() as served:
        urls = [served.open(served.add(name=f"if1-{number}")) for number in range(50)]
        hosts = [dial(url) for url in urls]
        for number, host in enumerate(hosts):
            host.sendall(f"X{number + 1}$\r".encode())
        for number, host in enumerate(hosts):
            served.until(lambda number=number: served.bench[f"if1-{number}"].axes["X"].position == number + 1)
            host.close()


def test_nul_after_cr_is_told_once(served, port, caplog):
    with dial(port) as telnet:
        assert ask(telnet, b"E\r", b"C\r") == b"C\r"
        telnet.sendall(b"\0E\r\0E\r")
        served.until(lambda: caplog.records)
    (told,) = [record.getMessage() for record in caplog.records]
    assert "sends NUL after CR, as a telnet client does" in told
    assert told.endswith(f"use axistwin term socket://{port.address}")
