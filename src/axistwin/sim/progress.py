"""Notification when a device begins a line of its stored program."""

from collections.abc import Callable

from axistwin.sim.signal import Signal

LineWatcher = Callable[[str, int], None]  # Called with a program's name and a line's index, from 0.
Line = tuple[str, int]  # A line of a program: the name of the program, and the index of the line from 0.


class Progress:
    """Reports the beginning of program lines; `attend()` is called after each change of `wanted`."""

    def __init__(self, attend: Callable[[], None] = lambda: None) -> None:
        self._attend = attend
        self._begins: Signal[str, int] = Signal()
        self._lines: list[Line | None] = []

    @property
    def wanted(self) -> frozenset[Line] | None:
        """Program lines whose execution must be reported to subscribers; None: all lines."""
        return None if None in self._lines else frozenset(line for line in self._lines if line is not None)

    def report(self, program: str, index: int) -> None:
        self._begins.emit(program, index)

    def subscribe(self, callback: LineWatcher, only: Line | None = None) -> Callable[[], None]:
        """Call `callback(program, index)` when a program line begins, or only the line `only`.

        The callback may read the bench but must not change it.  Return an unsubscribe function.
        """

        def begins(program: str, index: int) -> None:
            if only is None or only == (program, index):
                callback(program, index)

        unsubscribe = self._begins.subscribe(begins)
        self._lines.append(only)
        self._attend()

        def end() -> None:
            unsubscribe()
            self._lines.remove(only)
            self._attend()

        return end
