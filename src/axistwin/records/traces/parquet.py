"""Write traces to Parquet files: one row per change, in columns `time_ns`, `signal` and `integer`, `number` or `text`.

As in CSV files, step pulses have no rows.  The last row has the signal name `end`, and its time is the end of the
trace.

A Parquet file ends with a table of contents (its footer), without which the file is unreadable.  Each row group is
therefore written together with a new table of contents, which replaces the old table, so that the file is readable even
if the program is killed.  The last row group is rewritten until it is full.
"""

import io
import json
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

from axistwin.bench.codec import CHARACTERS
from axistwin.core.errors import require
from axistwin.core.lazy import NDArray, np, pa, pq
from axistwin.records.traces.batch import Batch, ChangeQueue, Value, merged
from axistwin.records.traces.files import units
from axistwin.records.traces.output import Output, Provenance
from axistwin.records.traces.signals import REAL, TEXT, Signal

MAGIC = b"PAR1"
TAIL = 8  # Number of bytes after the table of contents: its length and the magic number.
GROUP, MOST = 1 << 16, 1 << 20
"""Least and largest number of rows in a full row group; groups grow, so that the table of contents stays small."""
GROWS_AFTER = 64
NOTHING = memoryview(bytes(1 << 24))
SIGNALS, UNITS, END = "axistwin.signals", "axistwin.units", "end"
INTEGER, NUMBER, WORDS, NONE = range(4)
KINDS = {REAL: NUMBER, TEXT: WORDS}  # Column for the values of a signal, by kind; other kinds: `INTEGER`.
OPTIONS: dict[str, Any] = {
    "compression": "zstd",
    "use_dictionary": ["signal", "text"],
    "column_encoding": {
        "time_ns": "DELTA_BINARY_PACKED", "integer": "DELTA_BINARY_PACKED", "number": "BYTE_STREAM_SPLIT",
    },
}  # fmt: skip


def require_pyarrow() -> None:
    """Raise MissingExtraError if pyarrow is not installed."""
    require("pyarrow", "traces")


class ParquetSink:
    """Writes a Parquet file with one row for each change of a signal."""

    def __init__(
        self, output: Output, signals: Sequence[Signal], first: Sequence[Value], now_ns: int, provenance: Provenance
    ) -> None:
        self._output, self._signals = output, signals
        self._names = pa.array([*(signal.full for signal in signals), END], pa.string())
        kinds = {signal.full: signal.kind for signal in signals}
        self._about = {**provenance, SIGNALS: json.dumps(kinds), UNITS: json.dumps(units(signals))}
        self._batches: list[pa.Table] = []
        self._rows = self._groups = 0
        self._new = False
        self._contents: Any = None
        self._place = len(MAGIC)  # Position in the Parquet file at which the present block of rows begins.
        self._rewritable = 0  # Number of bytes at the end of the Parquet file that the next call of `flush` replaces.
        output.append(MAGIC)
        waiting = ChangeQueue(signals)
        for n, value in enumerate(first):
            waiting.add(now_ns, n, value)
        texts: list[bytes] = []
        self.write(merged(waiting.parts(now_ns + 1, texts), texts))
        self.flush()

    def write(self, batch: Batch) -> None:
        """Add rows to the present group; if the group is full, begin a new group."""
        table = self._table(batch)
        while self._rows + len(table) >= self._full:
            room = self._full - self._rows
            self._add(table.slice(0, room))
            self._close_group()
            table = table.slice(room)
        self._add(table)

    def _add(self, table: "pa.Table") -> None:
        self._batches.append(table)
        self._rows += len(table)
        self._new |= len(table) > 0

    def _close_group(self) -> None:
        self.flush()
        self._place += self._body
        self._rewritable -= self._body
        self._contents = self._with_group
        self._batches, self._rows, self._groups = [], 0, self._groups + 1

    def flush(self) -> None:
        """Write the present group, and a table of contents for the whole file."""
        if not self._new:
            return
        self._new = False
        self._batches = [pa.concat_tables(self._batches)]
        body, self._with_group = self._encoded(self._batches[0])
        self._body = len(body)
        data = body + _footer(self._with_group)
        self._output.replace_end(data, self._rewritable)
        self._rewritable = len(data)

    def end(self, now_ns: int) -> None:
        self.write(Batch(np.array([now_ns]), np.array([len(self._signals)]), np.array([0]), ()))
        self.flush()

    @property
    def _full(self) -> int:
        return min(MOST, GROUP << self._groups // GROWS_AFTER)

    def _table(self, batch: Batch) -> "pa.Table":
        signals, values = batch.signals, batch.values
        kinds = np.array([*(KINDS.get(signal.kind, INTEGER) for signal in self._signals), NONE], np.int8)[signals]
        columns = [
            pa.array(batch.times), pa.DictionaryArray.from_arrays(pa.array(signals.astype(np.int32)), self._names),
            pa.array(values, mask=kinds != INTEGER), pa.array(values.view(np.float64), mask=kinds != NUMBER),
            _texts(values, kinds == WORDS, batch.texts),
        ]  # fmt: skip
        return pa.table(columns, self._schema())

    def _schema(self) -> "pa.Schema":
        columns = {
            "time_ns": pa.int64(), "signal": pa.dictionary(pa.int32(), pa.string()), "integer": pa.int64(),
            "number": pa.float64(), "text": pa.string(),
        }  # fmt: skip
        return pa.schema(list(columns.items()), metadata=self._about)

    def _encoded(self, table: "pa.Table") -> tuple[bytes, Any]:
        tail = _Tail()
        file = pa.PythonFile(tail, mode="w")
        writer = pq.ParquetWriter(file, table.schema, **OPTIONS)
        # The footer of a Parquet file contains positions relative to the start of the file.
        while (missing := self._place - file.tell()) > 0:
            file.write(NOTHING[:missing])
        tail.parts = []
        writer.write_table(table)
        writer.close()
        data = b"".join(tail.parts)
        length = int.from_bytes(data[-TAIL:-4], "little") + TAIL
        contents = pq.read_metadata(io.BytesIO(MAGIC + data[-length:]))
        if self._contents is not None:
            whole = pq.read_metadata(io.BytesIO(MAGIC + _footer(self._contents)))
            whole.append_row_groups(contents)
            contents = whole
        return data[:-length], contents


class _Tail(io.RawIOBase):
    """A file in memory that appends bytes to the list `parts`, or discards them if it is None."""

    def __init__(self) -> None:
        self.parts: list[bytes] | None = None

    def writable(self) -> bool:
        return True

    def write(self, data: Any) -> int:
        if self.parts is not None:
            self.parts.append(bytes(data))
        return len(data)


def _footer(contents: Any) -> bytes:
    file = io.BytesIO()
    contents.write_metadata_file(file)
    data = file.getvalue()
    return data[-int.from_bytes(data[-TAIL:-4], "little") - TAIL :]


def _texts(values: "NDArray[np.int64]", wanted: "NDArray[np.bool_]", known: Sequence[bytes]) -> "pa.Array":
    if not wanted.any():
        return pa.nulls(len(values), pa.string())
    return pa.array([_shown(text) for text in known], pa.string()).take(pa.array(values, mask=~wanted))


# Cache the conversion of messages from bytes to text, because hosts often repeat a message.
_shown = lru_cache(1 << 14)(CHARACTERS.show)
