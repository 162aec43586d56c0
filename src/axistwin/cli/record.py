"""`axistwin record`: between a host and a real controller, write down what they say and when."""

import asyncio
import logging
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

import click

from axistwin.bench import FAMILIES, line_format, product
from axistwin.bench.actions import level_name
from axistwin.bench.events import Changed
from axistwin.cli.ending import ending
from axistwin.cli.seconds import Seconds
from axistwin.cli.serve import NOW_AND_THEN_S
from axistwin.cli.served import ANY_PORT
from axistwin.conversations.recorder import LF_NS, Recorder, recording_to
from axistwin.errors import LinkError, UsageError
from axistwin.links.pacing import Pacer
from axistwin.links.relay import Relay
from axistwin.links.server import Server
from axistwin.links.urls import PortUrl, parse, parse_as
from axistwin.sim.frames import UartFormat
from axistwin.sim.pins import Pin
from axistwin.sim.serial_port import Flow
from axistwin.units import US
from axistwin.version import VERSION

log = logging.getLogger("axistwin")

USUAL = UartFormat(9600, 8, "N", 2)
ON_FOR_S = 2.0
GRAIN_NS = US
"""What is known of real time is told in microseconds."""


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.option("--serial", "device", required=True, metavar="DEV", help="The controller: a device, or a pyserial URL.")
@click.option("--tcp", multiple=True, metavar="H:P", help="For the host: raw TCP. Port 0: any free.")
@click.option("--rfc2217", multiple=True, metavar="H:P", help="The same with line format, control lines and break.")
@click.option("--pty", multiple=True, metavar="PATH", help="The same as a pseudo terminal, with a link to it at PATH.")
@click.option("-o", "--output", type=click.Path(dir_okay=False, path_type=Path), metavar="FILE.talk",
              help="The recording; else a name with date and time.")  # fmt: skip
@click.option("--line", metavar="FORMAT", help="Line format of the controller, such as '9600 8N2'; else its usual one.")
@click.option("--model", metavar="MODEL", help="What it is, so that the recording says so.")
@click.option("--on-for", type=Seconds(), default=ON_FOR_S, show_default=True, metavar="SECONDS",
              help="How long it has been switched on when the recording begins.")  # fmt: skip
@click.option("--flow", type=click.Choice(["dtr", "none"]), default="none", show_default=True,
              help="dtr: hold the host's characters back while the controller's DTR is off.")  # fmt: skip
def record(
    device: str,
    tcp: tuple[str, ...],
    rfc2217: tuple[str, ...],
    pty: tuple[str, ...],
    output: Path | None,
    line: str | None,
    model: str | None,
    on_for: float,
    flow: str,
) -> int:
    """Sit between a host and a real controller, and write a conversation with times.

    The controller is on a serial device, or on whatever pyserial can open.  The host takes the port that is told.  All
    is passed on at once and written as it goes, until interrupted; then `axistwin replay` tells how well a virtual
    controller does in the place of the real one.

    For what speaks RS232 or RS485.  An 1810 or 1811 is reached through the bus of its computer, where nothing can sit
    between; `docs/recording.md` tells what to do.

    \b
    axistwin record --serial /dev/ttyUSB0 --model if1 -o session.talk
    axistwin record --serial /dev/ttyUSB0 --line "9600 8N1" --tcp 127.0.0.1:5001
    axistwin record --serial /dev/ttyUSB0 --rfc2217 127.0.0.1:2217    the host sets format, DTR and RTS
    axistwin record --serial /dev/ttyUSB0 --pty /tmp/if1              the host wants a device
    axistwin record --serial socket://terminalserver:4001             it is on a terminal server
    """
    given = {"tcp": tcp, "rfc2217": rfc2217, "pty": pty}
    urls = [parse_as(scheme, text) for scheme, texts in given.items() for text in texts]
    fmt, name = _format(model, line), model or "controller"
    path = output or Path(f"{name}-{datetime.now(UTC):%Y%m%d-%H%M%S}.talk")
    logging.basicConfig(format="axistwin: %(message)s", level=logging.INFO)
    relay = Relay(device, name, fmt)
    try:
        headers = _headers(device, model, fmt, on_for)
        with recording_to(relay.bench, path, headers, grain_ns=GRAIN_NS, raw=relay.raw) as recorder:
            _record_lines(relay, name, recorder)
            code = asyncio.run(_relay(relay, name, urls or [parse(ANY_PORT)], Flow(flow), recorder, path))
    finally:
        relay.close()
    return code


def _format(model: str | None, line: str | None) -> UartFormat:
    usual = USUAL if model is None else product(model).line
    if usual is None:
        serial = ", ".join(name for name in FAMILIES if product(name).line is not None)
        raise UsageError(f"a {model} is on a bus, where nothing can sit between: there are recordings of {serial}")
    return line_format(line, usual)[0]


def _headers(device: str, model: str | None, line: UartFormat, on_for: float) -> dict[str, str]:
    """The first comments; those that name no setting are for people."""
    now = f"{datetime.now(UTC):%Y-%m-%dT%H:%M:%SZ}"
    return {
        "model": model or "",
        "line": str(line),
        "on-for": f"{on_for:g}",
        "recorded": f"{now} from {device} by axistwin {VERSION}",
    }


def _record_lines(relay: Relay, name: str, recorder: Recorder) -> None:
    """What the host does with its control lines are acts, what the controller does with its own can be seen."""
    port = relay.port
    for subject, line in (("dtr", port.dtr_line), ("rts", port.rts_line)):
        line.watch(partial(_shown, recorder, name, subject))
    for subject, line in (("dtr", port.host.dtr_line), ("rts", port.host.rts_line)):
        line.watch(partial(_done, recorder, name, subject))


async def _relay(relay: Relay, name: str, urls: list[PortUrl], flow: Flow, recorder: Recorder, path: Path) -> int:
    ended = ending()
    server = Server(relay.bench, flow=flow)
    try:
        for url in urls:
            await server.open(name, url)
        server.start()
        relay.start(server.pacer, partial(_lost, ended))
        for _, url in server.ports:
            click.echo(f"{name} listening on {url}")
        log.info("recording %s into %s", relay.url, path)
        _now_and_then(server.pacer, recorder)
        return await ended
    finally:
        server.pacer.sync()
        server.close()


def _now_and_then(pacer: Pacer, recorder: Recorder) -> None:
    """So that the last answer is written, too."""
    pacer.sync()
    if recorder.silent_ns > LF_NS:  # nothing is ever to come on this bench, and yet the message may go on
        recorder.catch_up()
    asyncio.get_running_loop().call_later(NOW_AND_THEN_S, _now_and_then, pacer, recorder)


def _lost(ended: asyncio.Future[int], error: LinkError) -> None:
    if not ended.done():
        ended.set_exception(error)


def _shown(recorder: Recorder, name: str, subject: str, line: Pin) -> None:
    recorder.record_state(name, subject, level_name(line.level))


def _done(recorder: Recorder, name: str, subject: str, line: Pin) -> None:
    recorder.record(Changed(recorder.bench.now, name, f"host.{subject}", line.level))
