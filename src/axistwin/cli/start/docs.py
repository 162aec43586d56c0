"""`axistwin docs`: the pages of the documentation, in a browser or as text."""

import json
import sys
import webbrowser
from pathlib import Path

import click

from axistwin.cli.common.completing import complete_page
from axistwin.cli.common.listing import print_rows
from axistwin.core.errors import UsageError, unknown
from axistwin.core.storage import user_cache, write_error
from axistwin.core.version import VERSION
from axistwin.ui.guide import pages


@click.command()
@click.argument("page", default=pages.START, shell_complete=complete_page)
@click.option("--list", "listing", is_flag=True, help="List the pages.")
@click.option("--text", "as_text", is_flag=True, help="Print the page instead of opening it.")
@click.option("--out", type=click.Path(file_okay=False, path_type=Path), metavar="DIR",
              help="Write the HTML pages into this directory, and open nothing.")  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="With --list: one JSON object instead of text.")
@click.option("--playground", is_flag=True, help="Write the playground, a page that runs axistwin in the browser.")
@click.option("--engine", type=click.Path(exists=True, file_okay=False, path_type=Path), metavar="DIR",
              help="With --playground: the folder of Pyodide's files, see the page `playground`.")  # fmt: skip
def docs(
    page: str, listing: bool, as_text: bool, out: Path | None, as_json: bool, playground: bool, engine: Path | None
) -> None:
    """Open a PAGE of the documentation in the browser, or the first page if PAGE is left out.

    The pages come with axistwin and need no network.  The address of the page is printed, too.

    \b
    Examples:
      axistwin docs
      axistwin docs ports
      axistwin docs --list
      axistwin docs scenes --text | less
      axistwin docs --playground --engine build/engine --out site
    """
    if playground:
        _playground(out, engine)
        return
    names = pages.names()
    if listing:
        _list(names, as_json)
        return
    if as_json:
        raise UsageError("--json is only for the list of pages: expected axistwin docs --list --json")
    wanted = page.removesuffix(".md")
    if wanted not in names:
        raise unknown(kind="page", name=page, names=names)
    if as_text:
        _print(pages.text(wanted))
        return
    try:
        place = pages.build(out or user_cache() / f"pages-{VERSION}") / f"{wanted}.html"
    except (OSError, RuntimeError) as error:
        remedy = "choose a directory with --out DIR"
        if isinstance(error, OSError):
            raise write_error("cannot write the pages", error, remedy) from None
        raise UsageError(f"cannot write the pages ({error}): {remedy}") from None
    address = place.resolve().as_uri()
    click.echo(address)
    if out is None and not webbrowser.open(address):
        click.echo("axistwin: no browser was found: open the address by hand, or use --text", err=True)


def _playground(out: Path | None, engine: Path | None) -> None:
    if out is None or engine is None:
        raise UsageError("--playground needs two folders: expected --engine DIR --out DIR")
    from axistwin.ui.playground.building import build

    try:
        page = build(out, engine)
    except OSError as error:
        raise write_error(
            "cannot write the files of the playground", error, "choose another directory with --out DIR"
        ) from None
    click.echo(page)
    click.echo(
        f"axistwin: next: {Path(sys.executable).name} -m http.server --bind 127.0.0.1 --directory {out}", err=True
    )


def _list(names: dict[str, str], as_json: bool) -> None:
    if as_json:
        listed = [{"name": name, "title": title} for name, title in names.items()]
        click.echo(json.dumps({"pages": listed}, ensure_ascii=False))
        return
    print_rows(("page", "title"), names.items())


def _print(page: str) -> None:
    if not sys.stdout.isatty():
        click.echo(page)
        return
    from rich.console import Console
    from rich.markdown import Markdown

    Console().print(Markdown(page))
