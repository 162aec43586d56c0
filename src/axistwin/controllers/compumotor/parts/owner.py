"""SINGULAR commands, which take time (chapter Command attributes), and the sources from which these commands come.

The two sources are the host and the sequence.  Commands 79h and 7Ah end only the SINGULAR command that the sequence has
begun.  Command 73h also ends the SINGULAR command that the host has sent.
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
        """True while a command with the attribute SINGULAR is in progress, e.g. a move."""
        return self.singular is not None

    def begin(self, procedure: Procedure, ended: Callable[[str | None], None]) -> None:
        """Begin a SINGULAR command; `ended` gets the reason if the command was ignored, otherwise None."""
        self.singular = self._clock.process(self._perform(procedure, ended))

    def end(self) -> None:
        if self.singular is not None:
            interrupt(self.singular)

    def kill(self) -> None:
        """End the command in progress at once, because the power is off."""
        process, self.singular = self.singular, None
        if process is not None:
            kill(process)

    def _perform(self, procedure: Procedure, ended: Callable[[str | None], None]) -> Procedure:
        why = None
        try:
            why = yield from procedure
        except Interrupt:
            pass  # discontinued
        finally:
            self.singular = None
        ended(why)
