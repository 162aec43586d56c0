"""The program `axistwin`: stdout, stderr and exit codes."""

import re
import subprocess
import sys
from pathlib import Path

import click
import pytest

from axistwin import __version__
from axistwin.cli.program import COMMANDS, axistwin, execute
from axistwin.core.errors import LinkError, ProgramError, UsageError

from ..command import PATIENCE_S


@pytest.fixture
def ending(monkeypatch):
    """Return a function that ends the command `run` in a given way, and returns the result of `main`."""

    def end(how) -> int:
        def callback():
            if isinstance(how, BaseException):
                raise how
            return how

        monkeypatch.setattr(type(axistwin), "get_command", lambda *_: click.Command("run", callback=callback))
        return main("run")

    return end


def main(*arguments: str) -> int:
    return execute(list(arguments))


def test_version(capsys):
    assert main("--version") == 0
    assert capsys.readouterr().out == f"axistwin, version {__version__}\n"


@pytest.mark.parametrize("flag", ["-h", "--help"])
def test_help_names_all_commands(capsys, flag):
    assert main(flag) == 0
    assert re.findall(r"^  (\w[\w-]*)  ", capsys.readouterr().out, re.MULTILINE) == list(COMMANDS)


def test_help_begins_with_where_to_begin(capsys):
    assert main("--help") == 0
    named = re.findall(r"^  axistwin (\w+)", capsys.readouterr().out.split("Options:")[0], re.MULTILINE)
    assert named == ["demo", "learn", "examples", "docs", "run", "serve"]


def test_no_command_shows_the_help_and_is_wrong_usage(capsys):
    assert main() == 2 and "Commands:" in capsys.readouterr().err


def test_a_command_that_does_not_exist(capsys):
    assert main("fly") == 2 and "no command 'fly'" in capsys.readouterr().err


@pytest.mark.parametrize("command", list(COMMANDS))
def test_every_command_has_a_module(command):
    assert COMMANDS[command].load().name == command


@pytest.mark.parametrize(("how", "code"), [
    (None, 0), (1, 1), (UsageError("no such thing: choose another"), 2), (LinkError("port 5001 is taken"), 2),
    (ProgramError("no such step", file="a.if1", line=3, column=7), 1), (KeyboardInterrupt(), 130)])  # fmt: skip
def test_exit_codes(ending, capsys, how, code):
    assert ending(how) == code
    out, err = capsys.readouterr()
    assert out == ""
    told = "interrupted" if isinstance(how, KeyboardInterrupt) else how
    assert err.strip() == (f"axistwin: {told}" if isinstance(how, BaseException) else "")


def test_a_bug_surfaces(ending):
    with pytest.raises(ZeroDivisionError):
        ending(ZeroDivisionError())


def test_a_reader_that_goes_away_is_no_error():
    code = "from axistwin.cli.program import main; main(['--help'])"
    program = subprocess.Popen(
        [sys.executable, "-c", "import sys; sys.stdin.read(); " + code],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip
    assert program.stdout is not None
    program.stdout.close()
    _, complaints = program.communicate(timeout=PATIENCE_S)
    assert complaints == b""


def test_neither_version_nor_help_nor_a_bench_need_the_big_libraries():
    code = (
        "import sys, axistwin.cli.program, axistwin.cli.runs.run; "
        "bench = axistwin.Bench(); bench.add('if1'); bench.run(2); "
        "names = 'numpy', 'matplotlib', 'pydantic', 'rich', 'serial', 'vcd', 'importlib.metadata'; "
        "print([name for name in names if name in sys.modules]); "
        "import simpy, importlib.metadata; print(simpy.__version__ == importlib.metadata.version('simpy')); "
        "print(hasattr(simpy, 'no_such_name'))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=PATIENCE_S, check=True)
    assert done.stdout == "[]\nTrue\nFalse\n"


def test_a_server_answers_without_displays_checkers_and_files():
    code = (
        "import sys, axistwin.cli.program, axistwin.cli.serving.serve, axistwin.links.tcp; from axistwin import Bench; "
        "bench = Bench(); motor = bench.add('smartmotor'); bench.add('if1'); bench.run(1.5); "
        "motor.serial.write(b'RP '); bench.run(0.1); print(motor.serial.read()); "
        "names = 'numpy numba matplotlib pydantic rich serial tomllib json hashlib shutil difflib shlex'.split(); "
        "names += ['importlib.metadata', 'simpy.rt']; "
        "names += ['axistwin.' + name for name in ('bench.acts', 'bench.codec', 'controllers.front', "
        "'controllers.digiplan.checker', 'controllers.smartmotor.language.image')]; "
        "print([name for name in names if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=PATIENCE_S, check=True)
    assert done.stdout == "b'0\\r'\n[]\n"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
@pytest.mark.parametrize("arguments", [["commands", "if1"], ["--help"], ["commands", "if1", "--json"]])
def test_an_output_that_cannot_be_written_is_one_line(arguments):
    program = [sys.executable, "-c", "from axistwin.cli.program import main; main()"]
    with Path("/dev/full").open("w") as full:
        ended = subprocess.run(
            [*program, *arguments], stdout=full, stderr=subprocess.PIPE, text=True, timeout=PATIENCE_S
        )
    assert (ended.returncode, ended.stderr) == (1, "axistwin: the output cannot be written: no space left on device\n")


@pytest.mark.parametrize(("arguments", "words"), [
    (["run", "if1", "a.if1", "--for", "nan"], "'nan' is not a number"),
    (["run", "if1", "a.if1", "--option", "state=/x"], "use --state"),
    (["run", "if1", "a.if1", "--option", "X=5"], "invalid value 5 for axis X: expected a table of options"),
    (["run", "if1", "a.if1", "--option", "X=5", "--option", "X.limits=[0,1]"],
     "--option X.limits=[0,1] conflicts with an earlier --option for X: remove one of the two"),
    (["run", "if1", "a.smx"], "a.smx is a compiled SmartMotor program")])  # fmt: skip
def test_wrong_usage_is_told_in_one_line_and_ends_with_2(arguments, words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.if1").write_text("X1$\n")
    assert main(*arguments) == 2 and words in capsys.readouterr().err
