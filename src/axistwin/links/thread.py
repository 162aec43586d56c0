"""An event loop in a thread of its own, so that a program that knows no asyncio can have ports."""

import asyncio
import threading
from collections.abc import Callable, Coroutine
from typing import Any, TypeVar

from axistwin.errors import UsageError

T = TypeVar("T")
INSIDE = "time cannot be told to pass from within the bench: not in `do`, a condition or a watcher"
OVER = "this twin is served no more: its `with` block has been left"


class LoopThread:
    """Runs coroutines and calls for others.  What goes wrong in its callbacks is in `problems`."""

    def __init__(self) -> None:
        self.problems: list[dict[str, Any]] = []
        self._loop = asyncio.new_event_loop()
        self._loop.set_exception_handler(lambda _, context: self.problems.append(context))
        self._thread = threading.Thread(target=self._loop.run_forever, name="axistwin", daemon=True)
        self._thread.start()

    def run(self, coroutine: Coroutine[Any, Any, T]) -> T:
        """Run it there, and return its result or raise its error.

        Raises UsageError within itself, or when it is over.
        """
        inside = threading.current_thread() is self._thread
        if inside or self._loop.is_closed():
            coroutine.close()  # it would wait for itself, or for nobody
            raise UsageError(INSIDE if inside else OVER)
        return asyncio.run_coroutine_threadsafe(coroutine, self._loop).result()

    def check_outside(self) -> None:
        """Raises UsageError within itself, where nobody can wait for it."""
        if threading.current_thread() is self._thread:
            raise UsageError(INSIDE)

    def do(self, action: Callable[[], T]) -> T:
        """Call it there."""
        if threading.current_thread() is self._thread:
            return action()

        async def act() -> T:
            return action()

        return self.run(act())

    def stop(self) -> None:
        """End the thread, when what is going on at the moment is over."""
        self.do(lambda: None)  # connections that have been closed end in the loop's next turn
        self.run(self._loop.shutdown_default_executor())  # which has looked up addresses
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()
