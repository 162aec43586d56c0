"""The board's clock as a linear function of the host's clock, fitted by least squares."""

import math

import numpy as np

SAMPLES = 256  # Number of clock samples to which the line is fitted.
ENOUGH = 40  # Smallest number of samples for a usable fit: 0.8 s, so that the slope is good to some 5 ppm.
MOST_DEVIATION = 0.01  # Largest relative deviation from the nominal frequency; ceramic resonators have 0.5 %.
WORST_S = 50e-6  # Largest error, in seconds, of the line at the start of motion.
NOISE_S = 5e-6  # Error of a sample with the shortest round trip; of others, half of the extra time may be error.
LEAST_SPREAD_S = 0.01  # Smallest standard deviation of the samples' times from which a slope is computed.
MOST_SHIFT_S, MOST_SLOPE = 20e-6, 20e-6  # Largest change of a steady line by a sample: in s, and of its slope.
_WRAP = 1 << 32


class ClockFit:
    """Converts between seconds of the host's clock and ticks of the board's clock."""

    def __init__(self, nominal_hz: float) -> None:
        self.nominal_hz = nominal_hz
        self._samples, self._count = np.empty((SAMPLES, 3)), 0
        self._latest, self._time_s, self._ticks, self.hz = 0, 0.0, 0.0, nominal_hz
        self.error_s = math.inf
        """Error of the line in seconds: its standard error at the latest sample, and the largest contradiction.

        A sample with a longer round trip may be off by half of the extra time; what is beyond is the contradiction.
        """
        self.steady = False  # True in motion: a line that moves by more than a pulse interval would stop the motors.

    @property
    def ready(self) -> bool:
        return self._count >= ENOUGH

    @property
    def good(self) -> bool:
        """True if host times can be converted to board times with an error of at most `WORST_S`."""
        return self.ready and self.error_s <= WORST_S

    def add(self, sent_s: float, received_s: float, clock: int) -> None:
        """Fit the line again with a reading: the 32 bits `clock`, read from `sent_s` to `received_s` of the host."""
        ticks = self.unwrapped(clock)
        self._latest = max(self._latest, ticks)
        if self._count == SAMPLES:
            self._samples[:-1] = self._samples[1:]
        else:
            self._count += 1
        self._samples[self._count - 1] = (sent_s + received_s) / 2, ticks, received_s - sent_s
        self._fit()

    def unwrapped(self, clock: int) -> int:
        """Extend a 32-bit reading of the board's clock to the full tick count."""
        return self._latest + ((clock - self._latest + (_WRAP >> 1)) % _WRAP) - (_WRAP >> 1)

    def _fit(self) -> None:
        """Fit a line by weighted least squares; the shortest round trips weigh most, as delays only add."""
        before_s, before, before_hz = self._time_s, self._ticks, self.hz
        at, ticks, trips = self._samples[: self._count].T
        extra_s = (trips - trips.min()) / 2
        noise_s = NOISE_S + extra_s
        weights = noise_s**-4
        total = weights.sum()
        mean_s, mean_ticks = float(weights @ at / total), float(weights @ ticks / total)
        from_mean_s = at - mean_s
        spread = float(weights @ from_mean_s**2)
        spread_out = spread > LEAST_SPREAD_S**2 * total
        if spread_out:
            self.hz = float(weights * from_mean_s @ (ticks - mean_ticks)) / spread
            self.hz = _within(self.hz, self.nominal_hz, self.nominal_hz * MOST_DEVIATION)
        self._time_s, self._ticks = mean_s, mean_ticks
        if self.steady:
            self.hz = _within(self.hz, before_hz, MOST_SLOPE * before_hz)
            now_s, now = float(at[-1]), self.ticks(float(at[-1]))
            self._ticks += _within(now, before + (now_s - before_s) * before_hz, MOST_SHIFT_S * self.hz) - now
        if spread_out:
            beyond_s = np.abs(self._ticks + from_mean_s * self.hz - ticks) / self.hz - extra_s
            mean_noise_s = np.linalg.norm(weights * noise_s) / total
            slope_noise = np.linalg.norm(weights * noise_s * from_mean_s) / spread
            standard_s = math.hypot(mean_noise_s, from_mean_s[-1] * slope_noise)
            self.error_s = max(0.0, float(beyond_s.max())) + standard_s

    def ticks(self, time_s: float) -> float:
        return self._ticks + (time_s - self._time_s) * self.hz

    def time_s(self, ticks: float) -> float:
        return self._time_s + (ticks - self._ticks) / self.hz


def _within(value: float, center: float, most: float) -> float:
    return min(max(value, center - most), center + most)
