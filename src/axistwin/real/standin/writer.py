"""Write lines in a thread of its own, so that a full disk or a paused terminal delays no stop and no pulse."""

from collections.abc import Callable
from queue import SimpleQueue
from threading import Thread

MOST_WAITING = 100_000  # Number of lines that can wait; further lines are lost.
END_S = 5.0  # Longest time in seconds to wait for the last lines.


class Writer(Thread):
    """A thread that passes lines to `write`, which may block; lines that wait are joined."""

    def __init__(self, name: str, write: Callable[[str], None]) -> None:
        super().__init__(name=name, daemon=True)
        self._write = write
        self._lines: SimpleQueue[str | None] = SimpleQueue()
        self.start()

    def put(self, line: str) -> bool:
        """Pass on a line and return at once; False: the line is lost, because too many wait."""
        found = self._lines.qsize() < MOST_WAITING
        if found:
            self._lines.put(line)
        return found

    def run(self) -> None:
        """Write lines until `close` is called."""
        lines: list[str | None] = []
        while None not in lines:
            lines = [self._lines.get()]
            while not self._lines.empty():
                lines.append(self._lines.get())
            self._write("".join(f"{line}\n" for line in lines if line is not None))

    def close(self, longest_s: float = END_S) -> None:
        """End the thread after the last line, or leave it behind if that takes longer than `longest_s` seconds."""
        self._lines.put(None)
        self.join(longest_s)
