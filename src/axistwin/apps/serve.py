"""`axistwin serve`: put controllers on real ports, and run until interrupted."""

import asyncio
import logging
import shlex
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import click

from axistwin.apps.conversations import partners
from axistwin.apps.ending import ending
from axistwin.apps.target import read_options
from axistwin.bench import Bench, product
from axistwin.errors import UsageError
from axistwin.links.pacing import Pacer, read_speed
from axistwin.links.server import Server
from axistwin.links.urls import PortUrl, parse, parse_as
from axistwin.sim.serial_port import Flow

ANY_PORT, ANY_BUS_PORT = "tcp://127.0.0.1:0", "bus://127.0.0.1:0"
NOW_AND_THEN_S = 0.1

Ports = list[tuple[str, PortUrl]]


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.argument("what", metavar="MODEL|SCENE.toml")
@click.option(
    "--tcp", multiple=True, metavar="H:P", help="Raw TCP. Without a host: this machine only. Port 0: any free."
)
@click.option("--pty", multiple=True, metavar="PATH", help="A pseudo terminal, with a link to it at PATH.")
@click.option("--rfc2217", multiple=True, metavar="H:P", help="TCP with line format, control lines and break.")
@click.option("--serial", multiple=True, metavar="DEV", help="A real serial device, at the baud rate of --line.")
@click.option("--bus", multiple=True, metavar="H:P", help="The registers of a board on a bus, for an 1810 or 1811.")
@click.option("--rs485", multiple=True, metavar="H:P", help="Raw TCP to the second channel of a SmartMotor.")
@click.option("--port", multiple=True, metavar="URL", help="Any of these, such as serial:///dev/ttyUSB0?baud=9600.")
@click.option(
    "--speed", default="1", show_default=True, metavar="N|max", help="Times real time; max: as fast as it goes."
)
@click.option(
    "--state", type=click.Path(file_okay=False), metavar="DIR", help="Keep there what survives without power."
)
@click.option(
    "--line", metavar="FORMAT", help="The host's format where the port tells none: '9600 8N2', 'instant', both."
)
@click.option("--flow", type=click.Choice(["dtr", "none"]), default="dtr", show_default=True,
              help="What holds back the host's characters where the port does not decide.")  # fmt: skip
@click.option("--reset-on-connect", is_flag=True, help="A new client finds the controller just switched on.")
@click.option(
    "--trace", type=click.Path(dir_okay=False), metavar="FILE", help="Write what happens: .csv, .vcd or .parquet."
)
@click.option("--signals", metavar="NAME,…", help="What to trace: 'default,motor.RPE', 'if1.X.*', '*'.")
@click.option("--record", type=click.Path(dir_okay=False), metavar="FILE", help="Write what is said, as FILE.talk.")
@click.option("--show-hosts", is_flag=True, help="Show the lines to paste into pyserial, PyVISA and EPICS asyn.")
@click.option(
    "--option", "options", multiple=True, metavar="NAME=VALUE", help="An option of the model, as in Bench.add."
)
def serve(
    what: str,
    speed: str,
    state: str | None,
    line: str | None,
    flow: str,
    reset_on_connect: bool,
    trace: str | None,
    signals: str | None,
    record: str | None,
    show_hosts: bool,
    options: tuple[str, ...],
    **ports: tuple[str, ...],
) -> int:
    """Put a controller, or all those of a scene, on real ports, and run until interrupted.

    For each port one line is printed, such as `if1 listening on tcp://127.0.0.1:5001`.  Several ports may lead to the
    same controller: the first client of any of them is connected, others are refused until it has gone.

    Interrupted (Ctrl-C) it ends with exit code 130; asked to end (SIGTERM), with 0.  Either saves what is kept without
    power, as switching off does.

    \b
    axistwin serve if1                              on a free TCP port of this machine
    axistwin serve if1 --tcp :5001 --show-hosts
    axistwin serve if2 --pty /tmp/if2 --state ./if2
    axistwin serve if1 --rfc2217 127.0.0.1:2217     pyserial: serial_for_url("rfc2217://127.0.0.1:2217")
    axistwin serve if1 --serial /dev/ttyUSB0 --line 2400
    axistwin serve 1811 --bus :1811 --show-hosts    a line for each access to a register; C hosts
    axistwin serve smartmotor --tcp :5001 --rs485 :5002
    axistwin serve if1 --tcp :5001 --speed max --line instant       for tests
    axistwin serve if1 --tcp :5001 --record session.talk            then: axistwin run if1 session.talk
    axistwin serve if1 --option self_test_s=0.2 --option 'X={limits=[-5000,5000]}'
    """
    given = [parse_as(scheme, text) for scheme in ("tcp", "pty", "rfc2217", "serial", "bus") for text in ports[scheme]]
    given += [parse(text) for text in ports["port"]]
    second = [parse_as("tcp", text) for text in ports["rs485"]]
    times = read_speed(speed)
    if what.endswith(".toml"):
        if state or line or options or second:
            raise UsageError("--state, --line, --rs485 and --option belong to a MODEL: write them into the scene")
        bench, wanted = _scene(what, given)
        headers = None
    else:
        bench = Bench()
        name = bench.add(what, state=state, line=line, **read_options(options)).name
        wanted = [(name, url) for url in given or [_any_port(bench, name)]]
        wanted += [(f"{name}.rs485", url) for url in second]
        if second:
            bench.port(f"{name}.rs485")  # so that it can be observed
        headers = {"model": what, "options": shlex.join(options), "line": line or ""}
    _talk()
    _prepare(bench, times)
    with _recording(bench, record, headers) as heard, _tracing(bench, trace, signals) as traced:
        now_and_then = [catch_up for catch_up in (heard, traced) if catch_up is not None]
        return asyncio.run(_serve(bench, wanted, times, Flow(flow), reset_on_connect, show_hosts, now_and_then))


def _scene(path: str, given: list[PortUrl]) -> tuple[Bench, Ports]:
    """The bench of a scene, and the ports its file names, or else those that are given."""
    from axistwin.apps.scenes.scene import Scene  # late: a scene needs more than a model does

    scene = Scene.load(Path(path))
    bench = scene.build(served=True)
    names = [name for name in partners.names(bench) if name not in scene.hosted]
    if not names:
        raise UsageError(f"nobody in {path} is to be talked to: give a controller ports, or leave out its host")
    if not given:
        ports = [(name, parse(url)) for name, url in scene.ports]
        return bench, ports or [(name, _any_port(bench, name)) for name in names]
    if len(names) != 1:
        raise UsageError(f"{path} has several controllers: write their ports into the scene")
    return bench, [(name, url) for name in names for url in given]


def _any_port(bench: Bench, name: str) -> PortUrl:
    return parse(ANY_BUS_PORT if partners.at_a_bus(bench, name) else ANY_PORT)


@contextmanager
def _tracing(bench: Bench, path: str | None, signals: str | None) -> Iterator[Callable[[], None] | None]:
    """Trace meanwhile; gives what is to be called now and then, so that long motions are written as they go."""
    if path is None:
        yield None
        return
    from axistwin.apps.traces.signals import split  # late: few need it
    from axistwin.apps.traces.trace import tracing

    with tracing(bench, Path(path), split(signals)) as traced:
        yield traced.catch_up


@contextmanager
def _recording(bench: Bench, path: str | None, headers: dict[str, str] | None) -> Iterator[Callable[[], None] | None]:
    """Record meanwhile, so that it can be played again on the same controller; gives the same."""
    if path is None:
        yield None
        return
    from axistwin.apps.conversations.recorder import recording_to  # late: few need it

    with recording_to(bench, Path(path), headers) as recorder:
        yield recorder.catch_up


def _prepare(bench: Bench, speed: float | None) -> None:
    """Do now what would keep a host waiting; tell what the user should know."""
    products = Counter(controller.product.model for controller in bench.controllers.values())
    for model, number in products.items():
        made = product(model)
        made.prepare(speed, number)
        if note := made.note():
            logging.getLogger("axistwin").warning("%s", note)


def _talk() -> None:
    """What happens on the ports is told on stderr."""
    logging.basicConfig(format="axistwin: %(message)s", level=logging.INFO)


async def _serve(
    bench: Bench,
    wanted: Ports,
    speed: float | None,
    flow: Flow,
    reset: bool,
    show: bool,
    now_and_then: Sequence[Callable[[], None]],
) -> int:
    ended = ending()
    server = Server(bench, speed=speed, flow=flow, reset=reset)
    try:
        for name, url in wanted:
            await server.open(name, url)
        server.start()
        for line in _lines(server, show):
            click.echo(line)
        if now_and_then:
            _now_and_then(server.pacer, now_and_then)
        return await ended
    finally:
        server.pacer.sync()
        server.close()
        for controller in bench.controllers.values():
            controller.power(False)
        if late := server.pacer.report():
            logging.getLogger("axistwin.links").warning("%s", late)


def _lines(server: Server, show_hosts: bool) -> Iterator[str]:
    for name, url in server.ports:
        yield f"{name} listening on {url}"
        if show_hosts:
            from axistwin.apps import hosts  # late: only on request

            shown = (
                hosts.bus(url) if url.scheme == "bus" else hosts.lines(name, url, server.bench.port(name).host.format)
            )
            yield from (f"    {line}" for line in shown)


def _now_and_then(pacer: Pacer, doings: Sequence[Callable[[], None]]) -> None:
    pacer.work()  # it sleeps while nothing is due, also while a motor runs
    for do in doings:
        do()
    asyncio.get_running_loop().call_later(NOW_AND_THEN_S, _now_and_then, pacer, doings)
