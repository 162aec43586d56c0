"""Run all recorded conversations and all examples here and in Pyodide under node, and compare the results.

Compared are bytes, levels and positions with their times; of examples also the drawings.  The speed of a moving
SmartMotor in Pyodide is printed.

    python benchmarks/playground.py --engine build/engine
    python benchmarks/playground.py --engine build/engine --start

`make engine` makes the folder.  The verdict is printed; the exit code is 1 if a result differs, or if the SmartMotor is
too slow.  `--start` measures the cold start of the page in Chromium instead, with and without the snapshot and the
compiled modules, in turns.
"""

import argparse
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread

from axistwin.ui.playground.building import PREPARED, SNAPSHOT, build

ROOT = Path(__file__).parents[1]
LEAST_SPEED = 4
STARTS, MOST_OF_START = 3, 0.8  # Number of cold starts of each kind, and the goal for their ratio.
CHROMIUM = shutil.which("chromium-headless-shell") or shutil.which("chromium")
CONVERSATIONS = ROOT / "tests" / "conversations"

PLAY = '''
import hashlib, json, tempfile, time
from pathlib import Path
from axistwin.bench import Bench
from axistwin.bench.options import read_options
from axistwin.bench.talk.conversation import load
from axistwin.bench.talk.player import play
from axistwin.ui.playground.playground import Playground
from axistwin.bench.programs.running import options

def result(file):
    """Return the difference from the recording, and a hash of all data, levels and positions with their times."""
    conversation = load(file)
    bench, seen = Bench(), []
    bench.add(conversation.headers["model"], **read_options(options(conversation)))
    for name, controller in bench.controllers.items():
        for pin_name, pin in controller.pins.items():
            pin.subscribe(lambda level, pin_name=pin_name: seen.append((bench.now, pin_name, bool(level))))
        if name in bench.ports:
            bench.port(name).subscribe_received(lambda byte, errors: seen.append((bench.now, byte, repr(errors))))
    difference = play(conversation, bench)
    for name, controller in bench.controllers.items():
        for axis_name, axis in controller.axes.items():
            seen.append((bench.now, axis_name, axis.position))
    return [str(difference), len(seen), hashlib.sha256(repr(seen).encode()).hexdigest()]

def example(name):
    """Return a hash of the states of an example in its first 20 seconds, one state a second."""
    playground, seen = Playground(Path(tempfile.mkdtemp())), []
    seen.append(playground.open_example(name))
    for second in range(1, 21):
        seen.append(playground.advance(second * 10**9, 1e9))
    return ["None", 20, hashlib.sha256(json.dumps(seen).encode()).hexdigest()]

def speed():
    """Return how much faster than real time a moving SmartMotor runs."""
    playground = Playground(Path(tempfile.mkdtemp()))
    playground.open_model("smartmotor")
    playground.advance(10**9, 1e9)
    for line in ("UCI UDI ZS", "A=100 V=32212 MV G"):
        playground.send("smartmotor", line)
    playground.advance(3 * 10**9, 1e9)
    begin = time.perf_counter()
    state = playground.advance(63 * 10**9, 1e9)
    assert state["controllers"]["smartmotor"]["axes"]["shaft"]["moving"]
    return 60 / (time.perf_counter() - begin)

def results(folder):
    files = sorted(Path(folder).glob("*.talk"))
    found = {file.name: result(file) for file in files if not load(file).headers["model"].endswith(".toml")}
    names = [one["name"] for one in Playground(Path(tempfile.mkdtemp())).choices()["examples"]]
    return json.dumps({"speed": speed(), "results": found | {name: example(name) for name in names}})
'''

NODE = """
import fs from "node:fs";
const engine = new URL("./engine/", import.meta.url).pathname;
import zlib from "node:zlib";
const { loadPyodide } = await import(engine + "pyodide.mjs");
const contents = JSON.parse(fs.readFileSync("contents.json", "utf8"));
const snapshot = contents.snapshot && zlib.gunzipSync(fs.readFileSync(engine + contents.snapshot));
const python = await loadPyodide({ indexURL: engine, ...(snapshot && { _loadSnapshot: snapshot }) });
await python.loadPackage("file://" + engine + contents.core, { checkIntegrity: false, messageCallback: () => {} });
for (const name of contents.archives)
  python.unpackArchive(new Uint8Array(fs.readFileSync(engine + name)).buffer, "zip", { extractDir: "/libraries" });
python.FS.mkdirTree("/conversations");
for (const name of fs.readdirSync(process.argv[2]))
  if (/[.](talk|toml|sms|if1)$/.test(name))
    python.FS.writeFile("/conversations/" + name, fs.readFileSync(process.argv[2] + "/" + name));
python.runPython('import sys; sys.path.insert(0, "/libraries")');
console.log(python.runPython(fs.readFileSync("play.py", "utf8") + '\\nresults("/conversations")'));
"""


class Files(SimpleHTTPRequestHandler):
    """Serves a folder, and prints nothing."""

    def log_message(self, *_: object) -> None:
        """Print nothing."""


def measure_start(engine: Path) -> int:
    """Print the median times from an empty browser to a page that can be used, and their ratio."""
    from playwright.sync_api import sync_playwright

    times: dict[str, list[float]] = {"plain": [], "prepared": []}
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as tool:
        plain = Path(folder, "engine")
        shutil.copytree(engine, plain, ignore=shutil.ignore_patterns(SNAPSHOT, PREPARED))
        for name, source in (("plain", plain), ("prepared", engine)):
            build(Path(folder, name), source)
        server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Files, directory=folder))
        Thread(target=server.serve_forever, daemon=True).start()
        for _ in range(STARTS):
            for name, found in times.items():
                browser = tool.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
                page, begin = browser.new_page(), time.perf_counter()
                page.goto(f"http://127.0.0.1:{server.server_port}/{name}/")
                page.wait_for_selector("html[data-state=ready]", timeout=120_000)
                found.append(time.perf_counter() - begin)
                browser.close()
        server.shutdown()
    plain_s, prepared_s = (statistics.median(found) for found in times.values())
    print(f"load {os.getloadavg()[0]:.1f}: {plain_s:.1f} s plain, {prepared_s:.1f} s prepared (goal if quiet <= 6)")
    verdict = "good" if prepared_s / plain_s <= MOST_OF_START else "bad"
    print(f"ratio {prepared_s / plain_s:.2f} (goal <= {MOST_OF_START}): verdict {verdict}")
    return verdict == "bad"


def main() -> int:
    """Print a line for each difference, and the verdict."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--engine", type=Path, required=True, help="folder made by `make engine`")
    parser.add_argument("--start", action="store_true", help="measure the cold start of the page in Chromium")
    given = parser.parse_args()
    engine = given.engine
    if given.start:
        return measure_start(engine)
    os.environ["AXISTWIN_JIT"] = "off"  # as in the browser
    space: dict[str, object] = {}
    begin = time.perf_counter()
    exec(PLAY, space)
    here = json.loads(space["results"](CONVERSATIONS))["results"]  # type: ignore[operator]
    here_s = time.perf_counter() - begin
    with tempfile.TemporaryDirectory() as folder:
        build(Path(folder), engine)
        Path(folder, "play.py").write_text(PLAY, encoding="utf-8")
        Path(folder, "play.mjs").write_text(NODE, encoding="utf-8")
        begin = time.perf_counter()
        command = ["node", "play.mjs", str(CONVERSATIONS)]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=600)
        there_s = time.perf_counter() - begin
    if done.returncode:
        print(done.stderr[-3000:], file=sys.stderr)
        return 1
    found = json.loads(done.stdout)
    there, speed = found["results"], found["speed"]
    different = [name for name in here if here[name] != there.get(name)]
    for name in different:
        print(f"{name}: {here[name]} here, {there.get(name)} in Pyodide")
    verdict = "bad" if different or len(here) < 50 or speed < LEAST_SPEED else "good"
    items = sum(count for _, count, _ in here.values())
    print(f"{len(here)} conversations and examples, {items} data, levels and positions: {len(different)} differ")
    print(f"a moving SmartMotor in Pyodide: {speed:.0f} times real (goal >= {LEAST_SPEED})")
    print(f"{here_s:.1f} s here, {there_s:.1f} s in Pyodide with its start: verdict {verdict}")
    return verdict == "bad"


if __name__ == "__main__":
    sys.exit(main())
