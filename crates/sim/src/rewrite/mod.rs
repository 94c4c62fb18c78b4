//! A part program for a control without compensation: rewritten so that the tool keeps the contour.
//!
//! Where the load follows by friction, it is behind the motor by half the gap b on each axis:
//! `load = motor - s b`, s the direction of the axis. So each end point is moved by `s b` of the axes
//! on the way there, arcs are cut where an axis of theirs reverses, and between two pieces the axis
//! that has reversed moves by its whole gap: while the motor crosses, the tool stands.
//!
//! ```text
//! lines     the program as lines; what cannot be moved is refused by its line      (text.rs)
//! refusals  all that is refused, in one run                                        (refusals.rs)
//! pieces    moves of the front end, cut at reversals, with the directions on them     (pieces.rs)
//! writer    end points moved, take-ups put in: as rapids where nothing is cut          (writer.rs)
//! heights   above which X and Y may go beyond their places                         (heights.rs)
//! again     the new text read again: its end points against those meant                 (again.rs)
//! judge     the machine's tool on the new program against the contour of the original (judge.rs)
//! normal    what is left of each piece besides the gap, taken off along its normal    (normal.rs)
//! ```
//! The last three go round while that makes the error smaller.
//! The new text is read again and its end points held against the pieces before anything else is
//! done with it.

mod again;
mod heights;
mod judge;
mod normal;
mod pieces;
mod refusals;
pub mod results;
mod text;
mod writer;

use crate::error::SimError;
use crate::machine::Machine;
use crate::motion::interpreter_config;
use crate::options::SimulateOptions;
use crate::program::Program;
use crate::recommend::{WIDEST, uncertainty, with_gap_times};
use again::{of_new, read_again};
use judge::{Judged, judge, no_help};
use lostmotion_base::AxisId;
use lostmotion_base::units::UM_PER_MM;
use lostmotion_gcode::Dialect;
use lostmotion_methods::{AxisConfig, USUAL_SHARE};
use normal::{Normals, Off, Shifts};
use pieces::{Original, Stretch, original_lines, refuse_in_place, steps, stretches};
use refusals::Refusals;
use results::{LeavesWith, Rewritten};
use text::{TextLines, lines};
use writer::new_text;

/// X, Y and Z: the axes that are moved.
const AXES: [AxisId; 3] = [AxisId::X, AxisId::Y, AxisId::Z];
/// Half the last digit, and rounding, mm.
const ROUNDING_MM: f64 = 2e-4;
/// Bytes of a program's text for each move at most. A choice: lines of five axes with comments have 60.
const BYTES_OF_A_MOVE: u64 = 100;
/// Rounds of taking off what is left along the normal. A choice: the first two take off most of it.
const ROUNDS: usize = 4;
/// Part of the RMS that a round has to gain, and part of the original's largest error by which the largest
/// may grow meanwhile. Choices.
const LEAST_ROUND: f64 = 0.03;
const MAX_SHARE: f64 = 0.1;
/// Way of an axis that is none, mm.
const STILL_MM: f64 = 1e-7;

/// How a program is rewritten.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RewriteOptions {
    /// Most that an end point is moved along an axis, um: more than half a gap of this size is refused.
    pub most_um: f64,
    /// Most that an end point is moved against what is left besides the gap, along the normal of the
    /// contour, um; 0 leaves that.
    pub most_normal_um: f64,
    /// How far off the gaps may be, as a part of them, below 1; as each axis says if `None`.
    pub gap_uncertainty: Option<f64>,
    /// Most moves of a program: they are held in memory, as is its text, of a hundred bytes a move at most.
    pub max_moves: usize,
}

impl Default for RewriteOptions {
    fn default() -> RewriteOptions {
        RewriteOptions {
            most_um: 100.0,
            most_normal_um: 20.0,
            gap_uncertainty: None,
            max_moves: 1_000_000,
        }
    }
}

/// Why a program is not rewritten.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RewriteError {
    /// What stands on a line is not rewritten.
    #[error("line {line}{}: {what}", column.map_or_else(String::new, |column| format!(", column {column}")))]
    Line {
        /// The line, from 1.
        line: usize,
        /// The column, from 1; `None` for all of the line.
        column: Option<usize>,
        /// What it is.
        what: String,
    },
    /// Several lines are not rewritten, in their order.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    Lines(Vec<RewriteError>),
    /// The machine does not fit.
    #[error("{0}")]
    Machine(String),
    /// The program cannot be run.
    #[error(transparent)]
    Sim(#[from] SimError),
}

/// What is written: the moves of the original in pieces, and by how much their ends are moved.
struct Moves<'a> {
    steps: &'a [Original],
    pieces: &'a [Vec<Stretch>],
    shifts: &'a Shifts,
    half: [f64; 3],
    /// Ends of the travel, machine coordinates, mm.
    travel: [[f64; 2]; 3],
}

impl Judged {
    /// Whether a further round was worth it: with a largest error that is allowed the RMS is smaller.
    fn is_better_than(&self, other: &Judged, most_um: f64) -> bool {
        self.stop.is_none()
            && self.leaves.rms_um < (1.0 - LEAST_ROUND) * other.leaves.rms_um
            && self.leaves.max_um <= most_um
    }
}

/// The new program, and where its lines come from.
#[derive(Debug, Default)]
struct Text {
    text: Vec<u8>,
    /// For each line the original move that it is on.
    steps: Vec<Option<usize>>,
    /// End points of its moves in machine coordinates, as they are meant, by their line.
    ends: Vec<(usize, [f64; 3])>,
}

/// Rewrites a program for a machine whose control has no compensation, and simulates both.
///
/// ```
/// use lostmotion_sim::rewrite::{RewriteOptions, rewrite};
/// use lostmotion_sim::{Machine, Program, SimulateOptions};
///
/// let program = Program::from_str("arc.ngc", "G21 G90 G17\nG0 X9 Y0\nG3 X9 Y0 I-9 J0 F900\nM2\n");
/// let machine = Machine::preset("vmc3-worn")?;
/// let options = SimulateOptions::default();
/// let new = rewrite(&program, &machine, &options, &RewriteOptions::default())?;
/// assert!(new.refused.is_none() && new.after.rms_um < 0.6 * new.before.rms_um);
/// assert!(new.text.contains("(backlash of Y"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// A line that is not rewritten, a program that was rewritten before, a machine whose joints do not go with X, Y and Z or whose control
/// compensates already, and all errors of a run. A new program that does not help is no error:
/// [`Rewritten::refused`].
pub fn rewrite(
    program: &Program,
    machine: &Machine,
    options: &SimulateOptions,
    wanted: &RewriteOptions,
) -> Result<Rewritten, RewriteError> {
    let half = half_gaps(machine, wanted)?;
    // The text is held beside its moves.
    let most_bytes = BYTES_OF_A_MOVE.saturating_mul(wanted.max_moves as u64);
    if let Some(bytes) = program.len().ok().filter(|bytes| *bytes > most_bytes) {
        let what = format!(
            "the program has {bytes} bytes, more than {} moves take",
            wanted.max_moves
        );
        return Err(SimError::refused(
            what,
            "allow more moves with --max-moves, half a kilobyte of memory each",
        )
        .into());
    }
    let source = program.bytes().map_err(|source| SimError::Read {
        name: program.name().to_owned(),
        source,
    })?;
    let mut refusals = Refusals::default();
    let lines = lines(
        &source,
        &interpreter_config(machine, options),
        &mut refusals,
    )?;
    let (steps, pieces) = moves(
        program,
        machine,
        options,
        &lines,
        wanted.max_moves,
        refusals,
    )?;
    let dialect = options.dialect.unwrap_or(machine.dialect());
    let all_told = machine.axes().iter().map(|axis| {
        let share = uncertainty(&axis.config, wanted.gap_uncertainty);
        (share, axis.id)
    });
    let told = all_told.fold(
        (0.0, AxisId::X),
        |most, own| {
            if own.0 > most.0 { own } else { most }
        },
    );
    let work = Work {
        program,
        machine,
        options,
        of_original: original_lines(&lines.all, &steps),
        lines,
        steps,
        pieces,
        dialect,
        half,
        wanted_of_gap: wanted.gap_uncertainty,
        told,
        shares: shares(machine, wanted.gap_uncertainty),
        untold: untold(machine, wanted.gap_uncertainty),
        least: (told.0 > 0.0).then(|| {
            machine.map_axes(|config| {
                let share = uncertainty(config, wanted.gap_uncertainty);
                with_gap_times(config, 1.0 - share)
            })
        }),
    };
    let before = work.judged_original(machine)?;
    let mut normals = Normals::new(&work.steps, &work.pieces);
    let plain = work.attempt(&Shifts::default(), &normals)?;
    let mut best = None;
    if wanted.most_normal_um > 0.0 && plain.judged.stop.is_none() {
        let tolerance_um = plain.answer.tolerance_um;
        let most_um = plain.judged.leaves.max_um + MAX_SHARE * before.leaves.max_um;
        let most_um = if plain.judged.leaves.max_um <= tolerance_um {
            most_um.min(tolerance_um)
        } else {
            most_um
        };
        let mut off = work.off(&plain, &normals)?;
        for round in 1..=ROUNDS {
            normals.take(&off);
            let shifts = normals.shifts(half, wanted.most_normal_um / UM_PER_MM);
            // What cannot be written so is left as it is.
            let Ok(next) = work.attempt(&shifts, &normals) else {
                break;
            };
            // An axis that friction holds follows only once its drive is wound up again: a round may be
            // worse than the one before.
            if round < ROUNDS {
                off = work.off(&next, &normals)?;
            }
            let last = best.as_ref().unwrap_or(&plain);
            if next.judged.is_better_than(&last.judged, most_um) {
                best = Some(next);
            }
        }
    }
    if let Some(best) = best {
        let answer = work.verdict(&before, best)?;
        if answer.refused.is_none() {
            return Ok(answer);
        }
    }
    work.verdict(&before, plain)
}

/// The moves of a program and their pieces.
///
/// # Errors
/// All lines that are not rewritten, with those that are refused already.
fn moves(
    program: &Program,
    machine: &Machine,
    options: &SimulateOptions,
    lines: &TextLines,
    max_moves: usize,
    mut refusals: Refusals,
) -> Result<(Vec<Original>, Vec<Vec<Stretch>>), RewriteError> {
    let steps = match steps(program, machine, options, lines, max_moves, &mut refusals) {
        Ok(steps) => steps,
        // What follows from a refused line is not told besides.
        Err(error) => return Err(refusals.told().unwrap_or_else(|| lines.placed(error))),
    };
    let pieces: Vec<Vec<Stretch>> = steps
        .iter()
        .map(|step| {
            stretches(step).unwrap_or_else(|error| {
                refusals.add(lines.placed(error));
                Vec::new()
            })
        })
        .collect();
    refuse_in_place(lines, &steps, &pieces, &mut refusals);
    refusals.told().map_or(Ok((steps, pieces)), Err)
}

/// What a program is rewritten from.
struct Work<'a> {
    program: &'a Program,
    machine: &'a Machine,
    options: &'a SimulateOptions,
    lines: TextLines,
    steps: Vec<Original>,
    pieces: Vec<Vec<Stretch>>,
    /// For each line of the original the move that it is on.
    of_original: Vec<Option<usize>>,
    dialect: Dialect,
    half: [f64; 3],
    /// How far off all gaps may be, as a part of them, where that is wanted.
    wanted_of_gap: Option<f64>,
    /// How far off a gap may be at most, as a part of it, and of which axis; 0 where nobody tells.
    told: (f64, AxisId),
    /// How far off the gaps of X, Y and Z may be in the runs at both ends, as a part of them.
    shares: [f64; 3],
    /// Axes with a gap of which nobody says how far off it may be.
    untold: Vec<String>,
    /// The machine with the least gaps that it may have, where that is told.
    least: Option<Machine>,
}

/// A new program, as the machine runs it.
struct Attempt {
    answer: Rewritten,
    new: Program,
    /// For each of its lines the original move that it is on.
    of_lines: Vec<Option<usize>>,
    judged: Judged,
}

impl Work<'_> {
    fn judged_original(&self, machine: &Machine) -> Result<Judged, RewriteError> {
        let (options, steps) = (self.options, &self.steps);
        judge(
            self.program,
            machine,
            options,
            steps,
            &self.of_original,
            None,
        )
    }

    /// Writes the program with displacements, reads it again, and runs it.
    fn attempt(&self, shifts: &Shifts, normals: &Normals<'_>) -> Result<Attempt, RewriteError> {
        let (options, machine) = (self.options, self.machine);
        let mut answer = Rewritten {
            schema: 1,
            program: self.program.name().to_owned(),
            machine: machine.name().to_owned(),
            tolerance_um: options
                .tolerance_um
                .unwrap_or(machine.simulate().tolerance_um),
            shift_mm: self.half,
            normal_um: UM_PER_MM * shifts.most(),
            ..Rewritten::default()
        };
        let moves = Moves {
            steps: &self.steps,
            pieces: &self.pieces,
            shifts,
            half: self.half,
            travel: AXES.map(|id| {
                let limits = machine.axis(id).map(|axis| axis.limits_table().limits());
                limits.map_or([f64::NEG_INFINITY, f64::INFINITY], |limits| {
                    [limits.min, limits.max]
                })
            }),
        };
        let text = new_text(&self.lines, &moves, self.dialect, &mut answer);
        answer.text = String::from_utf8_lossy(&text.text).into_owned();
        answer.bytes.clone_from(&text.text);
        let new = Program::from_bytes(self.program.name(), text.text.as_slice());
        let (steps, of_lines) = (&self.steps, &text.steps);
        read_again(&new, machine, options, &text, steps)?;
        let judged = judge(&new, machine, options, steps, of_lines, Some(normals));
        let judged = judged.map_err(|error| of_new(error, of_lines, steps))?;
        Ok(Attempt {
            answer,
            new,
            of_lines: text.steps,
            judged,
        })
    }

    /// What a new program leaves of each piece besides the gap. What a gap may be more than the least is no
    /// wind-up: it stays.
    fn off(&self, attempt: &Attempt, normals: &Normals<'_>) -> Result<Vec<Off>, RewriteError> {
        let Some(least) = &self.least else {
            return Ok(attempt.judged.off.clone());
        };
        let (new, of_lines, steps) = (&attempt.new, &attempt.of_lines, &self.steps);
        Ok(judge(new, least, self.options, steps, of_lines, Some(normals))?.off)
    }

    /// Whether a new program is good to use: on the machine as it is described, and with smaller and
    /// larger gaps.
    fn verdict(&self, before: &Judged, attempt: Attempt) -> Result<Rewritten, RewriteError> {
        let (machine, options) = (self.machine, self.options);
        let Attempt {
            mut answer,
            new,
            of_lines,
            judged: after,
        } = attempt;
        (answer.before, answer.time_before_s) = (before.leaves, before.duration_s);
        (answer.after, answer.time_after_s) = (after.leaves, after.duration_s);
        if let Some(stop) = &after.stop {
            answer.refused = Some(format!("the machine would stop: {stop}"));
            return Ok(answer);
        }
        let (told, of_axis) = self.told;
        answer.untold.clone_from(&self.untold);
        answer.is_uncertainty_told = self.untold.is_empty();
        let unknown = (told > WIDEST).then(|| {
            format!(
                "it does not help enough: a gap that may be off by {:.0} % (that of {of_axis}) is as good as unknown, and so little of it is taken up; measure it",
                100.0 * told
            )
        });
        answer.refused = unknown.or_else(|| no_help(before, &after, &self.steps, ""));
        for sign in [-1.0, 1.0] {
            // Gaps that the user knows to the last micrometre have no ends.
            if self.shares.iter().all(|share| *share == 0.0) {
                break;
            }
            let factors = self.shares.map(|share| 1.0 + sign * share);
            let end = machine.map_axes(|config| {
                with_gap_times(config, 1.0 + sign * share_of(config, self.wanted_of_gap))
            });
            let before = self.judged_original(&end)?;
            let after = judge(&new, &end, options, &self.steps, &of_lines, None)?;
            let when = when(&factors);
            let stops = after
                .stop
                .as_ref()
                .map(|stop| format!("the machine would stop{when}: {stop}"));
            let refused = stops.or_else(|| no_help(&before, &after, &self.steps, &when));
            answer.refused = answer.refused.or(refused);
            answer.uncertain.push(LeavesWith {
                factor: 1.0 + sign * self.shares.into_iter().fold(0.0, f64::max),
                factors,
                before: before.leaves,
                after: after.leaves,
            });
        }
        Ok(answer)
    }
}

/// How far off the gap of an axis may be in the runs at both ends, as a part of it: as told, the usual where
/// nobody says.
fn share_of(config: &AxisConfig, wanted: Option<f64>) -> f64 {
    match uncertainty(config, wanted) {
        0.0 if wanted.is_none() => USUAL_SHARE,
        share => share,
    }
}

/// The same of X, Y and Z; an axis without a gap has that of the widest, to be one figure with it.
fn shares(machine: &Machine, wanted: Option<f64>) -> [f64; 3] {
    let own = AXES.map(|id| {
        let axis = machine.axis(id);
        let axis = axis.filter(|axis| axis.config.reflected_load().gap_rad > 0.0)?;
        Some(share_of(&axis.config, wanted))
    });
    let widest = own.into_iter().flatten().fold(0.0, f64::max);
    own.map(|share| share.unwrap_or(widest))
}

/// Axes with a gap of which nobody says how far off it may be.
fn untold(machine: &Machine, wanted: Option<f64>) -> Vec<String> {
    let axes = machine.axes().iter().filter(|axis| {
        let config = &axis.config;
        config.reflected_load().gap_rad > 0.0
            && wanted.is_none()
            && uncertainty(config, wanted) == 0.0
    });
    axes.map(|axis| axis.id.to_string()).collect()
}

/// Where the true gaps are these parts of those described: one figure where all have the same.
fn when(factors: &[f64; 3]) -> String {
    let [x, y, z] = factors.map(|factor| format!("{:.0} %", 100.0 * factor));
    if x == y && y == z {
        format!(" where the true gaps are {x} of those described")
    } else {
        format!(" where the true gaps are {x} in X, {y} in Y and {z} in Z of those described")
    }
}

/// Half of the least that the gaps of X, Y and Z may be, mm.
fn half_gaps(machine: &Machine, wanted: &RewriteOptions) -> Result<[f64; 3], RewriteError> {
    let refuse = |what: String| Err(RewriteError::Machine(what));
    let name = machine.name();
    if machine.kinematics().kind() != "cartesian" {
        return refuse(format!(
            "the joints of machine \"{name}\" are not X, Y and Z (kinematics \"{}\"): end points cannot be moved by the gap of an axis",
            machine.kinematics().kind()
        ));
    }
    if machine
        .axes()
        .iter()
        .any(|axis| !axis.config.compensation.method.is_baseline())
    {
        return refuse(format!(
            "the control of machine \"{name}\" compensates already (compensation.method is {}): a rewritten program would compensate twice",
            machine.method_names()
        ));
    }
    if let Some(share) = wanted.gap_uncertainty
        && !(0.0..1.0).contains(&share)
    {
        return refuse(format!(
            "the gap's uncertainty is {share}; it has to be from 0 to below 1"
        ));
    }
    let mut half = [0.0; 3];
    for (half, id) in half.iter_mut().zip(AXES) {
        let Some(axis) = machine.axis(id) else {
            continue;
        };
        let second = machine.gantry().filter(|gantry| gantry.axis == id);
        let configs = std::iter::once(&axis.config).chain(second.map(|gantry| &gantry.second));
        // Of two motors the smaller gap: what both have.
        *half = configs
            .map(|config| {
                let units =
                    config.reflected_load().gap_rad / config.transmission.motor_rad_per_unit();
                0.5 * units * (1.0 - uncertainty(config, wanted.gap_uncertainty))
            })
            .fold(f64::INFINITY, f64::min);
        if *half * UM_PER_MM > wanted.most_um {
            return refuse(format!(
                "half the gap of {id} is {:.1} um, more than the {} um by which end points may be moved",
                *half * UM_PER_MM,
                wanted.most_um
            ));
        }
    }
    if half == [0.0; 3] {
        return refuse(format!(
            "machine \"{name}\" has no gap in X, Y and Z: there is nothing to take up"
        ));
    }
    Ok(half)
}
