"""An external encoder on another controller's axis: counted exactly, sample by sample."""

from fractions import Fraction

import pytest

from axistwin import Bench
from axistwin.core.errors import UsageError

SAMPLE_NS = 245_760
RATIOS = (Fraction(1), Fraction(5), Fraction(-7, 3))


def line(ratio: Fraction, **axis):
    """Return a bench, an IF1, and a SmartMotor that follows the IF1's X axis with this ratio, both ready."""
    bench = Bench()
    feeder, knife = bench.add("if1", X=axis), bench.add("smartmotor", line="instant")
    bench.run(1.5)
    feeder.serial.write(b"(")
    bench.run(0.1)
    feeder.serial.write(b"U61\r")
    bench.run(1.5)
    knife.master.follow(feeder.axes["X"], ratio)
    knife.serial.write(b"UCI UDI ZS MF4 ")
    bench.run(0.1)
    return bench, feeder, knife


@pytest.mark.parametrize("ratio", RATIOS)
def test_each_sample_sees_the_axis_as_it_is_then(ratio):
    """In every sample the shaft of an ideal motor in MF4 is at ratio × position of the axis, rounded down."""
    bench, feeder, knife = line(ratio)
    feeder.serial.write(b"X400@3000$\r")
    for _ in range(3000):
        bench.clock.run_to((bench.now // SAMPLE_NS + 1) * SAMPLE_NS)
        assert knife.axes["shaft"].position == feeder.axes["X"].position * ratio // 1
    assert feeder.axes["X"].position == 400


def test_the_division_of_the_run_makes_no_difference():
    """The result is the same in one piece, in small pieces, and with reports between the pieces."""

    def positions(piece_s, ask):
        bench, feeder, knife = line(Fraction(5))
        seen = []
        knife.axes["shaft"].subscribe(lambda samples: seen.extend(samples.positions))
        feeder.serial.write(b"X400@3000$\rX-200@900$\r")
        for _ in range(round(2 / piece_s)):
            bench.run(piece_s)
            if ask:
                knife.serial.write(b"RCTR ")
        knife.axes["shaft"].catch_up()
        return [at for at, before in zip(seen, [0, *seen], strict=False) if at != before]

    whole = positions(2, ask=False)
    assert whole[-1] == 5 * 200 and positions(0.004, ask=False) == whole
    assert positions(0.02, ask=True) == whole


def test_an_axis_that_is_stopped_by_hand_is_followed_no_further():
    """A jam in the middle of the move invalidates the predicted edges."""
    bench, feeder, knife = line(Fraction(5))
    feeder.serial.write(b"X400@1000$\r")
    bench.run(0.2)
    feeder.axes["X"].jam(True)
    at = feeder.axes["X"].position
    bench.run(1.0)
    assert 0 < at < 400 and feeder.axes["X"].position == at
    assert knife.axes["shaft"].position == 5 * at


def test_an_axis_that_loses_steps_is_followed_too():
    """A motor that is too weak loses whole teeth; the external encoder counts the shaft, not the pulses."""
    bench, feeder, knife = line(Fraction(2), motor={"torque": [[0, 0.1], [5000, 0.01]]}, load={"torque": 0.05})
    feeder.serial.write(b"X2000@6000$\r")
    bench.run(3)
    assert feeder.axes["X"].pulses == 2000 and knife.axes["shaft"].position == 2 * feeder.axes["X"].position


def test_a_circle_of_masters_is_an_error():
    """A circle of followers is refused, because in a circle no axis could move first."""
    bench = Bench()
    first, second, third = (bench.add("smartmotor") for _ in range(3))
    with pytest.raises(UsageError, match="a motor's external encoder cannot be mounted on the motor's own axis"):
        first.master.follow(first.axes["shaft"])
    second.master.follow(first.axes["shaft"])
    third.master.follow(second.axes["shaft"])
    with pytest.raises(UsageError, match="that follows this motor: expected an axis whose motion"):
        first.master.follow(third.axes["shaft"])
    assert first.master.followed is None
    second.master.stop()
    first.master.follow(third.axes["shaft"])  # now the chain ends at the second motor
