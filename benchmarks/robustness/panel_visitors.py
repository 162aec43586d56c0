"""Delay of a polling host by visitors of the panel, who load one page after the other.

    python benchmarks/robustness/panel_visitors.py [--seed 1] [--visits 64] [--scene examples/cut-to-length/scene.toml]

Half of the visitors only fetch the page (`GET /`), the others connect as a browser does, answer the frames for a time
chosen by the seed, and leave.  Measured in the serving process, in processor time: the longest computation between two
turns of the event loop, its 99th percentile among those of 1 ms and more, and the delay of the polls, which is the
computing time between two checks of the host's port.  Also checked: the driver, the stored users, the number of stored
pages. Exit code 0 if all limits hold, else 1.
"""

import argparse
import asyncio
import gc
import json
import random
import re
import sys
import threading
import urllib.request
from asyncio.events import Handle
from pathlib import Path
from time import perf_counter, process_time

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "src"))

from nicegui import Client

from axistwin.scenes.scene import Scene
from axistwin.scenes.sessions.session import Session
from axistwin.ui.panel import turns
from axistwin.ui.panel.page import KEPT_PAGES
from axistwin.ui.panel.web import Address, Panel

ROOT = Path(__file__).resolve().parents[2]
POLL_S = 0.005
P99_MS, PAGES_MB = 20.0, 64.0
"""Limits: delay of 99 of 100 polls; memory that visitors leave allocated."""
TURN_MS, SEARCH_MS = 5.0, 50.0
"""Limits: one piece of a page; one garbage collection."""


class Turns:
    """Processor time of each turn of the loop, in ms, of each piece of a page, and of Python's garbage collections.

    The time of a collection is no part of the piece in which it happens to be; it is part of a turn and of a poll.
    """

    def __init__(self) -> None:
        self.ms: list[float] = []
        self.pieces_ms: list[float] = []
        self.collected_ms: list[float] = []
        self._began = 0.0
        gc.callbacks.append(self._collecting)
        run, go_on = Handle._run, turns._Work.go_on

        def timed_run(handle: Handle) -> None:
            began = process_time()
            run(handle)
            self.ms.append((process_time() - began) * 1000)

        def timed_piece(work: turns._Work[object]) -> bool:
            began, collected = process_time(), sum(self.collected_ms)
            over = go_on(work)
            self.pieces_ms.append((process_time() - began) * 1000 - (sum(self.collected_ms) - collected))
            return over

        Handle._run = timed_run  # type: ignore[method-assign]
        turns._Work.go_on = timed_piece  # type: ignore[method-assign]

    def _collecting(self, phase: str, _: object) -> None:
        if phase == "start":
            self._began = process_time()
        else:
            self.collected_ms.append((process_time() - self._began) * 1000)


async def poll(waits_ms: list[float]) -> None:
    """Measure the delay of a check that is due every 5 ms."""
    loop = asyncio.get_running_loop()
    while True:
        due = loop.create_future()
        mark: list[float] = []
        timer = threading.Timer(POLL_S, lambda due=due, mark=mark: _arrive(loop, due, mark))
        timer.start()
        await due
        waits_ms.append((process_time() - mark[0]) * 1000)


def _arrive(loop: asyncio.AbstractEventLoop, due: "asyncio.Future[None]", mark: list[float]) -> None:
    mark.append(process_time())
    loop.call_soon_threadsafe(lambda: due.done() or due.set_result(None))


def fetch(address: str) -> str:
    """Fetch the page with `GET /` only."""
    with urllib.request.urlopen(address, timeout=60) as answer:
        return str(answer.read().decode())


async def look_on(address: str, client: str, seconds: float) -> int:
    """Connect as a browser does; return the number of answered frames."""
    import websockets

    query = f"client_id={client}&document_id=1&tab_id=1&next_message_id=0&implicit_handshake=true&EIO=4"
    url = f"{address.replace('http', 'ws')}_nicegui_ws/socket.io/?{query}&transport=websocket"
    end, frames = perf_counter() + seconds, 0
    async with websockets.connect(url, max_size=None) as socket:
        await socket.recv()
        await socket.send("40")
        while (left := end - perf_counter()) > 0:
            try:
                text = await asyncio.wait_for(socket.recv(), left)
            except TimeoutError:
                break
            assert isinstance(text, str)
            name, data = json.loads(text[2:])[:2] if text.startswith("42") else ("", {})
            if name == "run_javascript" and data.get("request_id"):
                frames += 1
                answer = {"client_id": client, "request_id": data["request_id"], "result": None}
                await socket.send("42" + json.dumps(["javascript_response", answer]))
    return frames


def visitors(address: str, seed: int, visits: int) -> int:
    """Load the page as all visitors; return the number of frames. Runs in a separate process."""
    chance, frames = random.Random(seed), 0
    for number in range(visits):
        client = re.search(r"client_id\W+([\w-]+)", fetch(address))
        assert client is not None
        if number % 2:
            frames += asyncio.run(look_on(address, client[1], chance.uniform(0.5, 1.5)))
    return frames


async def visited(address: str, seed: int, visits: int) -> int:
    """Start the process of the visitors, and return its number of frames."""
    words = [sys.executable, __file__, "--at", address, "--seed", str(seed), "--visits", str(visits)]
    process = await asyncio.create_subprocess_exec(*words, stdout=asyncio.subprocess.PIPE)
    told, _ = await process.communicate()
    return int(told)


def memory_mb() -> float:
    """Return the resident memory of the process."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * 4096 / 1e6


def percentile(values: list[float], part: float) -> float:
    """Return the value below which this share of the measurements lies."""
    return sorted(values)[min(len(values) - 1, int(len(values) * part))] if values else 0.0


async def main(scene: str, seed: int, visits: int) -> bool:
    """Print the measurements; return True if all limits hold."""
    loaded = Scene.load(ROOT / scene)
    session = Session(loaded.build, scene=loaded)
    panel = Panel("visitors", session, Address("127.0.0.1", 0, None))
    address = await panel.open()
    session.run()
    await asyncio.to_thread(fetch, address)
    nobody = panel.people.driver is None
    await visited(address, seed, 2)  # the first visits include work that is done only once
    gc.collect()
    before_mb = memory_mb()
    alone: list[float] = []
    polling = asyncio.create_task(poll(alone))
    await asyncio.sleep(2)
    polling.cancel()
    measured, waits = Turns(), list[float]()
    polling = asyncio.create_task(poll(waits))
    frames = await visited(address, seed, visits)
    polling.cancel()
    left_mb = memory_mb() - before_mb
    kept = sum(len(client.elements) > 50 for client in Client.instances.values())
    await panel.close()
    p99, longest = percentile(waits, 0.99), max(waits)
    longest_search = max(measured.collected_ms, default=0.0)
    print(f"seed {seed}: {visits} visits, {frames} frames, {len(waits)} polls (without visitors p99 "
          f"{percentile(alone, 0.99):.1f} ms); all in ms of processor time")  # fmt: skip
    print(
        f"a poll waits p50 {percentile(waits, 0.5):.2f}, p99 {p99:.1f}, at most {longest:.1f} (goal: p99 < {P99_MS:g})"
    )
    print(f"turns of the loop: p99 {percentile(measured.ms, 0.99):.1f}, longest {max(measured.ms):.1f}")
    pieces = measured.pieces_ms
    print(f"{len(pieces)} pieces of pages: p99 {percentile(pieces, 0.99):.1f}, longest {max(pieces):.1f}"
          f" (goal: p99 < {TURN_MS:g})")  # fmt: skip
    print(f"collections of garbage: {sum(ms > TURN_MS for ms in measured.collected_ms)} of more than {TURN_MS:g},"
          f" longest {longest_search:.1f} (goal: < {SEARCH_MS:g})")  # fmt: skip
    print(f"{left_mb:.0f} MB are left behind (goal < {PAGES_MB:g}); {kept} pages are kept (goal <= {KEPT_PAGES})")
    print(f"who fetches a page {'does not drive' if nobody else 'DRIVES'}")
    quick = p99 < P99_MS and percentile(pieces, 0.99) < TURN_MS and longest_search < SEARCH_MS
    good = nobody and quick and left_mb < PAGES_MB and kept <= KEPT_PAGES
    print("held" if good else "BROKEN")
    return good


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--visits", type=int, default=64)
    parser.add_argument("--scene", default="examples/cut-to-length/scene.toml")
    parser.add_argument("--at", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.at:
        print(visitors(given.at, given.seed, given.visits))
        sys.exit()
    sys.exit(0 if asyncio.run(main(given.scene, given.seed, given.visits)) else 1)
