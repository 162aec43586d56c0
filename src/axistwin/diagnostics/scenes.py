"""Check scenes: find all wrong keys and values, or else the first error that prevents building the scene."""

import re
from collections.abc import Iterator, Mapping
from os.path import isfile
from pathlib import Path

from axistwin.bench import rules
from axistwin.controllers.diagnostics import Diagnostic
from axistwin.controllers.product import Product
from axistwin.diagnostics.checking import PROGRAMS, as_diagnostic, kind_of
from axistwin.errors import SceneError
from axistwin.scenes.scene import Scene
from axistwin.scenes.source import Source, read_text

_SPAN = re.compile(r"""\[\[[^\]\n]*\]\]|\[[^\]\n]*\]|"[^"\n]*"|'[^'\n]*'|[\w-]+""")

_KEY = re.compile(r"""(?:[\w-]+|"[^"\n]*"|'[^'\n]*')(?:\.(?:[\w-]+|"[^"\n]*"|'[^'\n]*'))*[ \t]*=[ \t]*(?=[^\s#])""")
KEYS = (rules.UNKNOWN_KEY.code, rules.MISSING_KEY.code)
"""Codes of errors in a key; all other codes are for errors in a value."""


def diagnose_scene(file: Path, text: str | None = None) -> list[Diagnostic]:
    """Return the errors in a scene as diagnostics.

    If `text` is given, `text` is checked instead of the contents of the file.

    Raises SceneError if the file is missing or is not text.
    """
    text = read_text(file) if text is None else text
    return sorted(_as_diagnostic(error, text) for error in _errors(file, text))


def named_programs(scene: Path) -> Iterator[tuple[str, Path, Mapping[str, Product]]]:
    """Yield the program files that a scene file names, e.g. `move.sms`.

    Each item contains the endpoint, the file, and the models at all endpoints.

    Nothing is yielded if the scene itself has errors.  A file is yielded only once for each endpoint.
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
    """True if the diagnostic is about the program file `file`, and not about the scene file itself.

    The message of such a diagnostic begins with the file name.
    """
    return diagnostic.message.startswith(f"{file}:")


def _errors(file: Path, text: str) -> list[SceneError]:
    try:
        source = Source(file, text)
        return source.errors() or _build_errors(source)
    except SceneError as error:
        return [error]


def _build_errors(source: Source) -> list[SceneError]:
    """Build a scene, and return the errors that occur.

    The controllers save no data on the disk, so the state directories of the scene do not change.
    """
    contents = source.contents()
    for table in contents.controller:
        table.state = None
    return Scene(contents, source).build_errors()


def _as_diagnostic(error: SceneError, text: str) -> Diagnostic:
    """Convert an error in a scene file to a diagnostic with a line and a column.

    The diagnostic marks the word at the place of the error.  If a value is wrong, the diagnostic marks the value
    instead of the key.
    """
    lines = text.splitlines()
    line, column = error.line or 1, error.column or 1
    if error.code not in KEYS and line <= len(lines) and (key := _KEY.match(lines[line - 1], column - 1)):
        column = error.column = key.end() + 1
    found = _SPAN.match(lines[line - 1], column - 1) if line <= len(lines) else None
    error.code, error.width = error.code or rules.SCENE.code, len(found[0]) if found else 1
    return as_diagnostic(error)
