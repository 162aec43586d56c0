// The page of the playground: asks the worker for the state, and draws it.

const FRAME_MS = 50;
const BUDGET_S = 0.04; // computing time of one frame
const WINDOW_NS = 10e9; // shortest time that the curves show
const LEAST_SAMPLES = 100; // smallest number of samples that the curves show
const S = 1e9;

const $ = (id) => document.getElementById(id);
const element = (tag, attributes = {}, ...children) => {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
};

// Worker

const OLD_BROWSER = "this browser cannot run the playground: use a current Firefox, Chrome, Edge or Safari";

function newWorker() {
  try {
    return new Worker(new URL("./worker.js", import.meta.url), { type: "module" });
  } catch (error) {
    note(OLD_BROWSER, true);
    throw error;
  }
}

const worker = newWorker();
const waiting = new Map();
let calls = 0;

worker.onmessage = ({ data: { id, result, error } }) => {
  const [resolve, reject] = waiting.get(id);
  waiting.delete(id);
  if (error === undefined) resolve(result);
  else reject(new Error(error));
};
worker.onerror = () => note(OLD_BROWSER, true);

function call(method, ...args) {
  return new Promise((resolve, reject) => {
    waiting.set(++calls, [resolve, reject]);
    worker.postMessage({ id: calls, method, args });
  });
}

function note(text, isError = false) {
  $("note").textContent = text;
  $("note").classList.toggle("error", isError);
}

const guarded = (action) => async (...args) => {
  try {
    await action(...args);
  } catch (error) {
    note(error.message, true);
  }
};

// State

let largestBytes = Infinity; // of all files together that can be opened
let opened = null; // the overview of the open scene
let nowNs = 0;
let windowNs = WINDOW_NS;
let running = false;
let targetNs = 0; // virtual time of a share link, to which the session advances first

function show(overview) {
  opened = overview;
  targetNs = overview.target_ns;
  nowNs = 0;
  running = false;
  document.title = `${overview.title} – axistwin playground`;
  note(overview.note || overview.title);
  $("conversation").replaceChildren();
  $("controller").replaceChildren(...overview.controllers.filter((one) => one.port).map((one) => element("option", {}, one.name)));
  $("program").value = "";
  $("findings").replaceChildren();
  buildMachine();
  buildPins();
  for (const id of ["run", "step", "share", "scene", "table"]) $(id).disabled = false;
  showRunning();
}

function showRunning() {
  $("run").textContent = running ? "Pause" : "Run";
  $("run").setAttribute("aria-pressed", running);
}

// Frames

let last = performance.now();

const frame = guarded(async () => {
  const now = performance.now();
  const passed = (now - last) / 1000;
  last = now;
  if (!opened || document.hidden) return;
  const speed = Number($("speed").value);
  const before = nowNs;
  let until = nowNs;
  if (nowNs < targetNs) until = targetNs;
  else if (running) until = speed ? nowNs + Math.round(Math.min(passed, 0.25) * speed * S) : nowNs + 3600 * S;
  draw(await call("advance", until, BUDGET_S, Math.max(0, nowNs - windowNs)));
  if (running || before < targetNs) $("rate").textContent = `× ${((nowNs - before) / S / Math.max(passed, 1e-3)).toPrecision(2)}`;
  else $("rate").textContent = "";
});

async function loop() {
  await frame();
  setTimeout(loop, FRAME_MS);
}

function draw(state) {
  nowNs = state.now_ns;
  windowNs = Math.max(WINDOW_NS, LEAST_SAMPLES * state.interval_ns);
  $("time").textContent = `${(nowNs / S).toFixed(3)} s`;
  for (const message of state.messages) append(message);
  for (const [name, changes] of Object.entries(state.drawings)) drawings[name].show(changes);
  for (const [name, values] of Object.entries(state.controllers)) drawController(name, values);
  drawCurves(state.curves);
  const chosen = state.controllers[$("controller").value];
  $("reason").textContent = chosen ? (chosen.powered ? chosen.reason : "the power is off") : "";
}

function append({ name, who, text }) {
  const log = $("conversation");
  const atEnd = log.scrollTop + log.clientHeight > log.scrollHeight - 8;
  const shown = text.replaceAll("\r\n", "\n").replaceAll("\r", "\n");
  const several = opened.controllers.length > 1 && who !== "controller" ? `${name}: ` : "";
  log.append(element("span", { class: who }, who === "tutor" ? `  ${shown}` : several + shown));
  while (log.childNodes.length > 1000) log.firstChild.remove();
  if (atEnd) log.scrollTop = log.scrollHeight;
}

// Machine: the drawings, of which the state contains the changes

const SVG = "http://www.w3.org/2000/svg";
const svg = (tag, attributes, text = "") => {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.textContent = text;
  return made;
};
let drawings = {};
let boxes = {};

function buildMachine() {
  drawings = {};
  boxes = {};
  const parts = [];
  for (const controller of opened.controllers)
    for (const { name, kind, art, axis } of controller.drawings) {
      const drawing = element("div", { class: kind });
      drawings[name] = window.axistwinParts(drawing, art, guarded(async (part) => {
        await call("click", name, part);
        if (!running) draw(await call("state", Math.max(0, nowNs - windowNs)));
      }));
      const title = axis ? `${controller.name}.${axis}` : name;
      const box = element("section", { class: "axis", "aria-label": title }, element("h2", { class: "axis-name" }, title), drawing);
      if (axis) {
        boxes[title] = box;
        box.hidden = true; // until the axis is used; no drawing disappears
      }
      parts.push(box);
    }
  $("machine").replaceChildren(...parts);
}

// Inputs, outputs and lamps

let levels = {};
let lamps = {};

function buildPins() {
  levels = {};
  lamps = {};
  const parts = [];
  for (const controller of opened.controllers) {
    const of = opened.controllers.length > 1 ? `${controller.name}: ` : "";
    const power = element("button", { "aria-pressed": "true" }, "Power");
    power.onclick = guarded(() => call("act", controller.name, "power", power.getAttribute("aria-pressed") === "true" ? "off" : "on"));
    const inputs = controller.inputs.map((pin) => {
      const key = element("button", { title: `${pin}: high or low` }, pin);
      key.onclick = guarded(() => call("act", controller.name, pin, key.getAttribute("aria-pressed") === "true" ? "low" : "high"));
      return key;
    });
    const outputs = controller.outputs.map((pin) => element("span", { class: "lamp" }, pin));
    lamps[controller.name] = controller.lamps.map((lamp) => element("span", { class: `lamp ${lamp.tone}`, title: `${lamp.group}: ${lamp.words}` }, lamp.label));
    levels[controller.name] = { power, inputs: Object.fromEntries(controller.inputs.map((pin, n) => [pin, inputs[n]])), outputs: Object.fromEntries(controller.outputs.map((pin, n) => [pin, outputs[n]])) };
    parts.push(element("h2", {}, inputs.length ? `${of}power, inputs (pressed: high)` : `${of}power`), element("div", { class: "row" }, power, ...inputs));
    if (outputs.length) parts.push(element("h2", {}, `${of}outputs`), element("div", { class: "row" }, ...outputs));
    if (controller.lamps.length) parts.push(element("h2", {}, `${of}lamps`), element("div", { class: "row" }, ...lamps[controller.name]));
  }
  $("pins").replaceChildren(...parts);
}

function drawController(name, values) {
  for (const axis of Object.keys(values.axes)) boxes[`${name}.${axis}`].hidden &&= !values.used.includes(axis);
  const { power, inputs, outputs } = levels[name];
  power.setAttribute("aria-pressed", values.powered);
  for (const [pin, level] of Object.entries(values.pins)) {
    inputs[pin]?.setAttribute("aria-pressed", level);
    outputs[pin]?.classList.toggle("lit", level);
  }
  values.lamps.forEach((lit, n) => lamps[name][n].classList.toggle("lit", lit));
}

// Curves

const WIDTH = 600;
const HEIGHT = 110;

function drawCurves(curves) {
  const to = nowNs / S;
  const from = Math.max(0, to - windowNs / S);
  const parts = [];
  for (const [name, quantities] of Object.entries(curves).filter(([name]) => !boxes[name].hidden))
    for (const [quantity, points] of Object.entries(quantities)) {
      const values = points.map(([, value]) => value);
      const low = Math.min(0, ...values);
      const high = Math.max(1, ...values);
      const x = (t) => (WIDTH * (t - from)) / (to - from || 1);
      const y = (value) => 22 + ((HEIGHT - 28) * (high - value)) / (high - low);
      const drawing = svg("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": `${quantity} of ${name}` });
      drawing.append(
        svg("rect", { class: "frame", x: 0, y: 18, width: WIDTH, height: HEIGHT - 20 }),
        svg("polyline", { class: `curve ${quantity}`, points: points.map(([t, value]) => `${x(t).toFixed(1)},${y(value).toFixed(1)}`).join(" ") }),
        svg("text", { x: 4, y: 13 }, `${name} ${quantity}`),
        svg("text", { x: WIDTH - 4, y: 13, "text-anchor": "end" }, `${Math.round(low)} … ${Math.round(high)}   ${from.toFixed(1)} … ${to.toFixed(1)} s`),
      );
      parts.push(drawing);
    }
  $("curves").replaceChildren(...parts);
}

// Controls

$("choice").onchange = guarded(async () => {
  const [kind, name] = $("choice").value.split(" ");
  location.hash = "";
  show(await call(kind, name));
  start();
});

function start() {
  running = true;
  showRunning();
}

$("run").onclick = () => {
  running = !running;
  showRunning();
};

$("step").onclick = guarded(async () => {
  running = false;
  showRunning();
  draw(await call("step", Math.max(0, nowNs - windowNs)));
});

$("line").onsubmit = guarded(async (event) => {
  event.preventDefault();
  const text = $("text").value;
  $("text").value = "";
  note(opened.title);
  if (!running) start();
  for (const words of await call("send", $("controller").value, text)) append({ name: $("controller").value, who: "tutor", text: words });
});

const chosen = () => opened.controllers.find((one) => one.name === $("controller").value);

let checks = 0;
$("program").oninput = guarded(async () => {
  const mine = ++checks;
  await new Promise((resolve) => setTimeout(resolve, 200));
  if (mine !== checks) return;
  const found = await call("check", chosen().name, chosen().suffix, $("program").value);
  $("findings").replaceChildren(...found.map((one) => element("li", { class: one.severity }, `${one.line}:${one.column} ${one.message}`)));
});

$("load").onclick = guarded(async () => {
  await call("load", chosen().name, `program${chosen().suffix}`, $("program").value);
  note(`loaded into ${chosen().name}`);
  start();
});

$("share").onclick = guarded(async () => {
  location.hash = await call("link");
  try {
    await navigator.clipboard.writeText(location.href);
    note("the link is copied, and in the address bar");
  } catch {
    note("the link is in the address bar");
  }
});

function download(name, type, data) {
  const link = element("a", { href: URL.createObjectURL(new Blob([data], { type })), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

$("scene").onclick = guarded(async () => download("scene.zip", "application/zip", await call("saved")));
$("table").onclick = guarded(async () => download("curves.csv", "text/csv", await call("table")));

// A device is Python code of somebody: it runs only after a question.
async function open(method, ...args) {
  const found = await call(method, ...args, false);
  if (!found.asks) return found;
  const names = found.asks.join(", ");
  if (!confirm(`${names} is Python code, which would run in this page. Open it only if you trust its author.`)) {
    throw new Error(`${names} was not run: open the scene again and agree, or choose another`);
  }
  return call(method, ...args, true);
}

const openFiles = guarded(async (files) => {
  const texts = {};
  const bytes = [...files].reduce((sum, file) => sum + file.size, 0);
  if (bytes > largestBytes) throw new Error(`the files have ${bytes} bytes: expected at most ${largestBytes}: use the installed axistwin`);
  for (const file of files) texts[file.name] = await file.text();
  const scenes = Object.keys(texts).filter((name) => name.endsWith(".toml"));
  if (scenes.length > 1) throw new Error(`${scenes.length} scenes: expected one .toml file`);
  if (scenes.length) {
    show(await open("open_files", texts, scenes[0]));
    start();
    return;
  }
  const [name] = Object.keys(texts);
  if (!opened || !chosen()) throw new Error("no scene: choose a machine first, or open a scene with its files");
  $("program").value = texts[name];
  $("program").closest("details").open = true;
  await call("load", chosen().name, name, texts[name]);
  note(`${name} is loaded into ${chosen().name}`);
  start();
});

$("files").onchange = () => openFiles($("files").files);
addEventListener("dragover", (event) => {
  event.preventDefault();
  document.body.classList.add("dropping");
});
addEventListener("dragleave", () => document.body.classList.remove("dropping"));
addEventListener("drop", (event) => {
  event.preventDefault();
  document.body.classList.remove("dropping");
  openFiles(event.dataTransfer.files);
});

function setTheme(dark) {
  document.documentElement.classList.toggle("dark", dark);
  document.body.classList.toggle("body--dark", dark);
  $("theme").setAttribute("aria-pressed", dark);
}
setTheme(matchMedia("(prefers-color-scheme: dark)").matches);
$("theme").onclick = () => setTheme($("theme").getAttribute("aria-pressed") !== "true");

// Start

guarded(async () => {
  const { version, models, examples, largest } = await call("choices");
  largestBytes = largest;
  $("version").textContent = `axistwin ${version}`;
  const option = (kind, name, title) => element("option", { value: `${kind} ${name}` }, title);
  $("choice").replaceChildren(
    element("optgroup", { label: "Controllers" }, ...models.map((model) => option("open_model", model, model))),
    element("optgroup", { label: "Machines" }, ...examples.map(({ name, title }) => option("open_example", name, title))),
  );
  $("choice").disabled = false;
  const fragment = location.hash.slice(1);
  try {
    if (fragment) {
      $("choice").prepend(element("option", { value: "", disabled: "" }, "from the link"));
      $("choice").value = "";
      show(await open("open_link", fragment));
    } else {
      show(await call("open_model", models[0]));
      start();
    }
  } catch (error) {
    show(await call("open_model", models[0]));
    note(error.message, true);
  }
  document.documentElement.dataset.state = "ready";
  loop();
})();
