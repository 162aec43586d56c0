"""The command table of a device, which dispatcher, `axistwin commands`, checker, completion and docs read."""

import inspect
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import Flag
from functools import partial
from pathlib import Path
from typing import Any

from axistwin.controllers.commandset import Command
from axistwin.controllers.patterns import Pattern, Refused

Handler = Callable[..., Any]
Always = Flag("Always", "ALWAYS")  # The commands of a device have no states: its handlers refuse.


@dataclass(frozen=True)
class Entry(Command):
    """A command of a device: one method that is decorated with `command` or `query`."""

    pattern: Pattern
    place: str  # File and line of the method.
    asks: bool = False  # A query changes nothing and always answers.
    blocks: bool = False  # Later requests wait until this one has ended.
    after_s: float | None = None  # Time until the answer begins; None: that of the device.
    wanted: tuple[str, ...] = ()  # Names of the handler's parameters.

    @property
    def syntax(self) -> str:
        return str(self.code)

    def values(self, given: Any, read: Callable[[Any, Any], Any]) -> dict[str, Any]:
        """Return the values by name, None for a missing part.  Raises Refused with this command and the place."""
        made: dict[str, Any] = {}
        for parameter in self.parameters:
            value = given[parameter.name]
            try:
                made[parameter.name] = None if value is None else read(parameter, value)
            except Refused as reason:
                reason.entry = self
                reason.span = given.span(parameter.name) if isinstance(given, re.Match) else None
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
    return partial(_collect, pattern, section, name, asks=False, blocks=blocks, after_s=after)


def query(
    pattern: str, *, section: str = "", name: str = "", after: float | None = None
) -> Callable[[Handler], Handler]:
    """Make a method the handler of a request that changes nothing and always answers; see `command`."""
    return partial(_collect, pattern, section, name, asks=True, after_s=after)


def _collect(pattern: str, section: str, name: str, handler: Handler, **figures: Any) -> Handler:
    place = f"{Path(handler.__code__.co_filename).name}:{handler.__code__.co_firstlineno}"
    read = Pattern.read(pattern, place)
    wanted = tuple(inspect.signature(handler).parameters)[1:]
    entry = Entry(
        str(read), name or handler.__name__.replace("_", " "), section, read.parameters, Always.ALWAYS, handler,
        pattern=read, place=place, wanted=wanted, **figures,
    )  # fmt: skip
    handler.__dict__.setdefault("entries", []).append(entry)
    return handler


def attributes(kind: type) -> dict[str, Any]:
    """Return the attributes of a class, those of its bases first; one replaces that of the same name of a base."""
    return {name: value for base in reversed(kind.__mro__) for name, value in vars(base).items()}


def collected(kind: type) -> Iterator[Entry]:
    """Yield the commands of a class in the order of its methods; a method of the same name replaces that of a base."""
    for method in attributes(kind).values():
        yield from getattr(method, "entries", ())
