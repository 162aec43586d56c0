"""Apply fixes to a program; a file is replaced completely or stays unchanged, and a backup keeps its old contents."""

import difflib
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import count
from pathlib import Path

from axistwin.bench.talk.conversation import MOST_MIB
from axistwin.controllers.diagnostics import Diagnostic, Edit
from axistwin.core.errors import AxistwinError, printable, reason
from axistwin.core.storage import contents, encoding_of, split_at_end, write_whole

MOST_ROUNDS = 10  # Largest number of rounds of fixes, because a fix may reveal further errors.


def fix_text(
    text: str, find: Callable[[str], Sequence[Diagnostic]]
) -> tuple[str, list[Diagnostic], Sequence[Diagnostic]]:
    """Correct the errors in a program text, except errors with several possible corrections.

    Returns the new text, the fixed diagnostics and the remaining diagnostics.  A round that would add errors is not
    applied.
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
    """Apply edits to a text, and return the new text.  The last edit is applied first.  The line ends do not change."""
    begins = [0]
    for line in text.splitlines(keepends=True):
        begins.append(begins[-1] + len(line))
    for edit in sorted(edits, reverse=True):
        begin, end = begins[edit.line - 1] + edit.column - 1, begins[edit.end_line - 1] + edit.end_column - 1
        text = text[:begin] + edit.text + text[end:]
    return text


def read_exactly(file: Path) -> tuple[str, bytes, str]:
    """Return the text of a file with unchanged line ends, the bytes from a Ctrl-Z on, and the encoding of the text."""
    data, rest = split_at_end(contents(file, MOST_MIB))
    encoding = encoding_of(data)
    return data.decode(encoding, "surrogateescape"), rest, encoding


def replace(file: Path, text: str, rest: bytes, encoding: str) -> Path:
    """Write a new text to a file, then the bytes `rest`; return the file beside it that keeps the old contents.

    Raises AxistwinError if a file cannot be written; the old file is then unchanged.
    """
    target = file.resolve()
    backup = None
    try:
        backup = _backup(target)
        write_whole(target, text.encode(encoding, "surrogateescape") + rest)
    except OSError as error:
        if backup is not None:
            backup.unlink(missing_ok=True)
        raise AxistwinError(f"{file} cannot be written: {reason(error)}") from None
    return backup


def _backup(target: Path) -> Path:
    """Copy a file to a free name beside it, e.g. `home.sms.bak`.  Raises OSError."""
    names = (f"{target.name}.bak{number if number > 1 else ''}" for number in count(1))
    backup = next(path for name in names if not (path := target.with_name(name)).exists())
    write_whole(backup, target.read_bytes())
    os.chmod(backup, target.stat().st_mode & 0o7777)
    return backup


def difference(file: Path, before: str, after: str) -> Iterator[str]:
    """Yield the lines of a unified diff between two texts of a file, as printable text."""
    lines = (before.splitlines(), after.splitlines())
    for line in difflib.unified_diff(*lines, str(file), f"{file} (fixed)", lineterm=""):
        yield printable(line)
