"""Pins and the wires between them.

A pin has one level at a time.  What is connected to it (a controller's output stage, a switch, a wire) sets its
`source`; a person with a test lead may `drive` it to another level until they `release` it.
"""

from collections.abc import Callable

from axistwin.sim.clock import Clock, Event, Procedure


class Pin:
    """A digital terminal of a device.  `level` is the electrical level there, as the family defines it."""

    def __init__(self, clock: Clock, name: str, level: bool = False) -> None:
        self.clock, self.name = clock, name
        self._source = level
        self._driven: bool | None = None
        self._watchers: list[Callable[[Pin], None]] = []
        self._changed: Event | None = None
        self._flash_ns = 0
        self._flash_from = 0

    def __repr__(self) -> str:
        return f"<Pin {self.name} {'high' if self.level else 'low'}>"

    @property
    def level(self) -> bool:
        """True: high.  For the opto-isolated inputs of the IF1/IF2: current flows."""
        if self._driven is not None:
            return self._driven
        if self._flash_ns:
            return (self.clock.now - self._flash_from) // self._flash_ns % 2 == 0
        return self._source

    @property
    def driven(self) -> bool:
        """Whether it is forced from outside."""
        return self._driven is not None

    @property
    def flashing(self) -> bool:
        """Whether its output stage flashes."""
        return self._flash_ns != 0

    def drive(self, level: bool) -> None:
        """Force the terminal from outside, whatever is connected to it."""
        before, self._driven = self.level, bool(level)
        self._settle(before)

    def release(self) -> None:
        """Take the test lead away: the terminal goes back to what is connected to it."""
        before, self._driven = self.level, None
        self._settle(before)

    def set(self, level: bool) -> None:
        """What is connected to the terminal (an output stage, a switch, a wire) takes this level."""
        before, self._source, self._flash_ns = self.level, level, 0
        self._settle(before)

    def flash(self, half_period_ns: int) -> None:
        """The output stage flashes, high first.  It costs no events while nobody watches."""
        before, self._flash_ns, self._flash_from = self.level, half_period_ns, self.clock.now
        self._settle(before)
        if self._watchers:
            self.clock.process(self._flashing())

    def watch(self, watcher: Callable[["Pin"], None]) -> Callable[[], None]:
        """Call `watcher(pin)` at every change of level.  Returns what ends the watching."""
        self._watchers.append(watcher)
        if self._flash_ns and len(self._watchers) == 1:
            self.clock.process(self._flashing())
        return lambda: self._watchers.remove(watcher)

    def changed(self) -> Event:
        """An event that happens at the next change of level."""
        if self._changed is None:
            self._changed = self.clock.event()
        return self._changed

    def _settle(self, before: bool) -> None:
        if self.level is not before:
            self._announce()

    def _announce(self) -> None:
        if self._changed is not None:
            event, self._changed = self._changed, None
            event.succeed()
        for watcher in tuple(self._watchers):
            watcher(self)

    def _flashing(self) -> Procedure:
        began, half_ns = self._flash_from, self._flash_ns
        while self._watchers and self._flash_ns and self._flash_from == began:
            self.clock.background += 1
            yield self.clock.timeout(half_ns - (self.clock.now - began) % half_ns)
            self.clock.background -= 1
            if self._flash_ns and self._flash_from == began and self._driven is None:
                self._announce()


def connect(source: Pin, target: Pin, *, invert: bool = False, delay_ns: int = 0) -> None:
    """Wire `source` to `target`: the target follows the source's level, inverted and later if so wished."""

    def follow(pin: Pin) -> None:
        level = pin.level is not invert
        if delay_ns:
            pin.clock.call_later(delay_ns, lambda: target.set(level))
        else:
            target.set(level)

    source.watch(follow)
    follow(source)
