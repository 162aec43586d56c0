"""Generated pages of the reference: commands, options, codes, and the pages of the examples.

These pages are not in the repository, because the tables and examples are their source.
"""

from collections.abc import Iterator
from pathlib import Path
from shutil import copytree

import click

from axistwin.bench import product, show_controls
from axistwin.cli.main import axistwin
from axistwin.controllers.diagnostics import Rule
from axistwin.diagnostics import codes

EXAMPLES = Path(__file__).parents[1] / "examples"
MODELS = {"if2": "Digiplan IF1 and IF2", "1811": "Compumotor 1810 and 1811", "smartmotor": "Animatics SmartMotor 4.76"}


def write(folder: Path) -> None:
    """Write every page into `folder`."""
    pages = {"codes.md": "\n".join(diagnostics()), "cli.md": cli(), "commands.md": "\n".join(commands())}
    folder.mkdir(exist_ok=True)
    for name, text in pages.items():
        (folder / name).write_text(text, encoding="utf-8")
    copytree(EXAMPLES, folder / "examples", dirs_exist_ok=True)


def commands() -> Iterator[str]:
    """Return the command lists of the manuals, one table per family."""
    yield "# Commands of the controllers\n"
    yield "From the tables that parsers, checkers and editors read; `axistwin commands MODEL` prints the same.\n"
    for model, title in MODELS.items():
        made = product(model)
        yield f"## {title}\n"
        yield "| code | name | syntax | parameters | manual |"
        yield "| --- | --- | --- | --- | --- |"
        for each in made.commands:
            code = f"{each.code:02X}" if isinstance(each.code, int) else show_controls(each.code)
            cells = (
                _literal(code),
                each.name,
                _literal(show_controls(each.syntax)),
                ", ".join(map(str, each.parameters)),
                each.chapter,
            )
            yield "| " + " | ".join(map(_cell, cells)) + " |"
        yield ""


def diagnostics() -> Iterator[str]:
    """Return the tables of codes with an example of each code, one chapter per family."""
    for title, table in codes.tables().items():
        yield f"## {title}\n"
        yield "| code | | severity | manual |"
        yield "| --- | --- | --- | --- |"
        yield from (f"| [{r.code}](#{r.code.lower()}) | {r.title} | {r.severity} | {r.chapter} |" for r in table)
        yield ""
        for rule in table:
            yield from _section(rule)


def _section(rule: Rule) -> tuple[str, ...]:
    return (
        f"### {rule.code}\n",
        f"{rule.title[0].upper()}{rule.title[1:]}: {rule.severity}. Manual: {rule.chapter}.\n",
        f"{rule.explanation.replace('.  ', '. ')}\n",
        f"```{codes.suffix_of(rule)[1:]}",
        *codes.shown(rule.example),
        "```\n",
    )


def cli() -> str:
    """Return the reference of the command line, from the texts of `--help`."""
    context = click.Context(axistwin, info_name="axistwin")
    parts = ["# The command line\n", "What `axistwin COMMAND --help` prints.\n", _help(context)]
    for name in axistwin.list_commands(context):
        command = axistwin.get_command(context, name)
        assert command is not None
        parts += [f"## axistwin {name}\n", _help(click.Context(command, info_name=name, parent=context))]
    return "\n".join(parts)


def _help(context: click.Context) -> str:
    context.max_content_width = 100
    return f"```text\n{context.command.get_help(context)}\n```\n"


def _literal(text: str) -> str:
    return f"`{text}`" if text else ""


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("<", "&lt;") if "`" not in text else text.replace("|", "\\|")
