"""The command table of a device: what the decorators `command` and `query` collect from its methods.

Dispatcher, `axistwin commands`, checker, completion and documentation read this table.
"""

import inspect
import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from enum import Enum, Flag, auto
from math import isfinite
from pathlib import Path
from typing import Any, NamedTuple

from axistwin.controllers.commandset import Command, Field
from axistwin.core.errors import UsageError

Handler = Callable[..., Any]
_PART = re.compile(
    r"\{(?P<name>\w+)(?::(?P<kind>[^\s{}]+))?(?P<rest>[^{}]*)\}|(?P<bracket>[\[\]])|(?P<fixed>\w+=\d+)(?!\S)"
)
_RANGE = re.compile(r"(-?\d+(?:\.\d+)?)\.\.(-?\d+(?:\.\d+)?)")
KINDS = {
    "int": r"[+-]?\d+", "float": r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d{1,3})?", "word": r"\w+", "text": r".*",
}  # fmt: skip
LOOSE = {**dict.fromkeys(("int", "float"), r"(?:[-+.\d][^\s,;]{0,40})?"), "word": r"\w*", "text": r".*"}
"""For each kind what somebody may have sent in place of a value."""
MOST_DIGITS = 18  # Of an integer; one with more digits is in no range.
CONVERT: dict[str, Callable[[str], Any]] = {"int": int, "float": float}


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


class Always(Flag):
    """The commands of a device have no states: its handlers refuse what is not possible now."""

    ALWAYS = auto()


@dataclass(frozen=True)
class Parameter(Field):
    """A placeholder in the pattern of a command: `{position:int -1000..1000 steps}`."""

    kind: str = "word"

    def convert(self, text: str, axes: Mapping[str, str]) -> Any:
        """Return the value; `axes`: their names by those in upper case.  Raises Refused outside of the range."""
        if self.kind == "axis":
            return axes.get(text.upper(), text)
        if "|" in self.kind:
            return next((choice for choice in self.kind.split("|") if choice.upper() == text.upper()), text)
        if self.kind == "int" and len(text.lstrip("+-0")) > MOST_DIGITS:
            raise Refused(f"{self.name} {text[:MOST_DIGITS]}…: expected {self}", why=Why.RANGE)
        return self.checked(CONVERT.get(self.kind, str)(text))

    def expression(self, axes: Mapping[str, Any], loose: bool = False) -> str:
        """Return the regular expression of a value; `loose`: also of one in the wrong form."""
        if self.kind in KINDS:
            return (LOOSE if loose else KINDS)[self.kind]
        words = sorted(self.words(axes), key=len, reverse=True) or [""]
        return rf"\w{{0,{len(words[0])}}}" if loose else "|".join(map(re.escape, words)) or "(?!)"

    def words(self, axes: Mapping[str, Any]) -> list[str]:
        return list(axes) if self.kind == "axis" else self.kind.split("|")

    def misshapen(self, text: str, axes: Mapping[str, Any], flags: int) -> str:
        """Return what is wrong with the form of a value; "" if nothing is."""
        if re.fullmatch(self.expression(axes), text, flags):
            return ""
        form = {"int": "a whole number", "float": "a number", "word": "letters, digits or _"}.get(self.kind)
        return f"{self.name} {text!r}: expected {form or ' or '.join(self.words(axes))}"

    def checked(self, value: Any) -> Any:
        if isinstance(value, int | float) and not (isfinite(value) and self.allows(value)):  # type: ignore[arg-type]
            raise Refused(f"{self.name} {value}: expected {self}", why=Why.RANGE)
        return value

    def example(self, axis: str) -> Any:
        if self.kind == "axis":
            return axis
        if self.kind in CONVERT:
            return self.low if self.low is not None else min(0, self.high or 0)
        return self.kind.partition("|")[0] if "|" in self.kind else "a"


class Pattern(NamedTuple):
    """A pattern as its author wrote it, in parts: a text, a parameter, or a bracket of an optional part."""

    parts: tuple[str | Parameter, ...]
    fixed: Mapping[str, int]  # Fields of a datagram that have one value in this command.

    @classmethod
    def read(cls, text: str, place: str) -> "Pattern":
        """Raises UsageError for an invalid placeholder, or an optional part without its end."""
        parts: list[str | Parameter] = []
        fixed, end, depth = {}, 0, 0
        for found in _PART.finditer(text):
            parts += [text[end : found.start()]] if found.start() > end else []
            end = found.end()
            if found["name"]:
                parts.append(_parameter(found, place, optional=depth > 0))
                continue
            parts.append(found[0])
            if found["fixed"]:
                name, _, number = found["fixed"].partition("=")
                fixed[name] = int(number)
            else:
                depth += 1 if found["bracket"] == "[" else -1
        parts += [text[end:]] if text[end:] else []
        if depth or "{" in "".join(part for part in parts if isinstance(part, str)):
            raise UsageError(
                f"{place}: invalid pattern {text!r}: expected pairs of brackets, e.g. '{{axis}}PA[{{to:int}}]'"
            )
        made = cls(tuple(parts), fixed)
        if twice := [name for name, count in Counter(part.name for part in made.parameters).items() if count > 1]:
            raise UsageError(f"{place}: two placeholders {{{twice[0]}}} in {text!r}: give one another name")
        return made

    @property
    def has_text(self) -> bool:
        return any(isinstance(part, str) and part not in "[]" for part in self.parts)

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return tuple(part for part in self.parts if isinstance(part, Parameter))

    def expression(self, axes: Mapping[str, Any], loose: bool = False) -> str:
        """Return the regular expression of a line; `loose`: also of one with values in the wrong form."""

        def one(part: str | Parameter) -> str:
            if isinstance(part, str):
                return {"[": "(?:", "]": ")?"}.get(part) or re.escape(part)
            return f"(?P<{part.name}>{part.expression(axes, loose)})"

        return "".join(map(one, self.parts))

    def examples(self, axis: str) -> tuple[str, str]:
        """Return two lines that match: with and without the optional parts."""
        return self.filled({one.name: one.example(axis) for one in self.parameters})

    def filled(self, values: Mapping[str, Any]) -> tuple[str, str]:
        """Return the lines with these values: with and without the optional parts."""
        full, short, depth = "", "", 0
        for part in self.parts:
            if part in ("[", "]"):
                depth += 1 if part == "[" else -1
            else:
                word = str(values[part.name]) if isinstance(part, Parameter) else part
                full, short = full + word, short + (word if not depth else "")
        return full, short

    def __str__(self) -> str:
        shown = (part.kind if "|" in part.kind else part.name for part in self.parameters)
        return "".join(part if isinstance(part, str) else f"<{next(shown)}>" for part in self.parts)


def _parameter(found: re.Match[str], place: str, *, optional: bool) -> Parameter:
    name, rest = found["name"], found["rest"].strip()
    kind = found["kind"] or ("axis" if name == "axis" else "word")
    if not name.isidentifier() or (kind not in (*KINDS, "axis") and "|" not in kind):
        raise UsageError(
            f"{place}: invalid placeholder {found[0]}: expected a name and {', '.join(KINDS)}, e.g. {{to:int 0..9}}"
        )
    span = _RANGE.match(rest)
    unit = rest[span.end() :].strip() if span else rest
    ends: list[Any] = (
        [float(end) if kind == "float" else int(float(end)) for end in span.groups()] if span else [None, None]
    )
    if ".." in unit or (span and ends[0] > ends[1]):
        raise UsageError(f"{place}: invalid range in {found[0]}: expected LOW..HIGH, e.g. {{{name}:{kind} 0..9}}")
    return Parameter(name, unit, ends[0], ends[1], optional, kind)


@dataclass(frozen=True)
class Entry(Command):
    """A command of a device: one method that is decorated with `command` or `query`."""

    pattern: Pattern = field(default_factory=lambda: Pattern((), {}))
    place: str = ""  # File and line of the method.
    asks: bool = False  # A query changes nothing and always answers.
    blocks: bool = False  # Later requests wait until this one has ended.
    after_s: float | None = None  # Time until the answer begins; None: that of the device.
    wanted: tuple[str, ...] = ()  # Names of the handler's parameters.

    @property
    def syntax(self) -> str:
        return str(self.code)

    def values(
        self, get: Callable[[Parameter], Any], span: Callable[[str], tuple[int, int]] | None = None
    ) -> dict[str, Any]:
        """Return the values of the parameters from a function.  Raises Refused with this command and the place."""
        made = {}
        for parameter in self.pattern.parameters:
            try:
                made[parameter.name] = get(parameter)
            except Refused as reason:
                reason.entry, reason.span = self, span and span(parameter.name)
                raise
        return made


def command(
    pattern: str, *, section: str = "", name: str = "", blocks: bool = False, after: float | None = None
) -> Callable[[Handler], Handler]:
    """Make a method the handler of a command.

    `pattern`: the line without its terminator, with placeholders `{name:kind low..high unit}`; the kinds are int,
    float, word, text and choices such as `{side:L|R}`, `{axis}` is the name of an axis, and a part in brackets may be
    missing (None).  For datagrams: fields of one value, then the others, e.g. `"code=4 type=0 {motor:int 0..2}
    {value:int}"`.  `section`: that of the manual.  `blocks`: later requests wait until a procedure has ended.
    `after`: seconds until the answer, or that of `refused`, begins, from the end of a procedure.

    The method returns the answer: text, a number or bytes, fields of a datagram, or None for silence.  As a generator
    it is a procedure: it yields events, e.g. `self.after(0.2)` or `axis.done`, and returns its answer at its end.
    """
    return _collect(pattern, section, name, False, blocks, after)


def query(
    pattern: str, *, section: str = "", name: str = "", after: float | None = None
) -> Callable[[Handler], Handler]:
    """Make a method the handler of a request that changes nothing and always answers; see `command`."""
    return _collect(pattern, section, name, True, False, after)


def _collect(
    pattern: str, section: str, name: str, asks: bool, blocks: bool, after: float | None
) -> Callable[[Handler], Handler]:
    def collect(handler: Handler) -> Handler:
        place = f"{Path(handler.__code__.co_filename).name}:{handler.__code__.co_firstlineno}"
        read = Pattern.read(pattern, place)
        wanted = tuple(inspect.signature(handler).parameters)[1:]
        entry = Entry(
            str(read), name or handler.__name__.replace("_", " "), section, read.parameters, Always.ALWAYS, handler,
            pattern=read, place=place, asks=asks, blocks=blocks, after_s=after, wanted=wanted,
        )  # fmt: skip
        handler.__dict__.setdefault("entries", []).append(entry)
        return handler

    return collect


def collected(kind: type) -> Iterator[Entry]:
    """Yield the commands of a class in the order of its methods; a method of the same name replaces that of a base."""
    for method in attributes(kind).values():
        yield from getattr(method, "entries", ())


def attributes(kind: type) -> dict[str, Any]:
    """Return the attributes of a class, those of its bases first; one replaces that of the same name of a base."""
    return {name: value for base in reversed(kind.__mro__) for name, value in vars(base).items()}


def check_table(
    entries: list[Entry], fields: tuple[str, ...], matches: Callable[[Entry, str], bool], axis: str
) -> None:
    """Raise UsageError for a name that a handler or a datagram has not, or two commands that match one line.

    `fields`: those of the datagrams.  `matches(entry, line)`: True if this command matches a line.  Of two commands for
    datagrams the first one may be a special case of the second.
    """
    for index, entry in enumerate(entries):
        known = {parameter.name for parameter in entry.pattern.parameters}
        if missing := [name for name in entry.wanted if name not in known | set(fields)]:
            raise UsageError(
                f"{entry.place}: the pattern {entry.code!r} has no {{{missing[0]}}}: add it, or remove the parameter"
            )
        if unknown := [name for name in (*entry.pattern.fixed, *known) if fields and name not in fields]:
            raise UsageError(f"{entry.place}: no field {unknown[0]!r}: expected one of {', '.join(fields)}")
        for other in entries[index + 1 :]:
            if fields:
                lines = [str(entry.code)] if entry.pattern.fixed.items() <= other.pattern.fixed.items() else []
            else:
                lines = [line for line in entry.pattern.examples(axis) if matches(other, line)]
                lines += [line for line in other.pattern.examples(axis) if matches(entry, line)]
            if lines or entry.code == other.code:
                raise UsageError(
                    f"{other.place}: {other.code!r} also matches {(*lines, entry.code)[0]!r}, "
                    f"as {entry.code!r} does at {entry.place}: change one of the patterns"
                )
        if unused := [] if fields else sorted(known - {*entry.wanted}):
            raise UsageError(
                f"{entry.place}: the method of {entry.code!r} does not take {unused[0]!r}: add it to its parameters"
            )
