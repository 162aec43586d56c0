"""A host program in a thread, and whether it waits: then virtual time may pass, and not before.

A thread that waits (for characters, for a lock, for time to pass) is asleep, and the system says so.  It is looked at
several times, as one that only waits for its turn to run Python is asleep for a moment, too.
"""

import threading
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

LOOKS, LOOK_S = 3, 0.0003
"""So often, at such intervals, it must be found asleep."""
REACTION_S = 0.02
"""Where the system does not tell, a host that has done nothing for so long waits."""


class HostThread:
    """Calls a function of a host in a thread of its own, from `start` on."""

    def __init__(self, function: Callable[..., Any], arguments: tuple[Any, ...], keywords: dict[str, Any]) -> None:
        self._call = partial(function, *arguments, **keywords)
        self._outcome: Any = None
        self._error: BaseException | None = None
        self._thread = threading.Thread(target=self._run, name="host", daemon=True)

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    @property
    def done(self) -> bool:
        """Whether it has come to its end."""
        return self._thread.ident is not None and not self._thread.is_alive()

    @property
    def current(self) -> bool:
        """True within the host's function."""
        return threading.current_thread() is self._thread

    def outcome(self) -> Any:
        """What it has returned; what it has raised is raised."""
        self._thread.join()
        if self._error is not None:
            raise self._error
        return self._outcome

    def join(self, seconds: float) -> None:
        """Wait until it is done, but not longer."""
        self._thread.join(seconds)

    def asleep(self) -> bool:
        """Whether it waits for something at this moment, or has come to its end."""
        if self.done:
            return True
        if self._thread.native_id is None:  # it is just beginning
            return False
        try:
            stat = Path(f"/proc/self/task/{self._thread.native_id}/stat").read_text(encoding="ascii", errors="replace")
        except FileNotFoundError:  # it has just ended, or this is not Linux
            self.join(REACTION_S)
            return True
        return stat.rpartition(")")[2].split()[0] == "S"

    def _run(self) -> None:
        try:
            self._outcome = self._call()
        except BaseException as error:  # noqa: BLE001  # it is raised where the outcome is asked for
            self._error = error


def pause() -> None:
    """Between two looks."""
    time.sleep(LOOK_S)
