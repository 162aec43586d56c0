"""What is wrong with a scene: all keys and values, or else the first thing that keeps it from being built."""

import re
from pathlib import Path

from axistwin.bench import rules
from axistwin.controllers.diagnostics import Diagnostic
from axistwin.diagnostics.checking import as_diagnostic
from axistwin.errors import SceneError
from axistwin.scenes.scene import Scene
from axistwin.scenes.source import Source, read_text

_SPAN = re.compile(r"""\[\[[^\]\n]*\]\]|\[[^\]\n]*\]|"[^"\n]*"|'[^'\n]*'|[\w-]+""")


def diagnose_scene(file: Path, text: str | None = None) -> list[Diagnostic]:
    """Everything that can be told about a scene.  `text`: instead of what the file holds.

    Raises SceneError if there is no such file, or it is no text.
    """
    text = read_text(file) if text is None else text
    return sorted(_as_diagnostic(error, text) for error in _errors(file, text))


def _errors(file: Path, text: str) -> list[SceneError]:
    try:
        source = Source(file, text)
        found = source.complaints()
        if not found:
            _try(source)
    except SceneError as error:
        return [error]
    return found


def _try(source: Source) -> None:
    """Build it, without the state directories, so that nothing is left behind."""
    contents = source.contents()
    for table in contents.controller:
        table.state = None
    Scene(contents, source).build()


def _as_diagnostic(error: SceneError, text: str) -> Diagnostic:
    """With the code of a scene that cannot be built if it has none; about the word that stands at its place."""
    lines = text.splitlines()
    line, column = error.line or 1, error.column or 1
    found = _SPAN.match(lines[line - 1], column - 1) if line <= len(lines) else None
    error.code, error.width = error.code or rules.SCENE.code, len(found[0]) if found else 1
    return as_diagnostic(error)
