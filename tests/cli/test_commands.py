"""`axistwin commands`: a table, lines for grep, and JSON."""

import json

import pytest
from click.testing import CliRunner

from axistwin.bench import product, show_controls
from axistwin.cli.program import axistwin
from axistwin.core.errors import UsageError


def run(*arguments: str) -> str:
    result = CliRunner().invoke(axistwin, ["commands", *arguments], catch_exceptions=False)
    assert result.exit_code == 0
    return result.stdout


@pytest.mark.parametrize("model", ["if1", "if2"])
def test_one_line_per_command(model):
    lines = run(model).splitlines()
    assert len(lines) == 1 + len(product(model).commands)
    assert lines[0].split() == ["code", "hex", "name", "syntax", "parameters", "chapter", "implemented"]
    assert all(line.endswith("yes") for line in lines[1:])


def test_syntax_and_ranges_of_some_commands():
    lines = {line.split()[0]: " ".join(line.split()) for line in run("if1").splitlines()}
    assert "X[+|-][distance] [direction], [distance 0…999999999 steps]" in lines["X"]
    assert "P output[,length] output 0…5, [length 1…99 x 10 ms]" in lines["P"]
    assert "= times,first step times 0…255, first step 1…63 Repeating parts of a sequence" in lines["="]
    assert "@ speed speed 1…99999 steps/s Speed" in lines["@"]
    assert "U frame parity frame 1…8, parity 1…9 Initialisation" in lines["U"]


def test_control_characters_are_in_words():
    assert [line.split()[:2] for line in run("if1").splitlines()[1:4]] == [
        ["<LF>", "0A"], ["<CR>", "0D"], ["<SP>", "20"],
    ]  # fmt: skip
    assert show_controls("U\r\n") == "U<CR><LF>" and show_controls("\x13\x80") == "<XOFF>\x80"


def test_the_same_for_machines():
    table = json.loads(run("if1", "--json"))
    assert table["model"] == "if1"
    by_code = {command["code"]: command for command in table["commands"]}
    assert by_code["H"]["parameters"] == [{"name": "inputs", "unit": "", "low": 1, "high": 3, "optional": False}]
    assert by_code["\r"]["implemented"] and by_code["K"]["chapter"] == "Motion status"


def test_no_such_model():
    with pytest.raises(UsageError, match="no model 'if9': expected one of if1, if2"):
        run("if9")
