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

/** A function of two or four 32-bit numbers that answers one, as a WebAssembly function. */
function asWasm(count, callback) {
  const parameters = new Array(count).fill(0x7f);
  const type = [0x01, 4 + count + 1, 0x01, 0x60, count, ...parameters, 0x01, 0x7f];
  const bytes = [0, 0x61, 0x73, 0x6d, 1, 0, 0, 0, ...type];
  // imports e.f of type 0, and exports it as f
  bytes.push(0x02, 7, 1, 1, 0x65, 1, 0x66, 0, 0, 0x07, 5, 1, 1, 0x66, 0, 0);
  const module = new WebAssembly.Module(new Uint8Array(bytes));
  return new WebAssembly.Instance(module, { e: { f: callback } }).exports.f;
}

// Offsets in bytes of the structures of lostmotion.h where pointers have four bytes.
const ERROR = { size: 32, code: 4, message: 8, hint: 12, file: 16, line: 20, column: 24 };
const CONTOUR = { size: 152, time: 0, error: 8, actual: 96, line: 144 };

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
    this.slots = [];
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
    try {
      this.wasm.lm_error(error);
      const at = (offset) => this.view.getUint32(error + offset, true);
      throw new LostmotionError(this.text(at(ERROR.message)), {
        code: this.text(at(ERROR.code)),
        hint: this.text(at(ERROR.hint)),
        file: this.text(at(ERROR.file)),
        line: at(ERROR.line),
        column: at(ERROR.column),
      });
    } finally {
      this.wasm.lm_memory_free(error, ERROR.size);
    }
  }

  /** Puts a callback into the table of functions, in a place that is used again. */
  callback(number, count, function_) {
    const table = this.wasm.__indirect_function_table;
    this.slots[number] ??= table.grow(1);
    table.set(this.slots[number], asWasm(count, function_));
    return this.slots[number];
  }

  /** Runs, and hands the run to `read`; whatever was made is freed. */
  run(simulation, read) {
    const { wasm } = this;
    const freed = [];
    const given = (text) => {
      const bytes = new TextEncoder().encode(`${text}\0`);
      const pointer = wasm.lm_memory(bytes.length);
      freed.push(() => wasm.lm_memory_free(pointer, bytes.length));
      new Uint8Array(wasm.memory.buffer).set(bytes, pointer);
      return [pointer, bytes.length - 1];
    };
    const out = wasm.lm_memory(8);
    freed.push(() => wasm.lm_memory_free(out, 8));
    const made = (status, free) => {
      this.check(status);
      const handle = this.view.getUint32(out, true);
      freed.push(() => free(handle));
      return handle;
    };
    let thrown;
    const guarded = (work) => {
      try {
        return work() === false ? 0 : 1;
      } catch (error) {
        thrown ??= error;
        return 0;
      }
    };
    try {
      const [code, length] = given(simulation.program);
      const [name] = given(simulation.name ?? "program");
      const program = made(wasm.lm_program_from_text(name, code, length, out), wasm.lm_program_free);
      const { preset, toml } = simulation.machine;
      const machine = made(
        toml === undefined
          ? wasm.lm_machine_preset(given(preset)[0], out)
          : wasm.lm_machine_from_toml(given("machine.toml")[0], given(toml)[0], out),
        wasm.lm_machine_free,
      );
      const handle = made(wasm.lm_simulation_new(program, machine, out), wasm.lm_simulation_free);
      for (const method of simulation.methods ?? [])
        this.check(wasm.lm_simulation_method(handle, given(method)[0]));
      for (const [key, value] of Object.entries(simulation.settings ?? {})) {
        const [name_] = given(key);
        this.check(
          typeof value === "number"
            ? wasm.lm_simulation_set(handle, name_, value)
            : wasm.lm_simulation_set_json(handle, name_, given(JSON.stringify(value))[0]),
        );
      }
      if (simulation.onProgress) {
        const told = (_, at) =>
          guarded(() =>
            simulation.onProgress({
              doneBytes: Number(this.view.getBigUint64(at, true)),
              totalBytes: Number(this.view.getBigUint64(at + 8, true)),
              simulatedS: this.view.getFloat64(at + 16, true),
            }),
          );
        this.check(wasm.lm_simulation_on_progress(handle, this.callback(0, 2, told), 0));
      }
      if (simulation.onContour) {
        const told = (_, method, at, count) => guarded(() => simulation.onContour(this.contour(method, at, count)));
        this.check(wasm.lm_simulation_on_contour(handle, this.callback(1, 4, told), 0));
      }
      const status = wasm.lm_simulation_run(handle, out);
      if (thrown !== undefined) throw thrown;
      const run = made(status, wasm.lm_run_free);
      return this.text(
        ((text) => {
          this.check(wasm.lm_text(text, out, 0));
          return this.view.getUint32(out, true);
        })(made(read(run, out), wasm.lm_text_free)),
      );
    } finally {
      while (freed.length > 0) freed.pop()();
    }
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
}
