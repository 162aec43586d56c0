"""`axistwin record`: record the conversation of a host with a real controller."""

import asyncio
import logging
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

import click

from axistwin.bench import line_format, product
from axistwin.bench.actions import level_name
from axistwin.bench.events import LevelChanged
from axistwin.bench.models import models
from axistwin.bench.talk.recorder import LF_NS, Recorder, recording_to
from axistwin.cli.common.parameters import FILE, Seconds
from axistwin.cli.serving.bench_and_ports import ANY_PORT
from axistwin.cli.serving.ending import ending, fail
from axistwin.cli.serving.serve import CATCH_UP_S
from axistwin.core.errors import UsageError
from axistwin.core.units import US
from axistwin.core.version import VERSION
from axistwin.links.pacing import Pacer
from axistwin.links.relay import Relay
from axistwin.links.server import Server
from axistwin.links.urls import PortUrl, parse, parse_as
from axistwin.sim.frames import UartFormat
from axistwin.sim.pins import Pin
from axistwin.sim.serial_port import Flow

log = logging.getLogger("axistwin")

USUAL = UartFormat(9600, 8, "N", 2)
ON_FOR_S = 2.0
RESOLUTION_NS = US  # Resolution of the recorded times in ns.


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.option("--serial", "device", required=True, metavar="DEV",
              help="Port of the controller: a device, or a pyserial URL.")  # fmt: skip
@click.option("--tcp", multiple=True, metavar="H:P", help="Port for the host: raw TCP. Port 0: any free port.")
@click.option("--rfc2217", multiple=True, metavar="H:P",
              help="Port for the host: TCP with line format, control lines and break.")  # fmt: skip
@click.option("--pty", multiple=True, metavar="PATH", help="Port for the host: a pseudo terminal, with a link at PATH.")
@click.option("-o", "--output", type=FILE, metavar="FILE.talk",
              help="The recording; default: a name with date and time.")  # fmt: skip
@click.option("--line", metavar="FORMAT",
              help="Line format of the controller, e.g. '9600 8N2'; default: its usual format.")  # fmt: skip
@click.option("--model", metavar="MODEL", help="Model of the controller, noted in the recording.")
@click.option("--on-for", type=Seconds(), default=ON_FOR_S, show_default=True, metavar="SECONDS",
              help="Time since the controller was switched on.")  # fmt: skip
@click.option("--flow", type=click.Choice(["dtr", "none"]), default="none", show_default=True,
              help="dtr: hold back the host's characters while the controller's DTR is off.")  # fmt: skip
def record(
    device: str, tcp: tuple[str, ...], rfc2217: tuple[str, ...], pty: tuple[str, ...], output: Path | None,
    line: str | None, model: str | None, on_for: float, flow: str,
) -> int:  # fmt: skip
    """Relay all data between a host and a real controller, and record their conversation with times.

    The controller is on a serial device, or on a URL of pyserial.  The host connects to the port that is printed.
    All data is passed on at once, and recorded until the user presses Ctrl-C.  `axistwin replay` then compares a
    virtual controller with the recording.

    For controllers on RS232 or RS485.  An 1810 or 1811 is on the bus of its computer, where no relay is possible; see
    `docs/recording.md`.

    \b
    axistwin record --serial /dev/ttyUSB0 --model if1 -o session.talk
    axistwin record --serial /dev/ttyUSB0 --line "9600 8N1" --tcp 127.0.0.1:5001
    axistwin record --serial /dev/ttyUSB0 --rfc2217 127.0.0.1:2217    the host sets format, DTR and RTS
    axistwin record --serial /dev/ttyUSB0 --pty /tmp/if1              for a host that opens a device
    axistwin record --serial socket://terminalserver:4001             a controller on a terminal server
    """
    given = {"tcp": tcp, "rfc2217": rfc2217, "pty": pty}
    urls = [parse_as(scheme, text) for scheme, texts in given.items() for text in texts]
    fmt, name = _format(model, line), model or "controller"
    path = output or Path(f"{name}-{datetime.now(UTC):%Y%m%d-%H%M%S}.talk")
    logging.basicConfig(format="axistwin: %(message)s", level=logging.INFO)
    relay = Relay(device, name, fmt)
    try:
        headers = _headers(device, model, fmt, on_for)
        with recording_to(relay.bench, path, headers, grain_ns=RESOLUTION_NS, raw=relay.raw, relayed=True) as recorder:
            _record_lines(relay, name, recorder)
            code = asyncio.run(_relay(relay, name, urls or [parse(ANY_PORT)], Flow(flow), recorder, path))
    finally:
        relay.close()
    return code


def _format(model: str | None, line: str | None) -> UartFormat:
    if model is None:
        return line_format(line, USUAL)[0]
    made = product(model)
    if made.line is None:
        serial_models = ", ".join(name for name in models() if product(name).line is not None)
        raise UsageError(f"the model {made.model} has no serial port to record: expected one of {serial_models}")
    return line_format(line, made.line)[0]


def _headers(device: str, model: str | None, line: UartFormat, on_for: float) -> dict[str, str]:
    now = f"{datetime.now(UTC):%Y-%m-%dT%H:%M:%SZ}"
    return {
        "model": model or "", "line": str(line), "on-for": f"{on_for:g}",
        "recorded": f"{now} from {device} by axistwin {VERSION}",
    }  # fmt: skip


def _record_lines(relay: Relay, name: str, recorder: Recorder) -> None:
    """Record changes of control lines: those of the host as actions, those of the controller as states."""
    for at, act in ((relay.port, _record_shown), (relay.port.host, _done)):
        at.dtr_line.subscribe(partial(act, recorder, name, "dtr"))
        at.rts_line.subscribe(partial(act, recorder, name, "rts"))


async def _relay(relay: Relay, name: str, urls: list[PortUrl], flow: Flow, recorder: Recorder, path: Path) -> int:
    ended = ending()
    server = Server(relay.bench, flow=flow)
    try:
        for url in urls:
            await server.open(name, url)
        server.start()
        relay.start(server.pacer, partial(fail, ended))
        for _, url in server.ports:
            click.echo(f"{name} listening on {url}")
        log.info("recording %s into %s", relay.url, path)
        _catch_up_regularly(server.pacer, recorder)
        return await ended
    finally:
        server.pacer.sync()
        server.close()


def _catch_up_regularly(pacer: Pacer, recorder: Recorder) -> None:
    pacer.sync()
    if recorder.silent_ns > LF_NS:  # An answer of the controller is complete after 50 ms without a character.
        recorder.catch_up()
    asyncio.get_running_loop().call_later(CATCH_UP_S, _catch_up_regularly, pacer, recorder)


def _record_shown(recorder: Recorder, name: str, subject: str, line: Pin) -> None:
    recorder.record_state(name, subject, level_name(line.level))


def _done(recorder: Recorder, name: str, subject: str, line: Pin) -> None:
    recorder.record(LevelChanged(recorder.bench.now, name, f"host.{subject}", line.level))
