"""The checker's rules for mode cam (chapter 9): the table, SIZE and BASE, dwell, and changes that invalidate a CI.

The rules read the program text from top to bottom; values that are not constants are unknown.
"""

from dataclasses import dataclass, field

from axistwin.controllers.smartmotor import rules
from axistwin.controllers.smartmotor.checker.findings import Findings, constant_value
from axistwin.controllers.smartmotor.kernel.cam import DWELLING
from axistwin.controllers.smartmotor.kernel.state import WORDS
from axistwin.controllers.smartmotor.language.language import Elements, Statement

SMALLEST_SIZE = 4
QUARTER = 4
MODES = ("MC", "MC2", "MC4", "MC8")
INVALIDATING = frozenset({"D=", "BASE=", "SIZE=", "F=", *MODES})
LEAVING = frozenset(
    {"WAIT=", "TWAIT", "LOOP", "WHILE", "Cn", "GOTOn", "GOSUBn", "RETURN", "END", "IF", "ENDIF", "ELSE", "ELSEIF"}
)


@dataclass
class _Cam:
    """Values of the cam parameters before a statement; None for a value that is not constant."""

    findings: Findings
    size: int | None = None
    base: int | None = None
    functions: int | None = 0
    dwell: int | None = 0
    dwell_at: int = -1
    entries: set[int] = field(default_factory=set)
    tabled: bool = True  # True if all entries of the table have constant indices.
    pending: int | None = None  # Number of the CI statement that waits for the zero point.
    stale: str = ""  # Name of the parameter, BASE or SIZE, that was assigned after the last MCn; "" for none.

    def follow(self) -> None:
        for number, (keyword, statement) in enumerate(zip(self.findings.words, self.findings.statements, strict=True)):
            self._invalid(number, keyword)
            self._keep(number, keyword, statement)
            if keyword in MODES:
                self._mode(number)
            elif keyword == "CI":
                self._initialize(number)

    def _invalid(self, number: int, keyword: str) -> None:
        if self.pending is not None and keyword in INVALIDATING:
            message = (
                f"this makes the CI in line {self.findings.line(self.pending)} invalid unless its zero point has passed"
            )
            self.findings.report(rules.INVALID, number, message)
        if keyword in INVALIDATING | LEAVING:
            self.pending = None

    def _keep(self, number: int, keyword: str, statement: Statement) -> None:
        value = constant_value(statement)
        if keyword == "SIZE=":
            self.size, self.stale = value if value is None or 0 <= value < WORDS else self.size, "SIZE"
        elif keyword == "BASE=":
            self.base, self.stale = value, "BASE"
        elif keyword == "F=":
            self.functions = value
        elif keyword == "D=":
            self.dwell, self.dwell_at = value, number
        elif keyword in ("aw[]=", "ab[]=", "al[]=", "VLD()"):
            self._table(keyword, statement)

    def _table(self, keyword: str, statement: Statement) -> None:
        value = statement.operands[-1]
        first = next((k.value for k in value.indices if k.array == "aw"), None) if isinstance(value, Elements) else None
        if keyword != "aw[]=" or not isinstance(value, Elements) or first is None:
            self.tabled = False
        elif value.count == 1:
            self.entries.add(first)
        else:
            self.entries |= set(range(first, first + value.count))

    def _mode(self, number: int) -> None:
        self.stale = ""
        self._size(number)
        if self.base is not None:
            self._base(number, self.base)
        dwelling = self.functions is None or self.functions & DWELLING
        if self.dwell and not dwelling:
            self.findings.report(
                rules.NO_DWELL, self.dwell_at, f"D={self.dwell} is not a dwell: a dwell needs F=16 or F=128"
            )

    def _size(self, number: int) -> None:
        size = self.size
        if size is None:
            return
        if size == 0:
            self.findings.report(rules.NO_TABLE, number, "SIZE=0: a cam table has at least one interval")
        elif size < SMALLEST_SIZE:
            message = f"SIZE={size}: a cam needs {SMALLEST_SIZE} to {WORDS - 1} intervals, but the motor accepts fewer"
            self.findings.report(rules.SIZE, number, message)
        elif self.tabled and self.entries:
            missing = sorted(set(range(size + 1)) - self.entries)
            if missing:
                message = f"the table is shorter than SIZE={size}: aw[{missing[0]}] is not set"
                self.findings.report(rules.TABLE, number, message)

    def _base(self, number: int, base: int) -> None:
        if base <= 0:
            self.findings.report(rules.BASE, number, f"BASE={base}: a cam cycle has a positive length")
        elif base <= QUARTER:
            message = f"BASE={base}: the master must move less than a quarter of BASE in a sample"
            self.findings.report(rules.SHORT_BASE, number, message)
        elif self.size and base < self.size:
            self.findings.report(rules.BASE_BELOW_SIZE, number, f"BASE={base} is less than SIZE={self.size}")

    def _initialize(self, number: int) -> None:
        if self.stale:
            message = f"{self.stale}= was assigned after the last MCn: without a new MCn before CI it has no effect"
            self.findings.report(rules.STALE, number, message)
        self.pending = number


def check(findings: Findings) -> None:
    """Report wrong uses of cam mode in a program, e.g. a command MC before BASE is assigned."""
    begun = next(findings.all(*MODES), None)
    if begun is None:
        return
    for keyword in ("BASE=", "SIZE="):
        if keyword not in findings.words[: begun[0]]:
            message = f"{keyword} has not been assigned yet: MCn uses the present value"
            findings.report(rules.NOT_GIVEN, begun[0], message)
    _Cam(findings).follow()
