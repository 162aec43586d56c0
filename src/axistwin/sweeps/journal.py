"""The results of a sweep: numbered part files during the sweep, joined to one Parquet file at the end.

Each file contains the plan of the sweep and its own check sum.  An interrupted sweep is resumed only if its plan has
not changed.  One process at a time writes the results; it holds the lock in the directory of the part files.
"""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from hashlib import sha256
from pathlib import Path
from shutil import rmtree
from time import monotonic
from typing import Any, Self

from axistwin.core.errors import TraceError, UsageError, reason
from axistwin.core.lazy import pa, pq
from axistwin.core.storage import Lock, write_error, write_whole
from axistwin.records.traces.parquet import require_pyarrow
from axistwin.sweeps.job import APART, Row

PLAN, SUM = b"axistwin.sweep", b"axistwin.sum"
"""Metadata keys under which a Parquet file stores the plan of its sweep, and its check sum."""
MARK, DIGITS = b"SHA-256 of this file with zeros here: ", 64
"""Beginning of the value of `SUM`, and its number of hexadecimal digits."""
ROWS, FLUSH_S = 1000, 2.0  # Largest number of rows in a part file, and seconds after which a part file is written.
Plan = Mapping[str, Any]


class Journal:
    """Writes the results of a sweep to the file `out`, within a `with` block.

    Raises UsageError if `out` belongs to another sweep, if another process writes it, or if a file is damaged.
    """

    def __init__(self, out: Path, plan: Plan, types: Mapping[str, str]) -> None:
        require_pyarrow()
        if out.suffix != ".parquet":
            raise UsageError(f"invalid file name {out.name!r}: expected a name that ends in .parquet")
        self.out, self.plan = out, plan
        self.parts = _parts(out)
        self._types, self._rows = types, list[Row]()
        self._written_s = monotonic()
        self.complete = False
        self.done: set[int] = set()
        self._lock: Lock | None = None

    def __enter__(self) -> Self:
        try:
            self._reserve()
            self._open()
        except BaseException as error:
            self.__exit__()
            if isinstance(error, OSError):
                raise write_error(f"cannot write the results to {self.out}", error) from None
            raise
        return self

    def __exit__(self, *_: object) -> None:
        if self._lock is not None:
            self._lock.release()
            if self.complete:
                rmtree(self.parts, ignore_errors=True)

    def _reserve(self) -> None:
        if self.out.exists():
            return
        self.parts.mkdir(parents=True, exist_ok=True)
        self._lock = Lock(self.parts, being_written(self.out))

    def _open(self) -> None:
        """Read the runs that are done, after the lock is held: meanwhile another process may have ended the sweep."""
        ended = self.out.exists()
        for file, rows in [(self.out, _load(self.out))] if ended else self.tables():
            check_plan(file, plan_of(rows), self.plan)
            found = rows["run"].to_pylist()
            if not self.done.isdisjoint(found):
                raise UsageError(f"{file} repeats runs of another file: delete {file.name}")
            self.done.update(found)
        self.complete = ended

    def tables(self) -> "Iterator[tuple[Path, pa.Table]]":
        """Read the part files.  Raises UsageError for a damaged file."""
        return _tables(self.parts)

    def add(self, row: Row) -> None:
        """Store the results of one run, and regularly write all new results to a file."""
        self._rows.append(row)
        if len(self._rows) >= ROWS or monotonic() - self._written_s > FLUSH_S:
            self.flush()

    def flush(self) -> None:
        self._written_s = monotonic()
        if not self._rows:
            return
        number = 1
        while (file := self.parts / f"part-{number:06}.parquet").exists():
            number += 1
        _write(table(self._rows, self._types, self.plan), file)
        self.done |= {row["run"] for row in self._rows}
        self._rows = []

    def finish(self) -> None:
        if self.complete:
            return

        self.flush()
        parts = [part for _, part in self.tables()] or [table([], self._types, self.plan)]
        _write(pa.concat_tables(parts).sort_by("run"), self.out)
        self.complete = True


def table(rows: Sequence[Row], types: Mapping[str, str], plan: Plan) -> "pa.Table":
    """Convert the results of runs to a table.  `types` contains the name and the type of each column."""
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
    """Write a table with its check sum.  Raises AxistwinError; the file is then unchanged."""
    about = {**(found.schema.metadata or {}), SUM: MARK + b"0" * DIGITS}
    encoded = pa.BufferOutputStream()
    pq.write_table(found.replace_schema_metadata(about), encoded, compression="zstd")
    data = bytearray(encoded.getvalue())
    at = data.rindex(MARK) + len(MARK)
    data[at : at + DIGITS] = sha256(data).hexdigest().encode()
    try:
        write_whole(path, bytes(data))
    except OSError as error:
        raise write_error(f"cannot write the results to {path}", error) from None


def _load(path: Path) -> "pa.Table":
    """Read a table.  Raises TraceError for a file without results, and UsageError for a damaged one."""
    try:
        data = path.read_bytes() if path.is_file() else b""
    except OSError as error:
        raise UsageError(f"cannot read {path}: {reason(error)}") from None
    at = data.rfind(MARK) + len(MARK)
    summed = sha256(data[:at] + b"0" * DIGITS + data[at + DIGITS :]).hexdigest().encode()
    marked = at >= len(MARK)
    if marked and summed != data[at : at + DIGITS]:
        raise _damaged(path)
    try:
        # `pq.read_table` has threads, and one that still holds `data` at the end of Python aborts the process.
        found = pq.ParquetFile(pa.BufferReader(data)).read(use_threads=False)
        about = found.schema.metadata or {}
        if PLAN not in about:
            raise TraceError(f"{path} contains no results of a sweep: expected a file written by 'axistwin sweep'")
        if not marked and (SUM in about or not _consistent(found)):
            raise _damaged(path)
    except (pa.ArrowException, OSError, ValueError, TypeError, KeyError):
        raise _damaged(path) from None
    return found


def _consistent(found: "pa.Table") -> bool:
    """Check a table without a check sum, of an earlier version."""
    found.validate(full=True)
    plan = plan_of(found)
    return {"run", "ended", *plan["varied"], *plan["measures"], *plan["claims"]} <= set(found.column_names)


def _damaged(path: Path) -> UsageError:
    return UsageError(
        f"{path} is damaged, or not written by 'axistwin sweep': delete the file, and run the sweep again for its runs"
    )


def _parts(out: Path) -> Path:
    return out.with_name(f"{out.name}.parts")


def _tables(parts: Path) -> "Iterator[tuple[Path, pa.Table]]":
    for file in sorted(parts.glob("part-*.parquet")):
        yield file, _load(file)


def is_sweep(path: Path) -> bool:
    try:
        return PLAN in (pq.read_schema(path).metadata or {})
    except (pa.ArrowException, OSError, ValueError):
        return False


def read(path: Path) -> "pa.Table":
    """Return the results of a finished or interrupted sweep.

    Raises UsageError if no results exist at `path` or if they are damaged, and TraceError if the file contains no
    results of a sweep.
    """
    require_pyarrow()

    if path.exists():
        return _load(path)
    if parts := [part for _, part in _tables(_parts(path))]:
        return pa.concat_tables(parts).sort_by("run")
    raise UsageError(f"{path} does not exist: expected a file written by 'axistwin sweep'")


def plan_of(found: "pa.Table") -> Plan:
    plan: Plan = json.loads(found.schema.metadata[PLAN])
    return plan


def digest(found: "pa.Table") -> str:
    """Return a hash of the results of a sweep.  Sweeps with equal results have equal hashes."""
    kept = found.select([name for name in found.column_names if name not in APART]).sort_by("run")
    rows = (json.dumps(row, sort_keys=True) for row in kept.to_pylist())
    return sha256("\n".join(rows).encode()).hexdigest()[:16]


def being_written(out: Path) -> Callable[[str], str]:
    """Return a function that makes the error message for results that another process writes."""
    return lambda other: f"{out} is being written by {other}: wait for its end, or choose another file with --out"


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
