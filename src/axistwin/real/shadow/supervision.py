"""Starts the twin's process, and starts it again if it fails or hangs, while the relay goes on."""

import json
import subprocess
import sys
import time
from collections.abc import Callable
from typing import Any

from axistwin.real.shadow.feed import Feed, What

STUCK_S = 30.0  # Time after which a twin that reads nothing is ended.
PAUSE_S = 5.0  # Shortest time between two starts.
END_S = 30.0  # Longest time for the summary at the end.


class Supervisor:
    """Owns the twin's process, which executes `module`.  `warn` receives one line each time that it has failed."""

    def __init__(
        self, settings: dict[str, Any], warn: Callable[[str], object], module: str = "axistwin.real.shadow.process"
    ) -> None:
        self._ahead_ns = time.time_ns() - time.monotonic_ns()
        self._settings = {**settings, "ahead_ns": self._ahead_ns}
        self._warn, self._module = warn, module
        self._differed = False
        self.anew: Callable[[], object] = lambda: None  # Called when the twin knows nothing of the machine any more.
        self._start()

    def _start(self) -> None:
        command = [sys.executable, "-m", self._module]
        # In a session of its own: Ctrl-C ends the relay, and then the twin, by the end of its input.
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, start_new_session=True)
        assert self._process.stdin is not None
        # The settings go through the pipe, as the token of a panel is nobody else's business.
        settings = json.dumps(self._settings).encode() + b"\n"
        self._feed, self._started_s = Feed(self._process.stdin, self._ahead_ns, settings), time.monotonic()

    @property
    def pid(self) -> int:
        return self._process.pid

    def add(self, what: What, data: bytes = b"") -> None:
        if self._feed.add(what, data) or what is What.BACK:
            self.anew()

    def passed(self, by_host: bool, data: bytes) -> None:
        """Add what the host, or the machine, has sent."""
        self.add(What.HOST if by_host else What.MACHINE, data)

    def say(self, words: str) -> None:
        """Print a line beside the findings; where only JSON is wanted, as a message."""
        print(words, file=sys.stderr if self._settings["json"] else sys.stdout, flush=True)

    def check(self) -> None:
        """Start the process again if it has ended or hangs; to be called now and then."""
        code = self._process.poll()
        hangs = self._feed.stuck_s > STUCK_S
        if (code is None and not hangs) or time.monotonic() - self._started_s < PAUSE_S:
            return
        self._warn(
            "the twin hangs: it is started again" if hangs else f"the twin has failed ({code}): it is started again"
        )
        self._differed |= code == 1
        self.kill()
        self._start()
        self.anew()

    def kill(self) -> None:
        """End the process without a summary."""
        self._process.kill()
        self._process.wait()
        self._feed.abandon()

    def end(self) -> int:
        """Let the twin print its summary; return 1 if anything differed."""
        self._feed.close()
        try:
            code = self._process.wait(END_S)
        except subprocess.TimeoutExpired:
            self._warn("the twin hangs: there is no summary")
            self._process.kill()
            code = self._process.wait()
        return int(self._differed or code == 1)
