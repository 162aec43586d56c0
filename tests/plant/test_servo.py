"""Data sheets of servo motors and their loads."""

from dataclasses import replace
from math import inf, pi

import pytest

from axistwin import Bench
from axistwin.core.errors import UsageError
from axistwin.plant.servo import FRAME17, FRAME23, FRAME34, ServoLoad, servo_load, servo_motor


def test_the_data_sheets_are_those_of_such_motors():
    """The rated torques are about 0.07, 0.34 and 1 N·m; the rated current heats to 5 K below 70 °C in air of 25 °C."""
    for motor, torque in ((FRAME17, 0.07), (FRAME23, 0.34), (FRAME34, 1.0)):
        assert motor.torque_constant_nm_per_a * motor.continuous_current_a == pytest.approx(torque, rel=0.05)
        watts = motor.continuous_current_a**2 * motor.winding_resistance_ohm
        assert 35 < watts * motor.housing_to_ambient_k_per_w <= 41
        assert motor.counts_per_radian * 2 * pi == pytest.approx(motor.counts_per_rev)


def test_a_motor_by_name_or_by_values():
    assert servo_motor("frame17") is FRAME17 and servo_motor(FRAME34) is FRAME34
    assert servo_motor({"supply_voltage_v": 24}) == replace(FRAME23, supply_voltage_v=24)
    assert servo_motor({"model": "frame34", "kp": 100}).tuning == (100, 28, 550, 15, 1, 0, 0, 0)
    assert servo_load() == servo_load({}) == ServoLoad()
    assert servo_load({"gravity_torque_nm": -0.1}).gravity_torque_nm == -0.1


@pytest.mark.parametrize(("given", "message"), [
    ("frame42", "unknown motor 'frame42': expected one of frame17, frame23, frame34, or a table of parameters"),
    (7, "unknown motor 7: expected one of"),
    ({"model": "big"}, "unknown motor 'big': expected one of"),
    ({"volts": 24}, "unknown parameter 'volts' of the motor: expected one of model, torque_constant_nm_per_a"),
    ({"supply_voltage_v": 0}, "invalid motor supply_voltage_v=0: expected a number from above 0 to 1e[+]06"),
    ({"supply_voltage_v": "24"}, "invalid motor supply_voltage_v='24': expected a number"),
    ({"supply_voltage_v": inf}, "invalid motor supply_voltage_v=inf: expected a number"),
    ({"coulomb_friction_nm": -0.1}, "invalid motor coulomb_friction_nm=-0.1: expected a number from 0"),
    ({"counts_per_rev": 1000}, "invalid counts_per_rev=1000 of a motor: expected 2000 or 4000"),
    ({"kp": 65536}, "invalid motor kp=65536: expected a number from 0 to 65535"),
    ({"kp": 1.5}, "invalid motor kp=1.5: expected a whole number"),
    ({"ks": 0}, "invalid motor ks=0: expected a number from 1 to 65535")])  # fmt: skip
def test_a_wrong_motor_is_told_in_one_line(given, message):
    with pytest.raises(UsageError, match=f"^{message}"):
        servo_motor(given)


@pytest.mark.parametrize(("given", "message"), [
    ("heavy", "invalid load 'heavy': expected a table of parameters, e.g."),
    ({"mass": 1}, "unknown parameter 'mass' of the load: expected one of inertia_kg_m2"),
    ({"inertia_kg_m2": -1}, "invalid load inertia_kg_m2=-1: expected a number from 0"),
    ({"gravity_torque_nm": True}, "invalid load gravity_torque_nm=True: expected a number")])  # fmt: skip
def test_a_wrong_load_is_told_in_one_line(given, message):
    with pytest.raises(UsageError, match=f"^{message}"):
        servo_load(given)


@pytest.mark.parametrize("number", [10**400, -(10**5000)], ids=["long", "longer"])
def test_a_number_without_end_is_refused(number):
    shaft = Bench().add("smartmotor").axes["shaft"]
    for use in (lambda: ServoLoad(gravity_torque_nm=number), lambda: shaft.load(number)):
        with pytest.raises(UsageError, match="a whole number has more than 64 bits"):
            use()
