"""`axistwin stand-in`: a legacy host drives real motors through a motion board."""

import asyncio
import gc
import sys
import threading
from collections.abc import Callable, Coroutine, Iterator, Sequence
from contextlib import contextmanager, suppress
from importlib import import_module
from pathlib import Path
from time import monotonic
from typing import Any

import click
import serial

from axistwin.bench import Bench
from axistwin.cli.serving import bench_and_ports as served
from axistwin.cli.serving.ending import ending
from axistwin.cli.serving.preparing import preparing
from axistwin.core.errors import UsageError
from axistwin.links.server import Server
from axistwin.real.standin import reading
from axistwin.real.standin.driver import Driver
from axistwin.real.standin.events import Event, Failed
from axistwin.real.standin.hal.board import HalBoard
from axistwin.real.standin.hal.sender import HalSender
from axistwin.real.standin.hal.wiring import HalWiring
from axistwin.real.standin.journal import Journal, last_positions
from axistwin.real.standin.klipper import KlipperBoard
from axistwin.real.standin.output import Output
from axistwin.real.standin.real_time import real_time_priority
from axistwin.real.standin.sender import Sender, open_port
from axistwin.real.standin.stop_page import StopPage
from axistwin.real.standin.writer import Writer
from axistwin.scenes.diagnostics.refused_lines import RefusedLines, prepare
from axistwin.scenes.scene import Scene

POLL_S = 0.02  # Interval in seconds at which the end of a preparation is checked.
LEAST_COLLECT_S, COLLECTS = 0.01, 10
"""Shortest interval in seconds between two transfers of pulses to the boards, and number of transfers in a horizon."""
WARNING = "axistwin is not a safety controller: wire the emergency stop and the limit chain to the drives' enable."


@click.command("stand-in", context_settings={"help_option_names": ["-h", "--help"]})
@click.argument("scene", metavar="SCENE.toml")
@click.option("--board", metavar="DEV", help="Serial port of the only board, instead of the scene's.")
@click.option("--dry-run", is_flag=True, help="Print every pin and check the scene; open no port, move nothing.")
@click.option("--panel", metavar="[H:]P", help="Serve a page with the state of the motors and a stop at this port.")
@click.option("--quiet", is_flag=True, help="Do not tell lines that a controller refuses.")
@click.option("--unhomed", is_flag=True, help="Start although the last position is unknown: home the machine first.")
def stand_in(scene: str, board: str | None, panel: str | None, dry_run: bool, unhomed: bool, quiet: bool) -> int:
    """Replace a defective controller by an emulated controller, which drives the real motors.

    The host of the defective controller connects to the emulated controller.

    The scene's table [stand-in] maps axes, inputs and outputs to the pins of a board with Klipper's micro-controller
    firmware, or to LinuxCNC HAL.  All pin events happen later by a constant delay, the horizon.  While the motors are
    live, type `stop` or Enter to stop them, and `go` to continue after a stop.

    The journal of each run contains the positions of the motors.  After a run that did not end properly, the next run
    does not start without --unhomed; home the machine then.

    \b
    axistwin stand-in table.toml --dry-run
    axistwin stand-in table.toml
    axistwin stand-in table.toml --board /dev/ttyACM0
    axistwin stand-in table.toml --panel 8080             then open http://127.0.0.1:8080/
    """
    loaded = Scene.load(Path(scene))
    bench = loaded.build(served=True)
    plan = reading.read(loaded, bench, board)
    if dry_run:
        for line in reading.lines(plan):
            click.echo(line)
        return 0
    click.echo(WARNING, err=True)
    known = last_positions(plan.journal, plan.axes)
    if known is None and not unhomed:
        raise UsageError(
            f"the motor positions are unknown: {plan.journal} does not end in the positions of a completed run; "
            "start with --unhomed, then home the machine"
        )
    ports = served.scene(scene, [], alone=False).ports(bench)
    with preparing(bench, 1.0) as prepared:
        return asyncio.run(_Run(bench, plan, known, panel, quiet=quiet).serve(ports, prepared))


class _Run:
    def __init__(
        self, bench: Bench, plan: reading.Plan, positions: dict[str, int] | None, panel: str | None, *, quiet: bool
    ) -> None:
        """Prepare a run of `axistwin stand-in`.

        `positions`: positions of the motors at the end of the last run; None if the positions are unknown.
        `panel`: address of the page that shows the state and has a stop button.  `quiet`: refused lines are not told.
        """
        self.bench, self.plan, self._at_start, self._panel = bench, plan, positions, panel
        self._senders: list[Output] = []
        self._positions: dict[str, int] = {}
        self._changed = asyncio.Event()
        self._ending = self._proper_end = False
        self._terminal = Writer("terminal", _echo)
        self._refused, self._quiet = RefusedLines(self._tell), quiet

    async def serve(self, ports: served.Ports, prepared: threading.Event) -> int:
        lines = [open_port(table.port, table.baud) if table.port is not None else None for table, _ in self.plan.boards]
        journal = Journal(self.plan.journal, ", ".join(self.plan.axes), self._tell)
        self._connect(lines, journal.note)
        try:
            with self._page(), self._real_time():
                code = await self._drive(ports, prepared)
        finally:
            written = self._close(journal)
        return code if written else 1

    def _connect(self, lines: Sequence[serial.Serial | None], note: Callable[[str], None]) -> None:
        """Connect the bench to the boards.  `lines`: the port of each board; None for LinuxCNC HAL."""
        loop = asyncio.get_running_loop()

        def deliver(sender: Output, event: Event) -> None:
            loop.call_soon_threadsafe(self._handle, sender, event)

        options = self.plan.horizon_s, note, self._at_start
        senders = self._senders
        for line, (_, wiring) in zip(lines, self.plan.boards, strict=True):
            if isinstance(wiring, HalWiring):
                senders.append(HalSender(HalBoard(wiring, *options), deliver))
            elif line is not None:
                senders.append(Sender(KlipperBoard(wiring, *options), line, deliver))
        self._driver, self._server = Driver(self.bench, senders, self._tell), Server(self.bench)
        for sender in senders:
            if isinstance(sender, HalSender):
                self._driver.collected.subscribe(sender.complete)

    @contextmanager
    def _page(self) -> Iterator[None]:
        page = None if self._panel is None else StopPage(self._panel, self._state, self._stop_from_page)
        try:
            if page is not None:
                click.echo(f"panel on {page.url}")
            yield
        finally:
            if page is not None:
                page.close()

    def _close(self, journal: Journal) -> bool:
        self._ending, written = True, True
        self._server.close()
        for sender in self._senders:
            sender.close()
        # If no motor has moved, the positions at the end are those at the start.
        positions = self._driver.positions if self._proper_end else None if self._driver.live else self._at_start
        if positions is not None and not journal.end(positions):
            self._tell(f"the positions cannot be written to {journal.path}: the next start needs --unhomed")
            written = False
        journal.close()
        for controller in self.bench.controllers.values():
            controller.power(False)
        self._refused.close()
        self._terminal.close()
        return written

    @contextmanager
    def _real_time(self) -> Iterator[None]:
        """Run with real-time priority, except for LinuxCNC, whose processes must not inherit the priority."""
        if any(isinstance(sender, HalSender) for sender in self._senders):
            yield
            return
        with real_time_priority() as granted:
            if not granted:
                self._tell("no permission for real-time priority: a busy computer may stop the motors (docs: Time)")
            yield

    async def _drive(self, ports: served.Ports, prepared: threading.Event) -> int:
        ended = self._ended = ending()
        for sender in self._senders:
            sender.start()
        while not ((self._driver.all_ready and prepared.is_set()) or self._driver.failed):
            await self._change_or(asyncio.sleep(POLL_S))
            if ended.done():
                return await ended
        if self._driver.failed:
            return 1
        # Import before the motors start, because an import during a move could delay step pulses.
        import_module("numpy")
        self._watch_refused()
        gc.collect()
        gc.freeze()  # Shorten garbage collections, because a long garbage collection delays step pulses.
        for name, url in ports:
            click.echo(f"{name} listening on {await self._server.open(name, url)}")
        self._server.start()
        self._driver.begin(monotonic())
        self._terminal.put(f"LIVE: {', '.join(self._driver.axes)}; `stop` or Enter stops, `go` goes on")
        self._collect()
        _read_words(self._said)
        try:
            return await ended
        finally:
            await self._end()

    def _watch_refused(self) -> None:
        if not self._quiet:
            prepare(self.bench)
            self._refused.watch(self.bench)

    def _state(self) -> dict[str, Any]:
        """Return the values of the page.  Called in any thread: reads only what other threads replace as a whole."""
        stopped = frozenset().union(*(sender.stopped for sender in self._senders))
        live = [axis for axis in self._driver.axes if axis.rpartition(".")[0] not in stopped]
        if not self._driver.live:
            return {"state": "Connecting to the boards", "live": False, "reason": "", "positions": {}}
        state = f"LIVE: {', '.join(live)}" if live else "STOPPED"
        reasons = ", ".join(dict.fromkeys(tuple(self._driver.stopped.values())))
        return {"state": state, "live": bool(live), "reason": reasons, "positions": self._positions}

    def _stop_from_page(self) -> None:
        """Stop all motors.  Called in any thread."""
        for sender in self._senders:
            sender.stop("stopped from the page")

    async def _end(self) -> None:
        if not self._driver.failed:
            self._driver.stop("end of the run")
            for _ in range(50):
                if self._driver.still:
                    break
                await self._change_or(asyncio.sleep(POLL_S))
            self._proper_end = self._driver.still and not self._driver.failed
        self._ending = True
        for sender in self._senders:
            sender.shut_down()
        await asyncio.sleep(0.05)

    async def _change_or(self, other: asyncio.Future[int] | Coroutine[None, None, None]) -> None:
        self._changed.clear()
        waiting = {asyncio.ensure_future(self._changed.wait()), asyncio.ensure_future(other)}
        _, pending = await asyncio.wait(waiting, return_when=asyncio.FIRST_COMPLETED)
        for each in pending:
            if each is not other:
                each.cancel()

    def _handle(self, sender: Output, event: Event) -> None:
        if self._ending:
            return
        self._server.pacer.sync()
        self._driver.handle(sender, event)
        self._server.pacer.work()
        self._changed.set()
        if isinstance(event, Failed) and event.gone and not self._ended.done():
            self._ended.set_result(1)

    def _collect(self) -> None:
        self._server.pacer.inspect(self._driver.collect)
        self._positions = self._driver.commanded
        asyncio.get_running_loop().call_later(max(LEAST_COLLECT_S, self.plan.horizon_s / COLLECTS), self._collect)

    def _said(self, word: str) -> None:
        """Execute a command that the user has typed: `go` continues, any other text stops the motors."""
        if word == "go":
            self._driver.go_on(monotonic())
            self._tell("going on")
        else:
            self._driver.stop("stopped by hand")

    def _tell(self, line: str) -> None:
        self._terminal.put(f"axistwin: {line}")


def _echo(text: str) -> None:
    with suppress(OSError):  # A closed terminal must not end the run.
        click.echo(text, nl=False, err=True)


def _read_words(said: Callable[[str], None]) -> None:
    loop = asyncio.get_running_loop()

    def read() -> None:
        line = sys.stdin.readline()
        if line:
            said(line.strip())
        else:
            loop.remove_reader(sys.stdin)

    if sys.stdin is not None and not sys.stdin.closed:
        try:
            loop.add_reader(sys.stdin, read)
        except (OSError, ValueError):
            # Ignore stdin if stdin is a file, because asyncio cannot wait for input from a file.
            return
