"""Nonvolatile memory: the program (section 15 of the base language) and the data EEPROM (section 6)."""

from dataclasses import dataclass, field
from typing import Any

from axistwin.controllers.product import Store
from axistwin.core.storage import check_key, explaining_memory_errors

VERSION = 1
MOST_EEPROM = 32768
ERASED = 0xFF


@dataclass
class Nonvolatile:
    """The contents of program memory and data EEPROM."""

    program: str = ""  # The text of the program as `image.strip` makes it.
    broken: bool = False  # True if a download was interrupted or damaged.
    locked: bool = False  # True if the command LOCKP has forbidden uploads of the program.
    eeprom: bytearray = field(default_factory=bytearray)  # As far as it has been written to; the rest is erased.

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
        """Return the saved contents, those of a new motor without any.  Raises UsageError for an invalid file."""
        contents = store.load()
        if contents is None:
            return cls()
        import json  # lazy import: only memory files need the module `json`

        with explaining_memory_errors(store, "a SmartMotor"):
            return cls._from(json.loads(contents))

    @classmethod
    def _from(cls, kept: Any) -> "Nonvolatile":
        check_key("version", isinstance(kept, dict) and kept.get("version") == VERSION, f"{VERSION}")
        check_key("program", isinstance(kept["program"], str), "the text of a program")
        kept["program"].encode("latin-1")
        check_key("broken", isinstance(kept["broken"], bool), "true or false")
        check_key("locked", isinstance(kept["locked"], bool), "true or false")
        eeprom = bytearray.fromhex(kept["eeprom"])
        check_key("eeprom", len(eeprom) <= MOST_EEPROM, f"at most {MOST_EEPROM} bytes")
        return cls(kept["program"], kept["broken"], kept["locked"], eeprom)

    def read(self, place: int, size: int) -> bytes:
        return bytes(self.eeprom[place : place + size]).ljust(size, bytes((ERASED,)))

    def write(self, place: int, data: bytes) -> bool:
        """Write bytes to the data EEPROM.  Return True if a byte has changed."""
        if self.read(place, len(data)) == data:
            return False
        self.eeprom.extend((ERASED,) * (place - len(self.eeprom)))
        self.eeprom[place : place + len(data)] = data
        return True
