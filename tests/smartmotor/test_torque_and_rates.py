"""Mode torque of a motor without a data sheet, and rates of 0 while the motor moves."""

import pytest

from .talking import advance, ask, send

FASTER = 4 * 65536


@pytest.mark.parametrize(
    ("torque", "counts"), [(0, 0), (31, 0), (32, 1), (63, 1), (64, 2), (1023, 31), (-31, 0), (-32, -1), (-1023, -31)]
)
@pytest.mark.parametrize(("functions", "way"), [(0, 1), (2, -1)])
def test_torque_turns_the_shaft_by_a_32nd_of_it_in_a_sample(bench, motor, torque, counts, functions, way):
    """5 of the base language, MT: T at once; a motor without a data sheet: T/32 counts per sample, towards 0; F=2."""
    send(bench, motor, f"F={functions} MT T={torque}")
    advance(bench)
    before = motor.axes["shaft"].position
    advance(bench, 500)
    assert motor.axes["shaft"].position - before == 500 * counts * way


@pytest.mark.parametrize("words", ["MV A=0 V=0 G", "MP A=0 P=0 G", "A=0 X"])
def test_with_a_zero_a_moving_motor_keeps_its_velocity_until_s(bench, motor, words):
    """4 of the base language: A is the change of velocity in a sample; S stops whatever A is."""
    send(bench, motor, f"MV A={FASTER} V={FASTER} G", 0.01)
    send(bench, motor, words)
    advance(bench)
    before = motor.axes["shaft"].position
    advance(bench, 100)
    assert motor.axes["shaft"].position - before == 400
    assert send(bench, motor, "RV RBt") == b"262144\r1\r"
    send(bench, motor, "S")
    assert ask(bench, motor, "RV") == "0"
