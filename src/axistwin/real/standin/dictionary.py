"""The data dictionary of a board: its messages, its pins and its constants (Klipper's Protocol, Data Dictionary).

The board sends the dictionary on request, as JSON compressed by zlib.  Only the command `identify` and its response
have fixed identifiers.
"""

import json
import re
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from axistwin.core.errors import LinkError
from axistwin.real.standin import frames

IDENTIFY, IDENTIFY_RESPONSE = "identify offset=%u count=%c", "identify_response offset=%u data=%.*s"
_ARGUMENT = re.compile(r"(\w+)=(%[.*a-z]+)")
_TEXT = re.compile(r"%[.*a-z]+")

Value = int | bytes


@dataclass(frozen=True)
class Format:
    """Format of a message in Klipper's protocol, with its identifier and its parameters."""

    number: int
    text: str
    name: str
    parameters: tuple[tuple[str, bool], ...]  # Name of each parameter, and True if the parameter is a string.

    @classmethod
    def read(cls, text: str, number: int) -> "Format":
        """Parse the description of a message format, e.g. `queue_step oid=%c interval=%u`."""
        found = _ARGUMENT.findall(text)
        return cls(number, text, text.split()[0], tuple((name, kind.endswith("s")) for name, kind in found))


class Dictionary:
    """A firmware's commands, responses, pins and constants.  Raises LinkError for an invalid one."""

    def __init__(self, described: Mapping[str, Any] | None = None) -> None:
        described = described or {}
        try:
            commands, responses = described.get("commands", {}), described.get("responses", {})
            self.commands = {each.name: each for each in map(Format.read, commands, commands.values())}
            self._responses = {number: Format.read(text, number) for text, number in responses.items()}
            self.constants: dict[str, Any] = dict(described.get("config", {}))
            self.version = str(described.get("version", ""))
            self._outputs = {number: str(text) for text, number in described.get("output", {}).items()}
            enumerations = described.get("enumerations", {})
            self.pins = _numbered(enumerations.get("pin", {}))
            self._texts = {number: text for text, number in _numbered(enumerations.get("static_string_id", {})).items()}
        except (AttributeError, TypeError, ValueError, IndexError) as reason:
            raise LinkError(f"the board's firmware has sent an invalid dictionary: {reason}") from None
        self.commands.setdefault("identify", Format.read(IDENTIFY, 1))
        self._responses.setdefault(0, Format.read(IDENTIFY_RESPONSE, 0))

    @classmethod
    def unpack(cls, data: bytes) -> "Dictionary":
        """Decompress the data dictionary (commands, pins and constants) that a board's firmware has sent."""
        try:
            described = json.loads(zlib.decompress(data))
        except (zlib.error, ValueError) as reason:
            raise LinkError(
                f"the board's firmware has sent an invalid dictionary ({reason}): expected compressed JSON"
            ) from None
        if not isinstance(described, dict):
            raise LinkError("the board's firmware has sent an invalid dictionary: expected a JSON object")
        return cls(described)

    @property
    def clock_hz(self) -> float:
        return float(self.constants["CLOCK_FREQ"])

    def encode(self, name: str, **values: Value) -> bytes:
        """Encode a command as bytes.  Raises LinkError if the firmware does not have the command."""
        if name not in self.commands:
            raise LinkError(f"the board's firmware has no command {name!r}: install Klipper firmware with this command")
        command = self.commands[name]
        missing = {parameter for parameter, _ in command.parameters} ^ values.keys()
        if missing:
            raise LinkError(
                f"the command {name!r} of the board's firmware has unexpected parameters: "
                "use Klipper firmware of 2022 or later"
            )
        encoded = [frames.integer(command.number)]
        for parameter, _ in command.parameters:
            value = values[parameter]
            encoded.append(frames.integer(value) if isinstance(value, int) else frames.integer(len(value)) + value)
        return b"".join(encoded)

    def decode(self, content: bytes) -> tuple[str, dict[str, Any]]:
        """Decode a response; return its name, "" if it is unknown, and its values."""
        try:
            number, at = frames.read_integer(content, 0)
            if number in self._outputs:
                return "output", {"text": _TEXT.sub("…", self._outputs[number])}
            if number not in self._responses:
                return "", {}
            response = self._responses[number]
            values: dict[str, Any] = {}
            for name, is_string in response.parameters:
                value, at = frames.read_integer(content, at)
                if is_string:
                    values[name] = content[at : at + value]
                    at += value
                else:
                    values[name] = self._texts.get(value, value) if name == "static_string_id" else value
        except IndexError:
            return "", {}
        return response.name, values


def _numbered(enumeration: Mapping[str, Any]) -> dict[str, int]:
    """Expand pin ranges: {"PC0": [16, 3]}, i.e. 3 pins from number 16, becomes {"PC0": 16, "PC1": 17, "PC2": 18}."""
    numbers: dict[str, int] = {}
    for name, value in enumeration.items():
        if isinstance(value, int):
            numbers[name] = value
            continue
        first, count = value
        root = name.rstrip("0123456789")
        begin = int(name[len(root) :] or 0)
        numbers |= {f"{root}{begin + n}": first + n for n in range(count)}
    return numbers
