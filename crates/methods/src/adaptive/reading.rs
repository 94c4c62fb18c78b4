//! The gap from one window: the hypothesis under which the motor's motion is least surprising, and
//! how sure that is.
//!
//! 1. Onset: as if the gap had no end. Where the motor then does what its current does not explain,
//!    it met the far flank. A little after that the window ends: what follows, the shaft's ringing,
//!    tells of the load but not of the gap.
//! 2. Candidates: half gaps that would end there. The best is looked at closely (fine).
//! 3. Gauss-Newton (`newton`) over gap, load, stiffness and motor friction; all but the gap are
//!    held by what is known of them (`prior`).
//! 4. Where no hypothesis is good, a grid of half gaps and once more from there.
//!
//! The work is spread over servo ticks, a few samples in each, so that no tick takes longer than
//! another.

use super::lanes::{Hypotheses, Known, LANES, Progress, WARM_UP};
use super::newton::{Accepted, Newton, Sums};
use super::prior::{GAP, Prior, Vector, lanes_of, uniform};
use super::said::{AGAINST, ENDLESS, Onset, Said};
use super::window::Window;
use lostmotion_base::math;
use serde::{Deserialize, Serialize};

/// Ticks in a row that a slow motor's encoder errs alike, at most; the filter remembers no more.
const LIKE: f64 = 12.0;
/// Samples taken in a tick.
const SAMPLES_PER_TICK: usize = 32;
/// Half gaps of the grid: first, ratio, passes of eight.
const GRID_FROM: f64 = 6e-5;
const GRID_RATIO: f64 = 1.3;
const GRID_PASSES: u32 = 4;
/// Spacing when a half gap is looked at closely, after candidates and after the grid.
const CLOSE: f64 = 0.01;
const CLOSE_TO_GRID: f64 = 0.05;
/// Measurement noise that is supposed, rad: with less of it the innovations are sharper.
const NOISE: [f64; 2] = [2e-6, 3e-7];
/// Attempts to see an onset: index of the noise; and the sum of squared innovations over their
/// variance that is enough. The last is for a contact that shows but faintly.
const SEEN: [(usize, f64); 4] = [(0, 1e4), (1, 1e4), (1, 400.0), (1, 60.0)];
/// Half gaps that are tried: index of an onset and part of it. A soft contact is seen late.
const TRIED: [(usize, f64); LANES] = [
    (0, 1.01),
    (0, 0.99),
    (0, 0.97),
    (0, 0.94),
    (0, 0.9),
    (1, 0.98),
    (2, 0.97),
    (3, 0.96),
];
/// Mean square of the innovations over their variance from which on a hypothesis is poor.
const POOR: f64 = 10.0;
/// Standard deviation over value at which a half gap is clear enough not to look with less noise.
const CLEAR: f64 = 5e-3;

/// Where the work is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
enum Phase {
    Onset(usize),
    Candidates,
    Grid(u32),
    Fine,
    Newton,
    Check,
}

/// A reading under way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Reading {
    window: Window,
    /// Length of what is read of it, s, and the motor's largest speed, rad/s.
    extent: (f64, f64),
    /// What the encoder's noise is multiplied by, as its steps last for several ticks of a slow
    /// motor and err alike.
    steps: f64,
    prior: Prior,
    phase: Phase,
    hypotheses: Hypotheses,
    progress: Progress,
    sums: Sums,
    onset: Onset,
    searched: bool,
    /// Index of the supposed noise, and what was found with more of it.
    level: usize,
    noisier: Option<Accepted>,
    /// What stands at the end.
    found: Option<Accepted>,
    /// Best half gap so far and its cost; mean square of the innovations without a gap.
    best: (f64, f64),
    without: f64,
    newton: Newton,
}

impl Reading {
    /// `noise`: standard deviation of a measured position, rad.
    pub(super) fn new(window: Window, prior: Prior, noise: f64) -> Reading {
        let count = noise * 12.0_f64.sqrt();
        let at = prior.mean();
        let hypotheses = uniform(&at, prior.load.damping);
        let progress = Progress::start(&window, &hypotheses);
        let mut reading = Reading {
            extent: window.extent(),
            steps: (1.0 + (count / window.pace().max(count / LIKE)).min(LIKE)).sqrt(),
            window,
            prior,
            phase: Phase::Onset(0),
            hypotheses,
            progress,
            sums: Sums::default(),
            onset: Onset::default(),
            searched: false,
            level: 0,
            noisier: None,
            found: None,
            best: (0.0, f64::INFINITY),
            without: 0.0,
            newton: Newton::new(at),
        };
        reading.begin();
        reading
    }

    /// Sets out on a pass of the present phase.
    fn begin(&mut self) {
        let mut lanes = uniform(&self.newton.at, self.prior.load.damping);
        if self.phase == Phase::Newton {
            let step = self.differences();
            for (unknown, step) in step.into_iter().enumerate() {
                lanes_of(&mut lanes, unknown)[unknown + 1] += step;
            }
        } else {
            lanes.half_gap = std::array::from_fn(|lane| self.half_gap_of(lane));
        }
        self.hypotheses = lanes;
        self.progress = Progress::start(&self.window, &self.hypotheses);
        self.sums = Sums::default();
    }

    /// Differences from which derivatives are taken.
    fn differences(&self) -> Vector {
        let (time_s, speed) = self.extent;
        self.prior.step(self.newton.at[GAP], time_s, speed)
    }

    fn half_gap_of(&self, lane: usize) -> f64 {
        match self.phase {
            Phase::Onset(_) => [0.0, ENDLESS, 2e-4, 6e-4, 2e-3, 6e-3, 2e-2, 6e-2][lane],
            Phase::Candidates if lane + 1 == LANES && self.prior.half_gap > 0.0 => {
                self.prior.half_gap
            }
            Phase::Candidates => {
                let (which, part) = TRIED[lane];
                part * self.onset.half_ways[which]
                    .or(self.onset.half_ways[0])
                    .unwrap_or(GRID_FROM)
            }
            Phase::Grid(pass) => {
                GRID_FROM
                    * math::exp(
                        (f64::from(pass) * LANES as f64 + lane as f64) * math::log(GRID_RATIO),
                    )
            }
            Phase::Check => AGAINST
                .get(lane)
                .map_or(ENDLESS, |part| part * self.newton.at[GAP]),
            Phase::Fine | Phase::Newton => {
                let close = if self.searched { CLOSE_TO_GRID } else { CLOSE };
                self.best.0 * (1.0 + close * (lane as f64 - 0.5 * (LANES - 1) as f64))
            }
        }
    }

    /// Works for one tick. Returns what the window says once that is known.
    pub(super) fn work(&mut self, known: &Known) -> Option<Said> {
        let noise = (known.noise * self.steps).max(NOISE[self.level]);
        let known = &Known { noise, ..*known };
        for _ in 0..SAMPLES_PER_TICK {
            match self.progress.step(known, &self.hypotheses, &self.window) {
                Some(Some(innovation)) => {
                    if let Phase::Onset(attempt) = self.phase {
                        let (side, known) = (f64::from(self.window.side), self.prior.half_gap);
                        self.onset
                            .look(&innovation, &self.progress, side, known, SEEN[attempt].1);
                    }
                    self.sums.add(&innovation, self.phase == Phase::Newton);
                }
                Some(None) => {}
                None => return self.pass_done(noise > NOISE[self.level]),
            }
        }
        None
    }

    fn count(&self) -> f64 {
        self.window.samples.len().saturating_sub(WARM_UP).max(1) as f64
    }

    /// `noisy`: the encoder is noisier than what is supposed, so that nothing changes with less.
    fn pass_done(&mut self, noisy: bool) -> Option<Said> {
        match self.phase {
            Phase::Onset(attempt) => {
                let Some(end) = self.onset.end else {
                    return self.look_again(attempt + 1);
                };
                self.without = self.sums.cost[0] / self.count();
                self.window.samples.truncate(end);
                self.extent = self.window.extent();
                self.phase = Phase::Candidates;
            }
            Phase::Candidates => self.keep_best(Phase::Fine),
            Phase::Grid(pass) => self.keep_best(if pass + 1 < GRID_PASSES {
                Phase::Grid(pass + 1)
            } else {
                Phase::Fine
            }),
            Phase::Fine => {
                self.keep_best(Phase::Newton);
                self.newton.at[GAP] = self.best.0;
            }
            Phase::Newton => {
                if self
                    .newton
                    .take(&self.sums, self.count(), &self.prior, &self.differences())
                    && self.settle(noisy)
                {
                    let Some(found) = self.found else {
                        return Some(Said::NOTHING);
                    };
                    (self.newton.at, self.phase) = (found.at, Phase::Check);
                }
            }
            Phase::Check => {
                return self.found.map(|found| {
                    Said::checked(&found, &self.sums.cost, self.window.wavered, self.without)
                });
            }
        }
        self.begin();
        None
    }

    fn look_again(&mut self, attempt: usize) -> Option<Said> {
        let Some((level, _)) = SEEN.get(attempt) else {
            return Some(Said::NOTHING);
        };
        (self.level, self.onset, self.phase) = (*level, Onset::default(), Phase::Onset(attempt));
        self.begin();
        None
    }

    fn keep_best(&mut self, next: Phase) {
        for (gap, cost) in self.hypotheses.half_gap.iter().zip(self.sums.cost) {
            if cost < self.best.1 {
                self.best = (*gap, cost);
            }
        }
        self.phase = next;
    }

    /// After Gauss-Newton: whether what was found stands, or is looked for on.
    fn settle(&mut self, noisy: bool) -> bool {
        let found = self.newton.accepted.filter(|found| found.misfit <= POOR);
        if found.is_none() && self.noisier.is_some() {
            self.found = self.noisier;
            return true;
        }
        if found.is_none() && !self.searched {
            (self.newton, self.searched, self.phase) =
                (Newton::new(self.prior.mean()), true, Phase::Grid(0));
            return false;
        }
        let clear =
            |found: Accepted| found.variance < CLEAR * CLEAR * found.at[GAP] * found.at[GAP];
        let last =
            noisy || self.level + 1 >= NOISE.len() || self.level > 0 && found.is_some_and(clear);
        if last || found.is_none() {
            self.found = self.newton.accepted;
            return true;
        }
        self.noisier = found;
        self.newton = Newton::new(found.map_or(self.newton.at, |found| found.at));
        self.level += 1;
        false
    }
}
