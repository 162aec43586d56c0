"""Devices of Python files: loaded by `--device`, by `axistwin.devices.load`, and in the processes that are started."""

import asyncio
import json
import zipfile

import pytest
from serial import serial_for_url

from axistwin import Bench, Scene, serve
from axistwin.bench.models import models, product
from axistwin.controllers.registry import texts_of
from axistwin.core.errors import DeviceError, UsageError
from axistwin.devices import load
from axistwin.sweeps.sweep import Sweep
from axistwin.ui.editor.background import Background

from ..cli.test_way_in import completed
from ..command import refused, run
from .conftest import STAGE

SCENE = '[[controller]]\nmodel = "stage"\nhost = "move.talk"\n'
TALK = "; model: stage\n> 1PA500\\r\n+ 1\n> 1TP\\r\n< 500\\r\n"


@pytest.fixture
def scene(stage):
    stage.with_name("move.talk").write_text(TALK)
    file = stage.with_name("scene.toml")
    file.write_text(SCENE)
    return file


# In Python


def test_the_classes_with_a_model_are_loaded(stage):
    stage.write_text(
        f"{STAGE}\n\nclass Base(Device):\n    pass\n\n\nclass Large(Stage):\n    model = 'large'\nAlso = Large\n"
    )
    stage_class, large = load(stage)
    assert (stage_class.__name__, large.__name__) == ("Stage", "Large") and models()[-2:] == ("stage", "large")
    assert Bench().add("large").product.title == "Example stage controller"


def test_a_file_can_use_a_module_beside_it(stage):
    stage.with_name("beside_the_stage.py").write_text("NAME = 'stage2'\n")
    stage.write_text(f"from beside_the_stage import NAME\n{STAGE}    model = NAME\n")
    assert [kind.model for kind in load(stage)] == ["stage2"]


def test_a_changed_file_is_loaded_again_and_an_unchanged_one_is_not(stage):
    (first,) = load(stage)
    assert load(stage) == (first,)
    stage.write_text(STAGE.replace('"stage"', '"other"').replace("20_000", "30_000"))
    (second,) = load(stage)
    assert second is not first and models()[-1] == "other" and "stage" not in models()


def test_a_wrong_change_leaves_the_device_as_it_was(stage):
    load(stage)
    stage.write_text(STAGE + "1 / 0\n")
    with pytest.raises(DeviceError):
        load(stage)
    bench = Bench()
    bench.add("stage").serial.write(b"1PA500\r")
    bench.run(1)
    assert bench["stage"].axes["1"].position == 500


def test_a_copy_of_a_file_is_the_same_device(stage, tmp_path):
    (tmp_path / "copy").mkdir()
    (tmp_path / "copy" / "stage.py").write_text(STAGE)
    assert load(stage) == load(tmp_path / "copy" / "stage.py")


def test_two_files_with_one_model_are_both_named(stage, install):
    load(stage)
    other = stage.with_name("other.py")
    other.write_text("# another\n" + STAGE)
    assert refused("--device", other, "commands", "stage") == (
        2, f"axistwin: {other}:7: the model 'stage' is also in {stage}:6: give one of them another name\n"
    )  # fmt: skip
    install("my-stage", STAGE, stage="Stage")
    with pytest.raises(UsageError, match=r"'stage', .*stage.py:6 and my_stage:Stage of my_stage 1.0: rename one"):
        product("stage")


# Errors in a file


@pytest.mark.parametrize(("text", "message"), [
    ("class X(:\n", "stage.py:1: invalid syntax: correct this line"),
    ("\n1 / 0\n", "stage.py:2: ZeroDivisionError: division by zero: correct this line"),
    ("def f():\n    raise ValueError\nf()\n", "stage.py:2: ValueError: correct this line"),
    ("import no_such_module_here\n", "stage.py:1: no module 'no_such_module_here': install it in the Python of axistw"),
    ("import sys\nsys.exit(1)\n", 'stage.py:2: the file ends the program: put this line under if __name__'),
    ("x = 1\n", "stage.py: no class that derives from axistwin.devices.Device and has a model: expected e.g. class St"),
    (STAGE.replace('"stage"', '"if1"'), "stage.py:6: class Stage has the model 'if1', which is a model of axistwin"),
    (STAGE.replace('"stage"', '"Stage"'), "stage.py:6: class Stage has the model 'Stage': expected lower-case letters"),
    (STAGE.replace('"stage"', "5"), "stage.py:6: class Stage has no model: add one"),
    (STAGE.replace('{"1": Positioner(velocity=20_000)}', "5"), "stage.py:6: "),
    (STAGE + "\n\nclass Second(Stage):\n    model = 'stage'\n", "stage.py:21: the model 'stage' is also in "),
    (STAGE.replace("framing =", "framng ="), "stage.py:6: nothing reads 'framng' of class Stage: did you mean 'framin"),
    (STAGE.replace("n:int", "n:integer"), "stage.py:12: invalid placeholder {position:integer}: expected a name and"),
    ("from axistwin.devices import Lines\nx = Lines(b'')\n", "stage.py:2: invalid terminator b'': expected characters"),
    (STAGE.replace("axis: str, p", "p"), "stage.py:12: the method of '<axis>PA<position>' does not take 'axis': add"),
    ("\0", "stage.py: source code string cannot contain null bytes"),
    ("# coding: nonsense\n", "stage.py: not a Python file: expected text in UTF-8"),
])  # fmt: skip
def test_an_error_in_a_file_is_one_line_with_its_place(stage, text, message):
    stage.write_text(text)
    code, told = refused("--device", stage, "commands", "stage")
    assert (
        code == 2
        and f"axistwin: {stage.parent}/{message}" in told
        and told.count("\n") == 1
        and models()[-1] == "smartmotor"
    )


def test_a_missing_file_is_told(names, tmp_path):
    code, told = refused("--device", tmp_path / "none.py", "commands", "stage")
    assert code == 2 and "none.py: cannot be read (no such file or directory): expected a Python file" in told
    assert refused("--device", tmp_path, "commands", "stage")[0] == 2


def test_the_place_of_an_error_is_in_its_json(stage):
    stage.write_text("\n1 / 0\n")
    done = run("--device", stage, "commands", "stage", "--json")
    assert done.code == 2 and f'"file": "{stage}", "line": 2' in done.err


# The command line


def test_a_command_has_the_devices_of_its_files(scene, stage):
    done = run("--device", stage, "run", "stage", scene.with_name("move.talk"))
    assert done.code == 0 and "1        0  500     500" in done.out
    assert run("--device", stage, "run", scene).code == 0
    assert run("--device", stage, "check", scene).code == 0
    assert "move absolute" in run("--device", stage, "commands", "stage").out


def test_a_scene_names_a_model_and_runs_no_code(scene):
    remedy = "load the file of another device, axistwin --device FILE.py …, or install its package"
    wanted = f"scene.toml:2:1: no model 'stage': expected one of if1, if2, 1810, 1811, smartmotor; {remedy}"
    code, told = refused("run", scene)
    assert code == 1 and wanted in told
    done = run("check", scene)
    assert done.code == 1 and remedy in done.out
    assert remedy in refused("run", "stage", scene.with_name("move.talk"))[1]


def test_device_behind_the_command_is_told(stage):
    assert refused("run", "stage", "--device", stage) == (
        2, "axistwin: --device is before the command: axistwin --device FILE.py COMMAND …\n"
    )  # fmt: skip


def test_what_a_file_prints_is_no_result(stage):
    stage.write_text(f"print('hello')\n{STAGE}")
    done = run("--device", stage, "commands", "stage", "--json")
    assert done.err == "hello\n" and json.loads(done.out)["model"] == "stage"


def test_command_lines_in_messages_have_the_devices(stage, tmp_path):
    (tmp_path / "wrong.talk").write_text("; model: stage\n> 1PA\\r\n+ 1\n")
    done = run("--device", stage, "run", "stage", tmp_path / "wrong.talk")
    assert f"1 line refused: axistwin --device {stage} check stage {tmp_path}/wrong.talk\n" in done.err
    made = run("--device", stage, "new", tmp_path / "a" / "cell", "--models", "stage", "--yes")
    assert made.err == f"axistwin: next: axistwin --device {stage} run {tmp_path}/a/cell/scene.toml\n"
    assert "axistwin --device ../../stage.py run scene.toml" in (tmp_path / "a" / "cell" / "scene.toml").read_text()


def test_a_test_can_serve_a_class(stage):
    (kind,) = load(stage)
    with serve(kind, speed="manual") as twin, serial_for_url(twin.ports["stage"], timeout=5) as host:
        host.write(b"1PA500\r")
        twin.advance(1)
        host.write(b"1TP\r")
        twin.advance(0.1)
        assert host.read_until(b"\r") == b"500\r"


def test_completion_names_the_models_of_a_file_without_running_it(stage):
    stage.write_text("raise SystemExit\nclass Other:\n    model: str = 'stand'\n" + STAGE)
    assert completed("bash", "--device", str(stage), "commands", "s") == ["smartmotor", "stand", "stage"]
    assert completed("bash", "--device", "none.py", "commands", "s") == ["smartmotor"]
    stage.write_text("class X(:\n")
    assert completed("bash", "--device", str(stage), "commands", "s") == ["smartmotor"]


def test_completion_names_the_models_of_packages(install):
    install("my-stage", "raise SystemExit\n", stage="Stage")
    assert completed("bash", "commands", "s") == ["smartmotor", "stage"]


# Other processes


def test_workers_of_a_sweep_have_the_devices_of_the_scene(scene, stage):
    load(stage)
    stage.write_text("1 / 0\n")  # What was loaded counts.
    sweep = Sweep(scene).measure("end", "max stage.1.position")
    here, there = (sweep.run(seconds=2.0, workers=workers).to_pylist() for workers in (0, 1))
    assert [row["end"] for row in here] == [row["end"] for row in there] == [500]
    assert here[0]["ended"] == there[0]["ended"] == "for"


def test_the_device_is_part_of_the_hash_of_a_sweep(scene, stage):
    load(stage)
    first = Sweep(scene).run(seconds=1.0, workers=0).to_pylist()[0]["scene"]
    stage.write_text(STAGE.replace("20_000", "30_000"))
    load(stage)
    assert Sweep(scene).run(seconds=1.0, workers=0).to_pylist()[0]["scene"] != first


def test_only_the_files_of_a_scene_are_handed_over(stage, scene):
    load(stage)
    assert texts_of(["if1"]) == {} and texts_of(["STAGE", "if1"]) == {str(stage): STAGE}
    assert Scene.load(scene).device_files == {str(stage): STAGE}


def test_the_checks_of_the_language_server_have_the_devices(stage):
    load(stage)

    async def play():
        background = Background()
        try:
            return await background.run(models), await background.run(models)
        finally:
            background.close()

    assert asyncio.run(play()) == (models(), models())


def test_an_fmu_contains_the_devices_of_its_scene(scene, stage, tmp_path):
    pytest.importorskip("pythonfmu3", reason="the extra [fmu] is not installed")
    assert run("--device", stage, "fmu", scene, "--out", tmp_path / "machine.fmu").code == 0
    with zipfile.ZipFile(tmp_path / "machine.fmu") as archive:
        archive.extractall(tmp_path / "fmu")
    from axistwin.controllers.registry import FILES, LOADED
    from axistwin.real.integrations.fmu.slave import Machine

    LOADED.clear()
    FILES.clear()
    machine = Machine(instance_name="machine", resources=str(tmp_path / "fmu" / "resources"))
    machine.do_step(0.0, 2.0)
    assert machine.bench["stage"].axes["1"].position == 500
