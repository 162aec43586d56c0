"""Apply fixes to a program; a file is replaced completely or stays unchanged."""

import os
import tempfile
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from axistwin.controllers.diagnostics import Diagnostic, Edit
from axistwin.errors import AxistwinError
from axistwin.storage import encoding_of, reason

MOST_ROUNDS = 10
"""Largest number of rounds of fixes, because a fix may reveal further errors."""


def fix_text(
    text: str, find: Callable[[str], Sequence[Diagnostic]]
) -> tuple[str, list[Diagnostic], Sequence[Diagnostic]]:
    """Correct the errors in a program text, except errors with several possible corrections.

    Returns the new text, the fixed diagnostics and the remaining diagnostics.

    A round that would add errors is not applied.
    """
    done: list[Diagnostic] = []
    found = find(text)
    for _ in range(MOST_ROUNDS):
        chosen = _without_overlaps(each for each in found if each.fix is not None and each.fix.sure)
        if not chosen:
            break
        better = apply(text, [edit for each in chosen if each.fix for edit in each.fix.edits])
        left = find(better)
        if _errors(left) > _errors(found):
            break
        text, found = better, left
        done += chosen
    return text, done, found


def _errors(found: Sequence[Diagnostic]) -> int:
    return sum(each.severity == "error" for each in found)


def _without_overlaps(fixable: Iterable[Diagnostic]) -> list[Diagnostic]:
    """Select diagnostics whose fixes change different parts of the text.

    If two fixes overlap, only the diagnostic of the first fix is selected.
    """
    chosen: list[Diagnostic] = []
    taken: list[Edit] = []
    for each in fixable:
        assert each.fix is not None
        edges = [(edit[:2], edit[2:4], other[:2], other[2:4]) for edit in each.fix.edits for other in taken]
        if not any(begin <= other_end and other_begin <= end for begin, end, other_begin, other_end in edges):
            chosen.append(each)
            taken += each.fix.edits
    return chosen


def apply(text: str, edits: Iterable[Edit]) -> str:
    """Apply edits to a text, and return the new text.

    The last edit is applied first.  The line ends do not change.
    """
    begins = [0]
    for line in text.splitlines(keepends=True):
        begins.append(begins[-1] + len(line))
    for edit in sorted(edits, reverse=True):
        begin, end = begins[edit.line - 1] + edit.column - 1, begins[edit.end_line - 1] + edit.end_column - 1
        text = text[:begin] + edit.text + text[end:]
    return text


def read_exactly(file: Path) -> tuple[str, str]:
    """Return the text of a file with unchanged line ends, and the encoding of the file."""
    data = file.read_bytes()
    encoding = encoding_of(data)
    return data.decode(encoding), encoding


def replace(file: Path, text: str, encoding: str) -> None:
    """Write a new text to a file.  Raises AxistwinError if the file cannot be written.

    A temporary file replaces the old file, so the file is never incomplete.
    """
    target = file.resolve()
    beside = None
    try:
        handle, beside = tempfile.mkstemp(prefix=f".{target.name}.", dir=target.parent)
        with os.fdopen(handle, "wb") as new:
            new.write(text.encode(encoding))
            new.flush()
            os.fsync(new.fileno())
        os.chmod(beside, target.stat().st_mode & 0o7777)
        os.replace(beside, target)
    except OSError as error:
        if beside is not None:
            Path(beside).unlink(missing_ok=True)
        raise AxistwinError(f"{file} cannot be written: {reason(error)}") from None
