"""Framing: how the characters on a line become requests, and answers become characters."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, partial, reduce
from operator import xor
from struct import Struct, error
from typing import Any, ClassVar, NamedTuple

from axistwin.controllers.patterns import Parameter, Refused, Why
from axistwin.core.errors import UsageError
from axistwin.core.units import to_ns
from axistwin.devices.table import Entry
from axistwin.sim.frames import SOUND, LineError


class Request(NamedTuple):
    """A request of a host: its bytes, its command, and the values of the command's parameters or fields."""

    data: bytes
    entry: Entry
    values: Mapping[str, Any]


class Port(NamedTuple):
    """The device's side of a reader of characters."""

    address: bytes  # What requests for this device begin with.
    take: Callable[[bytes, Refused | None], None]  # Called with a request, and why it is refused.
    echo: Callable[[bytes], None]
    now: Callable[[], int]  # Virtual time in ns.
    drop: Callable[[bytes], None] = lambda data: None  # Called with a request for others.


Receive = Callable[[int, LineError], None]
Find = Callable[[bytes], Request]


@dataclass(frozen=True)
class Lines:
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
    most: int = 256
    fields: ClassVar[tuple[str, ...]] = ()

    def __post_init__(self) -> None:
        if not self.terminator or any(byte in self.ignore for byte in self.terminator):
            raise UsageError(
                f"invalid terminator {self.terminator!r}: expected characters that are not ignored, "
                'e.g. Lines(b"\\r", ignore=b"\\n")'
            )

    @property
    def endings(self) -> tuple[bytes, bytes]:
        """Terminators of requests and of answers."""
        return self.terminator, self.terminator if self.ending is None else self.ending

    def reader(self, port: Port) -> Receive:
        """Return a function for each received character; it has the state of one power-on."""
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
            if line.endswith(self.terminator):
                data, reason = bytes(line[: -len(self.terminator)]), Refused(wrong, why=Why.FORMAT) if wrong else None
                line.clear()
                wrong = ""
                self._pass_on(data, reason, port)

        return receive

    def _pass_on(self, data: bytes, wrong: Refused | None, port: Port) -> None:
        if data.startswith(port.address):
            rest = data[len(port.address) :]
            for part in rest.split(self.separator) if self.separator and wrong is None else [rest]:
                if part or data == port.address != b"":
                    port.take(part, wrong)
        elif data:
            port.drop(data)

    def finder(self, entries: Iterable[Entry], axes: Mapping[str, Any]) -> Find:
        """Return a function of a request's bytes; it raises Refused for an unknown command and a value out of range."""
        table = [(entry, entry.pattern.compiled(axes, self.ignore_case)) for entry in entries]
        worded = [entry for entry, _ in table if entry.pattern.has_text]
        convert = partial(Parameter.convert, axes=axes)
        check_form = partial(Parameter.check_form, axes=axes, ignore_case=self.ignore_case)

        def find(data: bytes) -> Request:
            text = data.decode("latin-1")
            for entry, expression in table:
                if found := expression.fullmatch(text):
                    return Request(data, entry, entry.values(found, convert))
            for entry in worded:
                if found := entry.pattern.compiled(axes, self.ignore_case, loose=True).fullmatch(text):
                    entry.values(found, check_form)
            raise Refused(f"unknown command {text!r}", why=Why.UNKNOWN)

        return find

    def shared(self, one: Entry, other: Entry, axes: Mapping[str, Any]) -> list[str]:
        """Return lines that two commands match."""

        def matched(entry: Entry, by: Entry) -> list[str]:
            expression = by.pattern.compiled(axes, self.ignore_case)
            return [line for line in entry.pattern.examples(next(iter(axes), "")) if expression.fullmatch(line)]

        return matched(one, other) + matched(other, one)

    def problems(self, entry: Entry) -> Iterator[str]:
        """Yield what is wrong with a pattern."""
        if not (entry.pattern.parts or self.address):
            yield "an empty pattern needs an address: without one empty lines are ignored"
        for parameter in entry.parameters:
            if parameter.name not in entry.wanted:
                yield f"the method of {entry.code!r} does not take {parameter.name!r}: add it to its parameters"

    def phrase(self, entry: Entry, values: Mapping[str, Any], address: bytes) -> bytes:
        """Return the characters of a request, with these values of the parameters."""
        line = entry.pattern.filled(values)[0].encode("latin-1", "replace")
        return line if line in [bytes([byte]) for byte in self.at_once] else address + line + self.terminator

    def written(self, answer: Any) -> bytes:
        """Return the characters of an answer.  Raises TypeError for an answer that cannot be written."""
        if isinstance(answer, bytes):
            return answer
        if not isinstance(answer, str | int | float) or isinstance(answer, bool):
            raise TypeError(f"returned {type(answer).__name__}: expected text, a number, bytes or None")
        return str(answer).encode("latin-1", "replace") + self.endings[1]


def add8(data: bytes) -> bytes:
    """Return the check sum of TMCL and others: the lowest 8 bits of the sum."""
    return bytes([sum(data) & 0xFF])


def xor8(data: bytes) -> bytes:
    """Return the exclusive or of all bytes."""
    return bytes([reduce(xor, data, 0)])


@dataclass(frozen=True)
class Datagrams:
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
    endings: ClassVar[tuple[bytes, bytes]] = (b"", b"")

    @property
    def fields(self) -> tuple[str, ...]:
        return (*_layout(self.request)[1], *(("data",) if self.length else ()))

    def reader(self, port: Port) -> Receive:
        held, last_ns, wrong = bytearray(), port.now(), False
        head, names = _layout(self.request)
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
        table, (head, names) = tuple(entries), _layout(self.request)
        tail = len(self.check(b""))

        def find(data: bytes) -> Request:
            values: dict[str, Any] = dict(zip(names, head.unpack(data[: head.size]), strict=True))
            if self.length:
                values["data"] = data[head.size : len(data) - tail]
            for entry in table:
                if all(values[name] == value for name, value in entry.pattern.fixed.items()):
                    entry.values(values, Parameter.checked)
                    return Request(data, entry, values)
            raise Refused(f"unknown command {data.hex(' ')}", why=Why.UNKNOWN)

        return find

    def shared(self, one: Entry, other: Entry, axes: Mapping[str, Any]) -> list[str]:  # noqa: ARG002
        """Return a datagram that two commands match; the first one may be a special case of the second."""
        return [str(one.code)] if one.pattern.fixed.items() <= other.pattern.fixed.items() else []

    def problems(self, entry: Entry) -> Iterator[str]:
        for name in (*entry.pattern.fixed, *(parameter.name for parameter in entry.parameters)):
            if name not in self.fields:
                yield f"no field {name!r}: expected one of {', '.join(self.fields)}"

    def phrase(self, entry: Entry, values: Mapping[str, Any], address: bytes) -> bytes:
        head, names = _layout(self.request)
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


@cache
def _layout(text: str) -> tuple[Struct, tuple[str, ...]]:
    form, *names = text.split()
    return Struct(form), tuple(names)


Framing = Lines | Datagrams
