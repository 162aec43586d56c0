"""`axistwin fmu`: write a scene as an FMU."""

from pathlib import Path

import click

from axistwin.cli.common.parameters import FILE
from axistwin.core.errors import UsageError


@click.command()
@click.argument("scene", metavar="SCENE.toml", type=FILE)
@click.option("--out", "-o", type=FILE, help="FILE.fmu; the name of the scene if left out.")
@click.option(
    "--command", "commands", metavar="NAME:LINE", multiple=True,
    help=r"An input that performs a line of a conversation, e.g. 'start: > X3000@5000S1$\r'.",
)  # fmt: skip
def fmu(scene: Path, out: Path | None, commands: tuple[str, ...]) -> None:
    """Write a scene as an FMU (FMI 3.0) for simulation tools such as Simulink or Dymola.

    Inputs are the torque on each shaft with the data sheet of a motor, and all open terminals.  Outputs are positions,
    velocities and terminals.  Hosts, conversations, programs, faults and the script of the scene are inside the FMU.
    Each --command adds a logical input NAME; a change to true performs LINE, which begins with > or !.

    The FMU needs Python with this version of axistwin on the computer of the simulation tool: docs/fmu.md.

    \b
    Examples:
      axistwin fmu scene.toml -o machine.fmu
      axistwin fmu scene.toml -o machine.fmu --command 'start: > X3000@5000S1$\\r' \\
          --command 'crash: ! fault jam X duration=0.5'
    """
    from axistwin.real.integrations.fmu.archive import export

    given: dict[str, str] = {}
    for each in commands:
        name, line = _named(each)
        if name in given:
            raise UsageError(f"two --command options have the name {name}: expected different names")
        given[name] = line
    path = export(scene, out or Path(f"{scene.stem}.fmu"), given)
    click.echo(f"axistwin: {path}", err=True)


def _named(text: str) -> tuple[str, str]:
    name, colon, line = text.partition(":")
    if not colon or not line.strip():
        raise UsageError(
            rf"invalid --command {text!r}: expected NAME: > COMMAND or NAME: ! ACTION, "
            r"e.g. 'start: > X3000@5000S1$\r'"
        )
    return name.strip(), line.strip()
