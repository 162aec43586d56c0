"""What one can look into: every value that can stand in an expression and is kept in the motor, and the mode.

They are called by the commands that report them, as RPE for @PE, since A to G are terminals; the buffered P and V,
which cannot be reported, by their own names.  Left out are CLK, which is the time itself, what has to be fetched from
outside, and the levels of pins.  `line` is the line of the stored program that is being carried out.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial

from axistwin.controllers.product import Follower, Register
from axistwin.controllers.smartmotor.chapters.variables import NOTHING, TABLE
from axistwin.controllers.smartmotor.kernel import log, state
from axistwin.controllers.smartmotor.kernel.interpreter import AT_STATEMENT, COMPUTED, MODE_TOLD, SLOT, VARIABLE
from axistwin.controllers.smartmotor.kernel.state import USER_PINS
from axistwin.controllers.smartmotor.listing import LINE, Lines
from axistwin.controllers.smartmotor.motor import Motor
from axistwin.sim.clock import Clock

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
    return found | {"RI": (SLOT, state.INDEX), "RMODE": (COMPUTED, MODE_TOLD), LINE: (COMPUTED, AT_STATEMENT)}


@dataclass(eq=False)
class _Following:
    """Somebody who follows some of them."""

    names: tuple[str, ...]
    follower: Follower

    def share(self, names: Sequence[str]) -> Follower:
        """Tells him of what happens to these names, as far as it concerns him."""
        place = {names.index(name): k for k, name in enumerate(self.names)}

        def tell(times: Sequence[int], which: Sequence[int], values: Sequence[int]) -> None:
            his = [n for n, number in enumerate(which) if number in place]
            if his:
                self.follower([times[n] for n in his], [place[which[n]] for n in his], [values[n] for n in his])

        return tell


class Registers:
    """Reads them, and has them followed, in whatever processor has the power."""

    def __init__(self, clock: Clock, lines: Lines) -> None:
        self.clock, self._lines = clock, lines
        self._motor: Motor | None = None
        self._followings: list[_Following] = []

    def connect(self, motor: Motor | None) -> None:
        """This processor has its power on now; everything in it is as it is at power-up."""
        self._motor = motor
        if motor is not None and self._followings:
            self._follow()
            for one in self._followings:
                count = len(one.names)
                one.follower([self.clock.now] * count, range(count), [self._read(name) for name in one.names])

    def table(self) -> dict[str, Register]:
        """All of them, also under their names in an expression."""
        return {name: Register(partial(self._look, name), _also(name), costly=name in COSTLY) for name in numbers()}

    def follow(self, names: Sequence[str], follower: Follower) -> Callable[[], None]:
        """Tell a follower of each change of these.  Several may follow, each its own ones."""
        one = _Following(tuple(names), self._lines.in_lines(names, follower))
        self._followings.append(one)
        self._follow()

        def end() -> None:
            self._followings.remove(one)
            self._follow()

        return end

    def _follow(self) -> None:
        """Have the motor tell what is followed, and by whom, as it is now."""
        if self._motor is None:
            return
        if not self._followings:
            self._motor.core.unfollow()
            return
        names, follower = self._all_followed()
        restless = any(name in WHILE_RESTING for name in names)
        self._motor.core.follow([numbers()[name] for name in names], follower, restless=restless)

    def _all_followed(self) -> tuple[tuple[str, ...], Follower]:
        """Everything that somebody follows, and who is told of it: a single follower at once."""
        if len(self._followings) == 1:
            return self._followings[0].names, self._followings[0].follower
        names = tuple(dict.fromkeys(name for one in self._followings for name in one.names))
        shares = [one.share(names) for one in self._followings]

        def tell(times: Sequence[int], which: Sequence[int], values: Sequence[int]) -> None:
            for share in shares:
                share(times, which, values)

        return names, tell

    def _look(self, name: str) -> int:
        """As it is at the last sample by now; without power 0, and no mode."""
        if self._motor is None:
            return state.NO_POWER if name == "RMODE" else 0
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
