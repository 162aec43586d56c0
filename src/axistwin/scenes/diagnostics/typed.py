"""Find typographic characters in the parts of a program that a controller receives; comments may contain them."""

import re
from collections.abc import Iterator, Sequence

from axistwin.bench import rules
from axistwin.bench.typography import MEANT, as_ascii, kinds, named
from axistwin.controllers.diagnostics import Diagnostic, Edit, Fix, Severity

_CODE = {
    ".talk": re.compile(r"(?:[^;]*?[<>].*|\s*;\s*(?:options|line):.*|[^;]*)"),
    ".sms": re.compile(r"""(?:"[^"]*(?:"|$)|[^"'])*'?"""),
}
"""Pattern of the part of a line that is not a comment, by suffix; otherwise a semicolon begins a comment."""
_BEFORE_SEMICOLON = re.compile(r"[^;]*")


def typographic(lines: Sequence[str], suffix: str) -> Iterator[Diagnostic]:
    """Yield one error for each kind of typographic character in a line; its fix replaces all of this kind there."""
    for number, line in enumerate(lines, start=1):
        if line.isascii():
            continue
        code = _CODE.get(suffix, _BEFORE_SEMICOLON).match(as_ascii(line))
        for places in kinds(line[: code.end()] if code else "").values():
            yield _found(line, number, places)


def _found(line: str, number: int, places: Sequence[int]) -> Diagnostic:
    character, column, rule = line[places[0]], places[0] + 1, rules.TYPOGRAPHIC
    edits = tuple(Edit(number, at + 1, number, at + 2, MEANT[line[at]]) for at in places)
    fix = Fix(f"write {MEANT[character].replace(' ', 'a blank')}", edits)
    return Diagnostic(number, column, Severity.ERROR, named(character), "", rule.code, number, column + 1, fix)
