"""Chapter Report-back functions: answers to status requests, which do not disturb motion."""

from axistwin.controllers.digiplan.chapters.faults import LineFault
from axistwin.controllers.digiplan.state import State

IN_MOTION, AT_SPEED, ACCELERATING, DECELERATING = 1, 2, 4, 8
COUNTER = 1 << 32
SHORT_COUNTER = 1 << 16
COARSE = 256  # Above the start/stop speed, the interface reports positions in multiples of 256 steps.


def motion_bits(state: State) -> int:
    """Return the motion status that commands K and Q report."""
    motion = state.motion
    status = int(state.faults.status())
    if motion.running:
        status |= IN_MOTION
        if motion.trend:
            status |= ACCELERATING if motion.trend > 0 else DECELERATING
        elif motion.ramp is not None and motion.rate == motion.ramp.top:
            status |= AT_SPEED
    return status


def _number(state: State, value: int) -> bytes:
    return state.frame.answer(b"%d" % value)


def motion_status(state: State) -> bytes:
    """Command K: 1 in motion, 2 at programmed speed, 4 accelerating, 8 decelerating, 16 drive fault, 32 emergency stop,
    64 limit, 128 communication fault, as a decimal number.

    Clears fault bits whose cause is gone.  Chapter Motion status.
    """
    status = motion_bits(state)
    state.faults.motion_has_been_read(state.locked)
    return _number(state, status)


def quick_status(state: State) -> bytes:
    """Command Q: report the motion status as one raw byte without a terminator.

    Like command K, Q then clears fault bits.  The byte is complete only with 8 data bits of which bit 8 is data or 1;
    otherwise the highest bit is lost.  Chapter Quick status.
    """
    status = motion_bits(state)
    state.faults.motion_has_been_read(state.locked)
    return bytes([state.frame.raw(status)])


def communication_status(state: State) -> bytes:
    """Command F: 1 parity, 2 overrun, 4 framing, 8 data fault or buffer overflow, 16 out of range, 32 locked.

    Clears all bits except 32.  Chapter Motion status.
    """
    status = communication_bits(state)
    state.faults.line = LineFault.NONE
    return _number(state, status)


def communication_bits(state: State) -> int:
    """Return the communication status that command F reports."""
    return state.faults.line.value | (LineFault.LOCKED.value if state.locked else 0)


def input_status(state: State) -> bytes:
    """Command I: a bit for each input in which no current flows.  Chapter Input status."""
    return _number(state, state.faults.inputs())


def sequence_status(state: State) -> bytes:
    """Command O: the step started last, 1 to 63; 0 before the first since power-up.  Chapter Sequence status."""
    return _number(state, state.step_number)


def busy_status(state: State) -> bytes:
    """Command E: `[` locked, `F` a fault, `E` busy, `C` clear for new commands.  Chapter Busy status."""
    return state.frame.answer(busy_letter(state).encode("ascii"))


def busy_letter(state: State) -> str:
    """Return the busy status that command E reports."""
    if state.locked:
        return "["
    if state.faults.status():
        return "F"
    return "E" if state.work.busy else "C"


def position(state: State) -> bytes:
    """Command N: steps since the last index or run began, modulo 2^32.

    In motion above the start/stop speed the count rises by 256 at a time.  Above that speed an interpolated
    run has a counter of 16 bits, which loses one step at each overflow: the position is then N + 65,537.  Chapters
    Position report-back, Position report-back in linear interpolation mode.
    """
    return _number(state, steps(state))


def steps(state: State) -> int:
    """Return the position that command N reports, in steps."""
    motion = state.motion
    made, levels = motion.steps, motion.levels
    if motion.running and levels and motion.rate > levels[0]:
        made -= made % COARSE
    if motion.interpolating and levels and made >= SHORT_COUNTER:
        return (made - SHORT_COUNTER - 1) % SHORT_COUNTER if made > SHORT_COUNTER else 0
    return made % COUNTER
