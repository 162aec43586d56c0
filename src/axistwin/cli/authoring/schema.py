"""`axistwin schema`: the JSON Schema of a scene file, for editors."""

import json

import click

from axistwin.scenes.scene import Scene


@click.command()
def schema() -> None:
    """Print the JSON Schema of a scene file; an editor then completes keys and reports errors during typing.

    Write the schema next to the scene, and name it in the scene's first line:

    \b
      axistwin schema > scene.json
      #:schema scene.json
    """
    click.echo(json.dumps(Scene.schema(), indent=2, ensure_ascii=False))
