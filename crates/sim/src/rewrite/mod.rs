//! A part program for a control without compensation: rewritten so that the tool keeps the contour.
//!
//! Where the load follows by friction, it is behind the motor by half the gap b on each axis:
//! `load = motor - s b`, s the direction of the axis. So each end point is moved by `s b` of the axes
//! on the way there, arcs are cut where an axis of theirs reverses, and between two pieces the axis
//! that has reversed moves by its whole gap: while the motor crosses, the tool stands.
//!
//! ```text
//! lines     the program as lines; what cannot be moved is refused by its line      (text.rs)
//! pieces    moves of the front end, cut at reversals, with the directions on them
//! writer    end points moved, take-ups put in: as rapids where nothing is cut          (writer.rs)
//! judge     the machine's tool on the new program against the contour of the original (judge.rs)
//! ```
//! The new text is read again and its end points held against the pieces before anything else is
//! done with it.

mod judge;
pub mod results;
mod text;
mod writer;

use crate::error::SimError;
use crate::machine::Machine;
use crate::motion::{ProgrammedMove, reversals};
use crate::options::SimulateOptions;
use crate::program::Program;
use crate::recommend::{uncertainty, with_gap_times};
use crate::results::HARM_UM;
use crate::simulation::Simulation;
use judge::judge;
use lostmotion_base::AxisId;
use lostmotion_base::units::UM_PER_MM;
use lostmotion_methods::USUAL_SHARE;
use lostmotion_path::Curve;
use results::{Leaves, LeavesWith, Rewritten};
use text::{Line, lines, refuse};
use writer::{LETTERS, new_text};

/// X, Y and Z: the axes that are moved.
const AXES: [AxisId; 3] = [AxisId::X, AxisId::Y, AxisId::Z];
/// Half the last digit, and rounding, mm.
const ROUNDING_MM: f64 = 2e-4;
/// Bytes of a program's text for each move at most. A choice: lines of five axes with comments have 60.
const BYTES_OF_A_MOVE: u64 = 100;
/// Part of the RMS that has to be gained. A choice: less is not worth another program.
const LEAST_GAIN: f64 = 0.1;
/// Change of an arc's radius up to which it is cut as a circle, mm.
const SPIRAL_MM: f64 = 2e-3;
/// Way of an axis that is none, mm.
const STILL_MM: f64 = 1e-7;

/// How a program is rewritten.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RewriteOptions {
    /// Most that an end point is moved along an axis, um: more than half a gap of this size is refused.
    pub most_um: f64,
    /// How far off the gaps may be, as a part of them, below 1; as each axis says if `None`.
    pub gap_uncertainty: Option<f64>,
    /// Most moves of a program: they are held in memory, as is its text, of a hundred bytes a move at most.
    pub max_moves: usize,
}

impl Default for RewriteOptions {
    fn default() -> RewriteOptions {
        RewriteOptions {
            most_um: 100.0,
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
    #[error("line {line}: {what}")]
    Line {
        /// The line, from 1.
        line: usize,
        /// What it is.
        what: String,
    },
    /// The machine does not fit.
    #[error("{0}")]
    Machine(String),
    /// The program cannot be run.
    #[error(transparent)]
    Sim(#[from] SimError),
}

/// A move of the original program.
#[derive(Clone, Debug)]
struct Original {
    curve: Curve,
    line: usize,
    rapid: bool,
    /// Machine less program coordinates, mm.
    shift: [f64; 3],
}

/// Part of a move on which no axis reverses.
#[derive(Clone, Copy, Debug)]
struct Stretch {
    start: [f64; 3],
    end: [f64; 3],
    direction: [f64; 3],
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
    let source = program.text().map_err(|source| SimError::Read {
        name: program.name().to_owned(),
        source,
    })?;
    let lines = lines(source.as_bytes(), &options.limits)?;
    let steps = steps(program, machine, options, &lines, wanted.max_moves)?;
    let dialect = options.dialect.unwrap_or(machine.dialect());
    let mut answer = Rewritten {
        schema: 1,
        program: program.name().to_owned(),
        machine: machine.name().to_owned(),
        tolerance_um: options
            .tolerance_um
            .unwrap_or(machine.simulate().tolerance_um),
        shift_mm: half,
        ..Rewritten::default()
    };
    let text = new_text(&lines, &steps, half, dialect, &mut answer)?;
    answer.text = String::from_utf8_lossy(&text.text).into_owned();
    let new = Program::from_str(program.name(), &answer.text);
    read_again(&new, machine, options, &text)?;
    // Both on the machine as it is described, and with smaller and larger gaps.
    let of_original: Vec<Option<usize>> = original_lines(&lines, &steps);
    let both = |machine: &Machine| -> Result<[(Leaves, f64, Option<String>); 2], RewriteError> {
        Ok([
            judge(program, machine, options, &steps, &of_original)?,
            judge(&new, machine, options, &steps, &text.steps)?,
        ])
    };
    let [before, after] = both(machine)?;
    (answer.before, answer.time_before_s) = (before.0, before.1);
    (answer.after, answer.time_after_s) = (after.0, after.1);
    if let Some(stop) = after.2 {
        answer.refused = Some(format!("the machine would stop: {stop}"));
        return Ok(answer);
    }
    answer.refused = no_help(&answer.before, &answer.after, "");
    let told = machine
        .axes()
        .iter()
        .map(|axis| uncertainty(&axis.config, wanted.gap_uncertainty))
        .fold(0.0, f64::max);
    answer.is_uncertainty_told = told > 0.0;
    let share = if told > 0.0 { told } else { USUAL_SHARE };
    for factor in [1.0 - share, 1.0 + share] {
        let end = machine.map_axes(|config| with_gap_times(config, factor));
        let [before, after] = both(&end)?;
        let when = format!(
            " where the true gaps are {:.0} % of those described",
            100.0 * factor
        );
        let stops = after
            .2
            .map(|stop| format!("the machine would stop{when}: {stop}"));
        let refused = stops.or_else(|| no_help(&before.0, &after.0, &when));
        answer.refused = answer.refused.or(refused);
        answer.uncertain.push(LeavesWith {
            factor,
            before: before.0,
            after: after.0,
        });
    }
    Ok(answer)
}

/// Why a program does not help enough, if it does not. At the ends of a wide interval the least gap
/// that is taken up is too small a part of the true one.
fn no_help(before: &Leaves, after: &Leaves, when: &str) -> Option<String> {
    let worse =
        after.rms_um > (1.0 - LEAST_GAIN) * before.rms_um || after.max_um > before.max_um + HARM_UM;
    worse.then(|| {
        format!(
            "it does not help enough{when}: RMS {:.2} um in place of {:.2}, at most {:.2} um in place of {:.2}",
            after.rms_um, before.rms_um, after.max_um, before.max_um
        )
    })
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

/// The moves of the program, each on a line of its own.
fn steps(
    program: &Program,
    machine: &Machine,
    options: &SimulateOptions,
    lines: &[Line],
    max_moves: usize,
) -> Result<Vec<Original>, RewriteError> {
    let mut steps: Vec<Original> = Vec::new();
    let curves = Simulation::new(program, machine)
        .options(options.clone())
        .curves()?;
    for item in curves {
        let item: ProgrammedMove = item?;
        let block = item.motion.block;
        let line = block.span.line as usize;
        let rapid = item.is_rapid();
        if steps.len() >= max_moves {
            return Err(refuse(
                line,
                format!("the program has more than {max_moves} moves"),
            ));
        }
        if (block.span.file, block.call_stack) != (0, 0) {
            return Err(refuse(line, "moves of subroutines are not rewritten"));
        }
        let Some(text) = line.checked_sub(1).and_then(|index| lines.get(index)) else {
            return Err(refuse(line, "the move stands on no line"));
        };
        let odd = text.is_not_plain();
        if let Some(what) = odd.clone().filter(|_| !rapid) {
            return Err(refuse(line, what));
        }
        if let Some(last) = steps.last()
            && last.line >= line
            && !(rapid && last.rapid && last.line == line && odd.is_some())
        {
            return Err(refuse(
                line,
                "the line moves more than once: loops, calls and cycles are not rewritten",
            ));
        }
        let (start, end) = (item.motion.curve.start(), item.motion.curve.end());
        let others = AxisId::ALL.iter().filter(|axis| axis.index() >= 3);
        if !rapid
            && others
                .clone()
                .any(|axis| (start[*axis] - end[*axis]).abs() > STILL_MM)
        {
            return Err(refuse(
                line,
                "cuts that move other axes than X, Y and Z are not rewritten",
            ));
        }
        if matches!(item.motion.curve, Curve::Quintic(_)) {
            return Err(refuse(line, "splines are not rewritten"));
        }
        // The word tells it best; the origin where there is none, and the tool's length where the curve is that of
        // the joints.
        let mut shift = [0.0; 3];
        for (axis, shift) in shift.iter_mut().enumerate() {
            let length = if item.is_tip {
                0.0
            } else {
                item.motion.tool_mm[axis]
            };
            let usual = item.origin_mm[axis] + length;
            let word = text
                .value(LETTERS[axis])
                .filter(|_| text.is_not_plain().is_none());
            *shift = word.map_or(usual, |value| end.0[axis] - value * text.mm);
        }
        steps.push(Original {
            curve: item.motion.curve,
            line,
            rapid,
            shift,
        });
    }
    Ok(steps)
}

/// A move cut where one of its axes reverses.
fn stretches(step: &Original) -> Result<Vec<Stretch>, RewriteError> {
    let curve = &step.curve;
    let length = curve.length();
    let mut cuts = vec![0.0];
    if let Curve::Arc(arc) = curve {
        if (arc.end_radius() - arc.start_radius()).abs() > SPIRAL_MM {
            return Err(refuse(step.line, "spirals are not rewritten"));
        }
        cuts.extend(reversals(curve));
    }
    cuts.push(length);
    Ok(cuts
        .windows(2)
        .map(|pair| {
            let middle = curve.tangent(0.5 * (pair[0] + pair[1]));
            let [start, end] = [pair[0], pair[1]].map(|s| curve.point(s).linear());
            let direction = std::array::from_fn(|axis| {
                let moves = (end[axis] - start[axis]).abs() > STILL_MM;
                if moves { middle[axis].signum() } else { 0.0 }
            });
            Stretch {
                start,
                end,
                direction,
            }
        })
        .collect())
}

/// Which original move each line of the original is on.
fn original_lines(lines: &[Line], steps: &[Original]) -> Vec<Option<usize>> {
    let mut of_lines = vec![None; lines.len()];
    for (index, step) in steps.iter().enumerate() {
        if let Some(of_line) = of_lines.get_mut(step.line - 1) {
            *of_line = Some(index);
        }
    }
    of_lines
}

/// Reads the new program as any other and holds the end points of its moves against those meant.
fn read_again(
    new: &Program,
    machine: &Machine,
    options: &SimulateOptions,
    text: &Text,
) -> Result<(), RewriteError> {
    let curves = Simulation::new(new, machine)
        .options(options.clone())
        .curves()?;
    let mut meant = text.ends.iter();
    for item in curves {
        let item = item?;
        let line = item.motion.block.span.line as usize;
        let end = item.motion.curve.end().linear();
        // Moves that go nowhere are no moves of the front end.
        let found = meant.by_ref().find(|(on, _)| *on == line);
        let off = found.map_or(f64::INFINITY, |(_, meant)| {
            (0..3)
                .map(|axis| (end[axis] - meant[axis]).abs())
                .fold(0.0, f64::max)
        });
        if off > ROUNDING_MM {
            return Err(RewriteError::Machine(format!(
                "line {line} of the new program does not lead where it is meant to: nothing is written; please report this program"
            )));
        }
    }
    Ok(())
}
