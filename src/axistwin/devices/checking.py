"""The checker of a device's host programs: each request is read by the framing and the table, and nothing is run."""

import shlex
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

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
from axistwin.controllers.registry import LOADED
from axistwin.core.errors import most_similar
from axistwin.devices.device import Device
from axistwin.devices.framing import Find, Lines, Port
from axistwin.devices.table import Entry, Refused, Why
from axistwin.sim.frames import LineError

E, W = Severity.ERROR, Severity.WARNING
TABLE, FRAMING = "Commands", "Framing"  # Chapters of a device's manual, if its table names no other.

RULES = (
    UNKNOWN := Rule("DV101", "the command is unknown", E, TABLE,
        "No command of the device has this form.  `axistwin commands MODEL` lists all commands.",
        "> 1PX5\\r", ".talk"),
    RANGE := Rule("DV102", "a value is wrong", E, TABLE,
        "The device refuses the command, because a parameter has not the form or the range that its table gives.",
        "> 1PA900000\\r", ".talk"),
    WRONG := Rule("DV103", "the framing of a request is wrong", E, FRAMING,
        "A line is longer than the device reads, or the check sum of a datagram is wrong.",
        f"> {'1TP' * 90}\\r", ".talk"),
    UNENDED := Rule("DV104", "the end of a request is missing", W, FRAMING,
        "The device obeys a request only after its terminator, or after all bytes of its datagram.",
        "> 1TP", ".talk"),
    OTHER := Rule("DV105", "a request is for another unit", W, FRAMING,
        "The device ignores a request without its address.  Its address is that of the option, as usually set.",
        "> #2TP\\r", ".talk"),
)  # fmt: skip


class _Request(NamedTuple):
    """A request as the reader has cut it, with the characters of the user's file."""

    characters: Sequence[Sent]
    data: bytes
    wrong: Refused | None


def checker_of(kind: type[Device], entries: Sequence[Entry], address: bytes) -> Checker:
    """Return the checker of a device whose requests begin with an address."""
    find = kind.framing.finder(entries, kind.axes)

    def check(sessions: Sequence[Session]) -> list[Diagnostic]:
        return [found for session in sessions for found in _check(kind, entries, find, address, session)]

    return check


def _check(
    kind: type[Device], entries: Sequence[Entry], find: Find, address: bytes, session: Session
) -> Iterator[Diagnostic]:
    cut, rest = _requests(kind, address, session.characters)
    for request in cut:
        if request.wrong is not None:
            rule = OTHER if request.wrong.why is Why.STATE else WRONG
            yield diagnose(rule, request.characters, request.wrong.words)
        elif (found := _problem(kind, entries, find, request)) is not None:
            yield found
    if rest and session.ended:
        yield _unended(kind, rest)


def _unended(kind: type[Device], rest: Sequence[Sent]) -> Diagnostic:
    ending = repr(kind.framing.terminator)[2:-1] if isinstance(kind.framing, Lines) else "all bytes of its datagram"
    return diagnose(UNENDED, rest, f"the end of the request is missing: expected {ending}")


def _problem(kind: type[Device], entries: Sequence[Entry], find: Find, request: _Request) -> Diagnostic | None:
    sent, lines = request.characters, isinstance(kind.framing, Lines)
    try:
        find(request.data)
        return None
    except Refused as refused:
        reason = refused
    if lines and len({each.line for each in sent}) > 1:  # Two lines of the file became one.
        return _unended(kind, [each for each in sent if each.line == sent[0].line])
    if reason.entry is not None:
        value = sent[slice(*reason.span)] if reason.span else ()  # An empty one where it is missing.
        return diagnose(RANGE, value or sent, reason.words, reason.entry.chapter)
    text = request.data.decode("latin-1") if lines else request.data.hex(" ")
    examples = [line for entry in entries for line in entry.pattern.examples(next(iter(kind.axes), ""))]
    near = most_similar(text, examples) if lines else ""
    fix = fixing(f"write {near}", replaced(sent, near), sure=False) if near else None
    return diagnose(UNKNOWN, sent, f"{reason.words}: {f'did you mean {near!r}?' if near else listing(kind)}", fix=fix)


def listing(kind: type[Device]) -> str:
    """Return where a user finds the commands of a device."""
    place = LOADED.get(kind.model)
    file = f"--device {shlex.quote(place.where.rpartition(':')[0])} " if place else ""
    return f"`axistwin {file}commands {kind.model}` lists all"


def _requests(kind: type[Device], address: bytes, characters: Sequence[Sent]) -> tuple[list[_Request], list[Sent]]:
    """Return the requests that the framing cuts out of the characters, and the rest without an end."""
    framing, found, held, taken = kind.framing, list[_Request](), list[Sent](), 0

    def take(data: bytes, wrong: Refused | None) -> None:
        nonlocal taken
        at = max(bytes(each.byte for each in held).find(data, taken), 0)
        taken = at + len(data)
        # Of a line that is too long only a part is taken.
        whole = held[: -len(getattr(framing, "terminator", b""))] or held
        found.append(_Request(tuple(held[at:taken] if data and not wrong else whole), data, wrong))

    def drop(data: bytes) -> None:
        words = f"this unit reads only what begins with {shown}: begin with it, or leave it to the unit it is for"
        take(data, Refused(words))

    shown = repr(address)[1:] if isinstance(framing, Lines) else address.hex(" ")
    receive: Callable[[int, LineError], None] = framing.reader(Port(address, take, lambda data: None, lambda: 0, drop))
    ignored = getattr(framing, "ignore", b"")
    for sent in characters:
        if sent.byte not in ignored:
            held.append(sent)
        receive(sent.byte, LineError.NONE)
        end = framing.terminator if isinstance(framing, Lines) else b""
        ended = end and bytes(each.byte for each in held[-len(end) :]) == end
        if taken or ended:
            held.clear()
            taken = 0
    return found, held
