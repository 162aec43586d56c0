"""The moments at which a device raises one of its fault flags, for those who want to know."""

from collections.abc import Callable


class Alarms:
    """`names`: the flags that are told, as the device's manual has them."""

    def __init__(self, *names: str) -> None:
        self.names = names
        self._watchers: list[Callable[[str], None]] = []

    def tell(self, name: str) -> None:
        """The device has raised this flag."""
        for watcher in tuple(self._watchers):
            watcher(name)

    def watch(self, watcher: Callable[[str], None]) -> Callable[[], None]:
        """Call `watcher(name)` whenever a flag is raised.  Returns what ends it."""
        self._watchers.append(watcher)
        return lambda: self._watchers.remove(watcher)
