"""`axistwin faults`: the table of faults for scenes, conversations and Python."""

import json
from collections.abc import Iterator
from typing import Any

import click

from axistwin.bench.faults.kinds import KINDS, THINGS
from axistwin.bench.faults.table import Kind
from axistwin.cli.common.listing import print_rows

HEADINGS = ("fault", "on", "parameters", "what happens")


@click.command()
@click.option("--json", "as_json", is_flag=True, help="One JSON object instead of a table.")
def faults(as_json: bool) -> None:
    """List all faults that a scene can contain, with their parameters and effects.

    The names are the same in scenes ([[fault]]), in conversations (! fault lose 3) and in Python
    (bench.faults.add("lose", "if1.serial", count=3)).  All faults also take name, at, when, nth, duration and seed.

    \b
    Examples:
      axistwin faults
      axistwin faults | grep encoder
      axistwin faults --json
    """
    if as_json:
        click.echo(json.dumps({"faults": [as_dict(kind) for kind in KINDS.values()]}, ensure_ascii=False))
        return
    print_rows(HEADINGS, rows())


def rows() -> Iterator[tuple[str, ...]]:
    for kind in KINDS.values():
        yield kind.name, THINGS[kind.on], " ".join(_parameters(kind)), kind.doc


def as_dict(kind: Kind) -> dict[str, Any]:
    parameters = [
        {"name": p.name, "unit": p.unit, "wanted": p.wanted, "default": p.default, "optional": p.optional, "doc": p.doc}
        for p in kind.parameters
    ]
    return {
        "name": kind.name, "of": THINGS[kind.on], "example": kind.on.value, "at_once": kind.at_once, "doc": kind.doc,
        "parameters": parameters,
    }  # fmt: skip


def _parameters(kind: Kind) -> Iterator[str]:
    for parameter in kind.parameters:
        if parameter.default is not None:
            shown = ("low", "high")[parameter.default] if isinstance(parameter.default, bool) else parameter.default
            yield f"[{parameter.name}={shown}]"
        else:
            yield f"[{parameter.name}]" if parameter.optional else parameter.name
