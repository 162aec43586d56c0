"""SINGULAR commands, which take time (chapter Command attributes): each owner performs one of them at a time.

The two owners are the host and the sequence.  79h and 7Ah end the SINGULAR command of the sequence only; 73h ends both.
"""

from collections.abc import Callable

from axistwin.sim.clock import Clock, Interrupt, Procedure, Process, interrupt, kill


class Owner:
    """Source of commands with the attribute SINGULAR: the host or a sequence."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self.singular: Process | None = None

    @property
    def busy(self) -> bool:
        """True while a command with the attribute SINGULAR is in progress."""
        return self.singular is not None

    def begin(self, procedure: Procedure, ended: Callable[[], None]) -> None:
        """Begin a command with the attribute SINGULAR.

        The function `ended` is called after the end of the command.
        """
        self.singular = self._clock.process(self._perform(procedure, ended))

    def end(self) -> None:
        """Discontinue the command in progress that has the attribute SINGULAR."""
        if self.singular is not None:
            interrupt(self.singular)

    def kill(self) -> None:
        """End the command in progress at once, because the power is off."""
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
