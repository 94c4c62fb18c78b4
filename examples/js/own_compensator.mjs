// The whole chain with a compensator of one's own, held against the library's.
//
// A compensator runs at the servo rate: it sees what a drive sees and answers with a correction. This one
// adds half the gap at once where the commanded velocity changes its sign. As own_compensator.rs.
//
//     node own_compensator.mjs FOLDER     (a folder with lostmotion.js and lostmotion.wasm)

import { readFile } from "node:fs/promises";
import { pathToFileURL } from "node:url";
import { resolve } from "node:path";

const folder = resolve(process.argv[2]);
const { Lostmotion } = await import(pathToFileURL(`${folder}/lostmotion.js`));
const lostmotion = await Lostmotion.load(await readFile(`${folder}/lostmotion.wasm`));

class Step {
  constructor(facts) {
    this.halfGap = 0.5 * facts.gapRad;
    // the direction of the last motion: what it carries from tick to tick
    this.direction = 0;
  }

  step({ velocity }) {
    if (Math.abs(velocity) > 1e-6) this.direction = Math.sign(velocity);
    return { position: this.direction * this.halfGap };
  }
}

const run = lostmotion.simulate({
  name: "circle.ngc",
  program: "G21 G90 G17 G94\nG0 X20 Y0 Z5\nG3 I-20 P3 F1500\nM2\n",
  machine: { preset: "vmc3-worn" },
  methods: ["none", "fixed"],
  compensators: [{ name: "step", make: (facts) => new Step(facts) }],
});
for (const { method, backlash } of run.results)
  console.log(`${method}: backlash RMS ${backlash.rms.toFixed(1)} um`);
console.log(`recommended: ${run.recommended ?? "-"}`);
