//! The limits of beta over a window.

use lostmotion_base::vec::dot;

use super::ends::End;

/// Value of a quadratic spline in the middle of an interval from its three coefficients there.
pub(super) const MIDDLE: [f64; 3] = [0.125, 0.75, 0.125];
/// The margin by which eased limits keep the start.
const EASE: f64 = 2e-4;

/// The same for a largest beta: what is reached by a limit of its own needs next to no margin.
const ROUNDING: f64 = 1e-5;

/// One joint's limits in one interval, divided by the limit: acceleration by the three
/// coefficients, jerk over sqrt(beta) likewise.
pub(super) type Rows = [[f64; 3]; 2];

/// A window of intervals.
#[derive(Clone, Debug, Default)]
pub(super) struct Problem {
    /// Nominal time of an interval, s.
    pub(super) step_s: f64,
    /// Joints with limits.
    pub(super) joints: usize,
    /// By interval, then joint.
    pub(super) rows: Vec<Rows>,
    /// By interval: one over the largest beta that velocities and feed allow.
    pub(super) inverse_ceilings: Vec<f64>,
    /// What the window begins and ends with.
    pub(super) ends: [End; 2],
}

impl Problem {
    /// Lets the first intervals keep the start, which a given state at the start may force on them:
    /// what it does not keep by a margin is scaled until it does.
    pub(super) fn ease(&mut self, intervals: usize, x: &[f64]) {
        for interval in 0..intervals.min(self.inverse_ceilings.len()) {
            let local = Local::at(x, interval);
            let inverse = &mut self.inverse_ceilings[interval];
            *inverse = inverse.min((1.0 - ROUNDING) / local.beta);
            for rows in &mut self.rows[interval * self.joints..(interval + 1) * self.joints] {
                for (kind, row) in rows.iter_mut().enumerate() {
                    let (right, _) = local.right(kind);
                    let left = dot(*row, local.x).abs();
                    if left > right * (1.0 - EASE) {
                        *row = row.map(|c| c * (right * (1.0 - EASE) / left));
                    }
                }
            }
        }
    }
}

impl Problem {
    /// Takes part of an interval's limits of acceleration and jerk away.
    pub(super) fn tighten(&mut self, interval: usize, scale: [f64; 2]) {
        for rows in &mut self.rows[interval * self.joints..(interval + 1) * self.joints] {
            for (row, scale) in rows.iter_mut().zip(scale) {
                *row = row.map(|c| c / scale);
            }
        }
    }
}

/// beta in the middle of an interval and what the right side of the jerk's limit and its slope are
/// there.
#[derive(Clone, Copy)]
pub(super) struct Local {
    pub(super) x: [f64; 3],
    pub(super) beta: f64,
    root: f64,
    slope: f64,
}

impl Local {
    pub(super) fn at(x: &[f64], interval: usize) -> Local {
        let x = [x[interval], x[interval + 1], x[interval + 2]];
        let beta = dot(MIDDLE, x);
        let root = 1.0 / beta.sqrt();
        Local {
            x,
            beta,
            root,
            slope: -0.5 * root / beta,
        }
    }

    /// The right side of a limit and its slope by beta: row 0 acceleration, row 1 jerk.
    pub(super) fn right(&self, kind: usize) -> (f64, f64) {
        if kind == 0 {
            (1.0, 0.0)
        } else {
            (self.root, self.slope)
        }
    }
}
