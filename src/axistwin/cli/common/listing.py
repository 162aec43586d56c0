"""Print rows of text: as a table that fits the terminal, or with tabs between the fields for a pipe."""

import sys
from collections.abc import Iterable, Sequence
from shutil import get_terminal_size
from textwrap import wrap

import click

NARROWEST = 100  # Width in characters that a terminal needs for a table; on a narrower one, each row is a paragraph.


def print_rows(headings: Sequence[str], rows: Iterable[Sequence[str]], title: str = "") -> None:
    """Print rows as a table that fits the terminal, or as one line per row into a pipe or a file."""
    if not sys.stdout.isatty():
        for row in (headings, *rows):
            click.echo("\t".join(row))
        return
    width = get_terminal_size().columns
    if width >= NARROWEST:
        _print_table(headings, rows, title, width)
        return
    for first, *others in rows:
        for line in wrap(first, width):
            click.echo(line)
        for line in wrap("; ".join(filter(None, others)), max(width - 4, 1)):
            click.echo(f"    {line}")


def _print_table(headings: Sequence[str], rows: Iterable[Sequence[str]], title: str, width: int) -> None:
    from rich.box import SIMPLE_HEAD
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(title=title or None, box=SIMPLE_HEAD, pad_edge=False, padding=(0, 1), title_justify="left")
    for place, heading in enumerate(headings):
        table.add_column(heading, style="bold" if place == 0 else "", no_wrap=place == 0)
    for row in rows:
        table.add_row(*map(Text, row))
    Console(width=width).print(table)
