"""Find the line and column of each part of a TOML file; `tomllib` returns only the contents.

    [[controller]]                  ("controller", 0)
    axes.X.limits = [-100, 8000]    ("controller", 0, "axes", "X", "limits")

The scanner expects texts that `tomllib` has accepted.  It reads headers and keys, and skips values.
"""

import re
from collections.abc import Iterator, Mapping

Path = tuple[str | int, ...]  # Keys and list indexes from the top of the file.
Place = tuple[int, int]  # Line and column, from 1.

_KEY = r"""(?:[\w-]+|"[^"\n]*"|'[^'\n]*')"""
_KEYS = rf"{_KEY}(?:[ \t]*\.[ \t]*{_KEY})*"
_TOKENS = re.compile(
    rf"""(?P<blank>[\s,]+|\#[^\n]*)
    |(?P<tables>\[\[[ \t]*(?P<listed>{_KEYS})[ \t]*\]\])
    |(?P<table>\[[ \t]*(?P<named>{_KEYS})[ \t]*\])
    |(?P<pair>(?P<keys>{_KEYS})[ \t]*=[ \t]*)""",
    re.VERBOSE,
)
_VALUE = re.compile(
    r'''"""(?:[^\\]|\\.)*?"{3,5}|\'\'\'.*?'{3,5}|"(?:[^"\\\n]|\\.)*"|'[^'\n]*'|[^\s,\[\]{}#]+''',
    re.DOTALL,
)


def places(text: str) -> dict[Path, Place]:
    return dict(reversed([*_Scanner(text).scan()]))


def spans(text: str) -> dict[Path, tuple[int, int]]:
    """Return the start and end index of each table header and value in a TOML text."""
    scanner = _Scanner(text)
    for _ in scanner.scan():
        pass
    return scanner.spans


def place_of(path: Path, known: Mapping[Path, Place]) -> Place:
    """Return line and column of a key in a TOML text; for an unknown key, those of its table."""
    while path and path not in known:
        path = path[:-1]
    return known.get(path, (1, 1))


class _Scanner:
    def __init__(self, text: str) -> None:
        self.text, self.at = text, 0
        self.spans: dict[Path, tuple[int, int]] = {}
        self.tables: dict[Path, int] = {}
        """Number of TOML headers read so far with the same name, e.g. 2 after the second [[controller]]."""

    def scan(self) -> Iterator[tuple[Path, Place]]:
        table: Path = ()
        while found := _TOKENS.match(self.text, self.at):
            begin, self.at = self.at, found.end()
            if found["tables"]:
                table = self._next_of(self._absolute(_split(found["listed"])))
                self.spans.setdefault(table, found.span())
                yield table, self._place(begin)
            elif found["table"]:
                table = self._absolute(_split(found["named"]))
                yield table, self._place(begin)
            elif found["pair"]:
                yield from self._pair(table, found["keys"], begin)

    def _pair(self, table: Path, keys: str, begin: int) -> Iterator[tuple[Path, Place]]:
        path = (*table, *_split(keys))
        for length in range(len(table) + 1, len(path) + 1):
            yield path[:length], self._place(begin)
        value_at = self.at
        yield from self._value(path)
        self.spans.setdefault(path, (value_at, self.at))

    def _value(self, path: Path) -> Iterator[tuple[Path, Place]]:
        match self.text[self.at : self.at + 1]:
            case "{":
                yield from self._inline_table(path)
            case "[":
                yield from self._array(path)
            case _:
                found = _VALUE.match(self.text, self.at)
                self.at = found.end() if found else len(self.text)

    def _inline_table(self, path: Path) -> Iterator[tuple[Path, Place]]:
        self.at += 1
        while not self._skip_to_bracket("}"):
            begin, found = self.at, _TOKENS.match(self.text, self.at)
            if not found or not found["pair"]:
                return
            self.at = found.end()
            yield from self._pair(path, found["keys"], begin)

    def _array(self, path: Path) -> Iterator[tuple[Path, Place]]:
        self.at += 1
        number = 0
        while not self._skip_to_bracket("]"):
            yield (*path, number), self._place(self.at)
            yield from self._value((*path, number))
            number += 1

    def _skip_to_bracket(self, bracket: str) -> bool:
        while (found := _TOKENS.match(self.text, self.at)) and found["blank"]:
            self.at = found.end()
        closed = self.text.startswith(bracket, self.at)
        self.at += closed
        return closed or self.at >= len(self.text)

    def _next_of(self, path: Path) -> Path:
        number = self.tables.get(path, 0)
        self.tables[path] = number + 1
        return (*path, number)

    def _absolute(self, keys: Path) -> Path:
        """Convert keys to a path: `controller.axes` after the second [[controller]] is ("controller", 1, "axes")."""
        path: Path = ()
        for key in keys[:-1]:
            path = (*path, key)
            if path in self.tables:
                path = (*path, self.tables[path] - 1)
        return (*path, keys[-1])

    def _place(self, at: int) -> Place:
        return self.text.count("\n", 0, at) + 1, at - (self.text.rfind("\n", 0, at) + 1) + 1


def _split(keys: str) -> Path:
    return tuple(key.strip("\"'") for key in re.findall(_KEY, keys))
