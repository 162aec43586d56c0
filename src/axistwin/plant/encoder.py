"""An incremental encoder on the motor's shaft or, behind backlash, on the load."""

from dataclasses import dataclass


@dataclass(frozen=True)
class EncoderData:
    """`counts_per_rev` after quadrature, for `pulses_per_rev` motor pulses; `backlash` in counts between the two."""

    counts_per_rev: int = 4000
    pulses_per_rev: int = 400
    backlash: int = 0

    def __post_init__(self) -> None:
        if self.counts_per_rev == 0 or self.pulses_per_rev <= 0 or self.backlash < 0:
            raise ValueError("an encoder has counts and pulses per revolution, and no negative backlash")


class Encoder:
    """Counts what the load does: the shaft's position in counts, less the play when the direction has changed."""

    def __init__(self, data: EncoderData) -> None:
        self.data = data
        self._load = 0
        self._displaced = 0

    def follow(self, position: int) -> int:
        """The shaft has moved monotonically to `position` (in pulses); returns the count there."""
        shaft = position * self.data.counts_per_rev // self.data.pulses_per_rev
        self._load = min(max(self._load, shaft - self.data.backlash), shaft)
        return self._load + self._displaced

    def displace(self, counts: int) -> None:
        """Somebody pushes the load; it stays there until the motor moves it back."""
        self._displaced += counts
