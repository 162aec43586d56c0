"""The part of Telnet that RFC 2217 needs: splits bytes into data and commands, without sockets."""

from dataclasses import dataclass
from enum import IntEnum

IAC = 0xFF
SE, SB = 0xF0, 0xFA
LONGEST_SUBNEGOTIATION = 64  # Longest subnegotiation in bytes; a longer one is invalid and discarded.


class Verb(IntEnum):
    """Verbs of a Telnet option negotiation."""

    WILL = 0xFB
    WONT = 0xFC
    DO = 0xFD
    DONT = 0xFE


class Option(IntEnum):
    """Telnet options that RFC 2217 uses."""

    BINARY = 0
    ECHO = 1
    SUPPRESS_GO_AHEAD = 3
    COM_PORT = 44


@dataclass(frozen=True)
class Negotiation:
    """A Telnet option negotiation, which consists of IAC, a verb and an option."""

    verb: Verb
    option: int

    def __bytes__(self) -> bytes:
        return bytes((IAC, self.verb, self.option))


@dataclass(frozen=True)
class Subnegotiation:
    """A Telnet subnegotiation, which consists of IAC SB, an option, a payload and IAC SE."""

    option: int
    payload: bytes

    def __bytes__(self) -> bytes:
        return bytes((IAC, SB, self.option)) + escape(self.payload) + bytes((IAC, SE))


@dataclass(frozen=True)
class Command:
    """A Telnet command without parameters, such as BRK."""

    code: int


Item = bytes | Negotiation | Subnegotiation | Command


def escape(data: bytes) -> bytes:
    """Double each byte FF in data that are sent over Telnet."""
    return data.replace(b"\xff", b"\xff\xff")


class Parser:
    """Splits a Telnet stream, in pieces of any size, into data, commands and negotiations."""

    def __init__(self) -> None:
        self._begun = b""

    def feed(self, data: bytes) -> list[Item]:
        """Return the complete data, commands and negotiations; data between two commands is one item."""
        items: list[Item] = []
        plain = bytearray()
        data, at = self._begun + data, 0
        self._begun = b""
        while (iac := data.find(IAC, at)) >= 0:
            plain += data[at:iac]
            found = _sequence(data, iac)
            if found is None:
                at = len(data)
                self._begun = data[iac:]
                break
            item, at = found
            if isinstance(item, bytes):
                plain += item
                continue
            if plain:
                items.append(bytes(plain))
                plain.clear()
            items.append(item)
        plain += data[at:]
        if plain:
            items.append(bytes(plain))
        return items


def _sequence(data: bytes, iac: int) -> tuple[Item, int] | None:
    """Return the item that begins with this IAC, and the index of the item's end; None if the item is incomplete."""
    if len(data) < iac + 2:
        return None
    code = data[iac + 1]
    if code == IAC:
        return b"\xff", iac + 2
    if code == SB:
        return _subnegotiation(data, iac)
    if code < Verb.WILL:
        return Command(code), iac + 2
    return None if len(data) < iac + 3 else (Negotiation(Verb(code), data[iac + 2]), iac + 3)


def _subnegotiation(data: bytes, begin: int) -> tuple[Item, int] | None:
    payload, at = bytearray(), begin + 2
    while at < min(len(data) - 1, begin + LONGEST_SUBNEGOTIATION):
        if data[at] != IAC:
            payload.append(data[at])
            at += 1
        elif data[at + 1] == IAC:
            payload.append(IAC)
            at += 2
        elif data[at + 1] == SE and payload:
            return Subnegotiation(payload[0], bytes(payload[1:])), at + 2
        else:  # An incomplete subnegotiation is discarded if a new Telnet command begins.
            return Command(SB), at
    return None if at < begin + LONGEST_SUBNEGOTIATION else (Command(SB), at)
