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

worker.onmessage = ({ data: { id, result, error, progress, stage } }) => {
  if (progress !== undefined) {
    $("progress").value = progress;
    $("stage").textContent = stage;
    return;
  }
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
  $("title").textContent = overview.title;
  note(overview.note);
  $("controller").replaceChildren(...overview.controllers.filter((one) => one.port).map((one) => element("option", {}, one.name)));
  $("program").value = "";
  $("findings").replaceChildren();
  buildMachine();
  buildPins();
  buildOperator();
  buildConversation();
  for (const id of ["run", "restart", "step", "share", "scene", "table"]) $(id).disabled = false;
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
  draw(await call("advance", until, BUDGET_S, Math.max(0, nowNs - windowNs), running));
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
  drawState(state.state);
  for (const [name, entries] of Object.entries(state.entries)) addEntries(name, entries);
  for (const [name, changes] of Object.entries(state.drawings)) drawings[name].show(changes);
  for (const [name, values] of Object.entries(state.controllers)) drawController(name, values);
  drawCurves(state.curves);
  drawLesson(state.controllers[$("controller").value]);
  drawOperator(state);
}

// State in words, and the next step

let shownState = "";

function drawState(state) {
  const now = JSON.stringify(state);
  if (now === shownState) return;
  shownState = now;
  $("state").textContent = state.words;
  $("words").textContent = state.next;
  for (const id of ["what", "next"]) $(id).dataset.tone = state.tone;
  $("acts").replaceChildren(
    ...state.buttons.map(([label, does, filled]) => {
      const button = element("button", filled ? { class: "filled" } : {}, label);
      button.onclick = guarded(() => press(label, does));
      return button;
    }),
  );
}

async function press(label, does) {
  if (does === "lessons") {
    tab("Terminal");
    $("lessons").open = true;
    $("titles").querySelector("button")?.focus();
  } else if (does === "run") start();
  else if (does === "restart") await restart();
  else {
    await call("press", label, running);
    if (!running) start();
  }
}

// Conversation: a list for each controller, lessons, and questions to the tutor

const TABS = ["Terminal", "Program", "Front panel"];
let logs = {};

function tab(chosen) {
  for (const name of TABS) {
    const id = name.replace(" ", "-");
    $(id).hidden = name !== chosen;
    $(`tab-${id}`).setAttribute("aria-selected", name === chosen);
    $(`tab-${id}`).tabIndex = name === chosen ? 0 : -1;
  }
}

$("tabs").append(
  ...TABS.map((name) => {
    const button = element("button", { role: "tab", id: `tab-${name.replace(" ", "-")}`, "aria-controls": name.replace(" ", "-") }, name);
    button.onclick = () => tab(name);
    return button;
  }),
);
$("tabs").onkeydown = ({ key, target }) => {
  const step = { ArrowRight: 1, ArrowLeft: -1 }[key];
  if (!step) return;
  const name = TABS[(TABS.indexOf(target.textContent) + step + TABS.length) % TABS.length];
  tab(name);
  $(`tab-${name.replace(" ", "-")}`).focus();
};
tab("Terminal");

const marked = (parts) => parts.map(([text, kind]) => (kind ? element("code", {}, text) : text));

function buildConversation() {
  logs = {};
  $("logs").replaceChildren(
    ...opened.controllers.map(({ name }) => {
      const box = element("div", { "aria-label": `Messages of ${name}` });
      logs[name] = { box, spoken: false, log: window.axistwinLog(box, null) };
      return box;
    }),
  );
  document.querySelector(".of").hidden = opened.controllers.length < 2;
  shownState = "";
  chooseController();
}

function chooseController() {
  const one = chosen();
  for (const [name, { box, spoken }] of Object.entries(logs)) box.hidden = name !== one.name || !spoken;
  buildFirst(one);
  $("lessons").hidden = !one.lessons.length;
  $("titles").replaceChildren(
    ...one.lessons.map((title, n) => {
      const button = element("button", {}, `${n + 1}  ${title}`);
      button.onclick = () => beginLesson(n + 1);
      return button;
    }),
  );
  for (const panel of $("Front-panel").children) panel.hidden = panel.dataset.of !== one.name;
}

function buildFirst({ name, first, lessons }) {
  const initialise = () => {
    const button = element("button", {}, "Initialise");
    button.onclick = guarded(() => call("initialise", name));
    return button;
  };
  const steps = first.steps.map(({ title, words, initialises }) =>
    element("li", {}, element("div", {}, element("b", {}, title), element("p", { class: "quiet" }, ...marked(words)), ...(initialises ? [initialise()] : []))),
  );
  const begin = element("button", {}, "Begin lesson 1");
  begin.onclick = () => beginLesson(1);
  const or = element("div", { class: "or" }, element("p", {}, "Six short lessons lead from the first command to a repeating sequence."), begin);
  $("first").replaceChildren(element("h2", {}, first.title), element("p", { class: "quiet" }, first.about), element("ol", {}, ...steps), ...(lessons.length ? [or] : []));
  $("first").hidden = logs[name].spoken;
}

function addEntries(name, entries) {
  const one = logs[name];
  if (!one.spoken && entries.some(({ who }) => "><?".includes(who))) {
    one.spoken = true;
    chooseController();
  }
  one.log.add(entries);
}

const beginLesson = guarded(async (number) => {
  $("lessons").open = false;
  await call("begin_lesson", $("controller").value, number);
  start();
  $("text").focus();
});

function drawLesson(values) {
  const lesson = values?.lesson;
  $("lesson").hidden = !lesson;
  if (!lesson || $("lesson-title").textContent === lesson.title) return;
  $("lesson-title").textContent = lesson.title;
  $("task").replaceChildren(...marked(lesson.task));
  $("show").hidden = lesson.finished;
  $("next-lesson").hidden = !lesson.finished || lesson.number === chosen().lessons.length;
  $("next-lesson").onclick = () => beginLesson(lesson.number + 1);
}

const ask = (question) => guarded(() => call("ask", $("controller").value, question, $("text").value));
$("show").onclick = ask("show");
$("why").onclick = ask("why");
$("what-next").onclick = ask("next");
$("explain").onclick = ask("explain");
$("init").onclick = guarded(() => call("initialise", $("controller").value));
$("end-lesson").onclick = guarded(() => call("end_lesson", $("controller").value));
$("controller").onchange = () => chooseController();

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
  operated = [];
  const parts = [];
  for (const controller of opened.controllers)
    for (const { name, kind, art, axis } of controller.drawings) {
      const drawing = element("div", { class: kind });
      drawings[name] = window.axistwinParts(drawing, art, guarded(async (part) => {
        await call("click", name, part);
        if (!running) draw(await call("state", Math.max(0, nowNs - windowNs)));
      }));
      const title = axis ? `${controller.name}.${axis}` : name;
      const heading = axis || (name.startsWith("switches") ? "Inputs and outputs" : "From above");
      const box = element("section", { class: "axis", "aria-label": title }, element("h2", { class: "axis-name" }, opened.controllers.length > 1 ? title : heading), drawing);
      if (axis) {
        boxes[title] = box;
        box.hidden = true; // until the axis is used; no drawing disappears
      }
      parts.push(box);
    }
  $("machine").replaceChildren(...parts);
}

// Power, inputs without a switch on a drawing, and the front panel in the groups of the manual

let levels = {};
let fronts = {};

function buildPins() {
  levels = {};
  fronts = {};
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
    levels[controller.name] = { power, inputs: Object.fromEntries(controller.inputs.map((pin, n) => [pin, inputs[n]])), outputs: Object.fromEntries(controller.outputs.map((pin, n) => [pin, outputs[n]])) };
    parts.push(element("h2", {}, `${of}power and other terminals`), element("div", { class: "row" }, power, ...inputs, ...outputs));
  }
  $("pins").replaceChildren(...parts);
  $("Front-panel").replaceChildren(...opened.controllers.map(buildFront));
}

function buildFront({ name, front }) {
  const box = element("div", {});
  box.dataset.of = name;
  fronts[name] = [];
  for (const group of front) {
    const items = group.items.map((item) => {
      if (item.kind === "lamp") {
        const lamp = element("span", { class: `lamp ${item.tone}`, title: item.words, role: "img", "aria-label": item.words }, item.label);
        fronts[name].push((lit) => {
          lamp.classList.toggle("lit", lit);
          lamp.setAttribute("aria-label", `${item.words} ${lit ? "on" : "off"}`);
        });
        return lamp;
      }
      const value = element("b", {});
      const shown = element("span", { class: "shown", title: item.words }, `${item.label} `, value, ` ${item.unit}`);
      fronts[name].push(([text, tone]) => {
        value.textContent = text;
        shown.className = `shown ${tone}`;
      });
      return shown;
    });
    box.append(element("section", { "aria-label": group.title }, element("h2", {}, group.title), element("div", { class: "row" }, ...items)));
  }
  return box;
}

function drawController(name, values) {
  for (const axis of Object.keys(values.axes)) boxes[`${name}.${axis}`].hidden &&= !values.used.includes(axis);
  const { power, inputs, outputs } = levels[name];
  power.setAttribute("aria-pressed", values.powered);
  for (const [pin, level] of Object.entries(values.pins)) {
    inputs[pin]?.setAttribute("aria-pressed", level);
    outputs[pin]?.classList.toggle("lit", level);
  }
  values.front.forEach((value, n) => fronts[name][n](value));
}

// Operator panel: a latching button changes with each click, any other is pressed while it is held

let operated = [];

function buildOperator() {
  const of = (pin) => pin.split(".");
  const buttons = opened.operator.button.map(({ name, pin, pressed, latching }) => {
    const [who, terminal] = of(pin);
    const key = element("button", { "aria-pressed": "false", class: latching && /stop/i.test(name) ? "stop" : "" }, name);
    const set = guarded((on) => call("act", who, terminal, on === (pressed === "high") ? "high" : "low"));
    const isOn = () => key.getAttribute("aria-pressed") === "true";
    if (latching) key.onclick = () => set(!isOn());
    else {
      key.onpointerdown = () => set(true);
      for (const end of ["onpointerup", "onpointerleave", "onblur"]) key[end] = () => isOn() && set(false);
      key.onkeydown = ({ key: typed, repeat }) => !repeat && " Enter".includes(typed) && set(true);
      key.onkeyup = ({ key: typed }) => " Enter".includes(typed) && set(false);
    }
    operated.push((state) => {
      key.setAttribute("aria-pressed", state.controllers[who].pins[terminal] === (pressed === "high"));
      key.classList.toggle("wanted", state.state.pin === pin);
    });
    return key;
  });
  const lamps = opened.operator.lamp.map(({ name, pin, lit }) => {
    const [who, terminal] = of(pin);
    const lamp = element("span", { class: "lamp" }, name);
    operated.push((state) => lamp.classList.toggle("lit", state.controllers[who].pins[terminal] === (lit === "high")));
    return lamp;
  });
  $("operator").replaceChildren(...buttons, ...lamps);
}

function drawOperator(state) {
  for (const show of operated) show(state);
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
      if (values.every((value) => value === values[0])) continue; // nothing has moved
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
  if (!parts.length) parts.push(element("p", { class: "hint" }, "Curves of the axes appear here while they move."));
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

const restart = guarded(async () => {
  show(await call("restart"));
  start();
});
$("restart").onclick = restart;

$("step").onclick = guarded(async () => {
  running = false;
  showRunning();
  draw(await call("step", Math.max(0, nowNs - windowNs)));
});

$("line").onsubmit = guarded(async (event) => {
  event.preventDefault();
  const text = $("text").value;
  if (!text) return;
  if (!running) start();
  await call("send", $("controller").value, text);
  $("text").value = "";
  note("");
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
  $("loading").hidden = true;
  document.documentElement.dataset.state = "ready";
  loop();
})();
