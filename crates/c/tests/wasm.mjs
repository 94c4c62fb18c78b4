// The package in Node: figures to the bit, callbacks, errors, nothing left behind.
// wasm.mjs FOLDER PART DOCUMENT

import { readFile } from "node:fs/promises";
import assert from "node:assert/strict";

const [folder, part, wanted] = process.argv.slice(2);
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
