"""The moments at which a device begins a line of a program that it keeps, for those who want to know."""

from collections.abc import Callable

LineWatcher = Callable[[str, int], None]
"""Told the name of the program, and the line's index from 0."""
Line = tuple[str, int]
"""A line by the same."""


class Progress:
    """Who is told of which lines.  `attend()` is called whenever others are wanted than before."""

    def __init__(self, attend: Callable[[], None] = lambda: None) -> None:
        self._attend = attend
        self._watchers: list[tuple[LineWatcher, Line | None]] = []

    @property
    def wanted(self) -> frozenset[Line] | None:
        """The lines that somebody wants to know of; None: all."""
        lines = frozenset(line for _, line in self._watchers if line is not None)
        return lines if len(lines) == len({line for _, line in self._watchers}) else None

    def tell(self, program: str, index: int) -> None:
        """This line begins now."""
        for watcher, line in tuple(self._watchers):
            if line is None or line == (program, index):
                watcher(program, index)

    def watch(self, watcher: LineWatcher, only: Line | None = None) -> Callable[[], None]:
        """Call `watcher(program, index)` whenever a line begins, or `only` this one.

        It may look and must change nothing at that moment.  Returns what ends it.
        """
        entry = watcher, only
        self._watchers.append(entry)
        self._attend()

        def look_away() -> None:
            self._watchers.remove(entry)
            self._attend()

        return look_away
