"""`axistwin stand-in` and `axistwin boards`."""

import asyncio
import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import click
import pytest

from axistwin.cli.program import main
from axistwin.cli.serving import stand_in
from axistwin.real.standin import reading
from axistwin.real.standin.events import Failed
from axistwin.real.standin.journal import Journal, last_positions
from axistwin.scenes.scene import Scene

SCENE = """
[[controller]]
model = "if1"
name = "table"

[stand-in]
horizon_ms = 1000
watchdog_ms = 1000

[[stand-in.board]]
name = "small"
port = "BOARD"

[[stand-in.axis]]
axis = "table.X"
step = "P2"
direction = "P3"
enable = "!P4"
travel = [-10, 10]

[[stand-in.input]]
to = "table.limit_plus"
pin = "^P8"
stops = "plus"

[[stand-in.output]]
from = "table.output1"
pin = "P10"
"""


@pytest.fixture
def scene(tmp_path):
    def write(text=SCENE):
        path = tmp_path / "table.toml"
        path.write_text(text.replace("BOARD", str(tmp_path / "board")))
        return path

    return write


def run(capsys, *words):
    with pytest.raises(SystemExit) as ended:
        main([str(word) for word in words])
    return ended.value.code, *capsys.readouterr()


def test_a_dry_run_prints_every_pin_and_opens_no_port(scene, capsys):
    code, out, err = run(capsys, "stand-in", scene(), "--dry-run")
    assert (code, err) == (0, "")
    for line in (
        "  P2       table.X step",
        "  !P4      table.X enable",
        "  ^P8      table.limit_plus input, stops plus motion at low",
        "  table.X: pulse 2 µs, travel -10 to 10, rate any",
    ):
        assert line in out.splitlines()


def test_the_dry_run_in_the_documentation(capsys, monkeypatch):
    home = Path(__file__).parents[2]
    monkeypatch.chdir(home)
    shown = re.search(
        r"^```console\n\$ axistwin (.*)\n((?:.*\n)*?)```$", (home / "docs" / "stand_in.md").read_text(), re.MULTILINE
    )
    assert run(capsys, *shown[1].split())[:2] == (0, shown[2])


@pytest.mark.parametrize(("old", "new", "message"), [
    ('"^P8"', '"P2"', ": pin P2 is used for table.X step and for table.limit_plus input: choose"),
    ("table.X", "table.W", ": no axis 'table.W': expected one of table.X, table.Y, table.Z"),
    ('"!P4"', '"P 4"', "stand-in.axis.enable"),
    ("watchdog_ms = 1000", "watchdog_ms = 2000", "watchdog_ms is too large (2000 ms): expected at most"),
    ("table.limit_plus", "table.output2", "table.output2 is an output: expected an input of a controller"),
    ('"table.output1"', '"table.input1"', "table.input1 is not an output that switches on and off"),
    ('model = "if1"', 'model = "smartmotor"', "no axis 'table.X': expected one of table.shaft"),
    ('step = "P2"', "", 'the key `step` is missing: expected a pin of the board, e.g. step = "PD2"'),
    ('port = "BOARD"', "", 'expected port = "/dev/ttyACM0" or hal = "FILE.hal"'),
    ('port = "BOARD"', 'port = "BOARD"\nhal = "x.hal"', 'expected port = "/dev/ttyACM0"'),
    (
        'port = "BOARD"',
        'hal = "x.hal"',
        "the key `step` is only for motion boards, but this axis is connected through LinuxCNC HAL: delete the key",
    )])  # fmt: skip
def test_errors_in_the_scene_have_their_place(scene, capsys, old, new, message):
    code, out, err = run(capsys, "stand-in", scene(SCENE.replace(old, new)), "--dry-run")
    assert (code, out, err.count("\n")) == (1, "", 1) and "table.toml:" in err
    assert message in err


def test_a_scene_without_a_stand_in(scene, capsys):
    code, _, err = run(capsys, "stand-in", scene('[[controller]]\nmodel = "if1"\n'), "--dry-run")
    assert code == 2
    assert "has no table [stand-in]: expected a table with a board and its axes" in err


HAL_SCENE = re.sub(r'(step|direction|enable|pin) = "[^"]*"\n', "", SCENE).replace('port = "BOARD"', 'hal = "x.hal"')


def test_a_dry_run_prints_the_pins_of_the_hal_component(scene, capsys, tmp_path):
    code, out, err = run(capsys, "stand-in", scene(HAL_SCENE), "--dry-run")
    assert (code, err) == (0, "")
    assert f"small: LinuxCNC HAL with {tmp_path / 'x.hal'}" in out
    for line in (
        "  axistwin.table.X.position-cmd      float out, position in pulses",
        "  axistwin.table.limit_plus          bit in, stops plus motion at low",
        "  axistwin.table.output1             bit out",
        "  table.X: travel -10 to 10, rate any",
    ):
        assert line in out.splitlines()
    code, _, err = run(capsys, "stand-in", scene(HAL_SCENE), "--board", "/dev/ttyACM0")
    assert (code, err.count("\n")) == (2, 1) and "the scene uses LinuxCNC HAL: remove the option --board" in err
    code, _, err = run(capsys, "stand-in", scene(HAL_SCENE.replace("table", "t" * 30)), "--dry-run")
    assert code == 1 and "is too long: expected at most 47 characters" in err


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root is refused")
def test_hal_refuses_root_and_the_position_stays_known(scene, capsys, tmp_path):
    journal = Journal(tmp_path / "table.journal", "table.X")
    journal.end({"table.X": 3})
    journal.close()
    code, _, err = run(capsys, "stand-in", scene(HAL_SCENE))
    assert code == 1
    assert re.search(r"(cannot run as root: start axistwin as another user|halcmd is missing: install LinuxCNC)", err)
    assert last_positions(tmp_path / "table.journal", ["table.X"]) == {"table.X": 3}


def test_a_missing_board(scene, capsys, tmp_path):
    code, _, err = run(capsys, "stand-in", scene())
    assert code == 2
    assert err.splitlines()[0].startswith("axistwin is not a safety controller")
    assert "axistwin boards` lists the connected boards" in err
    code, out, _ = run(capsys, "boards", tmp_path / "board")
    assert code == 1 and out.count("\n") == 1


@pytest.mark.parametrize(("gone", "code"), [(True, 1), (False, None)])
def test_a_board_that_has_gone_ends_the_run(scene, gone, code):
    """A board whose firmware has stopped waits for `go`; without a board `go` can do nothing."""

    async def serve():
        loaded = Scene.load(scene())
        bench = loaded.build(served=True)
        plan = reading.read(loaded, bench)
        run = stand_in._Run(bench, plan, None, None, quiet=False)
        run._connect([None], lambda line: None)
        run._ended = asyncio.get_running_loop().create_future()
        ((_, wiring),) = plan.boards
        run._handle(SimpleNamespace(wiring=wiring), Failed("the board has disappeared", gone))
        run._terminal.close()
        return run._ended.result() if run._ended.done() else None

    assert asyncio.run(serve()) == code


@pytest.mark.parametrize("quiet", [True, False])
def test_refused_lines_are_told_unless_quiet(scene, monkeypatch, quiet):
    monkeypatch.setattr(stand_in, "_echo", (told := []).append)
    loaded = Scene.load(scene())
    bench = loaded.build(served=True)
    run = stand_in._Run(bench, reading.read(loaded, bench), None, None, quiet=quiet)
    run._watch_refused()
    bench.run(1.5)
    for text in (b"(", b"U61\r", b"x1\r"):
        bench["table"].serial.write(text)
        bench.run(2)
    run._terminal.close()
    line = "axistwin: table: refused x1: unknown character 'x': commands are upper case; write X [DP101]\n"
    assert "".join(told) == ("" if quiet else line)


def test_a_closed_terminal_ends_no_run(monkeypatch):
    def write(*_, **__):
        raise BrokenPipeError

    monkeypatch.setattr(click, "echo", write)
    stand_in._echo("axistwin: stopped")


def test_a_start_from_an_unknown_position_is_refused(scene, capsys, tmp_path):
    (tmp_path / "table.journal").write_text("begin 2026-11-22 table.X\n")
    code, _, err = run(capsys, "stand-in", scene())
    assert code == 2 and "start with --unhomed, then home the machine" in err


@pytest.mark.skipif("AXISTWIN_REAL_TIME" not in os.environ, reason="real time: AXISTWIN_REAL_TIME=1 on an idle machine")
def test_a_run_on_a_pseudo_terminal_ends_with_known_positions(scene, tmp_path):
    """The command runs in real time, and a simulated board runs in another process."""
    board = subprocess.Popen(
        [sys.executable, Path(__file__).with_name("pty_board.py"), tmp_path / "board", tmp_path / "pulses"]
    )
    path, environment = scene(), {**os.environ, "PYTHONUNBUFFERED": "1"}
    try:
        while not (tmp_path / "board").is_symlink():
            assert board.poll() is None
            time.sleep(0.01)
        asked = subprocess.run(
            [sys.executable, "-m", "axistwin", "boards", tmp_path / "board", "--json"],
            capture_output=True,
            text=True,
            check=True,
        )
        assert json.loads(asked.stdout)[0]["firmware"] == "small board of the tests"
        command = [sys.executable, "-m", "axistwin", "stand-in", path]
        with subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, stdin=subprocess.DEVNULL,
                              text=True, env=environment) as program:  # fmt: skip
            lines = [program.stderr.readline() for _ in range(2)]
            assert lines[1].startswith("LIVE: table.X"), lines
            program.send_signal(signal.SIGINT)
            assert program.wait(20) == 130
    finally:
        board.terminate()
        board.wait(10)
    assert last_positions(tmp_path / "table.journal", ["table.X"]) == {"table.X": 0}
    assert json.loads((tmp_path / "pulses").read_text())["levels"]["4"] == 1  # the drive is off
