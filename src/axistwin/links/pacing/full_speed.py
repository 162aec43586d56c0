"""Virtual time as fast as possible.  The bench runs in slices of real time; between them, sockets are served."""

import asyncio

from axistwin.links.pacing.advancing import Advancer
from axistwin.links.pacing.slices import Slice


class FullSpeed:
    """Advances a bench while events are due, in slices.  After `cancel` the object cannot be used again."""

    behind_s = 0.0
    """Delay against the wall clock in seconds, which is 0 at full speed."""

    def __init__(self, bench: Advancer, loop: asyncio.AbstractEventLoop) -> None:
        self._bench, self._clock, self._loop = bench, bench.clock, loop
        self._next: asyncio.Handle | None = None
        self._ended = False

    def sync(self) -> None:
        """This function does nothing: at full speed, virtual time does not follow the wall clock."""

    def work(self) -> None:
        """Run a slice, unless the next slice is already planned."""
        if self._next is None:
            self._slice()

    def resume(self) -> None:
        """Request an advance of virtual time in the next pass of the event loop."""
        self._next = self._next or self._loop.call_soon(self._slice)

    def cancel(self) -> None:
        """Stop advancing virtual time."""
        self._ended = True
        if self._next is not None:
            self._next.cancel()

    @property
    def _idle(self) -> bool:
        """True if no event is planned, except background events that repeat for ever."""
        clock = self._clock
        if clock.quiet and clock.now >= self._bench.agenda_ns:
            return True
        return clock.next_event_ns() is None

    def _slice(self) -> None:
        self._next = None
        if not self._idle:
            self._bench.run(self._advance)
        self._bench.flush()
        if not self._ended and not self._idle:
            self.resume()

    def _advance(self) -> None:
        limit, step = Slice(), self._clock.step
        step()
        while not self._idle and not self._ended and not limit.over():
            step()
