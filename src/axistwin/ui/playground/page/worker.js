// The worker: Pyodide with axistwin.  A message {id, method, args} is answered by {id, result} or {id, error}.

import { loadPyodide } from "./engine/pyodide.mjs";

const OLD_BROWSER = "this browser cannot run Python: use a current Firefox, Chrome, Edge or Safari";
const engine = new URL("./engine/", import.meta.url).href;

const tell = (progress, stage) => self.postMessage({ progress, stage });

async function bytes(name) {
  const answer = await fetch(engine + name);
  if (!answer.ok) throw new Error(`${name} is missing: copy the whole folder of the playground`);
  return answer.arrayBuffer();
}

// A snapshot of a Python that has begun takes a fifth of the time of its begin.
async function snapshot(name) {
  const data = await bytes(name);
  const packed = new Uint8Array(data, 0, 2);
  if (packed[0] !== 0x1f || packed[1] !== 0x8b) return new Uint8Array(data); // the server has unpacked it
  return new Uint8Array(await new Response(new Blob([data]).stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer());
}

async function begin(contents) {
  if (contents.snapshot) {
    try {
      return await loadPyodide({ indexURL: engine, _loadSnapshot: await snapshot(contents.snapshot) });
    } catch (error) {
      console.warn(`the snapshot cannot be used: ${error.message}`);
    }
  }
  return loadPyodide({ indexURL: engine });
}

async function start() {
  if (typeof WebAssembly === "undefined") throw new Error(OLD_BROWSER);
  tell(0.05, "Loading Python …");
  const contents = await (await fetch(new URL("./contents.json", import.meta.url))).json();
  const archives = contents.archives.map(bytes);
  const python = await begin(contents);
  tell(0.5, "Loading libraries …");
  await python.loadPackage(engine + contents.core, { checkIntegrity: false, messageCallback: () => {} });
  for (const archive of archives) python.unpackArchive(await archive, "zip", { extractDir: "/libraries" });
  tell(0.7, "Loading axistwin …");
  python.runPython(`
import sys
sys.path.insert(0, "/libraries")
import json
from pathlib import Path
from axistwin.core.errors import AxistwinError
from axistwin.ui.playground.playground import Playground

_playground = Playground(Path("/scene"))

def call(method, arguments):
    try:
        result = getattr(_playground, method)(*json.loads(arguments))
    except AxistwinError as error:
        return json.dumps({"error": str(error)})
    if isinstance(result, bytes):
        return result
    return json.dumps({"result": result})
`);
  tell(0.95, "Building the machine …");
  return python.globals.get("call");
}

const started = start();

self.onmessage = async ({ data: { id, method, args } }) => {
  try {
    const call = await started;
    const answer = call(method, JSON.stringify(args));
    if (typeof answer !== "string") {
      const data = answer.toJs();
      answer.destroy();
      self.postMessage({ id, result: data });
    } else {
      self.postMessage({ id, ...JSON.parse(answer) });
    }
  } catch (error) {
    self.postMessage({ id, error: String(error.message ?? error).trim().split("\n").pop() });
  }
};
