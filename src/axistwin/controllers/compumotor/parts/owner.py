"""Chapter Command attributes, SINGULAR: a command that takes time, of which each owner performs one at a time.

The two owners are the host and the sequence.  What ends a SINGULAR command of the sequence (79h, 7Ah) does not affect
the host's; 73h ends both.
"""

from collections.abc import Callable

from simpy import Interrupt

from axistwin.sim.clock import Clock, Procedure, Process, interrupt, kill


class Owner:
    """The host, or the sequence, with its SINGULAR command."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self.singular: Process | None = None

    @property
    def busy(self) -> bool:
        """True while a SINGULAR command is in progress."""
        return self.singular is not None

    def begin(self, procedure: Procedure, ended: Callable[[], None]) -> None:
        """Perform a SINGULAR command; call `ended` after its end."""
        self.singular = self._clock.process(self._perform(procedure, ended))

    def end(self) -> None:
        """End the SINGULAR command before its time."""
        if self.singular is not None:
            interrupt(self.singular)

    def kill(self) -> None:
        """End the SINGULAR command without further effect, at power-off."""
        process, self.singular = self.singular, None
        if process is not None:
            kill(process)

    def _perform(self, procedure: Procedure, ended: Callable[[], None]) -> Procedure:
        try:
            yield from procedure
        except Interrupt:
            pass  # ended before its time
        finally:
            self.singular = None
        ended()
