"""Check scenes: find all wrong keys and values, or else the first error that prevents building the scene."""

import re
from collections.abc import Iterator, Mapping
from os.path import isfile
from pathlib import Path

from axistwin.bench import rules
from axistwin.controllers.diagnostics import Diagnostic
from axistwin.controllers.product import Product
from axistwin.core.errors import SceneError
from axistwin.scenes.diagnostics.checking import PROGRAMS, as_diagnostic, kind_of
from axistwin.scenes.scene import Scene
from axistwin.scenes.source import Source, read_text

_SPAN = re.compile(r"""\[\[[^\]\n]*\]\]|\[[^\]\n]*\]|"[^"\n]*"|'[^'\n]*'|[\w-]+""")

_KEY = re.compile(r"""(?:[\w-]+|"[^"\n]*"|'[^'\n]*')(?:\.(?:[\w-]+|"[^"\n]*"|'[^'\n]*'))*[ \t]*=[ \t]*(?=[^\s#])""")
KEYS = (rules.UNKNOWN_KEY.code, rules.MISSING_KEY.code)
"""Codes of errors in a key; all other codes are for errors in a value."""


def diagnose_scene(file: Path, text: str | None = None) -> list[Diagnostic]:
    """Return a scene's diagnostics; `text` replaces the file's.  Raises SceneError for a missing or binary file."""
    text = read_text(file) if text is None else text
    return sorted(_as_diagnostic(error, text) for error in _errors(file, text))


def named_programs(scene: Path) -> Iterator[tuple[str, Path, Mapping[str, Product]]]:
    """Yield each program of a scene once for each endpoint: endpoint, file, and models at all endpoints.

    A scene with errors yields nothing.
    """
    try:
        loaded = Scene.load(scene)
    except SceneError:
        return
    seen = set()
    for endpoint, file in loaded.named_programs():
        if (endpoint, file) not in seen and kind_of(file) in PROGRAMS and isfile(file):
            seen.add((endpoint, file))
            yield endpoint, file, loaded.models


def is_of_program(diagnostic: Diagnostic, file: Path) -> bool:
    """True if a diagnostic of a scene repeats an error that is in this program."""
    return diagnostic.message.startswith(f"{file}:")


def _errors(file: Path, text: str) -> list[SceneError]:
    try:
        source = Source(file, text)
        return source.errors() or _build_errors(source)
    except SceneError as error:
        return [error]


def _build_errors(source: Source) -> list[SceneError]:
    contents = source.contents()
    for table in contents.controller:
        table.state = None
    return Scene(contents, source).build_errors()


def _as_diagnostic(error: SceneError, text: str) -> Diagnostic:
    """Convert the error of a scene to a diagnostic.

    It covers the word at the error's place; for a wrong value, the value instead of its key.
    """
    lines = text.splitlines()
    line, column = error.line or 1, error.column or 1
    if error.code not in KEYS and line <= len(lines) and (key := _KEY.match(lines[line - 1], column - 1)):
        column = error.column = key.end() + 1
    found = _SPAN.match(lines[line - 1], column - 1) if line <= len(lines) else None
    error.code, error.width = error.code or rules.SCENE.code, len(found[0]) if found else 1
    return as_diagnostic(error)
