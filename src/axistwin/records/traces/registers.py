"""Trace registers: poll them at each event, or receive their changes from the controller."""

from collections.abc import Callable, Mapping, Sequence

from axistwin.controllers.product import Register
from axistwin.core.lazy import NDArray, np
from axistwin.records.traces.batch import Part, Rows, Value


def written(value: int | str) -> Value:
    """Convert a register value for a trace: convert a text to ASCII bytes, and return a number unchanged."""
    return value.encode("ascii", "replace") if isinstance(value, str) else value


class PolledRegister:
    """A register that the tracer reads after each event of the simulation.  `known`: the value at the last event."""

    def __init__(self, place: int, register: Register, add: Callable[[int, int, Value], None]) -> None:
        self._place, self.read, self._add = place, register.read, add
        self.known = register.read()

    def record(self, now_ns: int, value: int | str) -> None:
        self.known = value
        self._add(now_ns, self._place, written(value))


class ReportedRegisters:
    """Records reported register changes; `places`: index of each register's signal."""

    def __init__(self, places: Sequence[int], registers: Mapping[str, Register]) -> None:
        self._places = places
        self._known = [register.read() for register in registers.values()]
        self.rows = Rows(3)  # Changes reported by the controller: times, indices of registers, new values.

    def parts(self, _since_ns: int, before_ns: int) -> list[Part]:
        """Remove and return the changes of each register before `before_ns`."""
        times, which, values = self.rows.take(before_ns)
        if not len(times):
            return []
        # Convert the register indexes to 16-bit numbers, because NumPy sorts 16-bit numbers faster.
        order = np.argsort(which.astype(np.int16), kind="stable")
        numbers, begins = np.unique(which[order], return_index=True)
        spans = zip(numbers.tolist(), begins.tolist(), [*begins[1:].tolist(), len(which)], strict=True)
        return [self._part(n, times[order[begin:end]], values[order[begin:end]]) for n, begin, end in spans]

    def _part(self, n: int, times: "NDArray[np.int64]", values: "NDArray[np.int64]") -> Part:
        changed = np.diff(values, prepend=self._known[n]) != 0
        self._known[n] = int(values[-1])
        return Part(self._places[n], times[changed], values[changed])
