"""Chapters Output control and Combining inputs and outputs with move instructions."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from axistwin.controllers.digiplan.step import Step
from axistwin.sim.clock import Procedure
from axistwin.sim.pins import Pin
from axistwin.units import MS

if TYPE_CHECKING:
    from axistwin.controllers.digiplan.interface import Interface

PULSE_UNIT_NS = 10 * MS


OUTPUTS = range(1, 6)


class Outputs:
    """The five opto-isolated outputs: what is programmed, and their transistors, which need the 24 V supply.

    `follow_led`: link 3 of the card in position b; output 5 follows the LED and cannot be programmed.
    """

    def __init__(self, pins: Mapping[str, Pin], *, follow_led: bool) -> None:
        self._pins = {number: pins[f"output{number}"] for number in OUTPUTS}
        self._supply, self._follow_led = pins["supply"], follow_led
        self._on = dict.fromkeys(OUTPUTS, False)
        self._supply.subscribe(lambda _: self._settle())
        if follow_led:
            pins["led"].subscribe(lambda led: self._set(5, led.level))

    def is_on(self, number: int) -> bool:
        """True if this output is turned on, with or without the supply; output 0 never is."""
        return self._on.get(number, False)

    def switch(self, number: int, on: bool) -> None:
        """Turn an output on or off; output 0 and the fault output are left alone."""
        if number in self._on and not (number == 5 and self._follow_led):
            self._set(number, on)

    def reset(self) -> None:
        """The power is gone."""
        for number in OUTPUTS:
            self._set(number, False)

    def _set(self, number: int, on: bool) -> None:
        self._on[number] = on
        self._pins[number].set(on and self._supply.level)

    def _settle(self) -> None:
        for number, on in self._on.items():
            self._set(number, on)


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
        interface.outputs.switch(number, True)
    for number in step.reset:
        interface.outputs.switch(number, False)
    if step.pulse is not None:
        yield from _pulse(interface, step.pulse)


def _pulse(interface: "Interface", number: int) -> Procedure:
    before = interface.outputs.is_on(number)
    interface.outputs.switch(number, not before)
    try:
        yield interface.clock.timeout(interface.parameters.pulse_length * PULSE_UNIT_NS)
    finally:
        interface.outputs.switch(number, before)
