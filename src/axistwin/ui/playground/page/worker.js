// The worker: Pyodide with axistwin.  A message {id, method, args} is answered by {id, result} or {id, error}.

import { loadPyodide } from "./engine/pyodide.mjs";

const OLD_BROWSER = "this browser cannot run Python: use a current Firefox, Chrome, Edge or Safari";
const engine = new URL("./engine/", import.meta.url).href;

async function bytes(name) {
  const answer = await fetch(engine + name);
  if (!answer.ok) throw new Error(`${name} is missing: copy the whole folder of the playground`);
  return answer.arrayBuffer();
}

async function start() {
  if (typeof WebAssembly === "undefined") throw new Error(OLD_BROWSER);
  const contents = await (await fetch(new URL("./contents.json", import.meta.url))).json();
  const [python, wheel, libraries] = await Promise.all([
    loadPyodide({ indexURL: engine }),
    bytes(contents.wheel),
    bytes("libraries.zip"),
  ]);
  await python.loadPackage(engine + contents.core, { checkIntegrity: false, messageCallback: () => {} });
  python.unpackArchive(libraries, "zip", { extractDir: "/libraries" });
  python.unpackArchive(wheel, "zip", { extractDir: "/libraries" });
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
