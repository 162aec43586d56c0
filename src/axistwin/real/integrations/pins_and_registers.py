"""Pins and registers of a controller, as values that can be read and written.

| family | pins | registers, on request |
| --- | --- | --- |
| IF1, IF2 | `input1` to `input3`, `output1` to `output5` | |
| 1810, 1811 | `trigger2` to `trigger5`, `output1`, `output2` | `encoder` |
| SmartMotor | `A` to `G` (a written pin becomes an output) | variables `a` to `zzz`, reports such as `RTEMP` |

A pin of a motor in a chain has the name of its axis before it: `shaft2.A`.
"""

import re
from collections.abc import Awaitable, Callable, Iterable, Iterator
from typing import Any

from axistwin.core.errors import UsageError
from axistwin.drivers.asynchronous import AsyncController
from axistwin.drivers.board import Board
from axistwin.drivers.errors import RefusedError
from axistwin.drivers.if1 import IF1
from axistwin.drivers.smartmotor import Shaft, SmartMotors

VARIABLE = re.compile(r"([a-z])\1{0,2}")
REPORT = re.compile(r"R[A-Za-z]+")

Read = Callable[[], Awaitable[int]]
Write = Callable[[int], Awaitable[None]]


class Point:
    """A pin or register.  `value` is None until the first reading, for outputs until the first writing."""

    def __init__(self, name: str, read: Read | None, write: Write | None = None, *, bit: bool = True) -> None:
        self.name, self.bit = name, bit
        self.value: int | None = None
        self.observers: list[Callable[[int], Awaitable[None]]] = []  # Called with each new value.
        self._read, self._write = read, write

    @property
    def writable(self) -> bool:
        return self._write is not None

    async def refresh(self) -> None:
        if self._read is not None:
            await self._set(await self._read())

    async def write(self, value: int) -> None:
        """Write a value.  Raises RefusedError if the pin or register cannot be written, or cannot have this value."""
        if self._write is None:
            raise RefusedError(f"{self.name} cannot be written: expected an output or a variable")
        if self.bit and value not in (0, 1):
            raise RefusedError(f"{self.name} cannot be {value}: expected 0 or 1")
        await self._write(value)
        await self._set(value)

    async def _set(self, value: int) -> None:
        if value != self.value:
            self.value = value
            for observer in self.observers:
                await observer(value)


class _Group:
    """Pins that the controller reports in one answer; the answer is used for each pin once."""

    def __init__(self, ask: Callable[[], Awaitable[dict[Any, bool]]]) -> None:
        self._ask = ask
        self._unused: dict[Any, bool] = {}

    def reader(self, key: Any) -> Read:
        async def read() -> int:
            if key not in self._unused:
                self._unused = await self._ask()
            return int(self._unused.pop(key))

        return read


def points_of(driver: AsyncController, registers: Iterable[str] = ()) -> list[Point]:
    """Return the pins of a controller and the requested registers.  Raises UsageError for an unknown register."""
    core = driver.core
    if isinstance(core, IF1):
        found, known = list(_of_if1(driver)), ""
    elif isinstance(core, Board):
        found, known = list(_of_board(driver)), "encoder"
    elif isinstance(core, SmartMotors):
        found, known = list(_of_motors(driver, core)), "a variable or a report, e.g. a or RTEMP"
    else:
        found, known = [], "none, because its driver knows axes only"
    return found + [_register(driver, name, known) for name in registers]


def _of_if1(driver: AsyncController) -> Iterator[Point]:
    inputs = _Group(driver.inputs)
    for number in (1, 2, 3):
        yield Point(f"input{number}", inputs.reader(number))
    for number in (1, 2, 3, 4, 5):

        async def write(value: int, number: int = number) -> None:
            await driver.outputs(**{"on" if value else "off": [number]})

        yield Point(f"output{number}", None, write)


def _of_board(driver: AsyncController) -> Iterator[Point]:
    triggers = _Group(driver.triggers)
    for number in (2, 3, 4, 5):
        yield Point(f"trigger{number}", triggers.reader(number))
    for number in (1, 2):

        async def write(value: int, number: int = number) -> None:
            await driver.command(0x0B if value else 0x0C, number)

        yield Point(f"output{number}", None, write)


def _of_motors(driver: AsyncController, core: SmartMotors) -> Iterator[Point]:
    for axis, shaft in core.axes.items():
        assert isinstance(shaft, Shaft)
        before = f"{axis}." if len(core.axes) > 1 else ""
        pins = _Group(lambda axis=axis: driver.inputs(axis))  # type: ignore[misc]
        for pin in "ABCDEFG":

            async def write(value: int, axis: str = axis, pin: str = pin) -> None:
                await driver.outputs(axis, **{pin: bool(value)})

            wired = core.limits and pin in "CD"
            yield Point(before + pin, pins.reader(pin), None if wired else write)


def _register(driver: AsyncController, name: str, known: str) -> Point:
    axis, _, last = name.rpartition(".")
    if isinstance(driver.core, Board) and name == "encoder":
        return Point(name, driver.encoder, bit=False)
    variable = VARIABLE.fullmatch(last)
    is_known = isinstance(driver.core, SmartMotors) and (variable or REPORT.fullmatch(last))
    if not is_known or (axis and axis not in driver.axes):
        raise UsageError(f"unknown register {name!r}: expected {known or 'none, because an IF1 has no registers'}")

    async def read() -> int:
        return int(await driver.number(f"R{last}" if variable else last, axis or None))

    async def write(value: int) -> None:
        await driver.command(f"{last}={value}", axis or None)

    return Point(name, read, write if variable else None, bit=False)
