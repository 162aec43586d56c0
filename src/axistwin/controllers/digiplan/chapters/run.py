"""Chapters Run mode instructions and Aborting a run-mode move in a sequence: moves that continue until stopped."""

from fractions import Fraction

from axistwin.controllers.digiplan.chapters.speed import ramp
from axistwin.controllers.digiplan.state import State
from axistwin.controllers.digiplan.step import Step
from axistwin.sim.clock import Procedure


def go(step: Step) -> str | None:
    """Command G: run the named axes until stopped; the distance becomes zero."""
    if step.run:
        return "G is repeated"
    if not step.major:
        return "the axis is missing before G"
    step.run = True
    return None


def abort(step: Step) -> None:
    """Command A: stop the run (continuous motion) that command G has begun in an earlier step of the sequence.

    Chapter Aborting a run-mode move in a sequence.
    """
    step.abort = True


def run(state: State, step: Step) -> None:
    """Begin a run, which continues during the next steps of a sequence; set the index length to 0."""
    parameters = state.in_force
    table = ramp(parameters)
    minor = None
    if step.interpolated:
        minor = dict.fromkeys(step.minor, Fraction(parameters.minor_distance, parameters.distance))
    state.motion.begin(table.run(), table, {**step.major, **step.minor}, minor)
    state.parameters = state.parameters.without_index()


def stop_run(state: State) -> Procedure:
    """Decelerate the axes that are in a run (continuous motion), and wait until all axes are at rest."""
    state.motion.decelerate()
    while state.motion.running:
        yield state.motion.ended
