"""Mode torque of a motor without a data sheet, and rates of 0 while the motor moves."""

import pytest

from .cam import pass_samples
from .talking import ask, ready, tell

FASTER = 4 * 65536


@pytest.mark.parametrize(
    ("torque", "counts"), [(0, 0), (31, 0), (32, 1), (63, 1), (64, 2), (1023, 31), (-31, 0), (-32, -1), (-1023, -31)]
)
@pytest.mark.parametrize(("functions", "way"), [(0, 1), (2, -1)])
def test_torque_turns_the_shaft_by_a_32nd_of_it_in_a_sample(bench, torque, counts, functions, way):
    """5 of the base language, MT: T at once; a motor without a data sheet: T/32 counts per sample, towards 0; F=2."""
    motor = ready(bench)
    tell(bench, motor, f"F={functions} MT T={torque}")
    pass_samples(bench)
    before = motor.axes["shaft"].position
    pass_samples(bench, 500)
    assert motor.axes["shaft"].position - before == 500 * counts * way


@pytest.mark.parametrize("words", ["MV A=0 V=0 G", "MP A=0 P=0 G", "A=0 X"])
def test_with_a_zero_a_moving_motor_keeps_its_velocity_until_s(bench, words):
    """4 of the base language: A is the change of velocity in a sample; S stops whatever A is."""
    motor = ready(bench)
    tell(bench, motor, f"MV A={FASTER} V={FASTER} G", 0.01)
    tell(bench, motor, words)
    pass_samples(bench)
    before = motor.axes["shaft"].position
    pass_samples(bench, 100)
    assert motor.axes["shaft"].position - before == 400
    assert tell(bench, motor, "RV RBt") == b"262144\r1\r"
    tell(bench, motor, "S")
    assert ask(bench, motor, "RV") == "0"
