"""Work in the background: long checks in a thread, so that the server answers other requests meanwhile."""

import asyncio
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager, suppress
from functools import partial
from threading import Thread
from typing import TypeVar

SWITCH_S = 0.001
"""Time in seconds after which Python gives other threads their turn."""
Result = TypeVar("Result")

TURN_S = 0.1
"""The same while the server answers a request."""


@contextmanager
def undisturbed() -> Iterator[None]:
    """Let the threads in the background wait within this context."""
    before_s = sys.getswitchinterval()
    sys.setswitchinterval(TURN_S)
    try:
        yield
    finally:
        sys.setswitchinterval(before_s)


class Background:
    """Executes one function at a time, in a thread that does not delay the end of the process."""

    def __init__(self) -> None:
        self._one = asyncio.Lock()

    async def run(self, function: Callable[[], Result]) -> Result:
        """Return the result of a function that is executed in a thread, after the functions before it.

        A cancelled caller gets no result, but the function is executed to its end before the next one.
        """
        await self._one.acquire()
        loop = asyncio.get_running_loop()
        done: Future[Result] = Future()
        done.set_running_or_notify_cancel()
        done.add_done_callback(lambda _: loop.call_soon_threadsafe(self._one.release))
        Thread(target=_work, args=(function, done), daemon=True).start()
        return await asyncio.wrap_future(done)


def _work(function: Callable[[], Result], done: "Future[Result]") -> None:
    before_s = sys.getswitchinterval()
    sys.setswitchinterval(SWITCH_S)
    try:
        result = function()
    except Exception as error:  # noqa: BLE001  # raised again by `run`
        _settle(partial(done.set_exception, error))
    else:
        _settle(partial(done.set_result, result))
    finally:
        sys.setswitchinterval(before_s)


def _settle(settle: Callable[[], None]) -> None:
    with suppress(RuntimeError):  # the event loop has ended meanwhile
        settle()
