"""`axistwin schema`: the JSON Schema of a scene file, for editors."""

import json

import click

from axistwin.scenes.scene import Scene


@click.command(short_help="The JSON Schema of a scene file, for editors.")
def schema() -> None:
    """Print the JSON Schema of a scene file, so that an editor can complete keys and tell what is wrong while you type.

    Write it beside the scene, and name it in the scene's first line:

    \b
      axistwin schema > scene.json
      #:schema scene.json
    """
    click.echo(json.dumps(Scene.schema(), indent=2, ensure_ascii=False))
