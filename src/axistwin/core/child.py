"""A Python process of our own for tasks: pickled objects in by its standard input, out by its standard output."""

import os
import pickle
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any, BinaryIO

FOLDER = str(Path(__file__).resolve().parents[2])


class Child:
    """A process that runs the function `function` of a module, with `arguments` in its `sys.argv`."""

    def __init__(self, module: str, function: str, *arguments: str) -> None:
        path = os.pathsep.join(dict.fromkeys((FOLDER, *(part or os.getcwd() for part in sys.path))))
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-c", f"from {module} import {function}; {function}()", *arguments],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, env={**os.environ, "PYTHONPATH": path},
            start_new_session=True,  # Ctrl-C must interrupt only the parent process.
            creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
        )  # fmt: skip
        assert self._process.stdin is not None and self._process.stdout is not None, "the process has pipes"
        self._tasks, self._answers = self._process.stdin, self._process.stdout
        self.pid = self._process.pid

    def send(self, pickled: bytes) -> None:
        """Send a pickled object to the process.  Raises OSError if the process has ended."""
        self._tasks.write(pickled)
        self._tasks.flush()

    def receive(self) -> Any:
        """Wait for an object of the process.  Raises OSError, EOFError or UnpicklingError if the process ends."""
        return pickle.load(self._answers)  # noqa: S301  # our own process

    def interrupt(self) -> None:
        """Kill the process.  A thread that waits in `receive` then gets an EOFError."""
        self._process.kill()

    def end(self) -> None:
        """Kill the process, and close its pipes.  No other thread may use the pipes at the same time."""
        self._process.kill()
        self._process.wait()
        for pipe in (self._tasks, self._answers):
            with suppress(OSError):
                pipe.close()


def pipes() -> tuple[BinaryIO, BinaryIO]:
    """Return the pipes of a child process, to be called in it: the first has the tasks, the second takes the answers.

    Printed text then goes to standard error, and Ctrl-C is ignored, because the parent ends the process.
    """
    with suppress(ValueError):
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    return sys.stdin.buffer, answers
