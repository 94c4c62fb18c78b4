//! The gaps that the log allows: the profile of the cost, judged by whole blocks of the log.
//!
//! Impacts make the cost rough and its curvature at one point tells little. So the gap is held
//! beside the minimum, everything else is fitted anew, and the costs of the two are compared block
//! by block (Vuong 1989): their difference `D = sum d_g` over `G` blocks has the standard error
//! `sqrt(G) sd(d_g)`, whatever the residuals' distribution and however they go together within a
//! block. Near the minimum `D` grows with the square of the distance and the error with the distance
//! itself, and a distance of `t` standard errors of the gap has `D` at `t/2` of its own.

use super::replay::HALF_GAP;
use super::search::{Found, Search, huber};
use crate::spread::student_975;

/// Distances from the minimum, in parts of the gap: the first, each next one larger by the factor,
/// and the most on one side.
const FIRST_DISTANCE: f64 = 2e-3;
const DISTANCE_FACTOR: f64 = 3.0;
const MOST_DISTANCES: usize = 6;
/// Fall of the cost beside the minimum, in parts of its mean over the windows, from which on the
/// search begins anew from there. A choice: 1 is what noise alone brings about by one coefficient;
/// a minimum that is worse by 20 is some four standard errors off.
const BETTER_BY: f64 = 2.0;
/// How much surer than at 95 % by the scatter of the blocks a gap has to be rejected. Tuned on
/// logs with a known gap: with 1 the interval missed 2 of 10 with 2 % of noise, since all blocks
/// have in common that the current between two samples is not their mean.
const SURE_FACTOR: f64 = 1.3;
/// Minima that are tried.
const MOST_MINIMA: usize = 6;
/// Rounds of descent at each distance, and from a better point.
const ROUNDS: usize = 3;
const BETTER_ROUNDS: usize = 8;
/// Length of a block of the log, s. A choice: residuals of one stroke err alike, and strokes last
/// some tenths of a second.
pub(super) const BLOCK_S: f64 = 0.5;

/// One end of the interval.
struct Edge {
    /// From the minimum, in parts of the gap; 1 where no gap is rejected.
    distance: f64,
    /// The 97.5 % quantile of Student's t for the blocks that reject.
    quantile: f64,
    /// A deeper point on the way.
    better: Option<Found>,
    /// The last point that was looked at: its distance, and its losses over the blocks.
    last: (f64, Vec<f64>),
}

/// The minimum, which may be a better one than before, and the interval of the half gap.
pub(super) struct Profile {
    pub(super) found: Found,
    pub(super) interval_rad: [f64; 2],
    /// Half the interval's width over the quantile: the standard error.
    pub(super) standard_error_rad: f64,
    pub(super) blocks: usize,
}

/// Parts of the log that are held against each other.
const PARTS: usize = 3;

impl Search<'_> {
    /// The profile about a minimum; `numbers`: the block of each window that counts. `None` where
    /// better minima turn up beside each minimum.
    pub(super) fn profile(
        &self,
        found: Found,
        used: &[usize],
        numbers: &[usize],
    ) -> Option<Profile> {
        let count = numbers.last()? + 1;
        let mut best = found;
        for _ in 0..MOST_MINIMA {
            let losses = self.by_block(&best, numbers, count);
            // A minimum that was not the deepest is left for the one beside it.
            let low = self.edge(&best, -1.0, used, numbers, &losses)?;
            if let Some(better) = low.better {
                best = self.descend(&self.short, better.x, used, BETTER_ROUNDS)?;
                continue;
            }
            let high = self.edge(&best, 1.0, used, numbers, &losses)?;
            if let Some(better) = high.better {
                best = self.descend(&self.short, better.x, used, BETTER_ROUNDS)?;
                continue;
            }
            let gap = best.x[HALF_GAP];
            // About a regular minimum both sides are alike; a side that is narrower is so because
            // impacts make the cost rough.
            let distance = low.distance.max(high.distance);
            let interval_rad = [gap * (1.0 - distance), gap * (1.0 + distance)];
            let quantile = 0.5 * (low.quantile + high.quantile);
            let standard_error_rad = 0.5 * (interval_rad[1] - interval_rad[0]) / quantile;
            // Parts that disagree show errors that last longer than a block: the interval widens
            // by the scale factor of Birge (1932).
            let factor = gap * parts_error(&losses, &low.last, &high.last) / standard_error_rad;
            let factor = if factor > 1.0 { factor } else { 1.0 };
            let interval_rad = interval_rad.map(|end| gap + factor * (end - gap));
            return Some(Profile {
                interval_rad,
                standard_error_rad: factor * standard_error_rad,
                blocks: count,
                found: best,
            });
        }
        None
    }

    /// Where the interval ends on one side.
    fn edge(
        &self,
        best: &Found,
        side: f64,
        used: &[usize],
        numbers: &[usize],
        losses: &[f64],
    ) -> Option<Edge> {
        let mut edge = Edge {
            distance: 1.0,
            quantile: student_975(f64::INFINITY),
            better: None,
            last: (0.0, Vec::new()),
        };
        // Each gap begins with what went best with the one before.
        let (mut x, mut before) = (best.x, (0.0, 0.0));
        let mut distance = FIRST_DISTANCE;
        let better_share = BETTER_BY / used.len() as f64;
        for _ in 0..MOST_DISTANCES {
            x[HALF_GAP] = best.x[HALF_GAP] * (1.0 + side * distance);
            let beside = self.descend_but(&self.short, x, used, ROUNDS, Some(HALF_GAP))?;
            edge.last = (distance, self.by_block(&beside, numbers, losses.len()));
            let verdict = verdict(losses, &edge.last.1);
            edge.quantile = verdict.quantile;
            x = beside.x;
            if beside.cost < (1.0 - better_share) * best.cost {
                edge.better = Some(beside);
                return Some(edge);
            }
            // In units of the quantile at which a gap is rejected (head of the module).
            let ratio = (verdict.ratio / (0.5 * SURE_FACTOR * verdict.quantile)).max(0.0);
            if ratio >= 1.0 {
                // Straight between the last that passes and the first that does not.
                let (last, passed): (f64, f64) = before;
                edge.distance = last + (1.0 - passed) / (ratio - passed) * (distance - last);
                return Some(edge);
            }
            before = (distance, ratio);
            distance *= DISTANCE_FACTOR;
        }
        Some(edge)
    }

    /// Cost of a rival beyond that of a minimum, over the standard error of their difference.
    pub(super) fn ratio(&self, found: &Found, rival: &Found, numbers: &[usize]) -> f64 {
        let count = numbers.last().map_or(0, |last| last + 1);
        let [best, worse] = [found, rival].map(|found| self.by_block(found, numbers, count));
        verdict(&best, &worse).ratio
    }

    /// Losses of a minimum over each block.
    fn by_block(&self, found: &Found, numbers: &[usize], count: usize) -> Vec<f64> {
        let mut sums = vec![0.0; count];
        for (residual, number) in found.residuals.iter().zip(numbers) {
            sums[*number] += huber(*residual, self.delta);
        }
        sums
    }
}

/// Standard error of the gap in its own parts as the log's parts show it: each one's slope of the
/// cost at the minimum, by the parabola through three points, over the curvature of them all.
fn parts_error(losses: &[f64], low: &(f64, Vec<f64>), high: &(f64, Vec<f64>)) -> f64 {
    let (below, above) = (low.0, high.0);
    let (mut curvature, mut squares) = (0.0, 0.0);
    let part = losses.len().div_ceil(PARTS).max(1);
    let parts = || {
        losses
            .chunks(part)
            .zip(low.1.chunks(part))
            .zip(high.1.chunks(part))
    };
    for ((here, low), high) in parts() {
        let sum = |losses: &[f64]| losses.iter().sum::<f64>();
        let [down, up] = [sum(low) - sum(here), sum(high) - sum(here)];
        let slope = (up * below / above - down * above / below) / (below + above);
        squares += slope * slope;
        curvature += 2.0 * (up / above + down / below) / (below + above);
    }
    let count = parts().count() as f64;
    (squares * count / (count - 1.0)).sqrt() / curvature
}

/// How much worse one fit is than another.
struct Verdict {
    /// Sum of the differences over its standard error.
    ratio: f64,
    /// The 97.5 % quantile of Student's t for the blocks behind it.
    quantile: f64,
}

/// Two fits compared by their losses over the blocks (head of the module).
fn verdict(better: &[f64], worse: &[f64]) -> Verdict {
    let differences: Vec<f64> = better.iter().zip(worse).map(|(b, w)| w - b).collect();
    let count = differences.len() as f64;
    let sum: f64 = differences.iter().sum();
    let mean = sum / count;
    let square: f64 = differences.iter().map(|d| (d - mean) * (d - mean)).sum();
    let size: f64 = differences.iter().map(|d| (d - mean).abs()).sum();
    let error = (square * count / (count - 1.0)).sqrt();
    Verdict {
        ratio: if error > 0.0 { sum / error } else { 0.0 },
        quantile: student_975(size * size / square - 1.0),
    }
}
