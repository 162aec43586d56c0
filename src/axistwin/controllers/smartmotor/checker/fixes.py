"""Suggested corrections of statements.  A fix is sure if the statement can have only one meaning."""

from collections.abc import Callable, Sequence
from itertools import pairwise

from axistwin.controllers.diagnostics import Edit, Fix, Sent, fixing, put_before, put_behind, replaced
from axistwin.controllers.smartmotor import rules
from axistwin.controllers.smartmotor.checker.findings import Findings
from axistwin.controllers.smartmotor.language import class5
from axistwin.controllers.smartmotor.language.expressions import Problem
from axistwin.controllers.smartmotor.language.language import digits_as_address, read

WITHOUT = frozenset({"ES400", "ES1000"})  # Commands removed in 4.76 without a replacement.


def of(sent: Sequence[Sent], text: str, problem: Problem) -> Fix | None:
    """Return a fix for one invalid statement; None if its meaning is not clear."""
    if problem.rule is rules.EQUAL_SIGN:
        name = text.rstrip("-0123456789")
        return fixing("insert the equal sign", put_behind(sent[len(name) - 1], "="))
    if problem.rule is rules.ELEMENTS and read(f"{text}.").problem is None:
        return fixing("end the values with a period", put_behind(sent[-1], "."))
    if problem.rule is rules.LATER and (later := class5.find(text, class5.COMMANDS)) is not None:
        return _of_class5(sent, later)
    if problem.rule is rules.ADDRESS and (address := digits_as_address(text)) is not None:
        written = rf"\x{address[0]:X}{address[1]}"
        return fixing(f"write {written}", replaced(sent, written))
    return None


def _of_class5(sent: Sequence[Sent], later: class5.Found) -> Fix | None:
    if any(read(word).problem is not None for word in later.here.split()):
        return None
    return fixing(f"write {later.here}", replaced(sent, later.here), later.sure)


def in_program(findings: Findings, number: int, problem: Problem) -> Fix | None:
    """Return the fix for a statement in a program; the fix may depend on the neighbouring statements."""
    find = _IN_PROGRAM.get(problem.rule.code)
    if find is not None:
        return find(findings, number)
    return of(findings.text(number), findings.statements[number].text, problem)


def _removed(findings: Findings, number: int) -> Fix | None:
    if findings.statements[number].text not in WITHOUT:
        return None
    return fixing("leave it out", replaced(findings.text(number), ""))


def _blanks(findings: Findings, number: int) -> Fix | None:
    text = findings.statements[number].text
    first, last = number - text.startswith("="), number + text.endswith("=")
    if first < 0 or last >= len(findings.statements) or findings.line(first) != findings.line(last):
        return None
    if first == number and findings.statements[last].problem is None:
        return None  # The text "a= S" is ambiguous: S may be the value of a, or a separate command.
    parts = range(first, last + 1)
    whole = "".join(findings.statements[part].text for part in parts)
    if read(whole).problem is not None:
        return None
    return fixing(f"write {whole}", (_gap(findings, left, right) for left, right in pairwise(parts)))


def _unfinished(findings: Findings, number: int) -> Fix | None:
    return _blanks(findings, number) if findings.statements[number].text.endswith("=") else None


def _gap(findings: Findings, left: int, right: int) -> Edit:
    before, behind = findings.text(left)[-1], findings.text(right)[0]
    return Edit(before.line, before.column + before.width, behind.line, behind.column, "")


def _upper_case(findings: Findings, number: int) -> Fix | None:
    """Return a fix to upper case, sure if the whole line becomes valid; else it may be a comment."""
    statement = findings.statements[number]
    line = findings.line(number)
    beside = [each for at, each in enumerate(findings.statements) if findings.line(at) == line]
    sure = all(each.problem is None or read(each.text.upper()).problem is None for each in beside)
    better = statement.text.upper()
    return fixing(f"write {better}", replaced(findings.text(number), better), sure)


def _printed(findings: Findings, number: int) -> Fix | None:
    """Return a fix by which the program sends a command to another motor, which may be meant instead of its own."""
    address = digits_as_address(findings.statements[number].text)
    if address is None:
        return None
    better = f'PRINT(#{address[0]},"{address[1]} ")'
    return fixing(f"write {better}", replaced(findings.text(number), better), sure=False)


def _comment(findings: Findings, number: int) -> Fix | None:
    """Return a fix that turns the statement into a comment.  The fix is sure if no other statement is on the line."""
    line = findings.line(number)
    alone = sum(findings.line(at) == line for at in range(len(findings.statements))) == 1
    return fixing("make it a comment", put_before(findings.text(number)[0], "'"), alone)


_IN_PROGRAM: dict[str, Callable[[Findings, int], Fix | None]] = {
    rules.REMOVED.code: _removed,
    rules.BLANKS.code: _blanks,
    rules.EXPRESSION.code: _unfinished,
    rules.CASE.code: _upper_case,
    rules.NO_COMMENT.code: _comment,
    rules.ADDRESS.code: _printed,
}
