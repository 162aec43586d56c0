"""Chapter Baud rate: "The interface senses the baud rate automatically": the tolerance of its detection.

The bits of `(` are 0 0 0 1 0 1 0 0, and each is read in its middle.  The second 1 lasts from 6 to 7 of the host's
bits after the edge and is read at 6.5, the 0 after it at 7.5: the host's rate may be 7 / 6.5 = 1.077 or 0.933 of it.
"""

import pytest

from axistwin.core.units import S

from .talking import arrivals

RATES = (110, 300, 600, 1200, 2400, 4800, 9600)


def answered_at(bench, baud: int) -> float | None:
    """Return the rate at which `U` and <CR> answer a `(` sent at this rate, or None without an answer."""
    if1 = bench.add("if1", line=f"{baud} 8N2")
    bench.run(1.5)
    received = arrivals(bench, if1)
    if1.serial.write(b"(")
    bench.run(1)
    times = [at_ns for at_ns, _, _ in received]
    return None if len(times) < 2 else 11 * S / (times[1] - times[0])


@pytest.mark.parametrize(("baud", "rate"), [
    *((round(rate * percent / 100), rate) for rate in RATES for percent in (94, 107)),
    *((round(rate * percent / 100), None) for rate in RATES for percent in (92, 109)),
    *((baud, None) for baud in (55, 85, 200, 420, 850, 1700, 3500, 7000, 19200))])  # fmt: skip
def test_a_rate_that_is_not_quite_right_is_taken_for_the_nearest_one(bench, baud, rate):
    """Baud rate: "The options available" are seven; a rate between two of them is not detected.

    None: the character is misread at this rate, or the rate is between two of the list.
    """
    assert answered_at(bench, baud) == (rate and pytest.approx(rate, rel=1e-4))
