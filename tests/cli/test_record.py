"""`axistwin record` with a virtual controller in place of the hardware, and `axistwin replay` of the recording."""

import json
import re
import signal
import threading
from contextlib import contextmanager

import pytest
import serial
from click.testing import CliRunner

from axistwin.bench import Do, Expect, Hear, Say
from axistwin.bench.talk.conversation import load
from axistwin.cli.program import axistwin

from ..command import PATIENCE_S, ended, refused, serving
from ..links.serving import Served, ask, dial

pytestmark = pytest.mark.filterwarnings("ignore:set.* is deprecated:DeprecationWarning")  # pyserial's reader thread

QUICK = {"self_test_s": 0.05, "recalculation_s": 0.05}
"""Options that shorten the real time of these tests."""


@contextmanager
def hardware(url="tcp://127.0.0.1:0", **options):
    """Serve a virtual controller as the hardware, in real time; yield the URL for `record` and the port's URL."""
    with Served(speed=1.0) as served:
        served.add(line=None, initialised=False, **QUICK, **options)
        found = served.open(served.bench["if1"], url)
        served.do(lambda: served.bench.run(0.1))  # the controller was switched on earlier
        yield served, str(found).replace("tcp://", "socket://")


@contextmanager
def recorder(*arguments):
    with serving(*arguments, command="record") as (program, [(_, url)]):
        yield program, url


def line(host, text):
    host.sendall(text)
    answer = b""
    while not answer.endswith(b"\r") and (more := host.recv(1)):
        answer += more
    return answer


def replayed(*arguments):
    done = CliRunner().invoke(axistwin, ["replay", *map(str, arguments)], standalone_mode=False)
    return done.return_value, done.stdout


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    """Return the recorded session of a host with the hardware: 300 steps, and a limit switch after 100."""
    path = tmp_path_factory.mktemp("session") / "session.talk"
    options = ["--model", "if1", "--on-for", "0.1", "-o", path]
    with hardware(X={"limits": (-10, 100)}) as (served, url), recorder("--serial", url, *options) as (program, port):
        with dial(port) as host:
            assert ask(host, b"(", b"U\r") == b"U\r"
            host.sendall(b"U61\r")
            assert line(host, b"E\r") == b"C\r"
            host.sendall(b"X300$\r")
            served.until(lambda: served.bench["if1"].axes["X"].position == 101)  # the limit switch has opened
            assert line(host, b"K\r") == b"64\r" and line(host, b"N\r") == b"101\r"
        assert ended(program, signal.SIGINT)[0] == 130
    return path


TWIN = [word for name, value in QUICK.items() for word in ("--option", f"{name}={value}")]


@pytest.mark.slow
def test_the_twin_says_what_the_hardware_said(session):
    code, told = replayed(session, *TWIN, "--option", "X.limits=[-10,100]", "--json")
    comparison = json.loads(told)
    assert (code, comparison["different"]) == (0, 0)
    assert [act["twin"] for act in comparison["acts"]][-2:] == ["64\\r", "101\\r"]
    assert all(act["hardware_ns"] > 0 and act["twin_ns"] > 0 for act in comparison["acts"])
    assert (
        comparison["median_later_ns"]
        == sorted(act["later_ns"] for act in comparison["acts"])[len(comparison["acts"]) // 2]
    )


def test_a_twin_with_another_switch_differs_and_it_is_told_where(session):
    code, told = replayed(session, *TWIN, "--option", "X.limits=[-10,40]", "--brief")
    assert code == 1
    line = next(n for n, text in enumerate(session.read_text().splitlines(), 1) if text == r"< 101\r")
    assert re.search(rf"^ *{line} .*> N\\r  differs\n +hardware  101\\r\n +twin  41\\r\n +\^$", told, re.MULTILINE)
    assert "1 different in bytes" in told


def test_the_recording_says_what_it_is_of(session):
    conversation = load(session)
    assert conversation.headers == {"model": "if1", "line": "9600 8N2", "on-for": "0.1"}
    assert re.search(r"^; recorded: 20\d\d-\d\d-\d\dT\d\d:\d\d:\d\dZ from socket://127\.0\.0\.1:\d+ by axistwin ",
                     session.read_text(), re.MULTILINE)  # fmt: skip
    first, *others = (act.data for act in conversation.acts if isinstance(act, Say))
    assert first == b"("
    assert b"".join(others) == b"U61\rE\rX300$\rK\rN\r"  # in one piece or two, depending on TCP


def test_it_is_written_as_it_goes(tmp_path):
    with hardware() as (_, url), recorder("--serial", url, "-o", tmp_path / "a.talk") as (program, port):
        with dial(port) as host:
            assert ask(host, b"(", b"U\r") == b"U\r"
            host.sendall(b"U61\r")
            assert line(host, b"E\r") == b"C\r"
        program.kill()
        program.wait(PATIENCE_S)
    first, answer, *rest = (act for act in load(tmp_path / "a.talk").acts if isinstance(act, Say | Hear))
    assert (first, answer) == (Say(b"("), Hear(b"U\r"))
    said = b"".join(act.data for act in rest if isinstance(act, Say))
    assert said.startswith(b"U61\rE\r")  # in one piece or two, depending on TCP


@pytest.mark.slow
def test_control_lines_formats_and_breaks_are_passed_on_and_recorded(tmp_path):
    path = tmp_path / "lines.talk"
    arguments = ("--line", "1200 8N2", "--rfc2217", ":0", "-o", path)
    with hardware("rfc2217://127.0.0.1:0") as (served, url), recorder("--serial", url, *arguments) as (program, port):
        device = served.bench["if1"].serial
        with serial.serial_for_url(str(port), 1200, stopbits=2, timeout=PATIENCE_S) as host:
            served.until(lambda: device.host.baudrate == 1200)
            host.rts = False
            served.until(lambda: not device.host.rts)
            host.parity = "E"
            served.until(lambda: device.host.parity == "E")
            host.send_break(0.05)
            host.write(b"?")
            served.until(lambda: not device.pending)
            host.rts = True
            served.until(lambda: device.host.rts)
        assert ended(program)[0] == 0
    done = [act for act in load(path).acts if isinstance(act, Do)]
    assert [act.target for act in done] == ["rts", "line", "break", "rts"] and done[1].value == "1200 8E2"


@pytest.mark.slow
def test_the_controllers_control_lines_are_seen(tmp_path):
    path = tmp_path / "lines.talk"
    with hardware("rfc2217://127.0.0.1:0") as (served, url), recorder("--serial", url, "-o", path) as (program, port):
        with dial(port) as host:
            assert ask(host, b"(", b"U\r") == b"U\r"
            served.act(lambda: served.bench["if1"].power(False))
            while not any(isinstance(act, Expect) and act.subject == "dtr" for act in load(path).acts):
                assert program.poll() is None
        assert ended(program)[0] == 0
    assert [act.value for act in load(path).acts if isinstance(act, Expect) and act.subject == "dtr"] == ["low"]


@pytest.mark.parametrize(("arguments", "words"), [
    (["--serial", "/dev/nothing/here"], "cannot open /dev/nothing/here ("),
    (["--serial", "socket://127.0.0.1:1", "--model", "1811"], "the model 1811 has no serial port to record"),
    (["--serial", "socket://127.0.0.1:1", "--line", "quick"], "invalid baud rate or character format 'quick'")
])  # fmt: skip
def test_wrong_usage_is_one_line(arguments, words, tmp_path):
    code, message = refused("record", *arguments, "-o", tmp_path / "a.talk")
    assert (code, message.count("\n")) == (2, 1) and message.startswith("axistwin: ")
    assert words in message


def test_hardware_that_goes_away_ends_it_and_the_recording_is_there(tmp_path):
    with Served(speed=1.0) as served:
        served.add(line=None, initialised=False, **QUICK)
        url = served.open(served.bench["if1"])
        with recorder("--serial", f"socket://{url.address}", "-o", tmp_path / "a.talk") as (program, _):
            served.until(lambda: served.server.client("if1"))
            served.do(served.server.close)
            _, words = program.communicate(timeout=PATIENCE_S)
    assert program.returncode == 2 and f"lost socket://{url.address}" in words
    assert load(tmp_path / "a.talk").headers["line"] == "9600 8N2"


@pytest.mark.slow
def test_what_the_device_cannot_do_is_told_and_the_recording_goes_on(tmp_path):
    """A pty supports neither 1.5 stop bits with 5 data bits nor mark parity; both are reported once."""
    device = tmp_path / "hardware"
    with (
        hardware(f"pty:{device}"),
        recorder("--serial", device, "--rfc2217", ":0", "-o", tmp_path / "a.talk") as (program, port),
    ):
        with serial.serial_for_url(str(port), 9600, stopbits=2, timeout=PATIENCE_S) as host:
            host.bytesize, host.parity, host.stopbits = 5, "M", 1.5
            host.send_break(0.02)
            host.bytesize, host.parity, host.stopbits = 8, "N", 2
            host.bytesize, host.parity, host.stopbits = 5, "M", 1.5
            host.bytesize, host.parity, host.stopbits = 8, "N", 2
            host.write(b"(")
            assert host.read(2) == b"U\r"
        code, words = ended(program)
    assert code == 0
    assert words.count(f"{device} cannot do 9600 5M1.5: invalid argument") == 1, "once is enough"


@pytest.mark.slow
def test_what_raw_tcp_cannot_pass_on_is_told_once_and_is_no_act(tmp_path):
    """If a break were recorded, the twin would receive it, though the hardware has not."""
    path = tmp_path / "a.talk"
    with hardware() as (_, url), recorder("--serial", url, "--rfc2217", ":0", "-o", path) as (program, port):
        with serial.serial_for_url(str(port), 9600, stopbits=2, timeout=PATIENCE_S) as host:
            host.send_break(0.02)
            host.rts = False
            host.rts = True
            host.parity = "E"
            host.parity = "N"
            host.send_break(0.02)
            host.write(b"(")
            assert host.read(2) == b"U\r"
        code, words = ended(program)
    assert code == 0
    assert words.count(f"{url} carries characters only: line format, control lines and breaks are not forwarded") == 1
    assert not [act for act in load(path).acts if isinstance(act, Do)]
    told = re.findall(r"^; (\w+) (\S+).* by the host did not reach the controller$", path.read_text(), re.MULTILINE)
    assert [what for what, _ in told if what != "line"] == ["break", "rts", "rts", "break"]


@pytest.mark.slow
def test_hardware_that_does_not_answer_holds_up_neither_the_host_nor_the_recording(tmp_path):
    """A request to the hardware takes seconds; a host that negotiates with the recorder is answered meanwhile."""
    path, answers = tmp_path / "a.talk", threading.Event()
    with (
        hardware("rfc2217://127.0.0.1:0") as (served, url),
        recorder("--serial", url, "--rfc2217", ":0", "-o", path) as (program, port),
        serial.serial_for_url(str(port), 9600, stopbits=2, timeout=PATIENCE_S) as host,
    ):
        served.later(lambda: answers.wait(PATIENCE_S))
        for parity in ("E", "N"):  # pyserial gives up after three seconds
            host.rts = parity == "N"
            host.parity = parity
        answers.set()
        host.write(b"(")
        assert host.read(2) == b"U\r" and ended(program)[0] == 0
    assert [act.target for act in load(path).acts if isinstance(act, Do)] == ["rts", "rts"]
