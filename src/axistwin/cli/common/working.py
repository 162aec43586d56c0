"""Show the progress of a command on a terminal."""

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from time import monotonic

from axistwin.bench import Bench


class RunProgress:
    """One line of text with the progress of a run, e.g. its virtual time and its speed."""

    def __init__(self, what: str, bench: Bench, seconds: float | None = None, traces: Sequence[Path] = ()) -> None:
        self._what, self._bench, self._seconds, self._traces = what, bench, seconds, traces
        self._began_s = monotonic()

    def __rich__(self) -> str:
        now_s = self._bench.seconds
        parts = [f"running {self._what}: {now_s:.1f} s"]
        if self._seconds:
            parts.append(f"{min(100.0, 100 * now_s / self._seconds):.0f} %")
        parts.append(f"{now_s / max(monotonic() - self._began_s, 1e-3):.0f} times real time")
        if size := sum(path.stat().st_size for path in self._traces if path.exists()):
            parts.append(f"trace {size / 1e6:.1f} MB")
        return ", ".join(parts)


@contextmanager
def working(what: str | RunProgress) -> Iterator[None]:
    """Show a text with a spinner on the terminal while a `with` block is executed."""
    if not sys.stderr.isatty():
        yield
        return
    from rich.console import Console

    with Console(stderr=True).status(what):
        yield


@contextmanager
def counting(what: str, told: str) -> Iterator[Callable[[int, int, str], object] | None]:
    """Show a progress bar on the terminal: yield a function of the number done, of all, and a text; None elsewhere."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn(what), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, TextColumn("{task.fields[told]}"), console=Console(stderr=True)) as bar:
        task = bar.add_task(what, total=None, told=told)
        yield lambda done, every, told: bar.update(task, completed=done, total=every, told=told)
