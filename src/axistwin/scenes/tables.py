"""The tables of a scene file, and which keys and values they may hold."""

import json
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from typing import Annotated, Any

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    TypeAdapter,
    ValidationInfo,
    ValidatorFunctionWrapHandler,
    WithJsonSchema,
    create_model,
    field_validator,
)

from axistwin.bench import FAMILIES, product
from axistwin.fault_injection.kinds import KINDS
from axistwin.fault_injection.table import Parameter, Sort
from axistwin.plant.axes import servo_axis
from axistwin.plant.encoder import EncoderData
from axistwin.plant.servo import SERVO_MOTORS, WHOLE, ServoLoad, ServoMotor
from axistwin.plant.torque import Load, StepperMotor
from axistwin.scenes import toml_places


def _schema(parameter: Parameter) -> tuple[Any, Any]:
    """A parameter of a fault as a field; whether its value may be is for its kind to say."""
    kinds = {Sort.WHOLE: int, Sort.NUMBER: float, Sort.LEVEL: Any, Sort.WORD: str}
    return kinds[parameter.sort] | None, Field(None, description=f"{parameter.doc}: {parameter.wanted}")


FAULT_PARAMETERS: dict[str, Any] = {
    parameter.name: _schema(parameter) for kind in KINDS.values() for parameter in kind.parameters
}


class Table(BaseModel):
    """A table in which every key is known."""

    model_config = ConfigDict(extra="forbid", use_attribute_docstrings=True)


class AxisTable(Table):
    """The machine on one axis with a stepper motor."""

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


def _possible(path: Path) -> Path:
    if "\0" in str(path):
        raise ValueError("no file's name has a NUL in it")
    return path


File = Annotated[Path, AfterValidator(_possible)]


_ONE_OR_MORE = {"anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}}]}
_listed = BeforeValidator(lambda given: [given] if isinstance(given, str) else given)
Files = Annotated[list[File], _listed, WithJsonSchema(_ONE_OR_MORE)]
"""One file, or several."""


def _values(made: type[Any], **more: Any) -> dict[str, Any]:
    """The JSON Schema of a data sheet's values, by name; which may be is said when the axis is built."""
    numbers = {each.name: {"type": "integer" if each.name in WHOLE else "number"} for each in fields(made)}
    return {"type": "object", "properties": {**more, **numbers}, "additionalProperties": False}


_SHEETS = {"enum": list(SERVO_MOTORS), "description": "A data sheet, of which the values beside it are changed."}
SERVO_SCHEMA: dict[str, Any] = {
    "type": "object",
    "description": "The axis of a servo motor.",
    "properties": {
        "limits": {
            "type": "array", "items": {"type": "integer"}, "minItems": 2, "maxItems": 2,
            "description": "Positions, in encoder counts, beyond which the minus and the plus limit switch open.",
        },
        "motor": {
            "anyOf": [_values(ServoMotor, model=_SHEETS), {"enum": list(SERVO_MOTORS)}],
            "description": "Its data sheet, by name or by values; without it the shaft does exactly what it is told.",
        },
        "load": {**_values(ServoLoad), "description": "What hangs on the shaft."},
    },
    "additionalProperties": False,
}  # fmt: skip
ServoTable = Annotated[dict[str, Any], WithJsonSchema(SERVO_SCHEMA)]
"""The axis of a servo motor."""
_STEPPERS = TypeAdapter(dict[str, AxisTable])
_SERVOS = TypeAdapter(dict[str, ServoTable])


class ControllerTable(Table):
    """One controller."""

    model: str
    """Such as "if1", "1811" or "smartmotor"."""
    name: Annotated[str, Field(pattern=r"^[\w-]+$")] | None = None
    """What it is called in wires, conversations and plots; the model if left out."""
    line: str | None = None
    """The host's line format where the port carries none, such as "9600 8N2", or "instant"."""
    state: File | None = None
    """Directory for what it keeps without power, seen from the scene file."""
    history: Annotated[int, Field(ge=1, le=1_000_000_000)] | None = None
    """How many strokes of each axis are remembered."""
    options: dict[str, Any] = {}
    """Options of the model."""
    axes: dict[str, AxisTable | ServoTable] = {}
    """The machine, axis by axis."""
    ports: list[str] = []
    """Where it is reached: tcp://127.0.0.1:5001, rfc2217://127.0.0.1:0, pty:/tmp/if1, serial:///dev/ttyUSB0."""
    rs485_ports: list[str] = []
    """Where its second serial channel is reached, if it has one."""
    program: File | None = None
    """The source of a SmartMotor's stored program (.sms), seen from the scene file."""
    host: Files = []
    """Command lines (.if1, .181x) or conversations (.talk) that hosts have with it, seen from the scene file."""
    master: str | None = None
    """The axis that a SmartMotor's external encoder sits on, as "name.axis"."""
    master_ratio: tuple[int, Annotated[int, Field(ge=1)]] = (1, 1)
    """So many edges of that encoder for so many of that axis's units, motor pulses or encoder counts."""

    @field_validator("axes", mode="wrap")
    @classmethod
    def _as_the_model_has_them(cls, given: Any, _: ValidatorFunctionWrapHandler, info: ValidationInfo) -> Any:
        """What may stand in an axis depends on the kind of motor.  A servo's values are looked at when it is built."""
        adapter = _SERVOS if has_servo(info.data.get("model")) else _STEPPERS
        return adapter.validate_json(json.dumps(given), strict=True)

    @property
    def called(self) -> str:
        """Its name on the bench."""
        return self.name or self.model.lower()


def has_servo(model: str | None) -> bool:
    """Whether its axes are those of servo motors."""
    return model is not None and model.lower() in FAMILIES and product(model).make_axis is servo_axis


class LineTable(Table):
    """A serial line that motors share."""

    motors: Annotated[list[str], Field(min_length=1)]
    """Their names; in a daisy chain from the one next to the host on."""
    name: Annotated[str, Field(pattern=r"^[\w-]+$")] | None = None
    """What it is called in conversations and traces; "chain" or "rs485" if left out."""
    ports: list[str] = []
    """Where its host's end is reached."""
    host: Files = []
    """Conversations (.talk) that hosts have on it, seen from the scene file."""


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


Name = Annotated[str, Field(pattern=r"^[\w-]+$")]


class FaultTerms(Table):
    """Something that goes wrong."""

    kind: str
    """Which fault; `axistwin faults` lists them."""
    on: str = ""
    """What it acts on, such as "table.serial", "table.input1", "table.X" or "table"."""
    name: Name | None = None
    """What it is called; its kind if left out."""
    at: Annotated[float, Field(ge=0)] | None = None
    """When it begins, in seconds from the beginning."""
    when: str | None = None
    """What it waits for, such as "table.X passes 1000"."""
    nth: Annotated[int, Field(ge=1)] = 1
    """How many times that must happen."""
    duration: Annotated[float, Field(ge=0)] | None = None
    """After how many seconds it is mended; never if left out."""
    seed: int | None = None
    """What is left to chance follows from it; the scene's seed if left out."""

    @property
    def parameters(self) -> dict[str, Any]:
        """Those of its kind."""
        return self.model_dump(exclude_none=True, exclude=set(FaultTerms.model_fields))


FaultTable = create_model("FaultTable", __base__=FaultTerms, **FAULT_PARAMETERS)


Acts = Annotated[list[str], _listed, WithJsonSchema(_ONE_OR_MORE)]


class ScriptTable(Table):
    """Something that somebody does at the machine at a time."""

    at: Annotated[float, Field(ge=0)]
    """When, in seconds from the beginning."""
    do: Acts
    """What, as behind `!` in a conversation: "input1 high", "X.jam on", "fault lose 3"."""
    on: str = ""
    """Whose pins and axes these are; it need not be said if there is one controller only."""


class SceneFile(Table):
    """What a scene file holds."""

    title: str = ""
    """What it is, in a few words."""
    seed: int | None = None
    """Of what is left to chance."""

    controller: Annotated[list[ControllerTable], Field(min_length=1)]
    """The controllers, each begun by [[controller]]."""
    wire: list[WireTable] = []
    """The wires, each begun by [[wire]]."""
    chain: list[LineTable] = []
    """RS232 daisy chains, each begun by [[chain]]."""
    rs485: list[LineTable] = []
    """RS485 lines, each begun by [[rs485]]."""
    fault: list[FaultTable] = []  # type: ignore[valid-type]
    """What goes wrong, each begun by [[fault]]."""
    script: list[ScriptTable] = []
    """What somebody does at the machine, each begun by [[script]]."""


def shared_lines(contents: SceneFile) -> Iterator[tuple[str, str, LineTable, toml_places.Path]]:
    """The lines that motors share: kind, name, table and place."""
    for kind, tables in (("chain", contents.chain), ("rs485", contents.rs485)):
        for number, table in enumerate(tables):
            yield kind, table.name or (kind if not number else f"{kind}-{number + 1}"), table, (kind, number)
