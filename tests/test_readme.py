"""The commands in the README and in the pages of the families print what is shown under them."""

import re
import shlex
from pathlib import Path

import pytest
from click.testing import CliRunner

from axistwin.cli.program import axistwin

ROOT = Path(__file__).resolve().parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
PAGES = README, *(page.read_text(encoding="utf-8") for page in sorted((ROOT / "docs" / "families").glob("*.md")))


def acts():
    """Return each `$ command` of the console blocks with the output shown under it."""
    for block in re.findall(r"```console\n(.*?)```", "\n".join(PAGES), re.DOTALL):
        yield from re.findall(r"^\$ (.*)\n((?:(?!\$ ).*\n)*)", block, re.MULTILINE)


def test_the_consoles_show_what_is_printed(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    ran = 0
    for command, shown in acts():
        program, *arguments = shlex.split(command)
        if program == "cat":
            Path(arguments[0]).write_text(shown, encoding="utf-8")
        elif arguments[0] != "serve":  # tests/cli/test_serve.py tests this command
            assert CliRunner().invoke(axistwin, arguments).stdout == shown
            ran += 1
    assert ran == 2


@pytest.mark.parametrize("program", re.findall(r"```python\n(.*?)```", README, re.DOTALL))
def test_the_program_runs(program):
    exec(compile(program, "README.md", "exec"), {})


def test_the_set_up_is_what_ci_runs():
    ci = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    (test_command,) = re.findall(r"^python3 -m venv .*pytest$", README, re.MULTILINE)
    assert test_command in ci.splitlines()
