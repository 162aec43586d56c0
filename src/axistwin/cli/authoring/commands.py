"""`axistwin commands`: the command table of a model."""

import json
import sys
from collections.abc import Iterable
from shutil import get_terminal_size

import click

from axistwin.bench import product
from axistwin.bench.control_characters import show_controls
from axistwin.controllers.commandset import Command
from axistwin.reports.columns import columns

HEADINGS = ("code", "hex", "name", "syntax", "parameters", "chapter", "implemented")
REPORT = "Tests and evidence of each: the fidelity report, docs/report.md."
NARROWEST = 100
"""Narrowest terminal for the table; in a narrower one, one line per command wraps better."""


@click.command()
@click.argument("model")
@click.option("--json", "as_json", is_flag=True, help="One JSON object instead of a table.")
def commands(model: str, as_json: bool) -> None:
    """List every command in the manual of MODEL, in the manual's order.

    The columns are: syntax (parts in brackets may be left out), parameters with range and unit, the manual's chapter,
    and if the command is implemented.  Control characters are shown as <CR>, <LF> and <SP>.

    The fidelity report, docs/report.md, has the tests and the evidence of each command.

    \b
    Examples:
      axistwin commands if1
      axistwin commands if1 | grep speed
      axistwin commands if2 --json
    """
    made = product(model)
    if as_json:
        listed = [command.as_dict() for command in made.commands]
        click.echo(json.dumps({"model": made.model, "title": made.title, "commands": listed}, ensure_ascii=False))
    elif sys.stdout.isatty() and get_terminal_size().columns >= NARROWEST:
        _print_table(made.title, made.commands)
    else:
        for line in columns([HEADINGS, *map(_row, made.commands)]):
            click.echo(line)


def _row(command: Command) -> tuple[str, ...]:
    code = command.code
    number = ""
    if isinstance(code, int):
        number = f"{code:02X}"
    elif len(code) == 1:
        number = f"{ord(code):02X}"
    parameters = ", ".join(map(str, command.parameters))
    implemented = "yes" if command.implemented else "no"
    shown = number if isinstance(code, int) else show_controls(code)
    return shown, number, command.name, show_controls(command.syntax), parameters, command.chapter, implemented


def _print_table(title: str, listed: Iterable[Command]) -> None:
    from rich.box import SIMPLE_HEAD  # lazy import: only for a terminal
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(title=title, box=SIMPLE_HEAD, pad_edge=False, padding=(0, 1), title_justify="left")
    styles = {"code": "bold", "syntax": "cyan", "chapter": "dim"}
    for heading in HEADINGS[:-1]:
        table.add_column(heading, style=styles.get(heading, ""), no_wrap=heading in ("code", "hex", "syntax"))
    missing = 0
    for command in listed:
        missing += not command.implemented
        table.add_row(*map(Text, _row(command)[:-1]), style="" if command.implemented else "strike")
    console = Console()
    console.print(table)
    console.print("All are implemented." if not missing else f"{missing} (struck out) are not implemented.")
    console.print(REPORT)
