// From curves to samples of every joint, one each command cycle (1 ms), within all limits of velocity,
// acceleration and jerk.
//
// A corner under G64 is rounded within its tolerance; under G61 the tool comes to rest in it. The
// difference in time is what the tolerance buys. As plan.rs.
//
//     node plan.mjs FOLDER     (a folder with lostmotion.js and lostmotion.wasm)

import { readFile } from "node:fs/promises";
import { pathToFileURL } from "node:url";
import { resolve } from "node:path";

const folder = resolve(process.argv[2]);
const { Lostmotion } = await import(pathToFileURL(`${folder}/lostmotion.js`));
const lostmotion = await Lostmotion.load(await readFile(`${folder}/lostmotion.wasm`));

for (const mode of ["G61", "G64 P0.005", "G64 P0.05"]) {
  const { durationS, cuttingMm, samples } = lostmotion.plan({
    name: "corner.ngc",
    program: `G21 G90 G94 ${mode}\nG0 X0 Y0 Z5\nG1 X30 F6000\nG1 Y30\nM2\n`,
    machine: { preset: "vmc3" },
  });
  // Nine joints a sample: X is the first.
  const peak = samples.timeS.reduce((most, _, n) => Math.max(most, Math.abs(samples.acceleration[9 * n])), 0);
  console.log(
    `${mode}: ${durationS.toFixed(3)} s for ${cuttingMm.toFixed(1)} mm of cutting, ` +
      `X accelerates with up to ${peak.toFixed(0)} mm/s2`,
  );
}
