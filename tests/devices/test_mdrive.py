"""The MDrive-like party line of `examples/devices`; here ramps from 10,000 to 20,000 steps/s take 0.1 s, 1500 steps."""

import pytest

import axistwin
from axistwin.core.units import S
from axistwin.devices.making import product_of
from axistwin.drivers import TextDriver
from axistwin.testing import device_checks

from .made import ask, client, example, on_a_bench

MDrive = example("mdrive", "MDrive")
RAMPS = b"XEM=1\nXVI=10000\nXVM=20000\nXA=100000\nXD=100000\n"


def line(**options):
    made = on_a_bench(MDrive, **options)
    assert ask(*made, RAMPS) == b"\r\n" * 5
    return made


@pytest.fixture
def made():
    return line(X={"limits": (-30_000, 60_000), "home": (-20_000, -10_000)})


def moved(made, text, seconds=5):
    """Return the pulses of X and the time from the line to the last of them."""
    bench, controller = made
    began = bench.now
    assert ask(bench, controller, text, seconds) == b"\r\n"
    times = controller.axes["X"].pulse_times(began)
    return len(times), (times[-1] - began) / S


@pytest.mark.parametrize(("before", "text", "pulses", "seconds"), [
    (b"", b"XMA 23000\n", 23_000, 1.2),                    # 1500 + 20,000 + 1500 in 0.1 + 1 + 0.1 s
    (b"", b"XMR -3000\n", 3000, 0.2),                      # the ramps meet
    (b"XD=50000\n", b"xma 24500\r\n", 24_500, 1.3),        # down 3000 in 0.2 s
    (b"XVA Q=11500\n", b"XMR Q + Q\n", 23_000, 1.2),
    (b"XR1=-9000\n", b"XMA R1 - 14000\n", 23_000, 1.2),
])  # fmt: skip
def test_moves(made, before, text, pulses, seconds):
    ask(*made, before)
    assert moved(made, text) == (pulses, pytest.approx(seconds, abs=5e-9))


def test_escape_stops_at_once_and_with_a_ramp(made):
    bench, controller = made
    ask(bench, controller, b"XSL 20000\nYSL -1000\n", 1.1)
    assert ask(bench, controller, b"XM\x1b", 1) == b"\r\n"
    assert [controller.axes[name].position for name in "XYZ"] == [23_000, -1100, 0]
    assert ask(bench, controller, b"XPR P\n") == b"23000\r\n"


def test_what_is_read_in_motion(made):
    bench, controller = made
    ask(bench, controller, b"XMA 23000\n", 0.05)
    # after 0.05 s: 10,000 · 0.05 + 100,000 · 0.05²/2
    assert ask(bench, controller, b'XPR P," "MV," "VC\n', 0.55) == b"625 1 1\r\n"
    assert ask(bench, controller, b'xpr P,"_"V,"_"MV,"_"VC,"_"EF\n', 5) == b"11500_20000_1_0_0\r\n"
    assert ask(bench, controller, b'XPR P,V,MV,VC\nXPR "P=",P," I",S1\n') == b"23000000\r\nP=23000 I1, 1, 0\r\n"


@pytest.mark.parametrize(("text", "code"), [
    (b"XFOO", 20), (b"X\xff", 20), (b"XMA", 20), (b"XQ9=3", 20),
    (b"XEM=4", 21), (b"XA=90", 21), (b"XVM=5000001", 21),
    (b"XVI=20000", 22), (b"XVM=10000", 23), (b"XMA 1 + ?", 24), (b"XMA 1.5", 24), (b"XR1=", 24),
    (b"XV=3", 25), (b"XS1=3", 25), (b"XPY=0", 25), (b"XPY 0", 25),
    (b"XVA P=3", 29), (b"XVA F1=3", 29), (b"XVA LONG=1", 29), (b"XMA Q9", 30), (b"XPR Q9", 30), (b"XEX Q9", 30),
])  # fmt: skip
def test_errors(made, text, code):
    assert ask(*made, text + b"\n") == b"?\r\n"
    assert ask(*made, b'XPR ER," "EF\nYPR ER\n') == f"{code} 1\r\nYPR ER\r\n0\r\n>".encode()
    assert ask(*made, b"XEX F1\nXPR ER\n") == b"\r\n0\r\n"
    assert made[1].axes["X"].position == 0


def test_echo_modes(made):
    bench, controller = made
    assert ask(bench, controller, b"YR1=5\nYPR R1\nYFOO\nY\n") == b"YR1=5\r\n>YPR R1\r\n5\r\n>YFOO\r\n?Y\r\n>"
    assert ask(bench, controller, b"XR1=5\nXPR R1\nXFOO\nX\n") == b"\r\n5\r\n?\r\n\r\n"
    assert ask(bench, controller, b"ZEM 3\nZPR R1\nZFOO\nZ\n") == b"ZEM 3\r\nZPR R1\r\n0\r\nZFOO\r\n?\r\nZ\r\n"
    assert ask(bench, controller, b"ZEM 2\nZR1=5\nZPR R1\nZFOO\nZ\n") == b"5\r\n"
    assert ask(bench, controller, b"W\nWPR P\nPR P\n\x00\n") == b"", "for other motors"


def test_limit_switches(made):
    assert moved(made, b"XMA 80000\n")[0] == 60_001
    assert ask(*made, b'XPR P," "ER\n') == b"60001 83\r\n"
    assert ask(*made, b"XMA 90000\n", 1) == b"\r\n" and made[1].axes["X"].position == 60_001
    assert moved(made, b"XMA -80000\n", 9)[0] == 90_002
    assert ask(*made, b'XPR P," "ER\n') == b"-30001 84\r\n"


def test_the_search_for_home_of_the_program(made):
    ask(*made, b"XEX F2\n", 20)
    # left the switch at -9999, and went C0 = 51,200 away from it
    assert made[1].axes["X"].position == 41_201
    assert ask(*made, b'XPR P," "MV," "ER\n') == b"0 0 0\r\n"


@pytest.mark.parametrize(("program", "pulses", "seconds"), [
    # A line takes 1 ms, a move of 3000 steps 200 ms: the moves begin after 4, 4 + 204 and 4 + 408 ms.
    ("LB GO; R1 = 0; LB LP; MR 3000; H; R1 = R1 + 1; BR LP, R1 < 3; E", 9000, 0.612),
    ("LB GO; CL SB; CL SB; E; LB SB; MR 3000; H; RT", 6000, 0.408),
    ("LB GO; MR 3000; H 500; MR 3000; RT; MR 3000", 6000, 0.704),
    ("LB GO; BR NO, 1 > 2; MR 3000; E; LB NO; MR 100", 3000, 0.203),
    ("LB SU; VA D0 = 3000; E; LB GO; MR D0", 3000, 0.202),
])  # fmt: skip
def test_programs(program, pulses, seconds):
    assert moved(line(program=program), b"XEX GO\n") == (pulses, pytest.approx(seconds, abs=5e-9))


@pytest.mark.parametrize("wrong", ["BR NO", "VA", "H x", "R9 = 1", "MR", "HM = 1", "MA 1 ? 2", "RT", "=", "what"])
def test_programs_that_are_wrong(wrong):
    bench, controller = made = line(program=f"LB GO; {wrong}; MR 3000")
    ask(bench, controller, b"XEX GO\n", 1)
    assert controller.axes["X"].position == (0 if wrong == "RT" else 3000)
    assert ask(*made, b"XPR ER\n") == (
        b"0\r\n" if wrong in ("RT", "what") else b"20\r\n" if wrong[-1] == "1" else b"24\r\n"
    )


def test_a_program_without_an_end_ends_by_escape_and_by_another():
    bench, controller = line(program="LB GO; MR 3000; H; BR GO; LB F1; SL 0; H")
    ask(bench, controller, b"XEX GO\n", 10)
    ask(bench, controller, b"\x1b", 1)
    assert not controller.axes["X"].velocity
    ask(bench, controller, b"*EX GO\n", 10)
    assert ask(bench, controller, b"*EX F1\n", 1) == b""
    assert not any(axis.velocity for axis in controller.axes.values())


def test_what_is_stored_survives_a_loss_of_power(made):
    bench, controller = made
    assert ask(bench, controller, b"XS\nXVM=30000\nYVM=30000\n", 0.49) == b"\r\nYVM=30000\r\n>"
    assert ask(bench, controller, b"") == b"\r\n"
    controller.power_cycle()
    bench.run(1)
    assert ask(bench, controller, b"XPR VM\nXPR UV\nYPR VM\n") == (
        b"20000\r\nCT = G 0\r\nC0 = G 51200\r\nSU = 100\r\nF1 = 104\r\nF2 = 108\r\n\r\nYPR VM\r\n768000\r\n>"
    )


class Driven(MDrive):
    """The motors with what a host sends them; in echo mode 2 only PR is answered."""

    driver = TextDriver(
        move="{axis}EM 2\n{axis}MA {position}", stop="{axis}EM 2\n{axis}SL 0",
        position="{axis}EM 2\n{axis}PR P", busy="{axis}EM 2\n{axis}PR MV", at_rest=0,
    )  # fmt: skip


@pytest.mark.parametrize("check", device_checks(Driven))
def test_it_keeps_what_every_device_must(check):
    check()


# The driver of dvg-devices, over a serial port


@pytest.fixture
def twin():
    pytest.importorskip("termios", reason="no pseudo-terminals on Windows")
    bench = axistwin.Bench()
    bench.add(product_of(MDrive), "motors", Y={"home": (-3000, -2000)})
    with axistwin.serve(bench, speed="manual", scheme="pty") as twin:
        twin.advance(1)
        yield twin


@pytest.fixture
def host(twin):
    host = client("dvg_devices.MDrive_stepper_protocol_RS422").MDrive_Controller()
    host.serial_settings["timeout"] = 10  # the 0.1 s of the driver are real seconds, also on a busy computer
    assert twin.call(host.connect_at_port, twin.ports["motors"])
    twin.call(host.begin, "xyz")
    yield host
    twin.call(host.close)


def until_done(motor):
    while motor.state.is_moving:
        motor.query_is_moving()
    motor.query_state()
    motor.query_errors()
    return motor.state.position, motor.state.has_error


def test_what_the_driver_finds(host):
    assert [motor.device_name for motor in host.motors] == ["x", "y", "z"]
    for motor in host.motors:
        config = motor.config
        assert (config.user_variables, config.calibration_constant) == ({"CT": 0, "C0": 51_200}, 51_200)
        assert (config.user_subroutines, config.IO_S2) == ({"SU": 100, "F1": 104, "F2": 108}, "2, 1, 0")
        assert (config.motion_A, config.motion_D, config.motion_VI, config.motion_VM) == (10**6, 10**6, 1000, 768_000)
        assert (config.motion_HC, config.motion_RC, config.motion_LM, config.motion_MS) == (5, 25, 1, 256)


def test_moves_by_the_driver(twin, host):
    x, y, _ = host.motors

    def work():
        assert x.move_absolute_mm(20) and y.move_relative_steps(-1000)
        assert (x.state.is_moving, y.state.is_moving) == (True, True)
        return until_done(x), until_done(y)

    assert twin.call(work) == ((1_024_000, False), (-1000, False))
    axes = twin.bench["motors"].axes
    assert [len(axes[name].pulse_times()) for name in "XYZ"] == [1_024_000, 1000, 0]
    times = axes["X"].pulse_times()
    # ramps of 0.767 s and 294,911.5 steps, 434,177 steps at 768,000/s; the first 4 ms have 3000/s
    assert (times[-1] - times[0]) / S == pytest.approx(2 * 0.767 + 434_177 / 768_000 - 1 / 3000, abs=1e-6)


def test_a_slew_and_its_stops(twin, host):
    x, y, _ = host.motors

    def work():
        x.slew_mm_per_sec(2)
        y.slew_steps_per_sec(-5000)
        x.query_state()
        changing = x.state.is_velocity_changing
        while x.state.is_velocity_changing:
            x.query_state()
        assert (changing, x.state.velocity, x.state.is_moving) == (True, 102_400, True)
        x.controlled_stop()
        until_done(x)
        assert y.state.is_moving
        host.STOP()
        until_done(y)
        host.RESET()
        return x.state.is_moving, y.state.is_moving

    assert twin.call(work) == (False, False)
    assert not any(axis.velocity for axis in twin.bench["motors"].axes.values())


def test_home_and_errors_by_the_driver(twin, host):
    _, y, _ = host.motors

    def work():
        assert y.home()
        at_home = until_done(y)
        y.query("foo")
        y.query_errors()
        wrong = y.state.has_error, y.state.error, y.state.is_home_known
        y.init_interface()
        return at_home, wrong, y.state.has_error, y.save_to_NVM()

    assert twin.call(work) == ((0, False), (True, 20, False), False, True)
    assert twin.bench["motors"].axes["Y"].position == 51_200 - 1999
