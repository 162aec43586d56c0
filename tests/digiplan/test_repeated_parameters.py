"""Chapter Acceleration rate: "The interface will remember any programmed data unless it is overwritten"."""

import pytest

from .talking import ask, command, constant, pulse_times_of, ramped, ready, since_start


@pytest.mark.parametrize(
    ("message", "expected"),
    [
        ("@200@400X10$", constant(400, 10)),
        ("X10@400@200$", constant(200, 10)),
        ("X20Y10@400$", constant(400, 10)),
        ("<4<8X10@800$", constant(800, 10)),
        ("<8<4X200@800$", pulse_times_of(ramped(200, 400, 800, 100, 10_000))),
        ("^10^20X200@800$", pulse_times_of(ramped(200, 400, 800, 100, 20_000))),
        (">2>4X10@3<1$", constant(3, 10)),
        (">4>2X10@3<1$", constant(12.5, 10)),
        ("B+5B-5X10@400$", constant(400, 10)),
    ],
)
def test_in_one_message_the_last_value_counts(bench, message, expected):
    """Acceleration: if one message holds the same parameter twice, the last value is used."""
    if1 = ready(bench, recalculation_s=0.01)
    command(bench, if1, message, seconds=4)
    assert since_start(if1.axes["X"]) == expected
    assert ask(bench, if1, "F") == b"0\r"


def test_of_two_corrections_the_last_counts(bench, if1):
    """Backlash correction: the last value is 10, so an index of 20 makes 30 steps, and 10 back."""
    command(bench, if1, "B-20B-10X20B$", seconds=1)
    assert len(if1.axes["X"].pulse_times()) == 40 and if1.axes["X"].position == 20


def test_of_two_delays_the_last_counts(bench, if1):
    """Inter-character delay: the last value is used: 20 ms, not 250, before each of two characters."""
    command(bench, if1, "D25D2", seconds=0.1)
    assert ask(bench, if1, "E", 0.06) == b"C\r"


@pytest.mark.parametrize("message", ["X5Y6X7$", "X5GG$", "X5/Y2/Z1$", "P1P2$", "H1H2X5$", "L1L2X5$", "R1R2$", "X5B/B$"])
def test_what_is_no_data_stands_once(bench, if1, message):
    """Combining inputs and outputs: each stage of the format may be given once only."""
    command(bench, if1, message, seconds=0.3)
    assert ask(bench, if1, "F") == b"8\r"
    assert all(axis.position == 0 for axis in if1.axes.values())


@pytest.mark.parametrize(("message", "outputs"), [("S11$", (1,)), ("S1221$", (1, 2)), ("S12R22$", (1,))])
def test_an_output_named_twice_is_one_output(bench, if1, message, outputs):
    """Output switching: an output that is listed twice is switched once."""
    command(bench, if1, message, seconds=0.1)
    assert tuple(n for n in range(1, 6) if if1.pins[f"output{n}"].level) == outputs
    assert ask(bench, if1, "F") == b"0\r"


@pytest.mark.parametrize("message", ["X0005@0400$", "X+5@400$", "X 5 @ 4 0 0 $", "X000000005$"])
def test_leading_zeros_and_spaces_do_not_count(bench, if1, message):
    """Basic move instructions: spaces "will simply be ignored"; Index mode: "9 decades"."""
    command(bench, if1, message, seconds=0.3)
    assert since_start(if1.axes["X"]) == constant(400, 5)
