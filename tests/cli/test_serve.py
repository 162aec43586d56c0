"""`axistwin serve` as a program: output and signals."""

import asyncio
import re
import signal
import socket
from pathlib import Path

import pytest
import serial

from axistwin import Bench
from axistwin.cli.serving import bench_and_ports as served
from axistwin.cli.serving import host_lines
from axistwin.cli.serving.host_lines import lines
from axistwin.drivers import connect
from axistwin.links.server import Server
from axistwin.links.urls import PortUrl
from axistwin.sim.frames import UartFormat

from ..command import AT_ONCE, PATIENCE_S, ended, refused, run, serving


def positions(trace):
    rows = [row.split(",") for row in trace.read_text().splitlines()]
    return [int(value) for _, signal, value in (row for row in rows if len(row) == 3) if signal == "if1.X.pulses"]


def talk(url, *texts):
    answers = []
    with socket.create_connection((url.host, url.port), timeout=PATIENCE_S) as connection:
        for text in texts:
            connection.sendall(text)
            answers.append(connection.recv(16))
    return answers


@pytest.mark.parametrize("wait", [True, False])
def test_virtual_time_can_wait_for_the_first_host(wait):
    async def main():
        bench = Bench()
        bench.add("if1", line="instant")
        server = Server(bench)
        url = await server.open("if1", PortUrl("tcp", "127.0.0.1", 0))
        (server.start_on_connection if wait else server.start)()
        for _ in range(20):
            await asyncio.sleep(0)
        server.pacer.sync()
        assert (bench.now == 0) is wait
        _, writer = await asyncio.open_connection(url.host, url.port)
        while not server.client("if1"):
            await asyncio.sleep(0)
        while not bench.now:
            server.pacer.sync()
        writer.close()
        server.close()

    asyncio.run(main())


def test_a_host_that_sends_commands_before_the_data_format_is_told_why_nothing_comes():
    with serving("if1", *AT_ONCE) as (program, [(_, url)]):
        assert talk(url, b"(") == [b"U\r"]
        with socket.create_connection((url.host, url.port), timeout=PATIENCE_S) as connection:
            connection.sendall(b"E\rX1000$\r(")
            assert connection.recv(16) == b"U\r"
        code, words = ended(program)
    assert code == 0
    assert words.count("axistwin: if1: characters from the host are dropped, no data format yet") == 1


def test_interrupted_it_ends_with_130_takes_its_link_away_and_completes_its_trace(tmp_path):
    ports = ("--pty", tmp_path / "if1", "--tcp", ":0", "--rfc2217", "localhost:0")
    with serving("if1", *AT_ONCE, *ports, "--trace", "a.csv", ports=3, cwd=tmp_path) as (program, ports):
        assert [(name, url.scheme) for name, url in ports] == [("if1", "tcp"), ("if1", "pty"), ("if1", "rfc2217")]
        assert (tmp_path / "if1").is_symlink()
        with serial.Serial(str(tmp_path / "if1"), 9600, stopbits=2, timeout=PATIENCE_S) as host:
            host.write(b"(")
            assert host.read(2) == b"U\r"
            host.write(b"U61\rX50@400$\rX$\rN\r")
            assert host.read_until(b"\r").endswith(b"\r")
        assert ended(program, signal.SIGINT)[0] == 130
    assert [file.name for file in tmp_path.iterdir()] == ["a.csv"]
    assert positions(tmp_path / "a.csv")[:51] == list(range(51))


def test_what_is_locked_is_there_again_after_the_end(tmp_path):
    for first in (True, False):
        with serving("if2", *AT_ONCE, "--state", tmp_path) as (program, [(name, url)]):
            assert (name, url.host) == ("if2", "127.0.0.1")
            expected = [b"U\r", b"C\r", b"[\r"] if first else [b"U\r", b"[\r", b"[\r"]
            assert talk(url, b"(", b"U61\rE\r", b"[\rE\r") == expected
            assert ended(program) == (0, "")


def test_a_session_is_traced_and_recorded_and_can_be_played_again(tmp_path):
    talk_file = tmp_path / "session.talk"
    arguments = ("if1", *AT_ONCE, "--option", "recalculation_s=0.5", "--option", "X={limits=[-10,100]}")
    files = ("--record", talk_file, "--trace", tmp_path / "a.csv")
    with serving(*arguments, *files) as (program, [(_, url)]):
        # at 400 steps/s without a ramp, the switch opens on pulse 101 and stops the motor at this pulse
        assert talk(url, b"(", b"U61\rE\r", b"X200$\rE\r", b"N\r") == [b"U\r", b"C\r", b"E\r", b"101\r"]
        assert ended(program) == (0, "")
    played = run("run", "if1", talk_file)
    assert (played.code, played.err) == (0, "") and "X        0  101     101 " in played.out
    assert positions(tmp_path / "a.csv") == list(range(102))


def test_a_recording_is_written_while_it_goes_on(tmp_path):
    """The server is killed, so it cannot write the rest of the recording."""
    talk_file = tmp_path / "session.talk"
    with serving("if1", *AT_ONCE, "--record", talk_file) as (program, [(_, url)]):
        assert talk(url, b"(", b"U61\rE\r") == [b"U\r", b"C\r"]
        while "< C" not in talk_file.read_text():  # the last answer is written too, without a later event
            assert program.poll() is None
        program.kill()
        program.wait(PATIENCE_S)
    played = run("run", "if1", talk_file)
    assert (played.code, played.err) == (0, "")


def test_a_recording_ends_in_talk(tmp_path):
    code, words = refused("serve", "if1", "--record", tmp_path / "session.txt")
    assert (code, "ends in .talk" in words) == (2, True)


def test_a_scene_names_its_ports(tmp_path):
    scene = tmp_path / "cell.toml"
    scene.write_text(
        """
        [[controller]]
        model = "if1"
        name = "left"
        line = "instant"
        ports = ["tcp://127.0.0.1:0"]

        [[controller]]
        model = "if2"
        name = "right"
        line = "instant"
        ports = ["tcp://127.0.0.1:0"]
        """
    )
    with serving(scene, "--speed", "max", ports=2) as (program, ports):
        assert [name for name, _ in ports] == ["left", "right"]
        for _, url in ports:
            assert talk(url, b"(", b"U61\rE\r") == [b"U\r", b"C\r"]
        assert ended(program) == (0, "")


def test_a_port_in_use_is_one_line():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        address = f"127.0.0.1:{taken.getsockname()[1]}"
        code, words = refused("serve", "if1", "--tcp", address)
    assert code == 2
    assert words == (
        f"axistwin: cannot listen on tcp://{address}: address already in use; "
        "choose another address, or port 0 for any free port\n"
    )


@pytest.mark.parametrize(("arguments", "words"), [
    (["if9"], "no model 'if9'"),
    (["if1", "--speed", "fast"], "invalid speed 'fast'"),
    (["if1", "--port", "ftp://x"], "invalid port URL 'ftp://x'"),
    (["if1", "--line", "quick"], "invalid baud rate or character format 'quick'"),
    (["if1", "--option", "colour=red"], "no option 'colour'"),
    (["no.toml", "--line", "instant"], "cannot be used with a scene: make these settings in the scene file")
])  # fmt: skip
def test_wrong_usage_is_one_line(arguments, words):
    code, message = refused("serve", *arguments)
    assert code == 2
    assert message.startswith("axistwin: ") and words in message
    assert message.count("\n") == 1


# Refused lines

REFUSED = {
    "if1": (
        [(b"(", b"U\r"), (b"U61\rx1\rF\r", b"8\r"), (b"x1\rF\r", b"8\r")],
        [
            "axistwin: if1: refused x1: unknown character 'x': commands are upper case; write X [DP101]",
            "axistwin: if1: refused x1 (the same once more)",
        ],
    ),
    "smartmotor": (
        [(b"FLY RP ", b"0\r")],
        [
            (
                "axistwin: smartmotor: refused FLY: unknown command FLY [SM101]: "
                "The motor sets the status bit Bs (syntax error) and continues with the next statement. "
                "`axistwin commands smartmotor` lists all commands. A comment begins with an apostrophe."
            )
        ],
    ),
    "1811": ([], ["axistwin: 1811: refused 33 00 00 00 01: 31 (default velocity and acceleration) must be sent first"]),
}


@pytest.mark.parametrize("quiet", [(), ("--quiet",)])
@pytest.mark.parametrize("model", list(REFUSED))
def test_refused_lines_are_told_on_stderr_and_quiet_ends_it(model, quiet):
    said, told = REFUSED[model]
    with serving(model, *(AT_ONCE if said else ("--speed", "max")), *quiet) as (program, [(_, url)]):
        for text, answer in said:
            assert talk(url, text) == [answer]
        if not said:
            with connect(str(url), "1811", timeout=PATIENCE_S) as board:
                board.command(0x33, 0, 0, 0, 1)
                board.request(0x83)
        code, words = ended(program)
    assert code == 0
    assert [line for line in words.splitlines() if "refused" in line] == ([] if quiet else told)


# --show-hosts

LINE = UartFormat(9600, 8, "N", 2)


def test_the_lines_for_hosts_are_shown_with_each_port():
    with serving("if1", *AT_ONCE, "--show-hosts") as (program, [(_, url)]):
        line = program.stdout.readline()
        assert line == f'    pyserial  serial.serial_for_url("socket://{url.address}", timeout=2)\n'
        with eval(line.split("  ", 3)[-1]) as host:  # the line that a user pastes
            host.write(b"(")
            assert host.read(2) == b"U\r"


@pytest.mark.parametrize(("url", "expected"), [
    (
        PortUrl("rfc2217", "127.0.0.1", 2217),
        ['serial.serial_for_url("rfc2217://127.0.0.1:2217", baudrate=9600, bytesize=8, parity="N", stopbits=2,',
         'drvAsynIPPortConfigure("if1", "127.0.0.1:2217 COM", 0, 0, 0)', 'asynSetOption("if1", 0, "baud", "9600")',
         'asynOctetSetInputEos("if1", 0, "\\r")'],
    ),
    (
        PortUrl("pty", path="/tmp/if1"),
        ['serial.Serial("/tmp/if1", baudrate=9600, bytesize=8, parity="N", stopbits=2, timeout=2)',
         'open_resource("ASRL/tmp/if1::INSTR", baud_rate=9600, ',
         'drvAsynSerialPortConfigure("if1", "/tmp/if1", 0, 0, 0)', 'asynSetOption("if1", 0, "stop", "2")'],
    ),
    (PortUrl("tcp", "127.0.0.1", 5001),
     ["TCPIP0::127.0.0.1::5001::SOCKET", 'drvAsynIPPortConfigure("if1", "127.0.0.1:5001", 0, 0, 0)']),
    (PortUrl("tcp", "0.0.0.0", 5001), [f"TCPIP0::{socket.gethostname()}::5001::SOCKET"]),
    (PortUrl("serial", path="/dev/ttyUSB0", baud=2400), ["2400 baud, 8 data bits,", "parity N, 2 stop bits"])
])  # fmt: skip
def test_the_lines_fit_the_port(url, expected):
    shown = "\n".join(lines("if1", url, LINE))
    for part in expected:
        assert part in shown


def test_a_path_is_shown_so_that_it_works_in_every_directory(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(serial, "Serial", lambda path, **_: path)
    (shown, *_) = lines("if1", PortUrl("pty", path='a "b"'), LINE)
    assert eval(shown.split(None, 1)[1]) == str(tmp_path / 'a "b"')


def test_hosts_without_ipv6_are_told_so():
    shown = list(lines("if1", PortUrl("tcp", "::1", 5001), LINE))
    assert [line.split()[0] for line in shown if "not supported at ::1: use an IPv4 address" in line] == [
        "PyVISA",
        "asyn",
    ]
    assert len(shown) == 3
    assert list(host_lines.bus(PortUrl("bus", "::1", 1811)))[-1].split() == ["AXISTWIN_BUS=::1:1811", "./host"]


def test_a_board_on_its_bus_and_what_a_c_host_needs():
    with serving("1811", "--speed", "max", "--show-hosts") as (program, [(name, url)]):
        assert (name, url.scheme) == ("1811", "bus")
        shown = "".join(program.stdout.readline() for _ in range(3))
        assert f"AXISTWIN_BUS={url.address}" in shown
        header = Path(re.search(r"-I(\S+)", shown)[1]) / "axistwin_bus.h"
        assert "int in(" in header.read_text()
        with socket.create_connection((url.host, url.port), timeout=PATIENCE_S) as host:
            host.sendall(b"i\n")
            assert host.recv(10) == b"0\n"
        assert ended(program)[0] == 0


def test_a_board_has_no_serial_port():
    code, words = refused("serve", "1811", "--tcp", ":0")
    assert (code, "use its attribute `bus`" in words) == (2, True)


def test_a_scene_is_called_as_it_calls_itself(tmp_path):
    (tmp_path / "a.toml").write_text('title = "Two <b>"\ncontroller = [{ model = "if1" }]\n')
    (tmp_path / "b.toml").write_text('controller = [{ model = "if1" }]\n')
    titles = [served.scene(str(path), [], alone=True).title for path in sorted(tmp_path.iterdir())]
    assert titles == ["Two <b>", str(tmp_path / "b.toml")]
