"""`axistwin rescue`: save the programs and the data of a controller."""

import json
import sys
from pathlib import Path

import click

from axistwin.bench import line_format, product
from axistwin.cli.common.completing import complete_model
from axistwin.real.hosts.real_time import open_end
from axistwin.real.probing.rescue.compumotor import SETUP
from axistwin.real.probing.rescue.contents import reader
from axistwin.real.probing.rescue.finding import find
from axistwin.real.probing.rescue.saving import SCENE, Rescue, check_new
from axistwin.real.probing.rescue.saving import rescue as save
from axistwin.sim.frames import UartFormat

SHOWN = {"RSP": "sample period and firmware", "RCKS": "checksums"}  # Names of values that are printed, in words.


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.argument("port")
@click.option("--model", metavar="MODEL", shell_complete=complete_model,
              help="Model of the controller; default: an 1811 on a bus, or the family that answers.")  # fmt: skip
@click.option("--line", metavar="FORMAT", help="Line format, e.g. '9600 8N2'; default: all usual formats are tried.")
@click.option("--out", type=click.Path(file_okay=False, path_type=Path), metavar="DIR", default=Path("rescued"),
              show_default=True, help="New directory for the files.")  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Print all values as JSON.")
def rescue(port: str, model: str | None, line: str | None, out: Path, as_json: bool) -> int:
    """Save the programs and the data of the controller at PORT.

    PORT is a serial device, tcp://HOST:PORT, rfc2217://HOST:PORT, bus://HOST:PORT or a URL of pyserial.  The baud rate
    and the frame are found.  DIR receives a scene, the program and the whole exchange.  The same requests are then sent
    to a twin, a virtual controller that is started from the scene; the exit code is 1 if the twin answers differently.

    No motor moves during a rescue, and a controller that is moving is refused.

    \b
    axistwin rescue /dev/ttyUSB0
    axistwin rescue tcp://terminalserver:4001 --model smartmotor --out cutter
    axistwin rescue bus://127.0.0.1:1811 --out winder
    """
    check_new(out)
    if model is not None:
        reader(model)  # Raises UsageError before the port is opened.
    usual = UartFormat() if model is None else product(model).line
    fmt = None if line is None or usual is None else line_format(line, usual)[0]
    end = open_end(port, None if port.startswith("bus://") and (model is None or usual is None) else fmt or usual)
    try:
        found = find(end, model, fmt, lambda tried: _show(f"trying {tried}"))
        done = save(end, found, out, _progress)
    finally:
        end.close()
        _show("")
    if as_json:
        click.echo(json.dumps(done.as_dict(), indent=1, ensure_ascii=False))
    else:
        _print(done, out)
    return 1 if done.differences else 0


def _progress(answers: int, unanswered: int) -> None:
    silent = f", the last {unanswered} requests unanswered" if unanswered > 1 else ""
    _show(f"{answers} answers{silent}")


def _show(text: str) -> None:
    if sys.stderr.isatty():
        click.echo(f"\r\x1b[K{text}", nl=False, err=True)


def _print(done: Rescue, out: Path) -> None:
    line = "" if done.found.line is None else f", {done.found.line}"
    click.echo(f"{done.found.model}{line}")
    for name, words in SHOWN.items():
        if name in done.contents.values:
            click.echo(f"{words}: {done.contents.values[name]}")
    for text in done.contents.missing:
        click.echo(f"not read: {text}")
    for name in done.files:
        click.echo(out / name)
    if done.found.model in ("1810", "1811") and SETUP not in done.files:
        click.echo(f"no {SETUP}: the board contains nothing that has been set since its power-up")
    for name, (real, twin) in done.differences.items():
        click.echo(f"differs: {name}: the controller has {real}, the twin {twin or 'nothing'}")
    if not done.differences:
        depends = f", except {len(done.contents.depends)} that depend on the machine" if done.contents.depends else ""
        click.echo(f"the twin of {out / SCENE} gives the same answers{depends}")
