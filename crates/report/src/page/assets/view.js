// The path in three dimensions, by WebGL2. Without it the still pictures stay.
const view = (() => {
  const canvas = $("gl");
  // Smoothed edges cost a graphics card nothing and a processor three quarters of its time.
  const gl = canvas.getContext("webgl2", { antialias: !inSoftware(), preserveDrawingBuffer: true });
  if (!gl || path.n < 2) return null;
  const program = link(
    `#version 300 es
    in vec3 at; in vec3 color; in float index;
    uniform mat4 turn; uniform float last; uniform float dim;
    out vec4 tint;
    void main() {
      gl_Position = turn * vec4(at, 1.0);
      tint = vec4(color, index <= last ? 1.0 : dim);
    }`,
    `#version 300 es
    precision mediump float;
    in vec4 tint; out vec4 shown;
    void main() { if (tint.a < 0.02) discard; shown = vec4(tint.rgb, 1.0); shown.a = tint.a; }`);
  const uniform = (name) => gl.getUniformLocation(program, name);
  const uniforms = { turn: uniform("turn"), last: uniform("last"), dim: uniform("dim") };
  const cut = batch(), coarse = batch(), fast = batch(), vectors = batch(), tools = batch(), marks = batch(); // lines each
  const center = [0, 1, 2].map((k) => 0.5 * (path.low[k] + path.high[k]));
  const size = Math.max(Math.hypot(...[0, 1, 2].map((k) => path.high[k] - path.low[k])), 1e-3);
  const flat = path.high[2] - path.low[2] < 1e-6;
  const eye = { yaw: 0, pitch: 0, zoom: 1, center: center.slice() };
  // Segments that are drawn while the view moves: what a processor alone draws 30 times a second.
  const MOVING = 3000;
  let wanted = false, pulse = 0, moving = false, rest = 0;

  function inSoftware() {
    const trial = document.createElement("canvas").getContext("webgl2");
    const told = trial && trial.getExtension("WEBGL_debug_renderer_info");
    return Boolean(told) && /swiftshader|llvmpipe|softpipe|software|basic render/i.test(trial.getParameter(told.UNMASKED_RENDERER_WEBGL));
  }
  function link(vertex, fragment) {
    const made = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(made, shader);
    }
    gl.linkProgram(made);
    return made;
  }
  function batch() {
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    const buffers = [["at", 3, gl.FLOAT, false], ["color", 3, gl.UNSIGNED_BYTE, true], ["index", 1, gl.FLOAT, false]].map(([name, count, type, normalized]) => {
      const buffer = gl.createBuffer(), place = gl.getAttribLocation(program, name);
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, count, type, normalized, 0, 0);
      return buffer;
    });
    return { array, buffers, count: 0 };
  }
  function fill(made, at, color, index) {
    [at, color, index].forEach((values, k) => {
      gl.bindBuffer(gl.ARRAY_BUFFER, made.buffers[k]);
      gl.bufferData(gl.ARRAY_BUFFER, values, gl.DYNAMIC_DRAW);
    });
    made.count = index.length;
  }

  const none = data.methods.findIndex((method) => method.name === "none");
  function tint(kind) {
    const error = path.error[chosen.method], worst = data.tolerance;
    const hues = colors.error.map(rgb);
    const top = path.speed.reduce((a, b) => Math.max(a, b), 1e-9);
    if (kind === "speed") return (i) => ramp(path.speed[i] / top);
    const kinds = colors.kinds.map(rgb);
    if (kind === "limiter") return (i) => kinds[kindOf(path.limiter[i])];
    // How much smaller the error is than without compensation: blue is better, orange worse.
    if (kind === "gain") return (i) => hues[hueOf(Math.abs(error[i]) - Math.abs(path.error[none][i]))];
    return (i) => hues[hueOf(error[i] / worst * data.tolerance)];
  }
  function lines() {
    const of = tint($("colour").value), n = path.n - 1;
    for (const [made, rapid] of [[cut, 0], [fast, 1]]) {
      let count = 0;
      const has = (i) => (path.kind[i] & 1) === rapid && !(path.kind[i + 1] & 2) && parts.shown(i);
      for (let i = 0; i < n; i++) if (has(i)) count++;
      const at = new Float32Array(6 * count), color = new Uint8Array(6 * count), index = new Float32Array(2 * count);
      const grey = rgb(colors.soft);
      for (let i = 0, k = 0; i < n; i++) {
        if (!has(i)) continue;
        at.set(path.at.subarray(3 * i, 3 * i + 6), 6 * k);
        const c = rapid ? grey : of(i);
        for (let j = 0; j < 6; j++) color[6 * k + j] = 255 * c[j % 3];
        index[2 * k] = index[2 * k + 1] = i;
        k++;
      }
      fill(made, at, color, index);
      if (!rapid) coarsen(count, of);
    }
    arrows();
    lean();
    legend();
    draw();
  }
  // Of so many stretches next to each other one line, in the colour of the largest error on them.
  function coarsen(count, of) {
    const step = Math.ceil(count / MOVING), n = path.n - 1, error = path.error[chosen.method];
    const most = 2 * MOVING + 2, at = new Float32Array(6 * most), color = new Uint8Array(6 * most), index = new Float32Array(2 * most);
    const cuts = (i) => !(path.kind[i] & 1) && !(path.kind[i + 1] & 2) && parts.shown(i);
    let k = 0;
    for (let i = 0; step > 1 && i < n && k < most; i++) {
      if (!cuts(i)) continue;
      let end = i, worst = i;
      while (end + 1 < n && end + 1 - i < step && cuts(end + 1)) if (Math.abs(error[++end]) > Math.abs(error[worst])) worst = end;
      at.set(path.at.subarray(3 * i, 3 * i + 3), 6 * k);
      at.set(path.at.subarray(3 * end + 3, 3 * end + 6), 6 * k + 3);
      const c = of(worst);
      for (let j = 0; j < 6; j++) color[6 * k + j] = 255 * c[j % 3];
      index[2 * k] = index[2 * k + 1] = i;
      k++;
      i = end;
    }
    fill(coarse, at.subarray(0, 6 * k), color.subarray(0, 6 * k), index.subarray(0, 2 * k));
  }
  // Drawn coarsely until it has rested for a moment.
  function moves() {
    moving = coarse.count > 0;
    clearTimeout(rest);
    rest = setTimeout(() => { moving = false; draw(); }, 200);
    draw();
  }
  // The tool's path: each place of the path moved by its error, magnified.
  function arrows() {
    const error = path.error[chosen.method], times = Number($("times").value) * 1e-3 / 127;
    const n = $("arrows").checked ? path.n - 2 : 0, hues = colors.error.map(rgb);
    const at = new Float32Array(6 * n), color = new Uint8Array(6 * n), index = new Float32Array(2 * n);
    let count = 0;
    for (let i = 0; i < n; i++) {
      if (path.kind[i] & 1 || path.kind[i + 1] & 3 || !parts.shown(i)) continue;
      for (const [end, j] of [[0, i], [3, i + 1]]) {
        const by = error[j] * times;
        for (let k = 0; k < 3; k++) at[6 * count + end + k] = path.at[3 * j + k] + by * path.normal[3 * j + k];
      }
      const c = hues[hueOf(error[i])];
      for (let j = 0; j < 6; j++) color[6 * count + j] = 255 * c[j % 3];
      index[2 * count] = index[2 * count + 1] = i;
      count++;
    }
    fill(vectors, at.subarray(0, 6 * count), color.subarray(0, 6 * count), index.subarray(0, 2 * count));
  }
  // The tool at places next to each other in time, as a line from its tip.
  const TOOLS = 400, LENGTH = 0.07 * size / 127;
  function toolFrom(i, tip) {
    return tip.concat(tip.map((c, k) => c + LENGTH * path.tool[3 * i + k]));
  }
  function lean() {
    const at = [], index = [], end = path.time[path.n - 1], shows = path.tool && $("tools").checked;
    let next = 0;
    for (let i = 0; shows && i < path.n - 1; i++) {
      if (path.time[i] < next || path.kind[i] & 1 || !parts.shown(i)) continue;
      next = path.time[i] + end / TOOLS;
      at.push(...toolFrom(i, Array.from(path.at.subarray(3 * i, 3 * i + 3))));
      index.push(i, i);
    }
    const ink = rgb(colors.soft).map((c) => 255 * c);
    fill(tools, new Float32Array(at), new Uint8Array(at.length).map((_, k) => ink[k % 3]), new Float32Array(index));
  }
  function legend() {
    const box = $("scale"), kind = $("colour").value;
    box.replaceChildren();
    const row = (color, text) => {
      const line = element("div"), swatch = element("i");
      swatch.style.background = color;
      line.append(swatch, element("span", text));
      box.append(line);
    };
    const css = (c) => `rgb(${c.map((v) => Math.round(255 * v)).join(" ")})`;
    if (kind === "speed") {
      const top = path.speed.reduce((a, b) => Math.max(a, b), 0) * 60;
      for (const part of [1, 0.75, 0.5, 0.25, 0]) row(css(ramp(part)), `${(part * top).toFixed(0)} mm/min`);
      return;
    }
    if (kind === "limiter") {
      const of = KINDS.concat("other").map((name, k) => [colors.kinds[k], name, data.limits.every.filter((limit) => kindOf(limit.limiter) === k)]);
      for (const [color, name, those] of of) if (those.length) {
        const axes = those.map((limit) => limit.name.slice(name.length + 1)).filter(Boolean).sort().join(" ");
        const what = name === "other" ? those.map((limit) => limit.name).join(", ") : `${name} ${axes}`.trim();
        row(color, `${what}: ${percent(those.reduce((sum, limit) => sum + limit.share, 0))} of the time`);
      }
      return;
    }
    const bounds = BOUNDS.map((bound) => bound * data.tolerance), last = bounds.length;
    const what = kind === "gain" ? ["worse", "better"] : ["left", "right"];
    for (let hue = last; hue >= 0; hue--) {
      const text = hue === last ? `above ${signed(bounds[last - 1])} \u00b5m ${what[0]}`
        : hue === 0 ? `below ${signed(bounds[0])} \u00b5m ${what[1]}` : `${signed(bounds[hue - 1])} to ${signed(bounds[hue])}`;
      row(colors.error[hue], text);
    }
  }

  // Turns about Z, then tilts; parallel projection, as a drawing.
  function matrix() {
    const [cy, sy, cp, sp] = [Math.cos(eye.yaw), Math.sin(eye.yaw), Math.cos(eye.pitch), Math.sin(eye.pitch)];
    const rows = [[cy, sy, 0], [-sy * cp, cy * cp, sp], [sy * sp, -cy * sp, cp]];
    const width = canvas.clientWidth || 1, height = canvas.clientHeight || 1;
    const scale = 1.9 * eye.zoom / eye.span;
    const by = [scale * Math.min(1, height / width), scale * Math.min(1, width / height), -0.4 / size];
    return { rows, by };
  }
  function project(x, y, z) {
    const { rows, by } = matrix();
    const off = [x - eye.center[0], y - eye.center[1], z - eye.center[2]];
    return rows.map((row, k) => by[k] * (row[0] * off[0] + row[1] * off[1] + row[2] * off[2]));
  }
  function draw() {
    if (wanted) return;
    wanted = true;
    requestAnimationFrame(() => { wanted = false; paint(); });
  }
  function paint() {
    const ratio = window.devicePixelRatio || 1;
    const width = Math.round(canvas.clientWidth * ratio), height = Math.round(canvas.clientHeight * ratio);
    if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
    gl.viewport(0, 0, width, height);
    gl.clearColor(...rgb(colors.ground), 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.useProgram(program);
    const { rows, by } = matrix();
    const m = new Float32Array(16);
    rows.forEach((row, k) => {
      for (let j = 0; j < 3; j++) m[4 * j + k] = by[k] * row[j];
      m[12 + k] = -by[k] * (row[0] * eye.center[0] + row[1] * eye.center[1] + row[2] * eye.center[2]);
    });
    m[15] = 1;
    // What comes after the slider is faint; after any other choice all is shown.
    const last = chosen.upTo === undefined ? path.n : stretchAt(chosen.upTo);
    gl.uniform1f(uniforms.dim, 0.12);
    const show = (made, mode, dx, dy, upTo) => {
      if (!made.count) return;
      const moved = m.slice();
      moved[12] += 2 * dx * ratio / Math.max(width, 1);
      moved[13] += 2 * dy * ratio / Math.max(height, 1);
      gl.uniformMatrix4fv(uniforms.turn, false, moved);
      gl.uniform1f(uniforms.last, upTo);
      gl.bindVertexArray(made.array);
      gl.drawArrays(mode, 0, made.count);
    };
    // A line is one pixel wide in WebGL: drawn a few times next to itself it is seen better.
    const wide = path.n < 200000 ? [[0, 0], [0.7, 0], [0, 0.7], [-0.7, 0], [0, -0.7]] : [[0, 0]];
    if ($("rapids").checked) show(fast, gl.LINES, 0, 0, last);
    if (moving) show(coarse, gl.LINES, 0, 0, last);
    else {
      for (const [dx, dy] of wide) show(cut, gl.LINES, dx, dy, last);
      show(vectors, gl.LINES, 0, 0, last);
      show(tools, gl.LINES, 0, 0, last);
    }
    const tool = toolAt(chosen.time), ink = rgb(colors.ink).map((c) => 255 * c);
    const arm = 9 / (0.5 * Math.min(canvas.clientWidth, canvas.clientHeight) * 1.9 * eye.zoom / eye.span), at = [];
    for (let k = 0; k < 3; k++) for (const s of [-arm, arm]) at.push(...tool.map((c, j) => j === k ? c + s : c));
    if (path.tool) at.push(...toolFrom(stretchAt(chosen.time), tool));
    fill(marks, new Float32Array(at), new Uint8Array(at.length).map((_, j) => ink[j % 3]), new Float32Array(at.length / 3));
    gl.disable(gl.DEPTH_TEST);
    for (const [dx, dy] of [[0, 0], [1, 0], [0, 1], [-1, 0], [0, -1]]) show(marks, gl.LINES, dx, dy, 1);
    pulse++;
  }
  function toolAt(time) {
    const i = stretchAt(time), from = path.time[i], to = path.time[i + 1];
    const part = to > from ? Math.min((time - from) / (to - from), 1) : 0;
    return [0, 1, 2].map((k) => path.at[3 * i + k] + part * (path.kind[i + 1] & 2 ? 0 : path.at[3 * i + 3 + k] - path.at[3 * i + k]));
  }
  function fit() {
    // Of what is cut, not of the way to the tool changer.
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (let i = 0; i < path.n - 1; i++) {
      if ((path.kind[i] & 1 || !parts.shown(i)) && cut.count) continue;
      for (const j of [i, i + 1]) for (let k = 0; k < 3; k++) {
        low[k] = Math.min(low[k], path.at[3 * j + k]);
        high[k] = Math.max(high[k], path.at[3 * j + k]);
      }
    }
    eye.center = low.map((l, k) => 0.5 * (l + high[k]));
    eye.zoom = 1;
    eye.span = 1;
    const { rows } = matrix();
    const wide = rows.slice(0, 2).map((row) => row.reduce((sum, c, k) => sum + Math.abs(c) * (high[k] - low[k]), 0));
    const aspect = canvas.clientWidth / Math.max(canvas.clientHeight, 1);
    eye.span = 1.08 * Math.max(wide[0] / Math.max(aspect, 1), wide[1] * Math.min(aspect, 1), 1e-3);
    draw();
  }
  function look(yaw, pitch) { eye.yaw = yaw; eye.pitch = pitch; fit(); }
  function fly(time, line) {
    // A block may be drawn from the tick after its first one.
    let at = time + 0.5 * data.tick;
    for (let k = 0; k < 4 && line && runOf(stretchAt(at))[1] !== line; k++) at += data.tick;
    choose({ time: at }, "fly");
    eye.center = toolAt(chosen.time);
    eye.zoom = Math.max(eye.zoom, 6);
    // The largest magnification that keeps the error well inside the view.
    const most = 0.15 * eye.span / eye.zoom / (1e-3 * Math.abs(path.error[chosen.method][stretchAt(chosen.time)]) || 1);
    const fitting = [...$("times").options].map((option) => option.value).filter((times) => times <= most);
    $("times").value = fitting.length ? fitting[fitting.length - 1] : "10";
    $("arrows").checked = true;
    arrows();
    $("view").scrollIntoView({ block: "nearest" });
    draw();
  }
  function move(dx, dy) {
    const { rows, by } = matrix();
    const u = 2 * dx / canvas.clientWidth / by[0], v = -2 * dy / canvas.clientHeight / by[1];
    for (let k = 0; k < 3; k++) eye.center[k] -= u * rows[0][k] + v * rows[1][k];
    moves();
  }
  function turn(dx, dy) {
    eye.yaw += dx * 0.008;
    eye.pitch = Math.min(Math.max(eye.pitch + dy * 0.008, -Math.PI), Math.PI);
    moves();
  }
  function zoom(by) { eye.zoom = Math.min(Math.max(eye.zoom * by, 0.1), 1e5); moves(); }
  // The stretch that is drawn nearest to a place of the canvas.
  function pick(x, y) {
    let best = -1, least = 14 * 14;
    const { rows, by } = matrix(), w = 0.5 * canvas.clientWidth, h = 0.5 * canvas.clientHeight;
    const a = [0, 1].map((k) => rows[k].map((c) => by[k] * c * (k ? -h : w)));
    const o = [0, 1].map((k) => (k ? h : w) - a[k].reduce((sum, c, j) => sum + c * eye.center[j], 0));
    const on = (i, k) => o[k] + a[k][0] * path.at[3 * i] + a[k][1] * path.at[3 * i + 1] + a[k][2] * path.at[3 * i + 2];
    for (let i = 0; i < path.n - 1; i++) {
      if (path.kind[i + 1] & 2 || !parts.shown(i) || (path.kind[i] & 1 && !$("rapids").checked)) continue;
      const [px, py, qx, qy] = [on(i, 0), on(i, 1), on(i + 1, 0), on(i + 1, 1)];
      const [dx, dy] = [qx - px, qy - py], square = dx * dx + dy * dy;
      const part = square > 0 ? Math.min(Math.max(((x - px) * dx + (y - py) * dy) / square, 0), 1) : 0;
      const off = (px + part * dx - x) ** 2 + (py + part * dy - y) ** 2;
      if (off < least) { least = off; best = path.time[i] + part * (path.time[i + 1] - path.time[i]); }
    }
    return best;
  }

  const fingers = new Map();
  let moved = 0;
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, [event.offsetX, event.offsetY]);
    moved = 0;
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) return;
    const [dx, dy] = [event.offsetX - before[0], event.offsetY - before[1]];
    moved += Math.abs(dx) + Math.abs(dy);
    if (fingers.size > 1) {
      const other = [...fingers].find(([id]) => id !== event.pointerId)[1];
      const far = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]) || 1;
      zoom(far([event.offsetX, event.offsetY]) / far(before));
      move(dx / 2, dy / 2);
    } else if (event.buttons & 2 || event.shiftKey) move(dx, dy);
    else if (moved > 3) turn(dx, dy);
    fingers.set(event.pointerId, [event.offsetX, event.offsetY]);
  });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (event) => {
    fingers.delete(event.pointerId);
    if (end === "pointerup" && moved <= 3) {
      const time = pick(event.offsetX, event.offsetY);
      if (time >= 0) choose({ time }, "pick");
    }
  });
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    const [x, y] = [event.offsetX - canvas.clientWidth / 2, event.offsetY - canvas.clientHeight / 2];
    const by = Math.exp(-event.deltaY * 0.0015);
    // The place under the pointer stays.
    move(-x, -y);
    zoom(by);
    move(x, y);
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    const arrow = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    if (arrow && event.shiftKey) move(-30 * arrow[0], -30 * arrow[1]);
    else if (arrow) turn(12 * arrow[0], 12 * arrow[1]);
    else if (event.key === "+" || event.key === "=") zoom(1.25);
    else if (event.key === "-") zoom(0.8);
    else if (event.key === "f") fit();
    else if (event.key === "t") look(0, 0);
    else if (event.key === "," || event.key === ".") {
      const i = stretchAt(chosen.time) + (event.key === "." ? 1 : -1);
      choose({ time: path.time[Math.min(Math.max(i, 0), path.n - 1)] + 1e-6 }, "pick");
    } else return;
    event.preventDefault();
  });
  new ResizeObserver(draw).observe(canvas);
  const frames = () => pulse, drawnLines = () => cut.count / 2;
  // A flat part is looked at from above, others a little from the side.
  return { lines, draw, paint, turn, fly, fit, look, eye, frames, drawnLines, project, start: () => look(flat ? 0 : -0.5, flat ? 0 : 0.9) };
})();
