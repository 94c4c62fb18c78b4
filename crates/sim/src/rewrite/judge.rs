//! The machine's tool on a program against the contour of the original.

use super::normal::{Normals, Off};
use super::results::Leaves;
use super::{Original, RewriteError};
use crate::machine::Machine;
use crate::observer::{ContourPoint, Observer};
use crate::options::SimulateOptions;
use crate::program::Program;
use crate::results::HARM_UM;
use crate::simulation::Simulation;
use lostmotion_base::units::UM_PER_MM;

/// Moves before and behind the present one that a point may lie on.
const NEIGHBOURS: usize = 3;

/// Distance of a rapid, in parts of that of a cut, from which on a point is the rapid's. A choice: a rapid
/// along a cut is as far.
const ON_RAPID: f64 = 0.5;

/// Difference of two distances that tells nothing, mm: that of the same way written twice.
const ALIKE_MM: f64 = 1e-5;

/// Part of the RMS that has to be gained. A choice: less is not worth another program.
const LEAST_GAIN: f64 = 0.1;

/// What a machine makes of a program.
#[derive(Debug)]
pub(super) struct Judged {
    /// How far the tool is off the original contour.
    pub(super) leaves: Leaves,
    pub(super) duration_s: f64,
    /// Why the machine stops, if it does.
    pub(super) stop: Option<String>,
    /// Where it is off most.
    pub(super) worst: Option<Worst>,
    /// The error of each piece; empty where nobody asks for it.
    pub(super) off: Vec<Off>,
    /// The largest error on each move of the original, mm.
    of_steps: Vec<f64>,
}

/// Where the tool is off the contour of the original the most.
#[derive(Clone, Copy, Debug)]
pub(super) struct Worst {
    /// The line of the original whose move it is off.
    pub(super) line: usize,
    pub(super) at_mm: [f64; 3],
    pub(super) off_um: f64,
}

impl Judged {
    /// The largest error on the move of a line, um.
    pub(super) fn on(&self, steps: &[Original], line: usize) -> f64 {
        let mut of_steps = steps.iter().zip(&self.of_steps);
        let found = of_steps.find(|(step, _)| step.line == line);
        found.map_or(0.0, |(_, off)| off * UM_PER_MM)
    }
}

/// Why a program does not help enough, if it does not: by which of the two measures, and where the tool
/// is off most before and after. At the ends of a wide interval the least gap that is taken up is too
/// small a part of the true one.
pub(super) fn no_help(
    before: &Judged,
    after: &Judged,
    steps: &[Original],
    when: &str,
) -> Option<String> {
    let (old, new) = (&before.leaves, &after.leaves);
    if before.worst.is_none() {
        return Some(format!("it does not help{when}: nothing is cut"));
    }
    let needed = if new.rms_um > (1.0 - LEAST_GAIN) * old.rms_um {
        format!(
            "RMS {:.2} um in place of {:.2} (it has to shrink by {:.0} %), at most {:.2} um in place of {:.2}",
            new.rms_um,
            old.rms_um,
            100.0 * LEAST_GAIN,
            new.max_um,
            old.max_um
        )
    } else if new.max_um > old.max_um + HARM_UM {
        format!(
            "RMS {:.2} um in place of {:.2}, at most {:.2} um in place of {:.2} (it may grow by {HARM_UM} um)",
            new.rms_um, old.rms_um, new.max_um, old.max_um
        )
    } else {
        return None;
    };
    let place = |worst: &Worst, other: &Judged, name: &str| {
        let [x, y, z] = worst.at_mm.map(|at| format!("{at:.3}"));
        format!(
            "line {} at X{x} Y{y} Z{z} ({:.2} um, {name} at most {:.2})",
            worst.line,
            worst.off_um,
            other.on(steps, worst.line)
        )
    };
    let old = before
        .worst
        .as_ref()
        .map(|worst| place(worst, after, "after"));
    let new = after
        .worst
        .as_ref()
        .map(|worst| place(worst, before, "before"));
    let places = match (old, new) {
        (Some(old), Some(new)) => {
            format!("; the worst before is on {old}, after on {new}, lines of the original")
        }
        _ => String::new(),
    };
    Some(format!("it does not help enough{when}: {needed}{places}"))
}

/// Runs a program and measures the tool against the moves of the original.
pub(super) fn judge(
    program: &Program,
    machine: &Machine,
    options: &SimulateOptions,
    steps: &[Original],
    of_lines: &[Option<usize>],
    normals: Option<&Normals<'_>>,
) -> Result<Judged, RewriteError> {
    let mut judge = OffContour {
        steps,
        of_lines,
        squares: 0.0,
        count: 0,
        max: 0.0,
        worst: None,
        of_steps: vec![0.0; steps.len()],
        off: normals.map_or_else(Vec::new, Normals::room),
        normals,
    };
    let run = Simulation::new(program, machine)
        .method("none")
        .options(options.clone())
        .observer(&mut judge)
        .run()?;
    let stop = run.first().and_then(|result| result.stop.as_ref());
    Ok(Judged {
        leaves: Leaves {
            max_um: judge.max * UM_PER_MM,
            rms_um: (judge.squares / judge.count.max(1) as f64).sqrt() * UM_PER_MM,
        },
        duration_s: run.plan.duration_s,
        stop: stop.map(|stop| format!("line {}: {}", stop.block.span.line, stop.limit)),
        worst: judge.worst,
        off: judge.off,
        of_steps: judge.of_steps,
    })
}

/// Measures each point of a cut against the moves of the original around it.
struct OffContour<'a> {
    steps: &'a [Original],
    of_lines: &'a [Option<usize>],
    squares: f64,
    count: u64,
    max: f64,
    worst: Option<Worst>,
    of_steps: Vec<f64>,
    normals: Option<&'a Normals<'a>>,
    off: Vec<Off>,
}

impl Observer for OffContour<'_> {
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
            let nearest = |rapid: bool| {
                let feet = around
                    .clone()
                    .filter_map(|other| Some((other, self.steps.get(other)?)))
                    .filter(|(_, step)| step.rapid == rapid)
                    .map(|(other, step)| {
                        let range = (0.0, step.curve.length());
                        (other, step.curve.nearest(at, range, 1e-6))
                    });
                // Where a move goes back along another one, the tool is on its own.
                feet.min_by(|a, b| {
                    let apart = a.1.distance - b.1.distance;
                    if apart.abs() > ALIKE_MM {
                        apart.total_cmp(&0.0)
                    } else {
                        a.0.abs_diff(index).cmp(&b.0.abs_diff(index))
                    }
                })
            };
            let Some((other, foot)) = nearest(false) else {
                continue;
            };
            // On a rapid the tool has left its cut, whichever block it is counted to.
            if nearest(true).is_some_and(|(_, way)| way.distance < ON_RAPID * foot.distance) {
                continue;
            }
            if let Some(normals) = self.normals {
                normals.add(&mut self.off, other, foot.s, at);
            }
            let distance = foot.distance;
            if distance.is_finite() {
                self.squares += distance * distance;
                self.count += 1;
                self.note(other, distance, at);
            }
        }
    }
}

impl OffContour<'_> {
    /// Takes a distance from a move into account.
    fn note(&mut self, step: usize, distance: f64, at_mm: [f64; 3]) {
        if let Some(most) = self.of_steps.get_mut(step) {
            *most = most.max(distance);
        }
        if distance > self.max {
            self.max = distance;
            self.worst = self.steps.get(step).map(|step| Worst {
                line: step.line,
                at_mm: std::array::from_fn(|axis| at_mm[axis] - step.shift[axis]),
                off_um: distance * UM_PER_MM,
            });
        }
    }
}
