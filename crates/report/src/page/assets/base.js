// What all parts of the page share: the data unpacked, colours of the style sheet, and the time that
// is chosen.
const $ = (id) => document.getElementById(id);
const data = JSON.parse($("data").textContent);

function bytes(text) {
  const raw = atob(text), out = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) out[i] = raw.charCodeAt(i);
  return out.buffer;
}

// 16 bits each, times a step; the lowest stands for no value.
function unpack(packed) {
  const steps = new Int16Array(bytes(packed.b)), out = new Float32Array(steps.length);
  for (let i = 0; i < steps.length; i++) out[i] = steps[i] === -32768 ? NaN : steps[i] * packed.step;
  return out;
}

const path = (() => {
  const p = data.path, n = p.n, at = new Float32Array(3 * n);
  const steps = new Uint16Array(bytes(p.at));
  for (let i = 0; i < 3 * n; i++) at[i] = p.low[i % 3] + steps[i] * p.step[i % 3];
  const ticks = new Uint32Array(bytes(p.t)), time = new Float64Array(n);
  for (let i = 0; i < n; i++) time[i] = ticks[i] * p.time_step;
  const runs = [], last = [0, 0, 0];
  for (let i = 0; i < p.lines.length; i += 3) {
    for (let k = 0; k < 3; k++) last[k] += p.lines[i + k];
    runs.push([last[0], last[1], last[2]]);
  }
  return {
    n, at, time, runs, low: p.low, high: p.low.map((low, k) => low + 65535 * p.step[k]),
    normal: new Int8Array(bytes(p.normal)), kind: new Uint8Array(bytes(p.kind)),
    tool: p.tool && new Int8Array(bytes(p.tool)), speed: unpack(p.speed), limiter: new Uint8Array(bytes(p.limiter)), error: p.error.map(unpack),
  };
})();

// Index of the last value that is not above one; values rise.
function indexAt(values, value, count = values.length, of = (v) => v) {
  let low = 0, high = count - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (of(values[middle]) <= value) low = middle; else high = middle - 1;
  }
  return low;
}
const stretchAt = (time) => indexAt(path.time, time, Math.max(path.n - 1, 1));
const runOf = (stretch) => path.runs[indexAt(path.runs, stretch, path.runs.length, (run) => run[2])];

const BOUNDS = [-1, -0.6, -0.3, -0.1, 0.1, 0.3, 0.6, 1];
// What was not reached is grey.
const hueOf = (um) => Number.isNaN(um) ? 4 : BOUNDS.filter((bound) => um / data.tolerance >= bound).length;
// What limits the motion, by number; a colour for each kind.
const limits = new Map(data.limits.every.map((limit) => [limit.limiter, limit]));
const KINDS = ["feed", "velocity", "acceleration", "jerk", "tolerance", "look-ahead"];
const kindOf = (limiter) => limits.has(limiter) ? (KINDS.indexOf(limits.get(limiter).name.split(" ")[0]) + 7) % 7 : 6;
const percent = (share) => share < 0.001 ? "below 0.1 %" : `${(100 * share).toFixed(share < 0.1 ? 1 : 0)} %`;
let colors = {};
function readColors() {
  const style = getComputedStyle(document.documentElement);
  const names = ["ground", "raised", "ink", "soft", "line", "link", "good", "bad"];
  colors = Object.fromEntries(names.map((name) => [name, style.getPropertyValue("--" + name).trim()]));
  colors.kinds = KINDS.concat("").map((_, kind) => style.getPropertyValue("--k" + kind).trim());
  colors.error = BOUNDS.concat(0).map((_, hue) => style.getPropertyValue("--e" + hue).trim());
}
function rgb(color) {
  const value = parseInt(color.slice(1), 16);
  return [(value >> 16 & 255) / 255, (value >> 8 & 255) / 255, (value & 255) / 255];
}
// Light to dark of one hue, for what has no sign.
function ramp(part) {
  const from = rgb(colors.line), to = rgb(colors.error[1]);
  const t = Math.min(Math.max(part, 0), 1);
  return from.map((c, k) => c + t * (to[k] - c));
}

const signed = (um) => (um > 0 ? "+" : um < 0 ? "\u2212" : "") + digits(Math.abs(um));
const digits = (value) => value >= 1e6 ? value.toExponential(2) : value >= 100 ? value.toFixed(0) : value >= 10 ? value.toFixed(1) : value.toFixed(2);
const clock = (s) => s < 120 ? s.toFixed(3) + " s" : Math.floor(s / 60) + " min " + (s % 60).toFixed(2) + " s";

// What is chosen: a time and a method. Everyone who shows it is told.
const chosen = { time: data.duration, method: data.main, followers: [] };
function choose(change, from) {
  Object.assign(chosen, change);
  if ("time" in change) chosen.upTo = from === "slider" ? change.time : undefined;
  chosen.time = Math.min(Math.max(chosen.time, 0), data.duration);
  for (const tell of chosen.followers) tell(change, from);
}
function element(name, text, attributes = {}) {
  const made = document.createElement(name);
  if (text !== undefined) made.textContent = text;
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  return made;
}
const SVG = "http://www.w3.org/2000/svg";
function drawn(name, attributes, text) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text !== undefined) made.textContent = text;
  return made;
}
