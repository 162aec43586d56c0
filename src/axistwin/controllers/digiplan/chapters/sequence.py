"""Chapter Sequence mode: up to 63 steps, with repeats, waits and intervention by the host."""

from collections.abc import Sequence

from axistwin.controllers.digiplan.chapters import interpolation, outputs, run
from axistwin.controllers.digiplan.chapters.faults import LineFault, MotionFault
from axistwin.controllers.digiplan.chapters.index import index
from axistwin.controllers.digiplan.state import State
from axistwin.controllers.digiplan.step import EndOfWork, Parameters, Step
from axistwin.core.units import MS
from axistwin.sim.clock import Interrupt, Procedure

CYCLE_NS = 1 * MS  # A step without a wait takes one cycle of about 1 ms.


def repeat(step: Step, times: int, first: int) -> None:
    """Command =, in a sequence only: go back to step `first` (1 to 63), `times` times (1 to 255; 0 for ever).

    Chapter Repeating parts of a sequence.
    """
    step.repeat = times, first


def hand_over(step: Step) -> None:
    """Command `%` in a sequence: give control to the host until the host sends `%`.

    The interface reports the change of control by sending `%` and the terminator.  Chapter Controller intervention in a
    sequence.
    """
    step.hand_over = True


def sequence(state: State, steps: Sequence[Step]) -> Procedure:
    """Carry out the steps of a sequence.  An inner repeat starts again in each pass of the outer repeat."""
    left: dict[int, int] = {}
    number, state.ended_by = 1, MotionFault.NONE
    try:
        while number <= len(steps):
            step, began_ns = steps[number - 1], state.clock.now
            state.step = state.step_number = number
            state.on_step(number)
            yield from perform(state, step)
            if state.clock.now == began_ns:
                yield state.clock.timeout(CYCLE_NS)
            number = _next(step, number, left)
    except (EndOfWork, Interrupt):
        state.ended_by = state.faults.motion
        raise
    finally:
        state.step = 0


def _next(step: Step, number: int, left: dict[int, int]) -> int:
    if step.repeat is None:
        return number + 1
    times, first = step.repeat
    if times == 0:
        return first
    still = left.pop(number, times)
    if still == 0:
        return number + 1
    left[number] = still - 1
    return first


def perform(state: State, step: Step) -> Procedure:
    """Carry out one step, or one direct message, in the order of its format."""
    if step.high or step.low:
        state.waiting = step
        try:
            yield from outputs.wait_for_inputs(state.pins, step)
        finally:
            state.waiting = None
    state.parameters = state.parameters.after(step)
    if step.abort:
        yield from run.stop_run(state)
    if step.major:
        yield from _move(state, step)
    if step.set or step.reset or step.pulse is not None:
        yield from outputs.switch_outputs(state.outputs, step, state.parameters.pulse_length)
    if step.hand_over:
        yield from _intervention(state)


def _move(state: State, step: Step) -> Procedure:
    # A move waits for the end of a run (continuous motion), because both use the only ramp generator.
    while state.motion.running:
        yield state.motion.ended
    if interpolation.out_of_range(state.in_force, step):
        state.faults.raise_line(LineFault.RANGE)
        raise EndOfWork
    directions = _moving(step, state.in_force)
    if not state.stops.may_move(directions):
        if not state.step:
            state.refuse(state.begun, state.faults.inhibition(directions))
        raise EndOfWork
    if step.run:
        run.run(state, step)
    elif step.interpolated:
        yield from interpolation.interpolate(state, step)
    else:
        yield from index(state, step)


def _moving(step: Step, parameters: Parameters) -> dict[str, int]:
    major = step.major if step.run or parameters.distance else {}
    return {**major, **(step.minor if parameters.minor_distance else {})}


def _intervention(state: State) -> Procedure:
    """Give control to the host until it sends `%`, and carry out the steps that it sends."""
    yield from state.transmit(state.frame.answer(b"%"))
    while (step := (yield state.work.give_control())) is not None:
        yield from perform(state, step)
