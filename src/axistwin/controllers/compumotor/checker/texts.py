"""Text form of commands, as users write them, and explanations of commands and messages.

A command is written in hex, `33 00 00 61 A8`, or by its name in the table: `go_relative 25000`.  Values are
decimal, or hex after 0x; ranges are their two digits, such as 00 or 51; a switch is 0 or 1, off or on, + or -.
"""

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cached_property
from itertools import accumulate, groupby, starmap
from typing import Any

from axistwin.controllers.commandset import CommandSet
from axistwin.controllers.compumotor import language, rules
from axistwin.controllers.compumotor.commands import COMMANDS_1811
from axistwin.controllers.diagnostics import Rule
from axistwin.controllers.product import Placed
from axistwin.core.errors import ProgramError
from axistwin.core.numbers import NumberError, shortened, whole

SWITCHES = {"0": 0, "1": 1, "off": 0, "on": 1, "+": 0, "-": 1, "low": 0, "high": 1}
_HEX = re.compile(r"(?:[0-9A-Fa-f]{2})+")
_DIGITS = re.compile(r"[+-]?(?:0[xX][0-9A-Fa-f]+|[0-9]+)")
_SIGNS = {" + ": " plus ", " - ": " minus "}


def name_of(command: language.Opcode) -> str:
    """Return the name that a user writes for a command, e.g. `go_relative_encoder`."""
    name = command.name.lower()
    for sign, word in _SIGNS.items():
        name = name.replace(sign, word)
    return re.sub(r"[^a-z0-9]+", "_", name.replace("'", "")).strip("_")


@dataclass(frozen=True)
class Words:
    """Converts the commands and messages of one model from bytes to text and back."""

    commands: CommandSet
    model: str = "1811"

    def read(self, text: str) -> bytes:
        """Return the bytes of a command in hex or by its name.  Raise ProgramError with the column, counted from 1."""
        return bytes(placed.byte for placed in self.placed(text))

    def placed(self, text: str) -> list[Placed]:
        """Return the bytes of a command, each with its column in the command text."""
        words = list(re.finditer(r"\S+", text.partition(";")[0]))
        if not words:
            raise ProgramError(
                "the command is missing: expected hex or a name, e.g. 33 00 00 61 A8 or go_relative 25000", column=1
            )
        found = _hex(words) if _HEX.fullmatch(words[0][0]) else self._named(words)
        if len(found) > language.LONGEST:
            raise ProgramError(
                f"the command is too long: expected at most {language.LONGEST} bytes",
                column=found[language.LONGEST].column + 1,
                code=rules.TOO_LONG.code,
            )
        return found

    def message(self, text: str) -> bytes:
        """Return the bytes of a message in hex, padded with zeros to the length of a message."""
        words = list(re.finditer(r"\S+", text.partition(";")[0]))
        data = bytes(placed.byte for placed in _hex(words))
        if len(data) > language.LONGEST:
            raise ProgramError(f"the message is too long: expected at most {language.LONGEST} bytes", column=1)
        return data.ljust(language.LONGEST, b"\0") if data else b""

    def explain(self, command: bytes) -> str:
        found = language.decode(self.commands, command)
        return "means nothing" if found is None else _sentence(found[0].name, _values(found[0].fields, command[1:]))

    def explain_message(self, message: bytes) -> str:
        """Return a text that explains the meaning and the values of a message from the board."""
        opcode, data = message[0], message[1:]
        command = COMMANDS_1811.get(opcode)
        if not isinstance(command, language.Opcode):
            return "means nothing"
        if opcode in SPECIAL:
            return f"{command.name}: {SPECIAL[opcode](data)}"
        fields = command.fields if 0x51 <= opcode <= 0x53 else LAYOUTS.get(opcode, ())
        if fields is _INDEXED and _streamed(data):
            fields = _STREAMED
        return _sentence(command.name, _values(fields, data))

    def _named(self, words: list[re.Match[str]]) -> list[Placed]:
        command = self._find(words[0])
        fields = [field for field in command.fields if not isinstance(field, language.DontCare)]
        if len(words) - 1 != len(fields):
            value_names = " ".join(field.name.replace(" ", "_") for field in fields) or "no value"
            raise _wrong(
                f"wrong number of values for the command {words[0][0]}: expected {value_names}",
                rules.NUMBER_OF_VALUES,
                words[0],
            )
        values = iter(words[1:])
        found = [Placed(command.opcode, words[0].start(), len(words[0][0]))]
        for field in command.fields:
            word = words[0] if isinstance(field, language.DontCare) else next(values)
            data = bytes(field.size) if isinstance(field, language.DontCare) else _value(field, word)
            found += [Placed(byte, word.start(), len(word[0])) for byte in data]
        return found

    @cached_property
    def _names(self) -> dict[str, language.Opcode]:
        return {name_of(command): command for command in self.commands if isinstance(command, language.Opcode)}

    def _find(self, word: re.Match[str]) -> language.Opcode:
        names = self._names
        if word[0] in names:
            return names[word[0]]
        likely = re.sub(r"[^a-z0-9]+", "_", word[0].lower()).strip("_")
        near = [likely] if likely in names else get_close_matches(likely, names, 3)
        hint = f"did you mean {' or '.join(near)}?" if near else f"axistwin commands {self.model} lists them"
        error = _wrong(f"no command {word[0]!r}: {hint}", rules.UNKNOWN_NAME, word)
        error.instead, error.sure = near[0] if near else "", likely in names
        raise error


def _wrong(message: str, rule: Rule, word: re.Match[str]) -> ProgramError:
    return ProgramError(message, column=word.start() + 1, code=rule.code, width=len(word[0]))


def _hex(words: Iterable[re.Match[str]]) -> list[Placed]:
    found = []
    for word in words:
        given_byte = word[0]
        if not _HEX.fullmatch(given_byte):
            raise _wrong(f"{given_byte!r} is not a byte: expected two hex digits", rules.WORD, word)
        found += [Placed(byte, word.start() + 2 * number) for number, byte in enumerate(bytes.fromhex(given_byte))]
    return found


def _value(field: language.Number, word: re.Match[str]) -> bytes:
    value = _read(field, word[0])
    if value is None:
        given, valid_values = shortened(word[0]), _valid_values(field)
        raise _wrong(f"invalid {field.name} {given}: expected {valid_values}", rules.WORD, word)
    return field.encode(value)


def _read(field: language.Number, text: str) -> Any:
    if isinstance(field, language.Ranges):
        return field.decode(bytes.fromhex(text)) if re.fullmatch(r"[0-9A-Fa-f]{2}", text) else None
    if isinstance(field, language.Switch):
        return SWITCHES.get(text.lower())
    if not _DIGITS.fullmatch(text):
        return None
    try:
        value = whole(text, base=16 if "x" in text.lower() else 10)
    except NumberError:
        return None
    return value if field.allows(value) else None


def _valid_values(field: language.Number) -> str:
    if isinstance(field, language.Ranges):
        return "the digits of velocity range (0 to 5) and acceleration range (0 to 2), e.g. 00"
    if isinstance(field, language.Switch):
        return f"one of {', '.join(SWITCHES)}"
    return f"a number, {field}"


def _position(name: str, size: int, unit: str = "pulses") -> tuple[language.Number, ...]:
    return (language.Number(name, unit, size=size, signed=True),)


_RANGES = language.Ranges("ranges")
_TRIGGER = (language.u8("trigger"),)

_INDEXED = _RANGES, language.u32("velocity")  # Fields of the answer to 85h in indexer mode.
_STREAMED = (language.StreamedVelocity("velocity", "effective clock/65536", size=2),)
"""Fields of the answer to 85h in a streaming mode."""

LAYOUTS: dict[int, tuple[language.Number, ...]] = {
    0x01: (language.u8("identifier"),),
    **dict.fromkeys((*range(0x74, 0x78), *range(0x7C, 0x80), 0xAC), _TRIGGER),
    0x80: _position("position", 4),
    0x81: _position("short of the end", 4),
    0x82: _position("position", 6),
    0x83: _position("position", 6),
    0x85: _INDEXED,
    0x86: (_RANGES, language.u32("acceleration")),
    0x98: _position("count", 4, "encoder pulses"),
    0x99: _position("error", 4, "encoder pulses"),
    0x9A: _position("count", 4, "encoder pulses"),
    0x9B: (language.u32("slip", unit="rotor teeth"),),
    0x9C: (language.u16("motor pulses"), language.u16("encoder pulses")),
    0x9D: (language.u32("resolution", unit="pulses/rev"),),
    0x9E: (language.i32("sigma", unit="motor steps"),),
    0x9F: (language.u8("algorithm"), language.u8("constant"), _RANGES, language.u32("maximum velocity")),
    0xE2: (language.u32("bytes"),),
}
"""Fields of the messages that consist of numbers, by the opcode of the message."""

STATUS = ("+ limit", "- limit", "home", "direction -", "moving", "constant velocity", "accelerating", "decelerating")
LIMITS = {0x00: "none", 0x0F: "-", 0xF0: "+", 0xFF: "both"}


def _bits(names: Iterable[str], byte: int) -> str:
    return ", ".join(name for number, name in enumerate(names) if byte >> number & 1 and name) or "none"


def _of_a_command(data: bytes) -> str:
    """Explain a stored command; the default move has the number 0, which no host may send."""
    command = COMMANDS_1811.get(data[0])
    if not data[0]:
        return "end of the list"
    if not isinstance(command, language.Opcode):
        return "means nothing"
    return _sentence(command.name, _values(command.fields, data[1:]))


SPECIAL: dict[int, Callable[[bytes], str]] = {
    **dict.fromkeys((0x84, 0x8B), lambda data: "-" if data[0] else "+"),
    0x88: lambda data: _bits(STATUS, data[0]),
    0x89: lambda data: LIMITS.get(data[0], f"{data[0]:02X}"),
    **dict.fromkeys((0x8A, 0x8C, 0x8D, 0x8E, 0x8F, 0x93, 0x96), lambda data: "yes" if data[0] else "no"),
    0x95: lambda data: "no, the input is high" if data[0] else "yes, the input is low",
    **dict.fromkeys((0x90, 0x91, 0x92), _of_a_command),
    0x94: lambda data: f"{_bits(('', '', '2', '3', '4', '5'), data[0])} high",
    0x97: lambda data: f"{_bits(('', '1', '2'), data[0])} set",
    0xFD: lambda data: data.rstrip(b"\0").decode("ascii", "replace"),
}


def _streamed(data: bytes) -> bool:
    # A streamed velocity whose lower byte is 0 can equal a velocity of 0 of indexer mode in some ranges.
    return _RANGES.decode(data) is None or data[1] != 0


def _values(fields: Iterable[language.Number], data: bytes) -> Iterable[str]:
    """Yield names, values and units; values of one kind that follow each other share them."""
    fields = tuple(fields)
    ends = accumulate(field.size for field in fields)
    parts = [(field, data[end - field.size : end]) for field, end in zip(fields, ends, strict=True)]
    told = [each for each in parts if not isinstance(each[0], language.DontCare)]
    for (name, unit), same in groupby(told, lambda each: (each[0].name, each[0].unit)):
        yield f"{name} {', '.join(starmap(_shown, same))} {unit}".rstrip()


def _shown(field: language.Number, data: bytes) -> str:
    if isinstance(field, language.Ranges):
        return data.hex()
    if isinstance(field, language.Switch):
        return "0" if not data[0] else "1"
    value = int.from_bytes(data, "big", signed=field.signed)
    if isinstance(field, language.StreamedVelocity) and value & language.CCW:
        return f"CCW {value - language.CCW}"
    return str(value)


def _sentence(name: str, parts: Iterable[str]) -> str:
    values = ", ".join(parts)
    return f"{name}: {values}" if values else name
