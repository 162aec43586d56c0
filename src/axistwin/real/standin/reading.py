"""Read the table [stand-in] of a scene: check it against the bench, and return one wiring for each board."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TypedDict

from axistwin.bench import Bench
from axistwin.core.errors import UsageError
from axistwin.plant.machine_units import position, rate
from axistwin.real.standin.hal.wiring import HalWiring
from axistwin.real.standin.wiring import AxisPins, BoardPin, DrivenAxis, InputPin, OutputPin, Sensed, Switched, Wiring
from axistwin.scenes.scene import Scene
from axistwin.scenes.tables import BoardAxisTable, BoardInputTable, BoardOutputTable, BoardTable, StandInTable, Table
from axistwin.sim.pins import Pin

DIRECTIONS = {"plus": +1, "minus": -1, "both": 0, None: None}


class _Bounds(TypedDict):
    travel: tuple[int, int] | None
    max_rate: float | None


class _Stops(TypedDict):
    stops: int | None
    stops_at: bool


@dataclass(frozen=True)
class Plan:
    """The table [stand-in] of a scene: settings for the control of real motors."""

    boards: tuple[tuple[BoardTable, Wiring | HalWiring], ...]
    horizon_s: float
    watchdog_s: float
    journal: Path

    @property
    def axes(self) -> list[str]:
        return [axis.axis for _, wiring in self.boards for axis in wiring.axes]


def read(scene: Scene, bench: Bench, port: str | None = None) -> Plan:
    """Read the table [stand-in] of a scene file: the settings to drive real motors.

    `port` replaces the port of the only board in the scene.  Raises SceneError with the place in the scene file;
    UsageError if the scene has no table [stand-in].
    """
    table = scene.stand_in
    if table is None:
        raise UsageError(f"{scene.file} has no table [stand-in]: expected a table with a board and its axes")
    if table.watchdog_ms > table.horizon_ms:
        with scene.placing_errors("stand-in", "watchdog_ms"):
            raise UsageError(
                f"watchdog_ms is too large ({table.watchdog_ms:g} ms): "
                f"expected at most horizon_ms ({table.horizon_ms:g} ms)"
            )
    boards = {board.name: board for board in table.board}
    if port is not None and any(board.hal is not None for board in boards.values()):
        raise UsageError("--board sets a serial port, but the scene uses LinuxCNC HAL: remove the option --board")
    if port is not None:
        if len(boards) > 1:
            raise UsageError(
                "--board sets the port of a single board, but the scene has several boards: "
                "set the port of each board in the scene file"
            )
        boards = {name: board.model_copy(update={"port": port}) for name, board in boards.items()}
    reader = _Reader(scene, bench, table, boards)
    wirings = tuple((board, reader.wiring(name)) for name, board in boards.items())
    journal = table.journal or Path(f"{scene.file.stem}.journal")
    return Plan(wirings, table.horizon_ms / 1e3, table.watchdog_ms / 1e3, scene.file.parent / journal)


class _Reader:
    def __init__(self, scene: Scene, bench: Bench, table: StandInTable, boards: Mapping[str, BoardTable]) -> None:
        self._scene, self._bench, self._table, self._boards = scene, bench, table, boards

    def wiring(self, name: str) -> Wiring | HalWiring:
        scene, board = self._scene, self._boards[name]
        with scene.placing_errors("stand-in", "board", list(self._boards).index(name)):
            if (board.port is None) is (board.hal is None):
                raise UsageError(
                    'a board needs either a port or a HAL file: expected port = "/dev/ttyACM0" or hal = "FILE.hal"'
                )
        wiring = self._hal(board, scene.file.parent / board.hal) if board.hal is not None else self._pins(board)
        with scene.placing_errors("stand-in"):
            if not wiring.axes:
                raise UsageError(f"board {name} has no axis: expected a [[stand-in.axis]] with board = {name!r}")
            wiring.check()
        return wiring

    def _pins(self, board: BoardTable) -> Wiring:
        axes, inputs, outputs = [], [], []
        for number, axis in self._axes(board):
            enable, direction, step = (self._pin("axis", number, axis, key) for key in ("enable", "direction", "step"))
            axes.append(AxisPins(axis.axis, step, direction, enable, axis.pulse_us, **self._bounds(axis, number)))
        for number, given in self._inputs(board):
            inputs.append(InputPin(given.to, self._pin("input", number, given, "pin"), **_stops(given)))
        for number, output in self._outputs(board):
            pin = self._pin("output", number, output, "pin")
            outputs.append(OutputPin(output.source, pin, safe=output.safe == "high"))
        watchdog_s = self._table.watchdog_ms / 1e3
        return Wiring(board.name, tuple(axes), tuple(inputs), tuple(outputs), watchdog_s=watchdog_s)

    def _hal(self, board: BoardTable, file: Path) -> HalWiring:
        axes, inputs, outputs = [], [], []
        for number, axis in self._axes(board):
            for key in ("step", "direction", "enable"):
                self._no_pin("axis", number, axis, key)
            axes.append(DrivenAxis(axis.axis, **self._bounds(axis, number)))
        for number, given in self._inputs(board):
            self._no_pin("input", number, given, "pin")
            inputs.append(Sensed(given.to, **_stops(given)))
        for number, output in self._outputs(board):
            self._no_pin("output", number, output, "pin")
            outputs.append(Switched(output.source, safe=output.safe == "high"))
        return HalWiring(board.name, tuple(axes), tuple(inputs), tuple(outputs), file)

    # TOML tables of the scene that describe one board

    def _axes(self, board: BoardTable) -> Iterator[tuple[int, BoardAxisTable]]:
        for number, axis in enumerate(self._table.axis):
            with self._scene.placing_errors("stand-in", "axis", number, "axis"):
                _check_axis(self._bench, axis.axis)
            if self._board(axis.board, "axis", number) == board.name:
                yield number, axis

    def _inputs(self, board: BoardTable) -> Iterator[tuple[int, BoardInputTable]]:
        for number, given in enumerate(self._table.input):
            with self._scene.placing_errors("stand-in", "input", number, "to"):
                _check_pin(self._bench, given.to, output=False)
            if self._board(given.board, "input", number) == board.name:
                yield number, given

    def _outputs(self, board: BoardTable) -> Iterator[tuple[int, BoardOutputTable]]:
        for number, output in enumerate(self._table.output):
            with self._scene.placing_errors("stand-in", "output", number, "from"):
                _check_pin(self._bench, output.source, output=True)
            if self._board(output.board, "output", number) == board.name:
                yield number, output

    def _board(self, name: str | None, kind: str, number: int) -> str:
        names = list(self._boards)
        with self._scene.placing_errors("stand-in", kind, number):
            if name is None and len(names) > 1:
                raise UsageError(
                    f"the key `board` is missing: expected `board` with one of the names {', '.join(names)}"
                )
            if name is not None and name not in names:
                raise UsageError(f"no board {name!r}: expected one of {', '.join(names)}")
        return name or names[0]

    # Values

    def _pin(self, kind: str, number: int, table: Table, key: str) -> BoardPin:
        text = getattr(table, key)
        with self._scene.placing_errors("stand-in", kind, number):
            if text is None:
                raise UsageError(f'the key `{key}` is missing: expected a pin of the board, e.g. {key} = "PD2"')
        return BoardPin.read(text)

    def _no_pin(self, kind: str, number: int, table: Table, key: str) -> None:
        if getattr(table, key) is not None:
            with self._scene.placing_errors("stand-in", kind, number, key):
                raise UsageError(
                    f"the key `{key}` is only for motion boards, but this {kind} is connected through LinuxCNC HAL: "
                    "delete the key"
                )

    def _bounds(self, table: BoardAxisTable, number: int) -> _Bounds:
        """Return the travel limits of an axis in pulses and its highest rate in pulses/s."""
        name, _, axis = table.axis.rpartition(".")
        units, bounds = self._bench[name].axes[axis].units, _Bounds(travel=None, max_rate=None)
        with self._scene.placing_errors("stand-in", "axis", number, "travel"):
            if table.travel is not None:
                first, last = (position(end, units) for end in table.travel)
                bounds["travel"] = first, last
        with self._scene.placing_errors("stand-in", "axis", number, "max_rate"):
            if table.max_rate is not None:
                bounds["max_rate"] = rate(table.max_rate, units)
        return bounds


def _stops(given: BoardInputTable) -> _Stops:
    return _Stops(stops=DIRECTIONS[given.stops], stops_at=given.stops_at == "high")


def _check_axis(bench: Bench, axis: str) -> None:
    controller, _, name = axis.rpartition(".")
    if controller not in bench.controllers or name not in bench[controller].axes:
        axes = [f"{each}.{found}" for each in bench.controllers for found in bench[each].axes]
        raise UsageError(f"no axis {axis!r}: expected one of {', '.join(axes)}")


def _check_pin(bench: Bench, terminal: str, *, output: bool) -> None:
    def suits(pin: Pin) -> bool:
        return pin.is_output is output and not (output and pin.silent)

    controller, _, name = terminal.rpartition(".")
    machines = bench.controllers.items()
    suitable = (f"{called}.{pin}" for called, each in machines for pin in each.pins if suits(each.pins[pin]))
    example = next(suitable, "CONTROLLER.TERMINAL")
    if controller not in bench.controllers or name not in bench[controller].pins:
        raise UsageError(f"no terminal {terminal!r}: expected CONTROLLER.TERMINAL, e.g. {example}")
    if not suits(bench[controller].pins[name]):
        if output:
            raise UsageError(f"{terminal} is not an output that switches on and off: expected e.g. {example}")
        raise UsageError(f"{terminal} is an output: expected an input of a controller, e.g. {example}")


def lines(plan: Plan) -> list[str]:
    """Describe the settings of the boards, with a line for each pin and each axis."""
    found = [f"horizon {plan.horizon_s * 1e3:g} ms, watchdog {plan.watchdog_s * 1e3:g} ms, journal {plan.journal}"]
    for table, wiring in plan.boards:
        if isinstance(wiring, HalWiring):
            found.append(f"{wiring.name}: LinuxCNC HAL with {wiring.file}")
            found += [f"  {pin:34} {use}{_note(wiring, pin.removeprefix('axistwin.'))}" for pin, use in wiring.used()]
        else:
            found.append(f"board {wiring.name} on {table.port}, {table.baud} baud")
            found += [f"  {pin!s:8} {use}{_note(wiring, use.removesuffix(' input'))}" for pin, use in wiring.used()]
        for axis in wiring.axes:
            travel = "any" if axis.travel is None else f"{axis.travel[0]} to {axis.travel[1]}"
            rate = "any" if axis.max_rate is None else f"{axis.max_rate:g} pulses/s"
            pulse = f"pulse {axis.pulse_us:g} µs, " if isinstance(axis, AxisPins) else ""
            found.append(f"  {axis.axis}: {pulse}travel {travel}, rate {rate}")
    return found


def _note(wiring: Wiring | HalWiring, terminal: str) -> str:
    for given in wiring.inputs:
        if given.to == terminal and given.stops is not None:
            which = {+1: "plus motion", -1: "minus motion", 0: "all motion"}[given.stops]
            return f", stops {which} at {'high' if given.stops_at else 'low'}"
    return ""
