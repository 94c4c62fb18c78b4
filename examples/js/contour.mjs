// Samples as they are made: the contour error of every servo tick, in pieces of about a second of motion,
// added up by block, so that memory does not grow with the program.
//
//     node contour.mjs FOLDER     (a folder with lostmotion.js and lostmotion.wasm)

import { readFile } from "node:fs/promises";
import { pathToFileURL } from "node:url";
import { resolve } from "node:path";

const folder = resolve(process.argv[2]);
const { Lostmotion } = await import(pathToFileURL(`${folder}/lostmotion.js`));
const lostmotion = await Lostmotion.load(await readFile(`${folder}/lostmotion.wasm`));

const program = "G21 G90 G17 G94 G64 P0.005\nG0 X15 Y0 Z5\nG3 I-15 F1800\nG1 X0 Y15\nG1 X-15 Y0\nM2\n";
const methods = ["none", "fixed"];
const blocks = methods.map(() => new Map());
lostmotion.simulate({
  program,
  machine: { preset: "vmc3-worn" },
  methods,
  onContour: ({ method, errorUm, line }) => {
    errorUm.forEach((error, tick) => {
      const block = blocks[method].get(line[tick]) ?? { ticks: 0, squares: 0, most: 0 };
      block.ticks += 1;
      block.squares += error * error;
      block.most = Math.max(block.most, Math.abs(error));
      blocks[method].set(line[tick], block);
    });
  },
});
const texts = program.split("\n");
methods.forEach((method, index) => {
  for (const [line, { ticks, squares, most }] of blocks[index])
    if (texts[line - 1].match(/G[13] /))
      console.log(
        `${method}, line ${line} \`${texts[line - 1]}\`: ${most.toFixed(1)} um at most, RMS ${Math.sqrt(squares / ticks).toFixed(1)} um`,
      );
});
