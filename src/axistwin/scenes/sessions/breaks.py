"""Breakpoints, which stop the bench when an event happens.  A sentence describes the event, as for the triggers of
faults.
"""

from collections.abc import Callable
from logging import getLogger

from axistwin.bench import Bench
from axistwin.core.errors import UsageError

log = getLogger("axistwin")


class Break:
    """A breakpoint that can be switched on and off.  `once`: True if the breakpoint stops the bench only once."""

    def __init__(self, sentence: str, bench: Bench, on_hit: Callable[["Break"], None], *, once: bool = False) -> None:
        self.sentence, self.once = sentence, once
        self.hits = 0  # Number of times that this breakpoint has stopped the bench.
        self._bench, self._on_hit = bench, on_hit
        self._unsubscribe: Callable[[], object] | None = None
        self._on, self.on = False, True

    def __repr__(self) -> str:
        return f"<Break {self.sentence}: {'on' if self.on else 'off'}, {self.hits} hits>"

    @property
    def on(self) -> bool:
        """True if the breakpoint is on.  True raises UsageError for a sentence that does not fit the bench."""
        return self._on

    @on.setter
    def on(self, on: bool) -> None:
        self.suspend()
        if on:
            self._unsubscribe = self._bench.when(self.sentence, self._on_true)
        self._on = bool(on)

    def suspend(self) -> None:
        unsubscribe, self._unsubscribe = self._unsubscribe, None
        if unsubscribe is not None:
            unsubscribe()

    def resume(self, bench: Bench) -> None:
        """Resume the breakpoint on this bench; switch it off if its sentence does not fit the bench."""
        self._bench = bench
        try:
            self.on = self._on
        except UsageError as error:
            log.warning("%s", error)
            self._on = False

    def _on_true(self) -> None:
        if self._unsubscribe is not None:
            self.hits += 1
            self._on_hit(self)
