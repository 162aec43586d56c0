"""The public interface of a bench."""

import pytest

import axistwin
from axistwin import AxistwinError, Bench
from axistwin.core.errors import UsageError
from axistwin.records.traces.signals import catalogue


def test_the_example_of_the_package():
    bench = Bench()
    if1 = bench.add("if1")
    bench.run(1.5)
    if1.serial.write(b"(")
    bench.run(0.1)
    assert if1.serial.read() == b"U\r" and if1.serial.read() == b""


def test_time_is_nanoseconds_inside_and_seconds_outside():
    bench = Bench()
    assert (bench.now, bench.seconds) == (0, 0.0)
    bench.run(0.1)
    bench.run(0.2)
    assert (bench.now, bench.seconds) == (300_000_000, 0.3) and type(bench.now) is int


def test_running_no_time_is_allowed_and_backwards_is_not():
    bench = Bench()
    bench.run(0)
    with pytest.raises(UsageError, match="negative time"):
        bench.run(-1)


YEARS_291 = 291 * 365 * 86_400


def test_virtual_time_ends_before_64_bits_of_nanoseconds_do():
    """2^63 ns are 9,223,372,036.85 s; a run that would end later, alone or after others, is refused without effect."""
    bench = Bench()
    bench.run(YEARS_291)
    now_ns = bench.now
    for late in (
        lambda: bench.run(YEARS_291),
        lambda: bench.run_until(lambda: False, YEARS_291),
        lambda: bench.clock.run_to(1 << 63),
    ):
        with pytest.raises(UsageError, match=r"the virtual time is too large: expected less than 9\.22e9 s"):
            late()
        assert bench.now == now_ns
    bench.clock.run_to((1 << 63) - 1)
    assert bench.now == (1 << 63) - 1


@pytest.mark.parametrize("seconds", [1e10, float("inf"), float("nan"), 10**400])
def test_a_time_that_no_bench_will_ever_see_is_refused(seconds):
    for late in (lambda: Bench().run(seconds), lambda: Bench().run_until(lambda: False, seconds)):
        with pytest.raises(UsageError, match="is too long: expected less than 292 years"):
            late()


def test_a_condition_that_raises_leaves_nothing_behind():
    bench = Bench()
    bench.add("if1")

    def raises():
        raise ZeroDivisionError

    waiting = len(bench.clock._queue)
    with pytest.raises(ZeroDivisionError):
        bench.run_until(raises, 1)
    bench.clock.call_later(5, raises)
    with pytest.raises(ZeroDivisionError):
        bench.clock.run_to(10)
    assert len(bench.clock._queue) == waiting


def test_run_until_stops_at_the_event_that_makes_it_true():
    bench = Bench()
    if1 = bench.add("if1")
    assert bench.run_until(lambda: not if1.pins["led"].level, timeout=5)
    assert bench.now == 1_000_000_000  # the LED is on for one second


def test_run_until_gives_up_at_its_timeout():
    bench = Bench()
    bench.add("if1")
    assert not bench.run_until(lambda: False, timeout=0.5) and bench.seconds == 0.5


def test_controllers_have_names_and_a_free_one_is_found():
    bench = Bench()
    first, second, third = bench.add("if1"), bench.add("if1"), bench.add("IF2", name="drill")
    assert [first.name, second.name, third.name] == ["if1", "if1-2", "drill"] and bench["drill"] is third
    with pytest.raises(UsageError, match="the name 'drill' is in use by a controller"):
        bench.add("if1", name="drill")


@pytest.mark.parametrize(("call", "message"), [
    ({"model": "if3"}, "no model 'if3': expected one of if1, if2"),
    ({"model": "fi1"}, "expected one of if1, if2, 1810, 1811, smartmotor; did you mean 'if1'?"),
    ({"model": "Smart-Motr"}, "did you mean 'smartmotor'?"),
    ({"model": 1811}, "no model 1811: expected one of if1, if2, 1810, 1811, smartmotor; did you mean '1811'?"),
    ({"model": "if1", "name": 5}, "invalid name 5: expected letters, digits, _ and -, e.g. table"),
    ({"model": "if2", "name": "../a", "state": "b"}, "invalid name '../a': expected letters, digits, _ and -"),
    ({"model": "if2", "state": 5}, "invalid state=5: expected a directory, e.g. './state'"),
    ({"model": "if2", "state": "x" * 300}, "(file name too long): choose another directory"),
    ({"model": "if1", "history": 10**30}, "invalid option history: a whole number has more than 64 bits: expected"),
    ({"model": "1811", "step_ms": 10**5000}, "invalid option step_ms: a whole number has more than 64 bits"),
    ({"model": "smartmotor", "shaft": {"load": {"gravity_torque_nm": 10**400}}},
     "invalid option shaft.load.gravity_torque_nm: a whole number has more than 64 bits"),
    ({"model": "if1", "strobe_ms": 1e-9}, "strobe_ms=1e-09: expected a number from 0.001 to 60"),
    ({"model": "1811", "step_ms": 1e-9}, "step_ms=1e-09: expected a number from 0.001 to 60000"),
    ({"model": "1811", "interrupts": 1e308}, "interrupts=1e+308: expected a list, e.g. ['message_ready']"),
    ({"model": "1811", "interrupts": "failed"}, "interrupts='failed': expected a list, e.g. ['message_ready']"),
    ({"model": "1811", "part_number": 5.0}, "part_number=5.0: expected 13 or 14 characters, e.g. 94-003657-01A"),
    ({"model": "if1", "X": {"encoder": {"counts": 5}}}, "unknown parameter 'counts' of the encoder: expected one"),
    ({"model": "if1", "X": {"encoder": {"backlash": 0.5}}}, "backlash=0.5 of the encoder: expected a whole number"),
    ({"model": "if1", "X": {"load": {"torque": True}}}, "invalid torque=True of the load: expected a number from"),
    ({"model": "if1", "X": {"motor": {"torque": [[float("nan"), 1]]}}}, "number nan of the torque curve"),
    ({"model": "if1", "X": {"motor": {"torque": 5}}}, "expected pairs (pulses/s, N·m), e.g. [[0, 1.2]"),
    ({"model": "if1", "speed": 1}, "if1 has no option 'speed': expected one of X, Y, Z, wiring"),
    ({"model": "if1", "X": {"limit": 1}}, "axis X has no option 'limit': expected one of limits, home"),
    ({"model": "if1", "X": {"home": (0, 1)}}, "if1 has no home input"),
    ({"model": "if1", "wiring": "7-wire"}, "expected one of '5-wire', '3-wire'"),
    ({"model": "if1", "recalculation_s": -1}, "recalculation_s=-1: expected a number from 0 to 60"),
    ({"model": "if1", "line": "9600 9N1"},
     "invalid baud rate or character format '9600 9N1': expected e.g. '9600 8N2', or 'instant'"),
    ({"model": "if1", "line": "96 8"},
     "invalid baud rate or character format '96 8': expected e.g. '9600 8N2', or 'instant'"),
    ({"model": "if1", "X": {"motor": {"pull_in": 3}}}, "the motor of axis X needs `torque`: expected pairs"),
    ({"model": "if1", "X": {"motor": {"torque": [(9, 1), (3, 1)]}}},
     "invalid option of axis X: invalid torque curve: expected pairs"),
    ({"model": "if1", "X": 5},
     "invalid value 5 for axis X: expected a table of options, e.g. X={ limits = [-100, 5000] }"),
    ({"model": "if1", "X": {"motor": 1}}, "invalid option of axis X: "),
    ({"model": "if1", "X": {"limits": "foo"}},
     "invalid limits='foo' of axis X: expected two positions, e.g. [-100, 5000]"),
    ({"model": "if1", "X": {"limits": (5, -1)}}, "invalid limits=(5, -1) of axis X: expected two positions"),
    ({"model": "if1", "X": {"limits": (0, 1, 2)}}, "invalid limits=(0, 1, 2) of axis X: expected two positions"),
    ({"model": "if1", "history": 0}, "history=0: expected a number of moves, from 2 to 1000000000"),
    (
        {"model": "if1", "X": {"encoder": {"pulses_per_rev": 0}}},
        "invalid option of axis X: invalid encoder: counts_per_rev must not be 0, pulses_per_rev must be above 0",
    )])  # fmt: skip
def test_wrong_options_are_told_in_one_line(call, message):
    with pytest.raises(AxistwinError) as caught:
        Bench().add(**call)
    assert message in str(caught.value) and "\n" not in str(caught.value)


def test_nothing_half_made_is_left_on_the_bench():
    bench = Bench()
    with pytest.raises(UsageError):
        bench.add("if1", busy="perhaps")
    assert bench.controllers == {}


def test_the_host_states_its_own_format_and_lines():
    host = Bench().add("if1", line="1200 7E1").serial.host
    assert (host.baudrate, host.bytesize, host.parity, host.stopbits) == (1200, 7, "E", 1)
    assert (host.dtr, host.rts) == (True, True)
    host.baudrate, host.dtr = 2400, False
    assert (host.baudrate, host.bytesize, host.dtr) == (2400, 7, False)


@pytest.mark.parametrize(("text", "shown", "instant"), [
    ("9600 8N2", "9600 8N2", False), ("7e1", "9600 7E1", False), ("300", "300 8N2", False),
    ("instant", "9600 8N2", True), ("1200,7O1.5,instant", "1200 7O1.5", True), ("", "9600 8N2", False)])  # fmt: skip
def test_a_line_format_is_written_in_a_few_words(text, shown, instant):
    serial = Bench().add("if1", line=text).serial
    assert (str(serial.host.format), serial.instant) == (shown, instant)


def test_the_public_names_are_these():
    names = ["AxistwinError", "Bench", "Fault", "Scene", "Session", "play", "recording", "serve", "tracing"]
    assert axistwin.__all__ == names and all(getattr(axistwin, name) for name in names)
    with pytest.raises(AttributeError, match="has no attribute 'nobody'"):
        axistwin.nobody()


def test_terminals_are_pins_and_what_a_plug_or_a_bus_has_besides():
    bench = Bench()
    for model, others in (("if1", {"dtr", "rts", "dsr", "cts"}), ("1811", {"interrupt"}), ("smartmotor", set())):
        controller = bench.add(model)
        assert controller.terminals.keys() - controller.pins.keys() == others


def test_it_is_known_whether_a_controller_is_switched_on():
    controller = Bench().add("if1")
    states = [controller.powered]
    controller.power(False)
    states.append(controller.powered)
    controller.power_cycle()
    assert [*states, controller.powered] == [True, False, True]


def test_what_changes_between_two_events_is_no_signal_of_a_trace():
    bench = Bench()
    bench.add("if1")
    names = [signal.full for signal in catalogue(bench)]
    assert "if1.K" in names and not {"if1.Q", "if1.N"} & set(names)


def test_two_runs_are_identical():
    def run():
        bench = Bench()
        if1 = bench.add("if1", X={"limits": (-10, 300)})
        bench.run(1.2)
        if1.serial.write(b"(U61\r")
        bench.run(2)
        if1.serial.write(b"X500@2000$\rK\rN\rE\r")
        bench.run(3)
        return if1.serial.read(), if1.axes["X"].pulse_times().tobytes(), bench.now

    assert run() == run()


def test_a_state_directory_that_cannot_be(bench):
    with pytest.raises(UsageError, match=r"invalid state directory 'a\\x00b': expected a path without NUL"):
        bench.add("if2", state="a\0b")
