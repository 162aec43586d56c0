"""`axistwin new --device`: what it writes passes at once, with any answers."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from ..command import PATIENCE_S, refused, run

SOURCE = Path(__file__).resolve().parents[2] / "src"
PYTEST = "-m", "pytest", "-q", "-p", "no:cacheprovider"
BASE = "fuzz or repeated or power"  # The checks that take seconds.


def done(directory, *words):
    """Return exit code and output of a Python in a folder of files."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST")}
    ran = subprocess.run(
        [sys.executable, *words], cwd=directory, env=environment | {"PYTHONPATH": str(SOURCE)}, capture_output=True,
        text=True, timeout=PATIENCE_S,
    )  # fmt: skip
    return ran.returncode, ran.stdout + ran.stderr


def test_everything_passes_at_once(tmp_path):
    written = run("new", tmp_path / "cell", "--device", "--yes")
    cell = tmp_path / "cell"
    names = ["stage.py", "test_stage.py", "scene.toml", "first.talk", "README.md"]
    assert (written.code, written.out.split()) == (0, [str(cell / name) for name in names])
    assert written.err == f"axistwin: next: axistwin --device {cell / 'stage.py'} run {cell / 'scene.toml'}\n"
    code, output = done(cell, *PYTEST)
    assert code == 0 and "8 passed" in output, output
    axistwin = "-m", "axistwin", "--device", "stage.py"
    assert done(cell, *axistwin, "check", "scene.toml") == (0, "axistwin: scene.toml: nothing wrong\n")
    code, output = done(cell, *axistwin, "run", "scene.toml")
    assert code == 0 and "1 0 → 10000, up to 2000 pulses/s, until 5.109375" in output  # 9 characters at 9600 baud
    assert done(cell, *axistwin, "run", "stage", "first.talk") == (0, output)
    code, output = done(cell, *axistwin, "commands", "stage")
    assert code == 0 and output.count("\n") == 6


@pytest.mark.slow
@pytest.mark.parametrize("answers", [
    ["--framing", "datagrams", "--units", "80 per mm", "--axes", "1"],
    ["--framing", "crlf", "--units", "3200/3 per mm", "--travel", "7", "--line", "300 7E1", "--axes", "8"],
    ["--framing", "lf", "--travel", "100", "--name", "x_y2"],
    ["--framing", "datagrams", "--travel", "1000000", "--port", "tcp://127.0.0.1:0"],
])  # fmt: skip
def test_other_answers_pass_too(tmp_path, answers):
    files = run("new", tmp_path, "--device", "--yes", *answers).out.split()
    code, output = done(tmp_path, *PYTEST, "-k", f"not ({BASE})")
    assert code == 0 and "5 passed, 3 deselected" in output, output
    name = Path(files[0]).stem
    code, output = done(tmp_path, "-m", "axistwin", "--device", f"{name}.py", "run", name, "first.talk")
    assert code == 0 and " → " in output, output
    assert done(tmp_path, "-m", "axistwin", "--device", f"{name}.py", "check", "scene.toml")[0] == 0


def test_six_questions(tmp_path):
    typed = "class\nif1\nmover\ntab\nlf\nfast\n19200 7E1\n9\n3\nmm\n80 per mm\n0\n250\n"
    written = run("new", tmp_path, "--device", typed=typed)
    assert (
        written.code == 0
        and 'model, title, line = "mover", "Mover", "19200 7E1"' in (tmp_path / "mover.py").read_text()
    )
    for message in (
        "invalid name 'class': expected small letters, digits and _, e.g. stage",
        "the name 'if1' is in use (if1, if2, 1810, 1811, smartmotor are models): expected another, e.g. stage",
        "invalid framing 'tab': expected one of cr, lf, crlf, datagrams",
        "invalid baud rate or character format 'fast': expected e.g. '9600 8N2'",
        "invalid number of axes '9': expected 1 to 8, e.g. 2",
        "invalid units 'mm': expected steps, or how many are one unit, e.g. 80 per mm",
        "invalid travel '0': expected 2 to 1000000, e.g. 250",
    ):
        assert message in written.err
    assert (tmp_path / "scene.toml").read_text().count('limits = ["-1 mm", "250 mm"]') == 3


@pytest.mark.parametrize(("options", "message"), [
    (["--name", "Stage"], "invalid name 'Stage': expected small letters, digits and _, e.g. stage"),
    (["--name", "json"], "the name 'json' is in use"),
    (["--line", "instant"], "invalid line 'instant': expected the format of the device, e.g. 9600 8N1"),
    (["--travel", "99"], "a travel of 99 steps has 99 steps: expected 100 to 100000000, e.g. --travel 250 --units"),
    (["--travel", "1000", "--units", "1e9 per mm"], "a travel of 1000 mm has 1000000000000 steps"),
    (["--models", "if1"], "--models is not for --device: leave one of them out"),
])  # fmt: skip
def test_wrong_options_are_refused(tmp_path, options, message):
    code, error = refused("new", tmp_path / "cell", "--device", "--yes", *options)
    assert code == 2 and error.startswith(f"axistwin: {message}") and not (tmp_path / "cell").exists()


def test_the_options_of_a_device_need_device(tmp_path):
    code, error = refused("new", tmp_path, "--yes", "--name", "stage")
    assert (code, error) == (2, "axistwin: --name is only for --device: leave one of them out\n")
