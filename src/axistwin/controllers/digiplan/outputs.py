"""Chapters Output control and Combining inputs and outputs with move instructions."""

from typing import TYPE_CHECKING

from axistwin.controllers.digiplan.step import Step
from axistwin.sim.clock import Procedure
from axistwin.units import MS

if TYPE_CHECKING:
    from axistwin.controllers.digiplan.interface import Interface

PULSE_UNIT_NS = 10 * MS


def wait_high(step: Step, inputs: tuple[int, ...]) -> None:
    """Command H with inputs 1 to 3: begin when all of them are high.  Chapter Combining inputs and outputs."""
    step.high = inputs


def wait_low(step: Step, inputs: tuple[int, ...]) -> None:
    """Command L with inputs 1 to 3: then wait until all of them are low.  Chapter Combining inputs and outputs."""
    step.low = inputs


def set_outputs(step: Step, outputs: tuple[int, ...]) -> None:
    """Command S with outputs 1 to 5: turn them on, at the end of the move.  Chapter Output switching commands."""
    step.set = outputs


def reset_outputs(step: Step, outputs: tuple[int, ...]) -> None:
    """Command R with outputs 1 to 5: turn them off, at the end of the move.  Chapter Output switching commands."""
    step.reset = outputs


def pulse_output(step: Step, output: int, length: int | None) -> None:
    """Command P with output 1 to 5 and length 1 to 99 x 10 ms: invert it for so long; output 0 is a mere delay.

    The length is kept.  Chapters Output switching commands, Adding time delays.
    """
    step.pulse = output
    if length is not None:
        step.settings["pulse_length"] = length


def wait_for_inputs(interface: "Interface", step: Step) -> Procedure:
    """Wait until all inputs of H are high at once, then until all of L are low: levels, one list after the other."""
    for inputs, wanted in ((step.high, True), (step.low, False)):
        pins = [interface.pins[f"input{number}"] for number in inputs]
        while waiting := [pin for pin in pins if pin.level is not wanted]:
            yield waiting[0].changed()


def switch_outputs(interface: "Interface", step: Step) -> Procedure:
    """What the step asks of the outputs, S before R; a pulse takes its time."""
    for number in step.set:
        interface.switch(number, True)
    for number in step.reset:
        interface.switch(number, False)
    if step.pulse is not None:
        yield from _pulse(interface, step.pulse)


def _pulse(interface: "Interface", number: int) -> Procedure:
    before = interface.output(number)
    interface.switch(number, not before)
    try:
        yield interface.clock.timeout(interface.parameters.pulse_length * PULSE_UNIT_NS)
    finally:
        interface.switch(number, before)
