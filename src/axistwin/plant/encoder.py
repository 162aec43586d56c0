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
        self._counted: tuple[int, int] | None = None  # where the load was, and the count, when counting went wrong
        self._of, self._out_of = 1, 1

    def follow(self, position: int) -> int:
        """The shaft has moved monotonically to `position` (in pulses); returns the count there."""
        shaft = position * self.data.counts_per_rev // self.data.pulses_per_rev
        self._load = min(max(self._load, shaft - self.data.backlash), shaft)
        return self._count()

    def _count(self) -> int:
        moved = self._load + self._displaced
        if self._counted is None:
            return moved
        since, count = moved - self._counted[0], self._counted[1]
        counted = abs(since) * abs(self._of) // self._out_of
        return count + (counted if since * self._of > 0 else -counted)

    def miscount(self, of: int, out_of: int) -> None:
        """From now on it counts `of` for each `out_of` counts: 9 of 10, -1 of 1 backwards, 0 of 1 not at all.

        With 1 of 1 it counts well again, from where it has got to.
        """
        self._counted = self._load + self._displaced, self._count()
        self._of, self._out_of = of, out_of

    def displace(self, counts: int) -> None:
        """Somebody pushes the load; it stays there until the motor moves it back."""
        self._displaced += counts

    def slip(self, counts: int) -> None:
        """It turns on its shaft by so many counts."""
        self._counted = self._load + self._displaced, self._count() + counts
