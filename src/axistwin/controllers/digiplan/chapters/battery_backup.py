"""Chapter Using the battery backup (IF2 only): the data that a locked interface keeps without power."""

from dataclasses import asdict, dataclass, field

from axistwin.controllers.digiplan.chapters.data_format import BAUD_RATES, FORMAT_MESSAGE, Frame, MessageFormat
from axistwin.controllers.digiplan.commands import COMMANDS
from axistwin.controllers.digiplan.language import parse
from axistwin.controllers.digiplan.step import RANGES, Parameters
from axistwin.controllers.product import Store
from axistwin.core.storage import check_key, explaining_memory_errors

_BAUD_RATE = "a baud rate of an IF2, e.g. 9600"


@dataclass(frozen=True)
class Retained:
    """Data that an IF2 keeps in its battery-backed memory while the power is off.  Only a locked IF2 keeps the data."""

    locked: bool = False
    baudrate: int = 9600
    frame: Frame = field(default_factory=Frame)
    parameters: Parameters = field(default_factory=Parameters)
    sequence: str = ""
    lock: MessageFormat | None = None  # Format of the lock, which the unlock must have; None: any.

    def save(self, store: Store) -> None:
        """Save the retained data, e.g. the baud rate, in the battery-backed memory, as JSON."""
        import json

        store.save(json.dumps(asdict(self), indent=1).encode())

    @classmethod
    def recall(cls, memory_file: Store) -> "Retained":
        """Load the memory of an IF2; defaults if it is empty.  Raises UsageError if the file is damaged."""
        contents = memory_file.load()
        if contents is None:
            return cls()
        import json

        with explaining_memory_errors(memory_file, "an IF2"):
            kept = json.loads(contents)
            frame, parameters = Frame(**kept.pop("frame")), Parameters(**kept.pop("parameters"))
            lock = kept.pop("lock", None)
            lock = None if lock is None else MessageFormat(**{**lock, "eighth": tuple(lock["eighth"])})
            retained = cls(frame=frame, parameters=parameters, lock=lock, **kept)
            retained.check()
        return retained

    def check(self) -> None:
        """Raise ValueError if the data in the memory contain an invalid value."""
        for name, (low, high) in RANGES.items():
            value = getattr(self.parameters, name)
            check_key(name, type(value) is int and low <= value <= high, f"an integer, {low} to {high}")
        check_key("locked", type(self.locked) is bool, "true or false")
        check_key("baudrate", _is_baud_rate(self.baudrate), _BAUD_RATE)
        frame, lock = self.frame, self.lock
        is_format = FORMAT_MESSAGE.fullmatch(f"{frame.terminator}{frame.x1}{frame.x2}") is not None
        check_key("frame", is_format, "a data format, e.g. U61")
        check_key("frame", type(frame.x1) is int and type(frame.x2) is int, "integers x1 and x2")
        if lock:
            check_key("lock", _is_baud_rate(lock.baudrate), _BAUD_RATE)
            check_key("lock", type(lock.bytesize) is int and lock.bytesize in (7, 8), "7 or 8 data bits")
            check_key("lock", lock.parity in ("N", "O", "E"), "parity N, O or E")
            are_bits = len(lock.eighth) == 2 and all(type(bit) is bool for bit in lock.eighth)
            check_key("lock", are_bits, "two values of eighth, true or false")
        is_sequence = type(self.sequence) is str and not parse(self.sequence, COMMANDS).problems
        check_key("sequence", is_sequence, "valid commands of an IF2")


def _is_baud_rate(value: object) -> bool:
    return type(value) is int and value in BAUD_RATES
