"""Show on a terminal that a command is working, and how far it is."""

import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from time import monotonic

from axistwin.bench import Bench


class RunProgress:
    """The state of a run in one line: virtual time, per cent, times real time, size of the traces."""

    def __init__(self, what: str, bench: Bench, seconds: float | None = None, traces: Sequence[Path] = ()) -> None:
        self._what, self._bench, self._seconds, self._traces = what, bench, seconds, traces
        self._began_s = monotonic()

    def __rich__(self) -> str:
        """Return the line for the present virtual time."""
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
    """Show what the command does, within this context and only on a terminal."""
    if not sys.stderr.isatty():
        yield
        return
    from rich.console import Console

    with Console(stderr=True).status(what):
        yield
