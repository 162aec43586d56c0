"""Generated pages of the reference: commands, options, codes, and the pages of the examples.

These pages are not in the repository, because the tables and examples are their source.
"""

import re
from collections.abc import Iterator
from pathlib import Path
from shutil import copytree

import click

from axistwin.bench import product, show_controls
from axistwin.cli.program import axistwin
from axistwin.controllers.diagnostics import Rule
from axistwin.controllers.front import Lamp
from axistwin.scenes.diagnostics import codes

EXAMPLES = Path(__file__).parents[1] / "examples"
MODELS = {"if2": "Digiplan IF1 and IF2", "1811": "Compumotor 1810 and 1811", "smartmotor": "Animatics SmartMotor 4.76"}

PAGES = {"if2": "if1", "1811": "1811", "smartmotor": "smartmotor"}
"""Name of the page of each family in `docs/families`."""
FIDELITY = EXAMPLES.parent / "docs" / "fidelity.md"


TRY = """<iframe src="playground/index.html" title="axistwin in this page" loading="lazy"
  style="width: 100%; height: 44rem; border: 1px solid #8888; border-radius: .5rem"></iframe>

<p>This is axistwin in your browser: choose a machine, and type.
<a href="playground/index.html">Open it as a page of its own</a>.</p>"""
NO_ENGINE = "This page contains the [playground](playground.md) only if `make engine docs` has built the documentation."


def write(folder: Path, *, with_playground: bool) -> None:
    """Write every page into `folder`; `with_playground`: the site contains the playground."""
    try_it = f"```{{raw}} html\n{TRY}\n```" if with_playground else NO_ENGINE
    pages = {
        "try.md": try_it,
        "codes.md": "\n".join(diagnostics()),
        "cli.md": cli(),
        "commands.md": "\n".join(commands()),
    }
    folder.mkdir(exist_ok=True)
    for name, text in pages.items():
        (folder / name).write_text(text, encoding="utf-8")
    (folder / "families").mkdir(exist_ok=True)
    for model, title in MODELS.items():
        text = "\n".join((*status_bits(model), *chapters(model, title)))
        (folder / "families" / f"{PAGES[model]}.md").write_text(text, encoding="utf-8")
    copytree(EXAMPLES, folder / "examples", dirs_exist_ok=True)


def status_bits(model: str) -> Iterator[str]:
    """Return the bits of the status answers: value, name and meaning, as the front panel shows them."""
    yield "**Status answers.** A status answer is the sum of the weights of all bits that are 1. In a table of status"
    yield "bits, the column *bit* contains the weight of each bit: 1, 2, 4 or a higher power of 2. To see which bits of"
    yield "a status answer are 1, enter `:explain NUMBER` in `axistwin term`, where `NUMBER` is the status answer.\n"
    for group in product(model).front:
        bits = [lamp for lamp in group.items if isinstance(lamp, Lamp) and lamp.bit is not None]
        if bits:
            yield f"{group.title}:\n\n| bit | name | meaning |\n| --- | --- | --- |"
            for lamp in bits:
                value = f"{1 << (lamp.bit or 0)}"
                label = "" if lamp.label == value else f" `{lamp.label}`"
                yield f"| {value}{label} | {lamp.name} | {_cell(lamp.doc)} |"
            yield ""


def chapters(model: str, title: str) -> Iterator[str]:
    """Return the chapters of a manual with their commands, and the decisions by parts of `fidelity.md`."""
    found: dict[str, list[str]] = {}
    table = list(product(model).commands)
    removed = sum(not each.implemented for each in table)
    for each in table:
        code = f"{each.code:02X}" if isinstance(each.code, int) else show_controls(each.code)
        found.setdefault(each.chapter, []).append(f"`{code}`".replace("|", "\\|"))
    others = f" The motor refuses the {removed} commands that firmware 4.76 has removed." if removed else ""
    yield f"**Chapters of the manual.** All {len(table) - removed} commands are implemented: see the"
    yield f"[list](../generated/commands.md).{others}\n"
    yield "| chapter of the manual | commands |"
    yield "| --- | --- |"
    yield from (f"| {chapter} | {' '.join(codes)} |" for chapter, codes in found.items())
    yield "\n**Decisions.** Where the manual says nothing or contradicts itself, axistwin follows a decision about the"
    yield "emulated behaviour. The links below lead to the decisions about this family of controllers. For each"
    yield "decision about the emulated behaviour, the page [Fidelity](../fidelity.md) contains the evidence from the"
    yield "manual and the names of the tests.\n"
    family = FIDELITY.read_text(encoding="utf-8").split(f"\n## {title}\n")[1].split("\n## ")[0]
    first, *parts = family.split("\n### ")
    for part in ([f"{title}\n{first}"] if "\n| " in first else []) + parts:
        heading, rows = part.split("\n", 1)
        count = len(re.findall(r"^\| (?!question|---)", rows, re.MULTILINE))
        if count:
            decisions = f"{count} decision{'s' if count > 1 else ''} about the emulated behaviour"
            yield f"* The section [{heading}](../fidelity.md#{_anchor(heading)}) contains {decisions}."


def _anchor(heading: str) -> str:
    """Return the anchor that MyST gives a heading."""
    return re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-")


def commands() -> Iterator[str]:
    """Return the command lists of the manuals, one table per family."""
    yield "# Commands of the controllers\n"
    yield "This page is made from the command tables that the parsers, checkers and editors of axistwin use."
    yield "`axistwin commands MODEL` prints the commands of one model.\n"
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
        source = "page" if title == codes.OURS else "chapter of the manual"
        yield f"| code | problem | severity | {source} |"
        yield "| --- | --- | --- | --- |"
        yield from (f"| [{r.code}](#{r.code.lower()}) | {r.title} | {r.severity} | {r.chapter} |" for r in table)
        yield ""
        for rule in table:
            yield from _section(rule)


def _section(rule: Rule) -> tuple[str, ...]:
    ours = rule.chapter.startswith("docs/")
    source = f"the page `{rule.chapter}`" if ours else f"the chapter *{rule.chapter}* of the manual"
    return (
        f"### {rule.code}\n",
        f"{rule.severity.capitalize()}: {rule.title}. See {source}.\n",
        f"{_without_html(rule.explanation.replace('.  ', '. '))}\n",
        f"```{codes.suffix_of(rule)[1:]}",
        *codes.shown(rule.example),
        "```\n",
    )


def _without_html(text: str) -> str:
    """Return the text with `<` as an HTML entity, except in code between backquotes."""
    parts = text.split("`")
    parts[::2] = [part.replace("<", "&lt;") for part in parts[::2]]
    return "`".join(parts)


def cli() -> str:
    """Return the reference of the command line, from the texts of `--help`."""
    context = click.Context(axistwin, info_name="axistwin")
    purpose = "This page shows the output of `axistwin --help` and of `axistwin COMMAND --help`.\n"
    parts = ["# The command line\n", purpose, _help(context)]
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
