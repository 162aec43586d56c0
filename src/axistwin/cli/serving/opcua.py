"""`axistwin opcua`: serve axes as an OPC UA address space."""

import asyncio
import json
import logging
from pathlib import Path

import click

from axistwin.cli.common.completing import complete_model
from axistwin.cli.common.parameters import FILE
from axistwin.cli.serving import stations as of
from axistwin.cli.serving.ending import ending
from axistwin.cli.serving.sparing import log_to_stderr
from axistwin.core.errors import LinkError, UsageError, reason, require

LOOPBACK = "127.0.0.1"


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.argument("what", metavar="SCENE.toml|PORT")
@click.option("--model", metavar="MODEL", shell_complete=complete_model, help="Model of the controller at a PORT.")
@of.options
@click.option("--listen", default=LOOPBACK, show_default=True, metavar="ADDRESS", help="Address of this machine for "
              "clients; any other one needs --users and --certificates.")  # fmt: skip
@click.option("--port", type=click.IntRange(1, 65535), default=4840, show_default=True, metavar="N", help="TCP port.")
@click.option("--users", type=FILE, metavar="FILE", help="File with a line NAME PASSWORD operator|viewer per user; "
              "a viewer can only read.")  # fmt: skip
@click.option("--certificates", type=click.Path(file_okay=False, path_type=Path), metavar="DIR",
              help="Sign and encrypt with key.pem and certificate.der in DIR, made if missing; with DIR/trusted, only "
              "clients with a certificate in it can connect.")  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Print the URL as one JSON object in one line.")
def opcua(
    what: str, model: str | None, listen: str, port: int, users: Path | None, certificates: Path | None, as_json: bool,
    **given: object,
) -> int:  # fmt: skip
    """Run an OPC UA server with the axes, pins and registers of controllers, until the user presses Ctrl-C.

    The virtual controllers of a SCENE run inside; at a PORT there is a real or a virtual controller.  PORT is a serial
    device, COM3, tcp://HOST:PORT, rfc2217://HOST:PORT or bus://HOST:PORT, and needs --model.

    An axis is the object Objects/Machines/CONTROLLER/Axes/AXIS with the variables Position, Busy, Faults and others,
    and the methods MoveTo, MoveBy, MoveAt, Home, Stop, Abort, SetPosition and ClearFaults.  Its node is named
    CONTROLLER.AXIS, such as if1.X, and a variable if1.Axes.X.Position.

    The exit code is 130 after an interrupt (Ctrl-C) and 0 after SIGTERM or SIGHUP.  A motion continues after the end.
    It is 1 if data kept without power (state in a scene) could not be written.

    \b
    axistwin opcua examples/xy-table.toml
    axistwin opcua /dev/ttyUSB0 --model if1 --units "X=400 per mm"
    axistwin opcua scene.toml --listen 192.168.1.20 --users users.txt --certificates ./certificates
    """
    require("asyncua", "opcua")
    if listen != LOOPBACK and (users is None or certificates is None):
        raise UsageError(f"--listen {listen} permits access from the network: add --users FILE and --certificates DIR")
    wanted = of.Wanted.read(what, model, given)
    log_to_stderr(logging.WARNING)
    return asyncio.run(_serve(wanted, listen, port, users, certificates, as_json=as_json))


async def _serve(
    wanted: of.Wanted, address: str, port: int, users: Path | None, certificates: Path | None, *, as_json: bool
) -> int:
    from axistwin.real.integrations.opcua.security import read_users
    from axistwin.real.integrations.opcua.server import serving

    logging.basicConfig(format="axistwin: %(message)s")
    accounts = None if users is None else read_users(users)
    ended = ending()
    async with await wanted.machine() as machine:
        try:
            async with serving(machine, address, port, users=accounts, certificates=certificates) as url:
                click.echo(json.dumps({"url": url}) if as_json else f"serving {url}")
                code = await ended
        except OSError as error:
            raise LinkError(
                f"cannot listen on {address}:{port} ({reason(error)}): choose another --listen or --port"
            ) from None
    return code or int(machine.memory_lost)
