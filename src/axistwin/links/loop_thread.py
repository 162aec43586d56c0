"""An event loop in a separate thread, for programs that do not use asyncio."""

import asyncio
import threading
from collections.abc import Callable, Coroutine
from typing import Any, TypeVar

from axistwin.core.errors import UsageError

T = TypeVar("T")


class LoopThread:
    """Runs coroutines and functions for other threads.  `problems` collects the errors of callbacks."""

    def __init__(self) -> None:
        self.problems: list[dict[str, Any]] = []
        self._loop = asyncio.new_event_loop()
        self._loop.set_exception_handler(lambda _, context: self.problems.append(context))
        self._thread = threading.Thread(target=self._loop.run_forever, name="axistwin", daemon=True)
        self._thread.start()

    def run(self, coroutine: Coroutine[Any, Any, T]) -> T:
        """Return a coroutine's result in the loop's thread.  Raises UsageError in that thread, or after `stop`."""
        inside = threading.current_thread() is self._thread
        if inside or self._loop.is_closed():
            coroutine.close()  # Closing the coroutine prevents Python's warning that a coroutine was never awaited.
            self.check_outside()
            raise UsageError("the controllers are closed: use the controllers only inside the `with` block")
        return asyncio.run_coroutine_threadsafe(coroutine, self._loop).result()

    def check_outside(self) -> None:
        """Raise UsageError if called in the event loop's own thread.  Waiting in this thread would block for ever."""
        if threading.current_thread() is self._thread:
            raise UsageError("cannot advance virtual time in a callback: advance the time outside callbacks")

    def do(self, action: Callable[[], T]) -> T:
        if threading.current_thread() is self._thread:
            return action()

        async def act() -> T:
            return action()

        return self.run(act())

    def stop(self) -> None:
        self.do(lambda: None)  # Execute pending callbacks of asyncio, e.g. those that close network connections.
        self.run(self._loop.shutdown_default_executor())  # End the threads that resolve network addresses.
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()
