"""The log of a shadow: findings and hourly durations as JSON lines, each move of a day as Parquet, and what is learnt.

Bounded: a file of 16 MiB is followed by a new one, and one older is kept; of Parquet files the last 31.  A full disk
costs lines of the log, never the comparison.
"""

import json
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from statistics import median
from typing import Any

from axistwin.core.storage import write_error, write_whole
from axistwin.core.units import MS, S
from axistwin.real.shadow.findings import Finding, Kind, stamp
from axistwin.real.shadow.learning import DAY_NS, Learned
from axistwin.real.shadow.moves import Timed

HOUR_NS = 3600 * S
MOST_BYTES = 16 << 20
MOST_DAYS = 31
MOST_AN_HOUR, MOST_A_DAY = 2000, 200_000  # Moves that are remembered until they are written.
LEARNT_EVERY_NS = 60 * S


class Log:
    """Writes to `path`, and beside it `NAME.learned.json` and `NAME-DATE.parquet`.  None: nothing is written.

    `warn` receives one line when something cannot be written, and the next one only after a success.
    """

    def __init__(self, path: Path | None, warn: Callable[[str], object]) -> None:
        self.path, self._warn = path, warn
        self._failed = False
        self._hour, self._day, self._learnt_ns = -1, -1, 0
        self._moves: dict[str, list[Timed]] = {}
        self._rows: list[Timed] = []
        self._learned: Learned | None = None

    @property
    def _learned_path(self) -> Path:
        assert self.path is not None
        return self.path.with_name(self.path.name + ".learned.json")

    def learned(self) -> Learned:
        """Return what was learnt before, also by a program that was killed; nothing if there is none."""
        self._learned = self._stored()
        return self._learned

    def _stored(self) -> Learned:
        if self.path is None:
            return Learned()
        try:
            stored = json.loads(self._learned_path.read_text("utf-8"))
        except (OSError, ValueError):
            return Learned()
        return Learned.of(stored) if isinstance(stored, dict) else Learned()

    def found(self, finding: Finding) -> None:
        self.add("note" if finding.kind is Kind.NOTE else "finding", **finding.as_dict())

    def timed(self, timed: Timed) -> None:
        self.tick(timed.began_ns + timed.duration_ns)
        if self.path is None:
            return
        moves = self._moves.setdefault(timed.kind, [])
        if len(moves) < MOST_AN_HOUR:
            moves.append(timed)
        if len(self._rows) < MOST_A_DAY:
            self._rows.append(timed)

    def tick(self, now_ns: int, learned: Learned | None = None) -> None:
        """Write what is due: the last hour, the last day, what is learnt."""
        if self.path is None:
            return
        if learned is not None and now_ns - self._learnt_ns > LEARNT_EVERY_NS:
            self._learnt_ns = now_ns
            self.save(learned)
        if now_ns // HOUR_NS != self._hour:
            self.write_hour()
            self._hour = now_ns // HOUR_NS
        if now_ns // DAY_NS != self._day:
            self.write_day()
            self._day = now_ns // DAY_NS

    def save(self, learned: Learned) -> None:
        if self.path is not None:
            text = json.dumps(learned.as_dict()).encode()
            self._try(lambda: write_whole(self._learned_path, text))

    def write_hour(self) -> None:
        """Write one line for each kind of move of the last hour."""
        for kind, moves in self._moves.items():
            later = sorted(timed.middle_ns / MS for timed in moves)
            durations = [(timed.duration_ns + timed.middle_ns) / S for timed in moves]
            figures = {
                "later_ms": median(later),
                "least_ms": later[0],
                "most_ms": later[-1],
                "duration_s": median(durations),
            }
            usual = None if self._learned is None else self._learned.moves().get(kind)
            if usual is not None and usual.learnt:
                figures["usual_ms"] = usual.median / MS
            rounded = {name: round(value, 4) for name, value in figures.items()}
            self.add("moves", time=stamp(moves[-1].began_ns), kind=kind, count=len(moves), **rounded)
        self._moves.clear()

    def write_day(self) -> None:
        rows, self._rows = self._rows, []
        if rows and self.path is not None and find_spec("pyarrow") is not None:
            self._try(lambda: self._write_rows(rows))

    def _write_rows(self, rows: list[Timed]) -> None:
        import pyarrow as pa
        import pyarrow.parquet as pq

        assert self.path is not None
        table = pa.table(
            {
                "time": pa.array([timed.began_ns for timed in rows], pa.timestamp("ns", "UTC")),
                "move": [timed.kind for timed in rows],
                "duration_s": [timed.duration_ns / S for timed in rows],
                "later_low_ms": [timed.low_ns / MS for timed in rows],
                "later_high_ms": [timed.high_ns / MS for timed in rows],
            }
        )
        day = stamp(rows[0].began_ns)[:10]
        path, count = self.path.with_name(f"{self.path.stem}-{day}.parquet"), 1
        while path.exists():
            count += 1
            path = self.path.with_name(f"{self.path.stem}-{day}-{count}.parquet")
        pq.write_table(table, path)
        files = sorted(self.path.parent.glob(f"{self.path.stem}-????-??-??*.parquet"))
        for old in files[:-MOST_DAYS]:
            old.unlink(missing_ok=True)

    def add(self, what: str, **values: Any) -> None:
        if self.path is not None:
            line = json.dumps({"type": what, **values}, ensure_ascii=False) + "\n"
            self._try(lambda: self._append(line))

    def _append(self, line: str) -> None:
        path = self.path
        assert path is not None
        if path.exists() and path.stat().st_size > MOST_BYTES:
            path.replace(path.with_name(path.name + ".1"))
        with path.open("a", encoding="utf-8") as file:
            file.write(line)

    def _try(self, write: Callable[[], object]) -> None:
        try:
            write()
        except OSError as error:
            if not self._failed:
                self._failed = True
                self._warn(str(write_error(f"{self.path} cannot be written", error)))
        else:
            self._failed = False
