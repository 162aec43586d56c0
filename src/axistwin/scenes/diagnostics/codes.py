"""The codes of all checkers, for `axistwin check --codes` and for the documentation."""

from collections.abc import Iterator
from typing import Any

from axistwin.bench import product, rules
from axistwin.controllers.diagnostics import Rule
from axistwin.core.errors import UsageError, most_similar

FAMILIES = {
    "Digiplan IF1 and IF2": ("if2", ".if1"),
    "Compumotor 1810 and 1811": ("1811", ".181x"),
    "Animatics SmartMotor": ("smartmotor", ".sms"),
}
"""For each family of controllers, a model that has all codes, and the suffix of the examples."""
DEVICES, OURS = "Devices of your own", "Programs, conversations and scenes"
LONGEST = 200  # Number of characters above which an example is shortened.


def tables() -> dict[str, tuple[Rule, ...]]:
    from axistwin.bench import device_checker  # Imported here, because `check` of our models needs no device.

    families = {title: product(model).rules for title, (model, _) in FAMILIES.items()}
    return {**families, DEVICES: device_checker.RULES, OURS: rules.RULES}


def suffix_of(rule: Rule) -> str:
    """Return the suffix of the program files that a diagnostic rule checks, e.g. `.if1`."""
    family = next(title for title, table in tables().items() if rule in table)
    return rule.suffix or FAMILIES[family][1]


def select(code: str) -> list[Rule]:
    """Return the rules whose code begins with `code`, e.g. `DP` or `SM3`.  Raises UsageError if no code matches."""
    listed = {rule.code: rule for table in tables().values() for rule in table}
    found = [rule for each, rule in listed.items() if each.startswith(code.upper())]
    if not found:
        if similar := most_similar(code.upper(), listed):
            raise UsageError(f"unknown diagnostic code {code!r}: did you mean {similar}?")
        raise UsageError(f"unknown diagnostic code {code!r}: `axistwin check --codes` lists all codes")
    return found


def as_dict(rule: Rule) -> dict[str, Any]:
    return {
        "code": rule.code, "title": rule.title, "severity": rule.severity, "chapter": rule.chapter,
        "explanation": rule.explanation, "example": rule.example, "suffix": suffix_of(rule),
    }  # fmt: skip


def explained(rule: Rule) -> Iterator[str]:
    yield f"{rule.code}  {rule.title} ({rule.severity})"
    yield f"  {rule.explanation}"
    yield f"  Manual: {rule.chapter}"
    yield f"  Example ({suffix_of(rule)}):"
    yield from (f"    {line}" for line in shown(rule.example))


def shown(example: str) -> list[str]:
    text = example if len(example) <= LONGEST else f"{example[:60].rstrip()} …"
    return text.splitlines()
