//! The gap from one window: the hypothesis under which the motor's motion is least surprising, and how sure that is.
//!
//! Unknown are the half gap and, within what is known of them beforehand, load, stiffness and motor friction. First a grid of half gaps, eight in a pass;
//! then Gauss-Newton steps, the derivatives by differences from seven more hypotheses in the same pass. The curvature at the end is the
//! information that the window holds; its inverse, widened by what stays unexplained, is the variance of the half gap.
//! The work is spread over servo ticks, a few samples in each, so that no tick takes longer than another.

use super::super::twin::LoadModel;
use super::lanes::{Hypotheses, Innovation, Known, LANES, Lanes, Progress, WARM_UP};
use super::window::Window;
use serde::{Deserialize, Serialize};

/// Samples taken in a tick.
const SAMPLES_PER_TICK: usize = 8;
/// Unknowns: half gap, Coulomb friction, constant torque, inertia, viscous friction, stiffness, motor's Coulomb friction.
const N: usize = LANES - 1;
const GAP: usize = 0;
const INERTIA: usize = 3;
const STIFFNESS: usize = 5;
const MOTOR: usize = 6;
/// Places of inertia, viscous friction, Coulomb friction and constant torque among the unknowns.
const OF_LOAD: [usize; 4] = [INERTIA, 4, 1, 2];
/// Half gaps of the grid: from, ratio, passes of eight.
const GRID_FROM: f64 = 6e-5;
const GRID_RATIO: f64 = 1.3;
const GRID_PASSES: u32 = 4;
/// Measurement noise that is supposed, one after the other, rad: with less of it the innovations are sharper.
const NOISE: [f64; 2] = [2e-6, 3e-7];
/// Sum of squared innovations over their variance, without an end of the gap, at which enough of the contact has been seen, from attempt to
/// attempt: with much noise supposed, with little, and at last for a contact that shows but faintly. And samples after that.
const SEEN: [(usize, f64); 3] = [(0, 1e4), (1, 1e4), (1, 400.0)];
const AFTER: usize = 4;
/// Part of a known half gap over which no contact is looked for.
const LOOKED: f64 = 0.5;
/// Squares that come without contact.
const EXPECTED: f64 = 3.0;
/// Innovations over their standard deviation that tell of contact.
const THRESHOLDS: [f64; 4] = [4.0, 8.0, 16.0, 32.0];
/// A half gap that is never crossed, rad.
const ENDLESS: f64 = 10.0;
/// Half gaps that are tried: index of an onset and part of it. A soft contact is seen late.
const TRIED: [(usize, f64); LANES] = [(0, 1.01), (0, 0.99), (0, 0.97), (0, 0.94), (0, 0.9), (1, 0.98), (2, 0.97), (3, 0.96)];
/// Mean square of the innovations over their variance from which on a hypothesis is poor.
const POOR: f64 = 10.0;
/// Standard deviation over value at which a half gap is clear enough.
const CLEAR: f64 = 5e-3;
/// Passes of Gauss-Newton at most.
const MOST_STEPS: u32 = 6;

type Vector = [f64; N];

/// What a reading starts from: best guess and standard deviation of every unknown; the half gap has no prior.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Prior {
    pub(super) load: LoadModel,
    /// Covariance of the load's inertia, viscous friction, Coulomb friction and constant torque, SI.
    pub(super) covariance: [[f64; 4]; 4],
    pub(super) motor_coulomb: f64,
    pub(super) rated_torque: f64,
    /// Half gap near which to look, rad; 0 for anywhere.
    pub(super) half_gap: f64,
}

impl Prior {
    fn mean(&self) -> Vector {
        let load = &self.load;
        [self.half_gap, load.coulomb, load.constant, load.inertia, load.viscous, load.stiffness, self.motor_coulomb]
    }

    /// What is not said by the covariance: models are never quite right.
    fn slack(&self) -> Vector {
        let (load, rated) = (&self.load, self.rated_torque);
        [
            f64::INFINITY,
            0.005 * load.coulomb + 2e-4 * rated,
            3e-4 * rated,
            0.02 * load.inertia,
            0.02 * load.viscous + 1e-5 * rated,
            0.1 * load.stiffness,
            0.02 * self.motor_coulomb + 2e-4 * rated,
        ]
    }

    fn spread(&self) -> Vector {
        let mut spread = self.slack();
        for (unknown, entry) in OF_LOAD.into_iter().enumerate() {
            spread[entry] += self.covariance[unknown][unknown].max(0.0).sqrt();
        }
        spread[INERTIA] = spread[INERTIA].min(self.load.inertia);
        spread
    }

    /// Information beforehand: the inverse of covariance and slack; none of the gap.
    fn information(&self) -> [Vector; N] {
        let slack = self.slack();
        let mut information = [[0.0; N]; N];
        for unknown in [STIFFNESS, MOTOR] {
            information[unknown][unknown] = 1.0 / (slack[unknown] * slack[unknown]);
        }
        // in units of the slack, so that the numbers are of like size
        let scaled: [[f64; 4]; 4] = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                self.covariance[i][j] / (slack[OF_LOAD[i]] * slack[OF_LOAD[j]]) + if i == j { 1.0 } else { 0.0 }
            })
        });
        let l = factor(&scaled);
        for (j, column) in OF_LOAD.into_iter().enumerate() {
            let unit: [f64; 4] = std::array::from_fn(|i| if i == j { 1.0 } else { 0.0 });
            for (i, value) in solve(&l, &unit).into_iter().enumerate() {
                information[OF_LOAD[i]][column] = value / (slack[OF_LOAD[i]] * slack[column]);
            }
        }
        information
    }

    /// Differences for the derivatives.
    fn step(&self, half_gap: f64) -> Vector {
        let mut step = self.spread().map(|spread| 0.2 * spread);
        step[GAP] = (0.01 * half_gap).max(1e-6);
        step
    }
}

/// Where the work is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
enum Phase {
    /// No gap, a gap without end, and some between.
    Onset(usize),
    /// Gaps that end where the motor was first seen to meet something.
    Candidates,
    Grid(u32),
    Fine,
    Newton(u32),
}

/// A reading under way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Reading {
    window: Window,
    prior: Prior,
    phase: Phase,
    hypotheses: Hypotheses,
    progress: Progress,
    /// Sums over the pass: squares of all lanes, normal equations.
    cost: Lanes,
    normal: [[f64; N]; N],
    right: Vector,
    /// Way across the gap at which the innovations without an end first exceeded each threshold, rad.
    onset: [Option<f64>; THRESHOLDS.len()],
    searched: bool,
    /// Sum of squares without an end of the gap, and the samples up to where enough was seen.
    met: f64,
    end: Option<usize>,
    count0: f64,
    faint: bool,
    /// Index of the noise level.
    level: usize,
    before: Option<Accepted>,
    /// Best half gap of the grid so far and its cost.
    best: (f64, f64),
    /// Cost without a gap.
    without: f64,
    /// The present point, the last accepted one with its cost, and the step taken from it.
    at: Vector,
    accepted: Option<Accepted>,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Accepted {
    at: Vector,
    cost: f64,
    misfit: f64,
    step: Vector,
    variance: f64,
}

/// What a window says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Said {
    pub(super) half_gap: f64,
    /// Variance of the half gap, rad2.
    pub(super) variance: f64,
    pub(super) stiffness: f64,
    /// Whether the contact showed but faintly.
    pub(super) faint: bool,
    pub(super) at: Vector,
    /// Mean square of the innovations over their variance: with the best hypothesis, and without a gap.
    pub(super) misfit: f64,
    pub(super) without: f64,
}

impl Said {
    /// No contact was seen.
    const NOTHING: Said = Said { half_gap: 0.0, variance: f64::INFINITY, stiffness: 0.0, faint: true, at: [0.0; N], misfit: 0.0, without: 0.0 };
}

impl Reading {
    pub(super) fn new(window: Window, prior: Prior) -> Reading {
        let near = prior.half_gap > 0.0;
        let phase = Phase::Onset(0);
        let at = prior.mean();
        let hypotheses = uniform(&at, prior.load.damping);
        let progress = Progress::start(&window, &hypotheses);
        let mut reading = Reading {
            window, prior, phase, hypotheses, progress,
            cost: [0.0; LANES], normal: [[0.0; N]; N], right: [0.0; N],
            onset: [None; THRESHOLDS.len()], searched: false, met: 0.0, end: None, count0: 1.0, faint: false, level: 0, before: None, best: (0.0, f64::INFINITY), without: f64::NAN, at, accepted: None,
        };
        reading.begin();
        reading
    }

    /// Sets out on a pass of the present phase.
    fn begin(&mut self) {
        let mut lanes = uniform(&self.at, self.prior.load.damping);
        match self.phase {
            Phase::Onset(_) => lanes.half_gap = [0.0, ENDLESS, 2e-4, 6e-4, 2e-3, 6e-3, 2e-2, 6e-2],
            Phase::Candidates => {
                for (lane, gap) in lanes.half_gap.iter_mut().enumerate() {
                    let (which, part) = TRIED[lane];
                    *gap = self.onset[which].or(self.onset[0]).unwrap_or(self.best.0) * part;
                    if lane + 1 == LANES && self.prior.half_gap > 0.0 {
                        *gap = self.prior.half_gap;
                    }
                }
            }
            Phase::Grid(pass) => {
                let mut exponent = f64::from(pass * LANES as u32) - 1.0;
                for gap in &mut lanes.half_gap {
                    *gap = if exponent < 0.0 { 0.0 } else { GRID_FROM * lostmotion_base::math::exp(exponent * lostmotion_base::math::log(GRID_RATIO)) };
                    exponent += 1.0;
                }
            }
            Phase::Fine => {
                for (lane, gap) in lanes.half_gap.iter_mut().enumerate() {
                    *gap = self.best.0 * (1.0 + if self.searched { 0.05 } else { 0.01 } * (lane as f64 - 3.5));
                }
            }
            Phase::Newton(_) => {
                let step = self.prior.step(self.at[GAP]);
                for unknown in 0..N {
                    unknown_of(&mut lanes, unknown)[unknown + 1] += step[unknown];
                }
            }
        }
        self.hypotheses = lanes;
        self.progress = Progress::start(&self.window, &self.hypotheses);
        (self.cost, self.normal, self.right) = ([0.0; LANES], [[0.0; N]; N], [0.0; N]);
    }

    /// Works for one tick. Returns what the window says once that is known.
    pub(super) fn work(&mut self, known: &Known) -> Option<Said> {
        let known = &Known { noise: known.noise.max(NOISE[self.level]), ..*known };
        for _ in 0..SAMPLES_PER_TICK {
            match self.progress.step(known, &self.hypotheses, &self.window) {
                Some(Some(innovation)) => self.add(&innovation),
                Some(None) => {}
                None => return self.pass_done(self.level + 1 >= NOISE.len() || known.noise > NOISE[self.level]),
            }
        }
        None
    }

    fn add(&mut self, innovation: &Innovation) {
        let weight = 1.0 / innovation.variance;
        let e = &innovation.e;
        if let Phase::Onset(attempt) = self.phase {
            let side = f64::from(self.window.side);
            let way = ENDLESS - self.progress.lead[1] * side;
            let e = e[1] * side * weight.sqrt();
            self.met = (self.met + if e > 0.0 { e * e } else { 0.0 } - EXPECTED).max(0.0);
            // a traverse sets out so hard that it may look like a contact; so there is no looking for one over the first quarter of a gap that is known
            if way < LOOKED * self.prior.half_gap {
                self.met = 0.0;
            }
            if self.met > SEEN[attempt].1 && self.end.is_none() {
                self.end = Some(self.progress.taken() + AFTER);
            }
            for (onset, threshold) in self.onset.iter_mut().zip(THRESHOLDS) {
                if onset.is_none() && e > threshold && way > LOOKED * self.prior.half_gap {
                    *onset = Some(0.5 * way);
                }
            }
        }
        for (sum, e) in self.cost.iter_mut().zip(e) {
            *sum += weight * e * e;
        }
        if let Phase::Newton(_) = self.phase {
            for i in 0..N {
                let slope = e[i + 1] - e[0];
                self.right[i] -= weight * slope * e[0];
                for j in 0..=i {
                    self.normal[i][j] += weight * slope * (e[j + 1] - e[0]);
                }
            }
        }
    }

    fn count(&self) -> f64 {
        self.window.samples.len().saturating_sub(WARM_UP).max(1) as f64
    }

    fn pass_done(&mut self, last: bool) -> Option<Said> {
        match self.phase {
            Phase::Onset(attempt) => {
                self.keep_best();
                if self.end.is_none() && attempt + 1 < SEEN.len() {
                    (self.met, self.onset) = (0.0, [None; THRESHOLDS.len()]);
                    self.level = SEEN[attempt + 1].0;
                    self.phase = Phase::Onset(attempt + 1);
                    self.begin();
                    return None;
                }
                self.without = self.cost[0];
                self.count0 = self.count();
                self.faint = attempt > 0 || self.window.wavered;
                let Some(end) = self.end else { return Some(Said::NOTHING) };
                self.window.samples.truncate(end);
                self.best = (0.0, f64::INFINITY);
                self.phase = Phase::Candidates;
            }
            Phase::Candidates => {
                self.keep_best();
                self.phase = Phase::Fine;
            }
            Phase::Grid(pass) => {
                self.keep_best();
                self.phase = if pass + 1 < GRID_PASSES { Phase::Grid(pass + 1) } else { Phase::Fine };
                if self.best.0 <= 0.0 && pass + 1 >= GRID_PASSES {
                    self.best.0 = GRID_FROM;
                }
            }
            Phase::Fine => {
                self.keep_best();
                self.at[GAP] = self.best.0;
                self.phase = Phase::Newton(0);
            }
            Phase::Newton(steps) => {
                if !self.newton(steps) {
                    self.phase = Phase::Newton(steps + 1);
                } else if !self.searched && self.accepted.is_none_or(|accepted| accepted.misfit > POOR) {
                    // looked near a guess, or near an onset that was none: look on
                    self.accepted = None;
                    self.at = self.prior.mean();
                    self.searched = self.best.1.is_finite();
                    self.phase = if self.searched { Phase::Grid(0) } else { Phase::Candidates };
                } else {
                    let poor = self.accepted.is_none_or(|accepted| accepted.misfit > POOR);
                    if poor && self.before.is_some() {
                        self.accepted = self.before;
                        return self.said();
                    }
                    let clear = self.accepted.is_some_and(|accepted| accepted.variance < CLEAR * CLEAR * accepted.at[GAP] * accepted.at[GAP]);
                    if last || poor || clear && self.level > 0 {
                        return self.said();
                    }
                    self.before = self.accepted.take();
                    self.at = self.before.map_or(self.at, |before| before.at);
                    self.level += 1;
                    self.phase = Phase::Newton(0);
                }
            }
        }
        self.begin();
        None
    }

    fn keep_best(&mut self) {
        for (gap, cost) in self.hypotheses.half_gap.iter().zip(self.cost) {
            if cost < self.best.1 && *gap < ENDLESS {
                self.best = (*gap, cost);
            }
        }
    }

    /// Takes up a pass of Gauss-Newton. Says whether it was the last.
    fn newton(&mut self, steps: u32) -> bool {
        let (mean, information) = (self.prior.mean(), self.prior.information());
        let off: Vector = std::array::from_fn(|i| if i == GAP { 0.0 } else { self.at[i] - mean[i] });
        let pull: Vector = information.map(|row| row.iter().zip(off).map(|(a, x)| a * x).sum());
        let prior_cost: f64 = pull.iter().zip(off).map(|(a, x)| a * x).sum();
        let cost = self.cost[0] + prior_cost;
        let misfit = self.cost[0] / self.count();
        if !cost.is_finite() && self.accepted.is_none() {
            return true;
        }
        if let Some(accepted) = &mut self.accepted
            && !(cost <= accepted.cost)
        {
            // too far: half the way
            for i in 0..N {
                accepted.step[i] *= 0.5;
                self.at[i] = accepted.at[i] + accepted.step[i];
            }
            return steps + 1 >= MOST_STEPS;
        }
        let step = self.prior.step(self.at[GAP]);
        let (mut a, mut right) = (self.normal, self.right);
        let scale = misfit.max(1.0);
        for i in 0..N {
            for j in 0..=i {
                a[i][j] /= scale;
            }
            right[i] = right[i] / scale - pull[i] * step[i];
            for j in 0..=i {
                a[i][j] += information[i][j] * step[i] * step[j];
            }
            a[i][i] = a[i][i] * (1.0 + 1e-9) + 1e-12;
        }
        let l = factor(&a);
        let x = solve(&l, &right);
        let mut unit = [0.0; N];
        unit[GAP] = 1.0;
        let variance = solve(&l, &unit)[GAP] * step[GAP] * step[GAP];
        let before = self.accepted.map_or(f64::INFINITY, |accepted| accepted.cost);
        let mut moves: Vector = std::array::from_fn(|i| x[i] * step[i]);
        moves[GAP] = moves[GAP].max(-0.3 * self.at[GAP]).min(0.3 * self.at[GAP]);
        let at = self.at;
        self.accepted = Some(Accepted { at, cost, misfit, step: moves, variance });
        for i in 0..N {
            let least = if i == 2 { f64::NEG_INFINITY } else if i == 3 || i == 5 { 0.1 * mean[i] } else { 0.0 };
            self.at[i] = (at[i] + moves[i]).max(least);
        }
        let small = moves[GAP].abs() < (0.1 * variance.max(0.0).sqrt()).max(1e-3 * at[GAP]);
        small || before - cost < 1e-3 * cost && steps > 1 || steps + 1 >= MOST_STEPS
    }

    fn said(&self) -> Option<Said> {
        let Some(accepted) = &self.accepted else { return Some(Said::NOTHING) };
        Some(Said {
            half_gap: accepted.at[GAP],
            variance: accepted.variance,
            stiffness: accepted.at[5],
            faint: self.faint,
            at: accepted.at,
            misfit: accepted.misfit,
            without: self.without / self.count0,
        })
    }
}

fn uniform(at: &Vector, damping: f64) -> Hypotheses {
    let [half_gap, coulomb, constant, inertia, viscous, stiffness, motor_coulomb] = at.map(|value| [value; LANES]);
    Hypotheses { half_gap, coulomb, constant, inertia, viscous, stiffness, damping: [damping; LANES], motor_coulomb }
}

fn unknown_of(lanes: &mut Hypotheses, unknown: usize) -> &mut Lanes {
    match unknown {
        0 => &mut lanes.half_gap,
        1 => &mut lanes.coulomb,
        2 => &mut lanes.constant,
        3 => &mut lanes.inertia,
        4 => &mut lanes.viscous,
        5 => &mut lanes.stiffness,
        _ => &mut lanes.motor_coulomb,
    }
}

/// Cholesky's factor of a symmetric matrix given by its lower half.
fn factor<const M: usize>(a: &[[f64; M]; M]) -> [[f64; M]; M] {
    let mut l = [[0.0; M]; M];
    for i in 0..M {
        for j in 0..i {
            let sum: f64 = (0..j).map(|k| l[i][k] * l[j][k]).sum();
            l[i][j] = (a[i][j] - sum) / l[j][j];
        }
        let sum: f64 = (0..i).map(|k| l[i][k] * l[i][k]).sum();
        l[i][i] = (a[i][i] - sum).max(1e-14).sqrt();
    }
    l
}

fn solve<const M: usize>(l: &[[f64; M]; M], right: &[f64; M]) -> [f64; M] {
    let mut x = [0.0; M];
    for i in 0..M {
        let sum: f64 = (0..i).map(|k| l[i][k] * x[k]).sum();
        x[i] = (right[i] - sum) / l[i][i];
    }
    for i in (0..M).rev() {
        let sum: f64 = (i + 1..M).map(|k| l[k][i] * x[k]).sum();
        x[i] = (x[i] - sum) / l[i][i];
    }
    x
}

