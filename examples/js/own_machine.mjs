// The whole chain on a machine that is made in code: checked like a file.
//
// A plotter of two axes, first with a tight gap, then with a wide one. A description that makes no sense
// is refused with the keys of a machine file. As own_machine.rs.
//
//     node own_machine.mjs FOLDER     (a folder with lostmotion.js and lostmotion.wasm)

import { readFile } from "node:fs/promises";
import { pathToFileURL } from "node:url";
import { resolve } from "node:path";

const folder = resolve(process.argv[2]);
const { Lostmotion, LostmotionError } = await import(pathToFileURL(`${folder}/lostmotion.js`));
const lostmotion = await Lostmotion.load(await readFile(`${folder}/lostmotion.wasm`));

// The X axis of an embedded mill is a good start; every key of it may be changed.
const axis = lostmotion.machine({ preset: "vmc3" }).json.axis.x;
axis.limits = {
  min_mm: -200,
  max_mm: 200,
  velocity_mm_s: 150,
  acceleration_mm_s2: 1500,
  jerk_mm_s3: 30_000,
};
axis.load.slide.gap_um = 5;
const tight = {
  name: "plotter",
  kinematics: { kind: "cartesian" },
  axis: { x: axis, y: structuredClone(axis) },
};
const wide = structuredClone(tight);
wide.name = "worn plotter";
wide.axis.x.load.slide.gap_um = 40;

const program = "G21 G90 G17 G94\nG0 X30 Y0\nG3 I-30 P2 F2400\nM2\n";
for (const json of [tight, wide]) {
  const { result } = lostmotion.simulate({ name: "circle.ngc", program, machine: { json } });
  console.log(`${json.name}: ${result.method} leaves ${result.backlash.max.toFixed(1)} um of backlash at most`);
}

wide.axis.y.drive.position_gain_per_s = -1;
try {
  lostmotion.machine({ json: wide });
} catch (error) {
  if (!(error instanceof LostmotionError)) throw error;
  for (const { key, message } of error.findings) console.log(`${key}: ${message}`);
}
