"""Output formats of diagnostics: text, JSON, SARIF 2.1.0, GitHub workflow commands."""

import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

import click

from axistwin.controllers.diagnostics import Diagnostic, Severity
from axistwin.core.version import VERSION
from axistwin.scenes.diagnostics.codes import select

SARIF = "https://json.schemastore.org/sarif-2.1.0.json"
COLOURS = {Severity.ERROR: "red", Severity.WARNING: "yellow"}


@dataclass(frozen=True)
class Checked:
    """A file that has been checked, with its text and its diagnostics."""

    file: Path
    text: str
    found: Sequence[Diagnostic]
    model: str = ""
    scene: Path | None = None  # The scene that names the file; None if the user has named the file.

    @property
    def shown(self) -> str:
        """The file as shown to the user: `scene.toml → moves.if1`."""
        return str(self.file) if self.scene is None else f"{self.scene} → {self.file}"


def as_text(checked: Checked, excerpts: bool) -> Iterator[str]:
    lines = checked.text.splitlines() if excerpts else []
    for each in checked.found:
        place = click.style(f"{checked.shown}:{each.line}:{each.column}:", bold=True)
        severity = click.style(f"{each.severity}:", fg=COLOURS[each.severity], bold=True)
        yield f"{place} {severity} {_message(each)} [{each.code}]"
        if each.line <= len(lines):
            yield from _excerpt(lines[each.line - 1], each)


def _message(diagnostic: Diagnostic) -> str:
    return diagnostic.message + (f" (manual: {diagnostic.chapter})" if diagnostic.chapter else "")


def _excerpt(line: str, diagnostic: Diagnostic) -> Iterator[str]:
    end_line, end = diagnostic.end
    width = max(1, (end if end_line == diagnostic.line else len(line) + 1) - diagnostic.column)
    yield f"    {line.expandtabs(1)}"
    yield f"    {' ' * (diagnostic.column - 1)}{'^' * width}"


def as_json(checked: Sequence[Checked], model: str | None) -> str:
    found = [{**_file(each), **_plain(diagnostic)} for each in checked for diagnostic in each.found]
    errors = sum(each["severity"] is Severity.ERROR for each in found)
    files = [str(each.file) for each in checked]
    whole = {"model": model, "errors": errors, "warnings": len(found) - errors, "files": files, "diagnostics": found}
    return json.dumps(whole, ensure_ascii=False)


def _file(checked: Checked) -> dict[str, str]:
    return {"file": str(checked.file), **({} if checked.scene is None else {"scene": str(checked.scene)})}


def _plain(diagnostic: Diagnostic) -> dict[str, Any]:
    fields = asdict(diagnostic)
    if diagnostic.fix is not None:
        fields["fix"]["edits"] = [edit._asdict() for edit in diagnostic.fix.edits]
    return fields


def as_github(checked: Checked) -> Iterator[str]:
    """Yield each diagnostic as a GitHub Actions annotation, e.g. `::error file=a.sms,line=3,...`."""
    for each in checked.found:
        end_line, end = each.end
        name = _data(str(checked.file)).replace(":", "%3A").replace(",", "%2C")
        place = f"file={name},line={each.line},col={each.column},endLine={end_line},endColumn={end},title={each.code}"
        yield f"::{each.severity} {place}::{_data(_message(each))}"


def _data(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


# SARIF


def as_sarif(checked: Sequence[Checked]) -> str:
    codes = sorted({diagnostic.code for each in checked for diagnostic in each.found})
    driver = {"name": "axistwin", "semanticVersion": VERSION, "rules": [_rule(code) for code in codes]}
    results = [_result(each.file, diagnostic, codes) for each in checked for diagnostic in each.found]
    run = {"tool": {"driver": driver}, "columnKind": "unicodeCodePoints", "results": results}
    return json.dumps({"$schema": SARIF, "version": "2.1.0", "runs": [run]}, ensure_ascii=False)


def _rule(code: str) -> dict[str, Any]:
    (rule,) = select(code)
    return {
        "id": rule.code, "shortDescription": {"text": rule.title}, "fullDescription": {"text": rule.explanation},
        "help": {"text": f"{rule.explanation}\nManual: {rule.chapter}"},
        "defaultConfiguration": {"level": rule.severity},
    }  # fmt: skip


def _result(file: Path, diagnostic: Diagnostic, codes: Sequence[str]) -> dict[str, Any]:
    # A relative path in a SARIF report is relative to the working directory.
    artifact = {"uri": file.as_uri() if file.is_absolute() else quote(file.as_posix())}
    line, column = diagnostic.end
    region = _region(diagnostic.line, diagnostic.column, line, column)
    result: dict[str, Any] = {
        "ruleId": diagnostic.code, "ruleIndex": codes.index(diagnostic.code), "level": diagnostic.severity,
        "message": {"text": _message(diagnostic)},
        "locations": [{"physicalLocation": {"artifactLocation": artifact, "region": region}}],
    }  # fmt: skip
    if diagnostic.fix is not None:
        edits = [
            {"deletedRegion": _region(*edit[:4]), "insertedContent": {"text": edit.text}}
            for edit in diagnostic.fix.edits
        ]
        changes = [{"artifactLocation": artifact, "replacements": edits}]
        result["fixes"] = [{"description": {"text": diagnostic.fix.title}, "artifactChanges": changes}]
    return result


def _region(line: int, column: int, end_line: int, end_column: int) -> dict[str, int]:
    return {"startLine": line, "startColumn": column, "endLine": end_line, "endColumn": end_column}
