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
//! new text  end points moved, take-ups put in: as rapids where nothing is cut
//! judge     the machine's tool on the new program against the contour of the original
//! ```
//! The new text is read again and its end points held against the pieces before anything else is
//! done with it.

pub mod results;
mod text;

use crate::error::SimError;
use crate::machine::Machine;
use crate::motion::ProgrammedMove;
use crate::observer::{ContourPoint, Observer};
use crate::options::SimulateOptions;
use crate::program::Program;
use crate::recommend::{uncertainty, with_gap_times};
use crate::results::HARM_UM;
use crate::simulation::Simulation;
use lostmotion_base::units::UM_PER_MM;
use lostmotion_base::{AxisId, math};
use lostmotion_gcode::Dialect;
use lostmotion_path::Curve;
use results::{Leaves, LeavesWith, Rewritten};
use std::f64::consts::{FRAC_PI_2, TAU};
use text::{Line, lines, refuse};

/// X, Y and Z: the axes that are moved.
const AXES: [AxisId; 3] = [AxisId::X, AxisId::Y, AxisId::Z];
/// Their letters, and those of centres.
const LETTERS: [u8; 3] = *b"XYZ";
const CENTRES: [u8; 3] = *b"IJK";
/// Decimals of mm and of inch: a tenth of a micrometre and a quarter.
const DECIMALS: [usize; 2] = [4, 5];
/// Half the last digit, and rounding, mm.
const ROUNDING_MM: f64 = 2e-4;
/// By how much a gap may be off where nobody says; as comparisons test it.
const USUAL_SHARE: f64 = 0.3;
/// Part of the RMS that has to be gained. A choice: less is not worth another program.
const LEAST_GAIN: f64 = 0.1;
/// Change of an arc's radius up to which it is cut as a circle, mm.
const SPIRAL_MM: f64 = 2e-3;
/// Way of an axis that is none, mm.
const STILL_MM: f64 = 1e-7;
/// Moves before and behind the present one that a point may lie on.
const NEIGHBOURS: usize = 3;

/// How a program is rewritten.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RewriteOptions {
    /// Most that an end point is moved along an axis, um: more than half a gap of this size is refused.
    pub most_um: f64,
    /// How far off the gaps may be, as a part of them, below 1; as each axis says if `None`.
    pub gap_uncertainty: Option<f64>,
    /// Most moves of a program: they are held in memory.
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
struct Step {
    curve: Curve,
    line: usize,
    rapid: bool,
    /// Joints less program, mm.
    shift: [f64; 3],
}

/// Part of a move on which no axis reverses.
#[derive(Clone, Copy, Debug)]
struct Piece {
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
/// A line that is not rewritten, a machine whose joints do not go with X, Y and Z or whose control
/// compensates already, and all errors of a run. A new program that does not help is no error:
/// [`Rewritten::refused`].
pub fn rewrite(
    program: &Program,
    machine: &Machine,
    options: &SimulateOptions,
    wanted: &RewriteOptions,
) -> Result<Rewritten, RewriteError> {
    let half = half_gaps(machine, wanted)?;
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
) -> Result<Vec<Step>, RewriteError> {
    let mut steps: Vec<Step> = Vec::new();
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
        // The word tells it best; the origin where there is none.
        let mut shift = [0.0; 3];
        for (axis, shift) in shift.iter_mut().enumerate() {
            let usual = item.origin_mm[axis] + item.motion.tool_mm[axis];
            let word = text
                .value(LETTERS[axis])
                .filter(|_| text.is_not_plain().is_none());
            *shift = word.map_or(usual, |value| end.0[axis] - value * text.mm);
        }
        steps.push(Step {
            curve: item.motion.curve,
            line,
            rapid,
            shift,
        });
    }
    Ok(steps)
}

/// A move cut where one of its axes reverses.
fn pieces(step: &Step) -> Result<Vec<Piece>, RewriteError> {
    let curve = &step.curve;
    let length = curve.length();
    let mut cuts = vec![0.0];
    if let Curve::Arc(arc) = curve {
        if (arc.end_radius() - arc.start_radius()).abs() > SPIRAL_MM {
            return Err(refuse(step.line, "spirals are not rewritten"));
        }
        let [first, second, _] = curve.plane().axes();
        let (start, tangent) = (curve.start().linear(), curve.tangent(0.0));
        let from = [
            start[first] - arc.center()[0],
            start[second] - arc.center()[1],
        ];
        let turns = (from[0] * tangent[second] - from[1] * tangent[first]).signum();
        let flat = (length * length - arc.lift() * arc.lift()).max(0.0).sqrt();
        let sweep = flat / arc.start_radius();
        // Quarters that the radius passes, from the start on in the sense of the arc.
        let angle = turns * math::atan2(from[1], from[0]);
        let mut quarter = (angle / FRAC_PI_2).floor() + 1.0;
        while quarter * FRAC_PI_2 - angle < sweep {
            let part = (quarter * FRAC_PI_2 - angle) / sweep;
            // Ends that lie on a quarter but for rounding are no cuts.
            let at = part * length;
            if at > 10.0 * ROUNDING_MM && length - at > 10.0 * ROUNDING_MM {
                cuts.push(at);
            }
            quarter += 1.0;
            if cuts.len() > (sweep / TAU * 4.0) as usize + 8 {
                break;
            }
        }
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
            Piece {
                start,
                end,
                direction,
            }
        })
        .collect())
}

/// Writes the new program.
fn new_text(
    lines: &[Line],
    steps: &[Step],
    half: [f64; 3],
    dialect: Dialect,
    answer: &mut Rewritten,
) -> Result<Text, RewriteError> {
    let mut writer = Writer {
        out: Text::default(),
        end: lines
            .iter()
            .map(|line| line.end.clone())
            .find(|end| !end.is_empty())
            .unwrap_or_else(|| b"\n".to_vec()),
        semicolon: matches!(dialect, Dialect::Marlin | Dialect::Klipper),
        half,
        side: [0.0; 3],
        commanded: None,
        was_rapid: true,
    };
    let (mut next, mut is_headed) = (0, false);
    for (index, line) in lines.iter().enumerate() {
        if !is_headed && !line.is_head() {
            writer.header(&answer.program, &answer.machine);
            is_headed = true;
        }
        let from = next;
        while steps.get(next).is_some_and(|step| step.line == index + 1) {
            next += 1;
        }
        match steps.get(from..next).unwrap_or_default() {
            [] => writer.line(&line.text, None),
            [step] if line.is_not_plain().is_none() => {
                writer.step(line, step, from, answer)?;
            }
            // Rapids that are left as they are: to a place of the machine.
            others => {
                writer.line(&line.text, Some(from));
                for step in others {
                    let end = step.curve.end().linear();
                    writer.out.ends.push((writer.out.steps.len(), end));
                    writer.commanded = Some(end);
                    writer.was_rapid = true;
                }
            }
        }
    }
    // As the last line of the original ends.
    if lines.last().is_some_and(|line| line.end.is_empty()) {
        let cut = writer.out.text.len().saturating_sub(writer.end.len());
        writer.out.text.truncate(cut);
    }
    Ok(writer.out)
}

/// The new program as it grows.
struct Writer {
    out: Text,
    end: Vec<u8>,
    semicolon: bool,
    half: [f64; 3],
    /// The direction in which each axis went last; 0 before its first.
    side: [f64; 3],
    /// Where the machine was sent last, machine coordinates, mm.
    commanded: Option<[f64; 3]>,
    was_rapid: bool,
}

impl Writer {
    fn line(&mut self, text: &[u8], step: Option<usize>) {
        self.out.text.extend_from_slice(text);
        self.out.text.extend_from_slice(&self.end);
        self.out.steps.push(step);
    }

    fn remark(&self, text: &str) -> String {
        let plain = text.replace(['(', ')', ';', '\n', '\r'], " ");
        if self.semicolon {
            format!("; {plain}")
        } else {
            format!("({plain})")
        }
    }

    fn header(&mut self, program: &str, machine: &str) {
        let [x, y, z] = self.half.map(|half| format!("{half:.4}"));
        for text in [
            format!("{program} rewritten by lostmotion {} for machine {machine}", env!("CARGO_PKG_VERSION")),
            format!("for a control WITHOUT backlash compensation; half gaps in mm: X {x} Y {y} Z {z}"),
            "end points are moved by half the gap towards the way of each axis; lines with the mark backlash are new: they take up a gap".to_owned(),
            "do not run it where the control compensates, nor after a repair of screws or bearings".to_owned(),
        ] {
            let text = self.remark(&text);
            self.line(text.as_bytes(), None);
        }
    }

    /// A move with its end point moved, in as many pieces as it has reversals.
    fn step(
        &mut self,
        line: &Line,
        step: &Step,
        index: usize,
        answer: &mut Rewritten,
    ) -> Result<(), RewriteError> {
        let pieces = pieces(step)?;
        if pieces.len() > 1 {
            answer.arcs_split += 1;
            if line.has_code_behind_the_move() {
                return Err(refuse(
                    step.line,
                    "the arc has to be cut at its reversals: put the M code or E word on a line of its own",
                ));
            }
        }
        if line.value(b'P').is_some() && matches!(step.curve, Curve::Arc(_)) {
            return Err(refuse(
                step.line,
                "arcs of several turns (P) are not rewritten",
            ));
        }
        for (number, piece) in pieces.iter().enumerate() {
            for (side, direction) in self.side.iter_mut().zip(piece.direction) {
                if direction != 0.0 {
                    *side = direction;
                }
            }
            let offset: [f64; 3] = std::array::from_fn(|axis| self.side[axis] * self.half[axis]);
            let start: [f64; 3] = std::array::from_fn(|axis| piece.start[axis] + offset[axis]);
            let end: [f64; 3] = std::array::from_fn(|axis| piece.end[axis] + offset[axis]);
            let mut code_needed = number > 0;
            if !step.rapid && self.take_up(line, step, index, start, answer) {
                code_needed = true;
            }
            self.piece(
                line,
                step,
                index,
                number,
                [start, end],
                pieces.len() > 1,
                code_needed,
            );
        }
        self.was_rapid = step.rapid;
        Ok(())
    }

    /// Moves the axes whose gap has to be crossed before a piece; whether there is one.
    fn take_up(
        &mut self,
        line: &Line,
        step: &Step,
        index: usize,
        start: [f64; 3],
        answer: &mut Rewritten,
    ) -> bool {
        let from = self
            .commanded
            .unwrap_or_else(|| step.curve.start().linear());
        let moved: Vec<usize> = (0..3)
            .filter(|axis| (start[*axis] - from[*axis]).abs() > ROUNDING_MM)
            .collect();
        if moved.is_empty() {
            return false;
        }
        let rapid = self.was_rapid;
        let mut text = if rapid {
            "G0".to_owned()
        } else {
            "G1".to_owned()
        };
        let mut names = Vec::new();
        for axis in moved {
            let letter = char::from(LETTERS[axis]);
            text.push_str(&format!(
                " {letter}{}",
                number(start[axis] - step.shift[axis], line.mm)
            ));
            names.push(letter.to_string());
        }
        if let Some(feed) = line.feed.as_ref().filter(|_| !rapid) {
            text.push_str(&format!(" {feed}"));
        }
        let remark = self.remark(&format!("backlash of {}", names.join(" ")));
        text.push_str(&format!(" {remark}"));
        self.line(text.as_bytes(), Some(index));
        self.out.ends.push((self.out.steps.len(), start));
        if rapid {
            answer.in_the_air += 1;
        } else {
            answer.within_cuts += 1;
        }
        self.commanded = Some(start);
        // What follows is a cut; a rapid that took up is no cut.
        self.was_rapid = false;
        true
    }

    fn piece(
        &mut self,
        line: &Line,
        step: &Step,
        index: usize,
        piece: usize,
        [start, end]: [[f64; 3]; 2],
        is_split: bool,
        code_needed: bool,
    ) {
        let from = self
            .commanded
            .unwrap_or_else(|| step.curve.start().linear());
        let mut words: Vec<(u8, String)> = Vec::new();
        let code = match &step.curve {
            _ if step.rapid => "0",
            Curve::Arc(arc) => {
                let [first, second, _] = step.curve.plane().axes();
                let (start, tangent) = (step.curve.start().linear(), step.curve.tangent(0.0));
                let [x, y] = [
                    start[first] - arc.center()[0],
                    start[second] - arc.center()[1],
                ];
                // The plane's axes are right-handed in their order: as G2 and G3 count.
                if x * tangent[second] - y * tangent[first] > 0.0 {
                    "3"
                } else {
                    "2"
                }
            }
            _ => "1",
        };
        if code_needed && (piece > 0 || !line.has_motion()) {
            words.push((b'G', code.to_owned()));
        }
        for axis in 0..3 {
            let is_there = piece == 0 && line.value(LETTERS[axis]).is_some();
            if is_there
                || is_split && (end[axis] - start[axis]).abs() > STILL_MM
                || (end[axis] - from[axis]).abs() > ROUNDING_MM
            {
                words.push((LETTERS[axis], number(end[axis] - step.shift[axis], line.mm)));
            }
        }
        if let Curve::Arc(arc) = &step.curve {
            if let Some(radius) = line.value(b'R') {
                if is_split {
                    words.push((b'R', number(radius.abs() * line.mm, line.mm)));
                }
            } else if is_split {
                let axes = step.curve.plane().axes();
                // The centre goes with the piece.
                for (axis, center) in axes.into_iter().zip(arc.center()) {
                    let side = self.side[axis] * self.half[axis];
                    words.push((CENTRES[axis], number(center + side - start[axis], line.mm)));
                }
            }
        }
        let text = if piece == 0 {
            line.with(&words)
        } else {
            let mut text = String::new();
            for (letter, value) in &words {
                text.push_str(&format!("{}{value} ", char::from(*letter)));
            }
            text.trim_end().to_owned().into_bytes()
        };
        self.line(&text, Some(index));
        self.out.ends.push((self.out.steps.len(), end));
        self.commanded = Some(end);
    }
}

/// A number of mm in a program's unit, with a point.
fn number(value_mm: f64, mm: f64) -> String {
    let decimals = DECIMALS[usize::from(mm > 1.0)];
    let text = format!("{:.decimals$}", value_mm / mm);
    let cut = text.trim_end_matches('0');
    if cut == "-0." {
        "0.".to_owned()
    } else {
        cut.to_owned()
    }
}

/// Which original move each line of the original is on.
fn original_lines(lines: &[Line], steps: &[Step]) -> Vec<Option<usize>> {
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

/// How far the tool is off the original contour, the duration, and why the machine stops.
fn judge(
    program: &Program,
    machine: &Machine,
    options: &SimulateOptions,
    steps: &[Step],
    of_lines: &[Option<usize>],
) -> Result<(Leaves, f64, Option<String>), RewriteError> {
    let mut judge = Judge {
        steps,
        of_lines,
        squares: 0.0,
        count: 0,
        max: 0.0,
    };
    let run = Simulation::new(program, machine)
        .method("none")
        .options(options.clone())
        .observer(&mut judge)
        .run()?;
    let stop = run.first().and_then(|result| result.stop.as_ref());
    let stop = stop.map(|stop| format!("line {}: {}", stop.block.span.line, stop.limit));
    let leaves = Leaves {
        max_um: judge.max * UM_PER_MM,
        rms_um: (judge.squares / judge.count.max(1) as f64).sqrt() * UM_PER_MM,
    };
    Ok((leaves, run.plan.duration_s, stop))
}

/// Measures each point of a cut against the moves of the original around it.
struct Judge<'a> {
    steps: &'a [Step],
    of_lines: &'a [Option<usize>],
    squares: f64,
    count: u64,
    max: f64,
}

impl Observer for Judge<'_> {
    fn wants_contour(&self) -> bool {
        true
    }

    fn contour(&mut self, _method: usize, points: &[ContourPoint]) {
        for point in points.iter().filter(|point| point.moving && !point.rapid) {
            let line = point.block.span.line as usize;
            let index = line
                .checked_sub(1)
                .and_then(|line| self.of_lines.get(line).copied().flatten());
            let Some(index) = index else { continue };
            let shift = self.steps.get(index).map_or([0.0; 3], |step| step.shift);
            let at: [f64; 3] = std::array::from_fn(|axis| point.actual_mm[axis] + shift[axis]);
            let around =
                index.saturating_sub(NEIGHBOURS)..self.steps.len().min(index + NEIGHBOURS + 1);
            let distance = self
                .steps
                .get(around)
                .unwrap_or_default()
                .iter()
                .filter(|step| !step.rapid)
                .map(|step| {
                    step.curve
                        .nearest(at, (0.0, step.curve.length()), 1e-6)
                        .distance
                })
                .fold(f64::INFINITY, f64::min);
            if distance.is_finite() {
                self.squares += distance * distance;
                self.count += 1;
                self.max = self.max.max(distance);
            }
        }
    }
}
