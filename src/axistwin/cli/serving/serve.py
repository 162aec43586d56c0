"""`axistwin serve`: connect virtual controllers to real ports until the user presses Ctrl-C."""

import asyncio
import gc
import logging
from collections.abc import Awaitable, Callable, Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack, contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Self

import click

from axistwin.bench import Bench
from axistwin.bench.options import read_options
from axistwin.cli.common.completing import complete_target
from axistwin.cli.common.parameters import TRACE_LIMIT, Number, Size
from axistwin.cli.serving import bench_and_ports as what_is
from axistwin.cli.serving.bench_and_ports import Ports
from axistwin.cli.serving.ending import ending, fail
from axistwin.cli.serving.preparing import preparing
from axistwin.cli.serving.sparing import log_to_stderr
from axistwin.core.errors import AxistwinError, UsageError, require
from axistwin.links.pacing import Pacer, read_speed
from axistwin.links.server import Server
from axistwin.links.urls import PortUrl, parse, parse_as
from axistwin.scenes.diagnostics.refused_lines import RefusedLines
from axistwin.sim.serial_port import Flow

if TYPE_CHECKING:
    from axistwin.ui.panel.web import Panel

CATCH_UP_S = 0.1


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.argument("what", metavar="MODEL|SCENE.toml", shell_complete=complete_target)
@click.option("--tcp", multiple=True, metavar="H:P",
              help="Raw TCP. Without a host: only this machine. Port 0: any free port.")  # fmt: skip
@click.option("--pty", multiple=True, metavar="PATH", help="A pseudo terminal, with a link to it at PATH.")
@click.option("--rfc2217", multiple=True, metavar="H:P", help="TCP with line format, control lines and break.")
@click.option("--serial", multiple=True, metavar="DEV", help="A real serial device, at the baud rate of --line.")
@click.option("--bus", multiple=True, metavar="H:P", help="The registers of a board on a bus, for an 1810 or 1811.")
@click.option("--rs485", multiple=True, metavar="H:P", help="Raw TCP to the second channel of a SmartMotor.")
@click.option("--port", multiple=True, metavar="URL", help="A port as a URL, e.g. serial:///dev/ttyUSB0?baud=9600.")
@click.option("--speed", default="1", show_default=True, metavar="N|max",
              help="Virtual time per real time; max: as fast as possible.")  # fmt: skip
@click.option("--state", type=click.Path(file_okay=False), metavar="DIR",
              help="Directory for the data kept without power.")  # fmt: skip
@click.option("--line", metavar="FORMAT",
              help="The host's format if the port has none: '9600 8N2', 'instant', or both.")  # fmt: skip
@click.option("--flow", type=click.Choice(["dtr", "none"]), default="dtr", show_default=True,
              help="Flow control of the host's characters, if the port has none.")  # fmt: skip
@click.option("--reset-on-connect", is_flag=True, help="Cycle the controller's power for each new client.")
@click.option("--share", is_flag=True, help="Let several clients use one TCP port: requests one after the other, every "
              "client receives every answer.")  # fmt: skip
@click.option("--trace", type=click.Path(dir_okay=False), metavar="FILE", help="Write a trace: .csv, .vcd or .parquet.")
@click.option("--signals", metavar="NAME,…", help="Signals to trace: 'default,motor.RPE', 'if1.X.*', '*'.")
@click.option("--trace-limit", type=Size(), default=TRACE_LIMIT, show_default=True, metavar="SIZE|none",
              help="Largest size of the trace, e.g. 5GB.")  # fmt: skip
@click.option("--record", type=click.Path(dir_okay=False), metavar="FILE", help="Record the conversation as FILE.talk.")
@click.option("--panel", metavar="[H:]P",
              help="Serve a panel for browsers at this port. Without a host: only this machine.")  # fmt: skip
@click.option("--wait", is_flag=True, help="Start virtual time when the first browser or host connects.")
@click.option("--to", type=Number(min=0), metavar="SECONDS",
              help="With --panel: run to this virtual time at full speed, and pause.")  # fmt: skip
@click.option("--panel-token", metavar="WORD", help="Token for browsers; generated if other machines can connect.")
@click.option("--quiet", is_flag=True, help="Do not tell lines that a controller refuses.")
@click.option("--json", "as_json", is_flag=True, help="Print the ports as one JSON object in one line.")
@click.option("--show-hosts", is_flag=True, help="Print connection lines for pyserial, PyVISA and EPICS asyn.")
@click.option("--option", "options", multiple=True, metavar="NAME=VALUE",
              help="An option of the model, as in Bench.add.")  # fmt: skip
def serve(
    what: str, speed: str, state: str | None, line: str | None, flow: str, reset_on_connect: bool, share: bool,
    trace: str | None, signals: str | None, trace_limit: int | None, record: str | None, panel: str | None,
    panel_token: str | None, wait: bool, to: float | None, quiet: bool, show_hosts: bool, as_json: bool,
    options: tuple[str, ...], **ports: tuple[str, ...],
) -> int:  # fmt: skip
    """Connect a virtual controller, or all controllers of a scene, to real ports until the user presses Ctrl-C.

    For each port one line is printed, such as `if1 listening on tcp://127.0.0.1:5001`.  Several ports may lead to the
    same controller: the first client is connected, and others are refused until it disconnects.  With --share several
    clients can connect to a TCP port.  With --json the ports
    are one JSON object: {"ports": [{"name": "if1", "url": "tcp://127.0.0.1:5001", "hosts": []}], "panel": null}.

    A line that a controller refuses is told once on stderr, with the reason and the remedy.  --quiet ends this.

    The exit code is 130 after an interrupt (Ctrl-C) and 0 after SIGTERM or SIGHUP.  All save the data kept without
    power, as switching off does.

    \b
    axistwin serve if1                              on a free TCP port of this machine
    axistwin serve if1 --tcp :5001 --show-hosts
    axistwin serve if2 --pty /tmp/if2 --state ./if2
    axistwin serve if1 --rfc2217 127.0.0.1:2217     pyserial: serial_for_url("rfc2217://127.0.0.1:2217")
    axistwin serve if1 --serial /dev/ttyUSB0 --line 2400
    axistwin serve 1811 --bus :1811 --show-hosts    for C hosts
    axistwin serve smartmotor --tcp :5001 --rs485 :5002
    axistwin serve if1 --tcp :5001 --speed max --line instant       for tests
    axistwin serve if1 --tcp :5001 --record session.talk            then: axistwin run if1 session.talk
    axistwin serve examples/drill/scene.toml --panel 8080           then open http://127.0.0.1:8080/
    axistwin serve if1 --tcp :5001 --share          a second program sees the conversation, and can take part
    axistwin serve xy.toml --wait                   virtual time starts with the first host or browser
    axistwin serve scene.toml --panel 8080 --to 4.2                 paused at 4.2 s, to be examined
    axistwin serve if2 --panel 0.0.0.0:8080         for other machines; the token is printed
    axistwin serve if1 --option self_test_s=0.2 --option 'X={limits=[-5000,5000]}'
    """
    times = read_speed(speed)
    if to is not None and panel is None:
        raise UsageError("--to (run to a given time, then pause) needs the panel: add --panel, e.g. --panel 8080")
    served = _served(what, ports, {"state": state, "line": line}, options, with_panel=panel is not None)
    headers = _headers(what, options, line) if record and served.scene is None else None
    log_to_stderr(logging.INFO)
    with _Files() as files:
        shown = _panel(served, times, panel, panel_token)
        bench = served.build() if shown is None else shown.session.bench
        wanted = served.ports(bench)
        refused = RefusedLines()
        for watch in (_log_hints, *([] if quiet else [refused.watch])):
            if shown is None:
                watch(bench)
            else:
                shown.session.each_bench(watch)
        files.write(_recording(bench, record, headers), _tracing(bench, trace, signals, trace_limit))
        if shown is None:
            server = Server(bench, speed=times, flow=Flow(flow), reset=reset_on_connect, share=share)
        else:
            server = shown.session.serve(flow=Flow(flow), reset=reset_on_connect, share=share)
            shown.session.each_bench(files.end_unless_of(bench))
        show = _show_json if as_json else _show_lines
        start = partial(_start, server, shown, waits=wait or served.waits, to=to)
        with ExitStack() as background:
            background.callback(refused.close)
            # Compile the emulator of each controller in the background, so that the ports open without delay.
            prepare = partial(background.enter_context, preparing(bench, times))
            return asyncio.run(_serve(server, wanted, shown, partial(show, server, show_hosts), start, prepare, files))


def _served(
    what: str, ports: Mapping[str, tuple[str, ...]], state_and_line: Mapping[str, str | None], options: tuple[str, ...],
    *, with_panel: bool,
) -> what_is.Served:  # fmt: skip
    given = [parse_as(scheme, text) for scheme in ("tcp", "pty", "rfc2217", "serial", "bus") for text in ports[scheme]]
    given += [parse(text) for text in ports["port"]]
    second = [parse_as("tcp", text) for text in ports["rs485"]]
    if not what.endswith(".toml"):
        return what_is.model(what, given, second, {**state_and_line, **read_options(options)})
    if second or options or any(state_and_line.values()):
        raise UsageError(
            "--state, --line, --rs485 and --option cannot be used with a scene: make these settings in the scene file"
        )
    return what_is.scene(what, given, alone=with_panel)


def _panel(served: what_is.Served, speed: float | None, panel: str | None, token: str | None) -> "Panel | None":
    if panel is None:
        if token is not None:
            raise UsageError("--panel-token needs a panel: add --panel, e.g. --panel 8080")
        return None
    require("NiceGUI", "panel")
    from axistwin.scenes.sessions.session import Session
    from axistwin.ui.panel.address import Address
    from axistwin.ui.panel.web import Panel

    session = Session(served.build, speed, scene=served.scene, served=True)
    return Panel(served.title, session, Address.read(panel, token))


def _headers(model: str, options: tuple[str, ...], line: str | None) -> dict[str, str]:
    import shlex

    return {"model": model, "options": shlex.join(options), "line": line or ""}


class _Files:
    def __init__(self) -> None:
        self._stack = ExitStack()
        self._catch_up: list[Callable[[], None]] = []

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        self._catch_up.clear()
        self._stack.close()

    def write(self, *writers: AbstractContextManager[Callable[[], None] | None]) -> None:
        begun = (self._stack.enter_context(writer) for writer in writers)
        self._catch_up = [catch_up for catch_up in begun if catch_up is not None]

    @property
    def open(self) -> bool:
        return bool(self._catch_up)

    def catch_up(self) -> None:
        for catch_up in self._catch_up:
            catch_up()

    def end_unless_of(self, bench: Bench) -> Callable[[Bench], None]:
        """Return a callback that closes the files when a new simulation, another bench than `bench`, begins."""

        def end(another: Bench) -> None:
            if another is not bench and self.open:
                logging.getLogger("axistwin").warning("trace and recording end here: the session has gone back in time")
                try:
                    self.close()
                except AxistwinError as error:
                    logging.getLogger("axistwin").warning("%s", error)

        return end


@contextmanager
def _tracing(
    bench: Bench, path: str | None, signals: str | None, limit: int | None
) -> Iterator[Callable[[], None] | None]:
    if path is None:
        yield None
        return
    from axistwin.records.traces.signals import split
    from axistwin.records.traces.trace import tracing

    with tracing(bench, Path(path), split(signals), limit=limit) as traced:
        yield traced.catch_up
    if traced.incomplete:
        raise AxistwinError(f"the trace {path} is incomplete")


@contextmanager
def _recording(bench: Bench, path: str | None, headers: dict[str, str] | None) -> Iterator[Callable[[], None] | None]:
    if path is None:
        yield None
        return
    from axistwin.bench.talk.recorder import recording_to

    with recording_to(bench, Path(path), headers) as recorder:
        yield recorder.catch_up


def _log_hints(bench: Bench) -> None:
    for name, controller in bench.controllers.items():
        controller.subscribe_hint(partial(logging.getLogger("axistwin").warning, "%s: %s", name))


Show = Callable[[str | None], None]  # Function that prints the ports; its argument is the address of the panel.


async def _serve(
    server: Server, wanted: Ports, shown: "Panel | None", show: Show, start: Callable[[], Awaitable[None]],
    prepare: Callable[[], object], files: _Files,
) -> int:  # fmt: skip
    ended = ending()
    server.pacer.on_defect = partial(fail, ended)
    try:
        for name, url in wanted:
            await server.open(name, url)
        panel = None if shown is None else await shown.open()
        # Later garbage collections are short without the present objects.  A full one here would delay the start.
        gc.freeze()
        await start()
        show(panel)
        prepare()
        if files.open:
            _catch_up_regularly(server.pacer, files)
        code = await ended
    finally:
        if shown is not None:
            await shown.close()
        server.pacer.sync()
        server.close()
        try:
            files.close()  # End the trace and the recording before the controllers are switched off.
        finally:
            for controller in server.bench.controllers.values():
                controller.power(False)
            if late := server.pacer.report():
                logging.getLogger("axistwin.links").warning("%s", late)
    return code or int(any(controller.store.lost for controller in server.bench.controllers.values()))


async def _start(server: Server, shown: "Panel | None", *, waits: bool, to: float | None) -> None:
    if shown is not None and to is not None:
        await shown.session.advance_to(to)
    elif shown is not None:
        (shown.session.wait if waits else shown.session.run)()
    elif waits:
        server.start_on_connection()
    else:
        server.start()


def _show_lines(server: Server, show_hosts: bool, panel: str | None) -> None:
    if panel is not None:
        click.echo(f"panel on {panel}")
    for name, url in server.ports:
        click.echo(f"{name} listening on {url}")
        for line in _host_lines(server, name, url) if show_hosts else ():
            click.echo(f"    {line}")


def _show_json(server: Server, show_hosts: bool, panel: str | None) -> None:
    import json

    ports = [
        {"name": name, "url": str(url), "hosts": list(_host_lines(server, name, url)) if show_hosts else []}
        for name, url in server.ports
    ]
    click.echo(json.dumps({"ports": ports, "panel": panel}, ensure_ascii=False))


def _host_lines(server: Server, name: str, url: PortUrl) -> Iterator[str]:
    from axistwin.cli.serving import host_lines

    if url.scheme == "bus":
        return host_lines.bus(url)
    controller = server.bench.controllers.get(name.partition(".")[0])
    ends = (b"\r", b"\r") if controller is None else controller.product.endings
    return host_lines.lines(name, url, server.bench.port(name).host.format, ends)


def _catch_up_regularly(pacer: Pacer, files: _Files) -> None:
    pacer.inspect(files.catch_up)
    asyncio.get_running_loop().call_later(CATCH_UP_S, _catch_up_regularly, pacer, files)
