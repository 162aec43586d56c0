"""Commands as patterns, e.g. `{axis}PA{position:int -1000..1000 steps}`, and why a request is refused."""

import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from enum import Enum
from math import isfinite
from typing import Any, NamedTuple

from axistwin.controllers.commandset import Field
from axistwin.core.errors import UsageError

_PART = re.compile(r"\{(?P<name>\w+)(?::(?P<kind>[^\s{}]+))?(?P<rest>[^{}]*)\}|.", re.DOTALL)
_FIXED = re.compile(r"(\w+)=(\d+)(?!\S)")
_RANGE = re.compile(r"(-?\d+(?:\.\d+)?)\.\.(-?\d+(?:\.\d+)?)")
MOST_DIGITS = 18  # Of an integer; one with more digits is in no range.


class Kind(NamedTuple):
    """A kind of values: its regular expression, that of anything sent in place of a value, and words for users."""

    form: str
    loose: str
    words: str
    convert: Callable[[str], Any] = str


_SOME_NUMBER = r"(?:[-+.\d][^\s,;]{0,40})?"
KINDS = {
    "int": Kind(r"[+-]?\d+", _SOME_NUMBER, "a whole number", int),
    "float": Kind(r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d{1,3})?", _SOME_NUMBER, "a number", float),
    "word": Kind(r"\w+", r"\w*", "letters, digits or _"),
    "text": Kind(r".*", r".*", "text"),
}


class Why(Enum):
    """Why a device refuses a request."""

    UNKNOWN = "unknown command"
    RANGE = "value out of range"
    FORMAT = "wrong format"  #: A check sum, a character error, a line that is too long.
    STATE = "not possible now"
    BUG = "error in the device"


class Refused(Exception):  # noqa: N818  # it is no error of the program
    """Raised by a handler that refuses a request; `code`: the number of the error in the device's manual."""

    entry: Any = None  # The command, if the request has one, and where in the line the wrong value is.
    span: tuple[int, int] | None = None

    def __init__(self, words: str, code: int = 0, why: Why = Why.STATE) -> None:
        super().__init__(words)
        self.words, self.code, self.why = words, code, why


@dataclass(frozen=True)
class Parameter(Field):
    """A placeholder in the pattern of a command: `{position:int -1000..1000 steps}`."""

    kind: str = "word"

    def words(self, axes: Mapping[str, Any]) -> list[str]:
        """Return the values that are names: those of the axes, or choices."""
        return list(axes) if self.kind == "axis" else self.kind.split("|")

    def expression(self, axes: Mapping[str, Any], loose: bool = False) -> str:
        """Return the regular expression of a value; `loose`: also of one in the wrong form."""
        if self.kind in KINDS:
            return KINDS[self.kind].loose if loose else KINDS[self.kind].form
        words = sorted(self.words(axes), key=len, reverse=True) or [""]
        return rf"\w{{0,{len(words[0])}}}" if loose else "|".join(map(re.escape, words)) or "(?!)"

    def convert(self, text: str, axes: Mapping[str, Any]) -> Any:
        """Return the value of a text in the right form.  Raises Refused outside of the range."""
        if self.kind not in KINDS:
            words = self.words(axes)
            return text if text in words else next((word for word in words if word.upper() == text.upper()), text)
        if self.kind == "int" and len(text.lstrip("+-0")) > MOST_DIGITS:
            raise Refused(f"{self.name} {text[:MOST_DIGITS]}…: expected {self}", why=Why.RANGE)
        return self.checked(KINDS[self.kind].convert(text))

    def checked(self, value: Any) -> Any:
        if isinstance(value, int | float) and not (isfinite(value) and self.allows(value)):  # type: ignore[arg-type]
            raise Refused(f"{self.name} {value}: expected {self}", why=Why.RANGE)
        return value

    def check_form(self, text: str, axes: Mapping[str, Any], ignore_case: bool) -> None:
        """Raise Refused for a value in the wrong form."""
        if not _compiled(self.expression(axes), ignore_case).fullmatch(text):
            words = KINDS[self.kind].words if self.kind in KINDS else " or ".join(self.words(axes))
            raise Refused(f"{self.name} {text!r}: expected {words}", why=Why.FORMAT)

    def example(self, axis: str) -> Any:
        if self.kind in ("int", "float"):
            return self.low if self.low is not None else min(0, self.high or 0)
        return axis if self.kind == "axis" else self.kind.partition("|")[0] if "|" in self.kind else "a"


class Pattern(NamedTuple):
    """A pattern as its author wrote it, in parts: a character, a parameter, or a bracket of an optional part."""

    parts: tuple[str | Parameter, ...]
    needed: tuple[str | Parameter, ...]  # The parts outside of brackets.
    fixed: Mapping[str, int]  # Fields of a datagram that have one value in this command.

    @classmethod
    def read(cls, text: str, place: str) -> "Pattern":
        """Raises UsageError for an invalid placeholder, or an optional part without its end."""
        parts, needed, depth = list[str | Parameter](), list[str | Parameter](), 0
        for found in _PART.finditer(text):
            depth += {"[": 1, "]": -1}.get(found[0], 0)
            parts.append(_parameter(found, place, optional=depth > 0) if found["name"] else found[0])
            needed += [] if depth or found[0] == "]" else parts[-1:]
        if depth or "{" in parts:
            raise UsageError(
                f"{place}: invalid pattern {text!r}: expected pairs of brackets, e.g. '{{axis}}PA[{{to:int}}]'"
            )
        made = cls(tuple(parts), tuple(needed), {name: int(number) for name, number in _FIXED.findall(text)})
        if twice := [name for name, count in Counter(part.name for part in made.parameters).items() if count > 1]:
            raise UsageError(f"{place}: two placeholders {{{twice[0]}}} in {text!r}: give one another name")
        return made

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return tuple(part for part in self.parts if isinstance(part, Parameter))

    @property
    def has_text(self) -> bool:
        return any(isinstance(part, str) and part not in "[]" for part in self.parts)

    def compiled(self, axes: Mapping[str, Any], ignore_case: bool, *, loose: bool = False) -> re.Pattern[str]:
        """Return the regular expression of a line; `loose`: also of one with values in the wrong form."""
        expression = _joined(
            self.parts,
            lambda one: f"(?P<{one.name}>{one.expression(axes, loose)})",
            lambda text: {"[": "(?:", "]": ")?"}.get(text) or re.escape(text),
        )
        return _compiled(expression, ignore_case)

    def filled(self, values: Mapping[str, Any]) -> tuple[str, str]:
        """Return the lines with these values: with and without the optional parts."""

        def line(parts: Iterable[str | Parameter]) -> str:
            return _joined(parts, lambda one: str(values[one.name]), lambda text: text.strip("[]"))

        return line(self.parts), line(self.needed)

    def examples(self, axis: str) -> tuple[str, str]:
        """Return two lines that match: with and without the optional parts."""
        return self.filled({one.name: one.example(axis) for one in self.parameters})

    def __str__(self) -> str:
        return _joined(self.parts, lambda one: f"<{one.kind if '|' in one.kind else one.name}>", str)


def _compiled(expression: str, ignore_case: bool) -> re.Pattern[str]:
    return re.compile(expression, re.ASCII | (re.IGNORECASE if ignore_case else 0))


def _joined(parts: Iterable[str | Parameter], value: Callable[[Parameter], str], text: Callable[[str], str]) -> str:
    return "".join(text(part) if isinstance(part, str) else value(part) for part in parts)


def _parameter(found: re.Match[str], place: str, *, optional: bool) -> Parameter:
    name, rest = found["name"], found["rest"].strip()
    kind = found["kind"] or ("axis" if name == "axis" else "word")
    if not name.isidentifier() or (kind not in (*KINDS, "axis") and "|" not in kind):
        raise UsageError(
            f"{place}: invalid placeholder {found[0]}: expected a name and {', '.join(KINDS)}, e.g. {{to:int 0..9}}"
        )
    span = _RANGE.match(rest)
    unit = rest[span.end() :].strip() if span else rest
    number: Callable[[str], Any] = float if kind == "float" else lambda end: int(float(end))
    ends: list[Any] = [number(end) for end in span.groups()] if span else [None, None]
    if ".." in unit or (span and ends[0] > ends[1]):
        raise UsageError(f"{place}: invalid range in {found[0]}: expected LOW..HIGH, e.g. {{{name}:{kind} 0..9}}")
    return Parameter(name, unit, ends[0], ends[1], optional, kind)
