"""Chapters Run mode instructions and Aborting a run-mode move in a sequence: moves that go on until stopped."""

from fractions import Fraction
from typing import TYPE_CHECKING

from axistwin.controllers.digiplan.chapters.speed import ramp
from axistwin.controllers.digiplan.step import Step
from axistwin.sim.clock import Procedure

if TYPE_CHECKING:
    from axistwin.controllers.digiplan.interface import Interface


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


def run(interface: "Interface", step: Step) -> None:
    """Begin the run; it goes on while the next step of a sequence is carried out.  The index length is lost."""
    parameters = interface.in_force
    table = ramp(parameters)
    if step.interpolated:
        ratio = Fraction(parameters.minor_distance, parameters.distance)
        interface.motion.begin_interpolated(table.run(), table, step.major, step.minor, ratio)
    else:
        interface.motion.begin(table.run(), table, step.major)
    interface.parameters = interface.parameters.without_index()


def stop_run(interface: "Interface") -> Procedure:
    """Decelerate what runs and wait until it is at rest."""
    interface.motion.decelerate()
    while interface.motion.running:
        yield interface.motion.ended
