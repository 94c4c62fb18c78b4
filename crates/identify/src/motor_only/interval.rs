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
}

/// The minimum, which may be a better one than before, and the interval of the half gap.
pub(super) struct Profile {
    pub(super) found: Found,
    pub(super) interval_rad: [f64; 2],
    /// Half the interval's width over the quantile: the standard error.
    pub(super) standard_error_rad: f64,
    pub(super) blocks: usize,
}

/// Parts of the log that are fitted each by itself.
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
            let interval_rad = [gap * (1.0 - low.distance), gap * (1.0 + high.distance)];
            let quantile = 0.5 * (low.quantile + high.quantile);
            return Some(Profile {
                interval_rad,
                standard_error_rad: 0.5 * (interval_rad[1] - interval_rad[0]) / quantile,
                blocks: count,
                found: best,
            });
        }
        None
    }

    /// How much farther the gaps of the log's parts lie from each other than the interval says: the
    /// scale factor of Birge (1932), `sqrt(chi2/(n - 1))`, at least 1.
    pub(super) fn disagreement(&self, profile: &Profile, used: &[usize]) -> Option<f64> {
        let part = used.len().div_ceil(PARTS);
        let gaps: Vec<f64> = used
            .chunks(part)
            .map(|used| {
                let found = self.descend(&self.short, profile.found.x, used, BETTER_ROUNDS)?;
                Some(found.x[HALF_GAP])
            })
            .collect::<Option<_>>()?;
        let count = gaps.len() as f64;
        let mean = gaps.iter().sum::<f64>() / count;
        let square: f64 = gaps.iter().map(|gap| (gap - mean) * (gap - mean)).sum();
        // A part has the error of the whole times the root of their number.
        let expected = profile.standard_error_rad * profile.standard_error_rad * count;
        Some((square / (count - 1.0) / expected).sqrt().max(1.0))
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
        };
        // Each gap begins with what went best with the one before.
        let (mut x, mut before) = (best.x, (0.0, 0.0));
        let mut distance = FIRST_DISTANCE;
        let better_share = BETTER_BY / used.len() as f64;
        for _ in 0..MOST_DISTANCES {
            x[HALF_GAP] = best.x[HALF_GAP] * (1.0 + side * distance);
            let beside = self.descend_but(&self.short, x, used, ROUNDS, Some(HALF_GAP))?;
            let verdict = verdict(losses, &self.by_block(&beside, numbers, losses.len()));
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
