"""Values as TOML, for what has been made in Python and is to be read like a file."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from axistwin.errors import UsageError


def toml(table: Mapping[str, Any]) -> str:
    """A document with a line for each key; of each list of tables, a line for each of them."""
    lines = []
    for key, value in table.items():
        if isinstance(value, list) and value:
            items = "".join(f"  {toml_value(item)},\n" for item in value)
            lines.append(f"{json.dumps(key)} = [\n{items}]\n")
        else:
            lines.append(f"{json.dumps(key)} = {toml_value(value)}\n")
    return "".join(lines)


def toml_value(value: Any) -> str:
    """A value on one line.  None in a table is left out.  Raises UsageError for what TOML has not."""
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
    raise UsageError(f"{value!r} cannot stand in a scene: give text, numbers, lists and dicts")
