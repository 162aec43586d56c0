"""What registers have done, as changes of signals: those that are looked at, and those that a controller tells of."""

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

from axistwin.apps.traces.batch import Part, Value
from axistwin.controllers.product import Register

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
        self._told: list[tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]] = []
        self.waiting = 0

    def take(self, times: Sequence[int], which: Sequence[int], values: Sequence[int]) -> None:
        """The controller tells."""
        import numpy as np

        self._told.append((np.array(times, np.int64), np.array(which, np.int64), np.array(values, np.int64)))
        self.waiting += len(times)

    def parts(self, _since_ns: int, before_ns: int) -> list[Part]:
        """What has changed before a time."""
        import numpy as np

        if not self._told:
            return []
        times, which, values = (np.concatenate(column) for column in zip(*self._told, strict=True))
        due = int(np.searchsorted(times, before_ns))
        self._told = [(times[due:], which[due:], values[due:])] if due < len(times) else []
        self.waiting = len(times) - due
        if not due:
            return []
        order = np.argsort(which[:due], kind="stable")
        numbers, begins = np.unique(which[order], return_index=True)
        spans = zip(numbers.tolist(), begins.tolist(), [*begins[1:].tolist(), due], strict=True)
        return [self._part(n, times[order[begin:end]], values[order[begin:end]]) for n, begin, end in spans]

    def _part(self, n: int, times: "NDArray[np.int64]", values: "NDArray[np.int64]") -> Part:
        """Changes of one register, as far as they are changes."""
        import numpy as np

        changed = np.diff(values, prepend=self._known[n]) != 0
        self._known[n] = int(values[-1])
        return Part(self._places[n], times[changed], values[changed])
