"""Modes of operation and what moves the motor (chapters 4 and 5 of the base language, 9 and 10 of the manual)."""

from typing import TYPE_CHECKING

from axistwin.controllers.smartmotor.chapters.brakes import Control, switch_off
from axistwin.controllers.smartmotor.chapters.faults import may_move
from axistwin.controllers.smartmotor.kernel import host_mode
from axistwin.controllers.smartmotor.kernel.cam import RELATIVE_CAM, TABLE_MOST, invalidate, take_over
from axistwin.controllers.smartmotor.kernel.interpreter import HIGHEST, LOWEST
from axistwin.controllers.smartmotor.kernel.position import position as position_of_shaft
from axistwin.controllers.smartmotor.kernel.servo_law import clear_integral
from axistwin.controllers.smartmotor.kernel.state import (
    BASE,
    BE,
    BH,
    BO,
    BT,
    BUFFERED_FACTOR,
    BUFFERED_MODE,
    CAM_BASE,
    CAM_DWELL,
    CAM_F,
    CAM_FACTOR,
    CAM_ORIGIN,
    CAM_PHASE,
    CAM_TABLE,
    CI_PENDING,
    CI_SPOILT,
    CLK_ZERO,
    COMMANDED,
    CTR,
    FACTOR,
    FOLLOW_REM,
    HOST_ARMED,
    KP,
    M_CAM,
    M_FOLLOW,
    M_HOLD,
    M_HOST,
    M_POSITION,
    M_RATIO,
    M_STEP,
    M_STEP_RATIO,
    M_STOP,
    M_TORQUE,
    M_VELOCITY,
    MASTER,
    MASTER_SEEN,
    MC_BASE,
    MC_FACTOR,
    MC_SIZE,
    MFDIV,
    MFMUL,
    MODE,
    ORIGIN,
    PID_RATE,
    RATE,
    RATIO_DIV,
    RATIO_MUL,
    RELATIVE,
    RESOLUTION,
    SAMPLE,
    SIZE,
    STEPS,
    STOPPING,
    TARGET,
    TOP,
    TUNING,
    VELOCITY,
    A,
    D,
    P,
    T,
    V,
)

if TYPE_CHECKING:
    from axistwin.controllers.smartmotor.motor import Motor

PID_RATES = (1, 2, 4, 8)
RATIOS = (M_RATIO, M_STEP_RATIO)
FULL = 4
"""Edges of four that count in MF4, and always with steps."""


# Parameters


def parameter(motor: "Motor", value: int, *, slot: int, low: int, high: int) -> None:
    """A parameter that is kept until something uses it; a value outside its range sets Bs and changes nothing.

    BASE= and SIZE= make a CI that was given already invalid (9.5).
    """
    if not low <= value <= high:
        motor.syntax_error()
        return
    motor.i[slot] = value
    if slot in (BASE, SIZE):
        invalidate(motor.i)


def position(motor: "Motor", value: int) -> None:
    """P=exp, FEh and four bytes: the absolute target of MP in counts; the next G is an absolute move."""
    motor.i[P] = value
    motor.i[RELATIVE] = 0


def velocity(motor: "Motor", value: int) -> None:
    """FDh and four bytes: V, in 1/65536 count per sample, as V=exp."""
    parameter(motor, value, slot=V, low=LOWEST, high=HIGHEST)


def acceleration(motor: "Motor", value: int) -> None:
    """FCh and four bytes: A, in 1/65536 count per sample², as A=exp; below 0: Bs, and A stays."""
    parameter(motor, value, slot=A, low=0, high=HIGHEST)


def distance(motor: "Motor", value: int) -> None:
    """D=exp: the distance of a relative move of MP, in counts; in mode cam the dwell, taken over by CI (9.3)."""
    motor.i[D] = value
    motor.i[RELATIVE] = 1
    invalidate(motor.i)


def clock(motor: "Motor", value: int) -> None:
    """CLK=exp: the counter of samples goes on from this value."""
    motor.i[CLK_ZERO] = motor.i[SAMPLE] - value


def origin(motor: "Motor", value: int) -> None:
    """O=exp: the shaft is now at this position, in counts.  Nothing moves; SLN and SLP keep their values (3.2)."""
    i = motor.i
    shift = value - position_of_shaft(i)
    i[ORIGIN] += shift
    i[COMMANDED] += shift << 16
    i[CAM_ORIGIN] += shift
    if i[MODE] == M_POSITION:
        i[TARGET] += shift


def tune(motor: "Motor") -> None:
    """F: the buffered KP, KI, KD, KL, KS, KV, KA and KG come into force."""
    motor.i[TUNING : TUNING + 8] = motor.i[KP : KP + 8]


def pid(motor: "Motor", rate: int) -> None:
    """PIDn: trajectory and servo law every 1, 2, 4 or 8 samples, in which V, A and WAIT are meant; else Bs is set."""
    if rate in PID_RATES:
        motor.i[PID_RATE] = rate
    else:
        motor.syntax_error()


# What G starts


def buffer(motor: "Motor", mode: int, factor: int = 0) -> None:
    """MP, MV, MFR, MSR, MD: the mode that the next G starts.

    MFR and MSR take the ratio as it is now; MFDIV=0 sets Bs.  MD empties the buffer of points (10.1).
    """
    i = motor.i
    if mode == M_HOST:
        if i[MODE] != M_HOST:  # what is being done is not thrown away
            host_mode.clear(motor)
        i[HOST_ARMED] = 1  # the mode buffered before is the one that host mode ends in (10.2)
        return
    if mode in RATIOS:
        if i[MFDIV] == 0:
            motor.syntax_error()
            return
        i[RATIO_MUL], i[RATIO_DIV] = i[MFMUL], i[MFDIV]
    i[BUFFERED_MODE], i[BUFFERED_FACTOR], i[HOST_ARMED] = mode, factor, 0


def cam(motor: "Motor", factor: int) -> None:
    """MC, MC2, MC4, MC8: mode cam at the next G, or with CI at the next zero point, with BASE and SIZE as they are now.

    SIZE is the highest index of the table, up to 101; BASE counts are divided among SIZE intervals, so it is not less.
    Otherwise Bs is set and nothing changes.  Chapter 9.
    """
    i = motor.i
    if not 1 <= i[SIZE] <= TABLE_MOST or i[BASE] < i[SIZE]:
        motor.syntax_error()
        return
    i[MC_BASE], i[MC_SIZE], i[MC_FACTOR] = i[BASE], i[SIZE], factor
    i[CI_PENDING] = i[CI_SPOILT] = 0
    buffer(motor, M_CAM, factor)


def initialize_cam(motor: "Motor") -> None:
    """CI: at the next zero point the buffered D, BASE, SIZE, MCn, F=16 and F=128 replace those in force (9.5).

    If a CI has become invalid, "a new MCn and CI command must be issued".
    """
    motor.i[CI_PENDING] = not motor.i[CI_SPOILT]


# What acts at once


def go(motor: "Motor") -> None:
    """G: start, or go on with, the buffered mode and parameters.  Inhibited by a fault that has not been cleared."""
    i = motor.i
    mode = M_HOST if i[HOST_ARMED] else i[BUFFERED_MODE]
    if not may_move(motor, way(motor, mode)):
        return
    i[HOST_ARMED] = 0
    if mode == M_HOST:
        turn_on(motor, M_HOST)
    else:
        start(motor, mode)


def way(motor: "Motor", mode: int) -> int:
    """In which direction a mode would move the motor: positive, negative or unknown (0)."""
    i = motor.i
    if mode == M_POSITION:
        return i[D] if i[RELATIVE] else i[P] - (i[COMMANDED] >> 16)
    if mode == M_VELOCITY:
        return i[V]
    return i[T] if mode == M_TORQUE else 0


def start(motor: "Motor", mode: int) -> None:
    """The mode begins with the buffered parameters, from the present commanded position and velocity."""
    i = motor.i
    i[RATE] = i[A]
    if mode == M_POSITION:
        i[TARGET] = (i[COMMANDED] >> 16) + i[D] if i[RELATIVE] else i[P]
        i[TOP], i[FACTOR] = abs(i[V]), i[RELATIVE]
    elif mode == M_VELOCITY:
        i[TOP] = i[V]
    elif mode in RATIOS:
        sign = -1 if i[RATIO_DIV] < 0 else 1
        i[FACTOR], i[TARGET], i[FOLLOW_REM] = sign * i[RATIO_MUL], sign * i[RATIO_DIV], 0
    elif mode == M_CAM:
        _begin_cam(motor)
    elif mode in (M_FOLLOW, M_STEP):
        _count(motor, i[BUFFERED_FACTOR], steps=mode == M_STEP)
    turn_on(motor, mode)


def turn_on(motor: "Motor", mode: int) -> None:
    """The amplifier is on, in this mode, with a trajectory in progress."""
    i = motor.i
    if i[BO] or i[MODE] == M_TORQUE:
        i[COMMANDED] = position_of_shaft(i) << 16
        i[VELOCITY] = 0
        clear_integral(i)
    i[MODE], i[BO], i[STOPPING] = mode, 0, 0
    i[BT] = 0 if mode in (M_TORQUE, M_HOLD) else 1


def _begin_cam(motor: "Motor") -> None:
    """The cycle begins where the external encoder's counter says; F=16: relative to where the motor is (9.4)."""
    i = motor.i
    take_over(i)
    counts = i[CTR] * (1 if i[CAM_TABLE] else i[CAM_FACTOR])
    i[CAM_PHASE] = counts % (i[CAM_BASE] + i[CAM_DWELL])
    here = i[COMMANDED] >> 16 if not i[BO] else position_of_shaft(i)
    i[CAM_ORIGIN] = here if i[CAM_F] & RELATIVE_CAM else 0


def may_stop(motor: "Motor") -> bool:
    """S and X are inhibited by a fault as G is (3.2), unless the motor moves away from a limit: that can be stopped."""
    i = motor.i
    leaving = i[VELOCITY] != 0 and not (i[STOPPING] or i[BE] or i[BH])
    return not i[BO] and (leaving or may_move(motor, 0))


def stop(motor: "Motor") -> None:
    """S: the trajectory stops at once and the servo holds; the next G is a position move (option `stop_buffers`).

    Without effect while the motor is off.
    """
    i = motor.i
    if may_stop(motor):
        turn_on(motor, M_HOLD)
        i[VELOCITY] = 0
        _buffer_position(motor)


def decelerate(motor: "Motor") -> None:
    """X: decelerate to a stop at A, then hold; the next G is a position move (option `stop_buffers`).

    Without effect while the motor is off.
    """
    i = motor.i
    if may_stop(motor):
        turn_on(motor, M_STOP if i[VELOCITY] else M_HOLD)
        i[RATE] = i[A]
        _buffer_position(motor)


def _buffer_position(motor: "Motor") -> None:
    """Make the next G a position move, absolute or relative by what was assigned last, P or D."""
    if motor.options.stop_buffers == "position":
        buffer(motor, M_POSITION)


def torque(motor: "Motor") -> None:
    """MT: mode torque at once: PWM by T, -1023 to 1023.  Inhibited by a fault that has not been cleared."""
    if may_move(motor, motor.i[T]):
        motor.i[BUFFERED_MODE] = M_TORQUE
        turn_on(motor, M_TORQUE)


def off(motor: "Motor") -> None:
    """OFF: the amplifier is off.  After BRKRLS that deactivates MTB; otherwise MTB follows (5.2)."""
    if motor.brake_control is Control.RELEASED:
        motor.mtb_enabled = False
    switch_off(motor)


def follow(motor: "Motor", factor: int) -> None:
    """MF1, MF2, MF4: follow the external encoder at once, with 1, 2 or 4 of its four edges; CTR begins at 0."""
    _follow(motor, M_FOLLOW, factor)


def step_and_direction(motor: "Motor") -> None:
    """MS: follow steps (pin A) in the direction of pin B, at once; CTR begins at 0."""
    _follow(motor, M_STEP, FULL)


def _follow(motor: "Motor", mode: int, factor: int) -> None:
    if may_move(motor, 0):
        buffer(motor, mode, factor)
        start(motor, mode)


def quadrature(motor: "Motor") -> None:
    """MF0: pins A and B are an encoder's; CTR begins at 0.  The mode stays."""
    _count(motor, FULL, steps=False)


def count_steps(motor: "Motor") -> None:
    """MS0: pins A and B are step and direction; CTR begins at 0.  The mode stays."""
    _count(motor, FULL, steps=True)


def _count(motor: "Motor", resolution: int, *, steps: bool) -> None:
    i = motor.i
    i[RESOLUTION], i[STEPS], i[CTR] = resolution, steps, 0
    i[MASTER] = motor.edges()
    i[MASTER_SEEN] = i[MASTER] * resolution // FULL


def internal_encoder(_motor: "Motor") -> None:
    """ENC0: the servo is closed by the encoder on the shaft.  It always is, so nothing changes."""


def external_encoder(motor: "Motor") -> None:
    """ENC1: the servo is closed by an encoder on pins A and B.  There is none on the shaft of this motor: Bs is set."""
    motor.syntax_error()
