//! The machine's tool on a program against the contour of the original.

use super::normal::{Normals, Off};
use super::results::Leaves;
use super::{Original, RewriteError};
use crate::machine::Machine;
use crate::observer::{ContourPoint, Observer};
use crate::options::SimulateOptions;
use crate::program::Program;
use crate::simulation::Simulation;
use lostmotion_base::units::UM_PER_MM;

/// Moves before and behind the present one that a point may lie on.
const NEIGHBOURS: usize = 3;

/// Distance of a rapid, in parts of that of a cut, from which on a point is the rapid's. A choice: a rapid
/// along a cut is as far.
const ON_RAPID: f64 = 0.5;

/// What a machine makes of a program.
#[derive(Debug)]
pub(super) struct Judged {
    /// How far the tool is off the original contour.
    pub(super) leaves: Leaves,
    pub(super) duration_s: f64,
    /// Why the machine stops, if it does.
    pub(super) stop: Option<String>,
    /// The error of each piece; empty where nobody asks for it.
    pub(super) off: Vec<Off>,
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
        off: judge.off,
    })
}

/// Measures each point of a cut against the moves of the original around it.
struct OffContour<'a> {
    steps: &'a [Original],
    of_lines: &'a [Option<usize>],
    squares: f64,
    count: u64,
    max: f64,
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
                around
                    .clone()
                    .filter_map(|other| Some((other, self.steps.get(other)?)))
                    .filter(|(_, step)| step.rapid == rapid)
                    .map(|(other, step)| {
                        let range = (0.0, step.curve.length());
                        (other, step.curve.nearest(at, range, 1e-6))
                    })
                    .min_by(|a, b| a.1.distance.total_cmp(&b.1.distance))
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
                self.max = self.max.max(distance);
            }
        }
    }
}
