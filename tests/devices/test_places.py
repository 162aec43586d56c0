"""A device of others at places that know our families: the tutor, editors, new scenes, shared ports, real machines."""

from pathlib import Path

import pytest

from axistwin import Bench, Scene
from axistwin.bench import product
from axistwin.core.errors import UsageError
from axistwin.devices import load
from axistwin.real.probing.cases import dialect
from axistwin.real.probing.rescue.contents import reader
from axistwin.ui.editor.scene import Scenes
from axistwin.ui.editor.talk import Conversations
from axistwin.ui.teaching.tutor import Tutor

from ..command import refused, run
from ..links.test_sharing import Plug, hub  # noqa: F401  # a fixture


@pytest.fixture
def model(stage):
    load(stage)
    return "stage"


def test_the_tutor_explains_commands_and_names_the_power(model):
    bench = Bench()
    tutor = Tutor(bench.add(model))
    assert tutor.sending(b"1PA500\r") == [] and tutor.received(b"500\r") == [] and list(tutor.initialisation()) == []
    (found,) = tutor.explain("<axis>TP")
    assert "tell position" in found and "Tell position" in found
    assert tutor.explain("5") == ["no meaning known for '5'"]
    bench.run(1)
    move = "type  <axis>PA<position>   move absolute"
    assert tutor.why() == ["a move is possible: try", move]
    assert tutor.next() == [move, "type  <axis>TP             tell position"]
    bench[model].power(False)
    assert tutor.why() == ["the power is off: type  :drive power on"]


def test_there_are_no_lessons(model):
    assert refused("learn", model)[1].startswith("axistwin: no lessons for 'stage': expected one of if1, if2, 1810")


def offered(editing, *lines):
    return [item.label for item in editing.complete(list(lines), len(lines), len(lines[-1]))]


def test_an_editor_offers_its_commands_axes_and_name(model):
    talk, scene = Conversations(), Scenes()
    assert offered(talk, "; model: stage", "> ") == ["<axis>PA<position>", "<axis>TP"]
    assert offered(talk, "; model: stage", "> 1PA") == []
    assert talk.hover(["; model: stage", "> 1TP"], 2, 3).text.startswith("**<axis>TP** tell position")
    assert "1.position" in offered(talk, "; model: stage", "= ")
    assert offered(talk, "; model: ")[-1] == "stage" and '"stage"' in offered(scene, "[[controller]]", "model = ")
    controller = ("[[controller]]", 'model = "stage"')
    assert offered(scene, *controller, "[controller.axes]", "") == ["1"]
    assert offered(scene, *controller, "[controller.options]", "") == []


def test_an_editor_offers_nothing_of_a_package_that_cannot_be_imported(install):
    install("broken", "1 / 0\n", stage="Stage")
    assert offered(Conversations(), "; model: stage", "> ") == [] == offered(Conversations(), "; model: stage", "! ")
    assert "stage" not in offered(Conversations(), "; model: ")


def test_a_new_scene_can_contain_it(model, tmp_path):
    done = run("new", tmp_path / "cell", "--models", "stage,if1", "--yes")
    files = done.out.split()
    assert done.code == 0 and [Path(name).name for name in files] == ["scene.toml", "stage.talk", "if1.if1"]
    assert run("check", files[0]).code == run("run", files[0]).code == 0
    assert Scene.load(files[0]).build()["stage"].axes["1"].limits == (-100, 20000)


def test_its_requests_on_a_shared_port_end_with_a_pause(hub):  # noqa: F811
    def session(hub, a, b, c):
        a.send(b"\x01\x02\r\x04")
        b.send(b"\x01\x05\x06")
        assert hub.plug.sent == [b"\x01\x02\r\x04"]
        a.send(b"\x07")
        c.send(b"12\r34")
        hub._silent()
        hub._silent()
        assert hub.plug.sent == [b"\x01\x02\r\x04", b"\x07", b"\x01\x05\x06", b"12\r34"]

    hub(session, plain=True)


def test_what_exists_only_for_our_models_says_so(model, tmp_path):
    with pytest.raises(UsageError, match="stage cannot be rescued: expected one of if1, if2, 1810, 1811, smartmotor"):
        reader(model)
    assert refused("rescue", "tcp://127.0.0.1:1", "--model", model, "--out", tmp_path / "x")[0] == 2
    assert "no cases for stage" in refused("probe", "tcp://127.0.0.1:1", "--model", model)[1]
    with pytest.raises(UsageError, match=r"no cases for stage: expected one of if1, .* by `axistwin record`"):
        dialect(product(model))
    scene = tmp_path / "scene.toml"
    scene.write_text('[[controller]]\nmodel = "stage"\nhost = "a.if1"\n')
    (tmp_path / "a.if1").write_text("X100$\n")
    assert "a.if1 is not a program for stage: expected a conversation (.talk)" in refused("run", scene)[1]
