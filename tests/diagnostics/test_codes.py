"""The tables of codes: the example of each code has its diagnostic, and `check --codes` explains each code."""

import json
import re
from pathlib import Path

import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin.bench import product
from axistwin.cli.program import axistwin
from axistwin.core.errors import UsageError
from axistwin.scenes.diagnostics import codes
from axistwin.scenes.diagnostics.checking import diagnose_text, product_for
from axistwin.scenes.diagnostics.scenes import diagnose_scene

RULES = [(title, rule) for title, table in codes.tables().items() for rule in table]
OWN = [
    (title, rule) for title, rule in RULES if title != codes.DEVICES
]  # Those of devices: tests/devices/test_check.py


def found(title, rule):
    suffix = codes.suffix_of(rule)
    if suffix == ".toml":
        return diagnose_scene(Path("bench.toml"), rule.example)
    made = (
        product_for(suffix, rule.example)
        if "model:" in rule.example
        else product(codes.FAMILIES.get(title, ("if1",))[0])
    )
    return diagnose_text(rule.example, suffix, made)


@pytest.mark.parametrize(("title", "rule"), OWN, ids=[rule.code for _, rule in OWN])
def test_the_example_of_a_code_has_this_diagnostic(title, rule):
    cases = [diagnostic for diagnostic in found(title, rule) if diagnostic.code == rule.code]
    assert cases and {case.severity for case in cases} == {rule.severity}
    assert all(case.end > (case.line, case.column) for case in cases)


def test_codes_are_unique_and_in_order():
    listed = [rule.code for _, rule in RULES]
    assert len(set(listed)) == len(listed)
    for table in codes.tables().values():
        assert [rule.code for rule in table] == sorted(rule.code for rule in table)
    assert all(re.fullmatch(r"(DP|CM|SM|DV|AX|SC)\d{3}", code) for code in listed)


def test_each_code_has_a_title_and_an_explanation():
    for _, rule in RULES:
        assert rule.title[0] == rule.title[0].lower() or rule.title[:1] in "F%SR", rule.code
        assert rule.explanation.endswith("."), rule.code
        assert rule.chapter, rule.code


PROGRAMS = [(".if1", "if2"), (".181x", "1811"), (".sms", "smartmotor"), (".talk", "if2"), (".talk", "smartmotor")]
WORDS = st.sampled_from(
    ["X100", "$", ":", "x", " ", "\n", "> ", "\\r", "(", "U61", "33 00", "go_relative", "31", "D9 01", "a=1", "GOTO5",
     "endif", "a = 1", "F=32", "C1", "RETURN", "MC", "aw[0] 1 2", "-----", "A100", "+1", "! power off", "é", "%"]
)  # fmt: skip


@pytest.mark.parametrize(("suffix", "model"), PROGRAMS, ids=lambda value: value.strip("."))
@settings(max_examples=50)
@given(words=st.lists(WORDS, max_size=12))
def test_each_diagnostic_has_a_known_code_and_its_severity(suffix, model, words):
    severities = {rule.code: rule.severity for _, rule in RULES}
    for diagnostic in diagnose_text("".join(words), suffix, product(model)):
        assert diagnostic.severity == severities[diagnostic.code]
        assert diagnostic.end > (diagnostic.line, diagnostic.column)


def explain(*arguments):
    return CliRunner().invoke(axistwin, ["check", *arguments], catch_exceptions=False, standalone_mode=False)


def test_a_code_is_explained():
    assert explain("--codes", "dp301").stdout.splitlines() == [
        "DP301  the speed is above the maximum of the speed range (error)",
        (
            "  The highest speeds of the speed ranges 1 to 4 are 25000, 50000, 100000 and 4000 steps/s.  "
            "The interface keeps the range and the speed for later messages."
        ),
        "  Manual: Speed",
        "  Example (.if1):",
        "    @25001",
    ]


def test_codes_are_selected_by_their_beginning():
    assert set(re.findall(r"^(\w+)  ", explain("--codes", "CM4").stdout, re.MULTILINE)) == {
        "CM401", "CM402", "CM403", "CM404",
    }  # fmt: skip
    assert len(json.loads(explain("--codes", "--json").stdout)) == len(RULES)


def test_an_unknown_code():
    with pytest.raises(UsageError, match="unknown diagnostic code 'DP310': did you mean DP30"):
        explain("--codes", "DP310")


@pytest.mark.parametrize("form", ["sarif", "github"])
def test_codes_are_not_printed_in_formats_for_diagnostics(form):
    """Formats for diagnostics such as SARIF cannot contain a table of codes."""
    with pytest.raises(UsageError, match=f"invalid --format {form} for --codes: expected text or json"):
        explain("--codes", "CM4", "--format", form)
