"""The encoder counts of a servo motor as pulses."""

import numpy as np
import pytest

from axistwin import Bench
from axistwin.real.standin.motors import motor


@pytest.fixture
def servo():
    """A SmartMotor that accepts moves, and a function that sends commands and returns the pulses of some seconds."""
    bench = Bench()
    controller = bench.add("smartmotor")
    bench.run(1.5)
    controller.serial.write(b"UCI UDI ZS ")
    bench.run(0.5)
    shaft = controller.axes["shaft"]
    driven = motor(shaft)

    def say(text, seconds):
        controller.serial.write(text)
        found = []
        for _ in range(round(seconds * 100)):
            bench.run(0.01)
            found += driven.runs()
        return found

    return say, shaft, driven


def test_the_pulses_are_even_while_the_motor_has_a_constant_velocity(servo):
    """V=65536 is one count per sample, and there are 4069 samples/s."""
    say, shaft, driven = servo
    [(way, first), *more] = say(b"A=400 V=65536 P=8000 G ", 3.0)
    assert [way, *(each for each, _ in more)] == [1] * (1 + len(more))
    times = np.concatenate([first, *(each for _, each in more)])
    assert len(times) == shaft.position == driven.pulses == 8000 and (np.diff(times) > 0).all()
    cruise = np.diff(times[2000:6000])
    assert abs(cruise.mean() - 1e9 / 4069) < 0.002 * 1e9 / 4069
    assert np.abs(cruise - cruise.mean()).max() < 0.05 * cruise.mean()


def test_the_net_pulses_are_the_position_at_rest_after_changes_of_direction(servo):
    say, shaft, driven = servo
    found = []
    for text in (b"A=400 V=60000 P=900 G ", b"P=-700 G ", b"P=3 G ", b"P=2 G "):
        found += say(text, 1.5)
        assert sum(way * len(times) for way, times in found) == shaft.position == driven.pulses
    times = np.concatenate([each for _, each in found])
    assert (np.diff(times) >= 0).all()
    assert len(times) <= 900 + 1600 + 703 + 1 + 40  # the shaft overshoots a little


def test_a_blocked_shaft_has_no_pulses_until_it_is_released(servo):
    say, shaft, driven = servo
    say(b"A=400 V=60000 P=9000 G ", 0.5)
    driven.hold(700)
    assert (shaft.position, driven.pulses) == (700, 700) and say(b"", 0.5) == []
    driven.let_go()
    net = sum(way * len(times) for way, times in say(b"ZS P=0 G ", 2.0))
    assert (net, shaft.position, driven.pulses) == (-700, 0, 0)
