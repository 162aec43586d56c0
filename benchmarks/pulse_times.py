"""Expansion of pulse times: `pulse_times` compared with a Python loop of the same arithmetic.

A history of ramped moves is also compared with the expansion of each move by itself.  Times are processor times; also
printed is the peak memory, as a ratio to that of the result.
"""

import sys
import tracemalloc
from fractions import Fraction
from pathlib import Path
from time import process_time

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "src"))

from axistwin.sim.motion.profile import Profile, Segment
from axistwin.sim.motion.ramp import Ramp
from axistwin.sim.motion.train import Train

PULSES = 10_000_000
LOOPED = 200_000
MOVES = 10_000
S = 10**9


def vectorised(train: Train, until_ns: int) -> float:
    """Return pulses per second of processor time; the best of five, as the first run allocates memory."""
    rates = []
    for _ in range(5):
        begin = process_time()
        count = len(train.pulse_times(0, until_ns))
        rates.append(count / (process_time() - begin))
    return max(rates)


def looped(profile: Profile) -> float:
    """Return pulses per second with one formula per pulse."""
    begin = process_time()
    times = [profile.pulse_ns(n) for n in range(1, LOOPED + 1)]
    assert len(times) == LOOPED
    return LOOPED / (process_time() - begin)


def simplest(rate: Fraction) -> float:
    """Return pulses per second of the shortest possible loop, for a constant rate."""
    begin, numerator, denominator = process_time(), S * rate.denominator, rate.numerator
    times = [n * numerator // denominator for n in range(1, LOOPED + 1)]
    assert len(times) == LOOPED
    return LOOPED / (process_time() - begin)


def history(*, repeated: bool) -> tuple[Train, int]:
    """Return moves of about 1,000 pulses with ramps of 100 pulses/s every 10 ms, and the time after the last one."""
    ramps = [Ramp(Fraction(400 + n), Fraction(10_000), Fraction(100), Fraction(1, 100)) for n in range(200)]
    train, now = Train(), 0
    for k in range(MOVES):
        profile = ramps[0].index(1000) if repeated else ramps[k % 200].index(1000 + k // 200)
        assert profile.end_ns is not None
        train.start(now, +1, profile)
        now += profile.end_ns + S // 1000
    return train, now


def peak(train: Train, until_ns: int) -> float:
    """Return the peak memory of an expansion, divided by the memory of its result."""
    tracemalloc.start()
    times = train.pulse_times(0, until_ns)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return most / times.nbytes


def move_by_move(train: Train) -> float:
    """Return pulses per second with a calculation for each segment of each move."""
    import numpy as np

    moves = list(train.moves)[-LOOPED // 1000 :]
    begin, count = process_time(), 0
    for move in moves:
        times = np.empty(move.profile.pulses or 0, np.int64)
        move.profile.fill_pulse_times(1, move.start_ns, times)
        count += len(times)
    return count / (process_time() - begin)


def main() -> None:
    """Print the ratios for a rate with a short pattern, one with a long pattern, and for histories of moves."""
    for repeated, goal in ((True, 100), (False, 40)):
        train, now = history(repeated=repeated)
        speed, before = vectorised(train, now), max(move_by_move(train) for _ in range(5))
        what = "the same ramped move" if repeated else "different ramped moves"
        print(f"pulse_times of 10,000 times {what}: {speed / 1e6:.0f} million pulses/s (goal >= {goal})")
        print(f"  {speed / before:.0f} times each move by itself, peak memory {peak(train, now):.2f} times the result")
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
