"""An incremental encoder on the motor's shaft, or on the load, which backlash separates from the shaft."""

from dataclasses import dataclass


@dataclass(frozen=True)
class EncoderData:
    """`counts_per_rev`: counts after quadrature per revolution of `pulses_per_rev` motor pulses.  `backlash`: in
    counts, between motor and encoder.

    Channel Z is active once per revolution, for `index_counts` counts from count `index` on.
    """

    counts_per_rev: int = 4000
    pulses_per_rev: int = 400
    backlash: int = 0
    index: int = 0
    index_counts: int = 1

    def __post_init__(self) -> None:
        if self.counts_per_rev == 0 or self.pulses_per_rev <= 0 or self.backlash < 0:
            raise ValueError(
                "invalid encoder: counts_per_rev must not be 0, pulses_per_rev must be above 0, and backlash must be "
                "0 or more, e.g. counts_per_rev=4000, pulses_per_rev=400 and backlash=3"
            )
        if not 1 <= self.index_counts < max(2, abs(self.counts_per_rev)):
            raise ValueError("invalid index mark: expected a width of at least 1 count, and less than a revolution")


class Encoder:
    """An encoder that counts the load's motion: the shaft's position in counts, less the backlash after a reversal."""

    def __init__(self, data: EncoderData) -> None:
        self.data = data
        self._load = self._began = 0
        self._displaced = self._turned = 0
        self.direction = +1  # Direction of the load's last motion.
        self._counted: tuple[int, int] | None = None
        """Position of the load and encoder count at the latest encoder fault; None if there was no fault."""
        self._of, self._out_of = 1, 1

    def follow(self, position: int) -> int:
        """Turn the shaft to a `position` in pulses, without a reversal, and return the encoder count."""
        before, self._load = self._load, self._dragged(self._load, position)
        if self._load != before:
            self.direction = 1 if self._load > before else -1
        return self._count(self._load)

    def begin(self) -> None:
        self._began = self._load

    def count_at(self, position: int) -> int:
        """Return the count for an earlier `position` of the shaft in the present monotonic motion."""
        return self._count(self._dragged(self._began, position))

    @property
    def counts_per_pulses(self) -> tuple[int, int, int]:
        """Encoder ratio with tolerance, e.g. (4000, 400, 3): 400 motor pulses cause 4000 ± 3 encoder counts.

        The tolerance: 1 count of the shaft's position, the backlash, and 1 count at each end if the encoder miscounts.
        """
        counts, pulses = self.data.counts_per_rev * self._of, self.data.pulses_per_rev * self._out_of
        return counts, pulses, -(-(1 + self.data.backlash) * abs(self._of) // self._out_of) + 2

    @property
    def at_index(self) -> bool:
        disc = self._load + self._displaced + self._turned
        return (disc - self.data.index) % abs(self.data.counts_per_rev) < self.data.index_counts

    def index_edges(self) -> tuple[int, ...]:
        """Return two motor positions n, below and above: the index mark begins or ends between positions n-1 and n."""
        rev, width = abs(self.data.counts_per_rev), self.data.index_counts
        into = (self._load + self._displaced + self._turned - self.data.index) % rev
        above = self._load + (width if into < width else rev) - into
        below = self._load - into + (0 if into < width else width)
        return self._edge(above + self.data.backlash), self._edge(below)

    def _edge(self, counts: int) -> int:
        """Return the motor position n for which this count is reached between positions n-1 and n."""
        per_rev, pulses = self.data.counts_per_rev, self.data.pulses_per_rev
        return -(-counts * pulses // per_rev) if per_rev > 0 else counts * pulses // per_rev + 1

    def _dragged(self, load: int, position: int) -> int:
        shaft = position * self.data.counts_per_rev // self.data.pulses_per_rev
        return min(max(load, shaft - self.data.backlash), shaft)

    def _count(self, load: int) -> int:
        moved = load + self._displaced
        if self._counted is None:
            return moved
        since, count = moved - self._counted[0], self._counted[1]
        counted = abs(since) * abs(self._of) // self._out_of
        return count + (counted if since * self._of > 0 else -counted)

    def miscount(self, of: int, out_of: int) -> None:
        """Count wrongly from now on: `of` counts for each `out_of` counts, e.g. 9 of 10, -1 of 1, 0 of 1.

        After 1 of 1 the encoder counts correctly again, from its present count.
        """
        self._counted = self._load + self._displaced, self._count(self._load)
        self._of, self._out_of = of, out_of

    def displace(self, counts: int) -> None:
        """Push the load; the load stays there until the motor moves it back."""
        self._displaced += counts
        self.direction = 1 if counts > 0 else -1

    def slip(self, counts: int) -> None:
        self._counted = self._load + self._displaced, self._count(self._load) + counts
        self._turned += counts
