"""The work of the motor's processor in each sample of 245,760 ns, up to the next event.

    statements of the program - the shaft turns - trajectory - servo law - protection and inputs

The kernel is written for Numba (`jit.py`) and also runs as plain Python.  The kernel only detects a fault, an edge
or the end of a trajectory; Python (`motor.py`) handles the event at exactly that sample.
"""

from collections.abc import Sequence

from axistwin.controllers.smartmotor.kernel import state as s
from axistwin.controllers.smartmotor.kernel.cam import cam
from axistwin.controllers.smartmotor.kernel.host_mode import EXIT, LAST, UNDERFLOW, host
from axistwin.controllers.smartmotor.kernel.interpreter import statement
from axistwin.controllers.smartmotor.kernel.jit import sampled
from axistwin.controllers.smartmotor.kernel.log import FOLLOWED, MOVING, USED, note, room
from axistwin.controllers.smartmotor.kernel.physics import Floats, Ints
from axistwin.controllers.smartmotor.kernel.position import commanded_shaft, position
from axistwin.controllers.smartmotor.kernel.servo import ideal, overloaded, rotate
from axistwin.controllers.smartmotor.kernel.servo_law import control
from axistwin.controllers.smartmotor.kernel.trajectory import counted, follow, master_turns, profile, show_master, wrap

# Events, e.g. a fault, that interrupt the computation of servo samples; each event is one bit.
ALL_DONE = 0
STATEMENT_WAITS = 1  # Event: the next program statement, e.g. PRINT, must be executed outside the compiled servo code.
VALUE_WAITS = 2  # Event: the next program statement needs an external value, e.g. a serial character for GETCHR.
CALL_WAITS = 4  # Event: the subroutine C1 or C2 of the motor's program must be called.
TRAJECTORY = 8  # Event: the status flag Bt (trajectory in progress) has changed.
PLUS = 16  # Event: the motor has reached its positive travel limit.
MINUS = 32  # Event: the motor has reached its negative travel limit.
ERROR = 64  # Event: the position error of the motor is too large.
HEAT = 128  # Event: the temperature or the RMS current of the motor is too high.
GO_EDGE = 256  # Event: the input pin G has changed from high to low.
SWITCH = 512  # Event: the shaft has reached a position at which a switch changes its level.
INDEX_MARK = 1024  # Event: the index signal of the encoder has changed.
HOST_EXIT, HOST_UNDERFLOW, HOST_LAST = 2048, 4096, 8192
PIN_TAKEN = 16384  # Event: a program statement, e.g. a=UG, has used the pin of the brake signal as an input.
BEFORE_SAMPLE = STATEMENT_WAITS | VALUE_WAITS | CALL_WAITS
"""Events that the motor's program causes before the next servo sample is computed."""


@sampled
def statements(i: Ints, v: Ints, stack: Ints, code: Sequence[int]) -> int:
    if i[s.PENDING] and i[s.PROGRAM] == s.STOPPED:
        return CALL_WAITS
    while i[s.BUDGET] > 0 and i[s.PROGRAM] == s.RUNNING and i[s.SAMPLE] + 1 >= i[s.WAIT_UNTIL]:
        if i[s.PENDING]:
            return CALL_WAITS
        result = statement(i, v, stack, code)
        if result == 3:  # FETCH
            return VALUE_WAITS
        if result == 2:  # HELD
            break
        i[s.BUDGET] -= 1
        if result == 1:  # TRAP
            return STATEMENT_WAITS
    return ALL_DONE


@sampled
def move(i: Ints, v: Ints, ring: Ints, predicted: Ints) -> int:
    """Compute the commanded position for one sample; with PIDn it changes in every n-th sample only."""
    why, before = ALL_DONE, i[s.MASTER]
    master_turns(i, predicted)
    if i[s.SHOWN] != 0:
        show_master(i, before)
    if i[s.SAMPLE] % i[s.PID_RATE] != 0:
        return why
    moved = counted(i)
    mode = i[s.MODE]
    if mode < s.M_HOLD or mode == s.M_TORQUE:  # Without servo control, the commanded position follows the shaft.
        i[s.COMMANDED] = position(i) << 16
        i[s.VELOCITY] = 0
    elif mode < s.M_FOLLOW:
        if mode != s.M_HOLD:
            profile(i)
    elif mode <= s.M_STEP_RATIO:
        follow(i, moved)
    elif mode == s.M_CAM:
        cam(i, v, moved)
    elif mode == s.M_HOST:
        result = host(i, ring)
        if result == EXIT:
            why = HOST_EXIT
        elif result == UNDERFLOW:
            why = HOST_UNDERFLOW
        elif result == LAST:
            why = HOST_LAST
    wrap(i)
    return why


@sampled
def beyond_plus(i: Ints) -> int:
    """Return 1 if the positive limit is asserted, by pin C or by the software limit."""
    hard = i[s.LIMIT_C] and i[s.PINS] & 4
    return 1 if hard or (i[s.SOFT_LIMITS] and position(i) >= i[s.SLP]) else 0


@sampled
def beyond_minus(i: Ints) -> int:
    """Return 1 if the negative limit is asserted, by pin D or by the software limit."""
    hard = i[s.LIMIT_D] and i[s.PINS] & 8
    return 1 if hard or (i[s.SOFT_LIMITS] and position(i) <= i[s.SLN]) else 0


@sampled
def heading(i: Ints) -> int:
    """Return the direction of motion by its sign, or 0; 0 while decelerating after a fault."""
    if i[s.STOPPING]:
        return 0
    return i[s.T] if i[s.MODE] == s.M_TORQUE else i[s.VELOCITY]


@sampled
def protect(i: Ints, f: Floats) -> int:
    """Check limits, position error and overheat (manual, chapters 3 and 4)."""
    why = ALL_DONE
    plus, minus = beyond_plus(i), beyond_minus(i)
    if plus == 0:
        i[s.ACKNOWLEDGED_PLUS] = 0
    elif not i[s.BP] or not i[s.BR] or heading(i) > 0:
        why |= PLUS
    if minus == 0:
        i[s.ACKNOWLEDGED_MINUS] = 0
    elif not i[s.BM] or not i[s.BL] or heading(i) < 0:
        why |= MINUS
    i[s.BP], i[s.BM] = plus, minus
    if i[s.DRIVE] == s.DRIVE_ON and i[s.MODE] != s.M_TORQUE and not i[s.BE]:
        error = (i[s.COMMANDED] >> 16) - position(i)
        if error > i[s.E] or -error > i[s.E]:
            why |= ERROR
    if overloaded(i, f) and not i[s.BH]:
        why |= HEAT
    return why


@sampled
def mark(i: Ints) -> int:
    """Update Bi and Bx; the position of the index mark is captured once, which sets Bi."""
    shaft, turn = i[s.SHAFT], i[s.COUNTS_PER_REV]
    passed = i[s.INDEX_HIGH] if shaft >= i[s.INDEX_HIGH] else i[s.INDEX_LOW]
    before = i[s.BX]
    at_mark = (shaft - i[s.INDEX_LOW]) % turn == 0
    i[s.BX] = 1 if at_mark or i[s.INDEX_FORCED] else 0
    if i[s.INDEX_ARMED] and not before and (at_mark or shaft <= i[s.INDEX_LOW] or shaft >= i[s.INDEX_HIGH]):
        i[s.INDEX] = i[s.DIRECTION] * passed + i[s.ORIGIN]
        i[s.INDEX_ARMED] = 0
        i[s.BI] = 1
    if not at_mark:
        i[s.INDEX_LOW] += (shaft - i[s.INDEX_LOW]) // turn * turn
        i[s.INDEX_HIGH] = i[s.INDEX_LOW] + turn
    return INDEX_MARK if i[s.OBSERVE_INDEX] and i[s.BX] != before else ALL_DONE


@sampled
def inputs(i: Ints) -> int:
    """Debounce pin G, and check whether the shaft has reached a switch or an index mark."""
    why = ALL_DONE
    level = i[s.PINS] >> 6 & 1
    if level == i[s.GO_LEVEL]:
        i[s.GO_COUNT] = 0
    else:
        i[s.GO_COUNT] += 1
        if i[s.GO_COUNT] >= i[s.DEBOUNCE]:
            i[s.GO_LEVEL] = level
            i[s.GO_COUNT] = 0
            if level == 0:
                why |= GO_EDGE
    if i[s.SHAFT] + i[s.SLIPPED] < i[s.WINDOW_LOW] or i[s.SHAFT] + i[s.SLIPPED] > i[s.WINDOW_HIGH]:
        why |= SWITCH
    if i[s.SHAFT] <= i[s.INDEX_LOW] or i[s.SHAFT] >= i[s.INDEX_HIGH] or i[s.BX]:
        why |= mark(i)
    if i[s.BRAKE_READ]:
        i[s.BRAKE_READ] = 0
        why |= PIN_TAKEN
    return why


@sampled
def sample(i: Ints, v: Ints, f: Floats, ring: Ints, predicted: Ints) -> int:
    """Simulate the motor for one servo sample: turn the shaft, check for faults, and read the inputs."""
    i[s.SAMPLE] += 1
    i[s.BUDGET] = i[s.STATEMENTS_PER_SAMPLE]
    busy = i[s.BT]
    if i[s.IDEAL]:
        why = move(i, v, ring, predicted)
        ideal(i, f)
    else:
        rotate(i, f)
        why = move(i, v, ring, predicted)
        control(i)
    why |= protect(i, f) | inputs(i)
    if i[s.BT] != busy:
        why |= TRAJECTORY
    return why


@sampled
def advance(
    i: Ints, v: Ints, f: Floats, stack: Ints, code: Sequence[int], ring: Ints, predicted: Ints, shaft: Ints,
    commanded: Ints, log: Ints, most: int,
) -> int:  # fmt: skip
    """Compute up to `most` samples.  Return the reason for stopping.

    `predicted`: edges of the external encoder, see the slot PREDICTED.
    Writes the actual and the commanded position of each sample into `shaft` and `commanded`, in counts of the machine,
    and the changes of followed numbers into `log` (`log.py`).
    """
    first = i[s.SAMPLE]
    why = ALL_DONE
    log[USED] = 0
    while why == ALL_DONE and i[s.SAMPLE] - first < most and room(log):
        budget = i[s.BUDGET]
        why = statements(i, v, stack, code)
        if why == ALL_DONE:
            # `stated`: True if a program statement or a host command may have changed traced values, e.g. variables.
            stated = i[s.BUDGET] != budget or i[s.SAMPLE] == first
            why = sample(i, v, f, ring, predicted)
            n = i[s.SAMPLE] - first - 1
            shaft[n] = i[s.SHAFT] + i[s.SLIPPED]
            commanded[n] = commanded_shaft(i)
            if log[FOLLOWED]:
                note(i, v, log, log[FOLLOWED] if stated else log[MOVING])
    return why
