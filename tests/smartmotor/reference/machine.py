"""Independent reference of a servo motor: `servo.py` and `servo_law.py` must give bit-identical results.

Objects replace arrays, and amperes and torques replace slots; only the order of the floating point operations is the
same as in the original.
"""

from dataclasses import dataclass, field
from math import exp, floor, pi

SAMPLE_S = 245_760e-9
OPEN, SHORTED, ON = range(3)


@dataclass
class ReferenceMachine:
    """Motor, amplifier, load."""

    motor: object
    load: object
    torque_nm: float = 0.0
    jammed: bool = False
    brake: bool = False
    ambient: float = 25.0
    shaft: int = 0
    fraction: float = 0.0
    speed: float = 0.0  # counts per sample
    over_current: bool = False
    current: "Current" = field(default_factory=lambda: Current())

    def __post_init__(self):
        motor, load = self.motor, self.load
        inertia = motor.rotor_inertia_kg_m2 + load.inertia_kg_m2
        counts_per_radian = motor.counts_per_rev / (2 * pi)
        self.per_nm = SAMPLE_S**2 * counts_per_radian / inertia
        self.per_amp = motor.torque_constant_nm_per_a * self.per_nm
        self.viscous = (motor.viscous_friction_nm_s + load.viscous_friction_nm_s) * SAMPLE_S / inertia
        self.amps = 0.0  # at the end of the last sample
        self.remains = self.mean_remains = 0.0
        if inductance := motor.winding_inductance_h:
            in_time_constants = SAMPLE_S * motor.winding_resistance_ohm / inductance
            self.remains = exp(-in_time_constants)
            self.mean_remains = (1 - self.remains) / in_time_constants
        self.amps_per_pwm = motor.supply_voltage_v / 1023 / motor.winding_resistance_ohm
        back_emf = motor.torque_constant_nm_per_a / (SAMPLE_S * counts_per_radian)
        self.amps_per_speed = back_emf / motor.winding_resistance_ohm
        self.temperatures = Temperatures(motor)

    def turn(self, drive, pwm):
        """Compute one sample."""
        before = self.speed
        push = before + (self.torque_nm + self.load.gravity_torque_nm) * self.per_nm
        open_gain = 1 / (1 + self.viscous)
        amps, after, limited, peak = 0.0, 0.0, False, self.motor.peak_current_a
        if drive != OPEN:
            stall_amps = pwm * self.amps_per_pwm if drive == ON else 0.0
            share = 1 - self.mean_remains
            mean = self.mean_remains * self.amps + share * stall_amps
            closed_gain = 1 / (1 + self.viscous + self.per_amp * self.amps_per_speed * share)
            self.speed = self._after_friction(push + mean * self.per_amp) * closed_gain
            amps = mean - self.speed * self.amps_per_speed * share
            limited = drive == ON and abs(amps) > peak
            after = self.remains * self.amps + (1 - self.remains) * (stall_amps - self.speed * self.amps_per_speed)
            after = max(-peak, min(peak, after)) if abs(after) >= 1e-9 else 0.0
        if limited:
            self.over_current = True
            amps = after = peak * (1 if amps > 0 else -1)
        if limited or drive == OPEN:
            self.speed = self._after_friction(push + amps * self.per_amp) * open_gain
        self.amps = after
        self._move(before)
        if self.current.flows(amps):
            self.temperatures.warm(self.current.take_square(), self.ambient)

    def _after_friction(self, push):
        if self.jammed:
            return 0.0
        friction = (self.motor.coulomb_friction_nm + self.load.coulomb_friction_nm) * self.per_nm
        if self.brake:
            friction += self.motor.brake_torque_nm * self.per_nm
        if abs(push) <= friction:
            return 0.0
        return push - friction if push > 0 else push + friction

    def _move(self, before):
        place = self.fraction + self.speed + self.mean_remains / 2 * (before - self.speed)
        self.shaft += floor(place)
        self.fraction = place - floor(place)


@dataclass
class Current:
    """The measured current, in 0.01 A."""

    filtered: int = 0
    squares: list = field(default_factory=list)

    def flows(self, amps):
        """Measure the current of a sample; return True after 256 samples."""
        centiamps = min(int(abs(amps) * 100.0), 100_000)
        self.filtered += centiamps - self.filtered // 16
        self.squares.append(centiamps**2)
        return len(self.squares) == 256

    def take_square(self):
        """Return the mean square of the last 256 samples, A²."""
        mean = sum(self.squares) * (1e-4 / 256)
        self.squares.clear()
        return mean


class Temperatures:
    """Winding, housing, and the RMS current."""

    def __init__(self, motor):
        self.motor = motor
        self.winding = self.housing = 25.0
        self.mean_square = 0.0
        self.overload, self.hot = 0, False

    def warm(self, square, ambient):
        """Update the temperatures by the flow of heat at the end of 256 samples."""
        motor, block_s = self.motor, 256 * SAMPLE_S
        rise = square * (motor.winding_resistance_ohm * motor.winding_to_housing_k_per_w)
        self.winding += (self.housing + rise - self.winding) * (block_s / (block_s + motor.winding_time_constant_s))
        to_air = block_s / motor.housing_time_constant_s
        from_winding = to_air * motor.housing_to_ambient_k_per_w / motor.winding_to_housing_k_per_w
        total = 1 + from_winding + to_air
        inwards = (self.winding - self.housing) * (from_winding / total)
        self.housing += inwards + (ambient - self.housing) * (to_air / total)
        self.mean_square += (square - self.mean_square) * (block_s / 1.0)

    def overloaded(self, limit, patience):
        """True if the motor has been too hot, or its current too high, for `patience` samples."""
        rated = self.mean_square <= self.motor.continuous_current_a**2
        if self.hot and rated and floor(self.housing) <= limit - 5:
            self.hot, self.overload = False, 0
        if not self.hot:
            fine = rated and floor(self.housing) <= limit
            self.overload = 0 if fine else self.overload + 1
            self.hot = not fine and self.overload >= patience
        return self.hot


@dataclass
class ReferenceServo:
    """The servo law, from errors in the controller's direction to PWM in the machine's direction."""

    tuning: tuple = (42, 28, 550, 15, 1, 0, 0, 0)
    rate: int = 1
    amps: int = 1023
    direction: int = 1
    integral: int = 0
    error_before: int = 0
    difference: int = 0
    velocity_before: int = 0
    pwm: int = 0

    def off(self):
        """Switch the drive off and clear the memory of the servo law."""
        self.integral = self.error_before = self.difference = self.pwm = 0

    def torque(self, value):
        """Set PWM in torque mode, within AMPS."""
        self.pwm = self.direction * max(-self.amps, min(self.amps, value))

    def follow(self, sample, error, velocity):
        """Run the PID in every sample whose number is a multiple of `rate`."""
        if sample % self.rate:
            return
        kp, ki, kd, kl, ks, kv, ka, kg = self.tuning
        self.integral = max(-kl * 8192, min(kl * 8192, self.integral + ki * error))
        if sample // self.rate % max(ks, 1) == 0:
            self.difference, self.error_before = error - self.error_before, error
        speed, before = (max(-(2**32), min(2**32, value)) for value in (velocity, self.velocity_before))
        forward = (kv * speed + ka * (speed - before)) // 65536
        sixteenths = kp * error + self.integral // 128 + kd * self.difference + kg + forward
        self.torque((sixteenths + 8) // 16)
        self.velocity_before = velocity
