"""Read a scene file; report an error in one line, with its place and a remedy."""

import json
import re
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from copy import copy
from pathlib import Path
from typing import Any, Self

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from axistwin.bench import rules, typography
from axistwin.core.errors import NoSceneError, ProgramError, SceneError, UsageError, instead, most_similar
from axistwin.core.numbers import HIGHEST, LOWEST, NumberError, check_values
from axistwin.core.storage import read_file
from axistwin.scenes import toml_places
from axistwin.scenes.tables import SceneFile, scene_schema
from axistwin.scenes.toml_text import toml

_MESSAGES = {
    # The library pydantic reports the error "missing" for `limits = [0]`, because the second number is missing.
    "missing": "expected two numbers",
    "too_long": "expected two numbers",
    "string_pattern_mismatch": "expected only letters, digits, _ and -",
}


MOST_NESTED = 50  # Largest depth of nested tables and lists.


def _depth(value: object) -> int:
    inner = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return 1 + max(map(_depth, inner), default=0)


class Source:
    """The text of a scene file, or `text` instead, with the line and column of each table and key."""

    def __init__(self, file: Path, text: str | None = None) -> None:
        self.file = file
        self.text = read_text(file) if text is None else text
        try:
            self.data = tomllib.loads(self.text)
            nested = _depth(self.data) > MOST_NESTED
        except tomllib.TOMLDecodeError as error:
            raise self._not_toml(message=str(error)) from None
        except RecursionError:
            nested = True
        except ValueError as error:  # Python's TOML parser raises ValueError for a number with thousands of digits.
            raise self._not_toml(message=str(error).partition(":")[0]) from None
        if nested:
            raise self._not_toml(f"tables or lists are nested too deeply: expected at most {MOST_NESTED} levels")
        self.places = toml_places.places(self.text)

    def with_data(self, data: dict[str, Any]) -> Self:
        """Return a copy of this object with `data` as the contents of the scene.  No file is written."""
        other = copy(self)
        other.data = data
        return other

    def contents(self) -> SceneFile:
        """Validate the contents of the scene, and return them.  Raises SceneError for a wrong key or value."""
        try:
            return self._validated()
        except ValidationError as error:
            raise self._first_of(errors=error.errors()) from None

    def errors(self) -> list[SceneError]:
        """Return the errors in all keys and values of the scene, sorted by line."""
        try:
            self._validated()
        except ValidationError as error:
            found = [self._error_at(each) for each in error.errors()]
            return sorted(found, key=lambda error: (error.line, error.column, error.message))
        return []

    def _validated(self) -> SceneFile:
        # Use JSON: the library pydantic converts a JSON array to a tuple, but does not convert a Python list.
        contents = SceneFile.model_validate_json(json.dumps(self.data, default=str), strict=True)
        try:
            check_values(self.data)
        except NumberError as error:
            raise self.error(
                f"the number at {'.'.join(map(str, error.path))} has more than 64 bits: expected {LOWEST} to {HIGHEST}",
                error.path,
                rules.VALUE.code,
            ) from None
        return contents

    def _error_at(self, error: ErrorDetails) -> SceneError:
        file, line, column = self._place_parts(error["loc"])
        rule = _RULES.get(error["type"], rules.VALUE)
        close = most_similar(str(error["loc"][-1]), _keys_at(error["loc"][:-1])) if _unknown(error) else ""
        return SceneError(_message_for(error), file=file, line=line, column=column, code=rule.code, instead=close)

    def error(self, message: str, path: toml_places.Path, code: str = "") -> SceneError:
        """Return an error at the place of `path`, or at the place of the nearest enclosing part."""
        file, line, column = self._place_parts(path)
        return SceneError(message, file=file, line=line, column=column, code=code)

    def _place_parts(self, path: toml_places.Path) -> tuple[str, int, int]:
        return str(self.file), *toml_places.place_of(path, self.places)

    def _not_toml(self, message: str) -> SceneError:
        """Convert a TOML error to a SceneError with its place, by default the end of the file."""
        what, _, _ = message.partition(" (at ")
        found = re.search(r"line (\d+), column (\d+)", message)
        end = self.text.count("\n") + 1, len(self.text) - self.text.rfind("\n")
        line, column = (int(found[1]), int(found[2])) if found else end
        wrong = (self.text.splitlines()[line - 1 : line] or [""])[0][column - 1 : column]
        message = f"not TOML: {typography.named(wrong) or what[:1].lower() + what[1:]}"
        return SceneError(message, file=str(self.file), line=line, column=column, code=rules.NO_TOML.code)

    @contextmanager
    def placing_errors(self, *path: str | int) -> Iterator[None]:
        """Within a `with` block, convert a UsageError or ProgramError to a SceneError at the place of `path`."""
        try:
            yield
        except UsageError as error:
            raise self.error(message=str(error), path=path) from None
        except ProgramError as error:
            raise self.error(message=str(error) if error.file else error.message, path=path) from None

    @contextmanager
    def placing_errors_at_key(self, path: toml_places.Path, *tables: tuple[str, Mapping[str, Any]]) -> Iterator[None]:
        """Within a `with` block, convert a UsageError to a SceneError at the deepest key that its message names.

        `tables`: the tables to search, each with its key below `path`; empty key: `path` itself.
        """
        try:
            yield
        except UsageError as error:
            named = [(*filter(None, (at,)), *keys) for at, table in tables for keys in _named(table, str(error))]
            raise self.error(message=str(error), path=(*path, *max(named, key=len, default=()))) from None

    def _first_of(self, errors: list[ErrorDetails]) -> SceneError:
        def order(error: ErrorDetails) -> tuple[toml_places.Place, bool, str]:
            return toml_places.place_of(error["loc"], self.places), error["type"] == "missing", _message_for(error)

        first = min(errors, key=order)
        more = f" (and {len(errors) - 1} more)" if errors[1:] else ""
        return self.error(_message_for(first) + more, first["loc"])


class Given(Source):
    """A scene that is created from a dict instead of a file.

    Its errors name a key instead of a line.  Paths in the scene are relative to the working directory.
    """

    def __init__(self, table: Mapping[str, Any]) -> None:
        super().__init__(Path("the scene"), toml(table))

    def _place_parts(self, path: toml_places.Path) -> tuple[str, int, int]:
        keys = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in path)
        return f"{self.file}, {keys.removeprefix('.')}" if path else str(self.file), 0, 0


def read_text(file: Path) -> str:
    """Return the text of a scene file.  Raises NoSceneError if the file cannot be read."""
    try:
        return read_file(file).decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
    except OSError as error:
        raise NoSceneError(f"the scene file cannot be read: {error.strerror}", file=str(file)) from None
    except UnicodeDecodeError:
        raise SceneError("the scene file is not a text file in UTF-8: save it as UTF-8", file=str(file)) from None


def _message_for(error: ErrorDetails) -> str:
    path = error["loc"]
    if not path:
        return f"cannot be read: {error['msg'].partition(' at line')[0]}"
    key = str(path[-1])
    if _unknown(error):
        return f"unknown key {key!r}: {instead(key, _keys_at(path[:-1]))}"
    if error["type"] == "missing" and isinstance(path[-1], str):
        return f"{key!r} is missing: add {'[[controller]]' if key == 'controller' else f'{key} = …'}"
    name = ".".join(str(part) for part in path if isinstance(part, str))
    what = _MESSAGES.get(error["type"]) or error["msg"].removeprefix("Value error, ")
    return f"{name}: {what[:1].lower()}{what[1:]}, not {json.dumps(error['input'], ensure_ascii=False)}"


def _named(table: Mapping[str, Any], message: str) -> Iterator[tuple[str, ...]]:
    for key, value in table.items():
        if re.search(rf"\b{re.escape(key)}\b", message):
            yield (key,)
            inner = _named(value, message) if isinstance(value, Mapping) else ()
            yield from ((key, *rest) for rest in inner)


_RULES = {
    "extra_forbidden": rules.UNKNOWN_KEY,
    "unexpected_keyword_argument": rules.UNKNOWN_KEY,
    "missing": rules.MISSING_KEY,
}
"""Rules for the error types of pydantic; an error of any other type is a wrong value."""


def _unknown(error: ErrorDetails) -> bool:
    return _RULES.get(error["type"]) is rules.UNKNOWN_KEY


def _keys_at(path: toml_places.Path) -> list[str]:
    schema = node = scene_schema()
    for part in path:
        node = _definition(schema, node)
        if isinstance(part, int):
            node = node["items"]
        else:
            node = node["properties"][part] if "properties" in node else node["additionalProperties"]
    return list(_definition(schema, node)["properties"])


def _definition(schema: dict[str, Any], node: dict[str, Any]) -> dict[str, Any]:
    node = node["anyOf"][0] if "anyOf" in node else node
    return schema["$defs"][node["$ref"].rpartition("/")[2]] if "$ref" in node else node
