"""`axistwin schema`: the JSON Schema of a scene file, for editors."""

import json

import click

from axistwin.scenes.scene import Scene


@click.command()
@click.option("--sweep", is_flag=True, help="The schema of a sweep file.")
def schema(sweep: bool) -> None:
    """Print the JSON Schema of scene files.  An editor uses the schema to complete keys and to report errors.

    Write the schema next to the scene, and name it in the scene's first line:

    \b
      axistwin schema > scene.json
      #:schema scene.json
    """
    if sweep:
        from axistwin.sweeps.sweep_file import SweepFile

        click.echo(json.dumps(SweepFile.model_json_schema(), indent=2, ensure_ascii=False))
        return
    click.echo(json.dumps(Scene.schema(), indent=2, ensure_ascii=False))
