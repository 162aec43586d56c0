"""`axistwin serve`: put controllers on real ports, and run until interrupted."""

import asyncio
import gc
import logging
import shlex
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Self

import click

from axistwin.bench import Bench, product
from axistwin.bench.options import read_options
from axistwin.cli import served as what_is
from axistwin.cli.ending import ending, fail
from axistwin.cli.served import Ports
from axistwin.cli.sparing import Sparing
from axistwin.errors import MissingExtraError, UsageError
from axistwin.links.pacing import Pacer, read_speed
from axistwin.links.server import Server
from axistwin.links.urls import parse, parse_as
from axistwin.sim.serial_port import Flow

if TYPE_CHECKING:
    from axistwin.panel.web import Panel

NOW_AND_THEN_S = 0.1


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
@click.option(
    "--panel", metavar="[H:]P", help="See and touch it in a browser, at this port. Without a host: this machine only."
)
@click.option("--panel-token", metavar="WORD", help="What browsers have to know; made up where others may come.")
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
    panel: str | None,
    panel_token: str | None,
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
    axistwin serve examples/drill/scene.toml --panel 8080           then open http://127.0.0.1:8080/
    axistwin serve if2 --panel 0.0.0.0:8080         for others, too: they need the token that is printed
    axistwin serve if1 --option self_test_s=0.2 --option 'X={limits=[-5000,5000]}'
    """
    given = [parse_as(scheme, text) for scheme in ("tcp", "pty", "rfc2217", "serial", "bus") for text in ports[scheme]]
    given += [parse(text) for text in ports["port"]]
    second = [parse_as("tcp", text) for text in ports["rs485"]]
    times = read_speed(speed)
    headers = None
    if what.endswith(".toml"):
        if state or line or options or second:
            raise UsageError("--state, --line, --rs485 and --option belong to a MODEL: write them into the scene")
        served = what_is.scene(what, given, alone=panel is not None)
    else:
        served = what_is.model(what, given, second, {"state": state, "line": line, **read_options(options)})
        headers = {"model": what, "options": shlex.join(options), "line": line or ""}
    _talk()
    with _Files() as files:
        shown = _shown(served, times, panel, panel_token)
        bench = served.build() if shown is None else shown.session.bench
        wanted = served.ports(bench)
        _prepare(bench, times)
        if shown is None:
            _tell_hints(bench)
        else:
            shown.session.each_bench(_tell_hints)
        files.write(_recording(bench, record, headers), _tracing(bench, trace, signals))
        if shown is None:
            server = Server(bench, speed=times, flow=Flow(flow), reset=reset_on_connect)
        else:
            server = shown.session.serve(flow=Flow(flow), reset=reset_on_connect)
            shown.session.each_bench(files.end_unless_of(bench))
        return asyncio.run(_serve(server, wanted, shown, show_hosts, files))


def _shown(served: what_is.Served, speed: float | None, panel: str | None, token: str | None) -> "Panel | None":
    """It in a browser, if that is wished for.  Raises UsageError."""
    if panel is None:
        if token is not None:
            raise UsageError("--panel-token is for a --panel: say where that is to be, such as --panel 8080")
        return None
    try:
        from axistwin.panel.web import Address, Panel  # late: an extra
        from axistwin.sessions.session import Session
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] not in ("nicegui", "fastapi", "starlette", "uvicorn"):
            raise
        raise MissingExtraError("NiceGUI", "panel") from None
    session = Session(served.build, speed, scene=served.scene, served=True)
    return Panel(served.title, session, Address.read(panel, token))


class _Files:
    """The trace and the recording of a run."""

    def __init__(self) -> None:
        self._stack = ExitStack()
        self._catch_up: list[Callable[[], None]] = []

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Write the rest."""
        self._catch_up.clear()
        self._stack.close()

    def write(self, *writers: AbstractContextManager[Callable[[], None] | None]) -> None:
        """Begin with these."""
        begun = (self._stack.enter_context(writer) for writer in writers)
        self._catch_up = [catch_up for catch_up in begun if catch_up is not None]

    @property
    def open(self) -> bool:
        """Whether there is anything to be written."""
        return bool(self._catch_up)

    def catch_up(self) -> None:
        """Write what has happened by now."""
        for catch_up in self._catch_up:
            catch_up()

    def end_unless_of(self, bench: Bench) -> Callable[[Bench], None]:
        """What ends them when somebody goes back in time: they are of the bench that there is now, and of no other."""

        def end(another: Bench) -> None:
            if another is not bench and self.open:
                self._catch_up.clear()
                self._stack.close()
                logging.getLogger("axistwin").warning("trace and recording end here: somebody has gone back in time")

        return end


@contextmanager
def _tracing(bench: Bench, path: str | None, signals: str | None) -> Iterator[Callable[[], None] | None]:
    """Trace meanwhile; gives what is to be called now and then, so that long motions are written as they go."""
    if path is None:
        yield None
        return
    from axistwin.traces.signals import split  # late: few need it
    from axistwin.traces.trace import tracing

    with tracing(bench, Path(path), split(signals)) as traced:
        yield traced.catch_up


@contextmanager
def _recording(bench: Bench, path: str | None, headers: dict[str, str] | None) -> Iterator[Callable[[], None] | None]:
    """Record meanwhile, so that it can be played again on the same controller; gives the same."""
    if path is None:
        yield None
        return
    from axistwin.conversations.recorder import recording_to  # late: few need it

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


def _tell_hints(bench: Bench) -> None:
    """Tell on stderr when a controller has something to say about what keeps it from obeying."""
    for name, controller in bench.controllers.items():
        controller.watch_trouble(partial(logging.getLogger("axistwin").warning, "%s: %s", name))


def _talk() -> None:
    """What happens on the ports is told on stderr."""
    logging.basicConfig(format="axistwin: %(message)s", level=logging.INFO)
    for handler in logging.getLogger().handlers:
        handler.addFilter(Sparing())


async def _serve(server: Server, wanted: Ports, shown: "Panel | None", show: bool, files: _Files) -> int:
    ended = ending()
    server.pacer.on_defect = partial(fail, ended)  # also when somebody at the panel has had it advanced
    try:
        for name, url in wanted:
            await server.open(name, url)
        if shown is not None:
            click.echo(f"panel on {await shown.open()}")
        _spare_memory()
        _start(server, shown)
        for line in _lines(server, show):
            click.echo(line)
        if files.open:
            _now_and_then(server.pacer, files)
        return await ended
    finally:
        if shown is not None:
            await shown.close()
        server.pacer.sync()
        server.close()
        files.close()  # that it is switched off at the end is no part of what has happened
        for controller in server.bench.controllers.values():
            controller.power(False)
        if late := server.pacer.report():
            logging.getLogger("axistwin.links").warning("%s", late)


def _start(server: Server, shown: "Panel | None") -> None:
    if shown is None:
        server.start()
    else:
        shown.session.run()


def _spare_memory() -> None:
    """Objects made by now are permanent: the garbage collector need not go through them again while hosts wait."""
    gc.collect()
    gc.freeze()


def _lines(server: Server, show_hosts: bool) -> Iterator[str]:
    for name, url in server.ports:
        yield f"{name} listening on {url}"
        if show_hosts:
            from axistwin.cli import hosts  # late: only on request

            shown = (
                hosts.bus(url) if url.scheme == "bus" else hosts.lines(name, url, server.bench.port(name).host.format)
            )
            yield from (f"    {line}" for line in shown)


def _now_and_then(pacer: Pacer, files: _Files) -> None:
    pacer.look(files.catch_up)
    asyncio.get_running_loop().call_later(NOW_AND_THEN_S, _now_and_then, pacer, files)
