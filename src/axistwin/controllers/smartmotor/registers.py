"""Registers for inspection: the mode, and all stored values that an expression can read.  The names are those of the
report commands, such as RPE for @PE, because A to G are terminals.  The buffered P and V cannot be reported and keep
their names.  CLK (the time itself), values fetched from outside and the levels of pins are not included.  `line` is the
line of the stored program that is running.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial

from axistwin.controllers.product import Follower, Register
from axistwin.controllers.smartmotor.chapters.variables import NOTHING, TABLE
from axistwin.controllers.smartmotor.kernel import log, state
from axistwin.controllers.smartmotor.kernel.interpreter import AT_STATEMENT, COMPUTED, MODE_REPORTED, SLOT, VARIABLE
from axistwin.controllers.smartmotor.kernel.state import USER_PINS
from axistwin.controllers.smartmotor.listing import LINE, Lines
from axistwin.controllers.smartmotor.motor import Motor
from axistwin.sim.clock import Clock

LEFT_OUT = ("CLK", "I")
BUFFERED = ("P", "V")
SOFT_LIMITS = "SLE"  # The register that is 1 while the software limits are enabled; no command reports it.
WHILE_RESTING = ("RTEMP",)
COSTLY = (*WHILE_RESTING, LINE)  # Traced only on request; `line` changes in every sample of a program.


@cache
def numbers() -> Mapping[str, tuple[int, int]]:
    """Return each register's place: an operation, e.g. SLOT, and an index.  Reading RI does not clear Bi."""
    found = {
        _called(variable.name): (variable.operation, variable.place)
        for variable in TABLE
        if variable.operation in (SLOT, VARIABLE, COMPUTED)
        and variable.place != NOTHING
        and variable.name not in LEFT_OUT
    }
    return found | {
        "RI": (SLOT, state.INDEX), "RMODE": (COMPUTED, MODE_REPORTED), LINE: (COMPUTED, AT_STATEMENT),
        SOFT_LIMITS: (SLOT, state.SOFT_LIMITS),
    }  # fmt: skip


@dataclass(eq=False)
class _Following:
    names: tuple[str, ...]
    follower: Follower

    def share(self, names: Sequence[str]) -> Follower:
        """Return a follower of all these names, which forwards only the changes of some registers to this follower."""
        place = {names.index(name): k for k, name in enumerate(self.names)}

        def report(times: Sequence[int], which: Sequence[int], values: Sequence[int]) -> None:
            own = [n for n, number in enumerate(which) if number in place]
            if own:
                self.follower([times[n] for n in own], [place[which[n]] for n in own], [values[n] for n in own])

        return report


class Registers:
    """Reads the registers of the motor's processor, and reports changes of these registers."""

    def __init__(self, clock: Clock, lines: Lines) -> None:
        self.clock, self._lines = clock, lines
        self._motor: Motor | None = None
        self._followings: list[_Following] = []

    def connect(self, motor: Motor | None) -> None:
        """Connect the registers to a processor that has just been switched on; None disconnects them."""
        self._motor = motor
        if motor is not None and self._followings:
            self._follow()
            for one in self._followings:
                count = len(one.names)
                one.follower([self.clock.now] * count, range(count), [self._read(name) for name in one.names])

    def table(self) -> dict[str, Register]:
        """Return all registers by name.  A register whose name in expressions differs has both names."""
        return {name: Register(partial(self._value, name), _also(name), costly=name in COSTLY) for name in numbers()}

    def follow(self, names: Sequence[str], follower: Follower) -> Callable[[], None]:
        """Call `follower` with each change of the named registers; return a function that unsubscribes."""
        one = _Following(tuple(names), self._lines.in_lines(names, follower))
        self._followings.append(one)
        self._follow()

        def end() -> None:
            self._followings.remove(one)
            self._follow()

        return end

    def _follow(self) -> None:
        if self._motor is None:
            return
        if not self._followings:
            self._motor.core.unfollow()
            return
        names, follower = self._all_followed()
        restless = any(name in WHILE_RESTING for name in names)
        self._motor.core.follow([numbers()[name] for name in names], follower, restless=restless)

    def _all_followed(self) -> tuple[tuple[str, ...], Follower]:
        if len(self._followings) == 1:
            return self._followings[0].names, self._followings[0].follower
        names = tuple(dict.fromkeys(name for one in self._followings for name in one.names))
        shares = [one.share(names) for one in self._followings]

        def report(times: Sequence[int], which: Sequence[int], values: Sequence[int]) -> None:
            for share in shares:
                share(times, which, values)

        return names, report

    def _value(self, name: str) -> int:
        """Return a register's value after the latest sample; 0 while the power is off."""
        if self._motor is None:
            return state.NO_POWER if name == "RMODE" else 0
        value = self._read(name)
        return self._lines.line(value) if name == LINE else value

    def _read(self, name: str) -> int:
        if self._motor is None:
            return 0
        core = self._motor.core
        core.catch_up(changing=False)
        return log.value(core.i, core.v, *numbers()[name])


def _called(variable: str) -> str:
    return variable if variable in BUFFERED else f"R{variable.removeprefix('@')}"


def _also(name: str) -> tuple[str, ...]:
    variable = name.removeprefix("R")
    only = (*BUFFERED, SOFT_LIMITS, "RMODE", LINE)
    return () if name in only or variable in USER_PINS else (variable, f"@{variable}")
