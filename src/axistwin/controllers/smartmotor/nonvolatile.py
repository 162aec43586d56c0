"""Nonvolatile memory: the program (section 15 of the base language) and the data EEPROM (section 6)."""

from dataclasses import dataclass, field
from typing import Any

from axistwin.controllers.product import Store
from axistwin.errors import UsageError
from axistwin.storage import excerpt

VERSION = 1
MOST_EEPROM = 32768
ERASED = 0xFF


@dataclass
class Nonvolatile:
    """The contents of program memory and data EEPROM."""

    program: str = ""
    """The text of the program as `image.strip` makes it."""
    broken: bool = False
    """True if a download was interrupted or damaged."""
    locked: bool = False
    """True if the command LOCKP has forbidden uploads of the program."""
    eeprom: bytearray = field(default_factory=bytearray)
    """The data EEPROM as far as it has been written to; the rest is erased."""

    def save(self, store: Store) -> None:
        """Save the contents of the motor's nonvolatile memory as readable text."""
        contents = {
            "version": VERSION,
            "program": self.program,
            "broken": self.broken,
            "locked": self.locked,
            "eeprom": self.eeprom.hex(),
        }
        import json  # lazy import: only memory files need the module `json`

        store.save(json.dumps(contents, indent=1).encode())

    @classmethod
    def load(cls, store: Store) -> "Nonvolatile":
        """Read the saved contents of a motor's nonvolatile memory.

        Returns the empty memory of a new motor if nothing has been saved.  Raises UsageError for an invalid file.
        """
        contents = store.load()
        if contents is None:
            return cls()
        import json  # lazy import: only memory files need the module `json`

        try:
            return cls._from(json.loads(contents))
        except (ValueError, TypeError, KeyError, RecursionError) as error:
            memory_file, reason = store, excerpt(error)
            raise UsageError(
                f"{memory_file} is not a memory file of a SmartMotor ({reason}): delete the file to start without data"
            ) from None

    @classmethod
    def _from(cls, kept: Any) -> "Nonvolatile":
        _require(isinstance(kept, dict) and kept.get("version") == VERSION, "version", f"{VERSION}")
        _require(isinstance(kept["program"], str), "program", "the text of a program")
        kept["program"].encode("latin-1")
        _require(isinstance(kept["broken"], bool), "broken", "true or false")
        _require(isinstance(kept["locked"], bool), "locked", "true or false")
        eeprom = bytearray.fromhex(kept["eeprom"])
        _require(len(eeprom) <= MOST_EEPROM, "eeprom", f"at most {MOST_EEPROM} bytes")
        return cls(kept["program"], kept["broken"], kept["locked"], eeprom)

    def read(self, place: int, size: int) -> bytes:
        """Return `size` bytes of the data EEPROM, beginning at the address `place`."""
        return bytes(self.eeprom[place : place + size]).ljust(size, bytes((ERASED,)))

    def write(self, place: int, data: bytes) -> bool:
        """Write bytes to the data EEPROM.  Return True if a byte has changed."""
        if self.read(place, len(data)) == data:
            return False
        self.eeprom.extend((ERASED,) * (place - len(self.eeprom)))
        self.eeprom[place : place + len(data)] = data
        return True


def _require(valid: bool, key: str, expected: str) -> None:
    if not valid:
        raise ValueError(f"invalid value of the key {key!r}: expected {expected}")
