"""Work in the background: long checks in a process of their own, so that the server answers other requests meanwhile.

A thread is not enough: one thread of Python runs at a time, and a check would delay every answer.
"""

import asyncio
import pickle
import traceback
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from threading import Thread
from typing import Any, ParamSpec, TypeVar

from axistwin.controllers.registry import FILES
from axistwin.core.child import Child, pipes

Given = ParamSpec("Given")
Result = TypeVar("Result")


class Background:
    """Executes functions in a separate background process, one at a time."""

    def __init__(self) -> None:
        self._one = asyncio.Lock()
        self._process: Child | None = None
        self._closed = False

    async def run(self, function: Callable[Given, Result], *given: Given.args, **named: Given.kwargs) -> Result:
        """Return the result of a function in the background process.

        A cancelled caller gets no result, but the function still ends before the next one.  Raises RuntimeError with
        the traceback if it raises an exception, or ends the process twice.
        """
        task = pickle.dumps((function, given, named))
        await self._one.acquire()
        loop = asyncio.get_running_loop()
        done: Future[Result] = Future()
        done.set_running_or_notify_cancel()
        done.add_done_callback(lambda _: loop.call_soon_threadsafe(self._one.release))
        Thread(target=self._settle, args=(task, done), daemon=True).start()
        return await asyncio.wrap_future(done)

    def close(self) -> None:
        """End the background process; a function that it is still executing returns no result."""
        self._closed = True
        self._end()

    def _settle(self, task: bytes, done: "Future[Any]") -> None:
        """Execute a task in the background process, and settle `done`; runs in a thread."""
        answer = self._execute(task) or self._execute(task) or (False, "the process of the checks has ended")
        if self._closed:
            return  # The result of a task is discarded if the language server is ending.
        succeeded, result = answer
        if succeeded:
            done.set_result(result)
        else:
            done.set_exception(RuntimeError(result))

    def _execute(self, task: bytes) -> tuple[bool, Any] | None:
        if self._closed:
            return None
        first = self._process is None
        process = self._process = self._process or Child(__name__, "work")
        try:
            if first and FILES:  # The devices of others that this process has loaded.
                from axistwin.devices.loading import load_texts

                process.send(pickle.dumps((load_texts, (dict(FILES.values()),), {})))
                process.receive()
            process.send(task)
            answer: tuple[bool, Any] = process.receive()
        except (OSError, ValueError, EOFError, pickle.UnpicklingError):
            self._end()
            return None
        return answer

    def _end(self) -> None:
        process, self._process = self._process, None
        if process is not None:
            process.end()


def work() -> None:
    """Execute tasks from standard input until it is closed: the main function of the process."""
    tasks, answers = pipes()
    with suppress(EOFError, BrokenPipeError):
        while True:
            function, given, named = pickle.load(tasks)  # noqa: S301  # from our own parent process
            pickle.dump(_answer(function, given, named), answers)
            answers.flush()


def _answer(function: Callable[..., Any], given: tuple[Any, ...], named: dict[str, Any]) -> tuple[bool, Any]:
    try:
        return True, function(*given, **named)
    except Exception:  # noqa: BLE001  # raised again by `run`
        return False, traceback.format_exc()
