"""`axistwin check`: places in files, output, exit codes."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from axistwin.bench import product
from axistwin.cli.authoring.check import diagnose
from axistwin.cli.program import axistwin
from axistwin.core.errors import AxistwinError, UsageError

from ..told import raises


@pytest.fixture
def check(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Result]:
    monkeypatch.chdir(tmp_path)

    def run(name: str, text: str, *options: str, model: str = "if1") -> Result:
        Path(name).write_text(text, encoding="utf-8")
        return CliRunner().invoke(
            axistwin, ["check", model, name, *options], catch_exceptions=False, standalone_mode=False
        )

    return run


TYPED = """\
; two mistakes
X1000 @ 500 $     ; fine
+1.5
  x-$
! input1 high
@30000            ; too fast for range 1
S2
"""


def test_command_lines(check):
    result = check("moves.if1", TYPED)
    assert result.return_value == 1
    assert result.stdout.splitlines() == [
        "moves.if1:4:3: error: unknown character 'x': commands are upper case (manual: Full command list) [DP101]",
        "moves.if1:6:1: error: speed 30000 is above 25000 steps/s, the maximum of range 1 (manual: Speed) [DP301]",
        (
            "moves.if1:7:2: warning: without $ at its end this message starts nothing "
            "(manual: Index mode instructions) [DP305]"
        ),
    ]
    assert result.stderr == "axistwin: moves.if1: 2 errors, 1 warning (1 can be fixed by --fix)\n"


def test_warnings_alone_do_not_fail(check):
    result = check("moves.if1", "S2\n")
    assert result.return_value == 0 and result.stderr == "axistwin: moves.if1: 1 warning\n"


def test_a_program_without_errors(check):
    result = check("moves.if1", "X1000$\n")
    assert (result.return_value, result.stdout) == (0, "") and result.stderr == "axistwin: moves.if1: nothing wrong\n"


def test_json_output(check):
    result = check("moves.if1", TYPED, "--json")
    found = json.loads(result.stdout)
    assert (result.return_value, result.stderr) == (1, "") and found["errors"] == 2
    assert found["diagnostics"][0] == {
        "file": "moves.if1", "line": 4, "column": 3, "severity": "error",
        "message": "unknown character 'x': commands are upper case", "chapter": "Full command list",
        "code": "DP101", "end_line": 4, "end_column": 4,
        "fix": {"title": "write X", "sure": True,
                "edits": [{"line": 4, "column": 3, "end_line": 4, "end_column": 4, "text": "X"}]},
    }  # fmt: skip


TALK = r"""; model: if1
+1.5
> (
< U\r
> U61\r
  > X100\x30$\rX\x31x$\r
! power off
! power on
> X1$\r
= X.position 0
"""


def test_a_conversation_with_escapes_divided_messages_and_power_cuts(check):
    assert check("a.talk", TALK).stdout.splitlines() == [
        "a.talk:6:21: error: unknown character 'x': commands are upper case (manual: Full command list) [DP101]",
        (
            "a.talk:9:3: warning: characters before ( are ignored, because the baud rate is unknown "
            "(manual: Initialisation) [DP401]"
        ),
    ]


def test_several_controllers_in_one_conversation(check):
    text = "left: > (U61\\r\nright: > (V61\\r\\n\nleft: > X1\nright: > y\\n\nleft: > 00$\\r\n"
    assert check("a.talk", text).stdout.splitlines() == [
        "a.talk:4:10: error: unknown character 'y': commands are upper case (manual: Full command list) [DP101]"
    ]


def test_an_unreadable_line_is_an_error_at_its_place(check):
    result = check("a.talk", "> (\n+1\n?what\n")
    assert result.return_value == 1 and result.stdout.startswith("a.talk:3:1: error: unknown kind of line")
    assert check("a.if1", "X100$\nXê$\n").stdout == "a.if1:2:2: error: 'ê' is not an ASCII character [AX104]\n"


def test_files_that_are_not_programs(check, tmp_path):
    raises(UsageError, "no model 'if9'", check, "a.if1", "", model="if9")
    with pytest.raises(UsageError, match=r"nowhere\.if1 cannot be read"):
        CliRunner().invoke(axistwin, ["check", "if1", "nowhere.if1"], catch_exceptions=False, standalone_mode=False)


EXAMPLES = sorted(
    path
    for path in (Path(__file__).parents[2] / "examples").rglob("*")
    if path.suffix in (".if1", ".181x", ".sms", ".toml")
)


@pytest.mark.parametrize("example", EXAMPLES, ids=str)
def test_the_examples_have_no_errors(example):
    model = ["if2"] if example.suffix == ".if1" else []
    result = CliRunner().invoke(axistwin, ["check", *model, str(example)], standalone_mode=False)
    assert result.stderr.endswith("nothing wrong\n")


def test_every_unreadable_line_is_reported(check):
    result = check("a.if1", "Xé$\n+soon\nx1$\n! input9 high\nY100$\n")
    assert [line.split(":")[1:3] for line in result.stdout.splitlines()] == [["1", "2"], ["2", "2"], ["3", "1"]]


@pytest.mark.parametrize(("name", "contents"), [("long.if1", b"X" * (5 << 20)), ("odd.if1", b"\xff\xfe")])
def test_a_binary_or_huge_file_is_refused(tmp_path, name, contents):
    (tmp_path / name).write_bytes(contents)
    with pytest.raises(AxistwinError, match=r"is too large|not text"):
        diagnose(tmp_path / name, product("if1").check)


def test_a_device_file_is_refused():
    raises(UsageError, "expected an ordinary file", diagnose, Path("/dev/null"), product("if1").check)


def test_a_binary_file_is_an_error_and_other_files_are_checked(tmp_path):
    (tmp_path / "odd.if1").write_bytes(b"\xff\xfe")
    (tmp_path / "bad.if1").write_text("x1$\n")
    arguments = ["check", str(tmp_path / "odd.if1"), str(tmp_path / "bad.if1"), "--json"]
    result = CliRunner().invoke(axistwin, arguments, standalone_mode=False)
    assert result.return_value == 1
    assert [found["code"] for found in json.loads(result.stdout)["diagnostics"]] == ["AX100", "DP101"]
