"""The tables of a scene file, and which keys and values they may hold."""

from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, field_validator

from axistwin.plant.encoder import EncoderData
from axistwin.plant.torque import Load, StepperMotor


class Table(BaseModel):
    """A table in which every key is known."""

    model_config = ConfigDict(extra="forbid", use_attribute_docstrings=True)


class AxisTable(Table):
    """The machine on one axis."""

    limits: tuple[int, int] | None = None
    """Positions, in motor pulses, beyond which the minus and the plus limit switch open."""
    home: tuple[int, int] | None = None
    """First and last position at which the home input is high."""
    encoder: EncoderData | None = None
    """An encoder on the axis."""
    motor: StepperMotor | None = None
    """The motor's data sheet; without it the motor never stalls."""
    load: Load | None = None
    """What hangs on the shaft."""

    @field_validator("limits", "home")
    @classmethod
    def _in_order(cls, ends: tuple[int, int] | None) -> tuple[int, int] | None:
        if ends is not None and ends[0] > ends[1]:
            raise ValueError("the lower position comes first")
        return ends


class ControllerTable(Table):
    """One controller."""

    model: str
    """Such as "if1" or "if2"."""
    name: Annotated[str, Field(pattern=r"^[\w-]+$")] | None = None
    """What it is called in wires, conversations and plots; the model if left out."""
    line: str | None = None
    """The host's line format where the port carries none, such as "9600 8N2", or "instant"."""
    state: Path | None = None
    """Directory for what it keeps without power, seen from the scene file."""
    history: Annotated[int, Field(ge=1)] | None = None
    """How many strokes of each axis are remembered."""
    options: dict[str, Any] = {}
    """Options of the model."""
    axes: dict[str, AxisTable] = {}
    """The machine, axis by axis."""
    ports: list[str] = []
    """Where it is reached: tcp://127.0.0.1:5001, rfc2217://127.0.0.1:0, pty:/tmp/if1, serial:///dev/ttyUSB0."""

    @property
    def called(self) -> str:
        """Its name on the bench."""
        return self.name or self.model.lower()


class WireTable(Table):
    """A wire from one terminal to another."""

    from_: Annotated[str, Field(alias="from")]
    """The terminal it comes from, as "name.pin"."""
    to: str
    """The terminal it leads to, as "name.pin"."""
    invert: bool = False
    """Whether high arrives as low."""
    delay_ms: Annotated[float, Field(ge=0)] = 0.0
    """How much later a change arrives, in milliseconds."""


class SceneFile(Table):
    """What a scene file holds."""

    controller: Annotated[list[ControllerTable], Field(min_length=1)]
    """The controllers, each begun by [[controller]]."""
    wire: list[WireTable] = []
    """The wires, each begun by [[wire]]."""
