"""The moments at which a device begins a line of a program that it keeps, for those who want to know."""

from collections.abc import Callable

LineWatcher = Callable[[str, int], None]
"""Told the name of the program, and the line's index from 0."""


class Progress:
    """Who is told.  `attend(True)` is called when the first one comes, `attend(False)` when the last one has gone."""

    def __init__(self, attend: Callable[[bool], None] = lambda watched: None) -> None:
        self._attend = attend
        self._watchers: list[LineWatcher] = []

    @property
    def watched(self) -> bool:
        """Whether anybody wants to know."""
        return bool(self._watchers)

    def tell(self, program: str, index: int) -> None:
        """This line begins now."""
        for watcher in tuple(self._watchers):
            watcher(program, index)

    def watch(self, watcher: LineWatcher) -> Callable[[], None]:
        """Call `watcher(program, index)` whenever a line begins.  It may look and must change nothing at that moment.

        Returns what ends it.
        """
        self._watchers.append(watcher)
        if len(self._watchers) == 1:
            self._attend(True)

        def look_away() -> None:
            self._watchers.remove(watcher)
            if not self._watchers:
                self._attend(False)

        return look_away
