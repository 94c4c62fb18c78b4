//! The gap from one window: the hypothesis under which the motor's motion is least surprising, and
//! its variance.
//!
//! 1. Onset: as if the gap had no end. Where the motor then deviates from what its current explains,
//!    it met the far flank. The window is cut a little after that: the ringing that follows tells of
//!    the load but not of the gap.
//! 2. Candidates: half gaps that would end there. The neighbourhood of the best is scanned (fine).
//! 3. Gauss-Newton (`newton`), a pass at a point and one along the step from it, over gap, load, stiffness and motor friction; all but the gap have a
//!    prior (`prior`).
//! 4. Where no hypothesis is good, a grid of half gaps, and once more from its best.
//! 5. Once more with less supposed noise where that sharpens the innovations.
//! 6. While the gap is not known: once more from what was known of the load before, but with the inertia that was
//!    found, with candidates of its own. A load that slides on while the motor stops lies where its friction lets it,
//!    and gap and friction explain the motion together in more than one way, to which an inertia that is not known
//!    yet leads. The one that is less surprising counts.
//! 7. The result is compared with alternatives (`said`).
//!
//! The work is spread over servo ticks, a fixed number of samples in each, so that no tick takes
//! longer than another.

use super::lanes::{Hypotheses, Known, LANES, Lanes, Progress, Stays, WARM_UP};
use super::newton::{Accepted, Newton, PARTS, Sums};
use super::prior::{GAP, INERTIA, Prior, Vector, lanes_of, uniform};
use super::said::{AGAINST, ENDLESS_HALF_GAP_RAD, ONSET_LANES, Onset, Said};
use super::window::Window;
use lostmotion_base::math;
use pulp::{Arch, Simd, WithSimd};
use serde::{Deserialize, Serialize};

/// Bound of the consecutive ticks in which the encoder of a slow motor has the same rounding error:
/// the filter remembers no more. A choice: about the filter's memory, 3 ms.
const CORRELATED_TICKS: f64 = 12.0;
/// Samples taken in a tick.
const SAMPLES_PER_TICK: usize = 32;
/// Smallest half gap of the grid, rad at the motor: 0.4 um of total gap on a screw of 20 mm.
const GRID_FROM_RAD: f64 = 6e-5;
/// Ratio of consecutive half gaps of the grid: within the reach of Gauss-Newton. A choice: nearer
/// to 1 costs passes in proportion, farther may start beyond that reach.
const GRID_RATIO: f64 = 1.3;
/// Passes of eight half gaps over the grid: up to 0.2 rad, near the largest half gap that is used.
const GRID_PASSES: u32 = 4;
/// Spacing of the fine scan around the best candidate, as a part of it. A choice: eight points
/// cover 3.5 % on either side.
const FINE_SHARE: f64 = 0.01;
/// Spacing of the fine scan around the best point of the grid: it covers the grid's ratio.
const FINE_SHARE_AFTER_GRID: f64 = 0.05;
/// Least measurement noise that is supposed, rad, in the first and in the second search: with less
/// of it the innovations are sharper and errors of the model count more. The second is the least
/// noise of a measured position; the first a choice, at which errors of the model hardly count.
const SUPPOSED_NOISE_RAD: [f64; 2] = [2e-6, 3e-7];
/// Attempts to find an onset: index into [`SUPPOSED_NOISE_RAD`], and the sum of squared innovations
/// over their variance that shows a contact. The last is for faint contacts. Tuned on the study's
/// matrix.
const ONSET_ATTEMPTS: [(usize, f64); 4] = [(0, 1e4), (1, 1e4), (1, 400.0), (1, 60.0)];
/// Candidates for the half gap: index of an onset's threshold, and the part of the way up to it. A
/// soft contact is detected late, so most are smaller.
const CANDIDATES: [(usize, f64); LANES] = [
    (0, 1.01),
    (0, 0.99),
    (0, 0.97),
    (0, 0.94),
    (0, 0.9),
    (1, 0.98),
    (2, 0.97),
    (3, 0.96),
];
/// Mean square of the innovations over their variance from which on a hypothesis is rejected. A
/// choice: the same as of a reading that counts.
const POOR_MISFIT: f64 = 10.0;
/// Standard deviation over value below which a half gap is clear enough not to search with less
/// noise. A choice: half of the per cent to which one contact gives the gap (record 58 of the
/// decisions).
const CLEAR_DOUBT: f64 = 5e-3;

/// Phase of the work.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
enum Phase {
    Onset(usize),
    Candidates,
    Grid(u32),
    Fine,
    Newton,
    Along,
    Check,
}

/// A reading under way, of a window that stays the same but for its end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Reading {
    /// Length of the part that is read, s, and the motor's largest speed, rad/s.
    extent: (f64, f64),
    /// Factor on the encoder's noise: on a slow motor a count lasts for several ticks, whose errors
    /// are then equal.
    steps: f64,
    prior: Prior,
    phase: Phase,
    hypotheses: Hypotheses,
    progress: Progress,
    sums: Sums,
    onset: Onset,
    /// Whether the grid has been scanned.
    searched: bool,
    /// Index of the supposed noise.
    level: usize,
    /// Result with more noise.
    noisier: Option<Accepted>,
    /// The final result; while another one is searched for beside it, the first.
    found: Option<Accepted>,
    /// Whether another one is searched for.
    again: bool,
    /// Best half gap so far and its cost; mean square of the innovations without a gap.
    best: (f64, f64),
    without: f64,
    newton: Newton,
}

/// The samples of a tick in vectors as wide as the processor has them, which is most of what this compensator
/// computes. The bits do not depend on the width.
struct Samples<'a> {
    reading: &'a mut Reading,
    window: &'a Window,
    known: &'a Known,
}

impl WithSimd for Samples<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        self.reading.samples(simd, self.window, self.known)
    }
}

impl Reading {
    /// `noise`: standard deviation of a measured position, rad.
    pub(super) fn new(window: &Window, prior: Prior, noise: f64) -> Reading {
        let count = noise * 12.0_f64.sqrt();
        let at = prior.mean();
        let hypotheses = uniform(&at, prior.load.damping);
        let progress = Progress::start(window, &hypotheses);
        let mut reading = Reading {
            extent: window.extent(),
            // n equal errors have n times the variance of n independent ones in their mean
            steps: (1.0
                + (count / window.pace().max(count / CORRELATED_TICKS)).min(CORRELATED_TICKS))
            .sqrt(),
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
            again: false,
            best: (0.0, f64::INFINITY),
            without: 0.0,
            newton: Newton::new(at),
        };
        reading.begin(window);
        reading
    }

    /// Starts a pass of the present phase.
    fn begin(&mut self, window: &Window) {
        let mut lanes = uniform(&self.newton.at, self.prior.load.damping);
        // lane 0 is the point; each further lane changes one unknown, for the derivatives
        match self.phase {
            Phase::Newton => {
                let step = self.differences();
                for (unknown, step) in step.into_iter().enumerate() {
                    lanes_of(&mut lanes, unknown)[unknown + 1] += step;
                }
            }
            Phase::Along => {
                for (lane, point) in self.newton.along().into_iter().enumerate() {
                    for (unknown, value) in point.into_iter().enumerate() {
                        lanes_of(&mut lanes, unknown)[lane] = value;
                    }
                }
            }
            _ => lanes.half_gap = Lanes(std::array::from_fn(|lane| self.half_gap_of(lane))),
        }
        self.hypotheses = lanes;
        self.progress = Progress::start(window, &self.hypotheses);
        self.sums = Sums::default();
    }

    /// Differences from which derivatives are taken.
    fn differences(&self) -> Vector {
        // what moves a contact depends on how long the load runs free
        let (time_s, speed) = self.extent;
        self.prior.step(self.newton.at[GAP], time_s, speed)
    }

    /// Half gap of a lane in the present phase, rad.
    fn half_gap_of(&self, lane: usize) -> f64 {
        match self.phase {
            Phase::Onset(_) if lane == 0 => 0.0,
            Phase::Onset(_) => ENDLESS_HALF_GAP_RAD,
            // a half gap that is known already is one of the candidates
            Phase::Candidates if lane + 1 == LANES && self.prior.half_gap > 0.0 => {
                self.prior.half_gap
            }
            Phase::Candidates => {
                let (which, part) = CANDIDATES[lane];
                part * self.onset.half_ways[which]
                    .or(self.onset.half_ways[0])
                    .unwrap_or(GRID_FROM_RAD)
            }
            Phase::Grid(pass) => {
                GRID_FROM_RAD
                    * math::exp(
                        (f64::from(pass) * LANES as f64 + lane as f64) * math::log(GRID_RATIO),
                    )
            }
            Phase::Check => AGAINST
                .get(lane)
                .map_or(ENDLESS_HALF_GAP_RAD, |part| part * self.newton.at[GAP]),
            Phase::Fine | Phase::Newton | Phase::Along => {
                let close = if self.searched {
                    FINE_SHARE_AFTER_GRID
                } else {
                    FINE_SHARE
                };
                self.best.0 * (1.0 + close * (lane as f64 - 0.5 * (LANES - 1) as f64))
            }
        }
    }

    /// Does the work of one tick. Returns the result once there is one.
    pub(super) fn work(&mut self, window: &mut Window, known: &Known) -> Option<Said> {
        // the supposed noise bounds that of the encoder from below
        let noise = (known.noise * self.steps).max(SUPPOSED_NOISE_RAD[self.level]);
        let known = Known { noise, ..*known };
        let ends = Arch::new().dispatch(Samples {
            reading: self,
            window,
            known: &known,
        });
        if ends {
            return self.pass_done(window, noise > SUPPOSED_NOISE_RAD[self.level]);
        }
        None
    }

    /// Takes the samples of one tick. Returns whether the window ends with them.
    #[inline(always)]
    fn samples<S: Simd>(&mut self, simd: S, window: &Window, known: &Known) -> bool {
        // a vector that nobody asks is left out
        match self.phase {
            Phase::Onset(_) => self.samples_of(simd, window, known, ONSET_LANES),
            Phase::Along => self.samples_of(simd, window, known, PARTS),
            _ => self.samples_of(simd, window, known, LANES),
        }
    }

    /// Those of the first `asked` lanes.
    #[inline(always)]
    fn samples_of<S: Simd>(
        &mut self,
        simd: S,
        window: &Window,
        known: &Known,
        asked: usize,
    ) -> bool {
        let mut stays = Stays::default();
        for _ in 0..SAMPLES_PER_TICK {
            match self
                .progress
                .step(simd, (known, &self.hypotheses), &mut stays, window, asked)
            {
                Some(Some(innovation)) => {
                    if let Phase::Onset(attempt) = self.phase {
                        let (side, known) = (f64::from(window.side), self.prior.half_gap);
                        self.onset.look(
                            &innovation,
                            &self.progress,
                            side,
                            known,
                            ONSET_ATTEMPTS[attempt].1,
                        );
                    }
                    self.sums.add(&innovation, self.phase == Phase::Newton);
                }
                Some(None) => {}
                None => return true,
            }
        }
        false
    }

    /// Samples that count: those behind the warm-up.
    fn count(window: &Window) -> f64 {
        window.samples.len().saturating_sub(WARM_UP).max(1) as f64
    }

    /// Ends a pass and chooses the next phase. `noisy`: the encoder is noisier than what is supposed,
    /// so that a second search with less noise would change nothing.
    fn pass_done(&mut self, window: &mut Window, noisy: bool) -> Option<Said> {
        match self.phase {
            // the window is cut already
            Phase::Onset(_) if self.again => self.phase = Phase::Candidates,
            Phase::Onset(attempt) => {
                // no contact in this attempt: less noise or a lower threshold
                let Some(end) = self.onset.end else {
                    return self.look_again(window, attempt + 1);
                };
                // cost without a gap is the reference for how much a reading explains; then cut
                // behind the contact
                self.without = self.sums.cost[0] / Self::count(window);
                window.samples.truncate(end);
                self.extent = window.extent();
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
            Phase::Newton | Phase::Along => {
                let passed_on = !noisy && self.level + 1 < SUPPOSED_NOISE_RAD.len();
                let (ends, next) = if self.phase == Phase::Newton {
                    let (count, step) = (Self::count(window), self.differences());
                    let ends = self
                        .newton
                        .take(&self.sums, count, &self.prior, &step, passed_on);
                    (ends, Phase::Along)
                } else {
                    let costs = &self.sums.cost;
                    let ends = self.newton.choose(costs, &self.prior, passed_on);
                    (ends, Phase::Newton)
                };
                if !ends {
                    self.phase = next;
                } else if self.again || self.settle(noisy) {
                    let Some(found) = self.found else {
                        return Some(Said::NOTHING);
                    };
                    if !self.again && self.prior.half_gap == 0.0 {
                        self.search_again(&found);
                    } else {
                        let found = self.least_surprising(found);
                        (self.newton.at, self.phase) = (found.at, Phase::Check);
                    }
                }
            }
            Phase::Check => {
                return self.found.map(|found| {
                    Said::checked(&found, &self.sums.cost, window.wavered, self.without)
                });
            }
        }
        self.begin(window);
        None
    }

    /// The next attempt to find an onset, if there is one.
    fn look_again(&mut self, window: &Window, attempt: usize) -> Option<Said> {
        let Some((level, _)) = ONSET_ATTEMPTS.get(attempt) else {
            return Some(Said::NOTHING);
        };
        (self.level, self.onset, self.phase) = (*level, Onset::default(), Phase::Onset(attempt));
        self.begin(window);
        None
    }

    /// Keeps the best half gap of the lanes, and goes to the next phase.
    fn keep_best(&mut self, next: Phase) {
        for (gap, cost) in self.hypotheses.half_gap.iter().zip(&self.sums.cost.0) {
            if *cost < self.best.1 {
                self.best = (*gap, *cost);
            }
        }
        self.phase = next;
    }

    /// Starts a search for another explanation than this one, with its inertia.
    fn search_again(&mut self, found: &Accepted) {
        let mut start = self.prior.mean();
        start[INERTIA] = found.at[INERTIA];
        (self.newton, self.again) = (Newton::new(start), true);
        (self.onset, self.best) = (Onset::default(), (0.0, f64::INFINITY));
        // the first attempts have the supposed noises in turn; the same noise keeps the costs comparable
        self.phase = Phase::Onset(self.level);
    }

    /// This result, or the other one where that is less surprising; it is the final one.
    fn least_surprising(&mut self, found: Accepted) -> Accepted {
        let other = self
            .newton
            .accepted
            .filter(|other| self.again && other.cost < found.cost);
        let least = other.unwrap_or(found);
        self.found = Some(least);
        least
    }

    /// After Gauss-Newton: whether the result is final; otherwise sets the next phase.
    fn settle(&mut self, noisy: bool) -> bool {
        let found = self
            .newton
            .accepted
            .filter(|found| found.misfit <= POOR_MISFIT);
        // less noise only made it poor: the result with more noise counts
        if found.is_none() && self.noisier.is_some() {
            self.found = self.noisier;
            return true;
        }
        // a local minimum from the candidates: the whole range on a grid
        if found.is_none() && !self.searched {
            (self.newton, self.searched, self.phase) =
                (Newton::new(self.prior.mean()), true, Phase::Grid(0));
            return false;
        }
        let clear = |found: Accepted| {
            found.variance < CLEAR_DOUBT * CLEAR_DOUBT * found.at[GAP] * found.at[GAP]
        };
        // the second search starts from the result of the first
        let last = noisy
            || self.level + 1 >= SUPPOSED_NOISE_RAD.len()
            || self.level > 0 && found.is_some_and(clear);
        if last || found.is_none() {
            self.found = self.newton.accepted;
            return true;
        }
        self.noisier = found;
        self.newton = Newton::new(found.map_or(self.newton.at, |found| found.at));
        (self.level, self.phase) = (self.level + 1, Phase::Newton);
        false
    }
}
