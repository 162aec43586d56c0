"""Execute a long computation in pieces, so that the event loop can run the bench between two pieces.

The computation runs in a separate thread, and calls `breathe` wherever a piece may end.  The event loop waits while a
piece is executed, so the computation needs no locks.
"""

import asyncio
import threading
from collections.abc import Callable
from contextvars import copy_context
from time import perf_counter
from typing import Generic, TypeVar

T = TypeVar("T")
TURN_S = 0.0015  # Smallest duration of a piece in seconds; the piece ends at the next call of `breathe`.
_here = threading.local()


class _Abandoned(BaseException):
    pass


async def in_turns(compute: Callable[[], T]) -> T:
    """Return the result of `compute()`, executed in pieces, or raise its exception."""
    work = _Work(compute)
    try:
        while not work.go_on():
            await asyncio.sleep(0)
    except asyncio.CancelledError:
        work.abandon()
        raise
    return work.result()


def breathe() -> None:
    """Let other tasks run if the present piece of a computation has lasted for `TURN_S` seconds."""
    work: _Work[object] | None = getattr(_here, "work", None)
    if work is not None:
        work.breathe()


class _Work(Generic[T]):
    def __init__(self, compute: Callable[[], T]) -> None:
        self._compute, self._context, self._loop = compute, copy_context(), asyncio.get_running_loop()
        self._go, self._stop = threading.Semaphore(0), threading.Semaphore(0)
        self._over = self._abandoned = False
        self._began_s = 0.0
        self._found: list[T] = []
        self._error: BaseException | None = None
        threading.Thread(target=self._run, name="panel", daemon=True).start()

    def go_on(self) -> bool:
        """Execute one piece of the computation; return True after the last piece."""
        self._go.release()
        self._stop.acquire()
        return self._over

    def abandon(self) -> None:
        """Cancel the computation; its `finally` clauses are executed."""
        self._abandoned = True
        while not self._over:
            self.go_on()

    def result(self) -> T:
        if self._error is not None:
            raise self._error
        return self._found[0]

    def breathe(self) -> None:
        """End the present piece if it has lasted for `TURN_S` seconds; called in the thread of the computation."""
        if perf_counter() - self._began_s < TURN_S or self._over:
            return
        self._stop.release()
        self._go.acquire()
        if self._abandoned:
            raise _Abandoned
        self._began_s = perf_counter()

    def _run(self) -> None:
        self._go.acquire()
        # Permit calls of asyncio functions in this thread, e.g. `asyncio.create_task`.
        asyncio._set_running_loop(self._loop)
        _here.work = self
        self._began_s = perf_counter()
        try:
            self._found.append(self._context.run(self._compute))
        except BaseException as error:  # noqa: BLE001  # raised by `result`
            self._error = error
        self._over = True
        self._stop.release()
