"""The machine that the controllers drive: axes, motors, encoders, switches, loads."""

from axistwin.plant.axes import Axis, servo_axis, stepper_axis
from axistwin.plant.counts import Samples
from axistwin.plant.encoder import EncoderData
from axistwin.plant.joystick import Joystick, JoystickInputs
from axistwin.plant.machine_units import MachineUnits, position, rate
from axistwin.plant.master import Master, Run
from axistwin.plant.servo import FRAME17, FRAME23, FRAME34, SERVO_MOTORS, ServoLoad, servo_load, servo_motor
from axistwin.plant.servo_axis import FAR, ServoAxis
from axistwin.plant.stepper import StepperAxis
from axistwin.plant.switches import PositionSwitch, in_series
from axistwin.plant.torque import Load, StepperMotor

__all__ = [
    "FAR", "FRAME17", "FRAME23", "FRAME34", "SERVO_MOTORS", "Axis", "EncoderData", "Joystick", "JoystickInputs",
    "Load", "MachineUnits", "Master", "PositionSwitch", "Run", "Samples", "ServoAxis", "ServoLoad", "StepperAxis",
    "StepperMotor", "in_series", "position", "rate", "servo_axis", "servo_load", "servo_motor", "stepper_axis",
]  # fmt: skip
