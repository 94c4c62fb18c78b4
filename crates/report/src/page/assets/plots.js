// Plots over time with the extremes of every column, the histogram, and polar plots of circles.
const plots = (() => {
  const range = { from: 0, to: data.duration };
  const MARGIN = { left: 62, right: 12, top: 8, bottom: 24 };
  const NOTES = {
    error: "Reference minus load, the interpolator's delay taken out. It grows with speed where feed-forward is too small; a step after a reversal is the gap.",
    current: "Torque-forming current. Flat tops are the drive's limit: lower acceleration or jerk of this axis.",
    torque: "Motor torque: friction as steps at reversals, inertia as ramps.",
    speed: "Speed of the reference. Zero crossings are reversals; the worst errors mostly follow them.",
    "lost motion": "Motor minus load: it jumps by the gap when the axis reverses, and bends with torque by wind-up. The height of the jump is what to enter as backlash.",
    engagement: "+1 and \u22121: the flank in contact; 0: inside the gap, where nothing holds the load.",
    reference: "Where the axis is commanded to be.",
    motor: "Where the motor is, at the load's side of the transmission.",
    load: "Where the load is, and with it the tool.",
    "gap estimate": "What the method holds the gap to be, as it was known when each part began; nothing until readings of it agree. Compare it with the gap of the axis: a method that knows it to a few per cent corrects well.",
  };
  const UNITS = { current: "A", torque: "N m", engagement: "" };

  function ticks(low, high, count) {
    const raw = (high - low) / count;
    if (!(raw > 0)) return [low];
    const ten = 10 ** Math.floor(Math.log10(raw)), step = [1, 2, 5, 10].map((d) => d * ten).find((s) => s >= raw);
    const out = [];
    for (let k = Math.ceil(low / step); k * step <= high + 1e-9 * step; k++) out.push(k * step);
    return out.map((value) => [value, value.toFixed(Math.max(0, -Math.floor(Math.log10(step) + 1e-9)))]);
  }
  function prepare(canvas) {
    const ratio = window.devicePixelRatio || 1, [w, h] = [canvas.clientWidth, canvas.clientHeight];
    canvas.width = Math.round(w * ratio);
    canvas.height = Math.round(h * ratio);
    const pen = canvas.getContext("2d");
    pen.scale(ratio, ratio);
    pen.font = "12px system-ui, 'DejaVu Sans', sans-serif";
    pen.clearRect(0, 0, w, h);
    return { pen, w, h, x0: MARGIN.left, x1: w - MARGIN.right, y0: MARGIN.top, y1: h - MARGIN.bottom };
  }
  function frame({ pen, x0, x1, y0, y1 }, [low, high], [bottom, top], unit, across) {
    const px = (t) => x0 + (t - low) / (high - low) * (x1 - x0), py = (v) => y1 - (v - bottom) / (top - bottom) * (y1 - y0);
    pen.strokeStyle = colors.line;
    pen.fillStyle = colors.soft;
    pen.lineWidth = 1;
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const [value, text] of ticks(bottom, top, 4)) {
      pen.beginPath(); pen.moveTo(x0, py(value)); pen.lineTo(x1, py(value)); pen.stroke();
      pen.fillText(text, x0 - 6, py(value));
    }
    pen.textAlign = "center";
    pen.textBaseline = "top";
    for (const [value, text] of ticks(low, high, Math.max((x1 - x0) / 110, 2))) if (px(value) < x1 - 30) pen.fillText(text, px(value), y1 + 6);
    pen.textAlign = "right";
    pen.fillText(across, x1, y1 + 6);
    pen.textAlign = "left";
    if (unit) { pen.textBaseline = "top"; pen.fillText(unit, 4, y0 - 4); }
    return { px, py };
  }
  function band(low, high) {
    let [bottom, top] = [Infinity, -Infinity];
    for (const value of low) if (value < bottom) bottom = value;
    for (const value of high) if (value > top) top = value;
    if (!(top >= bottom)) [bottom, top] = [-1, 1];
    const pad = 0.08 * (top - bottom) || Math.abs(top) * 0.1 || 1;
    return [bottom - pad, top + pad];
  }
  // Columns of a pixel, each from the smallest to the largest value in its time.
  function columns(area, { px, py }, low, high, part, color) {
    const { pen, x0, x1 } = area;
    pen.fillStyle = color;
    pen.save();
    pen.beginPath(); pen.rect(x0, area.y0 - 2, x1 - x0, area.y1 - area.y0 + 4); pen.clip();
    let last = null;
    for (let k = 0; k < low.length; k++) {
      if (Number.isNaN(low[k])) { last = null; continue; }
      const [a, b] = [px(k * part), px((k + 1) * part)];
      if (b < x0 || a > x1) { last = [low[k], high[k]]; continue; }
      // Touches its neighbour, so that steps are seen as lines.
      const from = last ? Math.min(low[k], last[1]) : low[k], to = last ? Math.max(high[k], last[0]) : high[k];
      pen.fillRect(a, py(to) - 0.6, Math.max(b - a, 1.2), py(from) - py(to) + 1.2);
      last = [low[k], high[k]];
    }
    pen.restore();
  }
  function cursor({ pen, y0, y1, x0, x1 }, { px }) {
    const x = px(chosen.time);
    if (x < x0 - 1 || x > x1 + 1) return;
    pen.strokeStyle = colors.ink;
    pen.setLineDash([2, 2]);
    pen.beginPath(); pen.moveTo(x, y0); pen.lineTo(x, y1); pen.stroke();
    pen.setLineDash([]);
  }
  const cache = new Map();
  const ends = (key, packed) => {
    if (!cache.has(key)) cache.set(key, [unpack(packed.low), unpack(packed.high)]);
    return cache.get(key);
  };
  function visible(values, part) {
    return values.subarray(Math.max(Math.floor(range.from / part), 0), Math.ceil(range.to / part) + 1);
  }
  function error() {
    const area = prepare($("errorplot")), method = data.methods[chosen.method], part = method.error.ticks * data.tick;
    const [low, high] = ends("e" + chosen.method, method.error.ends);
    let [bottom, top] = band(visible(low, part), visible(high, part));
    if (Math.max(-bottom, top) > 0.4 * data.tolerance) [bottom, top] = [Math.min(bottom, -1.1 * data.tolerance), Math.max(top, 1.1 * data.tolerance)];
    const scale = frame(area, [range.from, range.to], [bottom, top], "\u00b5m", "s");
    columns(area, scale, low, high, part, colors.error[1]);
    const { pen, x0, x1 } = area;
    pen.strokeStyle = colors.bad;
    pen.setLineDash([6, 4]);
    for (const limit of [-data.tolerance, data.tolerance]) if (limit > bottom && limit < top) { pen.beginPath(); pen.moveTo(x0, scale.py(limit)); pen.lineTo(x1, scale.py(limit)); pen.stroke(); }
    pen.setLineDash([]);
    // The worst places are pinned.
    pen.fillStyle = colors.error[8];
    pen.textAlign = "center";
    pen.textBaseline = "bottom";
    let taken = [];
    for (const block of method.worst) {
      const x = scale.px(block.t), y = scale.py(block.um);
      if (x < x0 || x > x1) continue;
      pen.beginPath(); pen.arc(x, y, 3.5, 0, 7); pen.fill();
      if (taken.every((other) => Math.abs(other - x) > 44)) {
        const up = block.um > 0 ? Math.max(y - 6, 14) : Math.min(y + 18, area.y1);
        pen.fillText("line " + block.line, Math.min(Math.max(x, x0 + 24), x1 - 24), up);
        taken.push(x);
      }
    }
    cursor(area, scale);
  }
  function signal() {
    const method = data.methods[chosen.method], motor = method.motors[Number($("axis").value)];
    const which = Number($("signal").value), name = data.signals[which];
    if (!motor || !motor.signals[which]) return;
    const small = name === "error" || name === "lost motion" || name === "gap estimate";
    const unit = name in UNITS ? UNITS[name] : small ? (motor.unit === "mm" ? "\u00b5m" : "m" + motor.unit) : motor.unit + (name === "speed" ? "/s" : "");
    let [low, high] = ends(`m${chosen.method}/${$("axis").value}/${which}`, motor.signals[which]);
    if (small) [low, high] = [low, high].map((values) => values.map((value) => 1000 * value));
    const area = prepare($("signalplot")), part = motor.ticks * data.tick;
    const scale = frame(area, [range.from, range.to], band(visible(low, part), visible(high, part)), unit, "s");
    columns(area, scale, low, high, part, colors.error[6]);
    cursor(area, scale);
    $("signalname").textContent = `${motor.name}: ${name === "error" ? "following error" : name}`;
    $("signalnote").textContent = NOTES[name];
  }
  // A row for each limit, as dark as the part of the time that it has.
  const ROW = 30, MOST_ROWS = 10;
  function limited() {
    const every = data.limits.every.slice(0, MOST_ROWS), canvas = $("limitplot");
    canvas.style.height = `${MARGIN.top + ROW * every.length + MARGIN.bottom}px`;
    const area = prepare(canvas), { pen, x0, x1, y0, y1 } = area, part = data.limits.ticks * data.tick;
    const px = (t) => x0 + (t - range.from) / (range.to - range.from) * (x1 - x0);
    every.forEach((limit, row) => {
      const y = y0 + ROW * row, parts = new Uint8Array(bytes(limit.parts));
      pen.fillStyle = colors.ink;
      pen.textAlign = "left";
      pen.textBaseline = "top";
      pen.fillText(`${limit.name}: ${percent(limit.share)}`, x0, y);
      pen.fillStyle = colors.raised;
      pen.fillRect(x0, y + 15, x1 - x0, ROW - 19);
      pen.fillStyle = colors.kinds[kindOf(limit.limiter)];
      // The largest share in each column of pixels, so that a short limit is seen.
      const columns = new Uint8Array(Math.max(Math.ceil(x1 - x0), 0));
      for (let k = 0; k < parts.length; k++) if (parts[k]) {
        const from = Math.max(Math.floor(px(k * part) - x0), 0), to = Math.min(Math.max(Math.ceil(px((k + 1) * part) - x0), from + 1), columns.length);
        for (let x = from; x < to; x++) columns[x] = Math.max(columns[x], parts[k]);
      }
      columns.forEach((share, x) => {
        if (!share) return;
        pen.globalAlpha = 0.2 + 0.8 * share / 255;
        pen.fillRect(x0 + x, y + 15, 1, ROW - 19);
      });
      pen.globalAlpha = 1;
    });
    pen.fillStyle = colors.soft;
    pen.textAlign = "center";
    pen.textBaseline = "top";
    for (const [value, text] of ticks(range.from, range.to, Math.max((x1 - x0) / 110, 2))) if (px(value) < x1 - 30) pen.fillText(text, px(value), y1 + 6);
    pen.textAlign = "right";
    pen.fillText("s", x1, y1 + 6);
    cursor(area, { px });
  }
  function histogram() {
    const method = data.methods[chosen.method], { width, counts } = method.histogram, half = counts.length / 2;
    const whole = counts.reduce((a, b) => a + b, 0), area = prepare($("histogram"));
    let reach = 1;
    counts.forEach((count, k) => { if (count) reach = Math.max(reach, k < half ? half - k : k + 1 - half); });
    const bound = Math.max(reach * width, 0.2 * data.tolerance);
    const most = counts.reduce((a, b) => Math.max(a, b), 0) / Math.max(whole, 1) * 100;
    const scale = frame(area, [-bound, bound], [0, 1.08 * most || 1], "%", "\u00b5m");
    counts.forEach((count, k) => {
      if (!count) return;
      const [a, b] = [scale.px((k - half) * width), scale.px((k + 1 - half) * width)];
      area.pen.fillStyle = colors.error[hueOf((k + 0.5 - half) * width)];
      const y = Math.min(scale.py(count / whole * 100), area.y1 - 1.5);
      area.pen.fillRect(a, y, Math.max(b - a - 0.5, 1), area.y1 - y);
    });
    const [p50, p95, p99, p999] = method.percentiles;
    $("percentiles").textContent = `Half of the time the error is below ${digits(p50)} \u00b5m, 95 % below ${digits(p95)}, 99 % below ${digits(p99)}, 99.9 % below ${digits(p999)}; the largest is ${digits(method.max)}. Two humps are the two flanks of a gap: compensate it. A long thin tail is a few places: see the list of the worst.`;
  }
  // Radial deviation of a circle, magnified, as on the sheet of a ballbar.
  function polar() {
    const box = $("polar");
    if (!box) return;
    box.replaceChildren();
    box.className = "polars";
    for (const circle of data.methods[chosen.method].circles) {
      const [low, high] = [unpack(circle.low), unpack(circle.high)];
      const largest = Math.max(...low.map((v) => Math.abs(v) || 0), ...high.map((v) => Math.abs(v) || 0), 1e-3);
      const raw = 0.32 * circle.r * 1000 / largest, ten = 10 ** Math.floor(Math.log10(raw));
      const times = [5, 2, 1].map((d) => d * ten).find((d) => d <= raw) || ten;
      const figure = element("figure"), svg = drawn("svg", { viewBox: "0 0 300 300", role: "img", "aria-label": `Polar plot of the circle in line ${circle.line}` });
      const radius = (um) => 100 * (1 + um * times / 1000 / circle.r);
      svg.append(drawn("path", { class: "grid", d: "M150 20V280M20 150H280" }));
      svg.append(drawn("circle", { class: "nominal", cx: 150, cy: 150, r: 100 }));
      if (data.tolerance * times / 1000 / circle.r < 0.45) for (const um of [-data.tolerance, data.tolerance]) svg.append(drawn("circle", { class: "limit", cx: 150, cy: 150, r: radius(um) }));
      const at = (k, um) => { const angle = (k + 0.5) / low.length * 2 * Math.PI; return `${(150 + radius(um) * Math.cos(angle)).toFixed(1)} ${(150 - radius(um) * Math.sin(angle)).toFixed(1)}`; };
      let d = "";
      low.forEach((_, k) => {
        if (Number.isNaN(low[k])) return;
        const [a, b] = Math.abs(low[k]) > Math.abs(high[k]) ? [high[k], low[k]] : [low[k], high[k]];
        d += (d ? "L" : "M") + at(k, a) + (b !== a ? "L" + at(k, b) : "");
      });
      svg.append(drawn("path", { class: "round", d: d + "Z" }));
      svg.append(drawn("text", { x: 282, y: 145, "text-anchor": "end" }, circle.axes[0] + "+"), drawn("text", { x: 156, y: 30 }, circle.axes[1] + "+"));
      svg.append(drawn("text", { x: 150, y: 146, "text-anchor": "middle" }, `${times}\u00d7`), drawn("text", { x: 150, y: 164, "text-anchor": "middle" }, `G ${digits(circle.g)} \u00b5m`));
      figure.append(element("figcaption", `line ${circle.line}, R ${+circle.r.toFixed(3)} mm, ${circle.ccw ? "ccw" : "cw"}`), svg);
      figure.append(element("p", `Deviations ${times} times; outwards is too large. Spikes on the axes are reversal spikes; steps there are lost motion; an oval at 45\u00b0 is servo mismatch.`, { class: "note" }));
      box.append(figure);
    }
  }
  function over() { error(); signal(); limited(); }
  function all() { over(); histogram(); polar(); }
  function zoom(by, at) {
    const whole = data.duration, span = Math.min(Math.max((range.to - range.from) * by, 50 * data.tick), whole);
    const part = (at - range.from) / (range.to - range.from);
    range.from = Math.min(Math.max(at - part * span, 0), whole - span);
    range.to = range.from + span;
    over();
  }
  for (const id of ["errorplot", "signalplot", "limitplot"]) {
    const canvas = $(id);
    const timeAt = (x) => range.from + (x - MARGIN.left) / (canvas.clientWidth - MARGIN.left - MARGIN.right) * (range.to - range.from);
    canvas.addEventListener("click", (event) => choose({ time: timeAt(event.offsetX) }, "plot"));
    canvas.addEventListener("wheel", (event) => {
      if (!event.ctrlKey && document.activeElement !== canvas) return;
      event.preventDefault();
      zoom(Math.exp(event.deltaY * 0.002), timeAt(event.offsetX));
    }, { passive: false });
    canvas.addEventListener("dblclick", (event) => zoom(0.3, timeAt(event.offsetX)));
    canvas.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (step) choose({ time: chosen.time + step * (range.to - range.from) / 100 }, "plot");
      else if (event.key === "+" || event.key === "=") zoom(0.7, chosen.time);
      else if (event.key === "-") zoom(1.4, chosen.time);
      else return;
      event.preventDefault();
    });
  }
  $("whole").addEventListener("click", () => { range.from = 0; range.to = data.duration; over(); });
  new ResizeObserver(() => { over(); histogram(); }).observe($("errorplot"));
  return { over, all, signal, range };
})();
