//! The moves of a program, each on a line of its own, cut where one of their axes reverses.

use super::refusals::Refusals;
use super::text::{LETTERS, Line, TextLines, WRITE, refuse};
use super::{RewriteError, STILL_MM};
use crate::machine::Machine;
use crate::motion::{ProgrammedMove, reversals};
use crate::options::SimulateOptions;
use crate::program::Program;
use crate::simulation::Simulation;
use lostmotion_base::AxisId;
use lostmotion_path::Curve;

/// Change of an arc's radius up to which it is cut as a circle, mm: words of four decimals of an inch leave
/// 3.6 um. A choice: as much as grbl takes.
const SPIRAL_MM: f64 = 5e-3;

/// A move of the original program.
#[derive(Clone, Debug)]
pub(super) struct Original {
    pub(super) curve: Curve,
    pub(super) line: usize,
    pub(super) rapid: bool,
    /// Machine less program coordinates, mm.
    pub(super) shift: [f64; 3],
    /// Z of the curve less that of the tool's tip, mm.
    pub(super) tool_z_mm: f64,
}

/// Part of a move on which no axis reverses.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stretch {
    /// Where it begins and ends on the move's curve, mm.
    pub(super) range: [f64; 2],
    pub(super) start: [f64; 3],
    pub(super) end: [f64; 3],
    pub(super) direction: [f64; 3],
}

/// The moves of the program, each on a line of its own. What is refused is told in `refusals`, and left
/// out.
///
/// # Errors
/// The program cannot be run, calls another file, or has too many moves.
pub(super) fn steps(
    program: &Program,
    machine: &Machine,
    options: &SimulateOptions,
    lines: &TextLines,
    max_moves: usize,
    refusals: &mut Refusals,
) -> Result<Vec<Original>, RewriteError> {
    let mut steps: Vec<Original> = Vec::new();
    let curves = Simulation::new(program, machine)
        .options(options.clone())
        .curves()?;
    for item in curves {
        let item: ProgrammedMove = item?;
        let block = item.motion.block;
        let line = block.span.line as usize;
        // What an extruder does alone is no way.
        if item.motion.curve.length() <= STILL_MM && !lines_way(&lines.all, line) {
            continue;
        }
        if steps.len() >= max_moves {
            return Err(refuse(
                line,
                format!("the program has more than {max_moves} moves"),
            ));
        }
        if block.span.file != 0 {
            return Err(RewriteError::Machine(format!(
                "line {line} of a file that the program calls: moves of subroutines are not rewritten: {WRITE}"
            )));
        }
        match step(&item, &lines.all, steps.last()) {
            Ok(step) => steps.push(step),
            Err(error) => refusals.add(lines.placed(error)),
        }
    }
    Ok(steps)
}

/// One move, behind the last one, if it can be rewritten.
fn step(
    item: &ProgrammedMove,
    lines: &[Line],
    last: Option<&Original>,
) -> Result<Original, RewriteError> {
    let block = item.motion.block;
    let line = block.span.line as usize;
    let rapid = item.is_rapid();
    if block.call_stack != 0 {
        return Err(refuse(
            line,
            format!("moves of subroutines are not rewritten: {WRITE}"),
        ));
    }
    let Some(text) = line.checked_sub(1).and_then(|index| lines.get(index)) else {
        return Err(refuse(line, "the move stands on no line"));
    };
    let odd = text.is_not_plain();
    if let Some(odd) = odd.clone().filter(|_| !rapid) {
        return Err(odd.on(line));
    }
    if let Some(last) = last
        && last.line >= line
        && !(rapid && last.rapid && last.line == line && odd.is_some())
    {
        return Err(refuse(
            line,
            format!(
                "the line moves more than once: loops, calls and cycles are not rewritten; {WRITE}"
            ),
        ));
    }
    let (start, end) = (item.motion.curve.start(), item.motion.curve.end());
    let mut others = AxisId::ALL.iter().filter(|axis| axis.index() >= 3);
    if !rapid && others.any(|axis| (start[*axis] - end[*axis]).abs() > STILL_MM) {
        return Err(refuse(
            line,
            "cuts that move other axes than X, Y and Z are not rewritten",
        ));
    }
    if matches!(item.motion.curve, Curve::Quintic(_)) {
        return Err(refuse(
            line,
            "splines are not rewritten: write them as short lines",
        ));
    }
    // The word tells it best; the origin where there is none, and the tool's length where the curve is that of
    // the joints.
    let length = if item.is_tip {
        [0.0; 3]
    } else {
        std::array::from_fn(|axis| item.motion.tool_mm[axis])
    };
    let shift = std::array::from_fn(|axis| {
        let word = text.value(LETTERS[axis]).filter(|_| odd.is_none());
        word.map_or(item.origin_mm[axis] + length[axis], |value| {
            end.0[axis] - value * text.mm
        })
    });
    Ok(Original {
        curve: item.motion.curve,
        line,
        rapid,
        shift,
        tool_z_mm: length[2],
    })
}

/// Whether a line has a word of an axis.
fn lines_way(lines: &[Line], line: usize) -> bool {
    let found = line.checked_sub(1).and_then(|index| lines.get(index));
    found.is_none_or(Line::has_way)
}

/// A move cut where one of its axes reverses.
pub(super) fn stretches(step: &Original) -> Result<Vec<Stretch>, RewriteError> {
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
                range: [pair[0], pair[1]],
                start,
                end,
                direction,
            }
        })
        .collect())
}

/// Refuses what is not rewritten because of the moves around it.
pub(super) fn refuse_in_place(
    lines: &TextLines,
    steps: &[Original],
    pieces: &[Vec<Stretch>],
    refusals: &mut Refusals,
) {
    for (step, pieces) in steps.iter().zip(pieces) {
        let line = lines.all.get(step.line - 1).filter(|_| pieces.len() > 1);
        if let Some(odd) = line.and_then(Line::keeps_its_move_whole) {
            refusals.add(lines.placed(odd.on(step.line)));
        }
    }
    let first = steps.first().map_or(usize::MAX, |step| step.line);
    for (index, line) in lines.all.iter().enumerate().skip(first) {
        if let Some(odd) = line.takes_the_place() {
            refusals.add(lines.placed(odd.on(index + 1)));
        }
    }
}

/// Which original move each line of the original is on.
pub(super) fn original_lines(lines: &[Line], steps: &[Original]) -> Vec<Option<usize>> {
    let mut of_lines = vec![None; lines.len()];
    for (index, step) in steps.iter().enumerate() {
        if let Some(of_line) = of_lines.get_mut(step.line - 1) {
            *of_line = Some(index);
        }
    }
    of_lines
}
