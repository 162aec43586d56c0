"""The tables of a scene file with their keys and values."""

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import fields
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal

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

from axistwin.bench import product
from axistwin.bench.faults.kinds import KINDS
from axistwin.bench.faults.table import Parameter, Sort
from axistwin.core.errors import UsageError
from axistwin.plant import machine_units
from axistwin.plant.axes import servo_axis
from axistwin.plant.encoder import EncoderData
from axistwin.plant.machine_units import MachineUnits
from axistwin.plant.servo import SERVO_MOTORS, WHOLE, ServoLoad, ServoMotor
from axistwin.plant.torque import Load, StepperMotor
from axistwin.scenes import toml_places


def _schema(parameter: Parameter) -> tuple[Any, Any]:
    kinds = {Sort.WHOLE: int, Sort.NUMBER: float, Sort.LEVEL: Any, Sort.WORD: str}
    words: dict[str, Any] = {"enum": list(parameter.words)} if parameter.words else {}
    description = f"{parameter.doc}: {parameter.wanted}"
    return kinds[parameter.sort] | None, Field(None, description=description, json_schema_extra=words)


FAULT_PARAMETERS: dict[str, Any] = {
    parameter.name: _schema(parameter) for kind in KINDS.values() for parameter in kind.parameters
}


class Table(BaseModel):
    """Base class of the tables of a scene file; an unknown key in a table is an error."""

    model_config = ConfigDict(extra="forbid", use_attribute_docstrings=True, defer_build=True)


@contextmanager
def _pydantic_errors() -> Iterator[None]:
    """Convert a UsageError to a ValueError, because pydantic cannot handle a UsageError."""
    try:
        yield
    except UsageError as error:
        raise ValueError(error) from None


def _valued(check: Callable[[Any], object]) -> AfterValidator:
    def checked(given: Any) -> Any:
        with _pydantic_errors():
            check(given)
        return given

    return AfterValidator(checked)


class UnitsTable(Table):
    """The unit of an axis, e.g. millimetres."""

    per: Annotated[
        Any,
        _valued(machine_units.check_per),
        WithJsonSchema({"anyOf": [{"type": "number", "exclusiveMinimum": 0}, {"type": "string"}]}),
    ]
    """Motor pulses or encoder counts of one unit: 80, 6.4 or a fraction as text, "6400/360"."""
    of: Annotated[
        Any, _valued(machine_units.check_of), WithJsonSchema({"type": "string", "examples": ["mm", "deg", "rev"]})
    ]
    """Name of the unit: letters, or °."""


_POSITION = {"anyOf": [{"type": "integer"}, {"type": "string"}]}
_SPAN = {"type": "array", "minItems": 2, "maxItems": 2, "items": _POSITION}


def _in_counts(given: Any, info: ValidationInfo) -> Any:
    if not isinstance(given, str):
        return given
    # If the unit is invalid, the whole scene file is rejected, so any position can be returned.
    if "units" not in info.data:
        return 0
    table = info.data["units"]
    units = None if table is None else MachineUnits.given(table.model_dump())
    with _pydantic_errors():
        return machine_units.position(given, units)


Count = Annotated[int, BeforeValidator(_in_counts)]
Span = Annotated[tuple[Count, Count], WithJsonSchema(_SPAN)]
"""Two positions in counts; in a file also texts with a unit, e.g. "12.5 mm"."""


class AxisTable(Table):
    """An axis with a stepper motor: its switches, encoder, motor and load."""

    units: UnitsTable | None = None
    """Unit in which positions and velocities are also given and shown."""
    limits: Span | None = None
    """Positions, in motor pulses or in the unit of the axis, beyond which the minus and the plus limit switch open."""
    home: Span | None = None
    """First and last position at which the home input is high."""
    encoder: EncoderData | None = None
    """An encoder on the axis."""
    motor: StepperMotor | None = None
    """Data sheet of the motor; without it the motor never stalls."""
    load: Load | None = None
    """Load on the shaft."""

    @field_validator("limits", "home")
    @classmethod
    def _in_order(cls, ends: tuple[int, int] | None) -> tuple[int, int] | None:
        if ends is not None and ends[0] > ends[1]:
            raise ValueError("expected the lower position before the higher position, e.g. [0, 1000]")
        return ends


def _possible(path: Path) -> Path:
    if "\0" in str(path):
        raise ValueError("a file name cannot contain the character NUL")
    return path


File = Annotated[Path, AfterValidator(_possible)]
_ONE_OR_MORE = {"anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}}]}
_listed = BeforeValidator(lambda given: [given] if isinstance(given, str) else given)
Files = Annotated[list[File], _listed, WithJsonSchema(_ONE_OR_MORE)]
"""One file, or a list of files."""


def _values(made: type[Any], **more: Any) -> dict[str, Any]:
    numbers = {each.name: {"type": "integer" if each.name in WHOLE else "number"} for each in fields(made)}
    return {"type": "object", "properties": {**more, **numbers}, "additionalProperties": False}


_SHEETS = {
    "enum": list(SERVO_MOTORS),
    "description": "A data sheet; the other values of this table replace its values.",
}
SERVO_SCHEMA: dict[str, Any] = {
    "type": "object",
    "description": "The axis of a servo motor.",
    "properties": {
        "limits": {**_SPAN,
          "description": "Positions beyond which the limit switches minus and plus open: encoder counts, or '20 mm'."},
        "motor": {"anyOf": [_values(ServoMotor, model=_SHEETS), {"enum": list(SERVO_MOTORS)}],
          "description": "Data sheet of the motor, by name or by values; without it the motor is ideal."},
        "load": {**_values(ServoLoad), "description": "Load on the shaft."},
        "units": {**UnitsTable.model_json_schema(),
          "description": "Unit in which positions and velocities are also given and shown."},
    },
    "additionalProperties": False,
}  # fmt: skip
ServoTable = Annotated[dict[str, Any], WithJsonSchema(SERVO_SCHEMA)]
"""The axis of a servo motor."""
_STEPPERS = TypeAdapter(dict[str, AxisTable])
_SERVOS = TypeAdapter(dict[str, ServoTable])


class ControllerTable(Table):
    """Table [[controller]] of a scene file: the model, name and settings of one controller."""

    model: str
    """Model, e.g. "if1", "1811" or "smartmotor"."""
    name: Annotated[str, Field(pattern=r"^[\w-]+$")] | None = None
    """Name of the controller in wires, conversations and plots; the model if left out."""
    line: str | None = None
    """Line format of the host, if its port does not set one, e.g. "9600 8N2", or "instant"."""
    state: File | None = None
    """Directory for the data kept without power, relative to the scene file."""
    history: Annotated[int, Field(ge=1, le=1_000_000_000)] | None = None
    """Number of moves per axis that are recorded."""
    options: dict[str, Any] = {}
    """Options of the model."""
    axes: dict[str, AxisTable | ServoTable] = {}
    """The machine, one table per axis."""
    ports: list[str] = []
    """Ports of the controller: tcp://127.0.0.1:5001, rfc2217://127.0.0.1:0, pty:/tmp/if1, serial:///dev/ttyUSB0."""
    rs485_ports: list[str] = []
    """Ports of the second serial channel of a SmartMotor."""
    program: File | None = None
    """Source of a SmartMotor's stored program (.sms), relative to the scene file."""
    variables: dict[str, int] = {}
    """Variables and gains of a SmartMotor at power-up, before its program begins, e.g. { KP = 100, a = 3 }."""
    host: Files = []
    """Command lines (.if1, .181x) or conversations (.talk) of its hosts, relative to the scene file."""
    master: str | None = None
    """Axis that drives a SmartMotor's external encoder, as "name.axis"."""
    master_ratio: tuple[int, Annotated[int, Field(ge=1)]] = (1, 1)
    """Encoder edges per unit of that axis (motor pulse or encoder count), as [edges, units]."""

    @field_validator("axes", mode="wrap")
    @classmethod
    def _as_the_model_has_them(cls, given: Any, _: ValidatorFunctionWrapHandler, info: ValidationInfo) -> Any:
        model = info.data.get("model")
        try:
            adapter = _SERVOS if has_servo(model or "") else _STEPPERS
        except UsageError:
            return {}  # The model is the error, whatever its axes are.
        return adapter.validate_json(json.dumps(given), strict=True)

    @property
    def called(self) -> str:
        return self.name or self.model.lower()


def has_servo(model: str) -> bool:
    """Return whether the axes of a model are servo motors.  Raises UsageError for an unknown model."""
    return product(model).make_axis is servo_axis


class LineTable(Table):
    """A serial line shared by motors."""

    motors: Annotated[list[str], Field(min_length=1)]
    """Names of the motors; in a daisy chain, beginning with the motor next to the host."""
    name: Annotated[str, Field(pattern=r"^[\w-]+$")] | None = None
    """Name of the line in conversations and traces; "chain" or "rs485" if left out."""
    ports: list[str] = []
    """Ports for the host's end of the line."""
    host: Files = []
    """Conversations (.talk) of its hosts, relative to the scene file."""


class WireTable(Table):
    """An electrical wire between two pins, e.g. from `table.output1` to `feeder.input1`."""

    from_: Annotated[str, Field(alias="from")]
    """Terminal at the beginning of the wire, as "name.pin"."""
    to: str
    """Terminal at the end of the wire, as "name.pin"."""
    invert: bool = False
    """True: the wire inverts the level."""
    delay_ms: Annotated[float, Field(ge=0)] = 0.0
    """Delay of each change, in milliseconds."""


Name = Annotated[str, Field(pattern=r"^[\w-]+$")]


class FaultTerms(Table):
    """The keys that all faults of a scene have, e.g. kind, start time and duration."""

    kind: Annotated[str, Field(json_schema_extra={"enum": list(KINDS)})]
    """Kind of fault; `axistwin faults` lists them."""
    on: str = ""
    """Place of the fault, e.g. "table.serial", "table.input1", "table.X" or "table"."""
    name: Name | None = None
    """Name of the fault; its kind if left out."""
    at: Annotated[float, Field(ge=0)] | None = None
    """Start time, in seconds from the beginning."""
    when: str | None = None
    """Event that starts the fault, e.g. "table.X passes 1000"."""
    nth: Annotated[int, Field(ge=1)] = 1
    """Occurrence of the event that starts the fault: 1 is the first."""
    duration: Annotated[float, Field(ge=0)] | None = None
    """Duration in seconds; unlimited if left out."""
    seed: int | None = None
    """Seed of random values; derived from the scene's seed if left out."""

    @property
    def parameters(self) -> dict[str, Any]:
        return self.model_dump(exclude_none=True, exclude=set(FaultTerms.model_fields))


FaultTable = create_model("FaultTable", __base__=FaultTerms, **FAULT_PARAMETERS)


Acts = Annotated[list[str], _listed, WithJsonSchema(_ONE_OR_MORE)]


class ScriptTable(Table):
    """A script entry: one or more actions, and the time at which the actions are performed."""

    at: Annotated[float, Field(ge=0)]
    """Time, in seconds from the beginning."""
    do: Acts
    """Actions as after `!` in a conversation: "input1 high", "X.jam on", "fault lose 3"."""
    on: str = ""
    """Controller with these pins and axes; may be left out if there is only one controller."""


Pin = Annotated[str, Field(pattern=r"^[\^~]?!?\w+$")]
"""A pin of a motion board as Klipper writes it: `^` pull-up, `~` pull-down, `!` inverted, then the name."""


def _position(given: Any) -> Any:
    if type(given) is not int and not isinstance(given, str):
        raise ValueError(
            "invalid travel limit: expected a whole number of pulses or a text with a unit, e.g. 1000 or '12.5 mm'"
        )
    return given


def _rate(given: Any) -> Any:
    if not isinstance(given, str) and not (type(given) in (int, float) and given > 0):
        raise ValueError("expected a step rate or velocity above 0, e.g. 4000 (pulses/s) or '50 mm/s'")
    return given


class BoardTable(Table):
    """Connection to real motors: a board with Klipper's firmware, or LinuxCNC HAL on this computer."""

    name: Name
    """Name of the board."""
    port: str | None = None
    """Serial port of the board, e.g. "/dev/ttyACM0"."""
    hal: File | None = None
    """Instead of a port: LinuxCNC HAL, with the HAL commands of this file, relative to the scene file."""
    baud: Annotated[int, Field(ge=1200)] = 250_000
    """Baud rate of the firmware; a board with native USB ignores it."""


Position = Annotated[Any, AfterValidator(_position), WithJsonSchema(_POSITION)]
Rate = Annotated[
    Any,
    AfterValidator(_rate),
    WithJsonSchema({"anyOf": [{"type": "number", "exclusiveMinimum": 0}, {"type": "string"}]}),
]


class BoardAxisTable(Table):
    """The connection of an axis to the drive of a real motor."""

    axis: str
    """Axis as "controller.axis"; the encoder counts of a servo axis become pulses."""
    board: str | None = None
    """Name of the board; may be left out if there is only one."""
    step: Pin | None = None
    """Pin of the step input of the drive.  Axes at HAL have no pins of a board."""
    direction: Pin | None = None
    """Pin of the direction input; high in the positive direction."""
    enable: Pin | None = None
    """Pin of the enable input; off when the board stops."""
    pulse_us: Annotated[float, Field(gt=0, le=1000)] = 2.0
    """Minimum width of a step pulse, in microseconds."""
    travel: tuple[Position, Position] | None = None
    """Lowest and highest position in pulses or in the unit of the axis; motion beyond them is refused."""
    max_rate: Rate | None = None
    """Highest step rate in pulses per second, or a velocity, e.g. "50 mm/s"; a higher rate is refused."""


class BoardInputTable(Table):
    """A switch or a signal of the machine, connected to an input of a controller."""

    to: str
    """Input of a controller, as "controller.pin"."""
    pin: Pin | None = None
    """Pin of the board; none at HAL."""
    board: str | None = None
    """Name of the board; may be left out if there is only one."""
    stops: Literal["plus", "minus", "both"] | None = None
    """Direction of motion that the board stops at once; none if left out."""
    stops_at: Literal["low", "high"] = "low"
    """Level of the controller's input at which motion stops."""


class BoardOutputTable(Table):
    """Connection of a virtual controller's output to the real machine, e.g. through a pin of a motion board."""

    source: Annotated[str, Field(alias="from")]
    """Output of a controller, as "controller.pin"."""
    pin: Pin | None = None
    """Pin of the board; none at HAL."""
    board: str | None = None
    """Name of the board; may be left out if there is only one."""
    safe: Literal["low", "high"] = "low"
    """Level when the board has stopped."""


class StandInTable(Table):
    """Real motors on motion boards, for `axistwin stand-in`."""

    horizon_ms: Annotated[float, Field(ge=50, le=2000)] = 100.0
    """Constant delay of all pulses and outputs at the pins, in milliseconds."""
    watchdog_ms: Annotated[float, Field(ge=20, le=2000)] = 100.0
    """Time after which a board without commands stops all axes, in milliseconds; at most the horizon."""
    journal: File | None = None
    """Journal of pulses and positions, relative to the scene file; the scene's name with .journal if left out."""
    board: Annotated[list[BoardTable], Field(min_length=1)]
    """Boards, one [[stand-in.board]] each."""
    axis: Annotated[list[BoardAxisTable], Field(min_length=1)]
    """Axes, one [[stand-in.axis]] each."""
    input: list[BoardInputTable] = []
    """Inputs, one [[stand-in.input]] each."""
    output: list[BoardOutputTable] = []
    """Outputs, one [[stand-in.output]] each."""


class PanelTable(Table):
    """Options of the panel for this scene."""

    wait: bool = False
    """`true`: virtual time starts when the first browser or host connects to `axistwin serve`."""


class ButtonTable(Table):
    """A button of the operator panel."""

    name: str
    """Inscription."""
    pin: str
    """Input of a controller, as "controller.pin"."""
    pressed: Literal["high", "low"] = "high"
    """Level of the input while the button is pressed; the other level while it is free."""
    latching: bool = False
    """`true`: each click presses or releases the button; otherwise the button is pressed while it is held."""


class LampTable(Table):
    """A lamp of the operator panel."""

    name: str
    """Inscription."""
    pin: str
    """Terminal of a controller, as "controller.pin"."""
    lit: Literal["high", "low"] = "high"
    """Level at which the lamp is lit."""


class SelectorTable(Table):
    """A selector switch of the operator panel.  Only the controller input of the selected position is active."""

    name: str
    """Inscription."""
    positions: Annotated[dict[str, str], Field(min_length=2)]
    """Input of each position by its inscription, as "controller.pin"; "": no input."""
    selected: Literal["high", "low"] = "high"
    """Level of the input at the selected position; all other inputs of the switch have the opposite level."""


class OperatorTable(Table):
    """The operator panel of the machine, with buttons, lamps and selector switches."""

    button: list[ButtonTable] = []
    """Buttons, one [[operator.button]] each."""
    lamp: list[LampTable] = []
    """Lamps, one [[operator.lamp]] each."""
    selector: list[SelectorTable] = []
    """Selector switches, one [[operator.selector]] each."""

    @property
    def items(self) -> bool:
        return bool(self.button or self.lamp or self.selector)


class SceneFile(Table):
    """Contents of a scene file."""

    title: str = ""
    """Title in a few words."""
    seed: int | None = None
    """Seed of random values."""

    controller: Annotated[list[ControllerTable], Field(min_length=1)]
    """Controllers, one [[controller]] each."""
    wire: list[WireTable] = []
    """Wires, one [[wire]] each."""
    chain: list[LineTable] = []
    """RS232 daisy chains, one [[chain]] each."""
    rs485: list[LineTable] = []
    """RS485 lines, one [[rs485]] each."""
    fault: list[FaultTable] = []  # type: ignore[valid-type]
    """Faults, one [[fault]] each."""
    script: list[ScriptTable] = []
    """Actions at the machine, one [[script]] each."""
    stand_in: Annotated[StandInTable | None, Field(alias="stand-in")] = None
    """Real motors on motion boards."""
    panel: PanelTable = PanelTable()
    """Settings for `axistwin serve` and its panel."""
    operator: OperatorTable = OperatorTable()
    """Operator panel, shown by the panel."""


@cache
def scene_schema() -> dict[str, Any]:
    return SceneFile.model_json_schema()


def shared_lines(contents: SceneFile) -> Iterator[tuple[str, str, LineTable, toml_places.Path]]:
    for kind, tables in (("chain", contents.chain), ("rs485", contents.rs485)):
        for number, table in enumerate(tables):
            yield kind, table.name or (kind if not number else f"{kind}-{number + 1}"), table, (kind, number)
