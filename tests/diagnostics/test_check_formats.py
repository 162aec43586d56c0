"""`axistwin check` for several files, and its output as text, JSON, SARIF and GitHub workflow commands."""

import json
import re
from pathlib import Path

import pytest
from click.testing import CliRunner

from axistwin import __version__
from axistwin.cli.program import axistwin
from axistwin.core.errors import SceneError, UsageError
from axistwin.scenes.diagnostics import codes

from . import sarif

FILES = {
    "a b.if1": "x1000$\n@3000 X 5%5$\n", "home.sms": "A100 \nEND\n", "moves.181x": "33 00 00 00 01\n",
    "same.talk": "; model: if2\n> (U61\\r\n> S2\\r\n",
    "bench.toml": '[[controller]]\nmodel = "if1"\nnmae = "left"\naxes.X.limits = [100, 0]\n', "fine.if1": "X100$\n",
}  # fmt: skip


@pytest.fixture
def check(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, text in FILES.items():
        Path(name).write_text(text, encoding="utf-8")

    def run(*arguments):
        return CliRunner().invoke(axistwin, ["check", *arguments], catch_exceptions=False, standalone_mode=False)

    return run


def test_files_of_all_kinds_at_once_without_a_model(check):
    result = check("home.sms", "moves.181x", "same.talk", "bench.toml", "fine.if1")
    assert result.return_value == 1
    assert [re.sub(r": (error|warning): .* \[", " ", line) for line in result.stdout.splitlines()] == [
        "home.sms:1:1 SM103]", "moves.181x:1:1 CM305]", "same.talk:3:4 DP305]", "bench.toml:3:1 SC102]",
        "bench.toml:4:17 SC104]",
    ]  # fmt: skip
    assert result.stderr == "axistwin: 5 files: 4 errors, 1 warning (1 can be fixed by --fix)\n"


def test_a_model_is_for_all_programs(check):
    found = json.loads(check("1810", "moves.181x", "bench.toml", "--json").stdout)
    assert (found["model"], found["files"]) == ("1810", ["moves.181x", "bench.toml"])
    assert (found["errors"], found["warnings"]) == (3, 0)


def test_a_scene(check):
    result = check("bench.toml")
    assert result.stdout.splitlines()[0].startswith(
        "bench.toml:3:1: error: unknown key 'nmae': did you mean 'name'? [SC102]"
    )
    Path("bench.toml").write_text(FILES["bench.toml"].partition("nmae")[0] + 'state = "kept"\n', encoding="utf-8")
    assert check("bench.toml").stdout == "" and not Path("kept").exists()


def test_a_valid_scene_that_cannot_be_built(check):
    wire = '[[controller]]\nmodel = "if1"\n[[wire]]\nfrom = "if1.output1"\nto = "if1.inptu1"\n'
    Path("bench.toml").write_text(wire, encoding="utf-8")
    (line,) = check("bench.toml").stdout.splitlines()
    assert re.fullmatch(r"bench\.toml:5:6: error: if1 has no pin 'inptu1': .* \[SC110\]", line)


NAMING = """
[[controller]]
model = "if1"
name = "left"
host = ["bad.if1", "both.talk"]
[[controller]]
model = "smartmotor"
name = "right"
program = "home.sms"
[[script]]
at = 5
on = "left"
do = ["input1 high", "load late.if1"]
"""


def test_a_scene_is_checked_with_its_programs(check):
    for name, text in {
        "scene.toml": NAMING,
        "bad.if1": "X100$\nx\n",
        "both.talk": "; host: outside\n+2\nleft: > y\\r\nright: > FOO \n",
        "late.if1": "X1000@99999$\n",
    }.items():
        Path(name).write_text(text)
    result = check("scene.toml")
    assert result.return_value == 1
    assert [re.sub(r": (error|warning): .* \[", " ", line) for line in result.stdout.splitlines()] == [
        "scene.toml → bad.if1:2:1 DP101]", "scene.toml → both.talk:3:9 DP401]", "scene.toml → both.talk:4:10 SM503]",
        "scene.toml → home.sms:1:1 SM103]", "scene.toml → late.if1:1:6 DP301]",
    ]  # fmt: skip
    assert result.stderr.startswith("axistwin: scene.toml: ")
    found = json.loads(check("scene.toml", "--json").stdout)
    assert {(each["file"], each["scene"]) for each in found["diagnostics"]} >= {("bad.if1", "scene.toml")}
    assert found["files"] == ["scene.toml", "bad.if1", "both.talk", "home.sms", "late.if1"]


def test_an_unreadable_line_of_a_host_is_reported_once(check):
    Path("scene.toml").write_text('[[controller]]\nmodel = "if1"\nhost = "bad.if1"\n')
    Path("bad.if1").write_text("Xé$\n", encoding="utf-8")
    (line,) = check("scene.toml").stdout.splitlines()
    assert line.startswith("scene.toml → bad.if1:1:2: error:")


def test_fixes_are_applied_to_the_programs_of_a_scene(check):
    Path("scene.toml").write_text('[[controller]]\nmodel = "smartmotor"\nprogram = "home.sms"\n')
    assert check("scene.toml", "--fix").return_value == 0
    assert Path("home.sms").read_text() == "A=100 \nEND\n"


def test_warnings_fail_only_with_the_option(check):
    assert check("same.talk").return_value == 0 and check("same.talk", "--strict").return_value == 1
    assert check("fine.if1", "--strict").return_value == 0


def test_json_has_begin_and_end_of_places(check):
    found = json.loads(check("a b.if1", "--format", "json").stdout)["diagnostics"]
    assert check("a b.if1", "--json").stdout == check("a b.if1", "--format", "json").stdout
    assert [(d["line"], d["column"], d["end_line"], d["end_column"], d["code"]) for d in found] == [
        (1, 1, 1, 2, "DP101"), (2, 11, 2, 12, "DP102"),
    ]  # fmt: skip


def test_github_workflow_commands(check):
    (first, second) = check("a b.if1", "--format", "github").stdout.splitlines()
    assert first == (
        "::error file=a b.if1,line=1,col=1,endLine=1,endColumn=2,title=DP101::"
        "unknown character 'x': commands are upper case (manual: Full command list)"
    )
    assert "%25" not in first and second.startswith("::error file=a b.if1,line=2,")


def test_github_special_characters_are_escaped(check):
    Path("a,b:c.if1").write_text("%X$\n", encoding="utf-8")
    (line,) = check("a,b:c.if1", "--format", "github").stdout.splitlines()
    assert line.startswith("::error file=a%2Cb%3Ac.if1,line=1,") and "::%25 must be the only command" in line


def test_sarif_has_the_required_properties(check):
    result = check("a b.if1", "home.sms", "same.talk", "--format", "sarif")
    log = json.loads(result.stdout)
    assert (log["version"], result.return_value) == ("2.1.0", 1) and log["$schema"].endswith("sarif-2.1.0.json")
    (run,) = log["runs"]
    driver = run["tool"]["driver"]
    assert (driver["name"], driver["semanticVersion"]) == ("axistwin", __version__)
    assert run["columnKind"] == "unicodeCodePoints"
    assert [rule["id"] for rule in driver["rules"]] == ["DP101", "DP102", "DP305", "SM103"]
    assert all(rule["shortDescription"]["text"] for rule in driver["rules"])
    assert {rule["defaultConfiguration"]["level"] for rule in driver["rules"]} == {"error", "warning"}
    places = [location["physicalLocation"] for each in run["results"] for location in each["locations"]]
    assert {each["artifactLocation"]["uri"] for each in places} == {"a%20b.if1", "home.sms", "same.talk"}
    assert all(1 <= each["region"]["startLine"] <= each["region"]["endLine"] for each in places)
    assert all(each["region"]["startColumn"] < each["region"]["endColumn"] for each in places)


def test_a_fix_in_sarif(check):
    (result,) = json.loads(check("home.sms", "--format", "sarif").stdout)["runs"][0]["results"]
    (fix,) = result["fixes"]
    (change,) = fix["artifactChanges"]
    assert change["artifactLocation"]["uri"] == "home.sms"
    assert change["replacements"] == [{
        "deletedRegion": {"startLine": 1, "startColumn": 2, "endLine": 1, "endColumn": 2},
        "insertedContent": {"text": "="},
    }]  # fmt: skip


def test_sarif_has_file_uris_for_absolute_paths(check, tmp_path):
    log = json.loads(check(str(tmp_path / "home.sms"), "--format", "sarif").stdout)
    uri = log["runs"][0]["results"][0]["locations"][0]["physicalLocation"]["artifactLocation"]["uri"]
    assert uri == (tmp_path / "home.sms").as_uri()


@pytest.mark.parametrize(("arguments", "error", "message"), [
    ((), UsageError, "nothing to check: expected a program or a scene"), (("if1",), UsageError, "nothing to check"),
    (("if9", "fine.if1"), UsageError, "no model 'if9'"),
    (("fine.if1", "nowhere.if1"), UsageError, "nowhere.if1 cannot be read"),
    (("nowhere.toml",), SceneError, "nowhere.toml: the scene file cannot be read"),
    (("whose.talk",), UsageError, "unknown controller model")])  # fmt: skip
def test_files_that_cannot_be_checked(check, arguments, error, message):
    Path("whose.talk").write_text("> X\n", encoding="utf-8")
    with pytest.raises(error, match=message):
        check(*arguments)


def test_sarif_of_all_codes_is_valid(check):
    """All examples of rules are checked in one run; file names need escapes in URIs."""
    names = []
    for title, table in codes.tables().items():
        for rule in () if title == codes.DEVICES else table:
            suffix, model = codes.suffix_of(rule), codes.FAMILIES.get(title, ("if1",))[0]
            head = "" if suffix in (".toml", ".sms") or "model:" in rule.example else f"; model: {model}\n"
            names.append(f"{rule.code} é#?%.x{suffix}")
            Path(names[-1]).write_text(head + rule.example, encoding="utf-8")
    log = json.loads(check(*names, "--format", "sarif").stdout)
    assert sarif.problems(log) == []
    results, rules = log["runs"][0]["results"], log["runs"][0]["tool"]["driver"]["rules"]
    assert all(rules[each["ruleIndex"]]["id"] == each["ruleId"] for each in results)
    assert any("fixes" in each for each in results)
    assert {name[:5] for name in names} <= {each["ruleId"] for each in results}


def test_sarif_without_results_is_valid(check):
    log = json.loads(check("fine.if1", "--format", "sarif").stdout)
    assert sarif.problems(log) == []
    (run,) = log["runs"]
    assert (run["results"], run["tool"]["driver"]["rules"]) == ([], [])


@pytest.mark.parametrize(("path", "value", "problem"), [
    (("version",), "2.0.0", "$.version: '2.0.0' is not one of"),
    (("runs", 0, "results", 0, "level"), "fatal", "$.runs[0].results[0].level: 'fatal' is not one of"),
    (("runs", 0, "results", 0, "message"), {}, "$.runs[0].results[0].message: message has no text"),
    (("runs", 0, "colour"), 3, "$.runs[0]: run knows no colour")])  # fmt: skip
def test_the_sarif_checker_finds_errors(check, path, value, problem):
    log = json.loads(check("a b.if1", "--format", "sarif").stdout)
    *way, last = path
    place = log
    for key in way:
        place = place[key]
    place[last] = value
    (found,) = sarif.problems(log)
    assert found.startswith(problem)
