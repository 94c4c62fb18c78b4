//! Reads a window: excerpts from it, one after the other, each with the load sliding and with the
//! load held.
//!
//! Each excerpt goes through a grid of stiffnesses and dampings and from its best point through
//! Gauss-Newton, a bounded amount of work a servo tick. The most certain excerpt that passes the
//! tests is the reading.

use super::fit::{Found, ShaftNewton, ShaftPrior, grid};
use super::model::{Shaft, ShaftMotor};
use super::window::{Excerpt, SAMPLES_BEFORE, ShaftSample};
use serde::{Deserialize, Serialize};

/// Samples after the blow at which excerpts begin: later ones leave out a bouncing contact. A
/// choice: nearly in equal ratios up to 25 ms.
const STARTS: [usize; 9] = [0, 2, 4, 8, 14, 24, 40, 64, 100];
/// Lengths of the excerpts, samples: 40, 25 and 14 ms. A choice: long ones show a soft shaft, short
/// ones a contact that soon opens again.
const LENGTHS: [usize; 3] = [160, 100, 56];
/// Excerpts: each start with each length, the load sliding or held.
const EXCERPTS: usize = STARTS.len() * LENGTHS.len() * 2;
/// Squared residual of a rigid mass over that of the noise from which on the shaft is excited. A
/// choice: twice the noise in amplitude.
const EXCITED_RATIO: f64 = 4.0;
/// Largest mean square of the residual over that of the noise. A choice: of pure noise it scatters
/// by 0.11 over 160 samples, by 0.19 over 56.
const LARGEST_MISFIT: f64 = 1.25;
/// Largest squared residual over that of a rigid mass. A choice: the shaft has to explain nine
/// tenths of what a rigid mass leaves.
const LARGEST_SHARE_OF_MASS: f64 = 0.1;
/// Largest structure of a residual that is noise: Box and Pierce's sum over six lags, whose
/// chi-squared distribution with six degrees of freedom exceeds 18 in 0.6 % of cases.
const LARGEST_STRUCTURE: f64 = 18.0;
/// Misfit below which the residual may have any structure: it is far below the noise that is
/// supposed. A choice: a third of the noise in amplitude.
const ANY_STRUCTURE_BELOW: f64 = 0.1;
/// Least difference of the squared residuals over the noise between a load that slides and one that
/// is held: a likelihood ratio of exp(6).
const LEAST_DIFFERENCE: f64 = 12.0;
/// Largest standard deviations of ln k and of the damping ratio with which a reading counts. A
/// choice: larger lets vague readings in, smaller leaves coarse encoders without any.
const LARGEST_DOUBTS: [f64; 2] = [0.1, 0.1];
/// Standard deviation of ln k below which no better excerpt is searched for. A choice: stiffness to
/// 1.5 %; searching on costs servo ticks.
const SUFFICIENT_DOUBT: f64 = 0.015;
/// Points of the grid that are computed in a servo tick: bounds the work.
const POINTS_PER_TICK: usize = 4;
/// Largest difference of a starting point from a known stiffness, part of it. A choice: stiffnesses
/// of the grid lie a factor of 1.35 apart, so at least one is within it.
const NEAR_KNOWN_SHARE: f64 = 0.3;

/// Phase of the work on an excerpt.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
enum ShaftPhase {
    /// Scan of the grid from a point on; the best so far with its squared residual.
    Grid(usize, Option<(Shaft, f64)>),
    /// Gauss-Newton from the best point.
    ShaftNewton(ShaftNewton),
}

/// A window, and which excerpt of it is being read.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct ShaftReading {
    samples: Vec<ShaftSample>,
    excerpt: usize,
    phase: Option<ShaftPhase>,
    /// Result of the excerpt with the load sliding.
    sliding: Option<Found>,
    /// Most certain result so far.
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

    /// The excerpt under way, and whether its load is held; `None` if it cannot be read.
    fn excerpt(&self, motor: &ShaftMotor) -> Option<(Excerpt, bool)> {
        let (which, held) = (self.excerpt / 2, self.excerpt % 2 == 1);
        let start = SAMPLES_BEFORE - 1 + STARTS.get(which / LENGTHS.len())?;
        let samples = self
            .samples
            .get(start..start + LENGTHS.get(which % LENGTHS.len())?)?;
        // Coulomb friction of the motor is known only as long as it does not reverse
        let way = samples.last()?.position - samples.first()?.position;
        let turns = motor.coulomb > 0.0
            && samples
                .windows(2)
                .any(|pair| (pair[1].position - pair[0].position) * way < 0.0);
        (!turns).then(|| (Excerpt::new(motor, samples, way.signum()), held))
    }

    /// A bounded piece of work; at the end the result, if there is one.
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
            // without a prior a free inertia may grow to that of a held load: nothing to compare
            return self.take(None);
        }
        match self.phase {
            None => {
                // a rigid mass explains it as well as a shaft: not excited
                let noise = motor.noise * motor.noise * excerpt.len() as f64;
                if excerpt.left_by_a_mass(motor) < EXCITED_RATIO * noise {
                    return self.next();
                }
                self.phase = Some(ShaftPhase::Grid(0, None));
            }
            Some(ShaftPhase::Grid(from, best)) => {
                // coarse global search first: the residual has many local minima over the stiffness
                let mut points = grid(motor, held, prior);
                if let Some(near) = near {
                    points.retain(|point| (point.stiffness / near - 1.0).abs() < NEAR_KNOWN_SHARE);
                }
                let best =
                    points
                        .iter()
                        .skip(from)
                        .take(POINTS_PER_TICK)
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
                let done = from + POINTS_PER_TICK >= points.len();
                self.phase = Some(if done {
                    ShaftPhase::ShaftNewton(ShaftNewton::new(&start))
                } else {
                    ShaftPhase::Grid(from + POINTS_PER_TICK, best)
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

    /// Goes on to the next excerpt.
    fn next(&mut self) -> Option<Option<Found>> {
        (self.excerpt, self.phase) = (self.excerpt + 1, None);
        None
    }

    /// Takes the result of an excerpt: with the load sliding, then with the load held.
    fn take(&mut self, found: Option<Found>) -> Option<Option<Found>> {
        if self.excerpt.is_multiple_of(2) {
            self.sliding = found;
            return self.next();
        }
        // model selection by the squared residual: too close, and neither is believed
        let better = match (self.sliding.take(), found) {
            (Some(sliding), Some(held))
                if (sliding.squares - held.squares).abs() < LEAST_DIFFERENCE =>
            {
                None
            }
            (Some(sliding), Some(held)) if held.squares < sliding.squares => Some(held),
            (sliding, _) => sliding,
        };
        if let Some(found) = better.filter(counts)
            && self.best.is_none_or(|best| found.doubt[0] < best.doubt[0])
        {
            self.best = Some(found);
            if found.doubt[0] < SUFFICIENT_DOUBT {
                return Some(self.best);
            }
        }
        self.next()
    }
}

/// Whether a result passes all tests.
fn counts(found: &Found) -> bool {
    found.stays
        && (found.misfit < ANY_STRUCTURE_BELOW || found.structure < LARGEST_STRUCTURE)
        && found.misfit < LARGEST_MISFIT
        && found.part < LARGEST_SHARE_OF_MASS
        && found.doubt[0] < LARGEST_DOUBTS[0]
        && found.doubt[1] < LARGEST_DOUBTS[1]
}
