// Stores the state of the page in document.body.dataset.state: "busy", "running" or "quiet".
window.axistwinState = (() => {
  const OWN = '{"sent":';
  let sent = 0, planned = false;

  // Counts the messages that the page sends, and sends their number after them.
  function attach() {
    watch();
    timeline();
    window.socket.onAnyOutgoing((kind, message) => {
      if (kind !== "event" || message.args?.[0]?.startsWith(OWN)) return;
      sent += 1;
      document.body.dataset.state = "busy";
      if (!planned) queueMicrotask(() => { planned = false; emitEvent("sent", { sent }); });
      planned = true;
    });
  }

  // Greys the page while the server cannot be reached, and shows since when.
  function watch() {
    const gone = document.createElement("div");
    gone.id = "gone";
    gone.setAttribute("role", "alert");
    document.body.append(gone);
    window.socket.on("disconnect", () => {
      const since = new Date().toLocaleTimeString([], { hour12: false });
      gone.textContent = `No answer since ${since}: the page shows the state of that time`;
      document.documentElement.classList.add("gone");
    });
    window.socket.on("connect", () => {
      gone.textContent = "";
      document.documentElement.classList.remove("gone");
    });
  }

  // Tells the time under the pointer at the timeline, whose arrow keys move by 1 s, with Shift by 10 s.
  function timeline() {
    document.addEventListener("pointermove", (event) => {
      const past = event.target.closest?.(".past"), slider = past?.querySelector("[role=slider]");
      if (!slider) return;
      const { left, width } = slider.getBoundingClientRect(), part = Math.min(Math.max((event.clientX - left) / width, 0), 1);
      const told = past.querySelector(".pointed");
      told.textContent = `${(part * slider.getAttribute("aria-valuemax")).toFixed(2)} s`;
      told.style.left = `${100 * part}%`;
    });
    const key = (event) => {
      const way = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[event.key];
      if (!way || event.ctrlKey || event.altKey || event.metaKey || !event.target.closest?.(".timeline")) return;
      event.preventDefault();
      event.stopImmediatePropagation();
      if (event.type === "keydown") emitEvent("timeline", { by: way * (event.shiftKey ? 10 : 1) });
    };
    for (const type of ["keydown", "keyup"]) document.addEventListener(type, key, true);  // the slider moves at both
  }

  // Stores the state; "busy" if the server has not handled all messages.  `handled`: number of handled messages.
  function show(state, handled) {
    document.body.dataset.state = handled === sent ? state : "busy";
  }

  // Writes a text into an element; `elements`: the data from which Vue draws the page later.
  function write(elements, id, text) {
    if (elements[id]) elements[id].text = text;
    const node = document.getElementById(`c${id}`)?.firstChild;
    if (node) node.nodeValue = text;
  }

  // Draws marks on the timeline: places from 0 to 1, and whether each is abnormal.
  function marks(id, places) {
    document.getElementById(`c${id}`)?.replaceChildren(...places.map(([at, alarm]) => {
      const mark = document.createElement("b");
      mark.style.left = `${100 * at}%`;
      mark.classList.toggle("alarm", alarm);
      return mark;
    }));
  }

  // Opens the menu of lessons, in the terminal of a controller.
  async function lessons(controller) {
    const found = (kind, words) => [...document.querySelectorAll(`.talk ${kind}`)].find(
      (each) => each.getClientRects().length && each.textContent.includes(words));
    found(".talk-with [role=tab]", controller)?.click();
    for (let frame = 0; frame < 120; frame += 1) {
      await new Promise(requestAnimationFrame);
      const button = found(".terminal-head button", "Lessons");
      if (button) return button.click();
      found(".kinds [role=tab][aria-selected=false]", "Terminal")?.click();
    }
  }

  return { attach, show, write, marks, lessons };
})();
