// Compiles axistwin and its libraries, and takes a snapshot of a Python that has begun; runs in node.
//
//     node prepare.mjs ENGINE WHEEL CORE
//
// Writes ENGINE/compiled.zip, ENGINE/core.zip and ENGINE/snapshot.gz, from ENGINE/libraries.zip and the two wheels.

import fs from "node:fs";
import path from "node:path";
import { pathToFileURL } from "node:url";
import zlib from "node:zlib";

const [engine, wheel, core] = [path.resolve(process.argv[2]) + "/", process.argv[3], process.argv[4]];
const { loadPyodide } = await import(pathToFileURL(engine + "pyodide.mjs").href);

const COMPILE = `
import compileall, shutil, zipfile
from pathlib import Path

def pack(root, target):
    compileall.compile_dir(root, quiet=2, maxlevels=20, legacy=True)
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in sorted(root.rglob("*")):
            if path.is_file() and path.suffix != ".py" and "__pycache__" not in path.parts:
                name = zipfile.ZipInfo(path.relative_to(root).as_posix(), (2020, 1, 1, 0, 0, 0))
                archive.writestr(name, path.read_bytes(), zipfile.ZIP_DEFLATED)

root = Path("/libraries")
for name in ("cli", "docs", "drivers", "real", "sweeps", "testing", "ui/editor", "ui/panel", "ui/terminal"):
    shutil.rmtree(root / "axistwin" / name, ignore_errors=True)
for name in ("pydantic/v1", *(path.name + "/sboms" for path in root.glob("filelock*.dist-info"))):
    shutil.rmtree(root / name, ignore_errors=True)
pack(root, "/compiled.zip")
pack(Path("/core"), "/core.zip")
`;

// The modules of Python's own library that the first page imports.  A snapshot restores the memory that Pyodide begins
// with, so that it has no room for more, nor can it contain machine code such as pydantic-core.
const START = `
import sys
before = set(sys.modules)
sys.path.insert(0, "/libraries")
from pathlib import Path
from axistwin.ui.playground.playground import Playground
playground = Playground(Path("/scene"))
playground.choices()
playground.open_model("if1")
playground.advance(10**9, 1.0)
own = sys.stdlib_module_names - {"random"}
"import " + ", ".join(name for name in sys.modules if name not in before and name.partition(".")[0] in own)
`;

async function python(archives, options = {}) {
  const made = await loadPyodide({ indexURL: engine, ...options });
  for (const name of archives) made.unpackArchive(new Uint8Array(fs.readFileSync(engine + name)).buffer, "zip", { extractDir: "/libraries" });
  return made;
}

const compiling = await python(["libraries.zip", wheel]);
compiling.unpackArchive(new Uint8Array(fs.readFileSync(engine + core)).buffer, "zip", { extractDir: "/core" });
compiling.runPython(COMPILE);
fs.writeFileSync(engine + "compiled.zip", compiling.FS.readFile("/compiled.zip"));
fs.writeFileSync(engine + "core.zip", compiling.FS.readFile("/core.zip"));

const first = await python(["compiled.zip"]);
await first.loadPackage(pathToFileURL(engine + core).href, { checkIntegrity: false, messageCallback: () => {} });
const imports = first.runPython(START);

const ready = await python([], { _makeSnapshot: true });
const memory = ready._module.HEAP8.length;
ready.runPython(`${imports}\nimport gc\ngc.collect()`);
if (ready._module.HEAP8.length > memory) throw new Error("the snapshot is larger than the memory in which it is restored");
fs.writeFileSync(engine + "snapshot.gz", zlib.gzipSync(ready.makeMemorySnapshot(), { level: 9 }));
