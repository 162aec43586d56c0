"""`axistwin examples`: list the examples, or copy one."""

import json
from pathlib import Path

import click

from axistwin.cli.common.completing import complete_example
from axistwin.cli.common.listing import print_rows
from axistwin.core.errors import UsageError, unknown
from axistwin.ui.guide.shipped import examples as shipped


@click.command()
@click.argument("name", required=False, shell_complete=complete_example)
@click.argument("directory", type=click.Path(file_okay=False, path_type=Path), required=False, metavar="[DIR]")
@click.option("--json", "as_json", is_flag=True, help="One JSON object instead of text.")
def examples(name: str | None, directory: Path | None, as_json: bool) -> None:
    """List all examples, or copy the example NAME into the directory DIR.

    An example is a scene with its programs and a page about it.  No file is overwritten.

    \b
    Examples:
      axistwin examples
      axistwin examples drill my-drill
      axistwin run my-drill/scene.toml
    """
    found = shipped()
    if name is None:
        if as_json:
            listed = [{"name": one.name, "title": one.title, "scene": one.scene} for one in found.values()]
            click.echo(json.dumps({"examples": listed}, ensure_ascii=False))
            return
        print_rows(("example", "title"), ((one.name, one.title) for one in found.values()))
        return
    if name not in found:
        raise unknown(kind="example", name=name, names=found)
    if directory is None:
        raise UsageError(
            f"the directory for the example is missing: expected e.g. 'axistwin examples {name} my-{name}'"
        )
    paths = found[name].copy(directory)
    if as_json:
        click.echo(json.dumps({"example": name, "files": [str(path) for path in paths]}, ensure_ascii=False))
        return
    for path in paths:
        click.echo(path)
    if command := found[name].command:
        click.echo(f"axistwin: next: {command} {directory / found[name].scene}", err=True)
