"""Fault handling (chapter 4): limits, position error, overheat, and how they are cleared."""

from typing import TYPE_CHECKING

from axistwin.controllers.smartmotor.chapters import flow
from axistwin.controllers.smartmotor.chapters.brakes import switch_off
from axistwin.controllers.smartmotor.chapters.functions import CALL_C1, DECELERATE
from axistwin.controllers.smartmotor.kernel.kernel import ERROR, HEAT, MINUS, PLUS, heading
from axistwin.controllers.smartmotor.kernel.state import (
    ACKNOWLEDGED_MINUS,
    ACKNOWLEDGED_PLUS,
    BA,
    BB,
    BC,
    BD,
    BE,
    BF,
    BH,
    BI,
    BL,
    BM,
    BP,
    BR,
    BS,
    BT,
    BU,
    BW,
    CALL_FAULT,
    FAULT_AGAIN,
    HOT,
    M_ERROR,
    M_HOLD,
    M_OFF,
    M_STOP,
    M_TORQUE,
    MODE,
    PENDING,
    RATE,
    STOPPING,
    VELOCITY,
    A,
    F,
)

if TYPE_CHECKING:
    from axistwin.controllers.smartmotor.motor import Motor

LIMITS = ((PLUS, BR, BP, ACKNOWLEDGED_PLUS, 1), (MINUS, BL, BM, ACKNOWLEDGED_MINUS, -1))
"""The kernel's reason, the historical and the real-time flag, the acknowledgement, the direction."""
LATCHED = (BR, BL, BI, BW, BE, BH, BD, BU, BS, BA, BB, BC, BF)
"""What ZS clears.  Bk tells of the stored program and goes when that is whole again."""
OPEN_SWITCHES = (
    "in a limit fault, as pins C and D are not held low: give the shaft limits, or UCI UDI ZS at the top of the program"
)
ALARMS = {BR: "Br", BL: "Bl", BE: "Be", BH: "Bh"}
"""What is told of the flags, to those who want to know."""
FAULT_1 = 1
"""The label that a fault calls with F=32."""


# A fault happens


def happen(motor: "Motor", why: int) -> None:
    """What follows from the faults that the kernel has found in this sample (4.1)."""
    for reason, flag, _, acknowledged, sign in LIMITS:
        if why & reason:
            _limit(motor, flag, acknowledged, sign)
    for reason, flag in ((ERROR, BE), (HEAT, BH)):
        if why & reason:
            motor.i[flag] = 1
            motor.on_fault(ALARMS[flag])
            shut_down(motor, M_ERROR)
            _interrupt(motor, ends_program=True)


def _limit(motor: "Motor", flag: int, acknowledged: int, sign: int) -> None:
    """A limit is asserted, in hard- or software.  It stops the motor unless that moves away from it (3.1)."""
    i = motor.i
    i[flag] = 1
    motor.on_fault(ALARMS[flag])
    on_its_way = heading(i) * sign
    if i[acknowledged] and on_its_way <= 0:
        return
    i[acknowledged] = 0
    if on_its_way >= 0:
        shut_down(motor, M_OFF)
    _interrupt(motor, ends_program=False)


def shut_down(motor: "Motor", mode: int) -> None:
    """Amplifier off, or with F=1 decelerate at A first; then MTB, if that has not been deactivated (4.1)."""
    i = motor.i
    if i[MODE] < M_HOLD or not i[F] & DECELERATE or i[MODE] == M_TORQUE:
        switch_off(motor, mode)
    elif i[VELOCITY] == 0 or i[A] == 0:
        i[VELOCITY] = 0
        stopped(motor)
    else:
        i[MODE], i[RATE], i[STOPPING], i[BT] = M_STOP, i[A], 1, 1


def stopped(motor: "Motor") -> None:
    """The motor has decelerated because of a fault: MTB, or without it hold the position (table 4.2)."""
    i = motor.i
    i[STOPPING] = i[BT] = 0
    i[MODE] = M_HOLD
    if motor.mtb_enabled:
        switch_off(motor)


def _interrupt(motor: "Motor", *, ends_program: bool) -> None:
    """F=32: C1 is called at the end of the statement in progress; without it a motor protection fault ends the program.

    C1 is called also when the main program has ended, as the sample of 4.3 does.  A fault within C1 waits until that
    has returned.
    """
    i = motor.i
    if i[F] & CALL_C1 and FAULT_1 in motor.program.labels:
        if flow.within(motor, CALL_FAULT):
            i[FAULT_AGAIN] = 1
        else:
            i[PENDING] |= CALL_FAULT
    elif ends_program:
        flow.end(motor)


# What a fault forbids


def faulted(motor: "Motor") -> bool:
    """Whether a fault of table 4.1 has not been cleared."""
    i = motor.i
    return bool(i[BR] or i[BL] or i[BE] or i[BH])


def may_move(motor: "Motor", way: int) -> bool:
    """Whether a movement may begin, in this direction (0: unknown, or none).

    A limit that is still asserted and has been acknowledged lets the motor move away from it; an attempt in the other
    direction needs a new acknowledgement.
    """
    allowed = _allowed(motor, way)
    motor.refused |= not allowed
    return allowed


def _allowed(motor: "Motor", way: int) -> bool:
    i = motor.i
    if i[BE] or i[BH] or i[HOT] or (i[BP] and i[BM]):
        return False
    passes = [_passes(motor, flag, active, acknowledged, way * sign) for _, flag, active, acknowledged, sign in LIMITS]
    return all(passes)


def _passes(motor: "Motor", flag: int, active: int, acknowledged: int, towards: int) -> bool:
    i = motor.i
    if i[active] and i[acknowledged]:
        if towards > 0:
            i[acknowledged] = 0
        return towards <= 0
    return not i[flag]


# Clearing


def clear(motor: "Motor", *, slot: int) -> None:
    """Zr Zl Ze Zh Zd Zu Zs Za Zw Zb Zc Zf: clear one flag.  What still holds sets it again in the next sample (4.2)."""
    motor.i[slot] = 0
    for _, flag, active, acknowledged, _sign in LIMITS:
        if slot == flag:
            motor.i[acknowledged] = motor.i[active]


def clear_all(motor: "Motor") -> None:
    """ZS: clear all flags that are kept.  What still holds sets its flag again in the next sample (3.1, 4.2)."""
    for slot in LATCHED:
        clear(motor, slot=slot)


def trouble(motor: "Motor") -> str:
    """Why the motor has refused to move, and what helps; empty if it has not, or no fault keeps it any more."""
    i = motor.i
    if not motor.refused:
        return ""
    if i[BR] or i[BL]:
        return OPEN_SWITCHES if i[BP] or i[BM] else "a limit fault has not been cleared: ZS, Zr or Zl"
    if i[BE]:
        return "a position error has not been cleared: ZS or Ze"
    return "it has been overheated: ZS or Zh, when it is 5 °C below TH" if i[BH] else ""
