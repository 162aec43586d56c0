"""Paths: each kind of path changes its value in the scene; a path that is not in the scene is refused."""

import pytest

from axistwin import AxistwinError, Scene
from axistwin.sweeps import Variation

from ..told import raises
from .scenes import motor, stepper


def varied(scene, path, value):
    return Variation(Scene.load(scene), [path]).scene([value])


@pytest.mark.parametrize(("path", "value", "place"), [
    ("table.X.load.torque", 0.3, ("controller", 0, "axes", "X", "load", "torque")),
    ("X.load.torque", 0.3, ("controller", 0, "axes", "X", "load", "torque")),
    ("table.X.limits.1", 99, ("controller", 0, "axes", "X", "limits", 1)),
    ("table.X.motor.torque.0.1", 2.0, ("controller", 0, "axes", "X", "motor", "torque", 0, 1)),
    ("table.Y.load.torque", 0.1, ("controller", 0, "axes", "Y", "load", "torque")),
    ("table.wiring", "3-wire", ("controller", 0, "options", "wiring")), ("fault.crash.at", 2.0, ("fault", 0, "at")),
    ("script.0.at", 3.0, ("script", 0, "at")), ("wire.0.delay_ms", 3.0, ("wire", 0, "delay_ms")),
    ("seed", 5, ("seed",))])  # fmt: skip
def test_a_path_reaches_its_place(tmp_path, path, value, place):
    at = varied(stepper(tmp_path), path, value).data
    for key in place:
        at = at[key]
    assert at == value


def test_numbers_of_a_program_and_variables_of_a_motor(tmp_path):
    scene = motor(tmp_path)
    text = next(
        iter(varied(scene, "knife.program.KP", 99).build() and varied(scene, "knife.program.KP", 99).programs.values())
    )
    assert "'KP=1 in a comment" in text and "\nKP=99\n" in text
    assert varied(scene, "knife.KD", 321).build()["knife"].registers["RKD"].read() == 321
    assert varied(scene, "knife.shaft.load.inertia_kg_m2", 1e-5).build()
    replaced = varied(scene, "knife.shaft.motor.supply_voltage_v", 30.0)
    assert replaced.data["controller"][0]["axes"]["shaft"]["motor"] == {"model": "frame23", "supply_voltage_v": 30.0}
    assert replaced.build()["knife"].axes["shaft"].supply_v == 30.0


@pytest.mark.parametrize(("path", "told"), [
    ("table.X.lod.torque", "did you mean 'load'?"), ("tabel", "is not in the scene"),
    ("table.limits.5", "invalid index 5 in table.limits.5: the setting is not a list"),
    ("table.X.limits.5", "expected an index below 2, the length of the list"),
    ("table.X.home.0", "invalid index 0 in table.X.home.0: the setting is not a list"),
    ("fault.cash.at", "did you mean 'crash'?"), ("fault.crash", "expected e.g. fault.NAME.parameter"),
    ("fault.crash.kind", "a sweep cannot vary the setting fault.crash.kind: "),
    ("script.1.at", "expected an index below 1, the number of [[script]] tables"),
    ("wire.0.from", "a sweep cannot vary the setting wire.0.from: ")])  # fmt: skip
def test_a_path_that_is_not_in_the_scene_is_refused(tmp_path, path, told):
    with pytest.raises(AxistwinError) as error:
        Variation(Scene.load(stepper(tmp_path)), [path])
    assert told in str(error.value)


def test_a_number_that_a_program_does_not_assign_is_refused(tmp_path):
    with pytest.raises(
        AxistwinError,
        match=r"no command of the program .* sets KI to a whole number: expected a command, e\.g\. KI=100",
    ):
        Variation(Scene.load(motor(tmp_path)), ["knife.program.KI"])
    raises(AxistwinError, "is not in the scene", Variation, Scene.load(motor(tmp_path)), ["knife.KX"])
    raises(AxistwinError, "expected a whole number", varied, motor(tmp_path), "knife.program.KP", 1.5)


def test_a_state_directory_is_not_used(tmp_path):
    scene = stepper(tmp_path)
    scene.write_text(STATE + scene.read_text().partition('name = "table"\n')[2])
    varied(scene, "seed", 1).build()
    assert not (tmp_path / "kept").exists()


STATE = '[[controller]]\nmodel = "if2"\nname = "table"\nstate = "kept"\n'
