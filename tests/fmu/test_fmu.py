"""FMUs: the files in them, their variables, and the same pulses as a scene that runs by itself."""

import json
import os
import platform
import subprocess
import sys
import zipfile
from importlib.util import module_from_spec, spec_from_file_location
from math import inf, nan
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

from axistwin import Scene
from axistwin.core.errors import UsageError
from axistwin.real.integrations.fmu.archive import export

from ..command import run

pytest.importorskip("pythonfmu3", reason="the extra [fmu] is not installed")

SCENE = """
title = "A table and a knife"
[[controller]]
model = "if2"
name = "my-table"
host = "go.if1"
state = "memory"
ports = ["tcp://127.0.0.1:5001"]
[controller.axes.X]
limits = [-160, 24_000]
motor = { torque = [[0, 1.2], [4000, 0.7], [8000, 0.3]], inertia = 3e-5 }
load = { torque = 0.15, inertia = 6e-5 }
[[controller]]
model = "smartmotor"
name = "knife"
[[wire]]
from = "my-table.output1"
to = "my-table.input1"
"""
LINES = "X3000@5000S1$\nX-1500@5000R1$\n"
END_S = 5
BENCHMARK = Path(__file__).parents[2] / "benchmarks" / "fmu.py"


@pytest.fixture
def scene(tmp_path):
    (tmp_path / "go.if1").write_text(LINES)
    (tmp_path / "scene.toml").write_text(SCENE)
    return tmp_path / "scene.toml"


@pytest.fixture
def unpacked(scene, tmp_path):
    def unpack(**commands):
        export(scene, tmp_path / "machine.fmu", commands)
        with zipfile.ZipFile(tmp_path / "machine.fmu") as archive:
            archive.extractall(tmp_path / "fmu")
        return tmp_path / "fmu"

    return unpack


def instance(folder):
    """Return the Python object that pythonfmu3 makes for an FMU."""
    resources = folder / "resources"
    name = (resources / "slavemodule.txt").read_text()
    spec = spec_from_file_location(name, resources / f"{name}.py")
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.machine(instance_name="one", resources=str(resources))


class Tool:
    def __init__(self, machine):
        self.machine, self.now_s = machine, 0.0
        self.named = {each.name: each for each in machine.vars.values()}

    def run(self, until_s, step_s=0.01):
        for n in range(round(self.now_s / step_s), round(until_s / step_s)):
            result = self.machine.do_step(n * step_s, step_s)
            assert (result.status, self["time"]) == (0, n * step_s + step_s)
        self.now_s = until_s

    def __getitem__(self, name):
        return self.named[name].getter()

    def __setitem__(self, name, value):
        self.named[name].setter(value)


def test_an_fmu_contains_the_scene_without_its_ports(unpacked):
    folder = unpacked(start=r"my-table: > X100$\r")
    resources = folder / "resources"
    copy = Scene.load(resources / "scene" / "scene.toml")
    assert copy.ports == [] and copy.data["controller"][0]["host"] == "go.if1"
    assert "state" not in copy.data["controller"][0]
    assert (resources / "scene" / "go.if1").read_text() == LINES
    described = ET.parse(folder / "modelDescription.xml").getroot()
    kind = described.find("CoSimulation").attrib
    assert described.attrib["fmiVersion"] == "3.0" and described.attrib["description"] == "A table and a knife"
    assert (kind["modelIdentifier"], kind["canHandleVariableCommunicationStepSize"]) == ("machine", "true")
    names = {each.attrib["name"]: each.attrib["causality"] for each in described.find("ModelVariables")}
    expected = {
        "time": "independent", "'my-table'.X.torque": "input", "'my-table'.input2": "input", "knife.D.low": "input",
        "start": "input", "'my-table'.input1": "output", "'my-table'.limit_plus": "output", "knife.D": "output",
        "'my-table'.X.position": "output", "'my-table'.X.velocity": "output", "'my-table'.X.angle": "output",
        "knife.shaft.velocity": "output", "'my-table'.output1": "output",
    }  # fmt: skip
    assert {name: names.get(name) for name in expected} == expected
    assert not {"'my-table'.Y.torque", "knife.shaft.torque", "'my-table'.Y.angle"} & names.keys()


@pytest.mark.parametrize("step_s", [0.01, 0.1])
def test_the_step_does_not_change_the_pulses(scene, unpacked, step_s):
    native = Scene.load(scene).build()
    native.run(END_S)
    tool = Tool(instance(unpacked()))
    tool.run(END_S, step_s)
    found, expected = (bench["my-table"].axes["X"].pulse_times().tolist() for bench in (tool.machine.bench, native))
    assert found == expected and len(found) == 4500


def test_inputs_act_at_communication_points(scene, unpacked):
    native = Scene.load(scene).build()
    tool = Tool(instance(unpacked(start=r"my-table: ! input3 high", crash="! fault jam my-table.X duration=0.1")))
    for bench_does in (True, False):
        for at_s, name, value, act in (
            (3.0, "'my-table'.X.torque", -0.4, lambda: native["my-table"].axes["X"].load(-0.4)),
            (3.1, "knife.D.low", True, lambda: native["knife"].pins["D"].drive(False)),
            (3.2, "'my-table'.input2", True, lambda: native["my-table"].pins["input2"].drive(True)),
            (3.3, "start", True, lambda: native["my-table"].pins["input3"].drive(True)),
            (3.4, "knife.D.low", False, lambda: native["knife"].pins["D"].release()),
            (3.5, "start", False, lambda: None),
        ):
            if bench_does:
                native.run(at_s - native.seconds)
                act()
            else:
                tool.run(at_s)
                tool[name] = value
    native.run(END_S - native.seconds)
    tool.run(END_S)
    machine = tool.machine.bench
    for name in ("my-table", "knife"):
        levels = [{pin: each.level for pin, each in bench[name].pins.items()} for bench in (machine, native)]
        assert levels[0] == levels[1]
    axes = [bench["my-table"].axes["X"] for bench in (machine, native)]
    assert axes[0].pulse_times().tolist() == axes[1].pulse_times().tolist() and axes[0].outside_torque == -0.4
    assert axes[0].lost == axes[1].lost == tool["'my-table'.X.pulses"] - tool["'my-table'.X.position"]
    assert tool["'my-table'.X.angle"] == pytest.approx(axes[1].position * 6.283185307 / axes[1].per_rev)
    assert machine["my-table"].pins["input3"].level


def test_a_failed_action_ends_the_step_with_an_error(unpacked):
    tool = Tool(instance(unpacked(end="! mend crash", begin="my-table: ! fault jam X name=crash")))
    tool["end"] = True
    assert tool.machine.do_step(0.0, 0.1).status == 3 and "unknown fault 'crash'" in tool.machine.log_queue[-1].msg


def test_times_that_fmi_does_not_permit_are_errors_with_a_sentence(unpacked):
    """Time stands still in such a step, and the right one works afterwards."""
    tool = Tool(instance(unpacked()))
    machine = tool.machine
    for begin_s, step_s, sentence in (
        (7.0, 1e300, "1e+300 s is too long: expected less than 292 years (9.2e9 s)"),
        (float("nan"), 0.1, "invalid communication point nan: expected a finite number of seconds"),
        (float("inf"), 0.1, "invalid communication point inf: expected a finite number of seconds"),
        (100.0, float("nan"), "invalid step size nan: expected a finite number of seconds above 0"),
        (100.0, -0.1, "invalid step size -0.1: expected a finite number of seconds above 0"),
        (100.0, 0.0, "invalid step size 0: expected a finite number of seconds above 0"),
        (100.0, float("inf"), "invalid step size inf: expected a finite number of seconds above 0"),
        (100.0, 1e300, "1e+300 s is too long: expected less than 292 years (9.2e9 s)"),
        (100.0, 0.1, None),
        (100.1, 0.2, None),
        (100.2, 0.1, "invalid communication point 100.2 s: expected 100.3 s, the end of the last step"),
        (147.0, 0.1, "invalid communication point 147 s: expected 100.3 s, the end of the last step"),
        (100.3, -0.3, "invalid step size -0.3: expected a finite number of seconds above 0"),
        (100.3 + 4e-14, 0.7, None),
    ):
        before = machine.bench.now
        assert machine.do_step(begin_s, step_s).status == (0 if sentence is None else 3)
        assert (machine.bench.now > before) == (sentence is None)
        assert sentence is None or machine.log_queue[-1].msg == sentence
    assert (machine.bench.seconds, tool["time"]) == (1, 100.3 + 4e-14 + 0.7)


def test_the_c_functions_of_fmi_report_errors_and_are_not_fatal(unpacked):
    """The same as above, through the library of the FMU, in a process that a fatal error would end."""
    if sys.platform != "linux" or platform.machine() != "x86_64":
        pytest.skip("the library of the FMU is for Linux on x86-64")
    folder = unpacked()
    described = ET.parse(folder / "modelDescription.xml").getroot().find("ModelVariables")
    reference = {each.attrib["name"]: int(each.attrib["valueReference"]) for each in described}
    time, torque = reference["time"], reference["'my-table'.X.torque"]
    calls = [
        ("step", nan, 0.1), ("step", 0.0, nan), ("step", inf, 0.1), ("step", 0.0, 0.0), ("step", 0.0, 1e300),
        ("step", 0.0, 0.1), ("get", time), ("step", 0.5, 0.1), ("step", 0.0, 0.1), ("step", 0.1, -0.1),
        ("set", torque, nan), ("step", 0.1, 0.1), ("set", torque, 0.0), ("step", 0.1, 0.1), ("get", time),
    ]  # fmt: skip
    words = [sys.executable, Path(__file__).parent / "c_tool.py", folder, json.dumps(calls)]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    ok, error = 0, 3
    told = [
        "invalid communication point nan: expected a finite number of seconds",
        "invalid step size nan: expected a finite number of seconds above 0",
        "invalid communication point inf: expected a finite number of seconds",
        "invalid step size 0: expected a finite number of seconds above 0",
        "1e+300 s is too long: expected less than 292 years (9.2e9 s)",
        None, None,
        "invalid communication point 0.5 s: expected 0.1 s, the end of the last step",
        "invalid communication point 0 s: expected 0.1 s, the end of the last step",
        "invalid step size -0.1: expected a finite number of seconds above 0",
        None,
        "invalid torque nan N·m: expected -1000 to 1000 N·m",
        None, None, None,
    ]  # fmt: skip
    answers = json.loads(done.stdout)
    assert [[status, messages] for status, _, messages in answers] == [
        [ok, []] if each is None else [error, [[error, each]]] for each in told
    ]
    assert (answers[6][1], answers[-1][1]) == (0.1, 0.2)


def test_a_value_that_is_refused_once_is_refused_again(unpacked):
    tool = Tool(instance(unpacked()))
    for _ in range(2):
        tool["'my-table'.X.torque"] = float("nan")
        assert tool.machine.do_step(0.0, 0.1).status == 3
    tool["'my-table'.X.torque"] = 0.0
    assert tool.machine.do_step(0.0, 0.1).status == 0


def test_another_version_of_axistwin_is_refused(unpacked):
    folder = unpacked()
    settings = folder / "resources" / "axistwin.json"
    settings.write_text(json.dumps(json.loads(settings.read_text()) | {"version": "0.0.1"}))
    with pytest.raises(UsageError, match=r"this FMU needs axistwin 0\.0\.1, but .* is installed: install 0\.0\.1, or"):
        instance(folder)


@pytest.mark.parametrize(("words", "told"), [
    (["-o", "my-machine.fmu"], "expected letters, digits and _, e.g. machine.fmu"),
    (["-o", "machine.zip"], "expected a name that ends in .fmu"),
    (["-o", "missing/machine.fmu"], "missing/machine.fmu cannot be written: no such file or directory"),
    (["--command", "start"],
     "invalid --command 'start': expected NAME: > COMMAND or NAME: ! ACTION, e.g. 'start: > X3000@5000S1$\\r'"),
    (["--command", "a b: > X"], "invalid command name 'a b'"),
    (["--command", "time: > X"], "invalid command name 'time'"),
    (["--command", "start: knife: X"], "command 'start': unknown kind of line"),
    (["--command", "start: > X"], "command 'start': no controller name in '> X'"),
    (["--command", "start: knife: = D low"], "command 'start': invalid line 'knife: = D low'"),
    (["--command", "start: knife: ! Q low"], "command 'start': unknown name 'Q'"),
    (["--command", "a: knife: ! D low", "--command", "a: knife: ! D high"], "two --command options have the name a")
])  # fmt: skip
def test_errors_are_one_line_and_nothing_is_written(scene, words, told, monkeypatch):
    monkeypatch.chdir(scene.parent)
    done = run("fmu", scene, *words)
    assert (done.code, done.out, len(done.err.splitlines())) == (2, "", 1) and told in done.err
    assert sorted(path.name for path in scene.parent.iterdir()) == ["go.if1", "scene.toml"]


def test_a_program_outside_the_folder_of_the_scene_is_refused(scene, tmp_path):
    inner = tmp_path / "inner"
    inner.mkdir()
    (inner / "scene.toml").write_text(SCENE.replace("go.if1", "../go.if1"))
    with pytest.raises(UsageError, match="expected a file in the folder of the scene"):
        export(inner / "scene.toml", tmp_path / "machine.fmu")


def test_the_command(scene, monkeypatch):
    monkeypatch.chdir(scene.parent)
    done = run("fmu", "scene.toml", "--command", r"start: my-table: > X100$\r")
    assert (done.code, done.out, done.err) == (0, "", "axistwin: scene.fmu\n")


def test_fmpy_accepts_and_runs_an_fmu():
    pytest.importorskip("fmpy", reason="FMPy is not installed")
    words = [sys.executable, BENCHMARK, "--scenes", "1", "--steps", "0.1"]
    done = subprocess.run(words, capture_output=True, text=True, check=False, env=os.environ)
    assert (done.returncode, done.stdout.splitlines()[-1][:4]) == (0, "met ")
