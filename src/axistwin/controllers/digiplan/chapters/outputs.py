"""Chapters Output control and Combining inputs and outputs with move instructions."""

from collections.abc import Iterable, Mapping

from axistwin.controllers.digiplan.step import Step
from axistwin.core.units import MS
from axistwin.sim.clock import Procedure
from axistwin.sim.pins import Pin

PULSE_UNIT_NS = 10 * MS
OUTPUTS = range(1, 6)


class Outputs:
    """The five opto-isolated outputs.

    All outputs are off without the 24 V supply.  `follow_led`: True if link 3 of the card is in position b; output 5
    then follows the LED and cannot be programmed.
    """

    def __init__(self, pins: Mapping[str, Pin], *, follow_led: bool) -> None:
        self._pins = {number: pins[f"output{number}"] for number in OUTPUTS}
        self._supply, self._follow_led = pins["supply"], follow_led
        self.clock = self._supply.clock
        self._on = dict.fromkeys(OUTPUTS, False)
        self._supply.subscribe(lambda _: self._update())
        if follow_led:
            pins["led"].subscribe(lambda led: self._set(5, led.level))

    def is_on(self, number: int) -> bool:
        """True if the program has switched an output on, even without supply voltage; False for output 0."""
        return self._on.get(number, False)

    def switch(self, number: int, on: bool) -> None:
        """Turn an output on or off.  The call has no effect for output 0 and for the fault output."""
        if number in self._on and not (number == 5 and self._follow_led):
            self._set(number, on)

    def reset(self) -> None:
        """Turn all outputs off when the power of the interface is switched off."""
        for number in OUTPUTS:
            self._set(number, False)

    def _set(self, number: int, on: bool) -> None:
        self._on[number] = on
        self._pins[number].set(on and self._supply.level)

    def _update(self) -> None:
        for number, on in self._on.items():
            self._set(number, on)


def wait_high(step: Step, inputs: tuple[int, ...]) -> None:
    """Command H: wait until all given inputs (1 to 3) are high.  Chapter Combining inputs and outputs."""
    step.high = inputs


def wait_low(step: Step, inputs: tuple[int, ...]) -> None:
    """Command L with inputs 1 to 3: after H, wait until all of them are low.  Chapter Combining inputs and outputs."""
    step.low = inputs


def set_outputs(step: Step, outputs: tuple[int, ...]) -> None:
    """Command S with outputs 1 to 5: turn them on, at the end of the move.  Chapter Output switching commands."""
    step.set = outputs


def reset_outputs(step: Step, outputs: tuple[int, ...]) -> None:
    """Command R with outputs 1 to 5: turn them off, at the end of the move.  Chapter Output switching commands."""
    step.reset = outputs


def pulse_output(step: Step, output: int, length: int | None) -> None:
    """Command P with output 1 to 5, length 1 to 99 x 10 ms: invert the output for this time; output 0 is only a delay.

    The length is kept.  Chapters Output switching commands, Adding time delays.
    """
    step.pulse = output
    if length is not None:
        step.settings["pulse_length"] = length


def wait_for_inputs(pins: Mapping[str, Pin], step: Step) -> Procedure:
    """Wait until all inputs of H are high at the same time, then until all inputs of L are low."""
    for inputs, wanted in ((step.high, True), (step.low, False)):
        while waiting := _missing(pins, inputs, wanted):
            yield pins[waiting[0]].changed()


def _missing(pins: Mapping[str, Pin], inputs: Iterable[int], wanted: bool) -> list[str]:
    return [name for name in (f"input{number}" for number in inputs) if pins[name].level is not wanted]


def awaited(pins: Mapping[str, Pin], step: Step) -> tuple[str, str]:
    """Return the input for which a sequence step waits, and the required level, "high" or "low"."""
    if high := _missing(pins, step.high, True):
        return high[0], "high"
    return next(iter(_missing(pins, step.low, False)), f"input{(*step.low, *step.high)[0]}"), "low"


def switch_outputs(outputs: Outputs, step: Step, pulse_length: int) -> Procedure:
    """Execute the output commands of a sequence step: S (set), R (reset) and P (pulse)."""
    for number in step.set:
        outputs.switch(number, True)
    for number in step.reset:
        outputs.switch(number, False)
    if step.pulse is not None:
        before = outputs.is_on(step.pulse)
        outputs.switch(step.pulse, not before)
        try:
            yield outputs.clock.timeout(pulse_length * PULSE_UNIT_NS)
        finally:
            outputs.switch(step.pulse, before)
