"""Play all recorded conversations here and in Pyodide under node, and compare bytes, times, levels and positions.

    python benchmarks/playground.py --engine build/engine

`make engine` makes the folder.  The verdict is printed; the exit code is 1 if a conversation differs.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from axistwin.playground import build

ROOT = Path(__file__).parents[1]
CONVERSATIONS = ROOT / "tests" / "conversations"

PLAY = '''
import hashlib, json
from pathlib import Path
from axistwin.bench import Bench
from axistwin.bench.options import read_options
from axistwin.conversations import load, play
from axistwin.programs.running import options

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

def results(folder):
    files = sorted(Path(folder).glob("*.talk"))
    return json.dumps({file.name: result(file) for file in files if not load(file).headers["model"].endswith(".toml")})
'''

NODE = """
import fs from "node:fs";
const engine = new URL("./engine/", import.meta.url).pathname;
const { loadPyodide } = await import(engine + "pyodide.mjs");
const python = await loadPyodide({ indexURL: engine });
const contents = JSON.parse(fs.readFileSync("contents.json", "utf8"));
await python.loadPackage("file://" + engine + contents.core, { checkIntegrity: false, messageCallback: () => {} });
for (const name of ["libraries.zip", contents.wheel])
  python.unpackArchive(new Uint8Array(fs.readFileSync(engine + name)).buffer, "zip", { extractDir: "/libraries" });
python.FS.mkdirTree("/conversations");
for (const name of fs.readdirSync(process.argv[2]))
  if (/[.](talk|toml|sms|if1)$/.test(name))
    python.FS.writeFile("/conversations/" + name, fs.readFileSync(process.argv[2] + "/" + name));
python.runPython('import sys; sys.path.insert(0, "/libraries")');
console.log(python.runPython(fs.readFileSync("play.py", "utf8") + '\\nresults("/conversations")'));
"""


def main() -> int:
    """Print a line for each difference, and the verdict."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--engine", type=Path, required=True, help="folder made by `make engine`")
    engine = parser.parse_args().engine
    os.environ["AXISTWIN_JIT"] = "off"  # as in the browser
    space: dict[str, object] = {}
    begin = time.perf_counter()
    exec(PLAY, space)
    here = json.loads(space["results"](CONVERSATIONS))  # type: ignore[operator]
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
    there = json.loads(done.stdout)
    different = [name for name in here if here[name] != there.get(name)]
    for name in different:
        print(f"{name}: {here[name]} here, {there.get(name)} in Pyodide")
    verdict = "bad" if different or len(here) < 50 else "good"
    items = sum(count for _, count, _ in here.values())
    print(f"{len(here)} conversations, {items} data, levels and positions: {len(different)} differ")
    print(f"{here_s:.1f} s here, {there_s:.1f} s in Pyodide with its start: verdict {verdict}")
    return verdict == "bad"


if __name__ == "__main__":
    sys.exit(main())
