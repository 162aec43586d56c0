"""Write a report of a run or a test: one HTML page with its verdict, picture, conversation and origin.

The page refers to no other file, and needs no network and no script.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

from axistwin.core.errors import TraceError, UsageError
from axistwin.core.storage import write_file

if TYPE_CHECKING:
    from axistwin.records.plots.chart import Chart

SUFFIXES = (".html", ".htm")
MOST_LINES = 20_000
"""Largest number of lines of a conversation on the page; a longer conversation loses its first lines."""
STYLE = """
:root { color-scheme: light dark; font: 15px/1.45 system-ui, sans-serif; }
body { max-width: 1100px; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.4rem; } h2 { font-size: 1.05rem; margin-top: 2rem; }
.verdict { padding: .6rem 1rem; border-left: 6px solid; font-weight: 600; }
.good { border-color: #2e7d32; background: #2e7d3222; } .bad { border-color: #c00000; background: #c0000022; }
figure { margin: 0; background: #fff; overflow-x: auto; } figure svg { width: 100%; height: auto; }
pre { overflow: auto; max-height: 40rem; padding: .6rem; border: 1px solid #8886; }
pre { font: 13px/1.4 ui-monospace, monospace; }
th { text-align: left; padding-right: 2rem; vertical-align: top; font-weight: 500; } td { overflow-wrap: anywhere; }
@media print { pre { max-height: none; white-space: pre-wrap; } }
"""


@dataclass(frozen=True)
class Page:
    """Contents of the report page of a run or a test.  `good`: True if the run or the test has succeeded."""

    title: str
    verdict: str
    good: bool
    conversation: Sequence[str]
    provenance: Mapping[str, str]
    chart: "Chart | None" = None
    summary: Sequence[str] = ()
    details: Sequence[str] = field(default=())  # Lines that explain the verdict, e.g. the traceback of a failed test.


def check_path(path: Path) -> None:
    """Raise UsageError if the path does not end in .html, or if its directory does not exist."""
    if path.suffix.lower() not in SUFFIXES:
        raise UsageError(f"{path.name!r} is not a name for a report: expected a name that ends in .html")
    if not path.parent.is_dir():
        raise UsageError(f"{path} cannot be written: {path.parent} is not a directory")


def write_page(page: Page, path: Path) -> None:
    """Write a report to an HTML file.  Raises AxistwinError if the file cannot be written."""
    check_path(path)
    write_file(path, _html(page))


def of_recorded_files(
    title: str, verdict: str, good: bool, details: Sequence[str], conversation: Path, trace: Path
) -> Page:
    from axistwin.records.plots.trace_chart import of_trace
    from axistwin.records.traces.reading import read

    lines = conversation.read_text(encoding="utf-8").splitlines() if conversation.exists() else []
    try:
        found = read(trace)
    except (TraceError, UsageError):  # A report has no chart if the trace file contains no signal changes.
        return Page(title, verdict, good, lines, {}, details=details)
    return Page(title, verdict, good, lines, found.about, of_trace(found), details=details)


def _html(page: Page) -> str:
    parts = [
        f"<h1>{escape(page.title)}</h1>",
        f'<p class="verdict {"good" if page.good else "bad"}">{escape(page.verdict)}</p>',
        *([_lines(page.details)] if page.details else []),
        *_picture(page.chart),
        *(["<h2>Moves</h2>", _lines(page.summary)] if page.summary else []),
        "<h2>Conversation</h2>",
        _conversation(page.conversation),
        "<h2>Provenance</h2>",
        _table(page.provenance),
    ]
    head = f'<meta charset="utf-8"><title>{escape(page.title)}</title><style>{STYLE}</style>'
    viewport = '<meta name="viewport" content="width=device-width, initial-scale=1">'
    body = "\n".join(parts)
    return f'<!DOCTYPE html>\n<html lang="en"><head>{head}{viewport}</head><body>\n{body}\n</body></html>\n'


def _picture(chart: "Chart | None") -> list[str]:
    if chart is None:
        return []
    from axistwin.records.plots.picture import (
        as_svg,  # Only a report with a chart imports Matplotlib, which loads slowly.
    )

    return [f"<figure>{as_svg(chart)}</figure>"]


def _conversation(lines: Sequence[str]) -> str:
    shown = lines[-MOST_LINES:]
    left_out = f"<p>The first {len(lines) - len(shown):,} lines are left out.</p>\n" if len(shown) < len(lines) else ""
    return left_out + _lines(shown)


def _lines(lines: Sequence[str]) -> str:
    return f'<pre tabindex="0">{escape(chr(10).join(lines))}</pre>'


def _table(rows: Mapping[str, str]) -> str:
    cells = "".join(f"<tr><th>{escape(key)}</th><td>{escape(value)}</td></tr>" for key, value in rows.items())
    return f"<table>{cells}</table>"
