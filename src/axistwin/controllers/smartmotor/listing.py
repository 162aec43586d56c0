"""The stored program as lines, and the line that is running.

The motor stores the loaded lines without comments and needless blanks.  For a program with only one line, each
statement is listed as a line of its own.  A line is running from the sample in which one of its statements begins until
a statement of another line begins.  A line with WAIT or TWAIT is therefore running while WAIT or TWAIT holds the
program.

While there are subscribers, the program in the memory is replaced by a copy that reports when a statement begins
(`Program.announces`).  If only lines with one statement are observed, the copy reports the statements of these lines;
otherwise the copy reports all statements of the program.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from axistwin.controllers.product import Follower, Listing
from axistwin.controllers.smartmotor.kernel import state as s
from axistwin.controllers.smartmotor.language.program import Program
from axistwin.controllers.smartmotor.motor import Motor
from axistwin.sim.progress import Progress

PROGRAM_NAME = "program"
LINE = "line"  # The register with the line that is running, counted from 1; 0 while no program runs.


def lines_of(text: str) -> tuple[str, ...]:
    """Return the lines of a stored program.  In the memory of the motor, LF ends each line."""
    return tuple(text.removesuffix("\n").split("\n")) if text else ()


class Rows(NamedTuple):
    """The lines of a program, and the line of each statement; those in `silent` contain none."""

    lines: tuple[str, ...]
    of: tuple[int, ...]
    silent: frozenset[int]

    @classmethod
    def of_program(cls, program: Program) -> "Rows":
        """Return the lines of a program.  For a program with only one line, each statement is a line."""
        lines = lines_of(program.text)
        of = tuple(place.line - 1 for place in program.places)
        if len(lines) == 1:
            lines, of = tuple(statement.text for statement in program.statements), tuple(range(len(of)))
        numbers = {program.number_at(head) for head in program.heads} - {len(of)}
        return cls(lines, of, frozenset(range(len(lines))) - {of[number] for number in numbers})

    def statements(self, rows: Iterable[int] | None) -> frozenset[int]:
        """Return the statements that must be announced to report the start of these lines; None means all lines."""
        every = frozenset(number for number, row in enumerate(self.of) if row not in self.silent)
        found = [[number for number in every if self.of[number] == row] for row in rows or ()]
        if rows is None or any(len(numbers) > 1 for numbers in found):
            return every
        return frozenset(number for numbers in found for number in numbers)

    def row(self, number: int) -> int | None:
        """Return the line of a statement; None: the end of the program."""
        return self.of[number] if number < len(self.of) else None


class Lines:
    """Provides the text lines of the stored program, and reports which line the motor executes."""

    def __init__(self) -> None:
        self.progress = Progress(self._attend)
        self._motor: Motor | None = None
        self._listed: Program | None = None
        self._rows = Rows((), (), frozenset())

    def connect(self, motor: Motor) -> None:
        """Connect to a processor whose power has been switched on and whose program is not running yet."""
        self._motor = motor
        motor.on_program, motor.on_statement = self._announcing, self._begins
        if self.progress.wanted is None or self.progress.wanted:
            self._attend()

    def listings(self) -> Mapping[str, Listing]:
        """Return the listing of the stored program, also while the power is off."""
        motor = self._motor
        assert motor is not None, "it has been switched on once"
        if motor.nonvolatile.broken:
            kept = lines_of(motor.nonvolatile.program)
            return {PROGRAM_NAME: Listing("stored program, not valid: flag Bk", kept)}
        rows, locked = self.rows(), ", locked" if motor.nonvolatile.locked else ""
        return {PROGRAM_NAME: Listing(f"stored program{locked}", rows.lines, self._running(), rows.silent)}

    def rows(self) -> Rows:
        return self._rows if self._motor is None else self._rows_of(self._motor.program)

    def in_lines(self, names: Sequence[str], follower: Follower) -> Follower:
        """Return a follower that converts statement numbers to line numbers, from 1, for another follower."""
        if LINE not in names:
            return follower
        place = names.index(LINE)

        def convert(times: Sequence[int], which: Sequence[int], values: Sequence[int]) -> None:
            found = zip(which, values, strict=True)
            follower(times, which, [self.line(value) if k == place else value for k, value in found])

        return convert

    def line(self, statement: int) -> int:
        """Return the line number of a statement number, both from 1; 0 for no statement."""
        row = self.rows().row(statement - 1) if statement else None
        return 0 if row is None else row + 1

    def _rows_of(self, program: Program) -> Rows:
        if program is not self._listed:
            self._listed, self._rows = program, Rows.of_program(program)
        return self._rows

    def _running(self) -> int | None:
        motor = self._motor
        assert motor is not None
        motor.core.catch_up(changing=False)
        stopped = not motor.powered or motor.i[s.PROGRAM] == s.STOPPED
        return None if stopped else self.rows().row(motor.i[s.STATEMENT])

    def _begins(self, number: int) -> None:
        """Report the beginning of a line, unless the preceding statement was in the same line."""
        motor = self._motor
        assert motor is not None
        before, motor.statement_before = motor.statement_before, number
        index = self.rows().of[number]
        if before == s.NOTHING_YET or number <= before or self.rows().row(before) != index:
            self.progress.report(PROGRAM_NAME, index)

    def _attend(self) -> None:
        if self._motor is not None:
            change(self._motor, self._announcing(self._motor.program))

    def _announcing(self, program: Program) -> Program:
        wanted = self.progress.wanted
        if wanted is not None and not wanted:
            return program.announcing(frozenset())
        rows = None if wanted is None else [index for _, index in wanted]
        return program.announcing(self._rows_of(program).statements(rows))


def change(motor: Motor, after: Program) -> None:
    """Replace the program, even while running, by a program that differs only in its announcements."""
    if after is motor.program:
        return
    motor.catch_up()
    i, moved = motor.i, _moved(motor.program, after)
    i[s.PC] = moved.get(i[s.PC], 0)
    for at in range(s.RETURNS, s.RETURNS + i[s.DEPTH]):
        i[at] = moved.get(i[at] >> 2, i[at] >> 2) << 2 | i[at] & 3
    motor.statement_before = s.NOTHING_YET if i[s.PROGRAM] == s.STOPPED else i[s.STATEMENT]
    motor.use(after)


def _moved(before: Program, after: Program) -> dict[int, int]:
    """Return the place in a new code for each place in the old code; the codes differ only in announcements."""
    moved = {}
    for old, new in zip(before.heads, after.heads, strict=True):
        moved[old + before.announcement(old)] = new + after.announcement(new)
        moved[old] = new
    return moved
