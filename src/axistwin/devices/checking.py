"""The checker of a device's host programs: each request is read by the framing and the table, and nothing is run."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

from axistwin.controllers.diagnostics import (
    Checker,
    Diagnostic,
    Rule,
    Sent,
    Session,
    Severity,
    diagnose,
    fixing,
    replaced,
)
from axistwin.core.errors import most_similar
from axistwin.devices.device import Device
from axistwin.devices.framing import Lines, Port
from axistwin.devices.table import Entry, Refused, Why
from axistwin.sim.frames import LineError

E, W = Severity.ERROR, Severity.WARNING
TABLE, FRAMING = "Commands", "Framing"  # Chapters of a device's manual, if its table names no other.

RULES = (
    UNKNOWN := Rule("DV101", "the command is unknown", E, TABLE,
        "No command of the device has this form.  `axistwin commands MODEL` lists all commands.",
        "> 1PX5\\r", ".talk"),
    RANGE := Rule("DV102", "a value is out of range", E, TABLE,
        "The device refuses the command, because a parameter is out of the range that its table gives.",
        "> 1PA900000\\r", ".talk"),
    WRONG := Rule("DV103", "the framing of a request is wrong", E, FRAMING,
        "A line is longer than the device reads, or the check sum of a datagram is wrong.",
        f"> {'1TP' * 90}\\r", ".talk"),
    UNENDED := Rule("DV104", "the end of a request is missing", W, FRAMING,
        "The device obeys a request only after its terminator, or after all bytes of its datagram.",
        "> 1TP", ".talk"),
)  # fmt: skip


class _Request(NamedTuple):
    """A request as the reader has cut it, with the characters of the user's file."""

    characters: Sequence[Sent]
    data: bytes
    wrong: Refused | None


def checker_of(kind: type[Device], entries: Sequence[Entry], address: bytes) -> Checker:
    """Return the checker of a device whose requests begin with an address."""
    single = [(entry, kind.framing.finder([entry], kind.axes)) for entry in entries]

    def check(sessions: Sequence[Session]) -> list[Diagnostic]:
        return [found for session in sessions for found in _check(kind, single, address, session)]

    return check


def _check(kind: type[Device], single: Any, address: bytes, session: Session) -> Iterator[Diagnostic]:
    cut, rest = _requests(kind, address, session.characters)
    for request in cut:
        if request.wrong is not None:
            yield diagnose(WRONG, request.characters, request.wrong.words)
        elif (found := _problem(kind, single, request)) is not None:
            yield found
    if rest and session.ended:
        ending = repr(kind.framing.terminator)[2:-1] if isinstance(kind.framing, Lines) else "all bytes of its datagram"
        yield diagnose(UNENDED, rest, f"the end of the request is missing: expected {ending}")


def _problem(kind: type[Device], single: Any, request: _Request) -> Diagnostic | None:
    for entry, find in single:
        try:
            find(request.data)
        except Refused as reason:
            if reason.why is not Why.UNKNOWN:
                return diagnose(RANGE, _place(kind, entry, request), reason.words, entry.chapter)
        else:
            return None
    text = request.data.decode("latin-1") if isinstance(kind.framing, Lines) else request.data.hex(" ")
    examples = [line for entry, _ in single for line in entry.pattern.examples(next(iter(kind.axes), ""))]
    near = most_similar(text, examples) if isinstance(kind.framing, Lines) else ""
    fix = fixing(f"write {near}", replaced(request.characters, near), sure=False) if near else None
    remedy = f"did you mean {near!r}?" if near else f"`axistwin commands {kind.model}` lists all"
    return diagnose(UNKNOWN, request.characters, f"unknown command {text!r}: {remedy}", fix=fix)


def _place(kind: type[Device], entry: Entry, request: _Request) -> Sequence[Sent]:
    """Return the characters of the value that is out of range."""
    text = request.data.decode("latin-1")
    before = len(text) - len(text.lstrip())
    if isinstance(kind.framing, Lines) and (found := kind.framing.compiled(entry, kind.axes).fullmatch(text.strip())):
        for parameter in entry.pattern.parameters:
            try:
                parameter.convert(found[parameter.name] or "0", {})
            except Refused:
                begin, end = found.span(parameter.name)
                return request.characters[begin + before : end + before]
    return request.characters


def _requests(kind: type[Device], address: bytes, characters: Sequence[Sent]) -> tuple[list[_Request], list[Sent]]:
    """Return the requests that the framing cuts out of the characters, and the rest without an end."""
    framing, found, held, taken = kind.framing, list[_Request](), list[Sent](), 0

    def take(data: bytes, wrong: Refused | None) -> None:
        nonlocal taken
        at = max(bytes(each.byte for each in held).find(data, taken), 0)
        taken = at + len(data)
        whole = (
            held[: -len(getattr(framing, "terminator", b""))] or held
        )  # Of a line that is too long only a part is taken.
        found.append(_Request(tuple(whole if wrong else held[at:taken]), data, wrong))

    receive: Callable[[int, LineError], None] = framing.reader(Port(address, take, lambda data: None, lambda: 0))
    ignored = getattr(framing, "ignore", b"")
    for sent in characters:
        if sent.byte not in ignored:
            held.append(sent)
        receive(sent.byte, LineError.NONE)
        ended = isinstance(framing, Lines) and bytes(e.byte for e in held[-8:]).endswith(framing.terminator)
        if taken or ended:
            held.clear()
            taken = 0
    return found, held
