"""A remedy leads out: whoever does literally what `axistwin check` says has a program without this problem."""

import re
from itertools import product as product_of
from pathlib import Path

import pytest

from axistwin.bench import Bench, product
from axistwin.controllers.compumotor.checker.texts import name_of
from axistwin.controllers.diagnostics import Diagnostic
from axistwin.scenes.diagnostics import codes
from axistwin.scenes.diagnostics import fix as check_fix
from axistwin.scenes.diagnostics.checking import diagnose_text
from axistwin.scenes.diagnostics.scenes import diagnose_scene

from ..command import run
from .remedies import REMEDIES, Remedy

RULES = {
    rule.code: (title, rule)
    for title, table in codes.tables().items()
    for rule in table
    if title != codes.DEVICES  # tests/devices/test_check.py
}
IDS = [f"{each.code}-{each.says[:40]}" for each in REMEDIES]


CONVERSATION = re.compile(r"; model:|(?:.*\n)*> ")


def suffix_of(code: str, text: str) -> str:
    if RULES[code][1].suffix == ".toml":
        return ".toml"
    return ".talk" if CONVERSATION.match(text) else family(code)[1]


def model_of(code: str, text: str) -> str:
    named = re.match(r"; model: (\w+)", text)
    return named[1] if named else family(code)[0]


def family(code: str) -> tuple[str, str]:
    """Return the model and the suffix of programs for a code; lines of all families are tried with an IF1."""
    return codes.FAMILIES.get(RULES[code][0], ("if1", ".if1"))


def diagnose(code: str, text: str) -> list[Diagnostic]:
    suffix = suffix_of(code, text)
    if suffix == ".toml":
        return diagnose_scene(Path("bench.toml"), text)
    return diagnose_text(text, suffix, product(model_of(code, text)))


def mended(remedy: Remedy) -> str:
    if remedy.mended is not None:
        return remedy.mended
    fix = next(each.fix for each in diagnose(remedy.code, remedy.fault) if each.code == remedy.code)
    assert fix is not None
    return check_fix.apply(remedy.fault, fix.edits)


@pytest.mark.parametrize("remedy", REMEDIES, ids=IDS)
def test_a_remedy_leads_out(remedy: Remedy, tmp_path: Path) -> None:
    rule = RULES[remedy.code][1]
    found = [each for each in diagnose(remedy.code, remedy.fault) if each.code == remedy.code]
    assert found and any(remedy.says in text for text in (*(each.message for each in found), rule.explanation))
    after = mended(remedy)
    left = diagnose(remedy.code, after)
    assert [each for each in left if each.code == remedy.code or each.severity == "error"] == []
    suffix = suffix_of(remedy.code, after)
    file = tmp_path / f"program{suffix}"
    file.write_text(after, encoding="utf-8")
    what = [file] if suffix == ".toml" else [model_of(remedy.code, after), file]
    done = run("run", *what, "--for", 3)
    assert (done.code, "refused" in done.err) == (0, False), done


def test_each_code_has_a_remedy() -> None:
    assert {each.code for each in REMEDIES} == RULES.keys()


COMMAND_LINES = {
    found for _, rule in RULES.values() for found in re.findall(r"`axistwin (commands \w+)`", rule.explanation)
}


def test_the_command_lines_in_explanations_work() -> None:
    assert COMMAND_LINES and [words for words in COMMAND_LINES if run(*words.split()).code] == []


def error_of(text: str, suffix: str, model: str) -> Diagnostic | None:
    return next((each for each in diagnose_text(text, suffix, product(model)) if each.severity == "error"), None)


def choices(message: str) -> list[str]:
    """Return the values that a message names: an example, a list, or the ends of a range."""
    expected = message.partition("expected ")[2] or message
    if example := re.search(r"e\.g\. (\S+)$", expected):
        return [example[1]]
    if listed := re.match(r"one of (.*)", expected):
        return listed[1].split(", ")
    ends = re.search(r"(-?\d+)…(-?\d+)?", expected)
    return [end for end in ends.groups() if end] if ends else []


DIGIPLAN = (
    ">{}", "<{}", ">3@{}", "^{}", "D{}", "X{}$", "H{}X1$", "L{}X1$", "X1S{}$", "X1R{}$", "X1P{},5$",
    "X1P1,{}$", ":X1:={},1:$",
)  # fmt: skip


def test_the_ends_of_a_range_of_an_if1_are_accepted() -> None:
    for form in DIGIPLAN:
        error = error_of(form.format(9_999_999_999), ".if1", "if1")
        assert error and error.code == "DP109", form
        assert [value for value in choices(error.message) if error_of(form.format(value), ".if1", "if1")] == [], form


FORMS = {str(command.code): command for command in product("smartmotor").commands}
LIMITED = [code for code, command in FORMS.items() if code[-1] in "=n" and code.isascii() and command.parameters]


def test_the_ends_of_a_range_of_a_smartmotor_are_accepted() -> None:
    for code, beyond in product_of(LIMITED, (2147483647, -2147483648, 9999)):
        error = error_of(f"{code.removesuffix('n')}{beyond}", ".sms", "smartmotor")
        if error is not None and error.code in ("SM109", "SM110"):
            assert choices(error.message), code
            left = [
                error_of(f"{code.removesuffix('n')}{value}", ".sms", "smartmotor") for value in choices(error.message)
            ]
            assert {each.code for each in left if each} <= {"SM202"}, code  # a label that is missing


VALUES = (
    "@P @PE @V A V P D T E AMPS TH THD CLK MFMUL MFDIV BASE SIZE CX CTR I SLN SLP KP W Bt U UA UGA UIA TEMP LEN EPTR a"
)


def test_a_value_is_reported_as_the_message_says() -> None:
    for value in VALUES.split():
        error = error_of(value, ".sms", "smartmotor")
        assert error and error.code == "SM105", value
        report = re.search(r"(\S+) reports it", error.message)
        assert report and error_of(report[1], ".sms", "smartmotor") is None, value


def test_a_report_has_the_value_itself() -> None:
    """RP reports the measured position, so another statement reports the target P."""
    bench = Bench()
    motor = bench.add("smartmotor")
    bench.run(1)
    for value, number in {"P": 123, "V": 7000, "A": 5, "D": -9, "SLN": -77, "@P": 0}.items():
        error = error_of(value, ".sms", "smartmotor")
        assert error
        report = re.search(r"(\S+) reports it", error.message)
        assert report
        motor.serial.write(f"{value}={number}\r".encode() if value.isalpha() else b"")
        motor.serial.write(f"{report[1]}\r".encode())
        bench.run(0.2)
        assert motor.serial.read() == f"{number}\r".encode()


@pytest.mark.parametrize("code", [code for code, command in FORMS.items() if command.name == "removed"])
def test_what_to_write_for_a_removed_command_is_accepted(code: str) -> None:
    error = error_of(f"{code}1" if code.endswith("=") else code, ".sms", "smartmotor")
    assert error and error.code == "SM102"
    written = re.findall(r"write (?:e\.g\. )?((?:[A-Z]+[\w=]*\s?)+)", error.message)
    assert written or "remove this command" in error.message
    assert [error_of(each, ".sms", "smartmotor") for each in written] == [None] * len(written)


NAMES = [name_of(command) for command in product("1811").commands]


@pytest.mark.parametrize("end", [0, -1])
def test_the_messages_lead_from_each_name_to_its_values(end: int) -> None:
    for name in NAMES:
        led_to_its_values(name, end)


def led_to_its_values(name: str, end: int) -> None:
    """Each message names the values of a command, or a value for the first wrong word."""
    words = [name]
    for _ in range(20):
        error = error_of(" ".join(words), ".181x", "1811")
        if error is None or error.code not in ("CM110", "CM111", "CM112"):
            return
        told = error.message.partition("expected ")[2]
        if error.code == "CM112":
            assert len(words) == 1
            words += ["x"] * len(told.split())
        else:
            assert words[len(" ".join(words)[: error.column - 1].split())] == "x"
            words[len(" ".join(words)[: error.column - 1].split())] = choices(error.message)[end]
    raise AssertionError(f"no way out of {words}")
