"""A pseudo terminal, opened as a serial device by pyserial and by plain file calls."""

import asyncio
import fcntl
import os
import shutil
import subprocess
import sys
import termios
from contextlib import suppress

import pytest
import serial

from axistwin import Bench
from axistwin.core.errors import LinkError
from axistwin.core.units import to_ns
from axistwin.links.manual_pacer import ManualPacer
from axistwin.links.plug import CHUNK, FULL
from axistwin.links.server import Server
from axistwin.links.urls import parse
from axistwin.sim.frames import UartFormat

from .serving import HOST_TIMEOUT_S, dial, receive

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="needs Linux")


@pytest.fixture
def if1(served):
    """Return an IF1 that waits for its baud rate after power-up."""
    return served.add(initialised=False)


@pytest.fixture
def path(served, if1, tmp_path):
    """Return the path of the link to the IF1's pty."""
    link = tmp_path / "if1"
    served.open(if1, f"pty:{link}")
    return str(link)


def opened(path, **settings):
    return serial.Serial(path, timeout=HOST_TIMEOUT_S, **{"baudrate": 9600, "stopbits": 2, **settings})


def initialise(host):
    host.write(b"(")
    assert host.read(2) == b"U\r"
    host.write(b"U61\rE\r")
    assert host.read(2) == b"C\r"


def test_a_host_initialises_an_if1_and_asks(path):
    with opened(path) as host:
        initialise(host)
        host.write(b"K\r")
        assert host.read(2) == b"0\r"


def test_in_virtual_time_a_host_that_waits_has_data_before_time_goes_on():
    """Linux passes on what is written to a pty by a thread of its own, most often later than the next statement."""
    bench = Bench()
    bench.add("if1")
    pacer = ManualPacer(bench)
    server = Server(bench, pacer=pacer)

    async def ask():
        url = await server.open("if1", parse("pty:"))
        with opened(url.path) as host:
            for text, seconds, answer in ((b"(", 1.1, b"U\r"), (b"U61\r", 1.1, b""), *[(b"N\r", 0.1, b"0\r")] * 200):
                host.write(text)
                before = pacer.arrivals
                await pacer.receive_all()
                assert pacer.arrivals > before
                end_ns = bench.clock.later(to_ns(seconds))
                while not pacer.advance(end_ns):
                    pass
                assert host.in_waiting > 0 or not answer
                assert host.read(len(answer)) == answer
        server.close()

    bench.run(1.1)
    asyncio.run(ask())


def test_baud_rate_and_stop_bits_are_the_clients(served, if1, path):
    with opened(path, baudrate=1200, stopbits=1) as host:
        served.until(lambda: if1.serial.host.format == UartFormat(1200, 8, "N", 1))
        initialise(host)
        host.baudrate = 12345
        served.until(lambda: if1.serial.host.baudrate == 12345)
        host.stopbits = 2
        served.until(lambda: if1.serial.host.stopbits == 2)


def test_odd_parity_is_seen_and_data_bits_are_as_given(served, tmp_path):
    if1 = served.add(line="1200 7E1", initialised=False)
    served.open(if1, f"pty:{tmp_path}/if1")
    with opened(f"{tmp_path}/if1", baudrate=300) as host:
        served.until(lambda: if1.serial.host.format == UartFormat(300, 7, "E", 2))
        host.parity = "O"
        served.until(lambda: if1.serial.host.format == UartFormat(300, 7, "O", 2))


def test_the_device_shows_the_usual_format_to_who_comes(served, path):
    device = os.open(path, os.O_RDWR | os.O_NOCTTY)
    try:
        _, _, flags, _, _, speed, _ = termios.tcgetattr(device)
        assert speed == termios.B9600 and flags & termios.CSTOPB
    finally:
        os.close(device)


def test_baud_rate_0_hangs_up(served, if1, path):
    with opened(path) as host:
        served.until(lambda: if1.serial.host.dtr)
        settings = termios.tcgetattr(host.fd)
        settings[5] = termios.B0
        settings[4] = termios.B0
        termios.tcsetattr(host.fd, termios.TCSANOW, settings)
        served.until(lambda: not if1.serial.host.dtr and not if1.serial.host.rts)
    served.until(lambda: if1.serial.host.dtr and if1.serial.host.rts)


def test_a_client_may_come_when_the_one_before_has_closed(served, if1, path):
    with opened(path) as host:
        initialise(host)
    for _ in range(10):
        with opened(path) as host:
            host.write(b"E\r")
            assert host.read(2) == b"C\r"
    served.until(lambda: served.server._plugs["if1"].client is None)


def test_what_nobody_has_read_is_not_there_for_the_next_one(served, path):
    with opened(path) as host:
        initialise(host)
        host.write(b"E\r")
        assert host.read(1) == b"C"
    served.until(lambda: served.server._plugs["if1"].client is None)
    device = os.open(path, os.O_RDWR | os.O_NOCTTY)
    waiting = fcntl.ioctl(device, termios.FIONREAD, bytes(4))
    os.close(device)
    assert waiting == bytes(4)


def test_a_program_without_serial_settings_is_served_too(served, if1, path):
    """A program that only opens, writes and reads is served, as a shell does."""
    device = os.open(path, os.O_RDWR | os.O_NOCTTY)
    os.write(device, b"(")
    assert os.read(device, 2) == b"U\r"
    os.close(device)


def test_flushing_its_output_takes_back_what_has_not_left(served, if1, path):
    with opened(path) as host:
        initialise(host)
        served.act(lambda: if1.serial.dtr_line.drive(False))
        host.write(b"X100$\r")
        served.until(lambda: if1.serial.pending == 6)
        host.reset_output_buffer()
        served.until(lambda: if1.serial.pending == 0)


def test_a_client_that_does_not_read_loses_characters_and_no_more(served, if1, path):
    with opened(path) as host:
        initialise(host)
        port = served.server._plugs["if1"].client
        for _ in range(20):
            served.do(lambda: port.deliver(b"x" * 20_000, 0))
        assert len(port._writer._waiting) <= 64 * 1024 and port._writer._dropped > 0
        host.reset_input_buffer()
        host.write(b"E\r")
        assert host.read_until(b"\r").endswith(b"C\r")


def test_a_client_that_floods_waits_until_there_is_room(served, if1, path):
    served.act(lambda: if1.serial.dtr_line.drive(False))
    device = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    with suppress(BlockingIOError):
        for _ in range(1000):
            os.write(device, b"E\r" * 1000)
    assert served.do(lambda: if1.serial.pending) < FULL + CHUNK + 1
    os.close(device)
    with opened(path) as host:  # the characters of the disconnected client are sent
        served.act(if1.serial.dtr_line.release)
        initialise(host)


@pytest.mark.slow
def test_while_another_client_is_connected_a_pty_is_not_listened_to(served, if1, path):
    other = served.open(if1)
    with opened(path) as host:
        initialise(host)
        with dial(other) as refused:
            assert receive(refused, 1) == b""
    served.until(lambda: served.server._plugs["if1"].client is None)
    with dial(other) as connection:
        connection.sendall(b"E\r")
        assert receive(connection, 2) == b"C\r"
        with opened(path) as host:
            host.write(b"X100$\r")
            host.flush()
            connection.sendall(b"E\r")
            assert receive(connection, 2) == b"C\r"
    assert if1.axes["X"].position == 0
    served.until(lambda: served.server._plugs["if1"].client is None)
    with opened(path) as host:
        host.write(b"E\r")
        assert host.read(2) == b"C\r"


# The link


def test_the_link_is_gone_when_the_port_is_closed(served, path):
    assert os.path.islink(path)
    served.do(served.server.close)
    assert not os.path.lexists(path)


def test_without_a_path_the_device_itself_is_told(served, if1):
    assert served.open(if1, "pty:").path.startswith("/dev/pts/")


def test_a_link_left_behind_is_replaced(served, if1, tmp_path):
    link = tmp_path / "if1"
    link.symlink_to("/dev/pts/no-such")
    served.open(if1, f"pty:{link}")
    assert link.exists()


def test_a_link_left_behind_is_replaced_though_its_number_is_ours_now(served, if1, tmp_path):
    """A killed server has left its link; the next pty has the same number, and the link is replaced."""
    link = tmp_path / "if1"
    ends = os.openpty()
    link.symlink_to(os.ttyname(ends[1]))
    for end in ends:
        os.close(end)
    served.open(if1, f"pty:{link}")
    assert os.readlink(link).startswith("/dev/pts/") and link.exists()


@pytest.mark.parametrize("name", ["file", "directory", "link"])
def test_something_else_at_the_path_is_left_alone(served, if1, tmp_path, name):
    (tmp_path / "file").write_text("mine")
    (tmp_path / "directory").mkdir()
    (tmp_path / "link").symlink_to("file")
    with pytest.raises(LinkError, match=r"cannot create pty:.*: .* already exists; choose another path"):
        served.open(if1, f"pty:{tmp_path}/{name}")
    assert (tmp_path / name).exists()


def test_a_path_that_cannot_be_is_one_line(served, if1, tmp_path):
    with pytest.raises(LinkError, match="no such file or directory; choose another path"):
        served.open(if1, f"pty:{tmp_path}/no/such")


TIOCGEXCL = 0x80045440


def test_what_a_client_leaves_in_the_terminal_ends_with_the_client(served, if1, path):
    """Exclusive use, canonical mode, HUPCL and baud rate 0 are gone for the next client."""

    def state(fd):
        return termios.tcgetattr(fd), fcntl.ioctl(fd, TIOCGEXCL, bytes(4))

    first = os.open(path, os.O_RDWR | os.O_NOCTTY)
    fresh = state(first)
    left = termios.tcgetattr(first)
    left[2] |= termios.HUPCL
    left[3] |= termios.ICANON | termios.ECHO
    left[4] = left[5] = termios.B0
    termios.tcsetattr(first, termios.TCSANOW, left)
    fcntl.ioctl(first, termios.TIOCEXCL)
    served.until(lambda: not if1.serial.host.dtr)
    os.close(first)
    served.until(lambda: if1.serial.host.dtr)
    second = os.open(path, os.O_RDWR | os.O_NOCTTY)
    try:
        assert state(second) == fresh
    finally:
        os.close(second)
    with opened(path) as host:
        initialise(host)


EXCLUSIVE_CLIENTS = """
import fcntl, os, serial, subprocess, sys, termios
words = ["serve", "if1", "--pty", sys.argv[1], "--speed", "max", "--line", "instant", "--reset-on-connect"]
program = [sys.executable, "-c", "from axistwin.cli.program import main; main()"]
server = subprocess.Popen([*program, *words], stdout=subprocess.PIPE)
try:
    server.stdout.readline()
    for client in range(3):
        while True:
            try:
                host = serial.Serial(sys.argv[1], 9600, stopbits=2, timeout=0.25, exclusive=None)
                break
            except serial.SerialException:  # until the server has noticed that the client before has gone
                pass
        fcntl.ioctl(host.fd, termios.TIOCEXCL)
        while host.read(2) != b"U\\r":
            host.write(b"(")
        print("answered", flush=True)
        host.close()
finally:
    server.kill()
"""


@pytest.mark.slow
def test_exclusive_clients_one_after_another_without_the_rights_of_an_administrator(tmp_path):
    """TIOCEXCL stays in a terminal, and only CAP_SYS_ADMIN opens it then: another one takes its place at the link."""
    words = [sys.executable, "-c", EXCLUSIVE_CLIENTS, str(tmp_path / "if1")]
    if os.geteuid() == 0:
        if shutil.which("setpriv") is None:
            pytest.skip("needs setpriv of util-linux, to give up CAP_SYS_ADMIN")
        words = ["setpriv", "--bounding-set=-sys_admin", *words]
    done = subprocess.run(words, capture_output=True, text=True, timeout=300, check=False)
    assert done.stdout == "answered\n" * 3, done.stderr
