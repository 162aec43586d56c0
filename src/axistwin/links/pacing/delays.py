"""Delays of the bench against the wall clock, counted for the user."""

LATE_S = 0.025
"""Delay in seconds above which an event counts as an overrun."""


class Delays:
    """Counts how often virtual time has fallen behind the wall clock, and records the longest delay."""

    def __init__(self) -> None:
        self.blocks = 0
        self.overruns = 0
        """Number of overruns: blocks whose first event was late by more than `LATE_S` seconds."""
        self.most_late_s = 0.0

    def count(self, late_s: float) -> None:
        """Record that virtual time was `late_s` seconds behind the wall clock."""
        self.blocks += 1
        if late_s > LATE_S:
            self.overruns += 1
            self.most_late_s = max(self.most_late_s, late_s)

    def report(self) -> str | None:
        """Return one line about the overruns; None if there were none."""
        if not self.overruns:
            return None
        times = "once" if self.overruns == 1 else f"{self.overruns} times"
        return f"fell behind the wall clock {times}, by {self.most_late_s * 1000:.0f} ms at most"
