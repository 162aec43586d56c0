"""A long computation in pieces.  Between two pieces the event loop runs the bench and serves hosts.

The computation runs in a separate thread, but never at the same time as the loop: the loop waits for the end of each
piece.  The computation needs no locks; it calls `breathe` at any places.
"""

import asyncio
import threading
from collections.abc import Callable
from contextvars import copy_context
from time import perf_counter
from typing import Generic, TypeVar

T = TypeVar("T")
TURN_S = 0.0015
"""Duration after which a piece ends, at the next `breathe`."""
_here = threading.local()


class _Abandoned(BaseException):
    """Raised in a computation that has been cancelled."""


async def in_turns(compute: Callable[[], T]) -> T:
    """Return the result of `compute()`, or raise its error.  The loop runs between two pieces."""
    work = _Work(compute)
    try:
        while not work.go_on():
            await asyncio.sleep(0)
    except asyncio.CancelledError:
        work.abandon()
        raise
    return work.result()


def breathe() -> None:
    """End a piece here if the piece has lasted long enough; no effect outside `in_turns`."""
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
        """Compute one piece.  Returns True after the last."""
        self._go.release()
        self._stop.acquire()
        return self._over

    def abandon(self) -> None:
        """Cancel the computation; its `finally` clauses are executed."""
        self._abandoned = True
        while not self._over:
            self.go_on()

    def result(self) -> T:
        """Return the result, or raise the error."""
        if self._error is not None:
            raise self._error
        return self._found[0]

    def breathe(self) -> None:
        """End a piece if the piece has lasted long enough; called in the computation's thread."""
        if perf_counter() - self._began_s < TURN_S or self._over:
            return
        self._stop.release()
        self._go.acquire()
        if self._abandoned:
            raise _Abandoned
        self._began_s = perf_counter()

    def _run(self) -> None:
        self._go.acquire()
        asyncio._set_running_loop(self._loop)  # blocked meanwhile
        _here.work = self
        self._began_s = perf_counter()
        try:
            self._found.append(self._context.run(self._compute))
        except BaseException as error:  # noqa: BLE001  # raised by `result`
            self._error = error
        self._over = True
        self._stop.release()
