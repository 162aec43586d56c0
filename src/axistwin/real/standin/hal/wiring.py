"""The axes, inputs and outputs of a stand-in at LinuxCNC HAL, and the pins of the component `axistwin`."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from axistwin.core.errors import UsageError
from axistwin.real.standin.wiring import Wired

COMPONENT = "axistwin"
MOST_NAME = 47  # Longest name of a pin in HAL.
AXIS_PINS = (
    ("position-cmd", "float out, position in pulses"), ("velocity-cmd", "float out, velocity in pulses/s"),
    ("enable", "bit out, switches the drive on"), ("plus", "bit out, moving in the positive direction"),
    ("minus", "bit out, moving in the negative direction"),
    ("position-fb", "float in, position of the motor in pulses"),
)  # fmt: skip


@dataclass(frozen=True)
class HalWiring(Wired):
    """The axes, inputs and outputs at HAL; `file`: HAL commands that link the component's pins."""

    file: Path | None = None

    def used(self) -> Iterator[tuple[str, str]]:
        yield f"{COMPONENT}.heartbeat", "bit out, changes every millisecond"
        for axis in self.axes:
            for pin, use in AXIS_PINS:
                yield f"{COMPONENT}.{axis.axis}.{pin}", use
        for given in self.inputs:
            yield f"{COMPONENT}.{given.to}", "bit in"
        for output in self.outputs:
            yield f"{COMPONENT}.{output.source}", "bit out"

    def check(self) -> None:
        """Check that no pin name is too long for HAL.  Raises UsageError, also for an input of another board."""
        for pin, _ in self.used():
            if len(pin) > MOST_NAME:
                raise UsageError(f"the name of the HAL pin {pin} is too long: expected at most {MOST_NAME} characters")
        super().check()

    def setup(self) -> dict[str, Any]:
        stops = {given.to: given.stops_at for given in self.inputs if given.stops is not None}
        return {
            "axes": [axis.axis for axis in self.axes], "inputs": [given.to for given in self.inputs], "stops": stops,
            "outputs": {output.source: output.safe for output in self.outputs},
        }  # fmt: skip
