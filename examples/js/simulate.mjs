// The whole chain in JavaScript: from a part program to its contour error, block by block. For Node; a
// page hands `await fetch("lostmotion.wasm")` to `load`, best in a worker. As simulate.rs.
//
//     node simulate.mjs FOLDER     (a folder with lostmotion.js and lostmotion.wasm)

import { readFile } from "node:fs/promises";
import { pathToFileURL } from "node:url";
import { resolve } from "node:path";

const folder = resolve(process.argv[2]);
const { Lostmotion, LostmotionError } = await import(pathToFileURL(`${folder}/lostmotion.js`));
const lostmotion = await Lostmotion.load(await readFile(`${folder}/lostmotion.wasm`));

const run = lostmotion.simulate({
  name: "part.ngc",
  program:
    "G21 G90 G17 G94 G64 P0.005\nG0 X15 Y0 Z5\nG3 I-15 F1800\nG1 X0 Y15\nG1 X-15 Y0\nM2\n",
  machine: { preset: "vmc3" },
  methods: ["none"],
  settings: { tolerance_um: 10 },
  onProgress: (progress) => progress.simulatedS <= 3600,
});

const signed = (value) => (value < 0 || Object.is(value, -0) ? "" : "+") + value.toFixed(1);
console.log(`${run.result.within_tolerance ? "within" : "outside"} ${run.tolerance_um} um`);
for (const { block, text, max_um, parts_um } of run.result.worst_blocks)
  console.log(
    `line ${block.span.line} \`${text}\`: ${signed(max_um)} um = command ${signed(parts_um.command)}, ` +
      `servo ${signed(parts_um.servo)}, backlash ${signed(parts_um.backlash)}`,
  );

try {
  lostmotion.simulate({ program: "G21\nG1 Z-\n", machine: { preset: "vmc3" } });
} catch (error) {
  if (!(error instanceof LostmotionError)) throw error;
  console.log(`${error.code}: line ${error.line}, column ${error.column}`);
}
