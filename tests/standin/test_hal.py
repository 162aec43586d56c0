"""Output to LinuxCNC HAL: the component in virtual time, and in HAL itself where it is installed."""

import os
import queue
import shutil
import subprocess
import sys
import tempfile
import time
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from axistwin.real.standin.events import Failed, InputChanged, Ready, Stopped
from axistwin.real.standin.hal.board import HalBoard
from axistwin.real.standin.hal.sender import PYTHON, HalSender
from axistwin.real.standin.hal.track import SLOW_S, Track
from axistwin.real.standin.hal.wiring import HalWiring
from axistwin.real.standin.wiring import DrivenAxis, Sensed, Switched

from .hal_twin import HalTwin


@pytest.fixture
def if1():
    twin = HalTwin(line="instant")
    twin.run(1.6)
    twin.say(b"(")
    twin.say(b"U61\r", 1.3)
    return twin


def test_the_motors_make_the_pulses_of_the_controller(if1):
    if1.say(b"X+900Y-900Z @ 1500 $ \r", 1.5)
    if1.say(b"X-100 $ \r", 1.0)
    for name in "XYZ":
        axis, steps = if1.controller.axes[name], if1.steps[f"table.{name}"]
        virtual = axis.pulse_times() / 1e9
        assert len(steps) == len(virtual)
        assert if1.at(f"table.{name}") == sum(direction for _, direction in steps) == axis.position
        late = np.array([at for at, _ in steps]) - virtual
        assert np.ptp(late) < SLOW_S / 2 + 0.002, name  # two servo periods, and half the interval of slow pulses
    assert if1.pins["table.X.velocity-cmd"] == 0 and not if1.lines


def test_a_limit_stops_the_motors_and_corrects_the_controller(if1):
    if1.say(b"X2000 @ 1000 $ \r", 0.7)
    assert if1.pins["table.X.plus"] and not if1.pins["table.X.minus"]
    if1.pins["table.limit_plus"] = False
    before = if1.at()
    if1.run(1.0)
    assert 100 < if1.at() <= before + 1 and if1.controller.axes["X"].position == if1.at()
    assert if1.lines == [f"table.limit_plus stopped the motion: table.X at {if1.at():.0f}, table.Y at 0, table.Z at 0"]
    made = int(if1.at())
    assert if1.say(b"N\r") == b"%d\r" % made and if1.say(b"K\r") == b"64\r"
    if1.say(b"X-30 $ \r", 1.0)
    assert if1.at() == if1.controller.axes["X"].position == made - 30


def test_after_a_stop_the_user_must_continue(if1):
    if1.say(b"X2000 @ 1000 $ \r", 0.7)
    if1.driver.stop("stopped by the user")
    if1.run(3.0)
    made = if1.at()
    assert if1.lines == ["stopped: hal: stopped by the user"] and not if1.pins["table.X.enable"]
    if1.say(b"X100 $ \r", 1.0)
    assert if1.at() == made
    if1.driver.go_on(if1.now)
    if1.run(0.1)
    if1.say(b"X100 $ \r", 1.0)
    assert if1.at() == if1.controller.axes["X"].position == made + 100


def test_motors_stop_when_axistwin_is_late(if1):
    if1.say(b"X2000 @ 1000 $ \r", 0.7)
    if1.alive, before = False, if1.at()
    if1.run(0.3)
    assert before < if1.at() < before + 100  # less than the pulses of one horizon
    assert not if1.pins["table.X.enable"] and if1.lines == ["stopped: hal: late by 1 ms, with a horizon of 100 ms"]
    if1.alive = True
    if1.run(2.0)
    made = if1.at()
    if1.driver.go_on(if1.now)
    if1.run(0.2)
    assert if1.at() == if1.controller.axes["X"].position == made


def test_inputs_outputs_and_the_end(if1):
    if1.pins["table.input1"] = False
    if1.run(0.1)
    assert not if1.controller.pins["input1"].level
    if1.say(b"S1 $ \r", 0.05)
    assert if1.controller.pins["output1"].level and not if1.pins["table.output1"]
    if1.run(0.2)
    assert if1.pins["table.output1"]
    if1.board.shut_down()
    if1.turn()
    assert if1.motion.ended
    if1.motion.end()
    assert if1.pins["table.output1"]  # its safe level
    assert not if1.pins["table.X.enable"]


def test_limits_of_the_scene_and_open_switches_forbid_motion():
    axes = (DrivenAxis("table.X", travel=(-10, 50), max_rate=2000),)
    twin = HalTwin(axes=axes, line="instant")
    board = twin.board
    for direction, times, reason in (
        (1, np.arange(60) / 1000, "table.X: position 60 is beyond travel [-10, 50]"),
        (1, np.arange(20) / 5000, "table.X: 5000 pulses/s is above max_rate 2000"),
        (1, np.array([-5.0]), "late by"),
    ):
        board.queue("table.X", direction, twin.now + times)
        twin.run(0.05)
        assert reason in twin.lines[-1]
        twin.driver.go_on(twin.now)
        twin.run(0.02)
    twin.pins["table.limit_plus"] = False
    twin.run(0.1)
    board.queue("table.X", +1, twin.now + np.array([0.01]))
    twin.run(0.05)
    assert twin.lines[-1].endswith("table.X: table.limit_plus is open: no motion in this direction")


def test_an_open_emergency_stop_and_a_new_component():
    twin = HalTwin(closed=False)
    assert twin.lines == [
        "stopped: hal: the contact of the emergency stop table.estop is open: release the button, then try again"
    ]
    twin.pins["table.estop"] = True
    twin.driver.go_on(twin.now)
    assert "setup" in twin.board.commands.popleft()
    twin.board.commands.append({"begin": True})
    twin.turn()
    assert twin.driver.all_ready
    twin.board.receive({"error": "no more"})
    assert twin.board.events[-1] == Failed("no more")


def test_a_servo_axis():
    limits = tuple(Sensed(f"table.{pin}", stops=way, stops_at=True) for pin, way in (("C", +1), ("D", -1)))
    twin = HalTwin("smartmotor", (DrivenAxis("table.shaft"),), limits, (), closed=False)
    twin.run(1.2)
    twin.say(b"ZS A=100 V=100000 P=1000 G ", 1.2)
    shaft = twin.controller.axes["shaft"]
    assert twin.at("table.shaft") == shaft.position == 1000
    twin.say(b"P=-200 G ", 0.3)
    twin.pins["table.D"] = True
    twin.run(0.5)
    assert -200 < twin.at("table.shaft") == shaft.position < 1000


def test_a_line_through_pulses_ends_at_each_position():
    rng, track, times, positions = np.random.default_rng(3), Track(7), [], [7]
    at = 5.0
    for block in range(50):
        at = max(at, block * 0.1)
        direction = int(rng.choice((-1, 1)))
        pulses = at + np.cumsum(rng.choice((0.0002, 0.003, 0.15), rng.integers(1, 30)))
        at = pulses[-1]
        track.add(direction, pulses)
        times += pulses.tolist()
        positions += (positions[-1] + direction * np.arange(1, len(pulses) + 1)).tolist()
    knots = [knot for until in np.arange(0.05, at + 0.2, 0.01) for knot in track.knots(until)]
    assert all(a[0] <= b[0] for a, b in pairwise(knots))
    grid, found = np.array(knots).T
    expected = np.interp(grid, times, positions[1:], left=7)
    quick = np.diff(times, prepend=0)[np.clip(np.searchsorted(times, grid), 0, len(times) - 1)] <= SLOW_S
    assert np.abs(found - expected)[quick].max() < 1e-6 and found[-1] == track.position == positions[-1]


HAL_FILE = """
loadrt threads name1=all period1=100000
loadrt stepgen step_type=0 ctrl_type=v
loadrt pid num_chan=1
loadrt encoder num_chan=1
addf stepgen.make-pulses all
addf encoder.update-counters all
addf stepgen.capture-position all
addf pid.0.do-pid-calcs all
addf stepgen.update-freq all
setp stepgen.0.position-scale 1
setp pid.0.Pgain 500
setp encoder.0.counter-mode true
net step stepgen.0.step => encoder.0.phase-A
net position axistwin.table.X.position-cmd => pid.0.command
net feedback stepgen.0.position-fb => pid.0.feedback axistwin.table.X.position-fb
net velocity pid.0.output => stepgen.0.velocity-cmd
net on axistwin.table.X.enable => stepgen.0.enable pid.0.enable
net limit => axistwin.table.limit_plus
sets limit true
start
"""


@pytest.fixture
def hal(tmp_path):
    """Return a function that starts the component in HAL; HAL ends after the test."""
    if not shutil.which("halcmd") or not Path(PYTHON).exists():
        pytest.skip("no LinuxCNC: Debian's package linuxcnc-uspace has it")
    prefix, home = [], tmp_path
    if os.geteuid() == 0:
        if not shutil.which("runuser"):
            pytest.skip("no runuser: rtapi_app refuses root")
        prefix = ["runuser", "-u", "nobody", "--"]
    running = subprocess.run([*prefix, "halcmd", "list", "comp"], capture_output=True, text=True, check=False).stdout
    if any(not name.startswith("halcmd") for name in running.split()):
        pytest.skip("HAL is in use: a machine has only one")
    if prefix:
        home = Path(tempfile.mkdtemp(prefix="axistwin-hal-"))  # the user `nobody` cannot read pytest's folders
        shutil.chown(home, "nobody")
        prefix += ["env", f"HOME={home}"]
    senders = []

    def start(text, positions=None):
        file = home / "test.hal"
        file.write_text(text)
        events = queue.Queue()
        wiring = HalWiring(
            "hal", (DrivenAxis("table.X"),), (Sensed("table.limit_plus", stops=+1),), (Switched("table.output1"),), file
        )
        sender = HalSender(HalBoard(wiring, 0.2, positions=positions), lambda _, event: events.put(event), prefix)
        senders.append(sender)
        sender.start()
        return sender, events

    yield start
    for sender in senders:
        sender.close()
    if home != tmp_path:
        shutil.rmtree(home)


@pytest.mark.slow
def test_step_generators_of_hal_make_every_pulse(hal):
    sender, events = hal(HAL_FILE, {"table.X": 500})
    assert events.get(timeout=300) == Ready({"table.X": 500}, {"table.limit_plus": True})
    begin = time.monotonic() + 0.1
    sender.complete(begin)
    sender.queue("table.X", +1, begin + np.arange(1, 1001) / 5000)
    sender.queue("table.X", -1, begin + 0.25 + np.arange(1, 301) / 3000)
    sender.complete(begin + 0.4)
    late = events.get(timeout=300)
    assert late == Stopped(late.reason, {"table.X": 1200}) and late.reason.startswith("late by ")
    assert int(sender._halcmd("getp", "encoder.0.rawcounts")) == 1300  # edges at the step output
    sender.complete(time.monotonic() + 60)
    sender.resume("table")
    sender._halcmd("sets", "limit", "false")
    changed = events.get(timeout=300)
    assert isinstance(changed, InputChanged) and (changed.to, changed.level) == ("table.limit_plus", False)
    assert events.get(timeout=300) == Stopped(
        "table.limit_plus stopped the motion", {"table.X": 1200}, "table.limit_plus"
    )
    sender.shut_down()


@pytest.mark.parametrize(("text", "reason"), [
    ("loadrt nothing_of_this_name\n", "`halcmd -f test.hal` has failed: "),
    ("", "HAL pins without a signal: axistwin.table.X.position-fb, axistwin.table.limit_plus; link each pin to ")
])  # fmt: skip
def test_a_wrong_hal_file_is_an_error(hal, text, reason):
    _, events = hal(text)
    failed = events.get(timeout=300)
    assert isinstance(failed, Failed) and failed.reason.startswith(reason)


def test_the_component_imports_no_module_of_the_working_directory(tmp_path, monkeypatch):
    """`import hal` in the folder of a scene is not LinuxCNC's module."""
    (tmp_path / "hal.py").write_text(f"import pathlib\npathlib.Path({str(tmp_path / 'was-here')!r}).touch()")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("axistwin.real.standin.hal.sender.PYTHON", sys.executable)
    monkeypatch.setattr(os, "geteuid", lambda: 1000)
    started = HalSender(HalBoard(HalWiring("hal", (), (), (), None)), lambda *_: None)._start_component()
    with started, started.stdout, started.stdin:
        assert "has no module hal" in started.stdout.readline().decode()
    assert not (tmp_path / "was-here").exists()
