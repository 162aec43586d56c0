"""Chapters Run mode instructions and Aborting a run-mode move in a sequence: moves that go on until stopped."""

from fractions import Fraction

from axistwin.controllers.digiplan.chapters.speed import ramp
from axistwin.controllers.digiplan.state import State
from axistwin.controllers.digiplan.step import Step
from axistwin.sim.clock import Procedure


def go(step: Step) -> str | None:
    """Command G: run the axes named until stopped; the distance becomes zero.  Chapter Run mode instructions."""
    if step.run:
        return "G stands twice"
    if not step.major:
        return "the axis is missing before G"
    step.run = True
    return None


def abort(step: Step) -> None:
    """Command A, in a sequence only: stop the run begun by `G` in an earlier step.

    Chapter Aborting a run-mode move in a sequence.
    """
    step.abort = True


def run(state: State, step: Step) -> None:
    """Begin the run; it goes on while the next step of a sequence is carried out.  The index length is lost."""
    parameters = state.in_force
    table = ramp(parameters)
    if step.interpolated:
        ratio = Fraction(parameters.minor_distance, parameters.distance)
        state.motion.begin_interpolated(table.run(), table, step.major, step.minor, ratio)
    else:
        state.motion.begin(table.run(), table, step.major)
    state.parameters = state.parameters.without_index()


def stop_run(state: State) -> Procedure:
    """Decelerate what runs and wait until it is at rest."""
    state.motion.decelerate()
    while state.motion.running:
        yield state.motion.ended
