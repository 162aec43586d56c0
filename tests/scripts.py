"""Tables of scripts: what a manual says, and what is said to a controller, done, and compared for it."""

import re
from collections.abc import Iterable

import pytest

CHOICE = re.compile(r"\{([^{}]*\|[^{}]*)\}")


def scripts(table: dict[str, str]) -> pytest.MarkDecorator:
    """Parametrise a test by scripts; each key is a section of the manual with its rule.

    `X{10|-10}$; 1 s; X at {10|-10}` are two scripts: one with the first word of each pair, one with the second.
    """
    cases = {}
    for said, script in table.items():
        choices = [choice.split("|") for choice in CHOICE.findall(script)]
        for words in zip(*choices, strict=True) if choices else [()]:
            cases[" ".join([said, *dict.fromkeys(words)])] = _choose(script, words)
    return pytest.mark.parametrize("script", cases.values(), ids=cases.keys())


def _choose(script: str, words: Iterable[str]) -> str:
    rest = iter(words)
    return CHOICE.sub(lambda _: next(rest), script)
