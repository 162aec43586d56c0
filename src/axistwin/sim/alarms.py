"""Notification when a device raises one of its fault flags."""

from collections.abc import Callable

from axistwin.sim.signal import Signal


class Alarms:
    """The fault flags of a device.  `names`: the flags that are reported, named as in the device's manual."""

    def __init__(self, *names: str) -> None:
        self.names = names
        self._raised: Signal[str] = Signal()

    def report(self, name: str) -> None:
        """Notify the subscribers that the device raises the fault flag `name`."""
        self._raised.emit(name)

    def subscribe(self, callback: Callable[[str], None]) -> Callable[[], None]:
        """Call `callback(name)` whenever the device raises the fault flag `name`.  Return an unsubscribe function."""
        return self._raised.subscribe(callback)
