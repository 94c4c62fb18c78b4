/** A machine: the name of an embedded one, or the text of a machine file. */
export type Machine = { preset: string } | { toml: string };

/** How far a run is. */
export interface Progress {
  /** Bytes of the program read so far, and all of them. */
  doneBytes: number;
  totalBytes: number;
  /** Machine time so far, s. */
  simulatedS: number;
}

/** Contour errors of a method, one value a servo tick; the arrays are copies. */
export interface Contour {
  /** Number of the method in the order given. */
  method: number;
  timeS: Float64Array;
  /** um: positive to the left of the direction of travel. */
  errorUm: Float64Array;
  /** Actual tip from the program's zero, mm: x, y, z of each tick one after the other. */
  actualMm: Float64Array;
  /** Line of the block, from 1. */
  line: Uint32Array;
}

export interface Simulation {
  /** G-code. */
  program: string;
  /** Its name for messages. */
  name?: string;
  machine: Machine;
  /** Compensation methods; those of the machine where none is named. */
  methods?: string[];
  /** Options of the command by their names: numbers, texts, lists and tables. */
  settings?: Record<string, unknown>;
  /** Told about once a second of motion; `false` ends the run. */
  onProgress?: (progress: Progress) => boolean | void;
  /** Takes contour errors as they are made; `false` ends the run. */
  onContour?: (contour: Contour) => boolean | void;
}

/** Why there is no result. */
export class LostmotionError extends Error {
  /** Stable name of the reason. */
  readonly code: string;
  /** What to do; may be empty. */
  readonly hint: string;
  /** File, line and column (from 1) of the first finding; 0 without a place. */
  readonly file: string;
  readonly line: number;
  readonly column: number;
}

export class Lostmotion {
  /** From the bytes of `lostmotion.wasm`, a compiled module, or a response of `fetch`. */
  static load(source: BufferSource | WebAssembly.Module | Response): Promise<Lostmotion>;
  /** Version of the library. */
  readonly version: string;
  /** Runs a program, and answers the document of the command (its JSON Schema is the command's). */
  simulate(simulation: Simulation): any;
  /** The text that the command prints. */
  report(simulation: Simulation): string;
}
