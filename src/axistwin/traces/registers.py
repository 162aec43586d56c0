"""What registers have done, as changes of signals: those that are looked at, and those that a controller tells of."""

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

from axistwin.controllers.product import Register
from axistwin.traces.batch import Part, Rows, Value

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


def written(value: int | str) -> Value:
    """A register's value as it is written."""
    return value.encode("ascii", "replace") if isinstance(value, str) else value


class Looked:
    """A register as it was when somebody looked last."""

    def __init__(self, place: int, register: Register, add: Callable[[int, int, Value], None]) -> None:
        self._place, self.read, self._add = place, register.read, add
        self.known = register.read()

    def take(self, now_ns: int, value: int | str) -> None:
        """It is another at the end of a nanosecond in which something has happened."""
        self.known = value
        self._add(now_ns, self._place, written(value))


class Followed:
    """Registers of one controller, which tells of changes when it has got so far; `places`: where they are traced."""

    def __init__(self, places: Sequence[int], registers: Mapping[str, Register]) -> None:
        self._places = places
        self._known = [register.read() for register in registers.values()]
        self.rows = Rows(3)
        """What the controller tells: times, which of the registers, their values from then on."""

    def parts(self, _since_ns: int, before_ns: int) -> list[Part]:
        """What has changed before a time."""
        import numpy as np

        times, which, values = self.rows.take(before_ns)
        if not len(times):
            return []
        order = np.argsort(which.astype(np.int16), kind="stable")  # so short that it is sorted by counting
        numbers, begins = np.unique(which[order], return_index=True)
        spans = zip(numbers.tolist(), begins.tolist(), [*begins[1:].tolist(), len(which)], strict=True)
        return [self._part(n, times[order[begin:end]], values[order[begin:end]]) for n, begin, end in spans]

    def _part(self, n: int, times: "NDArray[np.int64]", values: "NDArray[np.int64]") -> Part:
        """Changes of one register, as far as they are changes."""
        import numpy as np

        changed = np.diff(values, prepend=self._known[n]) != 0
        self._known[n] = int(values[-1])
        return Part(self._places[n], times[changed], values[changed])
