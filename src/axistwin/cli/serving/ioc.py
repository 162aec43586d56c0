"""`axistwin ioc`: serve axes as motor records of EPICS."""

import asyncio
import json
import logging
import re
import sys
from contextlib import suppress

import click

from axistwin.cli.common.completing import complete_model
from axistwin.cli.serving import stations as of
from axistwin.cli.serving.ending import ending
from axistwin.cli.serving.sparing import log_to_stderr
from axistwin.core.errors import LinkError, UsageError, reason, require

NAME = re.compile(r"[A-Za-z0-9_:<>;.-]+")


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.argument("what", metavar="SCENE.toml|PORT")
@click.option("--prefix", required=True, metavar="P:", help="Beginning of all names of records, e.g. LAB:.")
@click.option("--model", metavar="MODEL", shell_complete=complete_model, help="Model of the controller at a PORT.")
@of.options
@click.option("--listen", multiple=True, metavar="ADDRESS", help="Address of this machine for clients; default: "
              "127.0.0.1, for clients on this machine only.")  # fmt: skip
@click.option("--port", type=click.IntRange(1024, 65000), metavar="N", help="UDP and TCP port of Channel Access; "
              "default: EPICS_CA_SERVER_PORT, or 5064.")  # fmt: skip
@click.option("--pva", is_flag=True, help="Serve the records by PV Access too.")
@click.option("--json", "as_json", is_flag=True, help="Print the names of the records as one JSON object in one line.")
def ioc(
    what: str, prefix: str, model: str | None, listen: tuple[str, ...], port: int | None, pva: bool, as_json: bool,
    **given: object,
) -> int:  # fmt: skip
    """Run an EPICS server with a record for each axis, pin and register, until the user presses Ctrl-C.

    The virtual controllers of a SCENE run inside; at a PORT there is a real or a virtual controller.  PORT is a serial
    device, COM3, tcp://HOST:PORT, rfc2217://HOST:PORT or bus://HOST:PORT, and needs --model.

    An axis is a motor record named P:CONTROLLER:AXIS, such as LAB:if1:X.  A pin or a register is a simple record, such
    as LAB:if1:input1.  A write to VAL with callback is answered when the axis is at rest.  Fields that have no effect
    refuse writes.  LAB:if1:X:FAULT holds the faults, and a 1 written to LAB:if1:X:CLEAR clears the faults.

    The exit code is 130 after an interrupt (Ctrl-C) and 0 after SIGTERM or SIGHUP.  A motion continues after the end.
    It is 1 if data kept without power (state in a scene) could not be written.

    \b
    axistwin ioc examples/xy-table.toml --prefix LAB:
    axistwin ioc /dev/ttyUSB0 --model if1 --prefix LAB: --units "X=400 per mm"
    axistwin ioc tcp://terminalserver:4001 --model smartmotor --prefix LAB: --registers a,RTEMP
    axistwin ioc bus://127.0.0.1:1811 --model 1811 --prefix LAB: --listen 192.168.1.20 --pva
    """
    require("caproto", "epics")
    if pva:
        require("p4p", "pva")
        _raise_limit()
    if not NAME.fullmatch(prefix):
        raise UsageError(f"invalid --prefix {prefix!r}: expected only letters, digits, ':', '_' and '-', e.g. LAB:")
    wanted = of.Wanted.read(what, model, given)
    log_to_stderr(logging.WARNING)
    return asyncio.run(_serve(wanted, prefix, listen or ("127.0.0.1",), port, pva=pva, as_json=as_json))


def _raise_limit() -> None:
    """Permit as many open files as the system does: p4p accepts clients without a limit, and spins when it cannot."""
    if sys.platform != "win32":
        import resource

        most = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
        with suppress(OSError, ValueError):  # macOS has no limit, but refuses it
            resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))


async def _serve(
    wanted: of.Wanted, prefix: str, addresses: tuple[str, ...], port: int | None, *, pva: bool, as_json: bool
) -> int:
    from axistwin.real.integrations.epics.ioc import LONGEST_NAME, Ioc

    ended = ending()
    async with await wanted.machine() as machine:
        served = Ioc(machine, prefix)
        longest_name = max(served.names, key=len)
        if len(longest_name) > LONGEST_NAME:
            raise UsageError(
                f"the record name {longest_name} is too long for EPICS: expected at most {LONGEST_NAME} characters"
            )
        try:
            async with served.serving(addresses, port, pv_access=pva) as address:
                if as_json:
                    click.echo(json.dumps({"address": address, "records": served.names}))
                else:
                    for name in served.names:
                        click.echo(name)
                    click.echo(f"{len(served.names)} records on {address}", err=True)
                code = await ended
        except OSError as error:
            raise LinkError(
                f"cannot listen on {', '.join(addresses)} ({reason(error)}): choose another --listen or --port"
            ) from None
    return code or int(machine.memory_lost)
