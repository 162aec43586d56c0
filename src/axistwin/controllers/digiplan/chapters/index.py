"""Chapters Index mode instructions and Backlash correction: moves of a given length."""

from axistwin.controllers.digiplan.chapters.speed import actual_start_stop, ramp
from axistwin.controllers.digiplan.state import State
from axistwin.controllers.digiplan.step import EndOfWork, Step
from axistwin.core.units import MS
from axistwin.sim.clock import Procedure
from axistwin.sim.motion.profile import Profile, Segment

REVERSAL_NS = 3 * MS  # Pause before the motor reverses: "at least 3mS".


def axis(name: str, step: Step, direction: int, distance: int | None) -> str | None:
    """Commands X Y Z: select an axis, its direction (default +) and optionally the distance, 0 to 999,999,999 steps.

    Several axes share one distance, the last one stated.  Later indexes use this distance again, but not the direction.
    Axes after `/` are minor axes, which have a distance of their own.  Chapter Index mode instructions.
    """
    if name in step.major or name in step.minor:
        return f"axis {name} is repeated"
    (step.minor if step.interpolated else step.major)[name] = direction
    if distance is not None:
        step.settings["minor_distance" if step.interpolated else "distance"] = distance
    return None


def backlash(step: Step, distance: int | None) -> str | None:
    """Command B: store the backlash distance, -255 to +255 steps.

    Without a number, correct the backlash in this index.  Chapter Backlash correction.
    """
    if distance is not None:
        step.settings["backlash"] = distance
        return None
    step.corrected = True
    return None if step.major else "the axis is missing before B"


def index(state: State, step: Step) -> Procedure:
    """Move the selected axes by the stored distance, and wait until these axes are at rest.

    With correction, a move against the backlash direction overshoots by the backlash distance and returns at the
    start/stop speed, so that every index ends in the same direction.  No return is made towards an open limit switch.
    The backlash direction is the same for all axes; if the axes move in different directions, some of them end in a
    wrong place, as the manual warns.
    """
    parameters, generator = state.in_force, state.motion
    table = ramp(parameters)
    against = step.corrected and parameters.distance > 0 and next(iter(step.major.values())) * parameters.backlash < 0
    back = abs(parameters.backlash) if against else 0
    generator.begin(table.index(parameters.distance + back), table, step.major)
    yield generator.ended
    if back:
        yield state.clock.timeout(REVERSAL_NS)
        rate = actual_start_stop(parameters.speed_range, parameters.start_stop)
        reverse = dict.fromkeys(step.major, 1 if parameters.backlash > 0 else -1)
        if not state.stops.may_move(reverse):
            raise EndOfWork
        generator.begin(Profile([Segment(rate, back / rate)]), table, reverse, further=True)
        yield generator.ended


def cancel(state: State) -> None:
    """Command #: stop every axis with deceleration, end a sequence, a wait or a pulse; the rest of the index is lost.

    Characters before # in the message are dropped.  Chapter Index mode instructions.
    """
    state.work.cancel()
