"""The results of a sweep: numbered part files during the sweep, joined to one Parquet file at the end.

A part file has a temporary name until it is complete.  The plan of the sweep is stored with the parts and in the
Parquet file.  An interrupted sweep is resumed only if its plan has not changed.
"""

import json
import os
from collections.abc import Mapping, Sequence
from hashlib import sha256
from pathlib import Path
from shutil import rmtree
from time import monotonic
from typing import TYPE_CHECKING, Any

from axistwin.errors import TraceError, UsageError
from axistwin.storage import write_whole
from axistwin.sweeps.job import APART, Row
from axistwin.traces.parquet import require_pyarrow

if TYPE_CHECKING:
    import pyarrow as pa

PLAN = b"axistwin.sweep"
"""Metadata key under which a Parquet file stores the plan of its sweep."""
ROWS, FLUSH_S = 1000, 2.0
"""Largest number of rows in a part file, and seconds after which a part file is written."""
Plan = Mapping[str, Any]


class Journal:
    """Writes the results of a sweep to the file `out`.  Raises UsageError if `out` belongs to another sweep."""

    def __init__(self, out: Path, plan: Plan, types: Mapping[str, str]) -> None:
        require_pyarrow()
        if out.suffix != ".parquet":
            raise UsageError(f"invalid file name {out.name!r}: expected a name that ends in .parquet")
        self.out, self.plan = out, plan
        self.parts = out.with_name(f"{out.name}.parts")
        self._types, self._rows = types, list[Row]()
        self._written_s = monotonic()
        self.complete = out.exists()
        try:
            self._open()
        except OSError as error:
            raise UsageError(f"cannot write the results to {out}: {error.strerror}") from None
        self.done = self._runs()

    def _open(self) -> None:
        if self.complete:
            check_plan(self.out, plan_of(self.out), self.plan)
            return
        told = self.parts / "plan.json"
        if told.exists():
            check_plan(self.parts, json.loads(told.read_text(encoding="utf-8")), self.plan)
            return
        self.parts.mkdir(parents=True, exist_ok=True)
        write_whole(told, json.dumps(self.plan, indent=2, ensure_ascii=False).encode())

    def _files(self) -> list[Path]:
        return [self.out] if self.complete else sorted(self.parts.glob("part-*.parquet"))

    def _runs(self) -> set[int]:
        import pyarrow.parquet as pq

        columns = (pq.read_table(file, columns=["run"])["run"].to_pylist() for file in self._files())
        return {run for column in columns for run in column}

    def add(self, row: Row) -> None:
        """Store the results of one run, and regularly write all new results to a file."""
        self._rows.append(row)
        if len(self._rows) >= ROWS or monotonic() - self._written_s > FLUSH_S:
            self.flush()

    def flush(self) -> None:
        """Write the results in memory to a new file, e.g. `part-000002.parquet`."""
        self._written_s = monotonic()
        if not self._rows:
            return
        last = max((int(file.stem.partition("-")[2]) for file in self._files()), default=0)
        _write(table(self._rows, self._types, self.plan), self.parts / f"part-{last + 1:06}.parquet")
        self.done |= {row["run"] for row in self._rows}
        self._rows = []

    def finish(self) -> None:
        """Join the part files to one Parquet file that is sorted by run number, and remove the part files."""
        if self.complete:
            return
        import pyarrow as pa
        import pyarrow.parquet as pq

        self.flush()
        parts = [pq.read_table(file) for file in self._files()] or [table([], self._types, self.plan)]
        _write(pa.concat_tables(parts).sort_by("run"), self.out)
        rmtree(self.parts)
        self.complete = True


def table(rows: Sequence[Row], types: Mapping[str, str], plan: Plan) -> "pa.Table":
    """Convert the results of runs to a table.  `types` contains the name and the type of each column."""
    import pyarrow as pa

    kinds = {
        "number": pa.float64(), "whole": pa.int64(), "truth": pa.bool_(), "text": pa.string(),
        "numbers": pa.list_(pa.float64()),
    }  # fmt: skip
    schema = pa.schema([(name, kinds[kind]) for name, kind in types.items()])
    shown = [{name: _as_kind(row[name], kind) for name, kind in types.items()} for row in rows]
    told = {PLAN: json.dumps(plan, ensure_ascii=False).encode()}
    return pa.Table.from_pylist(shown, schema=schema).replace_schema_metadata(told)


def _as_kind(value: Any, kind: str) -> Any:
    if value is None:
        return None
    if kind == "text":
        return value if isinstance(value, str) else json.dumps(value)
    return float(value) if kind == "number" else value


def kind_of(values: Sequence[Any]) -> str:
    """Return the type of a column from its values: "truth", "whole", "number" or "text"."""
    if all(isinstance(value, bool) for value in values):
        return "truth"
    if all(isinstance(value, int) and not isinstance(value, bool) for value in values):
        return "whole"
    return "number" if all(isinstance(value, int | float) for value in values) else "text"


def _write(found: "pa.Table", path: Path) -> None:
    import pyarrow.parquet as pq

    unfinished = path.with_name(f"{path.name}.{os.urandom(6).hex()}.new")
    try:
        pq.write_table(found, unfinished, compression="zstd")
        os.replace(unfinished, path)
    except OSError as error:
        unfinished.unlink(missing_ok=True)
        raise UsageError(f"cannot write the results to {path}: {error.strerror or error}") from None


def is_sweep(path: Path) -> bool:
    """True if the file contains the results of a sweep."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        return PLAN in (pq.read_schema(path).metadata or {})
    except (OSError, pa.ArrowInvalid):
        return False


def plan_of(path: Path) -> Plan:
    """Return the plan of a sweep from its file of results.  Raises TraceError for a file without results."""
    import pyarrow.parquet as pq

    if not is_sweep(path):
        raise TraceError(f"{path} contains no results of a sweep: expected a file written by 'axistwin sweep'")
    plan: Plan = json.loads(pq.read_schema(path).metadata[PLAN])
    return plan


def read(path: Path) -> "pa.Table":
    """Return the results of a finished or interrupted sweep.

    Raises UsageError if no results exist at `path`, and TraceError if the file contains no results of a sweep.
    """
    require_pyarrow()
    import pyarrow as pa
    import pyarrow.parquet as pq

    parts = sorted(path.with_name(f"{path.name}.parts").glob("part-*.parquet"))
    if path.exists():
        plan_of(path)
        return pq.read_table(path)
    if parts:
        return pa.concat_tables([pq.read_table(part) for part in parts]).sort_by("run")
    raise UsageError(f"{path} does not exist: expected a file written by 'axistwin sweep'")


def digest(found: "pa.Table") -> str:
    """Return a hash of the results of a sweep.

    Sweeps with equal results have equal hashes.
    """
    kept = found.select([name for name in found.column_names if name not in APART]).sort_by("run")
    rows = (json.dumps(row, sort_keys=True) for row in kept.to_pylist())
    return sha256("\n".join(rows).encode()).hexdigest()[:16]


def check_plan(file: Path, old: Plan, new: Plan) -> None:
    """Raise UsageError if two plans of sweeps differ; the message contains the first difference."""
    new = json.loads(json.dumps(new))
    for key in dict.fromkeys((*old, *new)):
        if old.get(key) != new.get(key):
            old_value, new_value = (json.dumps(plan.get(key), ensure_ascii=False) for plan in (old, new))
            raise UsageError(
                f"{file} contains results of another sweep, with {key} = {old_value} instead of {new_value}: "
                "choose another file with --out"
            )
