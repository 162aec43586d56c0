"""Read the examples in an error message, so that a test can take them literally."""

import re
import tomllib
from typing import Any

_END = re.compile(r" in \0|, not (?:[\0\dtfN-]|$)|; | \(| for \d| for the | for real ")
_BETWEEN = re.compile(r",? or | and |, ")
_QUOTED = re.compile(r"""'[^']*'|"[^"]*"|`[^`]*`|\[(?:[^\[\]]|\[[^\]]*\])*\]|\{[^}]*\}""")


def examples(message: str) -> list[str]:
    """Return the examples after the last `e.g.`; none if the message has no example."""
    _, found, text = message.rpartition("e.g. ")
    if not found:
        return []
    kept = _QUOTED.findall(text)
    text = _QUOTED.sub("\0", text)
    parts = _BETWEEN.split(_END.split(text)[0])
    rest = iter(kept)
    return [re.sub("\0", lambda _: next(rest), part).strip() for part in parts]


def bare(example: str) -> str:
    """Return an example without its quotes."""
    return example[1:-1] if example[:1] in "'\"`" and example[-1:] == example[:1] else example


def value(example: str) -> Any:
    """Return an example as a value in TOML; a text may have no quotes in a message."""
    try:
        return tomllib.loads(f"v = {example}")["v"]
    except tomllib.TOMLDecodeError:
        return bare(example)
