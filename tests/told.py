"""Read an error message and its examples, so that a test can take them literally."""

import re
import tomllib
from collections.abc import Callable
from typing import Any

import pytest

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
    return example[1:-1] if example[:1] in "'\"`" and example[-1:] == example[:1] else example


def value(example: str) -> Any:
    """Return an example as a value in TOML; a text may have no quotes in a message."""
    try:
        return tomllib.loads(f"v = {example}")["v"]
    except tomllib.TOMLDecodeError:
        return bare(example)


def raises(
    error: type[Exception] | tuple[type[Exception], ...],
    words: str,
    act: Callable[..., object],
    *given: object,
    **options: object,
) -> Any:
    """Call `act`, which must raise this error with these words; return the error."""
    with pytest.raises(error) as told:
        act(*given, **options)
    assert words in str(told.value)
    return told.value
