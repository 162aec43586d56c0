"""Read the table [stand-in] of a scene: check it against the bench, and return one wiring for each board."""

from dataclasses import dataclass
from pathlib import Path

from axistwin.bench import Bench
from axistwin.errors import UsageError
from axistwin.plant import StepperAxis
from axistwin.plant.machine_units import position, rate
from axistwin.scenes.scene import Scene
from axistwin.scenes.tables import BoardAxisTable, BoardTable, StandInTable
from axistwin.standin.wiring import AxisPins, BoardPin, InputPin, OutputPin, Wiring

DIRECTIONS = {"plus": +1, "minus": -1, "both": 0, None: None}


@dataclass(frozen=True)
class Plan:
    """The settings of a stand-in, read from the scene file."""

    boards: tuple[tuple[BoardTable, Wiring], ...]
    horizon_s: float
    watchdog_s: float
    journal: Path


def read(scene: Scene, bench: Bench, port: str | None = None) -> Plan:
    """Return the stand-in of a scene; `port` replaces the port of its only board.

    Raises SceneError with the place in the file; UsageError if the scene has no stand-in.
    """
    table = scene.stand_in
    if table is None:
        raise UsageError(f"{scene.file} has no table [stand-in]: expected a table with a board and its axes")
    if table.watchdog_ms > table.horizon_ms:
        with scene.placing_errors("stand-in", "watchdog_ms"):
            raise UsageError(
                f"watchdog_ms {table.watchdog_ms:g} is above horizon_ms {table.horizon_ms:g}: expected at most this"
            )
    boards = {board.name: board for board in table.board}
    if port is not None:
        if len(boards) > 1:
            raise UsageError("--board is only for a scene with one board: set the ports of these boards in the scene")
        boards = {name: board.model_copy(update={"port": port}) for name, board in boards.items()}
    wirings = tuple((board, _wiring(scene, bench, table, name)) for name, board in boards.items())
    journal = table.journal or Path(f"{scene.file.stem}.journal")
    return Plan(wirings, table.horizon_ms / 1e3, table.watchdog_ms / 1e3, scene.file.parent / journal)


def _bounds(
    scene: Scene, bench: Bench, table: BoardAxisTable, number: int
) -> tuple[tuple[int, int] | None, float | None]:
    """Return the limits of an axis: travel in pulses and highest rate in pulses/s; None for no limit."""
    name, _, axis = table.axis.rpartition(".")
    units = bench[name].axes[axis].units
    travel = max_rate = None
    with scene.placing_errors("stand-in", "axis", number, "travel"):
        if table.travel is not None:
            first, last = (position(end, units) for end in table.travel)
            travel = first, last
    with scene.placing_errors("stand-in", "axis", number, "max_rate"):
        if table.max_rate is not None:
            max_rate = rate(table.max_rate, units)
    return travel, max_rate


def _wiring(scene: Scene, bench: Bench, table: StandInTable, board: str) -> Wiring:
    axes, inputs, outputs = [], [], []
    for number, axis in enumerate(table.axis):
        with scene.placing_errors("stand-in", "axis", number, "axis"):
            _check_axis(bench, axis.axis)
        if _board(scene, table, axis.board, "axis", number) == board:
            pins = (BoardPin.read(axis.step), BoardPin.read(axis.direction), BoardPin.read(axis.enable))
            travel, max_rate = _bounds(scene, bench, axis, number)
            axes.append(AxisPins(axis.axis, *pins, axis.pulse_us, travel, max_rate))
    for number, given in enumerate(table.input):
        with scene.placing_errors("stand-in", "input", number, "to"):
            _check_pin(bench, given.to, output=False)
        if _board(scene, table, given.board, "input", number) == board:
            stops_at = given.stops_at == "high"
            inputs.append(InputPin(given.to, BoardPin.read(given.pin), DIRECTIONS[given.stops], stops_at))
    for number, output in enumerate(table.output):
        with scene.placing_errors("stand-in", "output", number, "from"):
            _check_pin(bench, output.source, output=True)
        if _board(scene, table, output.board, "output", number) == board:
            outputs.append(OutputPin(output.source, BoardPin.read(output.pin), output.safe == "high"))
    wiring = Wiring(board, tuple(axes), tuple(inputs), tuple(outputs), watchdog_s=table.watchdog_ms / 1e3)
    with scene.placing_errors("stand-in"):
        if not axes:
            raise UsageError(f"board {board} has no axis: expected a [[stand-in.axis]] with board = {board!r}")
        wiring.check()
    return wiring


def _board(scene: Scene, table: StandInTable, name: str | None, kind: str, number: int) -> str:
    names = [board.name for board in table.board]
    with scene.placing_errors("stand-in", kind, number):
        if name is None and len(names) > 1:
            raise UsageError(f"the board is missing: expected board = one of {', '.join(names)}")
        if name is not None and name not in names:
            raise UsageError(f"no board {name!r}: there are {', '.join(names)}")
    return name or names[0]


def _check_axis(bench: Bench, whole: str) -> None:
    controller, _, name = whole.rpartition(".")
    if controller not in bench.controllers or name not in bench[controller].axes:
        known = ", ".join(f"{each}.{axis}" for each in bench.controllers for axis in bench[each].axes)
        raise UsageError(f"no axis {whole!r}: there are {known}")
    if not isinstance(bench[controller].axes[name], StepperAxis):
        raise UsageError(f"{whole} is a servo axis: expected an axis with a stepper motor")


def _check_pin(bench: Bench, whole: str, *, output: bool) -> None:
    controller, _, name = whole.rpartition(".")
    if controller not in bench.controllers or name not in bench[controller].pins:
        raise UsageError(f"no terminal {whole!r}: expected NAME.PIN, e.g. table.input1")
    pin = bench[controller].pins[name]
    if output and (pin.silent or not pin.is_output):
        raise UsageError(f"{whole} is not a switched output: expected an output such as output1 or shutdown")
    if not output and pin.is_output:
        raise UsageError(f"{whole} is an output: expected an input of the controller")


def lines(plan: Plan) -> list[str]:
    """Return the plan as lines of text: each pin with its use, and the limits of each axis."""
    found = [f"horizon {plan.horizon_s * 1e3:g} ms, watchdog {plan.watchdog_s * 1e3:g} ms, journal {plan.journal}"]
    for table, wiring in plan.boards:
        found.append(f"board {wiring.name} on {table.port}, {table.baud} baud")
        found += [f"  {pin!s:8} {use}{_note(wiring, use)}" for pin, use in wiring.used()]
        for axis in wiring.axes:
            travel = "any" if axis.travel is None else f"{axis.travel[0]} to {axis.travel[1]}"
            rate = "any" if axis.max_rate is None else f"{axis.max_rate:g} pulses/s"
            found.append(f"  {axis.axis}: pulse {axis.pulse_us:g} µs, travel {travel}, rate {rate}")
    return found


def _note(wiring: Wiring, use: str) -> str:
    for given in wiring.inputs:
        if use == f"{given.to} input" and given.stops is not None:
            which = {+1: "plus motion", -1: "minus motion", 0: "all motion"}[given.stops]
            return f", stops {which} at {'high' if given.stops_at else 'low'}"
    return ""
