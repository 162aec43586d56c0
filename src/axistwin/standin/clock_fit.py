"""The board's clock as a linear function of the host's clock, fitted by least squares."""

from collections import deque

SAMPLES = 128
"""Number of clock samples to which the line is fitted."""
ENOUGH = 40
"""Smallest number of clock samples for a usable fit: they cover 0.8 s, so that the slope is good to some 5 ppm."""
MOST_DEVIATION = 0.01
"""Largest relative deviation of a board's clock from its nominal frequency; ceramic resonators have up to 0.5 %."""
WORST_S = 50e-6
"""Largest error, in seconds, of the line at the start of motion."""
NOISE_S = 10e-6
"""Error of a sample with the shortest round trip; of any other sample, half of the extra time may be error too."""
LEAST_SPREAD_S = 0.01
"""Smallest standard deviation of the samples' times from which a slope is computed."""
MOST_SHIFT_S, MOST_SLOPE = 20e-6, 20e-6
"""Largest change of a steady line by one sample: at the sample's time, and relative, of its slope."""
_WRAP = 1 << 32


class ClockFit:
    """Converts between seconds of the host's clock and ticks of the board's clock."""

    def __init__(self, nominal_hz: float) -> None:
        self.nominal_hz = nominal_hz
        self._samples: deque[tuple[float, int, float]] = deque(maxlen=SAMPLES)
        self._latest = 0
        self._time_s, self._ticks, self.hz = 0.0, 0.0, nominal_hz
        self.error_s = float("inf")
        """Largest difference in seconds between the line and a sample with a short round trip."""
        self.steady = False
        """True in motion: a line that moves by more than the time between two pulses would stop the motors."""

    @property
    def ready(self) -> bool:
        """True if there are enough clock samples to convert times."""
        return len(self._samples) >= ENOUGH

    @property
    def good(self) -> bool:
        """True if there are enough clock samples and their error is small."""
        return self.ready and self.error_s <= WORST_S

    def add(self, sent_s: float, received_s: float, clock: int) -> None:
        """Add one reading of the board's clock.

        The board read the 32 bits of `clock` between `sent_s` and `received_s` of the host's clock.
        """
        ticks = self.unwrapped(clock)
        self._latest = max(self._latest, ticks)
        self._samples.append(((sent_s + received_s) / 2, ticks, received_s - sent_s))
        self._fit()

    def unwrapped(self, clock: int) -> int:
        """Extend a 32-bit reading of the board's clock to the full tick count."""
        return self._latest + ((clock - self._latest + (_WRAP >> 1)) % _WRAP) - (_WRAP >> 1)

    def _fit(self) -> None:
        """Fit a line through the clock samples by weighted least squares."""
        before_s, before, before_hz = self._time_s, self._ticks, self.hz
        shortest = min(trip for _, _, trip in self._samples)
        base = self._samples[0][1]
        good = [(at, ticks - base, (NOISE_S + (trip - shortest) / 2) ** -2) for at, ticks, trip in self._samples]
        total = sum(weight for _, _, weight in good)
        mean_s = sum(weight * at for at, _, weight in good) / total
        mean_ticks = sum(weight * ticks for _, ticks, weight in good) / total
        spread = sum(weight * (at - mean_s) ** 2 for at, _, weight in good)
        if spread / total > LEAST_SPREAD_S**2:
            self.hz = sum(weight * (at - mean_s) * (ticks - mean_ticks) for at, ticks, weight in good) / spread
            least, most = (self.nominal_hz * (1 + sign * MOST_DEVIATION) for sign in (-1, +1))
            self.hz = min(max(self.hz, least), most)
        self._time_s, self._ticks = mean_s, base + mean_ticks
        if self.steady:
            self.hz = _within(self.hz, before_hz, MOST_SLOPE * before_hz)
            now_s, now = self._samples[-1][0], self.ticks(self._samples[-1][0])
            self._ticks += _within(now, before + (now_s - before_s) * before_hz, MOST_SHIFT_S * self.hz) - now
        short = [(at, ticks) for at, ticks, trip in self._samples if trip <= 1.5 * shortest + 50e-6]
        self.error_s = max(abs(self.ticks(at) - ticks) for at, ticks in short) / self.hz

    def ticks(self, time_s: float) -> float:
        """Convert a time of the host's clock to ticks of the board's clock."""
        return self._ticks + (time_s - self._time_s) * self.hz

    def time_s(self, ticks: float) -> float:
        """Convert ticks of the board's clock to a time of the host's clock."""
        return self._time_s + (ticks - self._ticks) / self.hz


def _within(value: float, center: float, most: float) -> float:
    return min(max(value, center - most), center + most)
