"""All codes of all checkers, for `axistwin check --codes` and for docs/diagnostics.md.

python -m axistwin.diagnostics.codes > docs/diagnostics.md
"""

from collections.abc import Iterable, Iterator
from difflib import get_close_matches
from typing import Any

from axistwin.bench import product, rules
from axistwin.controllers.diagnostics import Rule
from axistwin.errors import UsageError

FAMILIES = {
    "Digiplan IF1 and IF2": ("if2", ".if1"),
    "Compumotor 1810 and 1811": ("1811", ".181x"),
    "Animatics SmartMotor": ("smartmotor", ".sms"),
}
"""Each family, a model that has all of its codes, and the kind of file its examples are."""
OURS = "Programs, conversations and scenes"
LONGEST = 200
"""Characters of an example that are shown."""


def tables() -> dict[str, tuple[Rule, ...]]:
    """The table of codes of each family, and of what is common to all."""
    return {**{title: product(model).rules for title, (model, _) in FAMILIES.items()}, OURS: rules.RULES}


def suffix_of(rule: Rule) -> str:
    """The kind of file that its example is."""
    family = next(title for title, table in tables().items() if rule in table)
    return rule.suffix or FAMILIES[family][1]


def select(code: str) -> list[Rule]:
    """The rules with this code, or all that begin so: `DP`, `SM3`; empty: all.  Raises UsageError if there is none."""
    listed = {rule.code: rule for table in tables().values() for rule in table}
    found = [rule for each, rule in listed.items() if each.startswith(code.upper())]
    if not found:
        near = get_close_matches(code.upper(), listed, 1)
        raise UsageError(
            f"no code {code!r}: {f'did you mean {near[0]}?' if near else 'axistwin check --codes lists them'}"
        )
    return found


def as_dict(rule: Rule) -> dict[str, Any]:
    """The entry for `--format json`."""
    return {
        "code": rule.code,
        "title": rule.title,
        "severity": rule.severity,
        "chapter": rule.chapter,
        "explanation": rule.explanation,
        "example": rule.example,
        "suffix": suffix_of(rule),
    }


def explained(rule: Rule) -> Iterator[str]:
    """A rule in lines for a terminal."""
    yield f"{rule.code}  {rule.title} ({rule.severity})"
    yield f"  {rule.explanation}"
    yield f"  Manual: {rule.chapter}"
    yield f"  Example ({suffix_of(rule)}):"
    yield from (f"    {line}" for line in _shown(rule.example))


def page() -> str:
    """docs/diagnostics.md."""
    return "\n".join(_page())


HEAD = """\
# Diagnostics

What `axistwin check` and the language server can find. An **error** is refused by the controller; a **warning** is
obeyed, or ignored, but hardly as it was meant. A code keeps its meaning for good. `axistwin check --codes DP301`
explains one, `axistwin check --codes SM3` all that begin so.

```console
$ axistwin check if1 moves.if1
moves.if1:4:3: error: unknown character 'x': commands are upper case (manual: Full command list) [DP101]
```

| option | |
| --- | --- |
| `--format text` | one line each, `file:line:column: severity: message (manual: chapter) [code]` |
| `--format json`, `--json` | one object; places with their ends, fixes as edits |
| `--format sarif` | SARIF 2.1.0, for code scanning and editors |
| `--format github` | `::error file=…,line=…,col=…::message`, which GitHub shows beside the line |
| `--fix` | mends what can be meant in one way only, and says what it did; a file is replaced whole or not at all |
| `--strict` | warnings too make it fail |

Exit codes: 0 no errors, 1 errors, 2 wrong usage. The same findings appear while you type: [editors](editors.md).
"""


def _page() -> Iterator[str]:
    yield HEAD
    for title, table in tables().items():
        yield f"## {title}\n"
        yield "| code | | severity | manual |"
        yield "| --- | --- | --- | --- |"
        yield from (f"| [{r.code}](#{r.code.lower()}) | {r.title} | {r.severity} | {r.chapter} |" for r in table)
        yield ""
        for rule in table:
            yield from _section(rule)


def _section(rule: Rule) -> Iterable[str]:
    return (
        f"### {rule.code}\n",
        f"{rule.title[0].upper()}{rule.title[1:]}: {rule.severity}. Manual: {rule.chapter}.\n",
        f"{rule.explanation.replace('.  ', '. ')}\n",
        f"```{suffix_of(rule)[1:]}",
        *_shown(rule.example),
        "```\n",
    )


def _shown(example: str) -> list[str]:
    """Its lines; of a very long one, how it begins."""
    text = example if len(example) <= LONGEST else f"{example[:60].rstrip()} …"
    return text.splitlines()


if __name__ == "__main__":
    print(page(), end="")
