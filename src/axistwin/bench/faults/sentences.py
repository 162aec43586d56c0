"""Read and write faults as lines of text, for conversations and scripts.

    lose 3                              the next three characters to the default controller
    stuck input1 low duration=0.5
    jam X when="X passes 1000" duration=0.25
    flip serial way=from probability=0.01 seed=7

The first word is the kind.  The place, the values of parameters and NAME=VALUE follow in any order.
"""

import shlex
from collections.abc import Callable
from typing import Any

from axistwin.bench.faults.injector import Fault, Faults, Terms
from axistwin.bench.faults.kinds import kind_of
from axistwin.bench.faults.table import Kind
from axistwin.core.errors import UsageError
from axistwin.core.numbers import HIGHEST, NumberError, real, shortened, whole

TERMS: dict[str, Callable[[str], Any]] = {
    "name": str, "at": real, "when": str, "nth": whole, "duration": real, "seed": whole,
}  # fmt: skip
"""Properties of every fault, with their types."""


def read(text: str, faults: Faults, here: str = "") -> Callable[[], Fault]:
    """Return a function that adds the fault `lose 3` to the bench; `here`: the default controller."""
    words = _split(text)
    if not words:
        raise UsageError("the description of the fault is missing: expected KIND PLACE VALUES, e.g. stuck input1 low")
    kind = kind_of(words[0])
    named, bare = _sorted(words[1:])
    if "on" not in named and bare:
        spots = faults.spots(kind.on, here)
        place = next((word for word in bare if word in spots), None)
        if place is not None:
            bare.remove(place)
            named["on"] = place
    named |= _in_order(kind, bare, named)
    terms = {name: named.pop(name) for name in TERMS if name in named}
    return faults.plan(kind.name, named.pop("on", ""), Terms(**terms, here=here), named)


def name_in(text: str) -> str | None:
    """Return the name in `jam X name=late`; None if the description is invalid or names none."""
    try:
        words = _split(text)
    except UsageError:
        return None
    return next((word.removeprefix("name=") for word in words if word.startswith("name=")), None)


def write(fault: Fault) -> str:
    """Return the text with which a conversation adds an equal fault that begins at once."""
    words = [fault.kind.name, fault.spot.name]
    words += [f"{name}={_shown(value)}" for name, value in fault.values.items() if value is not None]
    words += [f"seed={fault.seed}"] if fault.seed is not None else []
    return " ".join([*words, f"name={shlex.quote(fault.name)}"])


def _split(text: str) -> list[str]:
    lexer = shlex.shlex(text, posix=True, punctuation_chars=False)
    lexer.whitespace_split, lexer.escape, lexer.commenters = True, "", ""
    try:
        return list(lexer)
    except ValueError:
        raise UsageError(f"a quotation mark is missing in {text!r}: expected e.g. when='X passes 1000'") from None


def _sorted(words: list[str]) -> tuple[dict[str, Any], list[str]]:
    named: dict[str, Any] = {}
    bare: list[str] = []
    for word in words:
        name, equals, value = word.partition("=")
        if not equals:
            bare.append(word)
        elif name in named:
            raise UsageError(f"{name} is given twice: expected {name}=VALUE only once")
        else:
            named[name] = _value(name, value)
    return named, bare


def _value(name: str, text: str) -> Any:
    if name not in TERMS:
        return text
    try:
        return TERMS[name](text)
    except NumberError:
        number = f"whole number up to {HIGHEST}" if TERMS[name] is whole else "number"
        raise UsageError(f"invalid value {name}={shortened(text)}: expected a {number}, e.g. {name}=1") from None


def _in_order(kind: Kind, bare: list[str], named: dict[str, Any]) -> dict[str, str]:
    """Find the parameters of `3` in `lose 3`: in order, those that are not given by name."""
    free = [parameter.name for parameter in kind.parameters if parameter.name not in named]
    if len(bare) > len(free):
        extra = bare[len(free)]
        raise UsageError(f"unexpected value {extra!r} of the fault {kind.name}: leave out {extra!r}")
    return dict(zip(free, bare, strict=False))


def _shown(value: Any) -> str:
    if isinstance(value, bool):
        return "high" if value else "low"
    return repr(value) if isinstance(value, float) else str(value)
