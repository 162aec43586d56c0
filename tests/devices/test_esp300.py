"""The ESP300-like controller of `examples/devices`: a count is 0.001 mm, 10 mm/s, 40 mm/s²; a ramp takes 0.25 s."""

import pytest

import axistwin
from axistwin.core.units import S
from axistwin.devices.making import product_of
from axistwin.testing import device_checks

from .made import ask, client, example, on_a_bench

Esp300 = example("esp300", "Esp300")
UNKNOWN = pytest.mark.filterwarnings("ignore:It is not known whether this device support SCPI:FutureWarning")


@pytest.fixture
def made():
    bench, controller = on_a_bench(Esp300, **{"1": {"limits": (-20_000, 20_000), "home": (4000, 5000)}})
    assert ask(bench, controller, b"1MO;2MO\r") == b""
    return bench, controller


def moved(made, line):
    """Return the pulses of axis 1 and the seconds from the line to the last of them."""
    bench, controller = made
    began = bench.now
    assert ask(bench, controller, line, 10) == b""
    times = controller.axes["1"].pulse_times(began)
    return len(times), (times[-1] - began) / S


@pytest.mark.parametrize(("line", "pulses", "seconds", "position"), [
    (b"1PA12.5\r", 12_500, 1.5, b"12.5000"),                   # 12.5/10 + 10/40
    (b"1PR-2.5\r", 2500, 0.5, b"-2.5000"),                     # the ramps meet: 2 · 10/40
    (b"1PA-0.625\r", 625, 0.25, b"-0.6250"),                   # to √(0.625 · 40) = 5 mm/s: 2 · 5/40
    (b"1VA5;1PA10\r", 10_000, 2.125, b"10.0000"),              # 10/5 + 5/40
    (b"1AG80;1PA10\r", 10_000, 1.1875, b"10.0000"),            # ramps of 1.25 in 0.25 s, 0.625 in 0.125 s; 8.125/10
    (b"1PR1;1PR1.5\r", 2500, 0.5, b"2.5000"),                  # from the target, in motion
    (b"1MV+;WT1000;1ST\r", 10_000, 1.25, b"10.0000"),          # 8.75 in 1 s, and the ramp
    (b"1MV-;WT1000;AB\r", 8750, 1.0, b"-8.7500"),              # without a ramp
    (b"1MV+;WT1000;1MF\r", 8750, 1.0, b"8.7500"),
    (b"1SU0.0005;1PA5\r", 10_000, 0.75, b"5.0000"),            # twice as many counts: 5/10 + 10/40
    (b"1PA5;1WS;1PA0\r", 10_000, 1.5, b"0.0000"),
    (b"1PA5;1WS250;1PA0\r", 10_000, 1.75, b"0.0000"),
])  # fmt: skip
def test_moves(made, line, pulses, seconds, position):
    assert moved(made, line) == (pulses, pytest.approx(seconds, abs=5e-9))
    assert ask(*made, b"1TP;1TP?;1DP?;1PA?;1TV?;TE?\r") == b"\r\n".join([position] * 4 + [b"0.0000", b"0", b""])


def test_positions_in_motion(made):
    bench, controller = made
    ask(bench, controller, b"1PA12.5\r", 0.5)
    assert ask(bench, controller, b"1TP?;1TV?;1MD?;1MO?;TS?\r", 0) == b"3.7500\r\n10.0000\r\n0\r\n1\r\nQ\r\n"


def test_the_status_byte(made):
    assert [ask(*made, line) for line in (b"TS\r", b"2MV+;TS\r", b"AB;1MF;TS\r", b"2MF;TS?\r")] == [
        b"P\r\n", b"R\r\n", b"P\r\n", b"@\r\n",
    ]  # fmt: skip


@pytest.mark.parametrize(("line", "code", "words"), [
    (b"1XX5", 6, "COMMAND DOES NOT EXIST"),
    (b"hello", 6, "COMMAND DOES NOT EXIST"),
    (b"\xff\x00", 6, "COMMAND DOES NOT EXIST"),
    (b"PA5", 37, "AXIS NUMBER MISSING"),
    (b"4PA5", 9, "AXIS NUMBER OUT OF RANGE"),
    (b"1PA", 38, "COMMAND PARAMETER MISSING"),
    (b"1PA5x", 7, "PARAMETER OUT OF RANGE"),
    (b"1PA1e400", 7, "PARAMETER OUT OF RANGE"),
    (b"1OR9", 7, "PARAMETER OUT OF RANGE"),
    (b"1SN12", 101, "AXIS-1 PARAMETER OUT OF RANGE"),
    (b"2VA0", 201, "AXIS-2 PARAMETER OUT OF RANGE"),
    (b"1VA21", 110, "AXIS-1 MAXIMUM VELOCITY EXCEEDED"),
    (b"1AC101", 111, "AXIS-1 MAXIMUM ACCELERATION EXCEEDED"),
    (b"1PA50.001", 106, "AXIS-1 POSITIVE SOFTWARE LIMIT DETECTED"),
    (b"1PR-50.001", 107, "AXIS-1 NEGATIVE SOFTWARE LIMIT DETECTED"),
    (b"3PA5", 313, "AXIS-3 MOTOR NOT ENABLED"),
    (b"3OR", 313, "AXIS-3 MOTOR NOT ENABLED"),
])  # fmt: skip
def test_errors(made, line, code, words):
    bench, controller = made
    assert ask(bench, controller, line + b"\r", 0.99) == b""  # 2 s after power-on: 5000 cycles of 0.4 ms
    now = round((bench.seconds - 0.99) / 0.0004)
    assert ask(bench, controller, b"TB?;TB?\r").split(b"\r\n") == [
        f"{code}, {now}, {words}".encode(), b"0, 5000, NO ERROR DETECTED", b"",
    ]  # fmt: skip
    assert not any(axis.velocity or axis.position for axis in controller.axes.values())


def test_the_rest_of_a_line_goes_on_after_an_error(made):
    assert ask(*made, b"1XX;1VA7;4TP?;1VA?\r") == b"7\r\n"


def test_blanks_and_line_feeds_are_ignored(made):
    assert ask(*made, b" 1 VA 7 ; 1VA?\r\n1VA ?\r\n") == b"7\r\n7\r\n"


def test_the_last_ten_errors_are_kept(made):
    ask(*made, b"PA;" * 3 + b"1XX;" * 9 + b"\r")
    assert ask(*made, b"TE?;" * 11 + b"\r") == b"37\r\n" + b"6\r\n" * 9 + b"0\r\n"


def test_a_limit_switch(made):
    assert moved(made, b"1PA30\r")[0] == 20_001  # the switch opens beyond 20,000
    assert ask(*made, b"1TP?;1MD?;TB?\r").startswith(b"20.0010\r\n1\r\n104, ")
    assert ask(*made, b"1PA31;TE?;1PA0\r", 5) == b"104\r\n"  # and moves away from it
    assert ask(*made, b"1TP?;TE?\r") == b"0.0000\r\n0\r\n"


@pytest.mark.parametrize(("line", "place"), [
    (b"1OR0\r", 0), (b"1DH2;1OR0\r", -2000),
    (b"1OR2\r", 3999), (b"1OR\r", 3999),         # in plus direction to the switch, and slowly off it
    (b"1OR3\r", 20_001), (b"1OR4\r", -20_001),
])  # fmt: skip
def test_searches_for_home(made, line, place):
    ask(*made, line, 20)
    assert made[1].axes["1"].position == place
    assert ask(*made, b"1TP?;1MD?;TE?\r") == b"0.0000\r\n1\r\n0\r\n"


def test_a_search_that_meets_a_limit(made):
    ask(*made, b"1PA10\r", 5)
    ask(*made, b"1OR\r", 20)  # the home switch lies behind
    assert ask(*made, b"TE?;TE?;TE?;1TP?\r") == b"104\r\n120\r\n0\r\n20.0010\r\n"


def test_what_is_stored_survives_a_loss_of_power(made):
    bench, controller = made
    ask(bench, controller, b"1VA5;1SN3;SM;1AC30\r")
    controller.power_cycle()
    bench.run(1)
    assert ask(bench, controller, b"1VA?;1SN?;1AC?;1MO?;2VA?\r") == b"5\r\n3\r\n40\r\n0\r\n10\r\n"


@pytest.mark.parametrize("check", device_checks(Esp300))
def test_it_keeps_what_every_device_must(check):
    check()


# The driver of PyMeasure, over TCP


@pytest.fixture
def twin():
    bench = axistwin.Bench()
    bench.add(product_of(Esp300), "esp300")
    with axistwin.serve(bench, speed="manual") as twin:
        twin.advance(1)
        yield twin


@pytest.fixture
def host(twin):
    driver = client("pymeasure.instruments.newport")
    host = driver.ESP300(twin.ports["esp300"].visa, visa_library="@py", read_termination="\r\n", timeout=10_000)
    yield host
    host.adapter.close()


@UNKNOWN
def test_a_session_of_pymeasure(twin, host):
    def work():
        host.clear_errors()
        host.x.enable()  # `host.enable()` also asks `*OPC?`, which no ESP300 answers
        host.y.enable()
        host.x.define_position(-2.5)
        host.y.units = "micrometer"
        assert (host.x.enabled, host.x.units, host.y.units) == (True, "millimeter", "micrometer")
        host.x.left_limit, host.x.right_limit = -5, 20
        began = twin.clock.seconds
        host.x.position, host.y.position = 10, -1.25
        assert not host.x.motion_done
        host.x.wait_for_stop()
        took = twin.clock.seconds - began
        assert (host.x.position, host.y.position, host.x.motion_done) == (10, -1.25, True)
        host.x.zero()
        assert (host.x.position, host.x.left_limit, host.x.right_limit) == (0, -5, 20)
        host.x.disable()
        return took

    took = twin.call(work)
    assert 1.5 < took < 1.55  # 12.5/10 + 10/40, and the characters
    axes = twin.bench["esp300"].axes.values()
    assert [(axis.position, len(axis.pulse_times())) for axis in axes] == [(12_500, 12_500), (-1250, 1250), (0, 0)]


@UNKNOWN
def test_errors_by_pymeasure(twin, host):
    def work():
        host.x.position = 5
        host.x.enable()
        host.x.position = 51
        host.write("1FOO")
        return [str(error) for error in host.errors], host.x.enabled, host.y.enabled

    assert twin.call(work) == (
        [
            "Newport ESP300 axis 1 reported the error: MOTOR NOT ENABLED",
            "Newport ESP300 axis 1 reported the error: POSITIVE SOFTWARE LIMIT DETECTED",
            "Newport ESP300 reported the error: COMMAND DOES NOT EXIST",
        ],
        True, False,
    )  # fmt: skip
