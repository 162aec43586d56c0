"""Expansion of pulse times: `pulse_times` compared with a Python loop of the same arithmetic."""

import sys
from fractions import Fraction
from pathlib import Path
from time import perf_counter

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "src"))

from axistwin.motion import Profile, Segment
from axistwin.motion.train import Train

PULSES = 10_000_000
LOOPED = 200_000
S = 10**9


def vectorised(train: Train, until_ns: int) -> float:
    """Return pulses per second of wall-clock time; the best of five, as the first run allocates memory."""
    rates = []
    for _ in range(5):
        begin = perf_counter()
        count = len(train.pulse_times(0, until_ns))
        rates.append(count / (perf_counter() - begin))
    return max(rates)


def looped(profile: Profile) -> float:
    """Return pulses per second with one formula per pulse."""
    begin = perf_counter()
    times = [profile.pulse_ns(n) for n in range(1, LOOPED + 1)]
    assert len(times) == LOOPED
    return LOOPED / (perf_counter() - begin)


def simplest(rate: Fraction) -> float:
    """Return pulses per second of the shortest possible loop, for a constant rate."""
    begin, numerator, denominator = perf_counter(), S * rate.denominator, rate.numerator
    times = [n * numerator // denominator for n in range(1, LOOPED + 1)]
    assert len(times) == LOOPED
    return LOOPED / (perf_counter() - begin)


def main() -> None:
    """Print the ratios for a rate with a short pattern and one with a long pattern."""
    for rate in (Fraction(10_000), Fraction(36_025, 4), Fraction(13_107_200, 3 * 1600)):
        profile = Profile([Segment(rate, None)])
        train = Train()
        train.start(0, +1, profile)
        speed = vectorised(train, profile.pulse_ns(PULSES))
        ratios = f"{speed / simplest(rate):.0f} times the plainest loop, {speed / looped(profile):.0f} times ours"
        print(f"pulse_times at {float(rate):g} pulses/s: {speed / 1e6:.0f} million pulses/s (goal >= 100)")
        print(f"  {ratios} (goal >= 20)")


if __name__ == "__main__":
    main()
