"""Chapter Using the battery backup (IF2 only): the data that a locked interface keeps without power."""

from collections.abc import Iterator
from dataclasses import asdict, dataclass, field

from axistwin.controllers.digiplan.chapters.data_format import BAUD_RATES, FORMAT_MESSAGE, Frame, MessageFormat
from axistwin.controllers.digiplan.commands import COMMANDS
from axistwin.controllers.digiplan.language import parse
from axistwin.controllers.digiplan.step import RANGES, Parameters
from axistwin.controllers.product import Store
from axistwin.errors import UsageError
from axistwin.storage import excerpt

_BAUD_RATE = "a baud rate of an IF2, e.g. 9600"


@dataclass(frozen=True)
class Retained:
    """Data that an IF2 keeps in its battery-backed memory while the power is off.

    Only a locked IF2 keeps the data.
    """

    locked: bool = False
    baudrate: int = 9600
    frame: Frame = field(default_factory=Frame)
    parameters: Parameters = field(default_factory=Parameters)
    sequence: str = ""
    lock: MessageFormat | None = None
    """Format of the lock command.  The unlock command must have this format; None means that any format is valid."""

    def save(self, store: Store) -> None:
        """Save the retained data, e.g. the baud rate, in the battery-backed memory.

        The data are stored as JSON text.
        """
        import json

        store.save(json.dumps(asdict(self), indent=1).encode())

    @classmethod
    def recall(cls, memory_file: Store) -> "Retained":
        """Load the data in the battery-backed memory of an IF2.  Return default values if the memory is empty.

        Raises UsageError if the file is damaged.
        """
        contents = memory_file.load()
        if contents is None:
            return cls()
        import json

        try:
            kept = json.loads(contents)
            frame, parameters = Frame(**kept.pop("frame")), Parameters(**kept.pop("parameters"))
            lock = kept.pop("lock", None)
            lock = None if lock is None else MessageFormat(**{**lock, "eighth": tuple(lock["eighth"])})
            retained = cls(frame=frame, parameters=parameters, lock=lock, **kept)
            retained.check()
        except (ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
            reason = excerpt(error)
            raise UsageError(
                f"{memory_file} is not a memory file of an IF2 ({reason}): delete the file to start without data"
            ) from None
        return retained

    def check(self) -> None:
        """Raise ValueError if the data in the memory contain an invalid value."""
        for key, expected, valid in self._checks():
            if not valid:
                raise ValueError(f"invalid value of the key {key!r}: expected {expected}")

    def _checks(self) -> Iterator[tuple[str, str, bool]]:
        """Check the values in the battery-backed memory.  Yield a key, the expected value and a result for each check.

        The result is True for a valid value, e.g. ("locked", "true or false", True).
        """
        for name, (low, high) in RANGES.items():
            value = getattr(self.parameters, name)
            yield name, f"an integer, {low} to {high}", type(value) is int and low <= value <= high
        yield "locked", "true or false", type(self.locked) is bool
        yield "baudrate", _BAUD_RATE, type(self.baudrate) is int and self.baudrate in BAUD_RATES
        frame, lock = self.frame, self.lock
        message = f"{frame.terminator}{frame.x1}{frame.x2}"
        yield "frame", "a data format, e.g. U61", FORMAT_MESSAGE.fullmatch(message) is not None
        yield "frame", "integers x1 and x2", type(frame.x1) is int and type(frame.x2) is int
        if lock:
            yield "lock", _BAUD_RATE, type(lock.baudrate) is int and lock.baudrate in BAUD_RATES
            yield "lock", "7 or 8 data bits", type(lock.bytesize) is int and lock.bytesize in (7, 8)
            yield "lock", "parity N, O or E", lock.parity in ("N", "O", "E")
            yield (
                "lock",
                "two values of eighth, true or false",
                len(lock.eighth) == 2 and all(type(bit) is bool for bit in lock.eighth),
            )
        yield (
            "sequence",
            "valid commands of an IF2",
            type(self.sequence) is str and not parse(self.sequence, COMMANDS).problems,
        )
