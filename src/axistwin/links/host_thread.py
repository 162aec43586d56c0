"""A host program in a thread.  Virtual time may pass only while the thread is blocked.

The operating system reports a thread that waits for characters, a lock or a timer as sleeping.  The state is polled
several times, because a thread that waits for Python's interpreter lock also sleeps for a moment.
"""

import threading
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

POLLS, POLL_S = 3, 0.0003
"""Number of polls in which a blocked thread must be sleeping, and seconds between two polls."""
REACTION_S = 0.02
"""Seconds without activity after which a host counts as blocked, on systems that do not report thread states."""


class HostThread:
    """Calls a host's function in a separate thread."""

    def __init__(self, function: Callable[..., Any], arguments: tuple[Any, ...], keywords: dict[str, Any]) -> None:
        self._call = partial(function, *arguments, **keywords)
        self._outcome: Any = None
        self._error: BaseException | None = None
        self._thread = threading.Thread(target=self._run, name="host", daemon=True)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    @property
    def done(self) -> bool:
        """True if the host's function has returned or raised an exception."""
        return self._thread.ident is not None and not self._thread.is_alive()

    @property
    def current(self) -> bool:
        """True when called from the host's own thread."""
        return threading.current_thread() is self._thread

    def outcome(self) -> Any:
        """Wait until the function has finished.  Return its result, or raise its exception."""
        self._thread.join()
        if self._error is not None:
            raise self._error
        return self._outcome

    def join(self, seconds: float) -> None:
        """Wait until the function has returned, `seconds` at most."""
        self._thread.join(seconds)

    def blocked(self) -> bool:
        """True if the thread is blocked at this moment, or has ended."""
        if self.done:
            return True
        if self._thread.native_id is None:  # the thread has not started completely
            return False
        try:
            stat = Path(f"/proc/self/task/{self._thread.native_id}/stat").read_text(encoding="ascii", errors="replace")
        except FileNotFoundError:  # the thread has ended, or the system is not Linux
            self.join(REACTION_S)
            return True
        return stat.rpartition(")")[2].split()[0] == "S"

    def _run(self) -> None:
        try:
            self._outcome = self._call()
        except BaseException as error:  # noqa: BLE001  # `outcome` raises the error again
            self._error = error


def pause() -> None:
    """Sleep between two polls."""
    time.sleep(POLL_S)
