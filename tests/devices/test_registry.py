"""The names of models: ours, those of installed packages, classes and products."""

import subprocess
import sys

import pytest

from axistwin import Bench
from axistwin.bench import product
from axistwin.bench.models import is_model, models
from axistwin.controllers import registry
from axistwin.controllers.registry import OURS
from axistwin.core.errors import UsageError
from axistwin.devices import Device

from ..command import PATIENCE_S, refused, run
from .conftest import STAGE

COPY = 'from axistwin.bench import product\nX9 = product("if1")._replace(model="x9", title="Model X9")\n'


def test_our_models_are_the_first_of_all(install):
    install("my-stage", STAGE, stage="Stage")
    assert models() == (*OURS, "stage") == ("if1", "if2", "1810", "1811", "smartmotor", "stage")
    assert [product(name).model for name in models()] == list(models())
    assert [product(name).family for name in models()] == ["digiplan"] * 2 + ["compumotor"] * 2 + ["smartmotor", ""]


def test_a_device_of_an_installed_package_is_a_model(install):
    install("my-stage", STAGE, stage="Stage")
    bench = Bench()
    bench.add("Stage").serial.write(b"1PA500\r")
    bench.run(1)
    assert bench["stage"].axes["1"].position == 500


def test_a_package_can_have_a_product(install):
    install("x9", COPY, x9="X9")
    assert Bench().add("x9").product.title == "Model X9"


def test_a_class_or_a_product_needs_no_name():
    class Lamp(Device):
        model = "lamp"

    bench = Bench()
    assert bench.add(Lamp).name == "lamp" and bench.add(product("if1")._replace(model="x9")).name == "x9"
    assert bench.add(product("if1")).product is product("if1")
    assert not is_model("lamp")


@pytest.mark.parametrize("wrong", [int, type("Bare", (), {}), "stag", 1811, None, Device])
def test_anything_else_is_refused_in_a_line(wrong):
    with pytest.raises(UsageError, match=r"no model|not a device|has no model"):
        Bench().add(wrong)


class Ours(Device):
    """A device with a name of ours."""

    model = "if1"


class Unwritable(Device):
    """A device whose name cannot be typed."""

    model = "My Stage"


@pytest.mark.parametrize(("made", "message"), [
    (Ours, "class Ours has the model 'if1', which is a model of axistwin"),
    (product("if1")._replace(title="Better"), "the product has the model 'if1', which is a model of axistwin"),
    (Unwritable, "class Unwritable has the model 'My Stage': expected lower-case letters, digits, - and _, e.g. 'st"),
])  # fmt: skip
def test_names_of_ours_are_taken(made, message):
    with pytest.raises(UsageError, match=message):
        Bench().add(made)


def test_a_package_cannot_take_a_name_of_ours(install):
    install("better", COPY, if1="X9")
    assert product("if1").title == "Digiplan IF1 stepper motor interface" and models() == tuple(OURS)


def test_two_packages_with_one_name_are_both_named(install):
    install("my-stage", STAGE, stage="Stage")
    install("your-stage", STAGE, stage="Stage")
    assert refused("commands", "stage") == (2, (
        "axistwin: two devices have the name 'stage', my_stage:Stage of my_stage 1.0 and your_stage:Stage of "
        "your_stage 1.0: rename one, or leave one of them out\n"
    ))  # fmt: skip
    assert run("commands", "if1").code == 0


@pytest.mark.parametrize(("text", "place", "message"), [
    ("import nothing_of_this_name\n", "Stage",
     "cannot be imported from broken:Stage of broken 1.0 (ModuleNotFoundError: No module named 'nothing_of_this_name'"),
    ("1 / 0\n", "Stage", "cannot be imported from broken:Stage of broken 1.0 (ZeroDivisionError: division by zero): "),
    ("raise SystemExit(3)\n", "Stage", "(SystemExit: 3): correct or remove this package"),
    ("", "Stage", "(AttributeError: module 'broken' has no attribute 'Stage')"),
    ("Stage = 5\n", "Stage", "5 is not a device: expected a class that derives from axistwin.devices.Device"),
    (COPY, "X9", "broken:X9 of broken 1.0 is the model 'x9', not 'stage': give both the same name"),
])  # fmt: skip
def test_a_broken_package_is_told_when_it_is_asked_for(install, tmp_path, text, place, message):
    install("broken", text, stage=place)
    assert run("run", "if1", tmp_path / "none.if1").err.endswith("No such file or directory\n")
    code, told = refused("commands", "stage")
    assert code == 2 and message in told and told.count("\n") == 1
    scene = tmp_path / "scene.toml"
    scene.write_text('[[controller]]\nmodel = "stage"\n')
    assert run("check", scene).code == 1


def test_nobody_looks_for_packages_before_an_unknown_name(monkeypatch):
    monkeypatch.setattr(registry, "installed", lambda: pytest.fail("looked"))
    assert all(map(is_model, OURS))
    assert not any(map(is_model, ("scene.toml", "a/b", "tcp://127.0.0.1:5001", "", None)))


def test_entry_points_are_read_as_packages_write_them(monkeypatch):
    text = "# devices\n[axistwin.devices]\n; of ours\nStage=a.b:C.D [extra]\n x1 = a:B\nwrong\n[other]\ny = a:B\n"
    assert list(registry._devices(text)) == [("stage", "a.b:C.D"), ("x1", "a:B")]


@pytest.mark.parametrize("command", ["run", "check"])
def test_our_models_need_no_module_of_devices(tmp_path, command):
    (tmp_path / "a.if1").write_text("X100$\n")
    code = (
        f"import sys; from axistwin.cli.program import execute; execute([{command!r}, 'if1', 'a.if1']); "
        "print([name for name in sys.modules if name.startswith(('axistwin.devices', 'importlib.metadata'))])"
    )
    program = [sys.executable, "-c", code]
    done = subprocess.run(program, cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE_S, check=True)
    assert done.stdout.splitlines()[-1] == "[]"
