"""Write values as TOML, so that data made in Python can be read like a file."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from axistwin.core.errors import UsageError


def toml(table: Mapping[str, Any]) -> str:
    """Return a dict as a TOML document with one line per key.  A list of tables has one line per table."""
    lines = []
    for key, value in table.items():
        if isinstance(value, list) and value:
            items = "".join(f"  {toml_value(item)},\n" for item in value)
            lines.append(f"{json.dumps(key)} = [\n{items}]\n")
        else:
            lines.append(f"{json.dumps(key)} = {toml_value(value)}\n")
    return "".join(lines)


def toml_value(value: Any) -> str:
    """Format a value as a line of TOML, without keys of None.  Raises UsageError for another type."""
    match value:
        case bool():
            return str(value).lower()
        case int() | float():
            return repr(value)
        case str() | Path():
            return json.dumps(str(value), ensure_ascii=False)
        case Mapping():
            pairs = (f"{json.dumps(key)} = {toml_value(item)}" for key, item in value.items() if item is not None)
            return f"{{{', '.join(pairs)}}}"
        case list() | tuple():
            return f"[{', '.join(map(toml_value, value))}]"
    raise UsageError(f"{value!r} is not allowed in a scene: expected text, numbers, lists and dicts")


def table_text(key: str, table: Mapping[str, Any]) -> str:
    lines = "".join(f"{name} = {toml_value(value)}\n" for name, value in table.items() if value is not None)
    return f"[[{key}]]\n{lines}"


def tables(data: Mapping[str, Any]) -> str:
    """Convert a dict to a TOML document.  A list of dicts is written as tables with the header [[name]]."""
    parts = [f"{key} = {toml_value(value)}\n" for key, value in data.items() if not _lists_tables(value)]
    parts += [f"\n{table_text(key, each)}" for key, value in data.items() if _lists_tables(value) for each in value]
    return "".join(parts).lstrip()


def _lists_tables(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(each, Mapping) for each in value)
