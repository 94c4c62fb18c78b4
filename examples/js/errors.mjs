// What is refused, and how a program learns of it: everything is a LostmotionError with a code, a place and
// a hint, and `findings` with all that was found.
//
//     node errors.mjs FOLDER     (a folder with lostmotion.js and lostmotion.wasm)

import { readFile } from "node:fs/promises";
import { pathToFileURL } from "node:url";
import { resolve } from "node:path";

const folder = resolve(process.argv[2]);
const { Lostmotion, LostmotionError } = await import(pathToFileURL(`${folder}/lostmotion.js`));
const lostmotion = await Lostmotion.load(await readFile(`${folder}/lostmotion.wasm`));

const good = { program: "G21 G90\nG0 X25\nG3 I-25 F2000\nM2\n", machine: { preset: "vmc3" } };
const tries = {
  "a mistake in the program": { ...good, program: "G21\nG1 Z-\n" },
  "no such machine": { ...good, machine: { preset: "vmc" } },
  "a key of a machine file": { ...good, machine: { toml: 'name = "mine"\nkinematic = 3\n' } },
  "an option": { ...good, settings: { tolerence_um: 5 } },
  "a method": { ...good, methods: ["adaptiv"] },
  "ended from outside": { ...good, onProgress: () => false },
};
for (const [what, simulation] of Object.entries(tries)) {
  try {
    lostmotion.simulate(simulation);
  } catch (error) {
    if (!(error instanceof LostmotionError)) throw error;
    const place = error.line > 0 ? `, line ${error.line}, column ${error.column}` : "";
    console.log(`${what}: ${error.code}${place}, found ${error.findings.length}`);
  }
}

// What a callback throws comes out as it is, and nothing is left behind.
try {
  lostmotion.simulate({
    ...good,
    onContour: () => {
      throw new Error("mine");
    },
  });
} catch (error) {
  console.log(`a callback: ${error.message}`);
}
