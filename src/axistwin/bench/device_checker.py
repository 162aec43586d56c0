"""The checker of a device's host programs: each request is read by the framing and the table, and nothing is run."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple

from axistwin.controllers.diagnostics import Diagnostic, Rule, Sent, Session, Severity, diagnose, fixing, replaced
from axistwin.controllers.files import listing
from axistwin.controllers.patterns import Refused, Why
from axistwin.controllers.product import Product
from axistwin.core.errors import most_similar
from axistwin.devices.device import Device
from axistwin.devices.framing import Lines, Port
from axistwin.devices.making import address_of, product_of
from axistwin.devices.table import collected
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


@cache
def checked_product(kind: Any) -> Product:
    """Return the model of a class, with its checker.  Raises UsageError for a wrong class."""
    made = product_of(kind)
    return made._replace(
        check=_Checker(kind, {}), check_for=lambda given: _Checker(kind, given), make_rules=lambda: RULES
    )


class _Request(NamedTuple):
    """A request as the reader has cut it, with the characters of the user's file."""

    characters: Sequence[Sent]
    data: bytes
    wrong: Refused | None


class _Checker:
    def __init__(self, kind: type[Device], given: Mapping[str, Any]) -> None:
        self.kind, self.framing = kind, kind.framing
        try:
            self.address = address_of(kind, given)
        except (LookupError, ValueError, TypeError):  # Options of a scene that is wrong.
            self.address = address_of(kind, {})
        self.entries = list(collected(kind))
        self.find = self.framing.finder(self.entries, kind.axes)
        self.end = self.framing.endings[0]

    def __call__(self, sessions: Sequence[Session]) -> list[Diagnostic]:
        return [found for session in sessions for found in self._check(session)]

    def _check(self, session: Session) -> Iterator[Diagnostic]:
        cut, rest = self._requests(session.characters)
        for request in cut:
            if request.wrong is not None:
                rule = OTHER if request.wrong.why is Why.STATE else WRONG
                yield diagnose(rule, request.characters, request.wrong.words)
            elif (found := self._problem(request)) is not None:
                yield found
        if rest and session.ended:
            yield self._unended(rest)

    def _unended(self, rest: Sequence[Sent]) -> Diagnostic:
        ending = repr(self.end)[2:-1] or "all bytes of its datagram"
        return diagnose(UNENDED, rest, f"the end of the request is missing: expected {ending}")

    def _problem(self, request: _Request) -> Diagnostic | None:
        sent = request.characters
        try:
            self.find(request.data)
            return None
        except Refused as refused:
            reason = refused
        if self.end and len({each.line for each in sent}) > 1:  # Two lines of the file became one.
            return self._unended([each for each in sent if each.line == sent[0].line])
        if reason.entry is not None:
            value = sent[slice(*reason.span)] if reason.span else ()  # An empty one where it is missing.
            return diagnose(RANGE, value or sent, reason.words, reason.entry.chapter)
        near = self._similar(request.data)
        fix = fixing(f"write {near}", replaced(sent, near), sure=False) if near else None
        remedy = f"did you mean {near!r}?" if near else listing(self.kind.model)
        return diagnose(UNKNOWN, sent, f"{reason.words}: {remedy}", fix=fix)

    def _similar(self, data: bytes) -> str:
        axis = next(iter(self.kind.axes), "")
        lines = (line for entry in self.entries for line in entry.pattern.examples(axis))
        return most_similar(data.decode("latin-1"), lines) if self.end else ""

    def _requests(self, characters: Iterable[Sent]) -> tuple[list[_Request], list[Sent]]:
        """Return the requests that the framing cuts out of the characters, and the rest without an end."""
        found, held, taken = list[_Request](), list[Sent](), list[tuple[bytes, Refused | None]]()

        def drop(data: bytes) -> None:
            shown = repr(self.address)[1:] if self.end else self.address.hex(" ")
            words = f"this unit reads only what begins with {shown}: begin with it, or leave it to the unit it is for"
            taken.append((data, Refused(words)))

        port = Port(self.address, lambda *request: taken.append(request), lambda data: None, lambda: 0, drop)
        receive = self.framing.reader(port)
        for sent in characters:
            if not isinstance(self.framing, Lines) or sent.byte not in self.framing.ignore:
                held.append(sent)
            receive(sent.byte, LineError.NONE)
            if taken or (self.end and bytes(each.byte for each in held[-len(self.end) :]) == self.end):
                found += self._placed(taken, held)
                held.clear()
                taken.clear()
        return found, held

    def _placed(self, taken: Iterable[tuple[bytes, Refused | None]], held: Sequence[Sent]) -> Iterator[_Request]:
        line, at = bytes(each.byte for each in held), 0
        whole = held[: len(held) - len(self.end)] or held  # Of a line that is too long only a part is taken.
        for data, wrong in taken:
            begin = max(line.find(data, at), 0)
            at = begin + len(data)
            yield _Request(tuple(held[begin:at] if data and not wrong else whole), data, wrong)
