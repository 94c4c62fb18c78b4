// Operations and levels of Z that are switched on and off: which stretches of the path are shown.
const parts = (() => {
  const n = path.n, operation = new Uint16Array(n), level = new Uint16Array(n);
  // An operation goes on from its heading to the next one; subroutines belong to what calls them.
  const names = ["before the first heading", ...data.operations.map(([, name]) => name)];
  const heads = data.operations.map(([line]) => line);
  let now = 0;
  path.runs.forEach(([file, line, from], k) => {
    if (!file) now = heads.length && heads[0] <= line ? 1 + indexAt(heads, line) : 0;
    operation.fill(now, from, k + 1 < path.runs.length ? path.runs[k + 1][2] : n);
  });
  // Levels are heights at which something is cut for a while; what lies between them, such as a
  // ramp, belongs to the one below it. Where there are too many they are bands.
  const z = (i) => path.at[3 * i + 2], cuts = (i) => !(path.kind[i] & 1) && !(path.kind[i + 1] & 2);
  const MOST = 24, step = Math.max(2 * data.path.step[2], 1e-3), found = new Map();
  for (let i = 0; i < n - 1; i++) if (cuts(i) && Math.abs(z(i) - z(i + 1)) <= step) {
    const at = Math.round(z(i) / (4 * step));
    found.set(at, (found.get(at) || 0) + 1);
  }
  let heights = [...found.keys()].sort((a, b) => a - b).map((at) => at * 4 * step);
  // A height that rounding has split is one.
  heights = heights.filter((height, k) => k === 0 || height - heights[k - 1] > 6 * step);
  const bands = heights.length > MOST;
  if (bands) heights = Array.from({ length: 12 }, (_, k) => path.low[2] + (path.high[2] - path.low[2]) * k / 12);
  const slack = bands ? 0 : 4 * step;
  for (let i = 0; i < n && heights.length; i++) level[i] = indexAt(heights, Math.min(z(i), z(Math.min(i + 1, n - 1))) + slack);
  const off = { operations: new Set(), levels: new Set() };
  const shown = (i) => !off.operations.has(operation[i]) && !off.levels.has(level[i]);

  function list(id, entries, changed) {
    const box = $(id);
    box.hidden = entries.length < 2;
    const all = element("button", "all or none", { type: "button" });
    const boxes = entries.map(([value, name]) => {
      const label = element("label"), tick = element("input", undefined, { type: "checkbox", value });
      tick.checked = true;
      tick.addEventListener("change", () => {
        if (tick.checked) off[id].delete(value); else off[id].add(value);
        changed();
      });
      label.append(tick, " " + name);
      return [label, tick, value];
    });
    all.addEventListener("click", () => {
      const on = boxes.some(([, tick]) => !tick.checked);
      for (const [, tick, value] of boxes) {
        tick.checked = on;
        if (on) off[id].delete(value); else off[id].add(value);
      }
      changed();
    });
    box.append(...boxes.map(([label]) => label), all);
  }
  function start(changed) {
    const used = [new Set(), new Set()];
    for (let i = 0; i < n - 1; i++) if (cuts(i)) { used[0].add(operation[i]); used[1].add(level[i]); }
    const sorted = (set) => [...set].sort((a, b) => a - b);
    list("operations", sorted(used[0]).map((k) => [k, names[k]]), changed);
    const high = (k) => heights[k + 1] === undefined ? path.high[2] : heights[k + 1];
    const name = (k) => bands ? `Z ${heights[k].toFixed(2)} to ${high(k).toFixed(2)}` : `Z ${heights[k].toFixed(3)}`;
    list("levels", heights.length ? sorted(used[1]).reverse().map((k) => [k, name(k)]) : [], changed);
    $("parts").hidden = $("operations").hidden && $("levels").hidden;
  }
  return { shown, start };
})();
