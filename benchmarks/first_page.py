"""Wall time of the first page of the panel in Chromium, with three controllers and an oscilloscope.

`axistwin serve SCENE --panel` runs in a process of its own, at real time.  A new Chromium opens the page: the first
visit after the start of the server, with an empty cache of the browser; then again, with a full one.  The time is the
browser's own, from the request until the page is complete; the page is looked at every 10 ms.  The last figure is the
processor time of the server in this time, for a computer with other work; it needs Linux.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tempfile
import time
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

GOAL_S = 0.8
RUNS = 5
PROGRAMS = map(shutil.which, ("chromium", "chromium-headless-shell"))
CHROMIUM = next(filter(None, PROGRAMS), None) if find_spec("playwright") else None
FLAGS = (
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync",
)  # fmt: skip
SIZE = {"width": 1280, "height": 1000}
SCENE = "\n".join(f'[[controller]]\nmodel = "{model}"\n' for model in ("if1", "1811", "smartmotor"))
SERVE = "import sys; from axistwin.cli.program import main; main(sys.argv[1:])"
SHOWN = """() => !document.documentElement.classList.contains("building")
    && document.querySelector(".scope-plot canvas") && performance.now()"""
"""JavaScript: the milliseconds since the request if the page is complete."""
POLL_MS, PATIENCE_MS = 10, 30_000


def main() -> None:
    """Print the times, each the least of some runs."""
    if CHROMIUM is None:
        print("first page in Chromium: not measured, because Chromium or playwright is not installed")
        return
    from playwright.sync_api import sync_playwright

    with tempfile.TemporaryDirectory() as folder, sync_playwright() as play:
        scene = Path(folder) / "scene.toml"
        scene.write_text(SCENE)
        runs = []
        for _ in range(RUNS):
            browser = play.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
            runs.append(visits(scene, browser))
            browser.close()
    start, first, worked, again = (min(run[k] for run in runs) for k in range(4))
    print(f"first page in Chromium: {first:.2f} s (goal <= {GOAL_S:g} s)")
    print(f"  {again:.2f} s at the second visit; the server had needed {start:.2f} s to start")
    print(f"  by processor time of the server: {worked:.2f} s")


def visits(scene: Path, browser: Browser) -> tuple[float, float, float, float]:
    """Return the times in seconds: start of the server, first page, the server's processor time, second page."""
    began = time.perf_counter()
    command = [sys.executable, "-c", SERVE, "serve", str(scene), "--panel", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        assert server.stdout is not None
        address = re.search(r"http\S+", server.stdout.readline())
        assert address is not None
        start_s = time.perf_counter() - began
        clock = ~server.pid << 3 | 2  # the number of the process's clock in Linux
        before_s = time.clock_gettime(clock)
        page = browser.new_context(viewport=SIZE).new_page()
        first_s = shown(page, address[0])
        worked_s = time.clock_gettime(clock) - before_s
        again_s = shown(page, address[0])
        server.terminate()
    return start_s, first_s, worked_s, again_s


def shown(page: Page, address: str) -> float:
    """Open the page, and return the time in seconds until it is complete."""
    page.goto(address, wait_until="commit")
    milliseconds: float = page.wait_for_function(SHOWN, polling=POLL_MS, timeout=PATIENCE_MS).json_value()
    return milliseconds / 1000


if __name__ == "__main__":
    main()
