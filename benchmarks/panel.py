"""Computing time of a user of the panel: a moving controller of each family, and an oscilloscope with 8 signals.

Processor time of the server: of a page until the browser has all views, of the longest piece in which no other task
of the event loop runs, and of a frame that updates all views.

At real time: the number of late blocks of the pacer, with a bare websocket client that answers each frame at once, and
with Debian's Chromium if it is installed; headless, it draws on the same processors.  At full speed: the remaining
share of the speed while that client is connected.
"""

import asyncio
import contextlib
import re
import subprocess
import sys
import urllib.request
from collections.abc import AsyncIterator, Iterator
from pathlib import Path
from time import perf_counter, process_time

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "src"))
sys.path.insert(0, str(Path(__file__).resolve().parent))

import tracing
from first_page import CHROMIUM, FLAGS, SIZE

from axistwin import Bench
from axistwin.bench import Controller
from axistwin.core.units import MS
from axistwin.scenes.sessions.session import Session
from axistwin.sim.clock import Procedure
from axistwin.ui.panel import page
from axistwin.ui.panel.views import scope
from axistwin.ui.panel.web import Address, Panel

SIGNALS = (
    "if1.X.pulses", "if1.X.velocity", "if1.output1", "if1.host_says", "1811.motor.pulses", "1811.motor.velocity",
    "motor.shaft.position", "motor.shaft.commanded",
)  # fmt: skip
PACED_S, FAST_S, RUNS = 15.0, 3.0, 3
GOAL_LATE, GOAL_SPEED = 0.01, 0.5
FRAMES = 100
GOAL_PAGE_MS, GOAL_WAIT_MS, GOAL_FRAME_MS = 800.0, 50.0, 2.0


def main() -> None:
    """Print the ratios."""
    tracing.run(None, "default")  # the kernels are compiled before the measurement
    asyncio.run(_measured())


async def _measured() -> None:
    await _first_page()
    scope.first_choice = lambda _: list(SIGNALS)
    late, blocks, _ = await _paced(at_work(asked=True), None)
    print(f"real time, nobody looks: {late / blocks:.2%} of {blocks} blocks late")
    for chromium in dict.fromkeys(("", CHROMIUM or "")):
        await _look_in_real_time(chromium)
    for asked, what in ((True, "a host asks ten times a second"), (False, "nobody asks")):
        await _look_at_full_speed(asked, what)


async def _first_page() -> None:
    """Print the processor time of a page, of its longest piece, and of a frame; each the least of several."""
    pages, waits, frames = zip(*[await _page() for _ in range(RUNS)], strict=True)
    page_ms, wait_ms, frame_ms = (1e3 * min(found) for found in (pages, waits, frames))
    print(f"first page of three controllers: {page_ms:.0f} ms of processor time (goal < {GOAL_PAGE_MS:g}); ", end="")
    print(f"longest wait of a request: {wait_ms:.1f} ms (goal < {GOAL_WAIT_MS:g}); ", end="")
    print(f"frame of all views: {frame_ms:.2f} ms (goal < {GOAL_FRAME_MS:g})")


async def _page() -> tuple[float, float, float]:
    """Return the processor times of a page, of its longest piece, and of one frame, in seconds."""
    session = at_work(asked=False)
    session.speed = 1.0
    web = Panel("benchmark", session, Address("127.0.0.1", 0, None))
    address, begun, made = await web.open(), process_time(), []
    with _longest_piece() as longest, _frames(made), looking(address, ""):
        while not made:
            await asyncio.sleep(0.01)
    page_s = process_time() - begun
    session.run()
    frame_s = await _frame(session, made[0])
    session.pause()
    await web.close()
    return page_s, max(longest), frame_s


@contextlib.contextmanager
def _longest_piece() -> Iterator[list[float]]:
    """Collect the processor time of each callback of the event loop."""
    found, run = [0.0], asyncio.Handle._run

    def timed(handle: asyncio.Handle) -> None:
        began = process_time()
        run(handle)
        found.append(process_time() - began)

    asyncio.Handle._run = timed  # type: ignore[method-assign]
    try:
        yield found
    finally:
        asyncio.Handle._run = run  # type: ignore[method-assign]


@contextlib.contextmanager
def _frames(made: list[page._Frames]) -> Iterator[None]:
    """Add the frames of the first complete page to `made`."""
    show = page._Frames.show

    async def added(frames: page._Frames) -> None:
        made.append(frames)
        await show(frames)

    page._Frames.show = added  # type: ignore[method-assign]
    try:
        yield
    finally:
        page._Frames.show = show  # type: ignore[method-assign]


async def _frame(session: Session, frames: page._Frames) -> float:
    """Return the mean processor time of a frame that updates all views, without that of the bench, in seconds."""
    spent = 0.0
    for _ in range(FRAMES):
        await asyncio.sleep(page.FRAME_S)
        session.inspect(lambda: None)
        began = process_time()
        with frames._client:
            for view in frames._made:
                view()
        spent += process_time() - began
    return spent / FRAMES


async def _look_in_real_time(chromium: str) -> None:
    session = at_work(asked=True)
    async with shown(session, chromium) as looks:
        late, blocks, frames = await _paced(session, looks)
    who = "Chromium" if chromium else "a bare websocket client"
    print(f"real time, {who} looks at {len(SIGNALS)} signals, {frames:.1f} frames/s: ", end="")
    print(f"{late / blocks:.2%} of {blocks} blocks late (goal < {GOAL_LATE:.0%})")


async def _look_at_full_speed(asked: bool, what: str) -> None:
    alone, session = at_work(asked), at_work(asked)
    speeds = [await _speed(alone) for _ in range(RUNS)]
    async with shown(session, ""):
        looked_at = [await _speed(session) for _ in range(RUNS)]
    ratio = max(looked_at) / max(speeds)
    print(f"as fast as it goes, {what}, {max(speeds):,.0f} times real time: ", end="")
    print(f"{ratio:.2f} of the speed while somebody looks (goal >= {GOAL_SPEED:g})")


@contextlib.asynccontextmanager
async def shown(session: Session, chromium: str) -> AsyncIterator[scope.Scopes]:
    """Connect a user while the block of the `with` statement runs."""
    web = Panel("benchmark", session, Address("127.0.0.1", 0, None))
    with looking(await web.open(), chromium):
        looks = web.common(scope.Scopes)
        await _until_seen(looks)
        yield looks
    await web.close()


def at_work(asked: bool) -> Session:
    """Return a bench with a moving controller of each family and, on request, a host that polls ten times a second."""

    def build() -> Bench:
        bench, hosts = tracing.at_work()
        if asked:
            bench.clock.process(_asking(bench, hosts))
        return bench

    return Session(build)


def _asking(bench: Bench, hosts: list[Controller]) -> Procedure:
    if1, board, motor = hosts
    while True:
        if1.serial.write(b"E\r")
        tracing.command(board, "83")
        motor.serial.write(b"RP ")
        yield bench.clock.timeout(98 * MS)
        if1.serial.read(), motor.serial.read()
        while board.bus.read(1) & 8:
            for _ in range(16):
                board.bus.read(0)
            board.bus.write(1, 0x80)
            yield bench.clock.timeout(2 * MS)


@contextlib.contextmanager
def looking(address: str, chromium: str) -> Iterator[None]:
    """Connect a user in a separate process."""
    with subprocess.Popen([sys.executable, __file__, address, chromium]) as process:
        try:
            yield
        finally:
            process.terminate()


def look(address: str, chromium: str) -> None:
    """Receive frames until the process ends."""
    if not chromium:
        asyncio.run(_answer_frames(address))
        return
    from playwright.sync_api import sync_playwright

    with sync_playwright() as play:
        page = play.chromium.launch(executable_path=chromium, args=FLAGS).new_page(viewport=SIZE)
        page.goto(address)
        page.locator("[data-test=scope-plot]").scroll_into_view_if_needed()
        page.wait_for_timeout(1e9)


async def _answer_frames(address: str) -> None:
    """Answer each frame at once, like a browser that draws in no time."""
    import socketio

    with urllib.request.urlopen(address) as answer:
        found = re.search(r"client_id\W+([\w-]+)", answer.read().decode())
    assert found is not None
    who = found[1]
    client = socketio.AsyncClient()

    @client.on("run_javascript")
    async def run(message: dict[str, str]) -> None:
        if message.get("request_id"):
            answer = {"client_id": who, "request_id": message["request_id"], "result": None}
            await client.emit("javascript_response", answer)

    query = f"client_id={who}&document_id=1&tab_id=1&next_message_id=0&implicit_handshake=true"
    await client.connect(f"{address}?{query}", socketio_path="/_nicegui_ws/socket.io", transports=["websocket"])
    await client.wait()


async def _speed(session: Session) -> float:
    """Return virtual seconds per second of the wall clock."""
    session.speed = None
    session.run()
    before_s, began = session.seconds, perf_counter()
    await asyncio.sleep(FAST_S)
    took = perf_counter() - began
    session.pause()
    return (session.seconds - before_s) / took


async def _paced(session: Session, looks: scope.Scopes | None) -> tuple[int, int, float]:
    """Return the numbers of late blocks and of all blocks, and frames per second."""
    session.speed = 1.0
    session.run()
    await asyncio.sleep(3.0)
    late, blocks, drawn = session.pacer.delays.overruns, session.pacer.delays.blocks, looks.drawn if looks else 0
    await asyncio.sleep(PACED_S)
    session.pause()
    frames = looks.drawn - drawn if looks else 0
    return session.pacer.delays.overruns - late, session.pacer.delays.blocks - blocks, frames / PACED_S


async def _until_seen(looks: scope.Scopes) -> None:
    while not looks.drawn:
        await asyncio.sleep(0.05)
    await asyncio.sleep(2.0)


if __name__ == "__main__":
    if len(sys.argv) == 3:
        look(*sys.argv[1:])
    else:
        main()
