"""`axistwin shadow`: a twin beside a real controller."""

import asyncio
import logging
import signal
from collections.abc import Callable
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import Any

import click

from axistwin.bench import line_format, product
from axistwin.cli.common.completing import complete_model
from axistwin.cli.common.parameters import FILE, Number, Seconds
from axistwin.cli.common.target import bench_for
from axistwin.cli.serving.bench_and_ports import ANY_BUS_PORT, ANY_PORT
from axistwin.cli.serving.ending import INTERRUPTED, ending
from axistwin.controllers.product import Product
from axistwin.controllers.registry import texts_of
from axistwin.core.errors import LinkError, UsageError, require
from axistwin.core.units import S
from axistwin.links.relay import Relay
from axistwin.links.server import Server
from axistwin.links.urls import parse
from axistwin.real.hosts.port_end import PortEnd
from axistwin.real.shadow.asking import Asker, questions_of
from axistwin.real.shadow.board_asking import BoardAsker
from axistwin.real.shadow.bus_relay import BusRelay
from axistwin.real.shadow.feed import What
from axistwin.real.shadow.supervision import Supervisor
from axistwin.sim.frames import UartFormat
from axistwin.sim.serial_port import Flow

log = logging.getLogger("axistwin")

USUAL = UartFormat(9600, 8, "N", 2)
PANEL = "axistwin.cli.serving.shadow_panel"
CHECK_S, BEAT_S, ASKS_S, QUIET_S = 1.0, 0.02, 0.01, 10.0
LATE_S = 0.005  # Delay of this process above which its times are not used.


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.argument("real", required=False)
@click.option("--model", metavar="MODEL", shell_complete=complete_model, help="Model of the controller.")
@click.option("--scene", type=FILE, metavar="SCENE.toml", help="The machine, instead of --model: one controller.")
@click.option("--option", "options", multiple=True, metavar="NAME=VALUE", help="An option of the model or an axis.")
@click.option("--port", "ports", multiple=True, metavar="URL",
              help="Port for the host, e.g. rfc2217://127.0.0.1:2217; default: any free TCP port.")  # fmt: skip
@click.option("--listen", nargs=2, metavar="HOST_SIDE CONTROLLER_SIDE",
              help="Two receive-only lines, instead of REAL: what the host and the controller send.")  # fmt: skip
@click.option("--ask", is_flag=True,
              help="Also ask the controller for inputs, status and positions, while the line is silent.")  # fmt: skip
@click.option("--line", metavar="FORMAT", help="Line format, e.g. '9600 8N2'; default: the model's usual format.")
@click.option("--tolerance", type=Number(min=0), metavar="MS",
              help="Time that is never a finding; default: 15 ms, and what is usual for the machine.")  # fmt: skip
@click.option("--log", "log_file", type=FILE, metavar="FILE",
              help="Findings and durations as JSON lines; what is learnt is kept beside it.")  # fmt: skip
@click.option("--panel", metavar="[H:]P",
              help="Serve a panel for browsers that only shows. Without a host: only this machine.")  # fmt: skip
@click.option("--for", "duration", type=Seconds(), metavar="S", help="End after this time; default: at Ctrl-C.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object at the end, instead of text.")
def shadow(
    real: str | None, model: str | None, scene: Path | None, options: tuple[str, ...], ports: tuple[str, ...],
    listen: tuple[str, str] | None, ask: bool, line: str | None, tolerance: float | None, log_file: Path | None,
    panel: str | None, duration: float | None, as_json: bool,
) -> int:  # fmt: skip
    """Compare a real controller with its twin while the machine works.

    The host connects to the port that is printed, and the controller is at REAL: a serial device, tcp://HOST:PORT,
    rfc2217://HOST:PORT, bus://HOST:PORT or a URL of pyserial.  All data are passed on first, and compared afterwards in
    another process.  Without --ask nothing else is sent to the controller.  With --listen two receive-only lines are at
    the cable.

    One line per finding: answers that differ or come late, missing characters, moves that take longer, positions that
    disagree, faults.  A summary follows at the end, and at the signal SIGUSR1.  Exit code 1 if anything differed.

    \b
    axistwin shadow /dev/ttyUSB0 --model if1 --port rfc2217://127.0.0.1:2217 --log table.jsonl
    axistwin shadow tcp://terminalserver:4001 --scene machine.toml
    axistwin shadow bus://127.0.0.1:1811 --model 1811 --port bus://127.0.0.1:1812
    axistwin shadow --listen /dev/ttyUSB0 /dev/ttyUSB1 --model smartmotor
    """
    if ask and listen:
        raise UsageError("--ask needs a line to the controller, and --listen only receives: leave one of them out")
    made, fmt = _checked(real, model, scene, options, listen, line)
    if log_file is not None and not log_file.parent.is_dir():
        raise UsageError(f"{log_file} cannot be written: there is no directory {log_file.parent}")
    logging.basicConfig(format="axistwin: %(message)s", level=logging.INFO)
    settings = {
        "model": made, "scene": None if scene is None else str(scene), "options": options, "line": line,
        "devices": texts_of([made]), "tolerance_ms": tolerance,
        "log": None if log_file is None else str(log_file), "json": as_json,
        "panel": None if panel is None else _panel(panel), "listens": bool(listen),
    }  # fmt: skip
    return asyncio.run(_run(real, made, ports, listen, fmt, settings, duration, ask))


def _checked(
    real: str | None, model: str | None, scene: Path | None, options: tuple[str, ...],
    listen: tuple[str, str] | None, line: str | None,
) -> tuple[str, UartFormat | None]:  # fmt: skip
    """Return the model and the line format, which is None for a board on a bus."""
    if (real is None) == (listen is None):
        raise UsageError(
            "expected either REAL or --listen HOST_SIDE CONTROLLER_SIDE, e.g. axistwin shadow /dev/ttyUSB0 --model if1"
        )
    if (model is None) == (scene is None):
        raise UsageError("expected either --model or --scene, e.g. --model if1")
    if scene is not None:
        from axistwin.real.shadow.twin import endpoint
        from axistwin.scenes.scene import Scene

        if options:
            raise UsageError("--option cannot be used with a scene: make these settings in the scene file")
        bench = Scene.load(scene).build()
        model = bench[endpoint(bench)].product.model
    assert model is not None
    made = product(model)
    if scene is None:
        bench_for(model, options)  # An error in the options is told before the ports are open.
    on_bus, is_bus = made.line is None, real is not None and real.startswith("bus:")
    if on_bus is not is_bus:
        expected = "bus://HOST:PORT, e.g. bus://127.0.0.1:1811" if on_bus else "a serial port, e.g. /dev/ttyUSB0"
        raise UsageError(f"the model {made.model} is not at {real or 'a serial line'}: expected {expected}")
    return made.model, None if made.line is None else line_format(line, made.line)[0]


def _panel(text: str) -> tuple[str, int, str | None]:
    """Return the panel's address, whose port the twin's process opens.  Raises LinkError if the port is in use."""
    require("NiceGUI", "panel")
    from axistwin.ui.panel.address import Address, listening_socket

    given = Address.read(text, None)
    with listening_socket(given) as sock:
        return given.host, sock.getsockname()[1], given.token


async def _run(
    real: str | None, name: str, ports: tuple[str, ...], listen: tuple[str, str] | None, fmt: UartFormat | None,
    settings: dict[str, Any], duration: float | None, ask: bool,
) -> int:  # fmt: skip
    ended = ending()
    with ExitStack() as stack:
        if listen is not None:
            begin: Callable[[Supervisor], Any] = partial(_listen, listen, settings["line"], stack)
        elif fmt is None:
            begin = partial(_relay_bus, str(real), ports, name, stack, ask)
        else:
            begin = await _relay(str(real), name, fmt, ports, stack, ask)
        supervisor = Supervisor(settings, log.warning, *([PANEL] if settings["panel"] else []))
        try:
            await begin(supervisor)
        except BaseException:
            supervisor.kill()
            raise
        try:
            _subscribe_summary(supervisor)
            checking = asyncio.create_task(_check(supervisor))
            done, _ = await asyncio.wait({ended}, timeout=duration)
            checking.cancel()
            code = ended.result() if done else 0
        finally:
            stack.close()
            differed = supervisor.end()
    return differed or (0 if code == INTERRUPTED else code)


async def _check(supervisor: Supervisor) -> None:
    """Keep the twin alive, and tell it when this process was late itself, as its times are then wrong."""
    loop, checks = asyncio.get_running_loop(), 0
    while True:
        before_s = loop.time()
        await asyncio.sleep(BEAT_S)
        late_s = loop.time() - before_s - BEAT_S
        if late_s > LATE_S:
            supervisor.add(What.LATE, b"%d" % round(late_s * S))
        checks += 1
        if checks % round(CHECK_S / BEAT_S) == 0:
            supervisor.check()


def _subscribe_summary(supervisor: Supervisor) -> None:
    number = getattr(signal, "SIGUSR1", None)
    if number is not None:
        asyncio.get_running_loop().add_signal_handler(number, supervisor.add, What.SUMMARY)


async def _relay(
    real: str, name: str, fmt: UartFormat, ports: tuple[str, ...], stack: ExitStack, ask: bool
) -> Callable[[Supervisor], Any]:  # fmt: skip
    relay = Relay(real.replace("tcp://", "socket://", 1) if real.startswith("tcp://") else real, name, fmt)
    stack.callback(relay.close)
    server = Server(relay.bench, flow=Flow.NONE)
    stack.callback(server.close)

    async def begin(supervisor: Supervisor) -> None:
        loop, waiting, quiet_until_s = asyncio.get_running_loop(), set[asyncio.Task[None]](), 0.0

        def lost(error: LinkError) -> None:
            nonlocal quiet_until_s
            if loop.time() > quiet_until_s:  # A port in use elsewhere closes each new connection.
                log.warning("%s; it is opened again as soon as it is there", error)
            quiet_until_s = loop.time() + QUIET_S
            supervisor.add(What.AWAY)
            task = loop.create_task(_reopen(relay, supervisor))
            waiting.add(task)
            task.add_done_callback(waiting.discard)

        for url in ports or (ANY_PORT,):
            await server.open(name, parse(url))
        server.start()
        relay.relayed.subscribe(supervisor.passed)
        relay.formats.subscribe(lambda new: supervisor.add(What.FORMAT, str(new).encode()))
        relay.start(server.pacer, lost)
        if ask:
            stack.callback(_ask(relay, product(name), fmt, supervisor).cancel)
        for _, opened in server.ports:
            supervisor.say(f"{name} listening on {opened}")

    return begin


def _ask(relay: Relay, made: Product, fmt: UartFormat, supervisor: Supervisor) -> asyncio.Task[None]:
    """Ask the controller, now and whenever the twin knows nothing of it any more."""
    loop = asyncio.get_running_loop()
    asker = Asker(
        made, lambda data: relay.ask(data, lambda said: asker.received(loop.time(), said)), relay.release,
        supervisor.passed,
    )  # fmt: skip
    if not asker.questions:
        log.warning("--ask has no effect: the table of %s has no query without a parameter, nor a driver", made.model)
    asker.pace(fmt)
    relay.formats.subscribe(asker.pace)
    relay.relayed.subscribe(lambda by_host, data: asker.passed(loop.time(), by_host, data))
    supervisor.anew = lambda: asker.begin(loop.time())
    supervisor.anew()

    async def tick() -> None:
        while True:
            await asyncio.sleep(ASKS_S)
            asker.tick(loop.time())

    return loop.create_task(tick())


async def _reopen(relay: Relay, supervisor: Supervisor) -> None:
    while True:
        await asyncio.sleep(CHECK_S)
        try:
            await relay.reopen()
        except LinkError:
            continue
        supervisor.add(What.BACK)
        return


async def _relay_bus(
    real: str, ports: tuple[str, ...], name: str, stack: ExitStack, ask: bool, supervisor: Supervisor
) -> None:  # fmt: skip
    asker = BoardAsker(questions_of(product(name)), supervisor.passed) if ask else None
    if asker is not None:
        supervisor.anew = asker.begin
    relay = BusRelay(parse(real), supervisor.passed, asker)
    stack.callback(relay.close)
    for text in ports or (ANY_BUS_PORT,):
        url = parse(text)
        if url.scheme != "bus":
            raise UsageError(f"the host of a board is at a bus, not at {url}: expected e.g. bus://127.0.0.1:1812")
        supervisor.say(f"{name} listening on {await relay.open(url)}")


async def _listen(
    lines: tuple[str, str], line: str | None, stack: ExitStack, supervisor: Supervisor
) -> None:  # fmt: skip
    """Receive from two lines; nothing is ever sent."""
    for what, target in zip((What.HOST, What.MACHINE), lines, strict=True):
        end = PortEnd(target, line, partial(supervisor.add, what), partial(_line_lost, supervisor))
        stack.callback(end.close)
        supervisor.say(f"listening at {target}")


def _line_lost(supervisor: Supervisor, error: LinkError) -> None:
    log.warning("%s", error)
    supervisor.add(What.AWAY)
