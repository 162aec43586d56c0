"""`axistwin commands`: the command table of a model."""

import json
import sys
from shutil import get_terminal_size
from textwrap import fill

import click

from axistwin.bench import product
from axistwin.bench.codec import show_controls
from axistwin.cli.common.completing import complete_model
from axistwin.cli.common.listing import print_rows
from axistwin.controllers.commandset import Command

HEADINGS = ("code", "hex", "name", "syntax", "parameters", "chapter", "implemented")
REPORT = "Tests and evidence of each: the fidelity report, docs/report.md."


@click.command()
@click.argument("model", shell_complete=complete_model)
@click.option("--json", "as_json", is_flag=True, help="One JSON object instead of a table.")
def commands(model: str, as_json: bool) -> None:
    """List all commands of the controller MODEL, in the order of its manual.

    The columns are: syntax (parts in brackets may be left out), parameters with range and unit, the manual's chapter,
    and if the command is implemented.  Control characters are shown as <CR>, <LF> and <SP>.  Into a pipe, one line per
    command is written, with tabs between the columns.

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
        return
    print_rows(HEADINGS, list(map(_row, made.commands)), made.title)
    if sys.stdout.isatty():
        missing = sum(not command.implemented for command in made.commands)
        end = "All are implemented." if not missing else f"{missing} are not implemented."
        click.echo(fill(f"{end}  {REPORT}", get_terminal_size().columns))


def _row(command: Command) -> tuple[str, ...]:
    code = command.code
    number = f"{code:02X}" if isinstance(code, int) else f"{ord(code):02X}" if len(code) == 1 else ""
    parameters = ", ".join(map(str, command.parameters))
    implemented = "yes" if command.implemented else "no"
    shown = number if isinstance(code, int) else show_controls(code)
    return shown, number, command.name, show_controls(command.syntax), parameters, command.chapter, implemented
