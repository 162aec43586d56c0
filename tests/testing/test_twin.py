"""`axistwin.serve`: hosts and their controllers in one test, in virtual time."""

import socket
import sys
import threading
import time
from pathlib import Path

import pytest
import serial

import axistwin
from axistwin import play
from axistwin.bench.talk.conversation import load
from axistwin.core.errors import LinkError, UsageError
from axistwin.core.units import S
from axistwin.links import host_thread
from axistwin.links.manual_pacer import ManualPacer

from ..told import raises

HOST_TIMEOUT_S = 300
SLEEP = time.sleep

MOTORS = {
    "controller": [
        {"model": "if1", "name": "left", "axes": {"X": {"limits": [-10, 100]}}},
        {"model": "if2", "name": "right", "options": {"wiring": "3-wire"}, "ports": ["rfc2217://127.0.0.1:1"]},
        {"model": "1811", "name": "board"},
    ],
    "wire": [{"from": "left.output1", "to": "right.input1"}],
}


@pytest.fixture
def twin():
    with axistwin.serve("if1", speed="manual") as twin:
        yield twin


@pytest.fixture
def host(twin):
    with serial.serial_for_url(twin.ports["if1"], timeout=HOST_TIMEOUT_S) as host:
        yield host


def ask(host, text):
    host.write(text)
    return host.read_until(b"\r")


def initialised(twin, host):
    twin.advance(1.5)
    assert twin.call(ask, host, b"(") == b"U\r"
    host.write(b"U61\r")
    twin.advance(1.2)


@pytest.mark.skipif(sys.platform != "linux", reason="reads the state of a thread in /proc")
def test_a_host_that_ends_while_its_state_is_read(twin, monkeypatch):
    finish, read_text = threading.Event(), Path.read_text

    def read_after_the_end(path, **options):
        if path.name != "stat":
            return read_text(path, **options)
        with path.open(**options) as file:
            finish.set()
            while path.exists():
                pass
            return file.read()

    monkeypatch.setattr(Path, "read_text", read_after_the_end)
    assert twin.call(finish.wait, HOST_TIMEOUT_S) is True


def test_a_host_that_does_not_wait(twin, host):
    twin.advance(1.5)
    host.write(b"(")
    twin.advance(0.1)
    assert host.read(2) == b"U\r" and twin.clock.now == 1_600_000_000


def test_time_passes_only_on_request(twin, host):
    twin.advance(1.5)
    host.timeout = 0.05
    assert ask(host, b"(") == b"" and twin.clock.seconds == 1.5


def test_a_host_may_wait_in_a_separate_thread(twin, host):
    heard = []
    thread = threading.Thread(target=lambda: heard.append(host.read(2)))
    thread.start()
    twin.advance(1.5)
    host.write(b"(")
    twin.advance(0.1)
    thread.join(HOST_TIMEOUT_S)
    assert heard == [b"U\r"]


def test_a_host_that_polls(twin, host):
    def wait_until_it_stops():
        while (busy := ask(host, b"E\r")) != b"C\r":
            assert busy == b"E\r"

    initialised(twin, host)
    host.write(b"X1000@1000$\r")
    twin.call(wait_until_it_stops)
    assert twin.bench["if1"].axes["X"].position == 1000


def test_a_run_is_reproducible(tmp_path):
    def session(path):
        with (
            axistwin.serve("if1", speed="manual", record=path) as twin,
            serial.serial_for_url(twin.ports["if1"], timeout=HOST_TIMEOUT_S) as host,
        ):
            initialised(twin, host)
            for _ in range(5):
                assert twin.call(ask, host, b"E\r") == b"C\r"
            host.write(b"X10$\r")
            twin.advance(1)
        return path.read_text()

    first = session(tmp_path / "first.talk")
    assert session(tmp_path / "second.talk") == first
    bench = axistwin.Bench()
    bench.add("if1")
    assert play(load(tmp_path / "first.talk"), bench) is None


def test_the_test_continues_while_a_host_waits(twin, host):
    """The host waits for an input; the test closes the input."""

    def move_and_wait():
        host.write(b">1X100$\r")
        while ask(host, b"N\r") != b"100\r":
            pass
        return "there"

    initialised(twin, host)
    working = twin.start(move_and_wait)
    twin.advance(0.5)
    assert not working.done and twin.bench["if1"].axes["X"].position == 0
    twin.bench["if1"].pins["input1"].drive(True)
    assert twin.run_until(lambda: twin.bench["if1"].axes["X"].position == 100, 5)
    assert working.result() == "there"


def test_an_exception_of_a_host_is_raised(twin):
    def fails():
        raise ZeroDivisionError

    raises(ZeroDivisionError, "", twin.call, fails)


def test_a_host_that_waits_without_end_is_an_error(twin, host, monkeypatch):
    monkeypatch.setattr("axistwin.links.manual_clock.IDLE_S", 0.05)
    working = twin.start(host.read, 1)
    raises(LinkError, "neither sent nor received data for 3 s of virtual time", working.result, timeout=3)
    assert 3 <= twin.clock.seconds <= 6
    host.close()


def test_a_scene_as_a_dict_on_free_ports():
    with axistwin.serve(MOTORS, speed="manual") as twin:
        assert [url.partition(":")[0] for url in twin.ports.values()] == ["socket", "rfc2217", "bus"]
        assert twin.ports["right"].port != 1
        assert twin.ports["left"].visa == f"TCPIP0::127.0.0.1::{twin.ports['left'].port}::SOCKET"
        twin.bench["left"].pins["output1"].drive(True)
        twin.advance(0)
        assert twin.bench["right"].pins["input1"].level
        with socket.create_connection((twin.ports["board"].host, twin.ports["board"].port), HOST_TIMEOUT_S) as bus:
            bus.sendall(b"i\n")
            assert bus.recv(8) == b"0\n"


def test_a_scene_file_and_the_ports_it_names(tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    (tmp_path / "cell.toml").write_text(f'[[controller]]\nmodel = "if1"\nports = ["tcp://127.0.0.1:{port}"]\n')
    with axistwin.serve(tmp_path / "cell.toml", speed="max", fixed_ports=True) as twin:
        assert twin.ports["if1"] == f"socket://127.0.0.1:{port}"
        with serial.serial_for_url(twin.ports["if1"], timeout=HOST_TIMEOUT_S) as host:
            assert ask(host, b"(") == b"U\r"


def test_time_passes_continuously_at_other_speeds():
    with axistwin.serve("if1", speed="max", line="instant") as twin:
        with serial.serial_for_url(twin.ports["if1"], timeout=HOST_TIMEOUT_S) as host:
            assert ask(host, b"(") == b"U\r"
            host.write(b"U61\rX100$\r")
            assert twin.run_until(lambda: twin.bench["if1"].axes["X"].position == 100, HOST_TIMEOUT_S)
            assert twin.call(ask, host, b"E\r") == b"C\r"
        raises(UsageError, "cannot advance virtual time by 1 s without a manual clock", twin.advance, 1)
        assert not twin.run_until(lambda: False, 0.01)


def test_an_exception_of_a_condition_is_raised_and_ends_the_wait():
    with axistwin.serve("if1", speed=1) as twin:
        pacer = twin._service.server.pacer
        raises(ZeroDivisionError, "", twin.run_until, lambda: 1 / 0, HOST_TIMEOUT_S)
        assert not pacer._advanced and not twin.run_until(lambda: False, 0.01)


def test_a_bench_of_the_user():
    bench = axistwin.Bench()
    bench.add("smartmotor", "axis")
    with (
        axistwin.serve(bench, speed="manual") as twin,
        serial.serial_for_url(twin.ports["axis"], timeout=HOST_TIMEOUT_S) as host,
    ):
        twin.advance(1)
        assert twin.call(ask, host, b"RP\r") == b"0\r"
        host.write(b"UCI UDI ZS MP A=500 V=500000 P=20000 G ")
        shaft = twin.bench["axis"].axes["shaft"]
        assert twin.run_until(lambda: shaft.position >= 10_000, 10)
        assert 10_000 <= shaft.position < 10_200  # at the exact sample
        assert not twin.run_until(lambda: shaft.position < 0, 0.1)


def test_the_end_closes_ports_and_threads():
    before = threading.active_count()
    with axistwin.serve("if1", speed="manual") as twin:
        port = twin.ports["if1"]
    assert threading.active_count() == before
    raises(ConnectionRefusedError, "", socket.create_connection, (port.host, port.port), HOST_TIMEOUT_S)


def test_a_bug_in_the_bench_is_raised(twin):
    def bug():
        raise ZeroDivisionError

    raises(ZeroDivisionError, "", twin.do, bug)


@pytest.mark.parametrize(("what", "options", "words"), [
    ({"controller": [{"model": "if9"}]}, {}, "no model 'if9'"),
    ({"controller": [{"model": object()}]}, {}, "is not allowed in a scene"), ("if9", {}, "no model 'if9'"),
    ("if1", {"scheme": "udp"}, "invalid kind of port 'udp': expected one of tcp, rfc2217, pty"),
    ("if1", {"fixed_ports": True}, "expected a scene that defines ports"),
    ({"controller": [{"model": "if1"}]}, {"fixed_ports": True}, "expected a scene that defines ports"),
    ("if1", {"speed": "fast"}, r"invalid speed 'fast': expected a number, \"max\" or \"manual\", e\.g\. 1\.0$")
])  # fmt: skip
def test_invalid_arguments_of_serve(what, options, words):
    with pytest.raises(axistwin.AxistwinError, match=words) as raised:
        axistwin.serve(what, **options)
    assert isinstance(raised.value, UsageError) or not options


def test_invalid_times_are_refused(twin):
    for seconds in (float("nan"), float("inf"), -1):
        raises(UsageError, "cannot advance virtual time by", twin.advance, seconds)
        if seconds != -1:
            raises(UsageError, "invalid timeout", twin.run_until, lambda: False, seconds)


def test_time_cannot_be_advanced_inside_the_bench(twin):
    raises(UsageError, "cannot advance virtual time in a callback", twin.do, lambda: twin.advance(1))


def test_a_closed_twin_refuses_calls():
    with axistwin.serve("if1", speed="manual") as twin:
        pass
    raises(UsageError, "the controllers are closed", twin.advance, 1)


@pytest.mark.parametrize("use", [
    lambda twin: twin.clock, lambda twin: twin.advance(1), lambda twin: twin.do(int), lambda twin: twin.call(int)
])  # fmt: skip
def test_a_twin_outside_its_block_refuses_calls(use):
    raises(UsageError, "are not open: use a `with` block", use, axistwin.serve("if1", speed="manual"))


@pytest.mark.parametrize(("changed", "words"), [
    ({"nmae": "left"}, r"the scene, controller\[1\]\.nmae: unknown key 'nmae': did you mean 'name'\?"),
    ({"axes": {"X": {"limits": [5, 0]}}},
     r"the scene, controller\[1\]\.axes\.X\.limits: .*expected the lower position"),
    ({"ports": ["tcp:nowhere"]}, r"the scene, controller\[1\]\.ports\[0\]: invalid address")])  # fmt: skip
def test_errors_of_a_scene_in_a_dict_have_their_keys(changed, words):
    with pytest.raises(axistwin.AxistwinError, match=f"^{words}"):
        axistwin.serve({"controller": [{"model": "1811"}, {"model": "if1", **changed}]})


@pytest.fixture
def resting():
    """Return an idle bench with a stopped wall clock, and a function that advances the wall clock by 5 s."""
    with axistwin.serve(axistwin.Bench(), speed=1.0) as twin:
        loop, pacer = twin._service.loop._loop, twin._service.server.pacer
        wall_s = loop.time()

        def set_clock(seconds):
            loop.time = lambda: wall_s + seconds

        twin.do(lambda: (set_clock(0), setattr(pacer, "speed", 1.0)))
        yield twin, lambda: set_clock(5)
        del loop.time


def test_an_action_on_an_idle_bench_has_the_present_time(resting):
    twin, five_seconds_later = resting
    began_ns = twin.do(lambda: twin.bench.now)
    five_seconds_later()
    assert twin.do(lambda: twin.bench.now) == began_ns + 5_000_000_000


def test_the_clock_of_an_idle_bench_runs(resting):
    twin, five_seconds_later = resting
    began_ns = twin.clock.now
    five_seconds_later()
    assert twin.clock.now == began_ns + 5_000_000_000 and twin.clock.seconds == twin.bench.seconds


def test_threads_advance_time_one_after_the_other(twin):
    threads = [threading.Thread(target=twin.advance, args=(0.25,)) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(HOST_TIMEOUT_S)
    assert twin.clock.now == 2_000_000_000


def test_a_host_cannot_advance_time(twin):
    raises(UsageError, "cannot call advance in a host program", twin.call, twin.advance, 1)


def test_a_sleep_of_a_host_takes_virtual_time(twin, host):
    """A move of 4000 pulses at 2000/s, with ramps, is in progress after a sleep of 0.2 s, and has ended after 5 s."""

    def drive():
        time.sleep(1.5)
        answers = [ask(host, b"("), host.write(b"U61\r")]
        time.sleep(1.2)
        host.write(b"X4000@2000$\r")
        time.sleep(0.2)
        answers.append(ask(host, b"E\r"))
        time.sleep(5)
        return [*answers, ask(host, b"E\r")]

    assert twin.call(drive) == [b"U\r", 4, b"E\r", b"C\r"]
    assert 7.9e9 < twin.clock.now < 8e9  # 1.5 + 1.2 + 0.2 + 5 s, and the characters
    assert time.sleep is SLEEP


def test_a_sleep_begins_when_time_stands_still(twin, host, monkeypatch):
    """A host that sleeps as soon as it has U is not earlier than one that is slow.

    U has come after 1.502083334 s, CR 11 bits later at 9600 baud, and time stops 3 ms after the last character.
    """
    deliver, has_read = ManualPacer._deliver, threading.Event()

    def deliver_to_a_fast_host(pacer):
        delivered = deliver(pacer)
        if delivered and has_read.wait(HOST_TIMEOUT_S):
            while not all(each.blocked() for each in host_thread._hosts.values()):
                pass
        return delivered

    def drive():
        time.sleep(1.5)
        host.write(b"(")
        assert host.read(1) == b"U"
        has_read.set()
        time.sleep(1)

    monkeypatch.setattr(ManualPacer, "_deliver", deliver_to_a_fast_host)
    twin.call(drive)
    assert twin.clock.now == 1_502_083_334 + 1_145_833 + 3_000_000 + S


def test_two_hosts_sleep_side_by_side(twin):
    order = []

    def nap(name, seconds):
        for _ in range(2):
            time.sleep(seconds)
            order.append((name, twin.clock.now))

    short, long = twin.start(nap, "short", 1), twin.start(nap, "long", 1.5)
    twin.advance(1.25)
    assert order == [("short", S)]
    long.result()
    assert short.result() is None
    assert order == [("short", S), ("long", 1.5 * S), ("short", 2 * S), ("long", 3 * S)]


def test_a_host_that_only_sleeps_is_told(twin):
    def poll():
        while True:
            time.sleep(0.5)

    raises(LinkError, "neither sent nor received data for 10 s", twin.call, poll)
    assert twin.clock.now == 11 * S


def test_one_long_sleep_is_not_silence(twin):
    twin.call(lambda: time.sleep(100))
    assert twin.clock.now == 100 * S


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="only Linux reports where a thread waits")
def test_a_sleep_by_the_wall_clock_is_told(twin):
    def sleep_until_told():
        while not told.list:
            SLEEP(1)

    with pytest.warns(UserWarning, match="sleeps by the wall clock, and virtual time has advanced by 10 s") as told:
        twin.call(sleep_until_told)


def test_an_exception_says_that_virtual_time_stood_still():
    def test():
        with axistwin.serve("if1", speed="manual") as twin:
            twin.advance(1.5)
            with serial.serial_for_url(twin.ports["if1"], timeout=0) as host:
                host.write(b"(")
                assert host.read(2) == b"U\r"

    with pytest.raises(AssertionError) as raised:
        test()
    assert ["twin.call" in note for note in raised.value.__notes__] == [True]


@pytest.mark.parametrize(("then_s", "told"), [(0, [True]), (0.1, [])])
def test_a_board_on_a_bus_has_the_note_too(then_s, told):
    def test():
        with axistwin.serve("1811", speed="manual") as twin:
            twin.advance(1)
            url = twin.ports["1811"]
            with socket.create_connection((url.host, url.port), timeout=10) as host, host.makefile() as answers:
                host.sendall(b"w 0 83\nw 1 10\nr 1\n")  # request the position, and ask for the status
                assert [next(answers) for _ in range(2)] == ["ok\n", "ok\n"]
                status = next(answers)  # without bit 3: no message is ready
                twin.advance(then_s)
                assert int(status, 16) & 0x08

    with pytest.raises(AssertionError) as raised:
        test()
    assert ["twin.call" in note for note in getattr(raised.value, "__notes__", [])] == told


def test_a_motor_says_once_why_it_does_not_move():
    """`axistwin serve` logs what `subscribe_hint` reports."""
    bench = axistwin.Bench()
    motor, told = bench.add("smartmotor"), []
    motor.subscribe_hint(told.append)
    bench.run(1)
    assert told == []
    motor.serial.write(b"A=100 V=100000 P=4000 G G ")
    bench.run(1)
    assert told == [motor.hint] and motor.hint.startswith("in a limit fault, as pins C and D are not held low")


def test_refused_lines_are_logged_and_bytes_are_as_before(caplog):
    with axistwin.serve("if1", speed="manual", line="instant") as twin:
        twin.advance(1.5)
        with serial.serial_for_url(twin.ports["if1"], timeout=5) as host:
            for text in (b"(", b"U61\r", b"x1", b"\r", b"x1\rF\r"):
                host.write(text)
                twin.advance(2)
            assert host.read(4) == b"U\r8\r"
        assert [record.name for record in caplog.records] == ["axistwin"]
    assert [record.getMessage().partition(": commands")[0] for record in caplog.records] == [
        "if1: refused x1: unknown character 'x'",
        "if1: refused x1 (the same once more)",
    ]
