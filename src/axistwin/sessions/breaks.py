"""Breaks: sentences of `fault_injection/triggers.py` that stop the bench when they come true."""

from collections.abc import Callable
from logging import getLogger

from axistwin.bench import Bench
from axistwin.errors import UsageError

log = getLogger("axistwin")


class Break:
    """One of them; it is off and on as one likes.  `once`: the first time is the last."""

    def __init__(self, sentence: str, bench: Bench, hit: Callable[["Break"], None], *, once: bool = False) -> None:
        self.sentence, self.once = sentence, once
        self.hits = 0
        """How often it has stopped the bench."""
        self._bench, self._hit = bench, hit
        self._unwatch: Callable[[], object] | None = None
        self._on = False
        self.on = True

    def __repr__(self) -> str:
        return f"<Break {self.sentence}: {'on' if self.on else 'off'}, {self.hits} hits>"

    @property
    def on(self) -> bool:
        """Whether it stops the bench.  Switched on it raises UsageError if there is no such thing there."""
        return self._on

    @on.setter
    def on(self, on: bool) -> None:
        self.rest()
        if on:
            self._unwatch = self._bench.when(self.sentence, self._happens)
        self._on = bool(on)

    def rest(self) -> None:
        """Stop nothing for the moment."""
        unwatch, self._unwatch = self._unwatch, None
        if unwatch is not None:
            unwatch()

    def go_on(self, bench: Bench) -> None:
        """After a rest, on this bench, which may be another.  Off if what it waits for is not there now."""
        self._bench = bench
        try:
            self.on = self._on
        except UsageError as error:
            log.warning("%s", error)
            self._on = False

    def _happens(self) -> None:
        if self._unwatch is not None:
            self.hits += 1
            self._hit(self)
