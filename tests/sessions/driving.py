"""Sessions in tests: an event loop with a fake clock, and random sessions."""

import asyncio
import selectors
from collections.abc import Awaitable, Callable, Coroutine
from pathlib import Path
from typing import Any

from click.testing import CliRunner

from axistwin import Bench, Session, tracing
from axistwin.cli.program import axistwin

TURN_S = 1e-6
"""Shortest duration of a turn of the loop, in seconds."""


class _Selector(selectors.DefaultSelector):
    """A selector that advances the fake clock instead of waiting."""

    now_s = 0.0

    def select(self, timeout: float | None = None) -> list[Any]:
        found = super().select(0)
        self.now_s += TURN_S if found else max(timeout or 0.0, TURN_S)
        return found


class Loop(asyncio.SelectorEventLoop):
    """An event loop with a fake clock: its timers expire at once, in order."""

    def __init__(self) -> None:
        self._hurried = _Selector()
        super().__init__(self._hurried)

    def time(self) -> float:
        return self._hurried.now_s


def drive(doing: Coroutine[Any, Any, Any]) -> Any:
    with asyncio.Runner(loop_factory=Loop) as runner:
        return runner.run(doing)


async def until(condition: Callable[[], object]) -> None:
    """Wait until a condition is true, for a minute of the fake clock at most."""
    for _ in range(6000):
        if condition():
            return
        await asyncio.sleep(0.01)
    raise AssertionError("the condition is not true within a minute")


class Traced:
    """Write a separate trace file for each bench of a session."""

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
        assert self._tracing is not None
        self._tracing.__exit__(None, None, None)
        return rows(self._path)


def rows(path: Path) -> list[str]:
    return [line for line in path.read_text().splitlines() if not line.startswith("#")]


def run_saved(files: dict[str, str], directory: Path, seconds: float) -> list[str]:
    """Write the files of a saved session, run its scene, and return the rows of the trace."""
    for name, text in files.items():
        (directory / name).parent.mkdir(parents=True, exist_ok=True)
        (directory / name).write_text(text)
    scene, trace = str(directory / "scene.toml"), directory / "again.csv"
    arguments = ["run", scene, "--for", repr(seconds), "--signals", "*", "--trace", str(trace)]
    outcome = CliRunner().invoke(axistwin, arguments, catch_exceptions=False)
    assert outcome.exit_code == 0, outcome.output
    return rows(trace)


def upto(found: list[str], time_ns: int) -> list[str]:
    """Return the header and the rows up to this time."""
    return [found[0], *(row for row in found[1:] if int(row.partition(",")[0]) <= time_ns)]


Step = Callable[[Session], Awaitable[None]]


async def do_all(session: Session, steps: list[Step]) -> None:
    for step in steps:
        await step(session)
    session.pause()
