//! Gap, shaft and load with which the replayed torque is nearest to the measured one.
//!
//! The problem is not convex: an impact that comes at another time than the measured one is worse
//! than none. So it is first solved with windows that are longer than an impact's shift, from the
//! valleys over a grid of gaps and stiffnesses, and from there with short ones. A valley that ends
//! nearly as deep as the deepest at another gap is a rival: then the log does not tell which.

use crate::{
    huber::{NormalEquations, Piece, solve_small},
    result::FittedLoad,
};
use lostmotion_base::math;

use super::replay::{
    COMPLIANCE, COULOMB, Coefficients, DAMPING_TIME, HALF_GAP, INERTIA, LANES, LATENESS, REPLAYED,
    Replay, VISCOUS, geometric, guess,
};

/// Half gaps of the first grid, rad at the motor: from 0.5 um at a lead of 20 mm to 0.5 mm at one
/// of 5.
const GRID_GAPS: (f64, f64, usize) = (1.5e-4, 0.3, 40);
/// Compliances of the first grid, rad/(N m) at the motor: ball screws of 20 to 500 N/um with leads
/// of 5 to 20 mm.
const GRID_COMPLIANCES: (f64, f64, usize) = (3e-4, 0.03, 8);
/// Points of the first grid that are looked at more closely, and into how many either way each is
/// divided for that.
const CLOSER: usize = 60;
const DIVISIONS: (i32, i32) = (2, 1);
/// Time from the log's start over which the grids go, s. A choice: a dozen strokes.
const GRID_SPAN_S: f64 = 8.0;
/// Points from which the descent is tried, the rounds of descent over that time, and how many go on
/// over the whole log. A choice.
const STARTS: usize = 16;
const FIRST_ROUNDS: usize = 6;
const FINALISTS: usize = 4;
/// Ratio of half gaps within which two starts are alike, so that only the better one is tried: with
/// alike compliances among the starts, whatever these are among the finalists. A choice.
const ALIKE_GAP: f64 = 1.06;
const ALIKE_COMPLIANCE: f64 = 1.5;
/// The sweep about a minimum: half gaps as parts of its own, and compliances. A choice: steps of 7 %
/// are finer than a valley with short windows, and the ends are a tenth and the tenfold.
const SWEEP_GAPS: (f64, f64, usize) = (0.1, 10.0, 69);
const SWEEP_COMPLIANCES: [f64; 3] = [0.7, 1.0, 1.4];
/// Valleys of a sweep that are followed down, and sweeps where they lead to better minima.
const VALLEYS: usize = 4;
const MOST_SWEEPS: usize = 3;
/// Cost over that of the best from which on a minimum of the first part is left. A choice.
const HOPELESS_FACTOR: f64 = 1.5;
/// Ratio of half gaps, and of compliances, below which two minima are one. A choice.
const SAME_GAP: f64 = 1.02;
const SAME_COMPLIANCE: f64 = 1.15;
/// Most rounds of Levenberg and Marquardt, accepted or not.
const MOST_ROUNDS: usize = 20;
/// Relative fall of the cost that counts as none.
const SETTLED_SHARE: f64 = 5e-5;
/// Damping of Levenberg and Marquardt beyond which no step helps any more.
const MAX_DAMPING: f64 = 1e2;
/// Longest damping time d/k, s. Origin as in `uncertainty`, halved: usual shafts have a tenth of it.
const MAX_DAMPING_TIME_S: f64 = 1e-3;
/// Latest and earliest current, s. A choice: more is a filter, whose lag depends on the frequency.
const MAX_LATENESS_S: f64 = 2e-3;
/// Ratio within which the inertia stays to that of the sliding load. A choice: the latter is known
/// to some parts in a hundred.
const INERTIA_DOUBT: f64 = 1.3;
/// A minimum.
#[derive(Clone)]
pub(super) struct Found {
    pub(super) x: Coefficients,
    /// Sum of the losses, (N m)^2.
    pub(super) cost: f64,
    pub(super) residuals: Vec<f64>,
    pub(super) rounds: u32,
    pub(super) settled: bool,
}

/// A minimum, and the other valleys.
pub(super) struct Answer {
    pub(super) found: Found,
    /// Other minima with short windows, the deepest first.
    pub(super) rivals: Vec<Found>,
    /// Windows that counted.
    pub(super) used: Vec<usize>,
}

/// What is replayed, and what is known before.
pub(super) struct Search<'a> {
    /// With long windows, and with short ones.
    pub(super) long: Replay<'a>,
    pub(super) short: Replay<'a>,
    pub(super) load: FittedLoad,
    pub(super) motor_inertia_kgm2: f64,
    /// Where the loss turns linear, N m.
    pub(super) delta: f64,
}

impl Search<'_> {
    /// The minimum from a grid over gaps and compliances, with long windows, then short ones; `None`
    /// where the log has too few windows.
    pub(super) fn run(&self) -> Option<Answer> {
        let starts = self.starts()?;
        // Successive halving: a few rounds of descent over part of the log, more for the better.
        let part = self.short.used(GRID_SPAN_S);
        let mut first: Vec<Found> = Vec::new();
        for start in starts {
            keep(
                &mut first,
                self.descend(&self.short, start, &part, FIRST_ROUNDS)?,
            );
        }
        let used = self.short.used(f64::INFINITY);
        let mut fine: Vec<Found> = Vec::new();
        let deepest = first.first()?.cost;
        first.retain(|found| found.cost < HOPELESS_FACTOR * deepest);
        let firsts = first.iter().map(|found| found.x).collect();
        for start in unlike(firsts, f64::INFINITY, FINALISTS) {
            let found = self.descend(&self.short, start, &used, MOST_ROUNDS)?;
            keep(&mut fine, found);
        }
        // Load and shaft are known now, so that the other gaps are seen as deep as they are.
        for _ in 0..MOST_SWEEPS {
            let best = fine.first()?.x;
            for start in self.valleys(&best, &used) {
                let found = self.descend(&self.short, start, &used, MOST_ROUNDS)?;
                keep(&mut fine, found);
            }
            if fine.first()?.x[HALF_GAP] == best[HALF_GAP] {
                break;
            }
        }
        let mut fine = fine.into_iter();
        let found = fine.next()?;
        Some(Answer {
            rivals: fine.collect(),
            used,
            found,
        })
    }

    /// The best points of two grids, the second about the best of the first and with short windows.
    fn starts(&self) -> Option<Vec<Coefficients>> {
        let (least, most, gaps) = GRID_GAPS;
        let (stiffest, softest, compliances) = GRID_COMPLIANCES;
        let guess =
            |gap: f64, compliance: f64| guess(gap, compliance, &self.load, self.motor_inertia_kgm2);
        let points: Vec<Coefficients> = geometric(least, most, gaps)
            .into_iter()
            .flat_map(|gap| {
                geometric(stiffest, softest, compliances)
                    .into_iter()
                    .map(move |compliance| guess(gap, compliance))
            })
            .collect();
        let (gap_divisions, compliance_divisions) = DIVISIONS;
        let gap_step = math::pow(
            most / least,
            1.0 / (gaps - 1) as f64 / f64::from(2 * gap_divisions + 1),
        );
        let compliance_step = math::pow(
            softest / stiffest,
            1.0 / (compliances - 1) as f64 / f64::from(2 * compliance_divisions + 1),
        );
        // Every gap is looked at more closely, and the best of all once more.
        let mut coarse = self.best(&self.long, points, usize::MAX)?;
        let mut seen = Vec::new();
        coarse.sort_by_key(|x| {
            let again = seen.contains(&x[HALF_GAP].to_bits());
            seen.push(x[HALF_GAP].to_bits());
            again
        });
        coarse.truncate(CLOSER);
        let closer: Vec<Coefficients> = coarse
            .iter()
            .flat_map(|x| {
                (-gap_divisions..=gap_divisions).flat_map(move |i| {
                    (-compliance_divisions..=compliance_divisions).map(move |j| {
                        guess(
                            x[HALF_GAP] * math::pow(gap_step, f64::from(i)),
                            x[COMPLIANCE] * math::pow(compliance_step, f64::from(j)),
                        )
                    })
                })
            })
            .collect();
        let closer = self.best(&self.short, closer, usize::MAX)?;
        Some(unlike(closer, ALIKE_COMPLIANCE, STARTS))
    }

    /// The deepest valleys of the cost over the gap other than that of a minimum, with everything
    /// else as there.
    fn valleys(&self, best: &Coefficients, used: &[usize]) -> Vec<Coefficients> {
        let (least, most, count) = SWEEP_GAPS;
        let points: Vec<Coefficients> = geometric(least, most, count)
            .into_iter()
            .flat_map(|gap| {
                SWEEP_COMPLIANCES.map(|compliance| {
                    let mut x = *best;
                    x[HALF_GAP] *= gap;
                    x[COMPLIANCE] *= compliance;
                    x
                })
            })
            .collect();
        let costs = costs_of(&self.short, &points, used, self.delta);
        let mut all: Vec<(f64, Coefficients)> = costs
            .chunks(SWEEP_COMPLIANCES.len())
            .zip(points.chunks(SWEEP_COMPLIANCES.len()))
            .filter_map(|(costs, points)| {
                let at = costs.iter().copied().zip(points.iter().copied());
                at.min_by(|a, b| a.0.total_cmp(&b.0))
            })
            .collect();
        // A valley is lower than both its neighbours; the ends have one.
        let lower = |n: usize| {
            let above = |m: usize| all.get(m).is_none_or(|other| other.0 >= all[n].0);
            above(n + 1) && above(n.wrapping_sub(1))
        };
        let lows: Vec<bool> = (0..all.len()).map(lower).collect();
        let mut low = lows.into_iter();
        all.retain(|(_, x)| {
            let own = (x[HALF_GAP] / best[HALF_GAP]).max(best[HALF_GAP] / x[HALF_GAP]) < ALIKE_GAP;
            low.next() == Some(true) && !own
        });
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all.into_iter().take(VALLEYS).map(|(_, x)| x).collect()
    }

    /// The points of least cost over the first part of the log.
    fn best(
        &self,
        replay: &Replay,
        points: Vec<Coefficients>,
        count: usize,
    ) -> Option<Vec<Coefficients>> {
        let used = replay.used(GRID_SPAN_S);
        if used.len() < 4 * REPLAYED {
            return None;
        }
        let costs = costs_of(replay, &points, &used, self.delta);
        let mut all: Vec<(f64, Coefficients)> = costs.into_iter().zip(points).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all.truncate(count);
        Some(all.into_iter().map(|(_, x)| x).collect())
    }
}

/// Costs of points: sums of Huber's losses, of squares where there is no delta.
fn costs_of(replay: &Replay, points: &[Coefficients], used: &[usize], delta: f64) -> Vec<f64> {
    let mut costs = Vec::with_capacity(points.len());
    for some in points.chunks(LANES) {
        let lanes: [Coefficients; LANES] = std::array::from_fn(|n| some[n.min(some.len() - 1)]);
        let mut sums = [0.0; LANES];
        for residuals in replay.residuals(&lanes, used) {
            for (sum, residual) in sums.iter_mut().zip(residuals) {
                *sum += huber(residual, delta);
            }
        }
        costs.extend(&sums[..some.len()]);
    }
    costs
}

/// The first of points that come in order of their cost without those alike to a better one.
fn unlike(points: Vec<Coefficients>, alike_compliance: f64, count: usize) -> Vec<Coefficients> {
    let near = |a: f64, b: f64, ratio: f64| (a / b).max(b / a) < ratio;
    let mut kept: Vec<Coefficients> = Vec::new();
    for x in points {
        let alike = kept.iter().any(|other| {
            near(x[HALF_GAP], other[HALF_GAP], ALIKE_GAP)
                && near(x[COMPLIANCE], other[COMPLIANCE], alike_compliance)
        });
        if !alike && kept.len() < count {
            kept.push(x);
        }
    }
    kept
}

/// Adds a minimum in order of cost; of minima at one gap and stiffness the deepest stays.
fn keep(all: &mut Vec<Found>, found: Found) {
    let near = |a: f64, b: f64, ratio: f64| (a / b).max(b / a) < ratio;
    let same = |a: &Found| {
        near(a.x[HALF_GAP], found.x[HALF_GAP], SAME_GAP)
            && near(a.x[COMPLIANCE], found.x[COMPLIANCE], SAME_COMPLIANCE)
    };
    match all.iter_mut().find(|other| same(other)) {
        Some(other) if found.cost < other.cost => *other = found,
        Some(_) => {}
        None => all.push(found),
    }
    all.sort_by(|a, b| a.cost.total_cmp(&b.cost));
}

impl Search<'_> {
    /// The minimum that lies downhill of here; `None` where the log has too little to tell.
    pub(super) fn descend(
        &self,
        replay: &Replay,
        start: Coefficients,
        used: &[usize],
        most_rounds: usize,
    ) -> Option<Found> {
        self.descend_but(replay, start, used, most_rounds, None)
    }

    /// As `descend`, with one coefficient held.
    pub(super) fn descend_but(
        &self,
        replay: &Replay,
        start: Coefficients,
        used: &[usize],
        most_rounds: usize,
        held: Option<usize>,
    ) -> Option<Found> {
        if used.len() < 4 * REPLAYED {
            return None;
        }
        let delta = self.delta;
        let mut x = start;
        let (mut damping, mut settled, mut rounds) = (1e-2_f64, false, 0);
        let mut about = replay.about(&x, used);
        let mut cost = loss(&about.residuals, delta);
        for round in 1..=most_rounds {
            rounds = round as u32;
            let mut normal = NormalEquations::<REPLAYED>::default();
            for (row, residual) in about.problem.rows.iter().zip(&about.residuals) {
                // Units of the loss in which it turns linear at 1.
                let scaled = residual / delta;
                normal.add(row, scaled, Piece::of(scaled));
            }
            if let Some(held) = held {
                normal.gradient[held] = 0.0;
                for j in 0..REPLAYED {
                    normal.matrix[held][j] = 0.0;
                    normal.matrix[j][held] = 0.0;
                }
            }
            // Steps of several dampings at once: which is best is not known where impacts make the
            // cost rough.
            let mut points = [x; LANES];
            let mut dampings = [0.0; LANES];
            for (lane, point) in points.iter_mut().enumerate() {
                dampings[lane] = damping * math::pow(10.0, 0.75 * (lane as f64 - 2.0));
                let mut matrix = normal.matrix;
                for (j, line) in matrix.iter_mut().enumerate() {
                    // A column without any effect on the log stays where it is.
                    line[j] = (line[j] * (1.0 + dampings[lane])).max(f64::MIN_POSITIVE.sqrt());
                }
                let Some(step) = solve_small(&matrix, &normal.gradient) else {
                    continue;
                };
                *point = bounded(
                    std::array::from_fn(|j| x[j] + delta * step[j]),
                    &x,
                    self.load.inertia_kgm2,
                );
            }
            let costs = costs_of(replay, &points, used, delta);
            let (lane, found) = costs
                .iter()
                .copied()
                .enumerate()
                .min_by(|a, b| a.1.total_cmp(&b.1))?;
            if found < cost {
                settled = cost - found < SETTLED_SHARE * cost;
                x = points[lane];
                damping = dampings[lane].max(1e-7);
                about = replay.about(&x, used);
                cost = loss(&about.residuals, delta);
            } else {
                // A minimum is also where no step helps any more.
                settled = damping > MAX_DAMPING;
                damping *= 1e4;
            }
            if settled {
                break;
            }
        }
        Some(Found {
            x,
            cost,
            residuals: about.residuals,
            rounds,
            settled,
        })
    }
}

/// Coefficients that a shaft can have with a load near the one that slides, not more than halved or
/// doubled in a step: far from the minimum a step may lead anywhere.
fn bounded(next: Coefficients, from: &Coefficients, inertia_kgm2: f64) -> Coefficients {
    std::array::from_fn(|j| match j {
        HALF_GAP | COMPLIANCE => next[j].clamp(0.5 * from[j], 2.0 * from[j]),
        INERTIA => next[j].clamp(inertia_kgm2 / INERTIA_DOUBT, INERTIA_DOUBT * inertia_kgm2),
        DAMPING_TIME => next[j].clamp(0.0, MAX_DAMPING_TIME_S),
        COULOMB | VISCOUS => next[j].max(0.0),
        LATENESS => next[j].clamp(-MAX_LATENESS_S, MAX_LATENESS_S),
        _ => next[j],
    })
}

/// Sum of Huber's losses.
fn loss(residuals: &[f64], delta: f64) -> f64 {
    residuals.iter().map(|r| huber(*r, delta)).sum()
}

/// Huber's loss of one residual.
pub(super) fn huber(residual: f64, delta: f64) -> f64 {
    let size = residual.abs();
    if size <= delta {
        0.5 * size * size
    } else {
        delta * (size - 0.5 * delta)
    }
}
