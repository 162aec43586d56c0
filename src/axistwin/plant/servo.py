"""Data sheets of servo motors with their amplifier and encoder, and of their loads.

The presets have typical figures of small brushless servo motors of these sizes.  The figures can be changed one by one.
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields, replace
from math import isfinite, pi
from typing import Any

from axistwin.core.errors import UsageError
from axistwin.core.numbers import check_values

MOST = 1e6  # Upper limit of all figures of a data sheet.
TUNING = "kp", "ki", "kd", "kl", "ks", "kv", "ka", "kg"
MOST_TUNING = 65535


@dataclass(frozen=True)
class ServoMotor:
    """Data sheet of a brushless servo motor with its amplifier, encoder and tuning.

    All figures are at the shaft.  Figures are above 0, except frictions, brake, inductance and tuning, which may be 0;
    `counts_per_rev` is 2000 or 4000.  The back-EMF in V per rad/s equals the torque constant in N·m per A.  Inductance
    divided by resistance is the windings' time constant, 0.5 to 2 ms in motors of these sizes.
    """

    torque_constant_nm_per_a: float
    winding_resistance_ohm: float
    rotor_inertia_kg_m2: float
    coulomb_friction_nm: float
    viscous_friction_nm_s: float  # The unit of viscous friction is N·m per rad/s.
    counts_per_rev: int  # after quadrature
    supply_voltage_v: float
    peak_current_a: float  # Amplifier limit.
    continuous_current_a: float  # RMS
    winding_to_housing_k_per_w: float
    housing_to_ambient_k_per_w: float
    winding_time_constant_s: float
    housing_time_constant_s: float
    brake_torque_nm: float
    winding_inductance_h: float = 0.0  # Without inductance, the motor current follows the voltage at once.
    kp: int = 42
    ki: int = 28
    kd: int = 550
    kl: int = 15
    ks: int = 1
    kv: int = 0
    ka: int = 0
    kg: int = 0

    def __post_init__(self) -> None:
        for name, value in asdict(self).items():
            low = 0.0 if name in TUNING or any(part in name for part in MAY_BE_0) else None
            _check(f"motor {name}", value, low, MOST_TUNING if name in TUNING else MOST, whole=name in WHOLE)
        if self.counts_per_rev not in (2000, 4000):
            raise UsageError(f"invalid counts_per_rev={self.counts_per_rev} of a motor: expected 2000 or 4000")
        _check("motor ks", self.ks, 1.0, MOST_TUNING)

    @property
    def tuning(self) -> tuple[int, ...]:
        """Factory settings of the servo gains KP, KI, KD, KL, KS, KV, KA and KG."""
        return tuple(getattr(self, name) for name in TUNING)

    @property
    def counts_per_radian(self) -> float:
        return self.counts_per_rev / (2 * pi)


WHOLE = ("counts_per_rev", *TUNING)
MAY_BE_0 = "friction", "brake", "inductance"


@dataclass(frozen=True)
class ServoLoad:
    """The load on the shaft.  `gravity_torque_nm` is constant; positive turns the shaft in the positive direction."""

    inertia_kg_m2: float = 0.0
    coulomb_friction_nm: float = 0.0
    viscous_friction_nm_s: float = 0.0  # per rad/s
    gravity_torque_nm: float = 0.0

    def __post_init__(self) -> None:
        for name, value in asdict(self).items():
            _check(f"load {name}", value, -MOST if name == "gravity_torque_nm" else 0.0, MOST)


def _check(parameter: str, value: object, low: float | None, high: float, whole: bool = False) -> None:
    """Raise UsageError unless a value is from `low` (None: above 0) to `high`; `whole`: a whole number."""
    check_values(value)
    kinds = int if whole else (int, float)
    if isinstance(value, bool) or not isinstance(value, kinds) or not isfinite(value):
        raise UsageError(f"invalid {parameter}={value!r}: expected {'a whole number' if whole else 'a number'}")
    if value > high or (value <= 0 if low is None else value < low):
        lowest = "above 0" if low is None else f"{low:g}"
        raise UsageError(f"invalid {parameter}={value!r}: expected a number from {lowest} to {high:g}")


FRAME17 = ServoMotor(
    torque_constant_nm_per_a=0.036, winding_resistance_ohm=2.5, rotor_inertia_kg_m2=4.0e-6, coulomb_friction_nm=0.004,
    viscous_friction_nm_s=2.0e-6, counts_per_rev=2000, supply_voltage_v=24.0, peak_current_a=6.0,
    continuous_current_a=2.0, winding_to_housing_k_per_w=1.5, housing_to_ambient_k_per_w=4.0,
    winding_time_constant_s=20.0, housing_time_constant_s=900.0, brake_torque_nm=0.3, kl=40,
)  # fmt: skip
FRAME23 = ServoMotor(
    torque_constant_nm_per_a=0.075, winding_resistance_ohm=0.7, rotor_inertia_kg_m2=1.6e-5, coulomb_friction_nm=0.012,
    viscous_friction_nm_s=1.0e-5, counts_per_rev=2000, supply_voltage_v=48.0, peak_current_a=14.0,
    continuous_current_a=4.5, winding_to_housing_k_per_w=1.0, housing_to_ambient_k_per_w=2.8,
    winding_time_constant_s=30.0, housing_time_constant_s=1200.0, brake_torque_nm=1.0,
)  # fmt: skip
FRAME34 = ServoMotor(
    torque_constant_nm_per_a=0.125, winding_resistance_ohm=0.35, rotor_inertia_kg_m2=1.2e-4, coulomb_friction_nm=0.03,
    viscous_friction_nm_s=5.0e-5, counts_per_rev=4000, supply_voltage_v=48.0, peak_current_a=24.0,
    continuous_current_a=8.0, winding_to_housing_k_per_w=0.6, housing_to_ambient_k_per_w=1.8,
    winding_time_constant_s=50.0, housing_time_constant_s=1800.0, brake_torque_nm=3.0,
)  # fmt: skip
SERVO_MOTORS = {"frame17": FRAME17, "frame23": FRAME23, "frame34": FRAME34}


def servo_motor(given: object) -> ServoMotor:
    """Return a servo motor's data by name or table; parameters left out are those of `model` (frame23)."""
    if isinstance(given, ServoMotor):
        return given
    values: dict[str, Any] = dict(given) if isinstance(given, Mapping) else {"model": given}
    model = values.pop("model", "frame23")
    if not isinstance(model, str) or model not in SERVO_MOTORS:
        raise UsageError(
            f"unknown motor {model!r}: expected one of {', '.join(SERVO_MOTORS)}, or a table of parameters"
        )
    _check_names("motor", values, ("model", *(field.name for field in fields(ServoMotor))))
    return replace(SERVO_MOTORS[model], **values) if values else SERVO_MOTORS[model]


def servo_load(given: object = None) -> ServoLoad:
    """Return the load from a table, e.g. `{"inertia_kg_m2": 1e-5}`; None: no load."""
    if isinstance(given, ServoLoad):
        return given
    if given is not None and not isinstance(given, Mapping):
        raise UsageError(f"invalid load {given!r}: expected a table of parameters, e.g. {{ inertia_kg_m2 = 1e-5 }}")
    values = dict(given or {})
    _check_names("load", values, tuple(field.name for field in fields(ServoLoad)))
    return ServoLoad(**values)


def _check_names(part: str, given: Mapping[str, object], known: tuple[str, ...]) -> None:
    for name in given:
        if name not in known:
            raise UsageError(f"unknown parameter {name!r} of the {part}: expected one of {', '.join(known)}")
