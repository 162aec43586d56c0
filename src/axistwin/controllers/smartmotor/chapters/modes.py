"""Modes of operation, and the commands of motion (chapters 4 and 5 of the base language, 9 and 10 of the manual)."""

from axistwin.controllers.smartmotor.chapters import host_mode
from axistwin.controllers.smartmotor.chapters.brakes import switch_off
from axistwin.controllers.smartmotor.chapters.faults import may_move
from axistwin.controllers.smartmotor.kernel import state as s
from axistwin.controllers.smartmotor.kernel.cam import RELATIVE_CAM, TABLE_MOST, invalidate, take_over
from axistwin.controllers.smartmotor.kernel.position import position as position_of_shaft
from axistwin.controllers.smartmotor.kernel.servo_law import clear_integral
from axistwin.controllers.smartmotor.processor import Control, Processor

PID_RATES = (1, 2, 4, 8)
RATIOS = (s.M_RATIO, s.M_STEP_RATIO)
FULL = 4  # Counted edges per encoder period of four, for MF4 and for steps.


def parameter(motor: Processor, value: int, *, slot: int, low: int, high: int) -> None:
    """Set a motion parameter or a cam parameter, e.g. the velocity V.

    A value outside the range does not change the parameter, but sets the flag Bs (syntax error).  BASE= and SIZE=
    invalidate an earlier CI (manual, section 9.5).
    """
    if not low <= value <= high:
        motor.syntax_error(f"{value} is out of range: expected {low} to {high}")
        return
    motor.i[slot] = value
    if slot in (s.BASE, s.SIZE):
        invalidate(motor.i)


def position(motor: Processor, value: int) -> None:
    """P=exp, record FEh: the absolute target of mode MP in counts; the next G is an absolute move."""
    motor.i[s.P] = value
    motor.i[s.RELATIVE] = 0
    _buffer_position(motor)


def distance(motor: Processor, value: int) -> None:
    """D=exp: set the distance of a relative move, in counts.

    The next G in mode MP is then a relative move.  In cam mode, D is the dwell: the motor stays at the last cam
    position while the master moves by D counts.  The dwell takes effect after CI (manual, section 9.3).
    """
    motor.i[s.D] = value
    motor.i[s.RELATIVE] = 1
    invalidate(motor.i)
    _buffer_position(motor)


def clock(motor: Processor, value: int) -> None:
    """CLK=exp: set the counter of samples."""
    motor.i[s.CLK_ZERO] = motor.i[s.SAMPLE] - value


def origin(motor: Processor, value: int) -> None:
    """O=exp: give the present shaft position a new value, in counts; the shaft does not move.

    SLN and SLP keep their values (manual, section 3.2).
    """
    i = motor.i
    shift = value - position_of_shaft(i)
    i[s.ORIGIN] += shift
    i[s.COMMANDED] += shift << 16
    i[s.CAM_ORIGIN] += shift
    if i[s.MODE] == s.M_POSITION:
        i[s.TARGET] += shift


def tune(motor: Processor) -> None:
    """F: put the buffered KP, KI, KD, KL, KS, KV, KA and KG in force."""
    motor.i[s.TUNING : s.TUNING + 8] = motor.i[s.KP : s.KP + 8]


def pid(motor: Processor, rate: int) -> None:
    """PIDn: compute the trajectory and the servo law only in every n-th sample; n is 1, 2, 4 or 8.

    The time unit of V, A and WAIT is then n samples.  Other values set Bs.
    """
    if rate in PID_RATES:
        motor.i[s.PID_RATE] = rate
    else:
        motor.syntax_error("no such rate: expected PID1, PID2, PID4 or PID8")


def buffer(motor: Processor, mode: int, factor: int = 0) -> None:
    """MP, MV, MFR, MSR, MD: select the mode that the next G starts.

    MFR and MSR use the present MFMUL/MFDIV; MFDIV=0 sets Bs.  MD empties the buffer of points (manual, section 10.1).
    """
    i = motor.i
    if mode == s.M_HOST:
        # Outside host mode, the command MD deletes all positions that the host has sent.
        if i[s.MODE] != s.M_HOST:
            host_mode.clear(motor)
        # At the end of host mode, the motor enters the mode that is stored in BUFFERED_MODE (manual, section 10.2).
        i[s.HOST_ARMED], i[s.HOST_FLAGS] = 1, 0
        return
    if mode in RATIOS:
        if i[s.MFDIV] == 0:
            motor.syntax_error("MFDIV is 0: set it first, e.g. MFDIV=1")
            return
        i[s.RATIO_MUL], i[s.RATIO_DIV] = i[s.MFMUL], i[s.MFDIV]
    i[s.BUFFERED_MODE], i[s.BUFFERED_FACTOR], i[s.HOST_ARMED], i[s.AFTER_STOP] = mode, factor, 0, 0


def cam(motor: Processor, factor: int) -> None:
    """MC, MC2, MC4, MC8: select cam mode, which the next command G starts (manual, chapter 9).

    If cam mode is in progress, CI makes the new cam effective at the next zero point of the cam.

    MCn uses the present BASE and SIZE.  SIZE is the highest index of the table, up to 101.  BASE counts are divided
    among SIZE intervals, so BASE is at least SIZE.  Otherwise Bs is set and nothing changes.
    """
    i = motor.i
    if not 1 <= i[s.SIZE] <= TABLE_MOST or i[s.BASE] < i[s.SIZE]:
        motor.syntax_error(f"expected SIZE from 1 to {TABLE_MOST}, and BASE at least SIZE: set them first")
        return
    i[s.MC_BASE], i[s.MC_SIZE], i[s.MC_FACTOR] = i[s.BASE], i[s.SIZE], factor
    i[s.CI_PENDING] = i[s.CI_SPOILT] = 0
    buffer(motor, s.M_CAM, factor)


def initialize_cam(motor: Processor) -> None:
    """CI: at the next zero point, put the buffered D, BASE, SIZE, MCn, F=16 and F=128 in force (9.5).

    After a CI has become invalid, "a new MCn and CI command must be issued".
    """
    motor.i[s.CI_PENDING] = not motor.i[s.CI_SPOILT]


def go(motor: Processor) -> None:
    """G: start or change a motion with the buffered settings, e.g. MV and V=1000.  An uncleared fault inhibits G."""
    i = motor.i
    mode = s.M_HOST if i[s.HOST_ARMED] else i[s.BUFFERED_MODE]
    if not may_move(motor, way(motor, mode)):
        return
    i[s.HOST_ARMED] = i[s.AFTER_STOP] = 0
    if mode == s.M_HOST:
        turn_on(motor, s.M_HOST)
    else:
        start(motor, mode)


def way(motor: Processor, mode: int) -> int:
    """Return the direction in which a mode would move the motor: positive, negative or unknown (0)."""
    i = motor.i
    if mode == s.M_POSITION:
        return i[s.D] if i[s.RELATIVE] else i[s.P] - (i[s.COMMANDED] >> 16)
    if mode == s.M_VELOCITY:
        return i[s.V]
    return i[s.T] if mode == s.M_TORQUE else 0


def start(motor: Processor, mode: int) -> None:
    """Start a mode with the buffered parameters, from the present commanded position and velocity."""
    i = motor.i
    i[s.ACCELERATION] = i[s.A]
    if mode == s.M_POSITION:
        i[s.TARGET] = (i[s.COMMANDED] >> 16) + i[s.D] if i[s.RELATIVE] else i[s.P]
        i[s.MAX_VELOCITY], i[s.FACTOR] = abs(i[s.V]), i[s.RELATIVE]
    elif mode == s.M_VELOCITY:
        i[s.MAX_VELOCITY] = i[s.V]
    elif mode in RATIOS:
        sign = -1 if i[s.RATIO_DIV] < 0 else 1
        i[s.FACTOR], i[s.TARGET], i[s.FOLLOW_REM] = sign * i[s.RATIO_MUL], sign * i[s.RATIO_DIV], 0
    elif mode == s.M_CAM:
        _begin_cam(motor)
    elif mode in (s.M_FOLLOW, s.M_STEP):
        _count(motor, i[s.BUFFERED_FACTOR], steps=mode == s.M_STEP)
    turn_on(motor, mode)


def turn_on(motor: Processor, mode: int) -> None:
    """Switch the amplifier on and enter the given mode.  The flag Bt then reports a trajectory in progress."""
    i = motor.i
    if i[s.BO] or i[s.MODE] in (s.M_TORQUE, s.M_BRAKE):
        i[s.COMMANDED] = position_of_shaft(i) << 16
        i[s.VELOCITY] = 0
        clear_integral(i)
    i[s.MODE], i[s.BO], i[s.STOPPING] = mode, 0, 0
    i[s.BT] = 0 if mode in (s.M_TORQUE, s.M_HOLD) else 1


def _begin_cam(motor: Processor) -> None:
    i = motor.i
    take_over(i)
    counts = i[s.CTR] * (1 if i[s.CAM_TABLE] else i[s.CAM_FACTOR])
    i[s.CAM_PHASE] = counts % (i[s.CAM_BASE] + i[s.CAM_DWELL])
    here = i[s.COMMANDED] >> 16 if not i[s.BO] else position_of_shaft(i)
    i[s.CAM_ORIGIN] = here if i[s.CAM_F] & RELATIVE_CAM else 0


def may_stop(motor: Processor) -> bool:
    """True if S and X act now: a fault inhibits them, except while moving away from a limit (3.2)."""
    i = motor.i
    leaving = i[s.VELOCITY] != 0 and not (i[s.STOPPING] or i[s.BE] or i[s.BH])
    return not i[s.BO] and i[s.MODE] != s.M_BRAKE and (leaving or may_move(motor, 0))


def stop(motor: Processor) -> None:
    """S: stop the trajectory at once and hold the position.

    The next G is a position move if P= or D= is assigned first (option `stop_buffers`).  Without effect while the motor
    is off.
    """
    i = motor.i
    if may_stop(motor):
        turn_on(motor, s.M_HOLD)
        i[s.VELOCITY] = 0
        _stopped(motor)


def decelerate(motor: Processor) -> None:
    """X: decelerate to a stop with the acceleration A, then hold the position.

    The next G is a position move if P= or D= is assigned first (option `stop_buffers`).  Without effect while the motor
    is off.
    """
    i = motor.i
    if may_stop(motor):
        turn_on(motor, s.M_STOP if i[s.VELOCITY] else s.M_HOLD)
        i[s.ACCELERATION] = i[s.A]
        _stopped(motor)


def _stopped(motor: Processor) -> None:
    motor.i[s.AFTER_STOP] = motor.options.stop_buffers == "position"
    motor.i[s.HOST_ARMED] = 0


def _buffer_position(motor: Processor) -> None:
    if motor.i[s.AFTER_STOP]:
        motor.i[s.BUFFERED_MODE], motor.i[s.AFTER_STOP] = s.M_POSITION, 0


def torque(motor: Processor) -> None:
    """MT: enter torque mode at once.  T sets the PWM value, -1023 to 1023.  A fault that is not cleared inhibits MT."""
    if may_move(motor, motor.i[s.T]):
        motor.i[s.BUFFERED_MODE], motor.i[s.AFTER_STOP] = s.M_TORQUE, 0
        turn_on(motor, s.M_TORQUE)


def off(motor: Processor) -> None:
    """OFF: switch the amplifier off, and apply MTB; after BRKRLS, deactivate MTB instead (5.2)."""
    if motor.brake_control is Control.RELEASED:
        motor.mtb_enabled = False
    switch_off(motor)


def follow(motor: Processor, factor: int) -> None:
    """MF1, MF2, MF4: follow the external encoder, at 1, 2 or 4 counts per period; CTR becomes 0."""
    _follow(motor, s.M_FOLLOW, factor)


def step_and_direction(motor: Processor) -> None:
    """MS: follow the step pulses at pin A, and set CTR to 0.  The level of pin B gives the direction of the steps."""
    _follow(motor, s.M_STEP, FULL)


def _follow(motor: Processor, mode: int, factor: int) -> None:
    if may_move(motor, 0):
        buffer(motor, mode, factor)
        start(motor, mode)


def quadrature(motor: Processor) -> None:
    """MF0: pins A and B are the lines of an encoder; CTR begins at 0.  The mode does not change."""
    _count(motor, FULL, steps=False)


def count_steps(motor: Processor) -> None:
    """MS0: pins A and B are step and direction; CTR begins at 0.  The mode does not change."""
    _count(motor, FULL, steps=True)


def _count(motor: Processor, resolution: int, *, steps: bool) -> None:
    i = motor.i
    i[s.RESOLUTION], i[s.STEPS], i[s.CTR] = resolution, steps, 0
    motor.on_pin_use.emit()
    i[s.MASTER] = motor.edges()
    i[s.MASTER_SEEN] = i[s.MASTER] * resolution // FULL


def internal_encoder(_motor: Processor) -> None:
    """ENC0: use the encoder on the shaft for the servo loop: no effect, as the loop always does."""


def external_encoder(motor: Processor) -> None:
    """ENC1: set Bs, because the motor's shaft has no external encoder for the servo loop."""
    motor.syntax_error("no external encoder is mounted on the shaft: use ENC0")
