// The lines of the program, coloured by their worst error; only those in sight are in the document.
const source = (() => {
  const box = $("lines"), inner = box.firstElementChild, HEIGHT = 20;
  const rows = [];
  let next = 1;
  for (const [from, text] of data.source) {
    if (from > next) rows.push([0, `lines ${next} to ${from - 1} are not in this page`]);
    text.split("\n").forEach((line, k) => rows.push([from + k, line]));
    next = from + text.split("\n").length;
  }
  if (next <= data.lines) rows.push([0, `lines ${next} to ${data.lines} are not in this page`]);
  const rowOf = new Map(rows.map(([line], row) => [line, row]));
  inner.style.height = rows.length * HEIGHT + "px";
  let worst = new Map(), begins = new Map(), now = -1;
  function rate() {
    worst = new Map();
    begins = new Map();
    const error = path.error[chosen.method];
    path.runs.forEach(([file, line, from], k) => {
      if (file) return;
      if (!begins.has(line)) begins.set(line, from);
      const to = k + 1 < path.runs.length ? path.runs[k + 1][2] : path.n - 1;
      let most = worst.get(line) || 0;
      for (let i = from; i < to; i++) if (!(path.kind[i] & 1) && Math.abs(error[i]) > Math.abs(most)) most = error[i];
      worst.set(line, most);
    });
    show();
  }
  function show() {
    const first = Math.max(Math.floor(box.scrollTop / HEIGHT) - 4, 0);
    const last = Math.min(first + Math.ceil(box.clientHeight / HEIGHT) + 8, rows.length);
    const made = [];
    for (let row = first; row < last; row++) {
      const [line, text] = rows[row];
      const item = element("div", undefined, { class: "row code" + (row === now ? " now" : ""), role: "option", "data-row": row, "aria-selected": row === now });
      item.style.top = row * HEIGHT + "px";
      if (worst.has(line)) item.style.borderLeftColor = colors.error[hueOf(worst.get(line))];
      if (worst.get(line)) item.title = `worst error ${signed(worst.get(line))} \u00b5m`;
      item.append(element("b", line || "\u2026"), text);
      made.push(item);
    }
    inner.replaceChildren(...made);
  }
  // The line of the time that is chosen, scrolled into sight.
  function follow() {
    const run = runOf(stretchAt(chosen.time));
    const row = run && !run[0] ? rowOf.get(run[1]) : undefined;
    now = row === undefined ? -1 : row;
    if (now >= 0) {
      const top = now * HEIGHT;
      if (top < box.scrollTop || top + HEIGHT > box.scrollTop + box.clientHeight) box.scrollTop = top - box.clientHeight / 2;
    }
    show();
  }
  function pick(row) {
    const line = rows[row] && rows[row][0];
    if (!begins.has(line)) return false;
    choose({ time: path.time[begins.get(line)] + 1e-6 }, "source");
    return true;
  }
  box.addEventListener("scroll", show);
  box.addEventListener("click", (event) => {
    const row = event.target.closest("[data-row]");
    if (row) pick(Number(row.dataset.row));
  });
  box.addEventListener("keydown", (event) => {
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (!step) return;
    // To the next line that moves something.
    for (let row = now + step; row >= 0 && row < rows.length; row += step) if (pick(row)) break;
    event.preventDefault();
  });
  return { rate, follow, show };
})();
