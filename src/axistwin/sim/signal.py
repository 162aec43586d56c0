"""The observer pattern: callbacks that subscribe to a signal, e.g. to the fault flags of a device."""

from collections.abc import Callable
from typing import Generic, ParamSpec

P = ParamSpec("P")


class Signal(Generic[P]):
    """A list of callbacks, which `emit` calls in order of subscription; true if there are any."""

    def __init__(self) -> None:
        self._callbacks: tuple[Callable[P, object], ...] = ()

    def __bool__(self) -> bool:
        return bool(self._callbacks)

    def subscribe(self, callback: Callable[P, object]) -> Callable[[], None]:
        """Subscribe a function: each later call of `emit` calls this function.  Return an unsubscribe function."""
        self._callbacks = (*self._callbacks, callback)
        return lambda: self._unsubscribe(callback)

    def _unsubscribe(self, callback: Callable[P, object]) -> None:
        left = list(self._callbacks)
        left.remove(callback)
        self._callbacks = tuple(left)

    def emit(self, *args: P.args, **kwargs: P.kwargs) -> None:
        """Call all subscribed callbacks.  A callback that is unsubscribed during the call of `emit` is still called."""
        for callback in self._callbacks:
            callback(*args, **kwargs)


class Alarms(Signal[str]):
    """Emits each fault flag that a device raises.  `names`: all flags, named as in the device's manual."""

    def __init__(self, *names: str) -> None:
        super().__init__()
        self.names = names
