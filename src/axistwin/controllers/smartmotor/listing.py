"""The stored program as lines, and the line that is being carried out.

The motor keeps the text as its lines were loaded, without comments and needless blanks; of a program that stands in
one line, each statement is listed as a line of its own.  A line runs from the sample in which a statement of it begins
until that of another line does: so WAIT, TWAIT and whatever else takes time run as long as they hold the program.

While somebody watches, the program in the memory is another one, which does the same and announces statements before
they are carried out (`Program.announces`); so whoever does not watch pays nothing.  For a line with one statement,
that one is enough; whether a line with several begins or goes on is known only if all statements are announced.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from axistwin.controllers.product import Follower, Listing
from axistwin.controllers.smartmotor.kernel.state import DEPTH, NOTHING_YET, PC, PROGRAM, RETURNS, STATEMENT, STOPPED
from axistwin.controllers.smartmotor.language.program import Program
from axistwin.sim.progress import Progress

if TYPE_CHECKING:
    from axistwin.controllers.smartmotor.motor import Motor

PROGRAM_NAME = "program"
"""What the one program of a motor is called."""
LINE = "line"
"""The register that tells the line that is being carried out, counted from 1; 0 while no program runs."""


def lines_of(text: str) -> tuple[str, ...]:
    """The lines of a text as the motor keeps it, each ended by LF."""
    return tuple(text.removesuffix("\n").split("\n")) if text else ()


@dataclass(frozen=True)
class Rows:
    """The lines of a program, the index of the line of each statement, and lines that take no time."""

    lines: tuple[str, ...]
    of: tuple[int, ...]
    silent: frozenset[int]

    @classmethod
    def of_program(cls, program: Program) -> "Rows":
        """As they stand in the memory, or a statement a line if it has one line only."""
        lines = lines_of(program.text)
        of = tuple(place.line - 1 for place in program.places)
        if len(lines) == 1:
            lines, of = tuple(statement.text for statement in program.statements), tuple(range(len(of)))
        numbers = {program.number_at(head) for head in program.heads} - {len(of)}
        return cls(lines, of, frozenset(range(len(lines))) - {of[number] for number in numbers})

    def statements(self, rows: Iterable[int] | None) -> frozenset[int]:
        """What is to be announced so that the beginning of these lines is known; None: of all."""
        every = frozenset(number for number, row in enumerate(self.of) if row not in self.silent)
        found = [[number for number in every if self.of[number] == row] for row in rows or ()]
        if rows is None or any(len(numbers) > 1 for numbers in found):
            return every
        return frozenset(number for numbers in found for number in numbers)

    def row(self, number: int) -> int | None:
        """The line of a statement; None: it is the end of the program."""
        return self.of[number] if number < len(self.of) else None


class Lines:
    """The program's lines in whatever processor has the power, and who watches them."""

    def __init__(self) -> None:
        self.progress = Progress(self._attend)
        self._motor: Motor | None = None
        self._listed: Program | None = None
        self._rows = Rows((), (), frozenset())

    def connect(self, motor: "Motor") -> None:
        """This processor has its power on now; its program is not running yet."""
        self._motor = motor
        motor.on_program, motor.on_statement = self._announcing, self._begins
        if self.progress.wanted is None or self.progress.wanted:
            self._attend()

    def listings(self) -> Mapping[str, Listing]:
        """The program; also without power, when nothing of it runs."""
        motor = self._motor
        assert motor is not None, "it has been switched on once"
        if motor.nonvolatile.broken:
            kept = lines_of(motor.nonvolatile.program)
            return {PROGRAM_NAME: Listing("stored program, not valid: flag Bk", kept)}
        rows, locked = self.rows(), ", locked" if motor.nonvolatile.locked else ""
        return {PROGRAM_NAME: Listing(f"stored program{locked}", rows.lines, self._running(), rows.silent)}

    def rows(self) -> Rows:
        """The lines of the program as it is now."""
        return self._rows if self._motor is None else self._rows_of(self._motor.program)

    def in_lines(self, names: Sequence[str], follower: Follower) -> Follower:
        """A follower who is told lines, counted from 1, where the processor knows of statements only."""
        if LINE not in names:
            return follower
        place = names.index(LINE)

        def told(times: Sequence[int], which: Sequence[int], values: Sequence[int]) -> None:
            found = zip(which, values, strict=True)
            follower(times, which, [self.line(value) if k == place else value for k, value in found])

        return told

    def line(self, statement: int) -> int:
        """The line of a statement, both counted from 1; 0: of none."""
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
        stopped = not motor.powered or motor.i[PROGRAM] == STOPPED
        return None if stopped else self.rows().row(motor.i[STATEMENT])

    def _begins(self, number: int) -> None:
        """A statement begins: so does its line, unless it goes on in the line of the one before."""
        motor = self._motor
        assert motor is not None
        before, motor.statement_before = motor.statement_before, number
        index = self.rows().of[number]
        if before == NOTHING_YET or number <= before or self.rows().row(before) != index:
            self.progress.report(PROGRAM_NAME, index)

    def _attend(self) -> None:
        if self._motor is not None:
            change(self._motor, self._announcing(self._motor.program))

    def _announcing(self, program: Program) -> Program:
        """The same program, which announces what is wanted."""
        wanted = self.progress.wanted
        if wanted is not None and not wanted:
            return program.announcing(frozenset())
        rows = None if wanted is None else [index for _, index in wanted]
        return program.announcing(self._rows_of(program).statements(rows))


def change(motor: "Motor", after: Program) -> None:
    """The program is this one from now on, which is the same but for what it announces; it may be running."""
    if after is motor.program:
        return
    motor.catch_up()
    i, moved = motor.i, _moved(motor.program, after)
    i[PC] = moved.get(i[PC], 0)
    for at in range(RETURNS, RETURNS + i[DEPTH]):
        i[at] = moved.get(i[at] >> 2, i[at] >> 2) << 2 | i[at] & 3
    motor.statement_before = NOTHING_YET if i[PROGRAM] == STOPPED else i[STATEMENT]
    motor.use(after)


def _moved(before: Program, after: Program) -> dict[int, int]:
    """Where in the one code a place of the other is; behind an announcement it is the statement itself."""
    moved = {}
    for old, new in zip(before.heads, after.heads, strict=True):
        moved[old + before.announcement(old)] = new + after.announcement(new)
        moved[old] = new
    return moved
