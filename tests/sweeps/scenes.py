"""Scenes: a stepper motor that loses steps under load, and a SmartMotor with a program."""

STEPPER = """
seed = 1
[[controller]]
model = "if2"
name = "table"
host = "go.if1"
[controller.axes.X]
limits = [-160, 24_000]
motor = { torque = [[0, 1.2], [4000, 0.7], [8000, 0.3]], inertia = 3e-5 }
load = { torque = 0.15, inertia = 6e-5 }
[[wire]]
from = "table.output1"
to = "table.input1"
delay_ms = 20
[[fault]]
kind = "jam"
on = "table.X"
name = "crash"
at = 90.0
duration = 0.1
[[script]]
at = 0.5
do = "input2 high"
"""
LINES = "X3000@5000S1$\nX-1500@5000R1$\n"
MOTOR = """
[[controller]]
model = "smartmotor"
name = "knife"
program = "knife.sms"
axes.shaft = { motor = "frame23", load = { inertia_kg_m2 = 2e-5 } }
"""
PROGRAM = "'KP=1 in a comment\nUCI UDI ZS\nKP=60\nKD=700 F\nA=300 V=400000 P=a G\nTWAIT\nUC=1 UCO\nEND\n"


def stepper(directory):
    (directory / "go.if1").write_text(LINES)
    (directory / "scene.toml").write_text(STEPPER)
    return directory / "scene.toml"


def motor(directory):
    (directory / "knife.sms").write_text(PROGRAM)
    (directory / "motor.toml").write_text(MOTOR)
    return directory / "motor.toml"
