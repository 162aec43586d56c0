"""Mistyped commands, errors and ports as JSON, terminal widths, and completion in shells."""

import io
import json
import os
import re
import shutil
import subprocess
import sys
from unittest.mock import patch

import pytest
from click.testing import CliRunner

from axistwin.cli.common import completing
from axistwin.cli.program import COMMANDS, axistwin, main
from axistwin.controllers.registry import OURS

from ..command import PATIENCE_S, ended, refused, run, running


@pytest.mark.parametrize(("word", "message"), [
    ("rnu", "no command 'rnu': did you mean run?"),
    ("Serve", "no command 'Serve': did you mean serve?"),
    ("xyz", f"no command 'xyz': expected {', '.join(COMMANDS)}")])  # fmt: skip
def test_an_unknown_command(word, message):
    assert refused(word) == (2, f"axistwin: {message}\n")


@pytest.mark.parametrize("words", [
    ("run", "if1", "no.if1"), ("run", "no.toml"), ("check", "no.toml"), ("check", "if1", "no.if1"),
    ("serve", "no.toml"), ("plot", "no.csv"), ("diff", "no.csv", "no.vcd"), ("replay", "no.talk")])  # fmt: skip
def test_a_missing_file_is_wrong_usage_everywhere(words):
    code, message = refused(*words)
    assert code == 2 and message.endswith("cannot be read: No such file or directory\n")


def test_errors_for_machines(tmp_path):
    scene = tmp_path / "a.toml"
    scene.write_text('[[controller]]\nmodel = "if9"\n')
    for words, code, rest in (
        (("rnu",), 2, {}),
        (("run", "if1", tmp_path), 2, {}),
        (("run", scene), 1, {"file": str(scene), "line": 2, "column": 1}),
    ):
        found = run(*words, "--json")
        assert (found.code, found.out) == (code, "")
        error = json.loads(found.err)
        assert error.pop("error") and error == {"exit_code": code, **rest}


@pytest.mark.parametrize(("words", "message"), [
    (("run", "if1"), "the PROGRAM is missing: expected a file for an IF1"),
    (("serve", "1811", "--tcp", ":0"), "1811 has no serial port: use its attribute `bus`"),
    (("serve", "if2", "--bus", ":0"), "if2 has no bus port: use its serial port (attribute `serial`)"),
    (
        ("serve", "smartmotor", "--bus", ":0"),
        "smartmotor has no bus port: use its serial port (attribute `serial`)",
    )])  # fmt: skip
def test_models_have_their_article(words, message):
    assert message in run(*words).err


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture
def on_a_terminal(monkeypatch):
    """Return a function that runs the program on a terminal of a given width; it returns exit code and output."""

    def show(width, *words):
        monkeypatch.setenv("COLUMNS", str(width))
        monkeypatch.setattr(sys, "stdout", Terminal())
        with pytest.raises(SystemExit) as end:
            main(words)
        return end.value.code, re.sub(r"\x1b\[[\d;]*m", "", sys.stdout.getvalue())

    return show


@pytest.mark.parametrize("words", [["commands", "1811"], ["commands", "smartmotor"], ["faults"], ["docs", "--list"]])
def test_no_table_is_wider_than_the_terminal(on_a_terminal, words):
    for width in (60, 80, 100, 160):
        code, shown = on_a_terminal(width, *words)
        lines = shown.splitlines()
        assert (code, len(lines) > 20, max(map(len, lines)) <= width) == (0, True, True), width


def test_the_title_of_a_table_and_the_place_of_an_error_are_shown_on_a_terminal(on_a_terminal, tmp_path):
    code, shown = on_a_terminal(120, "commands", "if1")
    assert code == 0
    assert "All are implemented." in shown.partition("Digiplan IF1 stepper motor interface")[2]
    assert "Digiplan" not in on_a_terminal(60, "commands", "if1")[1].partition("acceleration rate data")[0]
    (tmp_path / "a.if1").write_text("X1000$\n\tx$\n")
    code, shown = on_a_terminal(120, "check", "if1", f"{tmp_path}/a.if1")
    assert code == 1 and "     x$\n     ^" in shown.partition("commands are upper case")[2]


@pytest.mark.parametrize("words", [["commands", "1811"], ["faults"], ["examples"]])
def test_a_pipe_gets_fields_between_tabs(words):
    lines = run(*words).out.splitlines()
    assert len({line.count("\t") for line in lines}) == 1 and not any("  " in line for line in lines)


def test_the_ports_for_machines():
    with running("serve", "if1", "--tcp", ":0", "--json", "--show-hosts") as program:
        shown = json.loads(program.stdout.readline())
        (port,) = shown["ports"]
        assert (shown["panel"], port["name"], port["url"][:16]) == (None, "if1", "tcp://127.0.0.1:")
        assert any(line.startswith("pyserial") for line in port["hosts"])
        assert ended(program)[0] == 0


def completed(shell, *words):
    """Return the completions that a shell's script receives from the program."""
    place = words[-1] if shell == "fish" else str(len(words))
    asked = {"COMP_WORDS": " ".join(("axistwin", *words)), "COMP_CWORD": place}
    with patch.dict(os.environ, asked | {"_AXISTWIN_COMPLETE": f"{shell}_complete"}):
        done = CliRunner().invoke(axistwin, prog_name="axistwin", catch_exceptions=False)
    assert done.exit_code == 0
    lines = done.stdout.splitlines()
    if shell in ("powershell", "zsh"):  # type, value and description on three lines
        return lines[1::3]
    return [line.partition(",")[2].partition("\t")[0] for line in lines]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("cell/scene.toml", "cell/feed.if1", "cell/deep/home.sms", "cell/notes.txt", "a.csv", ".hidden/x.toml"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()


COMPLETED = {
    ("r",): ["run", "record", "rescue", "replay"], ("run", ""): [*OURS, "cell/scene.toml"],
    ("run", "i"): ["if1", "if2"], ("run", "ce"): ["cell/scene.toml"], ("run", "cell/"): ["cell/scene.toml"],
    ("serve", "cell/s"): ["cell/scene.toml"], ("run", "if1", ""): ["cell/deep/home.sms", "cell/feed.if1"],
    ("check", "cell/f"): ["cell/feed.if1"], ("plot", "a"): ["a.csv"], ("commands", "18"): ["1810", "1811"],
    ("examples", "dr"): ["drill"], ("docs", "po"): ["ports"], ("run", "--pl"): ["--plot"],
    ("completion", "b"): ["bash"],
}  # fmt: skip


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize("shell", ["bash", "zsh", "fish", "powershell"])
def test_values_are_completed(shell):
    assert {words: found for words in COMPLETED if (found := completed(shell, *words)) != COMPLETED[words]} == {}


def test_the_search_for_files_has_an_end(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(completing, "MOST_SEEN", 1)
    for name in ("a/1.toml", "a/2.toml", "b/c/3.toml", "b/c/d/e/f/4.toml"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    assert sorted(completing._files("", (".toml",))) == ["a/1.toml", "a/2.toml"]
    monkeypatch.setattr(completing, "MOST_SEEN", 100)
    assert "b/c/3.toml" in completing._files("", (".toml",))
    assert "b/c/d/e/f/4.toml" not in completing._files("", (".toml",))


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish", "powershell"])
def test_each_shell_has_a_script(shell):
    text = run("completion", shell).out
    assert "_AXISTWIN_COMPLETE" in text and f"{shell}_complete" in text
    if (program := shutil.which(shell)) is not None:
        assert subprocess.run([program, "-n"], input=text, text=True, check=False).returncode == 0


def test_bash_completes_with_the_script(tmp_path):
    bash = shutil.which("bash")
    if bash is None:
        pytest.skip("bash is not installed")
    program = tmp_path / "axistwin"
    program.write_text(f'#!/bin/sh\nexec {sys.executable} -m axistwin "$@"\n')
    program.chmod(0o755)
    words = run("completion", "bash").out + (
        'COMP_WORDS=(axistwin run smar); COMP_CWORD=2; _axistwin_completion axistwin smar run; echo "${COMPREPLY[@]}"\n'
    )
    environment = os.environ | {"PATH": f"{tmp_path}{os.pathsep}{os.environ['PATH']}"}
    done = subprocess.run(
        [bash, "-c", words], capture_output=True, text=True, env=environment, timeout=PATIENCE_S, check=False
    )
    assert done.stdout.split() == ["smartmotor"]
