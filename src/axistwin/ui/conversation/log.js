// The list of a conversation: entries are added, or replaced by their number.  `keys(text)` gets what is typed on the list.
window.axistwinLog = (box, keys) => {
  const MOST = 2000; // entries on the page; the browser lays out only the visible ones
  const NAMES = { ">": "host", "<": "controller", "·": "act", "!": "fault", "?": "question" };
  const CODES = { Enter: "\r", Backspace: "\b", Escape: "\x1b" };
  const list = document.createElement("ol");
  const shown = new Map();
  box.append(list);
  box.classList.add("log");
  box.tabIndex = 0;
  box.setAttribute("role", "log");

  const element = (tag, kind, ...children) => {
    const made = document.createElement(tag);
    if (kind) made.className = kind;
    made.append(...children);
    return made;
  };

  // A line of commands is wrapped at blanks, and before the colons that begin the steps of a program; nowhere else.
  const wrapped = (text) => {
    const program = text.split(":").length > 3;
    return text.split(program ? /( +)|(?=:)/ : /( +)/).filter(Boolean).map((piece) => (piece.trim() ? element("b", "", piece) : piece));
  };

  const part = ([text, kind]) => {
    if (!kind) return wrapped(text);
    return [kind === "control" ? element("s", "", text) : element("span", kind, text)];
  };
  const note = (parts) => element("p", "note", ...parts.map(([text, kind]) => (kind ? element("code", "", ...wrapped(text)) : text)));

  function row({ number, time, who, parts, notes, held }) {
    const spoken = who === ">" || who === "<";
    const sign = element("i", "", who);
    sign.setAttribute("role", "img");
    sign.setAttribute("aria-label", NAMES[who]);
    const said = element(spoken ? "code" : "span", "said", ...parts.flatMap(part));
    if (held) said.append(element("span", "quiet", " not received yet"));
    const made = element("li", "", element("time", "", time), " ", sign, " ", element("div", "", said, ...notes.map(note)));
    made.dataset.who = NAMES[who];
    return made;
  }

  function add(entries) {
    for (const entry of entries) {
      const made = row(entry);
      const before = shown.get(entry.number);
      if (before) before.replaceWith(made);
      else list.append(made);
      shown.set(entry.number, made);
    }
    while (shown.size > MOST) {
      const [oldest, old] = shown.entries().next().value;
      old.remove();
      shown.delete(oldest);
    }
    if (entries.length) settle();
  }

  // Shows the last entry, unless the user has scrolled back; twice, because the browser guesses heights at first.
  let follow = true;
  const toEnd = () => follow && (box.scrollTop = box.scrollHeight);
  function settle() {
    toEnd();
    requestAnimationFrame(() => requestAnimationFrame(toEnd));
  }
  box.addEventListener("scroll", () => (follow = box.scrollTop + box.clientHeight > box.scrollHeight - 32));
  new ResizeObserver(settle).observe(box);

  function clear() {
    shown.clear();
    list.replaceChildren();
  }

  if (keys) {
    box.addEventListener("keydown", (event) => {
      const text = event.key.length === 1 ? event.key : CODES[event.key];
      if (text === undefined || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      event.stopPropagation(); // the page has keys of its own
      keys(text);
    });
    box.addEventListener("paste", (event) => keys(event.clipboardData.getData("text")));
  }

  return { add, clear };
};
