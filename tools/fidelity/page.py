"""The report as one self-contained HTML page."""

import re
from collections.abc import Iterable, Sequence
from html import escape
from typing import Any

STYLE = """
body{font:15px/1.45 system-ui,sans-serif;max-width:1200px;margin:2em auto;padding:0 1em;color:#1b2430;background:#fff}
table{border-collapse:collapse;width:100%;margin:.6em 0 1.6em}
th,td{text-align:left;vertical-align:top;padding:.3em .6em;border-bottom:1px solid #d8dee6}
th{background:#eef2f6;position:sticky;top:0} code{font-size:90%} td.n{text-align:right}
.no{color:#b00020;font-weight:600}
summary{cursor:pointer;font-weight:600;padding:.3em 0} nav a{margin-right:1.2em}
@media(prefers-color-scheme:dark){body{background:#12161b;color:#dde3ea}th{background:#1f2730}
th,td{border-color:#303a45}a{color:#7db7ff}.no{color:#ff8a80}}
"""


def table(head: Sequence[str], lines: Iterable[Sequence[Any]]) -> str:
    """Return a table; integers are aligned right, `False` is a highlighted "no"."""
    rows = "\n".join(f"<tr>{''.join(map(_cell, line))}</tr>" for line in lines)
    return f"<table><thead><tr>{''.join(f'<th>{escape(name)}' for name in head)}</thead>\n<tbody>{rows}</tbody></table>"


def _cell(value: Any) -> str:
    if isinstance(value, bool):
        return "<td>yes</td>" if value else '<td class="no">no</td>'
    if isinstance(value, int | float):
        return f'<td class="n">{value}</td>'
    return f"<td>{text(value)}</td>"


def text(words: Any) -> str:
    """Return text as HTML; text in backticks becomes code."""
    return re.sub(r"`([^`]*)`", r"<code>\1</code>", escape(str(words)))


def section(name: str, title: str, *parts: str) -> str:
    """Return a section with an anchor."""
    return f'<section id="{name}"><h2>{escape(title)}</h2>\n{"".join(parts)}</section>\n'


def folded(title: str, inside: str) -> str:
    """Return contents that are shown after a click on their title."""
    return f"<details><summary>{escape(title)}</summary>{inside}</details>\n"


def page(title: str, sections: Sequence[tuple[str, str, str]], words: str) -> str:
    """Return the page: `sections` are names, titles and contents."""
    links = "".join(f'<a href="#{name}">{escape(short)}</a>' for name, short, _ in sections)
    inside = "".join(section(name, short, content) for name, short, content in sections)
    return (
        f'<!doctype html><html lang="en"><meta charset="utf-8"><title>{escape(title)}</title><style>{STYLE}</style>\n'
        f"<h1>{escape(title)}</h1><p>{words}</p><nav>{links}</nav>\n{inside}</html>\n"
    )
