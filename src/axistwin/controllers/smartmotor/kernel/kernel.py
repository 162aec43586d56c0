"""The work of the motor's processor in each sample of 245,760 ns, up to the next event.

    statements of the program - the shaft turns - trajectory - servo law - protection and inputs

The kernel is written for Numba (`jit.py`) and also runs as plain Python.  The kernel only detects a fault, an edge
or the end of a trajectory; Python (`motor.py`) handles the event at exactly that sample.
"""

from collections.abc import Sequence

from axistwin.controllers.smartmotor.kernel.cam import cam
from axistwin.controllers.smartmotor.kernel.host_mode import EXIT, LAST, UNDERFLOW, host
from axistwin.controllers.smartmotor.kernel.interpreter import statement
from axistwin.controllers.smartmotor.kernel.jit import sampled
from axistwin.controllers.smartmotor.kernel.log import FOLLOWED, MOVING, USED, note, room
from axistwin.controllers.smartmotor.kernel.machine import Floats, Ints
from axistwin.controllers.smartmotor.kernel.position import commanded_shaft, position
from axistwin.controllers.smartmotor.kernel.servo import ideal, overloaded, rotate
from axistwin.controllers.smartmotor.kernel.servo_law import control
from axistwin.controllers.smartmotor.kernel.state import (
    ACKNOWLEDGED_MINUS,
    ACKNOWLEDGED_PLUS,
    BE,
    BH,
    BI,
    BL,
    BM,
    BP,
    BR,
    BRAKE_READ,
    BT,
    BUDGET,
    BX,
    COMMANDED,
    COUNTS_PER_REV,
    DEBOUNCE,
    DIRECTION,
    DRIVE,
    DRIVE_ON,
    GO_COUNT,
    GO_LEVEL,
    IDEAL,
    INDEX,
    INDEX_ARMED,
    INDEX_FORCED,
    INDEX_HIGH,
    INDEX_LOW,
    LIMIT_C,
    LIMIT_D,
    M_CAM,
    M_FOLLOW,
    M_HOLD,
    M_HOST,
    M_STEP_RATIO,
    M_TORQUE,
    MASTER,
    MODE,
    OBSERVE_INDEX,
    ORIGIN,
    PENDING,
    PID_RATE,
    PINS,
    PROGRAM,
    RUNNING,
    SAMPLE,
    SHAFT,
    SHOWN,
    SLIPPED,
    SLN,
    SLP,
    SOFT_LIMITS,
    STATEMENTS_PER_SAMPLE,
    STOPPED,
    STOPPING,
    VELOCITY,
    WAIT_UNTIL,
    WINDOW_HIGH,
    WINDOW_LOW,
    E,
    T,
)
from axistwin.controllers.smartmotor.kernel.trajectory import (
    counted,
    follow,
    master_turns,
    profile,
    show_master,
    wrap,
)

# Reasons for stopping.  The first three come before their sample, the others at its end.
ALL_DONE = 0
STATEMENT_WAITS = 1  # a statement that Python carries out
VALUE_WAITS = 2  # a value that Python fetches
CALL_WAITS = 4  # C1 or C2 is to be called
TRAJECTORY = 8  # Bt has changed
PLUS, MINUS = 16, 32  # a limit
ERROR, HEAT = 64, 128  # position error, overheat
GO_EDGE = 256  # pin G has gone low
SWITCH = 512  # the shaft has reached a switch
INDEX_MARK = 1024  # Bx has changed
HOST_EXIT, HOST_UNDERFLOW, HOST_LAST = 2048, 4096, 8192
PIN_TAKEN = 16384  # an assignment has read the pin with the brake's signal
BEFORE_SAMPLE = STATEMENT_WAITS | VALUE_WAITS | CALL_WAITS


@sampled
def statements(i: Ints, v: Ints, stack: Ints, code: Sequence[int]) -> int:
    """Execute the statements of one sample."""
    if i[PENDING] and i[PROGRAM] == STOPPED:
        return CALL_WAITS
    while i[BUDGET] > 0 and i[PROGRAM] == RUNNING and i[SAMPLE] + 1 >= i[WAIT_UNTIL]:
        if i[PENDING]:
            return CALL_WAITS
        result = statement(i, v, stack, code)
        if result == 3:  # FETCH
            return VALUE_WAITS
        if result == 2:  # HELD
            break
        i[BUDGET] -= 1
        if result == 1:  # TRAP
            return STATEMENT_WAITS
    return ALL_DONE


@sampled
def move(i: Ints, v: Ints, ring: Ints, predicted: Ints) -> int:
    """Compute the trajectory of one sample; with PIDn, of every n-th."""
    why, before = ALL_DONE, i[MASTER]
    master_turns(i, predicted)
    if i[SHOWN] != 0:
        show_master(i, before)
    if i[SAMPLE] % i[PID_RATE] != 0:
        return why
    moved = counted(i)
    mode = i[MODE]
    if mode < M_HOLD or mode == M_TORQUE:  # the trajectory follows the shaft
        i[COMMANDED] = position(i) << 16
        i[VELOCITY] = 0
    elif mode < M_FOLLOW:
        if mode != M_HOLD:
            profile(i)
    elif mode <= M_STEP_RATIO:
        follow(i, moved)
    elif mode == M_CAM:
        cam(i, v, moved)
    elif mode == M_HOST:
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
    """Return 1 if the positive limit is asserted: pin C, or the software limit, "at or beyond"."""
    hard = i[LIMIT_C] and i[PINS] & 4
    return 1 if hard or (i[SOFT_LIMITS] and position(i) >= i[SLP]) else 0


@sampled
def beyond_minus(i: Ints) -> int:
    """Return 1 if the negative limit is asserted: pin D, or the software limit."""
    hard = i[LIMIT_D] and i[PINS] & 8
    return 1 if hard or (i[SOFT_LIMITS] and position(i) <= i[SLN]) else 0


@sampled
def heading(i: Ints) -> int:
    """Return the direction in which the motor is driven; 0 during a stop because of a fault."""
    if i[STOPPING]:
        return 0
    return i[T] if i[MODE] == M_TORQUE else i[VELOCITY]


@sampled
def protect(i: Ints, f: Floats) -> int:
    """Check limits, position error and overheat (chapters 3 and 4)."""
    why = ALL_DONE
    plus, minus = beyond_plus(i), beyond_minus(i)
    if plus == 0:
        i[ACKNOWLEDGED_PLUS] = 0
    elif not i[BP] or not i[BR] or heading(i) > 0:
        why |= PLUS
    if minus == 0:
        i[ACKNOWLEDGED_MINUS] = 0
    elif not i[BM] or not i[BL] or heading(i) < 0:
        why |= MINUS
    i[BP], i[BM] = plus, minus
    if i[DRIVE] == DRIVE_ON and i[MODE] != M_TORQUE and not i[BE]:
        error = (i[COMMANDED] >> 16) - position(i)
        if error > i[E] or -error > i[E]:
            why |= ERROR
    if overloaded(i, f) and not i[BH]:
        why |= HEAT
    return why


@sampled
def mark(i: Ints) -> int:
    """Handle an index mark that the shaft has reached or passed: the position is captured once, flag Bi."""
    shaft, turn = i[SHAFT], i[COUNTS_PER_REV]
    passed = i[INDEX_HIGH] if shaft >= i[INDEX_HIGH] else i[INDEX_LOW]
    before = i[BX]
    at_mark = (shaft - i[INDEX_LOW]) % turn == 0
    i[BX] = 1 if at_mark or i[INDEX_FORCED] else 0
    if i[INDEX_ARMED] and not before and (at_mark or shaft <= i[INDEX_LOW] or shaft >= i[INDEX_HIGH]):
        i[INDEX] = i[DIRECTION] * passed + i[ORIGIN]
        i[INDEX_ARMED] = 0
        i[BI] = 1
    if not at_mark:
        i[INDEX_LOW] += (shaft - i[INDEX_LOW]) // turn * turn
        i[INDEX_HIGH] = i[INDEX_LOW] + turn
    return INDEX_MARK if i[OBSERVE_INDEX] and i[BX] != before else ALL_DONE


@sampled
def inputs(i: Ints) -> int:
    """Poll pin G, "once per sample and de-bounced", and check for switches and index marks."""
    why = ALL_DONE
    level = i[PINS] >> 6 & 1
    if level == i[GO_LEVEL]:
        i[GO_COUNT] = 0
    else:
        i[GO_COUNT] += 1
        if i[GO_COUNT] >= i[DEBOUNCE]:
            i[GO_LEVEL] = level
            i[GO_COUNT] = 0
            if level == 0:
                why |= GO_EDGE
    if i[SHAFT] + i[SLIPPED] < i[WINDOW_LOW] or i[SHAFT] + i[SLIPPED] > i[WINDOW_HIGH]:
        why |= SWITCH
    if i[SHAFT] <= i[INDEX_LOW] or i[SHAFT] >= i[INDEX_HIGH] or i[BX]:
        why |= mark(i)
    if i[BRAKE_READ]:
        i[BRAKE_READ] = 0
        why |= PIN_TAKEN
    return why


@sampled
def sample(i: Ints, v: Ints, f: Floats, ring: Ints, predicted: Ints) -> int:
    """Compute one sample, after its statements."""
    i[SAMPLE] += 1
    i[BUDGET] = i[STATEMENTS_PER_SAMPLE]
    busy = i[BT]
    if i[IDEAL]:
        why = move(i, v, ring, predicted)
        ideal(i, f)
    else:
        rotate(i, f)
        why = move(i, v, ring, predicted)
        control(i)
    why |= protect(i, f) | inputs(i)
    if i[BT] != busy:
        why |= TRAJECTORY
    return why


@sampled
def advance(
    i: Ints,
    v: Ints,
    f: Floats,
    stack: Ints,
    code: Sequence[int],
    ring: Ints,
    predicted: Ints,
    shaft: Ints,
    commanded: Ints,
    log: Ints,
    most: int,
) -> int:
    """Compute up to `most` samples.  Return the reason for stopping.

    `predicted`: edges of the external encoder, see the slot PREDICTED.
    Writes the actual and the commanded position of each sample into `shaft` and `commanded`, in counts of the machine,
    and the changes of followed numbers into `log` (`log.py`).
    """
    first = i[SAMPLE]
    why = ALL_DONE
    log[USED] = 0
    while why == ALL_DONE and i[SAMPLE] - first < most and room(log):
        budget = i[BUDGET]
        why = statements(i, v, stack, code)
        if why == ALL_DONE:
            stated = i[BUDGET] != budget or i[SAMPLE] == first  # Python may have changed the state before
            why = sample(i, v, f, ring, predicted)
            n = i[SAMPLE] - first - 1
            shaft[n] = i[SHAFT] + i[SLIPPED]
            commanded[n] = commanded_shaft(i)
            if log[FOLLOWED]:
                note(i, v, log, log[FOLLOWED] if stated else log[MOVING])
    return why
