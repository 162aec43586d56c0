"""Chapter Run mode instructions: "the data used in a previous index will be lost ... default to zero index length"."""

import pytest

from .talking import ask, command


@pytest.mark.parametrize("run", ["X@400G$", "X/Y@400G$", ":X@400G:P0,5:A:$"])
def test_each_index_length_is_zero_until_it_is_said_again(bench, if1, run):
    """Run mode: "the distance MUST be stated in a subsequent index instruction", both distances of an interpolation."""
    command(bench, if1, "X200/Y100@400$", seconds=1)
    command(bench, if1, run, seconds=0.3)
    command(bench, if1, "#", seconds=0.3)
    at = {name: axis.position for name, axis in if1.axes.items()}

    def moved(message):
        before = [axis.position for axis in if1.axes.values()]
        command(bench, if1, message, seconds=0.5)
        return [axis.position - then for axis, then in zip(if1.axes.values(), before, strict=True)]

    assert at["X"] > 200
    assert (moved("Z-$"), moved("X/Y$"), moved("X50/Y$")) == ([0, 0, 0], [0, 0, 0], [50, 0, 0])
    assert (moved("X/Y25$"), moved("Z$"), ask(bench, if1, "F")) == ([50, 25, 0], [0, 0, 50], b"0\r")
