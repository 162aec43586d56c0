"""Sessions in tests: an event loop whose clock passes only when nobody has anything to do, and random sessions."""

import asyncio
import selectors
from collections.abc import Awaitable, Callable, Coroutine
from pathlib import Path
from typing import Any

from axistwin import Bench, Session, tracing

TURN_S = 1e-6
"""What a turn of the loop takes at least."""


class _Selector(selectors.DefaultSelector):
    """Whoever waits finds that it is that much later."""

    now_s = 0.0

    def select(self, timeout: float | None = None) -> list[Any]:
        found = super().select(0)
        self.now_s += TURN_S if found else max(timeout or 0.0, TURN_S)
        return found


class Loop(asyncio.SelectorEventLoop):
    """An event loop in which time is what its timers say."""

    def __init__(self) -> None:
        self._hurried = _Selector()
        super().__init__(self._hurried)

    def time(self) -> float:
        return self._hurried.now_s


def drive(doing: Coroutine[Any, Any, Any]) -> Any:
    """Run this in such a loop."""
    with asyncio.Runner(loop_factory=Loop) as runner:
        return runner.run(doing)


async def until(condition: Callable[[], object]) -> None:
    """Let time pass, a minute at most, until something is so."""
    for _ in range(6000):
        if condition():
            return
        await asyncio.sleep(0.01)
    raise AssertionError("it never is")


class Traced:
    """Traces every bench of a session, each into a file of its own."""

    def __init__(self, session: Session, directory: Path) -> None:
        self.directory = directory
        self._tracing: tracing | None = None
        self._count = 0
        session.each_bench(self._attach)

    def _attach(self, bench: Bench) -> None:
        self._count += 1
        self._tracing = tracing(bench, self._path, ("*",))
        self._tracing.__enter__()

    @property
    def _path(self) -> Path:
        return self.directory / f"{self._count}.csv"

    def rows(self) -> list[str]:
        """Of the present bench, up to now; it is not traced any more."""
        assert self._tracing is not None
        self._tracing.__exit__(None, None, None)
        return rows(self._path)


def rows(path: Path) -> list[str]:
    """Of a trace, without its comments."""
    return [line for line in path.read_text().splitlines() if not line.startswith("#")]


def upto(found: list[str], time_ns: int) -> list[str]:
    """Those that were written by this time."""
    return [found[0], *(row for row in found[1:] if int(row.partition(",")[0]) <= time_ns)]


Step = Callable[[Session], Awaitable[None]]


async def do_all(session: Session, steps: list[Step]) -> None:
    """One after the other; then it stands."""
    for step in steps:
        await step(session)
    session.pause()
