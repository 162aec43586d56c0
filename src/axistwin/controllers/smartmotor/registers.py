"""What one can look into: every value that can stand in an expression and is kept in the motor, and the mode.

They are called by the commands that report them, as RPE for @PE, since A to G are terminals; the buffered P and V,
which cannot be reported, by their own names.  Left out are CLK, which is the time itself, what has to be fetched from
outside, and the levels of pins.  `line` is the line of the stored program that is being carried out.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import cache, partial
from typing import TYPE_CHECKING

from axistwin.controllers.product import Follower, Register
from axistwin.controllers.smartmotor import log, state
from axistwin.controllers.smartmotor.interpreter import AT_STATEMENT, COMPUTED, SLOT, VARIABLE
from axistwin.controllers.smartmotor.listing import LINE, Lines
from axistwin.controllers.smartmotor.state import USER_PINS
from axistwin.controllers.smartmotor.variables import NOTHING, TABLE
from axistwin.sim.clock import Clock

if TYPE_CHECKING:
    from axistwin.controllers.smartmotor.motor import Motor

LEFT_OUT = ("CLK", "I")
BUFFERED = ("P", "V")
WHILE_RESTING = ("RTEMP",)
"""These change although nothing happens."""
COSTLY = (*WHILE_RESTING, LINE)
"""These change so often that nobody wants them who does not ask for them; `line` in every sample of a program."""


@cache
def numbers() -> Mapping[str, tuple[int, int]]:
    """Where each of them is: an operation and a place.  `I` is looked at here, not used."""
    found = {
        _called(variable.name): (variable.operation, variable.place)
        for variable in TABLE
        if variable.operation in (SLOT, VARIABLE, COMPUTED)
        and variable.place != NOTHING
        and variable.name not in LEFT_OUT
    }
    return found | {"RI": (SLOT, state.INDEX), "RMODE": (SLOT, state.MODE), LINE: (COMPUTED, AT_STATEMENT)}


class Registers:
    """Reads them, and has them followed, in whatever processor has the power."""

    def __init__(self, clock: Clock, lines: Lines) -> None:
        self.clock, self._lines = clock, lines
        self._motor: Motor | None = None
        self._names: Sequence[str] = ()
        self._follower: Follower = lambda times, which, values: None

    def connect(self, motor: "Motor | None") -> None:
        """This processor has its power on now; everything in it is as it is at power-up."""
        self._motor = motor
        if motor is not None and self._names:
            self._begin()
            count = len(self._names)
            self._follower([self.clock.now] * count, range(count), [self._read(name) for name in self._names])

    def table(self) -> dict[str, Register]:
        """All of them, also under their names in an expression."""
        return {name: Register(partial(self._look, name), _also(name), costly=name in COSTLY) for name in numbers()}

    def follow(self, names: Sequence[str], follower: Follower) -> Callable[[], None]:
        """Tell one follower of each change of these."""
        self._names, self._follower = tuple(names), self._lines.in_lines(names, follower)
        self._begin()
        return self._end

    def _begin(self) -> None:
        if self._motor is not None:
            places = [numbers()[name] for name in self._names]
            restless = any(name in WHILE_RESTING for name in self._names)
            self._motor.core.follow(places, self._follower, restless=restless)

    def _end(self) -> None:
        self._names = ()
        if self._motor is not None:
            self._motor.core.unfollow()

    def _look(self, name: str) -> int:
        """As it is at the last sample by now; 0 without power."""
        value = self._read(name)
        return self._lines.line(value) if name == LINE else value

    def _read(self, name: str) -> int:
        """The same as the processor has it."""
        if self._motor is None:
            return 0
        core = self._motor.core
        core.catch_up(changing=False)
        return log.value(core.i, core.v, *numbers()[name])


def _called(variable: str) -> str:
    return variable if variable in BUFFERED else f"R{variable.removeprefix('@')}"


def _also(name: str) -> tuple[str, ...]:
    variable = name.removeprefix("R")
    return () if name in (*BUFFERED, "RMODE", LINE) or variable in USER_PINS else (variable, f"@{variable}")
