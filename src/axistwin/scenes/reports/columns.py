"""Format rows of text in aligned columns."""

from collections.abc import Iterable, Iterator


def columns(rows: Iterable[Iterable[str]]) -> Iterator[str]:
    cells = [tuple(row) for row in rows]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    for row in cells:
        yield "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
