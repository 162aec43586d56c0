"""Chapter Linear interpolation mode: two indexes of different length that begin and end together."""

from fractions import Fraction

from axistwin.controllers.digiplan.chapters.speed import ramp, too_fast
from axistwin.controllers.digiplan.rules import CONSTRAINT, CONSTRAINTS
from axistwin.controllers.digiplan.state import State
from axistwin.controllers.digiplan.step import Fault, Parameters, Problem, Step
from axistwin.sim.clock import Procedure

MOST_SPEED = 10_000  # Highest speed of an interpolated move in steps/s.
LEAST_ACCELERATION = 5  # Lowest acceleration of an interpolated move in units of 1000 steps/s².
MOST_DISTANCE = 65_535  # Largest number of steps of the major axis in an interpolated move.
ONLY_RANGE = 1


def minor_axis(step: Step) -> str | None:
    """Command /: the next axes, one or two, are minor axes.

    The minor axis runs its own distance at speed x minor / major.  Speed up to 10,000 steps/s, acceleration from 5000
    steps/s², major distance up to 65,535 steps, speed range 1; otherwise out of range.
    Chapter Linear interpolation mode.
    """
    if step.interpolated:
        return "/ is repeated"
    if not step.major:
        return "the major axis is missing before /"
    step.interpolated = True
    return None


def constraint(parameters: Parameters, run: bool = False) -> Problem | None:
    """Return the problem of an interpolated move that breaks a constraint of the manual; otherwise None."""
    p = parameters
    if p.speed > MOST_SPEED:
        about, text = "speed", f"speed {p.speed} is above {MOST_SPEED} steps/s"
    elif p.acceleration < LEAST_ACCELERATION:
        about, text = "acceleration", f"acceleration {p.acceleration}000 is below {LEAST_ACCELERATION}000 steps/s²"
    elif p.distance > MOST_DISTANCE:
        about, text = "distance", f"major index {p.distance} is above {MOST_DISTANCE} steps"
    elif p.speed_range != ONLY_RANGE:
        about, text = "speed_range", f"speed range {p.speed_range} is not {ONLY_RANGE}"
    elif p.minor_distance > p.distance:
        about, text = "minor_distance", f"minor index {p.minor_distance} is longer than the major one, {p.distance}"
    elif run and p.minor_distance * p.distance == 0:
        about, text = "minor_distance", "a run needs two distances for its ratio"
    else:
        return None
    return Problem(CONSTRAINT, Fault.RANGE, 0, f"in linear interpolation, {text}", CONSTRAINTS, (about,))


def out_of_range(parameters: Parameters, step: Step) -> Problem | None:
    """Return the problem of a move that is too fast or breaks a constraint of interpolation; otherwise None."""
    return too_fast(parameters) or (constraint(parameters, step.run) if step.interpolated else None)


def interpolate(state: State, step: Step) -> Procedure:
    """Move the major and minor axes by their distances; return when all axes are at rest."""
    parameters, generator = state.in_force, state.motion
    table = ramp(parameters)
    ratio = Fraction(parameters.minor_distance, parameters.distance) if parameters.distance else Fraction(0)
    minor = step.minor if ratio else {}
    generator.begin(table.index(parameters.distance), table, {**step.major, **minor}, dict.fromkeys(minor, ratio))
    yield generator.ended
