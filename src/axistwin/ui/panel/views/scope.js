// The plot of the oscilloscope: draws the messages of the server, and sends messages about mouse, fingers and keys.
window.axistwinScope = (() => {
  const FULL = 65535, TOP = 4000, NEAR = 9, CLICK = 4, AXIS = 22;
  const LEAST = 28, FOLDED = 16, NUMBER = 3, LEVEL = 1;  // least heights of lanes in pixels; shares of what is left
  const COLOURS = ["#0072B2", "#BB4E00", "#00805D", "#B04C86", "#8A6000", "#2F79A3"], DASHES = [[], [6, 3], [2, 3]];
  const DARK = ["#56B4E9", "#FF9D5C", "#3CC9A0", "#E79BC4", "#E0B64A", "#8CC4E6"];
  const TOKENS = ["ink", "ink-2", "line", "act", "alarm", "well", "card"];
  let last = null, colours = {}, theme = null;

  const tell = (what) => emitEvent("scope", what);
  const made = (tag, kind, parent) => { const node = document.createElement(tag); node.className = kind; parent.append(node); return node; };
  const write = (node, text) => { if (node.textContent !== text) node.textContent = text; };

  function pairs(text) {
    const bytes = Uint8Array.from(atob(text), (sign) => sign.charCodeAt(0));
    return new Uint16Array(bytes.buffer);
  }

  // Returns the colours of the tokens in the present theme; a canvas knows no variables.
  function tokens(plot) {
    const now = document.body.classList.contains("body--dark");
    if (now === theme) return colours;
    theme = now;
    const probe = made("i", "", plot);
    for (const name of TOKENS) {
      probe.style.color = `var(--${name})`;
      colours[name] = getComputedStyle(probe).color;
    }
    probe.remove();
    return colours;
  }

  // Returns top and height of each lane in pixels; lanes that do not fit are reached by scrolling.
  function lanes(frame, room) {
    const weight = (signal) => (signal.folded ? 0 : signal.numbers ? NUMBER : LEVEL);
    const sum = (part) => frame.signals.reduce((all, signal) => all + part(signal), 0);
    const least = sum((signal) => (signal.folded ? FOLDED : LEAST)), left = Math.max(room - least, 0);
    const said = sum((signal) => (signal.text ? weight(signal) : 0)), drawn = sum(weight) - said;
    // lanes of messages take at most a third of the height beside others
    const most = frame.signals.every((signal) => signal.text) ? left : Math.max(room / 3 - LEAST * said, 0);
    const text = said && Math.min(left / (said + drawn), most / said);
    const share = drawn ? (left - text * said) / drawn : 0;
    let top = 0;
    return frame.signals.map((signal) => {
      const high = (signal.folded ? FOLDED : LEAST) + (signal.text ? text : share) * weight(signal), at = top;
      top += high;
      return [at, high];
    });
  }

  // Returns the curve of a signal as lists of points in pixels, one for each period in which the value is known.
  function stretches(signal, width, bottom, height) {
    const data = pairs(signal.data), found = [];
    let steps = null, before = 0;
    for (let n = 0; n < data.length; n += 2) {
      const x = (data[n] * width) / FULL, unknown = data[n + 1] === FULL, y = bottom - (data[n + 1] * height) / TOP;
      if (steps) steps.push([x, before]);
      if (unknown) steps = null;
      else if (!steps) found.push((steps = [[x, y]]));
      else if (y !== before) steps.push([x, y]);
      before = y;
    }
    return found;
  }

  function curve(pen, signal, n, [top, high], size, tint) {
    const pad = signal.folded ? 4 : 6, inside = high - 2 * pad;
    const style = last.lanes ? tint.ink : (theme ? DARK : COLOURS)[n % COLOURS.length];
    const found = stretches(signal, size.width, top + high - pad, inside);
    pen.setLineDash(last.lanes ? [] : DASHES[Math.floor(n / COLOURS.length) % DASHES.length]);
    pen.lineWidth = 1.5;
    pen.strokeStyle = style;
    for (const points of found) {
      pen.beginPath();
      points.forEach(([x, y], k) => (k ? pen.lineTo(x, y) : pen.moveTo(x, y)));
      pen.stroke();
      if (last.lanes && !signal.folded && signal.zero !== null && points.length) {  // the area between a curve and zero
        const zero = top + high - pad - signal.zero * inside;
        pen.lineTo(points.at(-1)[0], zero);
        pen.lineTo(points[0][0], zero);
        pen.globalAlpha = 0.09;
        pen.fillStyle = tint.ink;
        pen.fill();
        pen.globalAlpha = 1;
      }
    }
    pen.setLineDash([]);
  }

  function texts(pen, signal, [top, high], size, tint) {
    pen.font = `12px ${getComputedStyle(document.body).getPropertyValue("--mono")}`;
    pen.textBaseline = "middle";
    signal.words.forEach(([at, text], n) => {
      const x = at * size.width, room = (n + 1 < signal.words.length ? signal.words[n + 1][0] * size.width : size.width) - x - 6;
      pen.fillStyle = tint.ink;
      pen.fillRect(x, top + high / 2 - 7, 2, 14);
      const most = Math.floor(room / 7.3), lines = text.split("\n").slice(0, high > 30 ? 2 : 1);
      lines.forEach((line, k) => {
        pen.fillStyle = k ? tint["ink-2"] : tint.ink;
        const shown = line.length > most ? `${line.slice(0, Math.max(most - 1, 0))}…` : line;
        if (most > 1) pen.fillText(shown, x + 5, top + high / 2 + (lines.length > 1 ? 13 * k - 6 : 1));
      });
    });
  }

  // Returns the places of round times: the multiples of 1, 2 or 5 × 10ⁿ of which about twelve fit.
  function times(frame, width) {
    const span = frame.to - frame.from, least = span / Math.min(12, Math.max(width / 90, 2));
    const power = 10 ** Math.floor(Math.log10(least));
    const step = [1, 2, 5, 10].map((digit) => digit * power).find((each) => each >= least * 0.999) ?? 10 * power;
    const found = [], digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    for (let k = Math.ceil(frame.from / step - 1e-6); k * step <= frame.to + step * 1e-6; k += 1)
      found.push([(k * step - frame.from) / span, (k * step).toFixed(digits)]);
    return found;
  }

  function ready(canvas, width, height) {
    const dots = window.devicePixelRatio || 1;
    if (canvas.width !== Math.round(width * dots) || canvas.height !== Math.round(height * dots)) {
      canvas.width = Math.round(width * dots);
      canvas.height = Math.round(height * dots);
      canvas.style.width = `${width}px`;
      canvas.style.height = `${height}px`;
    }
    const pen = canvas.getContext("2d");
    pen.setTransform(dots, 0, 0, dots, 0, 0);
    pen.clearRect(0, 0, width, height);
    return pen;
  }

  function upright(pen, at, size, { well }, colour, dash, name, side = 4) {
    if (at === null) return;
    const x = Math.round(at * size.width) + 0.5;
    pen.strokeStyle = colour;
    pen.lineWidth = name.length > 1 ? 2 : 1;
    pen.setLineDash(dash);
    pen.beginPath();
    pen.moveTo(x, 0);
    pen.lineTo(x, size.height);
    pen.stroke();
    pen.setLineDash([]);
    pen.font = "500 12px Roboto, sans-serif";
    pen.textBaseline = "top";
    const wide = pen.measureText(name).width, left = x + side + wide > size.width ? x - side - wide : x + side;
    pen.fillStyle = well;  // no curve crosses the words
    pen.fillRect(left - 2, 1, wide + 4, 14);
    pen.fillStyle = colour;
    pen.fillText(name, left, 2);
  }

  // Writes names, ranges and values left of the lanes.
  function names(box, frame, places) {
    const shape = String(places.map((place, n) => [...place, frame.signals[n].range !== ""]));
    if (box.dataset.shape !== shape) box.replaceChildren();  // lanes of other heights are new ones: no name slides
    box.dataset.shape = shape;
    while (box.children.length < frame.signals.length) {
      const row = made("li", "", box), told = made("span", "scope-name", row);
      made("span", "scope-name-first", told); made("small", "quiet scope-note", told); made("small", "quiet scope-range", told);
      made("b", "scope-now", row); made("small", "quiet scope-unit", row);
    }
    frame.signals.forEach((signal, n) => {
      const row = box.children[n], [first, note, range] = row.firstChild.children;
      row.style.height = `${places[n][1]}px`;
      row.style.transform = `translateY(${places[n][0]}px)`;
      row.classList.toggle("folded", signal.folded);
      row.title = signal.name;
      write(first, signal.title); write(note, signal.note); write(range, signal.folded || places[n][1] < LEAST ? "" : signal.range);
      first.style.color = frame.lanes ? "" : (theme ? DARK : COLOURS)[n % COLOURS.length];
      write(row.children[1], signal.now); write(row.children[2], signal.unit);
    });
  }

  // Leaves folded what is folded, so that no lane moves under the pointer.
  function keep(frame, before) {
    const was = Object.fromEntries((before?.signals ?? []).map(({ name, folded }) => [name, folded]));
    for (const signal of frame.signals) signal.folded = was[signal.name] ?? signal.folded;
  }

  function draw(id, frame) {
    const plot = document.getElementById(`c${id}`), area = plot?.querySelector(".scope-area"), before = last;
    last = frame;
    if (!area) return;
    const tint = tokens(plot), width = area.clientWidth, room = plot.clientHeight - AXIS;
    if (width < 1 || room < 1) return;
    if (plot.matches(":hover")) keep(frame, before);
    const places = lanes(frame, room), height = Math.max(room, ...places.map(([top, high]) => top + high));
    plot.querySelector(".scope-names").style.minHeight = `${height}px`;
    const size = { width, height }, pen = ready(area.querySelector("canvas"), width, height);
    names(plot.querySelector(".scope-names"), frame, places);
    const marks = times(frame, width);
    pen.strokeStyle = tint.line;
    pen.lineWidth = 1;
    pen.beginPath();
    for (const [at] of marks) { pen.moveTo(Math.round(at * width) + 0.5, 0); pen.lineTo(Math.round(at * width) + 0.5, height); }
    if (frame.lanes) for (const [top, high] of places) { pen.moveTo(0, Math.round(top + high) - 0.5); pen.lineTo(width, Math.round(top + high) - 0.5); }
    pen.stroke();
    frame.signals.forEach((signal, n) => {
      const place = frame.lanes ? places[n] : [0, height];
      if (!signal.text) curve(pen, signal, n, place, size, tint);
      if (!signal.folded) texts(pen, signal, frame.lanes ? place : places[n], size, tint);
    });
    for (const [at, text] of frame.alarms) upright(pen, at, size, tint, tint.alarm, [], text, 8);
    upright(pen, frame.cursors[0], size, tint, tint.act, [], "A");
    upright(pen, frame.cursors[1], size, tint, tint.act, [6, 3], "B");
    upright(pen, frame.trigger, size, tint, tint["ink-2"], [2, 2], "T");
    if (frame.now < 1) upright(pen, frame.now, size, tint, tint.act, [], "");
    axis(plot, frame, marks, width, tint);
    write(plot.querySelector(".scope-hush"), frame.hush);
  }

  function axis(plot, frame, marks, width, tint) {
    const pen = ready(plot.querySelector(".scope-axis"), width, AXIS);
    pen.fillStyle = tint["ink-2"];
    pen.font = "12px Roboto, sans-serif";
    pen.textBaseline = "middle";
    pen.textAlign = "center";
    const unit = pen.measureText(frame.axis).width + 8;
    for (const [at, text] of marks) {
      const half = pen.measureText(text).width / 2, x = at * width;
      if (x > half && x + half < width - unit) pen.fillText(text, x, AXIS / 2);
    }
    pen.textAlign = "right";
    pen.fillText(frame.axis, width - 4, AXIS / 2);
  }

  // Returns the number of the lane at a height in pixels.
  function laneAt(plot, y) {
    const places = lanes(last, plot.clientHeight - AXIS);
    return Math.max(places.filter(([top]) => top <= y).length - 1, 0);
  }

  // Input of the user

  function attach(id) {
    const plot = document.getElementById(`c${id}`);
    if (!plot) {
      setTimeout(() => attach(id), 50);
      return;
    }
    const body = made("div", "scope-body", plot), list = made("ul", "scope-names", body), area = made("div", "scope-area", body);
    made("canvas", "", area);
    made("div", "scope-hush quiet", area);
    made("canvas", "scope-axis", plot);
    reordered(list);
    theme = null;
    const fingers = new Map();
    let began = null, moved = 0, held = "", apart = 0, factor = 1, shift = 0, at = 0.5, asked = 0, row = null;
    const width = () => Math.max(area.clientWidth, 1);
    const place = (event) => Math.min(Math.max((event.clientX - area.getBoundingClientRect().left) / width(), 0), 1);
    // Returns the number of the lane under the pointer; null while the signals are overlaid.
    const under = (event) => (last?.lanes ? laneAt(plot, event.clientY - area.getBoundingClientRect().top) : null);
    const later = () => {  // at most one message per frame of the browser
      asked = asked || requestAnimationFrame(() => {
        if (factor !== 1) tell({ do: "zoom", factor, place: at });
        if (shift !== 0) tell({ do: held ? "drag" : "pan", which: held, part: shift, place: at, lane: row });
        [factor, shift, asked] = [1, 0, 0];
      });
    };
    new ResizeObserver(() => {
      tell({ do: "size", pixels: width() });
      if (last) draw(id, last);
    }).observe(plot);
    new MutationObserver(() => { theme = null; if (last) draw(id, last); }).observe(document.body, { attributeFilter: ["class"] });
    new IntersectionObserver((seen) => tell({ do: "seen", seen: seen[seen.length - 1].isIntersecting }),
      { rootMargin: "800px" }).observe(plot);

    area.addEventListener("wheel", (event) => {
      event.preventDefault();
      at = place(event);
      if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY)) shift += (event.deltaX || event.deltaY) / width();
      else factor *= 1.0015 ** Math.max(-400, Math.min(400, event.deltaY * (event.deltaMode ? 30 : 1)));
      later();
    }, { passive: false });

    area.addEventListener("pointerdown", (event) => {
      area.setPointerCapture(event.pointerId);
      fingers.set(event.pointerId, event);
      began = event.clientX;
      moved = 0;
      held = fingers.size > 1 ? "" : near(place(event));
      apart = distance();
    });
    area.addEventListener("pointermove", (event) => {
      const before = fingers.get(event.pointerId);
      if (!before) {
        hover(place(event));
        return;
      }
      fingers.set(event.pointerId, event);
      at = place(event);
      row = under(event);
      if (fingers.size > 1) {
        const now = distance();
        factor *= now > 0 && apart > 0 ? apart / now : 1;
        [apart, moved] = [now, CLICK + 1];
        later();
      } else if ((moved = Math.max(moved, Math.abs(event.clientX - began))) > CLICK) {
        shift += (before.clientX - event.clientX) / width();
        later();
      }
    });
    const release = (event) => {
      if (fingers.delete(event.pointerId) && event.type === "pointerup" && moved <= CLICK)
        tell({ do: "click", place: place(event), other: event.shiftKey, lane: under(event) });
      if (!fingers.size) setTimeout(() => { held = ""; }, 60);
    };
    area.addEventListener("pointerup", release);
    area.addEventListener("pointercancel", release);
    plot.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || !KEYS.has(event.key)) return;
      event.preventDefault();
      tell({ do: "key", key: event.key, shift: event.shiftKey, alt: event.altKey });
    });

    let pointed = null, pointing = 0;
    function hover(where) {  // at most ten messages in a second
      pointed = where;
      pointing = pointing || setTimeout(() => { pointing = 0; tell({ do: "hover", place: pointed }); }, 100);
    }
    area.addEventListener("pointerleave", () => hover(null));

    function distance() {
      const [one, other] = [...fingers.values()];
      return other ? Math.abs(one.clientX - other.clientX) : 0;
    }
    function near(where) {
      const found = (last?.cursors ?? []).findIndex((cursor) => cursor !== null && Math.abs(cursor - where) * width() < NEAR);
      return ["a", "b"][found] ?? "";
    }
  }

  // Lets the user drag lanes by their names.
  function reordered(list) {
    let lane = null;
    const row = (event) => [...list.children].findIndex((each) => {
      const { top, bottom } = each.getBoundingClientRect();
      return event.clientY >= top && event.clientY < bottom;
    });
    list.addEventListener("pointerdown", (event) => { lane = row(event); list.setPointerCapture(event.pointerId); });
    list.addEventListener("pointerup", (event) => {
      const to = row(event);
      if (lane !== null && lane >= 0 && to >= 0 && to !== lane) tell({ do: "lane", lane, to });
      lane = null;
    });
  }
  const KEYS = new Set(["+", "-", "=", "ArrowLeft", "ArrowRight", "a", "b", "A", "B", ",", ".", "<", ">", " ", "Home", "Escape", "l", "n", "p"]);

  return { draw, attach };
})();
