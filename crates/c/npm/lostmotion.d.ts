/** A machine: the name of an embedded one, the text of a machine file, or an object with its keys. */
export type Machine = { preset: string } | { toml: string } | { json: object };

/** Something that was found in a program or a machine file. */
export interface Finding {
  /** Stable name of the kind of finding. */
  code: string;
  /** What was found, with values. */
  message: string;
  /** What to do; may be empty. */
  hint: string;
  /** Name of the program or file. */
  file: string;
  /** The line that it is about; may be empty. */
  excerpt: string;
  /** The key of a machine file that it is about; empty for a program. */
  key: string;
  /** Whether it refuses the program or the machine. */
  isError: boolean;
  /** Line, from 1; 0 for the file as a whole. */
  line: number;
  /** Column in bytes, from 1; 0 where there is none. */
  column: number;
  /** Length in bytes. */
  length: number;
}

/** A program that is read, and how. */
export interface Reading {
  /** G-code. */
  program: string;
  /** Its name for messages. */
  name?: string;
  /** Its dialect, tools and parameters are used. */
  machine?: Machine;
  /** Options of the command that say how a program is read: `{ dialect: "fanuc" }`. */
  settings?: Record<string, unknown>;
}

/** A canonical operation, and the block that it comes from. */
export interface Operation {
  /** `STRAIGHT_FEED(10.0000, ...)`. */
  text: string;
  /** Line and column in bytes, from 1; 0 for what holds before the first block. */
  line: number;
  column: number;
  /** 0 for the program, n for the nth file of subroutines. */
  file: number;
}

/** A style of programs. */
export interface Style {
  /** Letters; `upper` if left out. */
  case?: "upper" | "lower" | "keep";
  /** Blanks for each level of O-words; 2 if left out. */
  indent?: number;
  /** Line numbers, or the step of new ones; `keep` if left out. */
  lineNumbers?: "keep" | "remove" | number;
}

/** A planned motion. */
export interface Plan {
  /** Length of the motion, s. */
  durationS: number;
  /** Length of cutting moves and of rapids, mm. */
  cuttingMm: number;
  rapidMm: number;
  /** One for each command cycle; nine joints X Y Z A B C U V W a sample, one sample after the other, mm
   * and deg. */
  samples: {
    timeS: Float64Array;
    position: Float64Array;
    /** Per s. */
    velocity: Float64Array;
    /** Per s2. */
    acceleration: Float64Array;
    /** Line of the block, from 1. */
    line: Uint32Array;
  };
}

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

/** What a compensator may know of its axis; angles in rad at the motor's shaft. */
export interface AxisFacts {
  /** Unit of positions. */
  unit: "mm" | "deg" | "rad";
  /** Angle of the motor for a unit of the axis, rad. */
  motorRadPerUnit: number;
  /** Time between two calls of `step`, s. */
  servoPeriodS: number;
  /** Total gap, rad. */
  gapRad: number;
  /** Inertia of motor and load, kg m2. */
  motorInertiaKgm2: number;
  loadInertiaKgm2: number;
  /** Coulomb friction of motor and load, N m. */
  motorCoulombNm: number;
  loadCoulombNm: number;
  /** Viscous friction of the load, N m s/rad, and the constant torque on it, N m. */
  loadViscousNmSPerRad: number;
  loadConstantNm: number;
  /** Stiffness, N m/rad, and damping, N m s/rad, of the shaft. */
  stiffnessNmPerRad: number;
  dampingNmSPerRad: number;
}

/** What a compensator sees at a servo tick: rad, rad/s, rad/s2 at the motor, A. */
export interface Tick {
  /** Reference, and that of the next tick. */
  position: number;
  velocity: number;
  acceleration: number;
  nextPosition: number;
  nextVelocity: number;
  nextAcceleration: number;
  /** Motor from its encoder, and its velocity as the drive computes it. */
  motorPosition: number;
  motorVelocity: number;
  /** Torque-forming current, and its mean over the last servo period. */
  current: number;
  meanCurrent: number;
  /** Load from its scale; NaN unless the compensator has `loadScale`. */
  loadPosition: number;
  /** Whether the drive was at a limit in the last period. */
  saturated: boolean;
}

/** What a compensator answers; 0 where it has nothing to say. */
export interface Correction {
  /** Added to the position reference, rad. */
  position?: number;
  /** Added to the velocity feed-forward, rad/s. */
  velocity?: number;
  /** Added to the torque feed-forward, N m. */
  torque?: number;
  /** Subtracted from the measured motor position, rad. */
  feedback?: number;
}

/** A compensator of your own. */
export interface Compensator {
  /** Name in the results. */
  name: string;
  /** Makes the state of an axis that stands at `motorPosition` rad. The library copies it where it tries a
   * motion ahead: what it carries from tick to tick has to be fields of its own, of plain data. */
  make: (facts: AxisFacts, motorPosition: number) => { step(tick: Tick): Correction | void };
  /** Whether it is shown the load's scale. */
  loadScale?: boolean;
}

export interface Simulation {
  /** G-code. */
  program: string;
  /** Its name for messages. */
  name?: string;
  machine: Machine;
  /** Compensation methods; those of the machine where none is named. */
  methods?: string[];
  /** Compensators of your own, beside the methods. What one throws ends the run and is thrown by it. */
  compensators?: Compensator[];
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
  /** Everything that was found. */
  readonly findings: Finding[];
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
  /** Plans a program: samples of every joint. `methods` and `onContour` are not used. */
  plan(simulation: Simulation): Plan;
  /** What is wrong with a program; with `lints`, or levels of lints by their codes, also what is allowed
   * and may break something. */
  findings(
    reading: Reading & { lints?: boolean; levels?: Record<string, "allow" | "warn" | "deny"> },
  ): Finding[];
  /** Canonical operations. Throws at the end of a program with errors. */
  operations(reading: Reading): Operation[];
  /** What a line does: the document of `lostmotion gcode explain`. */
  explain(reading: Reading & { line: number }): any;
  /** A program in one style. */
  format(program: string, style?: Style): string;
  /** A program with everything computed; `system` is 1 for G54 to 9 for G59.3, 1 if left out. */
  resolved(reading: Reading & { system?: number }): string;
  /** Embedded machines, each with a line about it. */
  presets(): { name: string; summary: string }[];
  /** Compensation methods, each with a line about it. */
  methods(): { name: string; summary: string }[];
  /** All that is wrong with the text of a machine file; an empty list for one that holds. */
  problems(toml: string, name?: string): Finding[];
  /** A machine that was checked: its keys, its file, and what a commissioning engineer would object to. */
  machine(description: Machine): { json: any; toml: string; remarks: string[] };
}
