"""Fault handling (chapter 4): limits, position error, overheat, and clearing of faults."""

from axistwin.controllers.smartmotor.chapters import flow
from axistwin.controllers.smartmotor.chapters.brakes import switch_off
from axistwin.controllers.smartmotor.chapters.functions import CALL_C1, DECELERATE
from axistwin.controllers.smartmotor.kernel import state as s
from axistwin.controllers.smartmotor.kernel.kernel import ERROR, HEAT, MINUS, PLUS, heading
from axistwin.controllers.smartmotor.processor import Processor

LIMITS = ((PLUS, s.BR, s.BP, s.ACKNOWLEDGED_PLUS, 1), (MINUS, s.BL, s.BM, s.ACKNOWLEDGED_MINUS, -1))
"""For each limit: the kernel's stop reason, historical flag, real-time flag, acknowledgement and direction."""
LATCHED = (s.BR, s.BL, s.BI, s.BW, s.BE, s.BH, s.BD, s.BU, s.BS, s.BA, s.BB, s.BC, s.BF)
"""The flags that ZS clears.  Bk is cleared when the stored program is valid again."""
OPEN_SWITCHES = (
    "in a limit fault, as pins C and D are not held low: give the shaft limits, or UCI UDI ZS at the top of the program"
)
AT_SWITCH = "in a limit fault, at a limit switch: ZS, a move away from it, and ZS again"
BEYOND = "in a limit fault, at or beyond a software limit: SLD ZS"
ALARMS = {s.BR: "Br", s.BL: "Bl", s.BE: "Be", s.BH: "Bh"}  # Names of faults in reports, by flag.
FAULT_1 = 1  # The label that a fault calls with F=32.


def happen(motor: Processor, why: int) -> None:
    """Handle the faults that the kernel has found in the last computed servo sample (manual, section 4.1)."""
    for reason, flag, _, acknowledged, sign in LIMITS:
        if why & reason:
            _limit(motor, flag, acknowledged, sign)
    for reason, flag in ((ERROR, s.BE), (HEAT, s.BH)):
        if why & reason:
            motor.i[flag] = 1
            motor.on_fault(ALARMS[flag])
            shut_down(motor, s.M_ERROR)
            _interrupt(motor, ends_program=True)


def _limit(motor: Processor, flag: int, acknowledged: int, sign: int) -> None:
    """Stop the motor at a switch's or a software limit (3.1), unless it moves away from the limit."""
    i = motor.i
    i[flag] = 1
    motor.on_fault(ALARMS[flag])
    on_its_way = heading(i) * sign
    if i[acknowledged] and on_its_way <= 0:
        return
    i[acknowledged] = 0
    if on_its_way >= 0:
        shut_down(motor, s.M_OFF)
    _interrupt(motor, ends_program=False)


def shut_down(motor: Processor, mode: int) -> None:
    """Switch the amplifier off and apply MTB, unless deactivated; with F=1, decelerate at A first (4.1)."""
    i = motor.i
    if i[s.MODE] < s.M_HOLD or not i[s.F] & DECELERATE or i[s.MODE] == s.M_TORQUE:
        switch_off(motor, mode)
    elif i[s.VELOCITY] == 0 or i[s.A] == 0:
        i[s.VELOCITY] = 0
        stopped(motor)
    else:
        i[s.MODE], i[s.ACCELERATION], i[s.STOPPING], i[s.BT] = s.M_STOP, i[s.A], 1, 1


def stopped(motor: Processor) -> None:
    """End the deceleration after a fault: apply MTB, or hold the position if MTB is deactivated (table 4.2)."""
    i = motor.i
    i[s.STOPPING] = i[s.BT] = 0
    i[s.MODE] = s.M_HOLD
    if motor.mtb_enabled:
        switch_off(motor)


def _interrupt(motor: Processor, *, ends_program: bool) -> None:
    """With F=32 call C1 after the present statement; without F=32 a motor protection fault ends the program.

    C1 is called even if the main program has ended, as in the example of 4.3.  A fault within C1 calls C1 again.
    """
    i = motor.i
    if i[s.F] & CALL_C1 and FAULT_1 in motor.program.labels:
        if flow.within(motor, s.CALL_FAULT):
            i[s.FAULT_AGAIN] = 1
        else:
            i[s.PENDING] |= s.CALL_FAULT
    elif ends_program:
        flow.end(motor)


def may_move(motor: Processor, way: int) -> bool:
    """True if no fault prevents a movement in the direction `way`; 0: the direction is unknown.

    Once acknowledged, an asserted limit permits movement away from it; towards it, a new acknowledgement is needed.
    """
    allowed = _allowed(motor, way)
    if not (allowed or motor.refused):
        motor.refused = True
        if reason := inhibition(motor):
            motor.on_refusal(reason)
    return allowed


def _allowed(motor: Processor, way: int) -> bool:
    i = motor.i
    if i[s.BE] or i[s.BH] or i[s.HOT] or (i[s.BP] and i[s.BM]):
        return False
    passes = [_passes(motor, flag, active, acknowledged, way * sign) for _, flag, active, acknowledged, sign in LIMITS]
    return all(passes)


def _passes(motor: Processor, flag: int, active: int, acknowledged: int, towards: int) -> bool:
    i = motor.i
    if i[active] and i[acknowledged]:
        if towards > 0:
            i[acknowledged] = 0
        return towards <= 0
    return not i[flag]


def clear(motor: Processor, *, slot: int) -> None:
    """Zr Zl Ze Zh Zd Zu Zs Za Zw Zb Zc Zf: clear one flag.  A persistent cause sets the flag again (4.2)."""
    motor.i[slot] = 0
    for _, flag, active, acknowledged, _sign in LIMITS:
        if slot == flag:
            motor.i[acknowledged] = motor.i[active]


def clear_all(motor: Processor) -> None:
    """ZS: clear all latched flags; a persistent cause sets its flag again in the next sample (3.1, 4.2)."""
    for slot in LATCHED:
        clear(motor, slot=slot)


def inhibition(motor: Processor) -> str:
    """Return why the motor has refused to move, and the remedy; "" if no fault prevents motion."""
    return latched(motor) if motor.refused else ""


def latched(motor: Processor) -> str:
    """Return the fault that has not been cleared, and the remedy; "" if there is none."""
    i = motor.i
    if i[s.BP] or i[s.BM]:
        return _asserted(motor)
    if i[s.BR] or i[s.BL]:
        own = " or Zr" * (not i[s.BL]) + " or Zl" * (not i[s.BR])
        return f"a limit fault has not been cleared: ZS{own}"
    if i[s.BE]:
        return "a position error has not been cleared: free the shaft, then ZS or Ze"
    return "an overheat fault has not been cleared: let it cool to 5 °C below TH, then ZS or Zh" if i[s.BH] else ""


def _asserted(motor: Processor) -> str:
    """Return the remedy for an asserted limit: a software limit, a switch, or an input without a switch."""
    i = motor.i
    pins = [motor.pins[name] for name, slot in (("C", s.LIMIT_C), ("D", s.LIMIT_D)) if i[slot]]
    hard = [pin for pin in pins if pin.level]
    if not hard:
        return BEYOND
    return AT_SWITCH if all(pin.wired and not (pin.driven or pin.held) for pin in hard) else OPEN_SWITCHES
