// lostmotion for JavaScript: the C interface as WebAssembly, for Node and browsers. A run stays on the
// thread that asks for it; in a page that is a worker's.

/** Why there is no result. */
export class LostmotionError extends Error {
  constructor(message, told) {
    super(message);
    this.name = "LostmotionError";
    Object.assign(this, told);
  }
}

/** A function as a WebAssembly function; "iif-i": of two 32-bit numbers and a double, answers one. */
function asWasm(signature, callback) {
  const [parameters, results] = signature
    .split("-")
    .map((letters) => [letters.length, ...Array.from(letters, (letter) => (letter === "i" ? 0x7f : 0x7c))]);
  const function_ = [0x01, 0x60, ...parameters, ...results];
  const type = [0x01, function_.length, ...function_];
  const bytes = [0, 0x61, 0x73, 0x6d, 1, 0, 0, 0, ...type];
  // imports e.f of type 0, and exports it as f
  bytes.push(0x02, 7, 1, 1, 0x65, 1, 0x66, 0, 0, 0x07, 5, 1, 1, 0x66, 0, 0);
  const module = new WebAssembly.Module(new Uint8Array(bytes));
  return new WebAssembly.Instance(module, { e: { f: callback } }).exports.f;
}

// Offsets in bytes of the structures of lostmotion.h where pointers have four bytes.
const ERROR = { size: 32, code: 4, message: 8, hint: 12, file: 16, line: 20, column: 24, findings: 28 };
const CONTOUR = { size: 152, time: 0, error: 8, actual: 96, line: 144 };
const FINDING = { size: 40, isError: 24, line: 28, column: 32, length: 36 };
const FINDING_TEXTS = { code: 0, message: 4, hint: 8, file: 12, excerpt: 16, key: 20 };
const OPERATION = { size: 16, text: 0, line: 4, column: 8, file: 12 };
const PLAN = { size: 80, duration: 0, cutting: 8, rapid: 16 };
const SAMPLE = { size: 232, time: 0, position: 8, velocity: 80, acceleration: 152, line: 224 };
const COMPENSATOR = { size: 32, name: 4, create: 12, copy: 16, destroy: 20, step: 24, loadScale: 28 };
/** Numbers of the facts of an axis, from byte 8 on. */
const FACTS = [
  ["motorRadPerUnit", "servoPeriodS", "gapRad", "motorInertiaKgm2", "motorCoulombNm", "loadInertiaKgm2"],
  ["loadCoulombNm", "loadViscousNmSPerRad", "loadConstantNm", "stiffnessNmPerRad", "dampingNmSPerRad"],
].flat();
/** Numbers of a tick, and behind them whether the drive was at a limit. */
const TICK = [
  ["position", "velocity", "acceleration", "nextPosition", "nextVelocity", "nextAcceleration"],
  ["motorPosition", "motorVelocity", "current", "meanCurrent", "loadPosition"],
].flat();
const CORRECTION = ["position", "velocity", "torque", "feedback"];
/** Joints of a sample of the plan. */
const JOINTS = 9;
/** What the index of a list behind its last one is answered with. */
const STATUS_SIZE = 4;

/** A copy of an object with its class: what it carries are its fields. */
function copied(state) {
  const fields = Object.entries(state).map(([name, value]) => [
    name,
    typeof value === "function" ? value : structuredClone(value),
  ]);
  return Object.assign(Object.create(Object.getPrototypeOf(state)), Object.fromEntries(fields));
}

/** Room and handles of a call, which are given back at its end. */
class Scope {
  constructor(lostmotion) {
    this.lostmotion = lostmotion;
    this.wasm = lostmotion.wasm;
    this.freed = [];
    /** Where a call puts a handle or a pointer. */
    this.out = this.room(8);
  }

  room(bytes) {
    const pointer = this.wasm.lm_memory(bytes);
    this.freed.push(() => this.wasm.lm_memory_free(pointer, bytes));
    return pointer;
  }

  /** A text for a call, and how many bytes it is; null where it is left out. */
  given(text) {
    if (text === undefined) return [0, 0];
    const bytes = new TextEncoder().encode(`${text}\0`);
    const pointer = this.room(bytes.length);
    new Uint8Array(this.wasm.memory.buffer).set(bytes, pointer);
    return [pointer, bytes.length - 1];
  }

  /** The same of a value as JSON. */
  json(value) {
    return this.given(value === undefined ? undefined : JSON.stringify(value))[0];
  }

  /** The handle that a call has made. */
  made(status, free) {
    this.lostmotion.check(status);
    const handle = this.lostmotion.view.getUint32(this.out, true);
    this.freed.push(() => free(handle));
    return handle;
  }

  /** The text that a call has made. */
  text(status) {
    const handle = this.made(status, this.wasm.lm_text_free);
    this.lostmotion.check(this.wasm.lm_text(handle, this.out, 0));
    return this.lostmotion.text(this.lostmotion.view.getUint32(this.out, true));
  }

  program(code, name = "program") {
    const [text, length] = this.given(code);
    const status = this.wasm.lm_program_from_text(this.given(name)[0], text, length, this.out);
    return this.made(status, this.wasm.lm_program_free);
  }

  /** The machine of a description; null where it is left out. */
  machine(description) {
    if (description === undefined) return 0;
    const { preset, toml, json } = description;
    let status;
    if (toml !== undefined)
      status = this.wasm.lm_machine_from_toml(this.given("machine.toml")[0], this.given(toml)[0], this.out);
    else if (json !== undefined) status = this.wasm.lm_machine_from_json(this.json(json), this.out);
    else status = this.wasm.lm_machine_preset(this.given(preset)[0], this.out);
    return this.made(status, this.wasm.lm_machine_free);
  }

  /** The list of findings that a call has made. */
  findings(status) {
    const { lostmotion, wasm } = this;
    const handle = this.made(status, wasm.lm_findings_free);
    lostmotion.check(wasm.lm_findings_count(handle, this.out));
    const count = lostmotion.view.getUint32(this.out, true);
    const room = this.room(FINDING.size);
    return Array.from({ length: count }, (_, index) => {
      lostmotion.check(wasm.lm_findings_get(handle, index, room));
      return lostmotion.finding(room);
    });
  }

  end() {
    while (this.freed.length > 0) this.freed.pop()();
  }
}

export class Lostmotion {
  static async load(source) {
    const made =
      typeof Response !== "undefined" && source instanceof Response
        ? await WebAssembly.instantiateStreaming(source, {})
        : await WebAssembly.instantiate(source, {});
    return new Lostmotion((made.instance ?? made).exports);
  }

  constructor(exports) {
    this.wasm = exports;
    this.version = this.text(exports.lm_version());
    this.slots = {};
  }

  /** The memory, which may have grown since the last look. */
  get view() {
    return new DataView(this.wasm.memory.buffer);
  }

  text(pointer) {
    const bytes = new Uint8Array(this.wasm.memory.buffer, pointer);
    return new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
  }

  /** Throws what went wrong last unless a call answered 0. */
  check(status) {
    if (status === 0) return;
    const error = this.wasm.lm_memory(ERROR.size);
    const finding = this.wasm.lm_memory(FINDING.size);
    try {
      this.wasm.lm_error(error);
      const at = (offset) => this.view.getUint32(error + offset, true);
      const findings = Array.from({ length: at(ERROR.findings) }, (_, index) => {
        this.wasm.lm_error_finding(index, finding);
        return this.finding(finding);
      });
      throw new LostmotionError(this.text(at(ERROR.message)), {
        code: this.text(at(ERROR.code)),
        hint: this.text(at(ERROR.hint)),
        file: this.text(at(ERROR.file)),
        line: at(ERROR.line),
        column: at(ERROR.column),
        findings,
      });
    } finally {
      this.wasm.lm_memory_free(error, ERROR.size);
      this.wasm.lm_memory_free(finding, FINDING.size);
    }
  }

  /** A finding as an object. */
  finding(room) {
    const at = (offset) => this.view.getUint32(room + offset, true);
    const texts = Object.entries(FINDING_TEXTS).map(([name, offset]) => [name, this.text(at(offset))]);
    return {
      ...Object.fromEntries(texts),
      isError: this.view.getUint8(room + FINDING.isError) !== 0,
      line: at(FINDING.line),
      column: at(FINDING.column),
      length: at(FINDING.length),
    };
  }

  /** Puts a callback into the table of functions, in a place that is used again. */
  callback(name, signature, function_) {
    const table = this.wasm.__indirect_function_table;
    this.slots[name] ??= table.grow(1);
    table.set(this.slots[name], asWasm(signature, function_));
    return this.slots[name];
  }

  /** Adds a compensator of the caller's; each state has a number. */
  compensator(scope, handle, number, { name, make, loadScale }, thrown) {
    const states = new Map();
    let next = 1;
    const kept = (state) => {
      states.set(next, state);
      return next++;
    };
    const guarded = (work) => {
      try {
        return work();
      } catch (error) {
        thrown.push(error);
        return 0;
      }
    };
    const create = (_, facts, motorPosition) =>
      guarded(() => kept(make({ unit: this.text(this.view.getUint32(facts, true)), ...this.numbers(FACTS, facts + 8) }, motorPosition)));
    const copy = (state) => guarded(() => kept(copied(states.get(state))));
    const destroy = (state) => void states.delete(state);
    const step = (state, tick, correction) => {
      const saturated = this.view.getUint8(tick + 8 * TICK.length) !== 0;
      const answer = guarded(() => states.get(state).step({ ...this.numbers(TICK, tick), saturated }) ?? {});
      // one that has thrown ends the run: no drive could act on what is no number
      CORRECTION.forEach((part, index) =>
        this.view.setFloat64(correction + 8 * index, answer === 0 ? NaN : (answer[part] ?? 0), true),
      );
    };
    const room = scope.room(COMPENSATOR.size);
    const set = (offset, value) => this.view.setUint32(room + offset, value, true);
    const functions = { create: ["iif-i", create], copy: ["i-i", copy], destroy: ["i-", destroy], step: ["iii-", step] };
    set(0, COMPENSATOR.size);
    set(COMPENSATOR.name, scope.given(name)[0]);
    for (const [which, [signature, function_]] of Object.entries(functions))
      set(COMPENSATOR[which], this.callback(`${which} ${number}`, signature, function_));
    this.view.setUint8(room + COMPENSATOR.loadScale, loadScale ? 1 : 0);
    this.check(this.wasm.lm_simulation_compensator(handle, room));
  }

  /** Numbers that stand one behind the other, by their names. */
  numbers(names, at) {
    return Object.fromEntries(names.map((name, index) => [name, this.view.getFloat64(at + 8 * index, true)]));
  }

  /** Does the work of a call, and gives back what it needed. */
  within(work) {
    const scope = new Scope(this);
    try {
      return work(scope);
    } finally {
      scope.end();
    }
  }

  /** A simulation, with what a callback throws. */
  simulation(scope, simulation) {
    const { wasm } = this;
    const program = scope.program(simulation.program, simulation.name);
    const machine = scope.machine(simulation.machine);
    const handle = scope.made(wasm.lm_simulation_new(program, machine, scope.out), wasm.lm_simulation_free);
    for (const method of simulation.methods ?? [])
      this.check(wasm.lm_simulation_method(handle, scope.given(method)[0]));
    for (const [key, value] of Object.entries(simulation.settings ?? {})) {
      const [name] = scope.given(key);
      this.check(
        typeof value === "number"
          ? wasm.lm_simulation_set(handle, name, value)
          : wasm.lm_simulation_set_json(handle, name, scope.json(value)),
      );
    }
    const thrown = [];
    simulation.compensators?.forEach((own, number) => this.compensator(scope, handle, number, own, thrown));
    const guarded = (work) => {
      try {
        return work() === false ? 0 : 1;
      } catch (error) {
        thrown.push(error);
        return 0;
      }
    };
    if (simulation.onProgress) {
      const told = (_, at) =>
        guarded(() =>
          simulation.onProgress({
            doneBytes: Number(this.view.getBigUint64(at, true)),
            totalBytes: Number(this.view.getBigUint64(at + 8, true)),
            simulatedS: this.view.getFloat64(at + 16, true),
          }),
        );
      this.check(wasm.lm_simulation_on_progress(handle, this.callback("progress", "ii-i", told), 0));
    }
    return { handle, guarded, thrown };
  }

  /** Runs, and answers the text that `read` makes of the run. */
  run(simulation, read) {
    const { wasm } = this;
    return this.within((scope) => {
      const { handle, guarded, thrown } = this.simulation(scope, simulation);
      if (simulation.onContour) {
        const told = (_, method, at, count) =>
          guarded(() => simulation.onContour(this.contour(method, at, count)));
        this.check(wasm.lm_simulation_on_contour(handle, this.callback("contour", "iiii-i", told), 0));
      }
      const status = wasm.lm_simulation_run(handle, scope.out);
      if (thrown.length > 0) throw thrown[0];
      return scope.text(read(scope.made(status, wasm.lm_run_free), scope.out));
    });
  }

  contour(method, at, count) {
    const view = this.view;
    const row = (index, offset) => at + index * CONTOUR.size + offset;
    const numbers = (offset) =>
      Float64Array.from({ length: count }, (_, index) => view.getFloat64(row(index, offset), true));
    return {
      method,
      timeS: numbers(CONTOUR.time),
      errorUm: numbers(CONTOUR.error),
      actualMm: Float64Array.from({ length: 3 * count }, (_, index) =>
        view.getFloat64(row(Math.floor(index / 3), CONTOUR.actual + 8 * (index % 3)), true),
      ),
      line: Uint32Array.from({ length: count }, (_, index) =>
        view.getUint32(row(index, CONTOUR.line), true),
      ),
    };
  }

  simulate(simulation) {
    return JSON.parse(this.run(simulation, this.wasm.lm_run_json));
  }

  report(simulation) {
    return this.run(simulation, this.wasm.lm_run_text);
  }

  plan(simulation) {
    const { wasm } = this;
    return this.within((scope) => {
      const { handle, guarded, thrown } = this.simulation(scope, simulation);
      const parts = [];
      const told = (_, at, count) => guarded(() => parts.push(this.samples(at, count)));
      this.check(wasm.lm_simulation_on_plan(handle, this.callback("plan", "iii-i", told), 0));
      const plan = scope.room(PLAN.size);
      const status = wasm.lm_simulation_plan(handle, plan);
      if (thrown.length > 0) throw thrown[0];
      this.check(status);
      const number = (offset) => this.view.getFloat64(plan + offset, true);
      return {
        durationS: number(PLAN.duration),
        cuttingMm: number(PLAN.cutting),
        rapidMm: number(PLAN.rapid),
        samples: joined(parts),
      };
    });
  }

  /** Samples of the plan, copied. */
  samples(at, count) {
    const view = this.view;
    const joints = (offset) =>
      Float64Array.from({ length: JOINTS * count }, (_, index) =>
        view.getFloat64(at + Math.floor(index / JOINTS) * SAMPLE.size + offset + 8 * (index % JOINTS), true),
      );
    return {
      timeS: Float64Array.from({ length: count }, (_, index) => view.getFloat64(at + index * SAMPLE.size, true)),
      position: joints(SAMPLE.position),
      velocity: joints(SAMPLE.velocity),
      acceleration: joints(SAMPLE.acceleration),
      line: Uint32Array.from({ length: count }, (_, index) =>
        view.getUint32(at + index * SAMPLE.size + SAMPLE.line, true),
      ),
    };
  }

  findings({ program, name, machine, settings, lints, levels }) {
    const { wasm } = this;
    return this.within((scope) => {
      const handle = scope.program(program, name);
      const on = scope.machine(machine);
      const reading = scope.json(settings);
      return scope.findings(
        levels === undefined
          ? wasm.lm_program_findings(handle, on, reading, lints ? 1 : 0, scope.out)
          : wasm.lm_program_lint(handle, on, reading, scope.json(levels), scope.out),
      );
    });
  }

  operations({ program, name, machine, settings }) {
    const { wasm } = this;
    return this.within((scope) => {
      const handle = scope.program(program, name);
      const status = wasm.lm_program_operations(handle, scope.machine(machine), scope.json(settings), scope.out);
      const operations = scope.made(status, wasm.lm_operations_free);
      const room = scope.room(OPERATION.size);
      const found = [];
      for (;;) {
        this.check(wasm.lm_operations_next(operations, room));
        const at = (offset) => this.view.getUint32(room + offset, true);
        if (at(OPERATION.text) === 0) return found;
        found.push({
          text: this.text(at(OPERATION.text)),
          line: at(OPERATION.line),
          column: at(OPERATION.column),
          file: at(OPERATION.file),
        });
      }
    });
  }

  explain({ program, name, machine, settings, line }) {
    return JSON.parse(
      this.within((scope) => {
        const handle = scope.program(program, name);
        const on = scope.machine(machine);
        return scope.text(
          this.wasm.lm_program_explain_json(handle, on, scope.json(settings), line, scope.out),
        );
      }),
    );
  }

  format(program, { case: letters, indent, lineNumbers } = {}) {
    const style = { case: letters, indent, line_numbers: lineNumbers?.toString() };
    return this.within((scope) =>
      scope.text(this.wasm.lm_program_format_as(scope.program(program), scope.json(style), scope.out)),
    );
  }

  resolved({ program, name, machine, settings, system = 1 }) {
    return this.within((scope) => {
      const handle = scope.program(program, name);
      const on = scope.machine(machine);
      return scope.text(
        this.wasm.lm_program_resolved(handle, on, scope.json(settings), system, scope.out),
      );
    });
  }

  presets() {
    return this.listed(this.wasm.lm_preset);
  }

  methods() {
    return this.listed(this.wasm.lm_method);
  }

  /** Names and lines about them, of a function that gives one by its number. */
  listed(function_) {
    return this.within((scope) => {
      const found = [];
      for (;;) {
        const status = function_(found.length, scope.out, scope.out + 4);
        if (status === STATUS_SIZE) return found;
        this.check(status);
        const text = (offset) => this.text(this.view.getUint32(scope.out + offset, true));
        found.push({ name: text(0), summary: text(4) });
      }
    });
  }

  problems(toml, name = "machine.toml") {
    return this.within((scope) =>
      scope.findings(
        this.wasm.lm_machine_problems(scope.given(name)[0], scope.given(toml)[0], scope.out),
      ),
    );
  }

  machine(description) {
    return this.within((scope) => {
      const handle = scope.machine(description);
      const text = (function_) => scope.text(function_(handle, scope.out));
      return {
        json: JSON.parse(text(this.wasm.lm_machine_json)),
        toml: text(this.wasm.lm_machine_toml),
        remarks: text(this.wasm.lm_machine_remarks).split("\n").filter(Boolean),
      };
    });
  }
}

/** Samples in one. */
function joined(parts) {
  const all = (name, kind) => {
    const whole = new kind(parts.reduce((length, part) => length + part[name].length, 0));
    let at = 0;
    for (const part of parts) {
      whole.set(part[name], at);
      at += part[name].length;
    }
    return whole;
  };
  return {
    timeS: all("timeS", Float64Array),
    position: all("position", Float64Array),
    velocity: all("velocity", Float64Array),
    acceleration: all("acceleration", Float64Array),
    line: all("line", Uint32Array),
  };
}
