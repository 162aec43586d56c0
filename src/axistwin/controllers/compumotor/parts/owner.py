"""SINGULAR commands, which take time (chapter Command attributes): each owner performs one of them at a time.

The two owners are the host and the sequence.  79h and 7Ah end the SINGULAR command of the sequence only; 73h ends both.
"""

from collections.abc import Callable

from axistwin.sim.clock import Clock, Interrupt, Procedure, Process, interrupt, kill


class Owner:
    """The host or the sequence, as the source of a SINGULAR command."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self.singular: Process | None = None

    @property
    def busy(self) -> bool:
        """True while a SINGULAR command is in progress."""
        return self.singular is not None

    def begin(self, procedure: Procedure, ended: Callable[[], None]) -> None:
        """Perform a SINGULAR command as a process, and call `ended` after its end."""
        self.singular = self._clock.process(self._perform(procedure, ended))

    def end(self) -> None:
        """Discontinue the SINGULAR command."""
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
            pass  # discontinued
        finally:
            self.singular = None
        ended()
