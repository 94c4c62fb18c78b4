//! Reads a window: excerpts from it, one after the other, each with the load sliding and with the
//! load held.

use super::fit::{Found, ShaftNewton, ShaftPrior, grid};
use super::model::{Shaft, ShaftMotor};
use super::window::{BEFORE, Excerpt, ShaftSample};
use serde::{Deserialize, Serialize};

/// Samples after the blow at which excerpts begin, and how long they are.
const STARTS: [usize; 9] = [0, 2, 4, 8, 14, 24, 40, 64, 100];
const LENGTHS: [usize; 3] = [160, 100, 56];
/// Excerpts: each start with each length, the load sliding or held.
const EXCERPTS: usize = STARTS.len() * LENGTHS.len() * 2;
/// A rigid mass has to leave so many times what the noise does.
const EXCITED: f64 = 4.0;
/// Mean square of the residual over that of the noise, at most, and over what a rigid mass leaves.
const EXPLAINED: f64 = 1.25;
const PART: f64 = 0.1;
/// Structure in the residual (sum of the squares of its first autocorrelations, times their number)
/// up to which it is noise; one that is far below the noise may have any.
const STRUCTURE: f64 = 18.0;
const WHITE_BELOW: f64 = 0.1;
/// By how much a load that slides and one that is held have to differ in the squares of their
/// residuals, over the noise, to be told apart.
const APART: f64 = 12.0;
/// Standard deviations of ln k and of the damping ratio up to which a reading counts, and of ln k
/// at which no better one is looked for.
const SHARP: [f64; 2] = [0.1, 0.1];
const ENOUGH: f64 = 0.015;
/// Points of the grid taken in a tick.
const POINTS: usize = 4;
/// Part by which the stiffness may be off what is known for a start to be tried.
const NEAR: f64 = 0.3;

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
enum ShaftPhase {
    /// Looking over the grid from a point on; the best so far with its squares.
    Grid(usize, Option<(Shaft, f64)>),
    ShaftNewton(ShaftNewton),
}

/// A window, and which excerpt of it is being read.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct ShaftReading {
    samples: Vec<ShaftSample>,
    excerpt: usize,
    phase: Option<ShaftPhase>,
    /// What the excerpt says with the load sliding.
    sliding: Option<Found>,
    best: Option<Found>,
}

impl ShaftReading {
    pub(super) fn new(samples: Vec<ShaftSample>) -> ShaftReading {
        ShaftReading {
            samples,
            excerpt: 0,
            phase: None,
            sliding: None,
            best: None,
        }
    }

    /// The excerpt under way, and whether its load is held; none if there is no motion that can be
    /// read.
    fn excerpt(&self, motor: &ShaftMotor) -> Option<(Excerpt, bool)> {
        let (which, held) = (self.excerpt / 2, self.excerpt % 2 == 1);
        let start = BEFORE - 1 + STARTS.get(which / LENGTHS.len())?;
        let samples = self
            .samples
            .get(start..start + LENGTHS.get(which % LENGTHS.len())?)?;
        let way = samples.last()?.position - samples.first()?.position;
        let turns = motor.coulomb > 0.0
            && samples
                .windows(2)
                .any(|pair| (pair[1].position - pair[0].position) * way < 0.0);
        (!turns).then(|| (Excerpt::new(motor, samples, way.signum()), held))
    }

    /// A bounded piece of work; at the end what was found, if anything.
    pub(super) fn work(
        &mut self,
        motor: &ShaftMotor,
        prior: ShaftPrior,
        near: Option<f64>,
    ) -> Option<Option<Found>> {
        if self.excerpt >= EXCERPTS {
            return Some(self.best);
        }
        let Some((excerpt, held)) = self.excerpt(motor) else {
            return self.next();
        };
        if held && (prior.is_none() || self.sliding.is_none()) {
            // an inertia that is free may be as large as a held load's
            return self.take(None);
        }
        match self.phase {
            None => {
                let noise = motor.noise * motor.noise * excerpt.len() as f64;
                if excerpt.left_by_a_mass(motor) < EXCITED * noise {
                    return self.next();
                }
                self.phase = Some(ShaftPhase::Grid(0, None));
            }
            Some(ShaftPhase::Grid(from, best)) => {
                let mut points = grid(motor, held, prior);
                if let Some(near) = near {
                    points.retain(|point| (point.stiffness / near - 1.0).abs() < NEAR);
                }
                let best = points
                    .iter()
                    .skip(from)
                    .take(POINTS)
                    .fold(best, |best, point| {
                        let squares = excerpt.left_by(motor, point).squares;
                        if best.is_none_or(|(_, least)| squares < least) {
                            Some((*point, squares))
                        } else {
                            best
                        }
                    });
                let Some((start, _)) = best else {
                    return self.next();
                };
                let done = from + POINTS >= points.len();
                self.phase = Some(if done {
                    ShaftPhase::ShaftNewton(ShaftNewton::new(&start))
                } else {
                    ShaftPhase::Grid(from + POINTS, best)
                });
            }
            Some(ShaftPhase::ShaftNewton(mut newton)) => {
                let end = newton.work(motor, &excerpt, prior);
                self.phase = Some(ShaftPhase::ShaftNewton(newton));
                if let Some(found) = end {
                    return self.take(found);
                }
            }
        }
        None
    }

    fn next(&mut self) -> Option<Option<Found>> {
        (self.excerpt, self.phase) = (self.excerpt + 1, None);
        None
    }

    /// Takes what an excerpt says: with the load sliding, then with the load held.
    fn take(&mut self, found: Option<Found>) -> Option<Option<Found>> {
        if self.excerpt.is_multiple_of(2) {
            self.sliding = found;
            return self.next();
        }
        let better = match (self.sliding.take(), found) {
            (Some(sliding), Some(held)) if (sliding.squares - held.squares).abs() < APART => None,
            (Some(sliding), Some(held)) if held.squares < sliding.squares => Some(held),
            (sliding, _) => sliding,
        };
        if let Some(found) = better.filter(counts)
            && self.best.is_none_or(|best| found.doubt[0] < best.doubt[0])
        {
            self.best = Some(found);
            if found.doubt[0] < ENOUGH {
                return Some(self.best);
            }
        }
        self.next()
    }
}

fn counts(found: &Found) -> bool {
    found.stays
        && (found.misfit < WHITE_BELOW || found.structure < STRUCTURE)
        && found.misfit < EXPLAINED
        && found.part < PART
        && found.doubt[0] < SHARP[0]
        && found.doubt[1] < SHARP[1]
}
