"""Framing: how the characters on a line become requests, and answers become characters."""

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from struct import Struct, error
from typing import Any, NamedTuple

from axistwin.core.errors import UsageError
from axistwin.core.units import to_ns
from axistwin.devices.table import Entry, Parameter, Refused, Why
from axistwin.sim.frames import SOUND, LineError

MOST_LINE = 256


class Request(NamedTuple):
    """A request of a host: its bytes, its command, and the values of the command's parameters or fields."""

    data: bytes
    entry: Entry
    values: Mapping[str, Any]


class Port(NamedTuple):
    """What a reader of characters uses."""

    address: bytes  # What requests for this device begin with; the reader drops all others.
    take: Callable[[bytes, Refused | None], None]
    """Function that is called with a whole request, and with the reason if its framing is wrong."""
    echo: Callable[[bytes], None]
    now: Callable[[], int]  # Virtual time in ns.
    drop: Callable[[bytes], None] = lambda data: None  # Function that is called with a request for others.


Receive = Callable[[int, LineError], None]
Find = Callable[[bytes], Request]


class Framing(ABC):
    """What `Lines` and `Datagrams` have in common."""

    fields: tuple[str, ...] = ()
    endings: tuple[bytes, bytes] = (b"", b"")  # Terminators of requests and of answers.
    address: str = ""

    @abstractmethod
    def reader(self, port: Port) -> Receive:
        """Return a function for each received character; it has the state of one power-on."""

    @abstractmethod
    def finder(self, entries: Iterable[Entry], axes: Mapping[str, Any]) -> Find:
        """Return a function of a request's bytes; it raises Refused for an unknown command and a value out of range."""

    @abstractmethod
    def phrase(self, entry: Entry, values: Mapping[str, Any], address: bytes) -> bytes:
        """Return the characters of a request, with these values of the parameters."""

    @abstractmethod
    def written(self, answer: Any) -> bytes:
        """Return the characters of an answer.  Raises TypeError for an answer that cannot be written."""


@dataclass(frozen=True)
class Lines(Framing):
    r"""Lines of text that end with a terminator.

    `ending`: terminator of the answers, by default that of the lines.  `echo`: each received character is sent back.
    `ignore`: characters that are dropped, e.g. b"\n" for hosts that end lines with CR LF.  `at_once`: characters that
    are requests without terminator and address, and drop a line that has begun, e.g. b"\x1b".  `separator`: character
    between several commands in a line.  `address`: what each line begins with; `{address}` is the option of that name,
    and other lines are for other devices.  `most`: longest line; a longer one is refused as a whole.  An empty line is
    dropped, but not one with nothing behind the address.
    """

    terminator: bytes = b"\r"
    ending: bytes | None = None
    echo: bool = False
    ignore: bytes = b""
    at_once: bytes = b""
    ignore_case: bool = False
    separator: bytes = b""
    address: str = ""
    most: int = MOST_LINE

    def __post_init__(self) -> None:
        if not self.terminator or any(byte in self.ignore for byte in self.terminator):
            raise UsageError(
                f"invalid terminator {self.terminator!r}: expected characters that are not ignored, "
                'e.g. Lines(b"\\r", ignore=b"\\n")'
            )

    @property
    def endings(self) -> tuple[bytes, bytes]:  # type: ignore[override]
        return self.terminator, self.terminator if self.ending is None else self.ending

    def reader(self, port: Port) -> Receive:
        line, wrong = bytearray(), ""

        def receive(byte: int, errors: LineError) -> None:
            nonlocal wrong
            if self.echo:
                port.echo(bytes([byte]))
            if errors != SOUND:
                wrong = wrong or "a character was received with an error"
            if byte in self.ignore:
                return
            if byte in self.at_once and errors == SOUND:
                line.clear()
                wrong = ""
                port.take(bytes([byte]), None)
                return
            line.append(byte)
            if len(line) > self.most + len(self.terminator):
                wrong = wrong or f"a line is longer than {self.most} characters"
                del line[self.most : -len(self.terminator)]
            if not line.endswith(self.terminator):
                return
            data, reason = bytes(line[: -len(self.terminator)]), Refused(wrong, why=Why.FORMAT) if wrong else None
            line.clear()
            wrong = ""
            if data.startswith(port.address):
                rest = data[len(port.address) :]
                for part in rest.split(self.separator) if self.separator and reason is None else [rest]:
                    if part or data == port.address != b"":
                        port.take(part, reason)
            elif data:
                port.drop(data)

        return receive

    def finder(self, entries: Iterable[Entry], axes: Mapping[str, Any]) -> Find:
        table = [(entry, self.compiled(entry, axes)) for entry in entries]
        names = {name.upper(): name for name in axes} if self.ignore_case else {}

        def find(data: bytes) -> Request:
            text = data.decode("latin-1")
            for entry, expression in table:
                if found := expression.fullmatch(text):
                    return Request(data, entry, entry.values(partial(_converted, found, names), found.span))
            for entry, _ in table:
                if entry.pattern.has_text and (found := self.compiled(entry, axes, loose=True).fullmatch(text)):
                    entry.values(partial(self._formed, found, axes), found.span)
            raise Refused(f"unknown command {text!r}", why=Why.UNKNOWN)

        return find

    @property
    def _flags(self) -> int:
        return re.ASCII | (re.IGNORECASE if self.ignore_case else 0)

    def compiled(self, entry: Entry, axes: Mapping[str, Any], loose: bool = False) -> re.Pattern[str]:
        return re.compile(entry.pattern.expression(axes, loose), self._flags)

    def _formed(self, found: re.Match[str], axes: Mapping[str, Any], parameter: Parameter) -> None:
        text = found[parameter.name]
        if text is not None and (words := parameter.misshapen(text, axes, self._flags)):
            raise Refused(words, why=Why.FORMAT)

    def phrase(self, entry: Entry, values: Mapping[str, Any], address: bytes) -> bytes:
        line = entry.pattern.filled(values)[0].encode("latin-1", "replace")
        return line if line in [bytes([byte]) for byte in self.at_once] else address + line + self.terminator

    def written(self, answer: Any) -> bytes:
        if isinstance(answer, bytes):
            return answer
        if not isinstance(answer, str | int | float) or isinstance(answer, bool):
            raise TypeError(f"returned {type(answer).__name__}: expected text, a number, bytes or None")
        return str(answer).encode("latin-1", "replace") + self.endings[1]


def _converted(found: re.Match[str], names: Mapping[str, str], parameter: Parameter) -> Any:
    return None if found[parameter.name] is None else parameter.convert(found[parameter.name], names)


def add8(data: bytes) -> bytes:
    """Return the check sum of TMCL and others: the lowest 8 bits of the sum."""
    return bytes([sum(data) & 0xFF])


def xor8(data: bytes) -> bytes:
    """Return the exclusive or of all bytes."""
    found = 0
    for byte in data:
        found ^= byte
    return bytes([found])


@dataclass(frozen=True)
class Datagrams(Framing):
    """Datagrams of fixed length, or with a length in their head, and perhaps with a check sum at the end.

    `request`, `answer`: the fields as `struct` has them, e.g. `">BBBBi address code type motor value"`.  `check`:
    function that returns the check sum's bytes of all bytes before.  `length`: name of the field of a request with the
    number of bytes that follow the head; they are the field `data`.  `gap`: seconds of silence after which the rest of
    a datagram is no longer expected.  `address`: what a datagram begins with, as in `Lines`.
    """

    request: str
    answer: str
    check: Callable[[bytes], bytes] = lambda data: b""
    length: str = ""
    gap: float = 0.1
    address: str = ""

    @cached_property
    def _head(self) -> tuple[Struct, tuple[str, ...]]:
        return _layout(self.request)

    @cached_property
    def fields(self) -> tuple[str, ...]:  # type: ignore[override]
        return (*self._head[1], *(("data",) if self.length else ()))

    def reader(self, port: Port) -> Receive:
        held, last_ns, wrong = bytearray(), port.now(), False
        head, names = self._head
        tail, gap_ns = len(self.check(b"")), to_ns(self.gap)

        def receive(byte: int, errors: LineError) -> None:
            nonlocal last_ns, wrong
            if port.now() - last_ns > gap_ns:
                held.clear()
                wrong = False
            last_ns = port.now()
            wrong |= errors != SOUND
            held.append(byte)
            if len(held) < head.size:
                return
            size = head.size + tail
            if self.length:
                size += int(head.unpack(held[: head.size])[names.index(self.length)])
            if len(held) >= size:
                data, broken = bytes(held), wrong or self.check(bytes(held[: size - tail])) != held[size - tail :]
                held.clear()
                wrong = False
                if data.startswith(port.address):
                    port.take(data, Refused("the check sum is wrong", why=Why.FORMAT) if broken else None)
                else:
                    port.drop(data)

        return receive

    def finder(self, entries: Iterable[Entry], axes: Mapping[str, Any]) -> Find:  # noqa: ARG002
        table, (head, names) = tuple(entries), self._head
        tail = len(self.check(b""))

        def find(data: bytes) -> Request:
            values: dict[str, Any] = dict(zip(names, head.unpack(data[: head.size]), strict=True))
            if self.length:
                values["data"] = data[head.size : len(data) - tail]
            for entry in table:
                if all(values[name] == value for name, value in entry.pattern.fixed.items()):
                    entry.values(lambda parameter: parameter.checked(values[parameter.name]))
                    return Request(data, entry, values)
            raise Refused(f"unknown command {data.hex(' ')}", why=Why.UNKNOWN)

        return find

    def phrase(self, entry: Entry, values: Mapping[str, Any], address: bytes) -> bytes:
        head, names = self._head
        given = {name: value for name, value in values.items() if not isinstance(value, str)}  # A field is a number.
        fields = {**dict.fromkeys(names, 0), **given, **entry.pattern.fixed}
        data = address + head.pack(*(fields[name] for name in names))[len(address) :]
        return data + self.check(data)

    def written(self, answer: Any) -> bytes:
        if isinstance(answer, bytes):
            return answer
        if not isinstance(answer, Mapping):
            raise TypeError(f"returned {type(answer).__name__}: expected the fields of an answer, bytes or None")
        struct, names = _layout(self.answer)
        try:
            data = struct.pack(*(answer[name] for name in names))
        except KeyError as missing:
            raise TypeError(f"an answer without the field {missing}: expected {', '.join(names)}") from None
        except error as wrong:
            raise TypeError(f"an answer that does not fit {self.answer!r}: {wrong}") from None
        return data + self.check(data)


def _layout(text: str) -> tuple[Struct, tuple[str, ...]]:
    form, *names = text.split()
    return Struct(form), tuple(names)
