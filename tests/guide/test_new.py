"""`axistwin new`: the new scene can be run with any answers."""

from itertools import product

import pytest

from axistwin import Scene

from ..command import refused, run

MODELS = ["if1", "if2", "1810", "1811", "smartmotor", "if1,if1,smartmotor,1811"]


@pytest.mark.parametrize(("models", "host"), list(product(MODELS, ["scene", "outside", "both"])))
def test_a_new_scene_has_no_errors_and_moves(tmp_path, models, host):
    options = ["--models", models, "--axes", 3, "--travel", 300, "--host", host]
    done = run("new", tmp_path / "cell", *options, "--port", "tcp://127.0.0.1:0", "--yes")
    assert done.code == 0
    files = done.out.splitlines()
    assert run("check", *files).code == 0 and bool(Scene.load(files[0]).ports) == (host != "scene")
    assert len(files) == 1 + (0 if host == "outside" else len(models.split(",")))
    if host != "outside":
        ran = run("run", files[0], "--for", 10)
        assert ran.code == 0 and " → " in ran.out


def test_a_question_is_repeated_after_an_invalid_answer(tmp_path):
    typed = "if9\nif1, smartmotor\n4\n1\n\n9000\nnobody\nboth\npty:/x\nrfc2217://127.0.0.1:6000\n"
    done = run("new", tmp_path, typed=typed)
    assert done.code == 0
    text = (tmp_path / "scene.toml").read_text(encoding="utf-8")
    assert "[controller.axes.X]" in text and "[controller.axes.Y]" not in text
    assert text.count("limits = [-100, 20000]") == 2
    assert Scene.load(tmp_path / "scene.toml").ports == [
        ("if1", "rfc2217://127.0.0.1:6000"), ("smartmotor", "rfc2217://127.0.0.1:6001"),
    ]  # fmt: skip
    for message in (
        "no model 'if9'",
        "invalid number of axes '4'",
        "invalid host '9000'",
        "invalid port 'pty:/x' of the first controller",
    ):
        assert message in done.err


def test_no_file_is_written_if_answers_are_missing(tmp_path):
    done = run("new", tmp_path / "cell", typed="if1\n")
    assert (done.code, done.out) == (2, "")
    assert done.err.endswith("expected more lines with answers, or --yes to use the default answers\n")
    assert not (tmp_path / "cell").exists()


@pytest.mark.parametrize(("option", "message"), [
    (["--models", "x"], "no model 'x': expected one or more of if1, if2, 1810, 1811, smartmotor"),
    (["--models", ","], "no model is given: expected one or more of if1, if2, 1810, 1811, smartmotor"),
    (["--axes", "0"], "invalid number of axes '0': expected 1 to 3, e.g. 2"),
    (["--travel", "x"], "invalid travel 'x': expected 100 to 100000000, e.g. 20000"),
    (["--host", "x"], "invalid host 'x': expected one of scene, outside, both"),
    (["--port", "bus://:1"],
     "invalid port 'bus://:1' of the first controller: expected a tcp or rfc2217 port, e.g. tcp://127.0.0.1:5001")
])  # fmt: skip
def test_a_wrong_option_is_refused(tmp_path, option, message):
    assert refused("new", tmp_path / "cell", "--yes", *option) == (2, f"axistwin: {message}\n")
    assert not (tmp_path / "cell").exists()


@pytest.mark.parametrize("name", ["scene.toml", "if1.if1"])
def test_nothing_is_overwritten(tmp_path, name):
    (tmp_path / name).write_text("mine")
    code, message = refused("new", tmp_path, "--yes")
    assert (code, message) == (2, f"axistwin: {tmp_path / name} exists already: choose a directory without this file\n")
    assert [path.name for path in tmp_path.iterdir()] == [name]
