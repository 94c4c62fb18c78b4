// The package in a worker, so that the page stays awake: takes `{ program, preset, methods }`, tells how far
// it is, and answers the worst blocks of each method or why there are none.

import { Lostmotion, LostmotionError } from "./lostmotion.js";

const loaded = fetch("lostmotion.wasm").then((response) => Lostmotion.load(response));

self.onmessage = async ({ data: { program, preset, methods } }) => {
  try {
    const lostmotion = await loaded;
    const run = lostmotion.simulate({
      program,
      machine: { preset },
      methods,
      onProgress: ({ doneBytes, totalBytes }) => self.postMessage({ share: doneBytes / totalBytes }),
    });
    const results = run.results.map(({ method, cutting, worst_blocks }) => ({
      method,
      mostUm: cutting.max,
      blocks: worst_blocks.map(({ block, text, max_um }) => ({ line: block.span.line, text, maxUm: max_um })),
    }));
    self.postMessage({ toleranceUm: run.tolerance_um, results });
  } catch (error) {
    if (!(error instanceof LostmotionError)) throw error;
    const { code, message, hint, line, column } = error;
    self.postMessage({ refused: { code, message, hint, line, column } });
  }
};
