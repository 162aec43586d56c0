"""Chapter Linear interpolation mode: a long and a short index that begin and end together."""

from fractions import Fraction

from axistwin.controllers.digiplan.chapters.speed import ramp, too_fast
from axistwin.controllers.digiplan.rules import CONSTRAINT
from axistwin.controllers.digiplan.state import State
from axistwin.controllers.digiplan.step import Fault, Parameters, Problem, Step
from axistwin.sim.clock import Procedure

MOST_SPEED = 10_000  # steps/s
LEAST_ACCELERATION = 5  # x 1000 steps/s²
MOST_DISTANCE = 65_535  # steps of the major axis
ONLY_RANGE = 1

CHAPTER = "Constraints in linear interpolation mode"


def minor_axis(step: Step) -> str | None:
    """Command /: what follows is the minor axis, or two of them.

    The minor axis runs its own distance at speed x minor / major.  Speed up to 10,000 steps/s, acceleration from 5000
    steps/s², major distance up to 65,535 steps, speed range 1; otherwise out of range.
    Chapter Linear interpolation mode.
    """
    if step.interpolated:
        return "/ stands twice"
    if not step.major:
        return "the major axis is missing before /"
    step.interpolated = True
    return None


def constraint(parameters: Parameters, run: bool = False) -> Problem | None:
    """The constraint that an interpolated move with these parameters breaks."""
    p = parameters
    broken = {
        f"speed {p.speed} is above {MOST_SPEED} steps/s": (p.speed > MOST_SPEED, "speed"),
        f"acceleration {p.acceleration}000 is below {LEAST_ACCELERATION}000 steps/s²": (
            p.acceleration < LEAST_ACCELERATION,
            "acceleration",
        ),
        f"major index {p.distance} is above {MOST_DISTANCE} steps": (p.distance > MOST_DISTANCE, "distance"),
        f"speed range {p.speed_range} is not {ONLY_RANGE}": (p.speed_range != ONLY_RANGE, "speed_range"),
        f"minor index {p.minor_distance} is longer than the major one, {p.distance}": (
            p.minor_distance > p.distance,
            "minor_distance",
        ),
        "a run needs two distances for its ratio": (run and p.minor_distance * p.distance == 0, "minor_distance"),
    }
    for text, (holds, about) in broken.items():
        if holds:
            return Problem(CONSTRAINT, Fault.RANGE, 0, f"in linear interpolation, {text}", CHAPTER, (about,))
    return None


def out_of_range(parameters: Parameters, step: Step) -> Problem | None:
    """Why a move with these parameters is out of range: its speed, or a constraint of linear interpolation."""
    return too_fast(parameters) or (constraint(parameters, step.run) if step.interpolated else None)


def interpolate(state: State, step: Step) -> Procedure:
    """Run major and minor axes by their distances; return when they are at rest, both on their counts."""
    parameters, generator = state.in_force, state.motion
    table = ramp(parameters)
    ratio = Fraction(parameters.minor_distance, parameters.distance) if parameters.distance else Fraction(0)
    profile = table.index(parameters.distance)
    generator.begin_interpolated(profile, table, step.major, step.minor if ratio else {}, ratio)
    yield generator.ended
