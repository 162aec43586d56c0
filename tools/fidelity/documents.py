"""Tables in Markdown documents, as lists of cells under their headings."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Line:
    """One line of a table: its headings, outermost first, and its cells."""

    headings: tuple[str, ...]
    cells: tuple[str, ...]


def table_lines(path: Path, columns: int) -> Iterator[Line]:
    """Yield each line of every table with this number of columns, without the heads."""
    headings: list[str] = []
    lines = path.read_text(encoding="utf-8").splitlines()
    for number, line in enumerate(lines):
        if match := re.match(r"(#+) (.*)", line):
            depth = len(match[1])
            headings = [*headings[: depth - 1], match[2]]
        elif line.startswith("| "):
            is_head = number + 1 < len(lines) and lines[number + 1].startswith("| ---")
            cells = cells_of(line)
            if not is_head and not line.startswith("| ---") and len(cells) == columns:
                yield Line(tuple(headings[1:]), cells)


def cells_of(line: str) -> tuple[str, ...]:
    r"""Return the cells of a line; a `|` between backticks or after a `\` is text."""
    divided = re.findall(r"(?:`[^`]*`|\\.|[^|\\])+", line.strip().removeprefix("|").removesuffix("|"))
    return tuple(cell.strip() for cell in divided)
