// The package in Node: figures to the bit, callbacks, errors, nothing left behind.
// wasm.mjs FOLDER PART DOCUMENT CANON FORMATTED PLAN

import { readFile } from "node:fs/promises";
import assert from "node:assert/strict";

const [folder, part, wanted, canon, formatted, planned] = process.argv.slice(2);
const { Lostmotion, LostmotionError } = await import(`${folder}/lostmotion.js`);
const lostmotion = await Lostmotion.load(await readFile(`${folder}/lostmotion.wasm`));
const program = await readFile(part, "utf8");
const machine = { preset: "vmc3-worn" };

let [told, samples, last] = [0, 0, 0];
const run = lostmotion.simulate({
  name: part,
  program,
  machine,
  methods: ["none", "fixed"],
  onProgress: (progress) => {
    told++;
    last = progress.simulatedS;
  },
  onContour: (contour) => {
    samples += contour.errorUm.length;
    assert(contour.timeS.length === contour.line.length && contour.actualMm.every(Number.isFinite));
  },
});
assert.deepEqual(run, JSON.parse(await readFile(wanted, "utf8")));
assert(told > 10 && Math.abs(last - run.plan.duration_s) < 1 && samples > 8000 * (last - 1));
assert.match(lostmotion.report({ program, machine, name: part }), /on vmc3-worn, method none/);

// Of the program alone: what the command prints.
const operations = lostmotion.operations({ program });
assert.equal(operations.map(({ text }) => `${text}\n`).join(""), await readFile(canon, "utf8"));
assert(operations.every(({ line, column, file }) => line > 0 === column > 0 && file === 0));
assert(operations.at(-1).line > 3);
assert.equal(lostmotion.format(program, { case: "lower", indent: 4 }), await readFile(formatted, "utf8"));
assert.deepEqual(lostmotion.findings({ program, machine }), []);
const [found] = lostmotion.findings({ program: "G21\nG1 Z-\nM2\n" });
assert.deepEqual([found.code, found.line, found.column, found.isError], ["missing-number", 2, 6, true]);
assert(found.message.length > 0 && found.excerpt === "G1 Z-" && found.file === "program");
const loud = { program: "G21 G90\nG1 X10 F100\nM2\n", lints: true };
const quiet = lostmotion.findings({ ...loud, levels: { all: "allow" } });
assert.deepEqual(quiet, []);
assert(lostmotion.findings(loud).length >= quiet.length);
assert.equal(lostmotion.explain({ program, line: 1 }).line, 1);
assert.match(lostmotion.resolved({ program: "G21 G90\n#1 = 4\nG1 X[#1 * 5] F600\nM2\n" }), /X20/);
const thrown = (work, code) =>
  assert.throws(work, (error) => error instanceof LostmotionError && error.code === code && Array.isArray(error.findings));
thrown(() => lostmotion.operations({ program: "G21\nG1 Z-\n" }), "missing-number");
thrown(() => lostmotion.format(program, { case: "loud" }), "option");
thrown(() => lostmotion.findings({ program, levels: { nome: "warn" } }), "option");
thrown(() => lostmotion.explain({ program, line: 9999999 }), "option");
thrown(() => lostmotion.resolved({ program: "G1 Z-\n" }), "missing-number");

// The plan: rows of the command's table, to its decimals.
const plan = lostmotion.plan({ program, machine, name: part });
const rows = (await readFile(planned, "utf8")).trimEnd().split("\n");
const names = rows.shift().split(",");
assert.equal(plan.samples.timeS.length, rows.length);
assert(Math.abs(plan.durationS - plan.samples.timeS.at(-1)) < 2e-3);
rows.forEach((row, sample) => {
  const cells = row.split(",").map(Number);
  const cell = (name) => cells[names.indexOf(name)];
  ["x_mm", "y_mm", "z_mm"].forEach((name, joint) =>
    assert(Math.abs(plan.samples.position[9 * sample + joint] - cell(name)) < 1e-6, `${name} of ${sample}`),
  );
  assert.equal(plan.samples.line[sample], cell("line"));
});
assert(plan.samples.velocity.some((value) => value !== 0) && plan.samples.acceleration.every(Number.isFinite));
thrown(() => lostmotion.plan({ program, machine, onProgress: () => false }), "cancelled");

// Machines.
assert(lostmotion.presets().some(({ name, summary }) => name === "vmc3" && summary.length > 0));
assert(lostmotion.methods().some(({ name }) => name === "adaptive"));
const checked = lostmotion.machine(machine);
assert.equal(checked.json.axis.x.load.slide.gap_um, 40);
assert.deepEqual(lostmotion.problems(checked.toml), []);
assert.deepEqual(lostmotion.machine({ json: checked.json }).json, checked.json);
const worse = checked.toml.replace(/^jerk_mm_s3 = .*$/m, "jerk_mm_s3 = -1.0");
const [problem] = lostmotion.problems(worse, "mine.toml");
assert(problem.file === "mine.toml" && problem.line > 0 && problem.key.endsWith("jerk_mm_s3"));

const refused = (simulation, code, line) =>
  assert.throws(
    () => lostmotion.simulate(simulation),
    (error) => error instanceof LostmotionError && error.code === code && error.line === line,
  );
refused({ program: "G21\nG1 Z-\n", machine }, "missing-number", 2);
refused({ program, machine: { toml: "name = 3\n" } }, "machine", 1);
refused({ program, machine, settings: { tolerance: 3 } }, "option", 0);
refused({ program, machine, methods: ["nome"] }, "unknown-method", 0);
refused({ program, machine, onProgress: () => false }, "cancelled", 0);
const mine = new Error("mine");
assert.throws(
  () => lostmotion.simulate({ program, machine, onContour: () => { throw mine; } }),
  (error) => error === mine,
);
assert.equal(lostmotion.wasm.lm_handles(), 0);
console.log("wasm: figures are those of the command");
