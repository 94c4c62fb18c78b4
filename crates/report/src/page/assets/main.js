// Brings the parts together.
readColors();
const pick = (id, names, value) => {
  $(id).replaceChildren(...names.map((name, k) => element("option", name, { value: k })));
  $(id).value = value;
};
const options = $("colour").querySelectorAll("option");
pick("method", data.methods.map((method) => method.name), chosen.method);
if (data.methods.length < 2) $("methodpick").hidden = true;
if (data.methods.length < 2 || !data.methods.some((method) => method.name === "none")) options[3].remove();
const motors = data.methods[chosen.method] ? data.methods[chosen.method].motors : [];
pick("axis", motors.map((motor) => motor.name), 0);
// Signals that the chosen method has: one that learns nothing has no estimate of the gap.
function signals() {
  const { motors } = data.methods[chosen.method] || { motors: [] }, before = $("signal").value;
  const has = data.signals.map((name, k) => [name === "error" ? "following error" : name, k]).filter(([, k]) => motors.some((motor) => motor.signals[k]));
  $("signal").replaceChildren(...has.map(([name, k]) => element("option", name, { value: k })));
  $("signal").value = has.some(([, k]) => String(k) === before) ? before : "0";
}
signals();
$("tools").parentElement.hidden = !path.tool;
// A run that did not trace its motors has no signals of them.
for (const id of ["axis", "signal", "signalplot"]) $(id).parentElement.hidden = !motors.length;
// The slider goes by time, or by lines: each move of the program is as long as any other there.
const slider = (() => {
  const runs = path.runs, byLine = () => $("by").value === "line";
  const begin = (k) => k < runs.length ? path.time[runs[k][2]] : data.duration;
  const lineAt = (time) => {
    const k = indexAt(runs, time, runs.length, (run) => path.time[run[2]]), from = begin(k);
    return k + Math.min(Math.max((time - from) / Math.max(begin(k + 1) - from, 1e-9), 0), 1);
  };
  function follow() {
    $("time").max = byLine() ? runs.length : data.duration;
    $("time").value = byLine() ? lineAt(chosen.time) : chosen.time;
  }
  function time() {
    const value = Number($("time").value), k = Math.min(Math.floor(value), runs.length - 1);
    return byLine() ? begin(k) + (value - k) * (begin(k + 1) - begin(k)) : value;
  }
  $("by").addEventListener("change", follow);
  $("time").addEventListener("input", () => choose({ time: time() }, "slider"));
  return { follow };
})();

function flights() {
  const method = data.methods[chosen.method];
  $("flights").replaceChildren(...method.worst.map((block) => {
    const button = element("button", `${signed(block.um)} \u00b5m, line ${block.line}`, { type: "button", title: block.cause });
    button.addEventListener("click", () => view ? view.fly(block.t, block.line) : choose({ time: block.t }, "fly"));
    return button;
  }));
}
function readout() {
  const i = stretchAt(chosen.time), run = runOf(i), error = path.error[chosen.method];
  $("clock").textContent = clock(chosen.time);
  const text = $("readout").firstElementChild;
  if (!run || !error) return;
  text.hidden = false;
  const file = run[0] ? data.files[run[0] - 1] + " " : "";
  const what = path.kind[i] & 1 ? "rapid" : Number.isNaN(error[i]) ? "not reached" : `${signed(error[i])} \u00b5m`;
  const limit = limits.get(path.limiter[i]);
  const place = [0, 1, 2].map((k) => "XYZ"[k] + path.at[3 * i + k].toFixed(3)).join(" ");
  text.textContent = `${file}line ${run[1]}: ${what}, ${(60 * path.speed[i]).toFixed(0)} mm/min${limit ? " by " + limit.name : ""}, ${place}`;
}
chosen.followers.push((change, from) => {
  if ("method" in change) {
    $("method").value = chosen.method;
    flights();
    signals();
    source.rate();
    if (view) view.lines();
    plots.all();
  }
  if ("time" in change) {
    if (from !== "slider") slider.follow();
    plots.over();
  }
  source.follow();
  readout();
  if (view) view.draw();
});

$("method").addEventListener("change", (event) => choose({ method: Number(event.target.value) }));
for (const id of ["axis", "signal"]) $(id).addEventListener("change", plots.signal);
for (const link of document.querySelectorAll("a[data-t]")) link.addEventListener("click", (event) => {
  event.preventDefault();
  const time = Number(link.dataset.t);
  if (view) view.fly(time); else choose({ time }, "fly");
});
if (data.methods.length && path.n > 1) {
  $("plots").hidden = false;
  if (view) {
    $("view").hidden = false;
    const still = $("still");
    if (still) still.open = false;
    for (const id of ["colour", "arrows", "times", "tools"]) $(id).addEventListener("change", view.lines);
    $("rapids").addEventListener("change", view.draw);
    $("fit").addEventListener("click", view.fit);
    $("top").addEventListener("click", () => view.look(0, 0));
    $("iso").addEventListener("click", () => view.look(-0.5, 0.9));
    parts.start(view.lines);
    view.lines();
    view.start();
  }
  flights();
  source.rate();
  readout();
  slider.follow();
  plots.all();
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    readColors();
    source.show();
    if (view) view.lines();
    plots.all();
  });
  addEventListener("beforeprint", () => { const still = $("still"); if (still) still.open = true; });
}
window.lostmotion = { data, path, chosen, choose, view, plots, ready: performance.now() };
