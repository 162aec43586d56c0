// The plot of the oscilloscope: draws the messages of the server, and sends messages about mouse, fingers and keys.
window.axistwinScope = (() => {
  const FULL = 65535, TOP = 4000, LEFT = 10, RIGHT = 12, ABOVE = 6, LINE = 15, FOLDED = 0.36, COLUMN = 420, NAMES = 160, BELOW = 40, NEAR = 9, CLICK = 4;
  const COLOURS = ["#0072B2", "#BB4E00", "#00805D", "#B04C86", "#8A6000", "#2F79A3"], DASHES = ["solid", "dashed", "dotted"];
  const INK = "#1c2430", RULE = "#d5dae1", CURSORS = ["#2457c5", "#8a2be2"], TRIGGER = "#d0342c";
  let last = null, shape = "", waiting = 0, columns = 1;

  const tell = (what) => emitEvent("scope", what);

  function pairs(text) {
    const bytes = Uint8Array.from(atob(text), (sign) => sign.charCodeAt(0));
    return new Uint16Array(bytes.buffer);
  }

  // Returns the line of a signal in pixels: a list of points for each period in which the value is known.
  function stretches(signal, [base, height], count, area) {
    const data = pairs(signal.data), found = [];
    const wide = area.width / FULL, bottom = area.y + area.height * (1 - base / count), high = (area.height * height) / count / TOP;
    let steps = null, before = 0;
    for (let n = 0; n < data.length; n += 2) {
      const x = area.x + data[n] * wide, unknown = data[n + 1] === FULL, y = bottom - data[n + 1] * high;
      if (steps) steps.push([x, before]);
      if (unknown) steps = null;
      else if (!steps) found.push((steps = [[x, y]]));
      else if (y !== before) steps.push([x, y]);
      before = y;
    }
    return found;
  }

  function drawn(params) {
    const n = params.dataIndex, signal = last.signals[n], count = total(last);
    const style = { fill: "none", stroke: COLOURS[n % COLOURS.length], lineWidth: 1.4,
      lineDash: last.lanes ? "solid" : DASHES[Math.floor(n / 2) % 3] };
    const lines = signal ? stretches(signal, lanes(last)[n], count, params.coordSys) : [];
    return { type: "group", silent: true, children: lines.map((points) => (
      { type: "polyline", silent: true, shape: { points }, style })) };
  }

  const weight = (signal) => (signal.folded ? FOLDED : 1);
  const total = (frame) => frame.signals.reduce((sum, signal) => sum + weight(signal), 0);

  // Returns the upper edge of each lane, from the bottom of the plot, in lanes of normal height.
  function tops(frame) {
    let above = total(frame);
    return frame.signals.map((signal) => { const top = above; above -= weight(signal); return top; });
  }

  // Returns the base and the height of each curve.
  function lanes(frame) {
    const count = total(frame), upper = tops(frame);
    return frame.signals.map((signal, n) => {
      if (!frame.lanes) return [0.04 * count, 0.9 * count];
      return signal.folded ? [upper[n] - FOLDED + 0.04, 0.08] : [upper[n] - 0.92, 0.66];
    });
  }

  // Returns the number of the lane at a height in pixels.
  function laneAt(y, high) {
    const up = (1 - (y - ABOVE) / Math.max(high - ABOVE - BELOW, 1)) * total(last), upper = tops(last);
    return Math.max(upper.filter((top) => top >= up).length - 1, 0);
  }

  function label(signal) {
    return signal.range === "" || signal.folded ? signal.title : `${signal.title}   ${signal.range}`;
  }

  function series(frame) {
    const places = lanes(frame), upper = tops(frame), count = total(frame), width = frame.to - frame.from;
    const lines = { data: frame.signals.map(() => [frame.from, 0]) };
    const names = !frame.lanes ? [] : frame.signals.map((signal, n) => ({
      value: [frame.from, upper[n] - (signal.folded ? 0.18 : 0.14)], name: label(signal), label: { color: COLOURS[n % COLOURS.length] },
    }));
    const words = frame.signals.flatMap((signal, n) => (signal.folded ? [] : signal.words).map(([at, text]) => (
      { value: [frame.from + at * width, places[n][0] + places[n][1] / 2], name: text })));
    const upright = (place) => (place === null ? [] : [[frame.from + place * width, 0], [frame.from + place * width, count]]);
    return [lines, { data: names }, { data: words }, ...frame.cursors.map((at) => ({ data: upright(at) })),
      { data: upright(frame.trigger) }];
  }

  function looks() {
    const lines = { type: "custom", silent: true, clip: true, renderItem: drawn, z: 3 };
    const text = { type: "scatter", silent: true, symbol: "rect", clip: true };
    const names = { ...text, symbolSize: 0.1, z: 5, label: { show: true, position: "right", distance: 2, formatter: "{b}",
      fontSize: 11, fontWeight: 600, backgroundColor: "rgba(255,255,255,.8)", padding: [1, 3] } };
    const words = { ...text, symbolSize: [2, 12], itemStyle: { color: INK }, z: 4, labelLayout: { hideOverlap: true },
      label: { show: true, position: "right", distance: 2, formatter: "{b}", color: INK, fontSize: 11, fontFamily: "monospace",
        width: 150, overflow: "truncate" } };
    const upright = (name, color, type) => ({ type: "line", silent: true, symbol: "none", showSymbol: false, z: 6,
      lineStyle: { color, type, width: 1.4 }, endLabel: { show: true, formatter: name, color, fontWeight: 700, distance: -14, offset: [14, 8] } });
    return [lines, names, words, upright("A", CURSORS[0], "solid"), upright("B", CURSORS[1], "dashed"), upright("T", TRIGGER, "dotted")];
  }

  // Returns the number of lines of the legend.
  const legendLines = (frame) => Math.ceil(frame.signals.length / columns);

  // Returns the legend of overlaid signals, in columns above the curves.
  function legend(frame) {
    return frame.lanes ? [] : frame.signals.map((signal, n) => (
      { id: `name${n}`, type: "text", silent: true, left: LEFT + COLUMN * Math.floor(n / legendLines(frame)),
        top: 2 + LINE * (n % legendLines(frame)), style: { text: label(signal),
        fill: COLOURS[n % COLOURS.length], font: "600 11px sans-serif" } }));
  }

  function options(frame) {
    const above = frame.lanes ? ABOVE : ABOVE + LINE * legendLines(frame);
    return {
      animation: false, grid: { left: LEFT, right: RIGHT, top: above, bottom: BELOW },
      xAxis: { type: "value", nameLocation: "middle", nameGap: 24, axisLine: { lineStyle: { color: INK } },
        axisLabel: { hideOverlap: true, showMinLabel: false, showMaxLabel: false }, splitLine: { lineStyle: { color: RULE } } },
      yAxis: { type: "value", interval: 1, axisLabel: { show: false }, axisTick: { show: false },
        splitLine: { show: frame.lanes && !frame.signals.some((signal) => signal.folded), lineStyle: { color: RULE } } },
      series: looks(),
    };
  }

  function draw(id, frame) {
    last = frame;
    const chart = getElement(id)?.chart;
    clearTimeout(waiting);
    if (!chart) {
      waiting = setTimeout(() => draw(id, last), 50);
      return;
    }
    columns = Math.max(Math.floor(chart.getWidth() / COLUMN), 1);
    const now = JSON.stringify([id, frame.lanes, columns, frame.signals.map((signal) => [signal.name, signal.folded])]);
    if (shape !== now) chart.setOption(options(frame), { notMerge: true });
    shape = now;
    chart.setOption({
      xAxis: { min: frame.from, max: frame.to, name: frame.axis }, yAxis: { min: 0, max: Math.max(total(frame), 1) },
      series: series(frame), graphic: legend(frame),
    });
  }

  // Input of the user

  function attach(id) {
    const plot = document.getElementById(`c${id}`);
    if (!plot) {
      setTimeout(() => attach(id), 50);
      return;
    }
    const fingers = new Map();
    let lane = null, began = null, moved = 0, held = "", apart = 0, factor = 1, shift = 0, at = 0.5, asked = 0, row = null;
    const width = () => Math.max(plot.clientWidth - LEFT - RIGHT, 1);
    const place = (event) => Math.min(Math.max((event.clientX - plot.getBoundingClientRect().left - LEFT) / width(), 0), 1);
    // Returns the number of the lane under the pointer; null while the signals are overlaid.
    const under = (event) => (last?.lanes ? laneAt(event.clientY - plot.getBoundingClientRect().top, plot.clientHeight) : null);
    const later = () => {  // at most one message per frame of the browser
      asked = asked || requestAnimationFrame(() => {
        if (factor !== 1) tell({ do: "zoom", factor, place: at });
        if (shift !== 0) tell({ do: held ? "drag" : "pan", which: held, part: shift, place: at, lane: row });
        [factor, shift, asked] = [1, 0, 0];
      });
    };
    new ResizeObserver(() => tell({ do: "size", pixels: width() })).observe(plot);
    new IntersectionObserver((seen) => tell({ do: "seen", seen: seen[seen.length - 1].isIntersecting }),
      { rootMargin: "800px" }).observe(plot);

    plot.addEventListener("wheel", (event) => {
      event.preventDefault();
      at = place(event);
      if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY)) shift += (event.deltaX || event.deltaY) / width();
      else factor *= 1.0015 ** Math.max(-400, Math.min(400, event.deltaY * (event.deltaMode ? 30 : 1)));
      later();
    }, { passive: false });

    plot.addEventListener("pointerdown", (event) => {
      plot.setPointerCapture(event.pointerId);
      fingers.set(event.pointerId, event);
      began = event.clientX;
      moved = 0;
      held = fingers.size > 1 ? "" : near(place(event));
      const where = event.clientY - plot.getBoundingClientRect().top;
      lane = last?.lanes && fingers.size === 1 && event.clientX - plot.getBoundingClientRect().left < NAMES
        ? [laneAt(where, plot.clientHeight), event.clientY] : null;
      apart = distance();
    });
    plot.addEventListener("pointermove", (event) => {
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
      const high = event.clientY - plot.getBoundingClientRect().top;
      if (lane && event.type === "pointerup" && moved <= CLICK && Math.abs(event.clientY - lane[1]) > 2 * CLICK) {
        tell({ do: "lane", lane: lane[0], to: laneAt(high, plot.clientHeight) });
        moved = CLICK + 1;
      }
      lane = null;
      if (fingers.delete(event.pointerId) && event.type === "pointerup" && moved <= CLICK)
        tell({ do: "click", place: place(event), other: event.shiftKey, lane: under(event) });
      if (!fingers.size) setTimeout(() => { held = ""; }, 60);
    };
    plot.addEventListener("pointerup", release);
    plot.addEventListener("pointercancel", release);
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
    plot.addEventListener("pointerleave", () => hover(null));

    function distance() {
      const [one, other] = [...fingers.values()];
      return other ? Math.abs(one.clientX - other.clientX) : 0;
    }
    function near(where) {
      const found = (last?.cursors ?? []).findIndex((cursor) => cursor !== null && Math.abs(cursor - where) * width() < NEAR);
      return ["a", "b"][found] ?? "";
    }
  }
  const KEYS = new Set(["+", "-", "=", "ArrowLeft", "ArrowRight", "a", "b", "A", "B", ",", ".", "<", ">", " ", "Home", "Escape", "l", "n", "p"]);

  return { draw, attach };
})();
