//! A planned motion at another pace: feed hold, resume, feed override and stop at any moment, all
//! within the joints' limits.
//!
//! What was planned stays: the joints go the same way p(sigma), and only how fast its time sigma
//! goes by changes. So the tool never leaves the path of the plan, wherever it is told to stop,
//! inside a blend or a rounded corner too. [`ramp`] brings the pace from one value to another in
//! the shortest time that every joint's velocity, acceleration and jerk allow; [`ramp::aim`] finds a
//! place where that can be done, at the latest where the plan itself rests.

mod action;
mod course;
mod ramp;
mod retimed;

pub use action::Action;

use crate::optimal::LimitJudge;
use crate::{Heeds, PlanError, PlannerConfig, Sample, Shortfalls};
use action::Asked;
use course::{Course, PaceState};
use lostmotion_base::{Clock, Coords, Tick};
use ramp::Ramp;
use ramp::{Aim, PACE_SLACK, aim};
use retimed::{MOST_PACE, Retimed, SEAM_EXCESS};

/// Longest step of the plan, ns. A choice: half of the usual command cycle; shorter costs time.
const LONGEST_STEP_NS: u64 = 500_000;
/// Command cycles from the first attempt to get nearer to the pace asked for to the second. A
/// choice: 2 ms at the usual cycle; attempts cost time, waiting costs pace.
const FIRST_DELAY: u32 = 2;
/// Command cycles between two attempts, at most: each waits twice as long as the one before. A
/// choice: 64 ms at the usual cycle.
const LONGEST_DELAY: u32 = 64;
/// Command cycles over which third differences of the samples reach.
const DIFFERENCE_REACH: i64 = 3;

/// Makes samples of a plan at the pace that is asked for.
///
/// Fed with the samples of a planner whose clock is [`Pacer::plan_clock`], it outputs samples at
/// the command cycle. As long as nothing is asked for they are the plan's own to the bit.
#[derive(Clone, Debug)]
pub struct Pacer {
    config: PlannerConfig,
    course: Course,
    /// Steps of the plan in a command cycle.
    steps: f64,
    period_s: f64,
    state: PaceState,
    /// The change of pace under way, and for how long it has been.
    ramp: Option<(Ramp, f64)>,
    /// A change that begins some cycles later.
    next: Option<Aim>,
    /// A pace that changes all along, where one is asked for.
    retimed: Option<Box<Retimed>>,
    /// Overrides in force while nothing holds the motion.
    asked: Asked,
    held: bool,
    stopping: bool,
    /// Cycles until the next attempt, and between the last two.
    patience: u32,
    delay: u32,
    tick: Tick,
    /// The last positions that were output, the latest last.
    past: [Coords; 4],
    over: bool,
    /// Windows in which nothing better was found, of retimed motions that are past.
    kept: u64,
}

impl Pacer {
    /// The clock that the planner has to have for a pacer with these settings: fine enough that
    /// nothing is lost between two of its samples.
    pub fn plan_clock(config: &PlannerConfig) -> Clock {
        let period = config.clock.period_ns();
        let whole =
            (period.div_ceil(LONGEST_STEP_NS)..=period).find(|steps| period.is_multiple_of(*steps));
        whole
            .and_then(|steps| Clock::from_nanos(period / steps))
            .unwrap_or(config.clock)
    }

    /// A pacer at rest at the start of a plan; `config` as for the planner, with the clock of the
    /// samples that are wanted.
    ///
    /// # Errors
    /// A setting or limit that makes no sense.
    pub fn new(config: &PlannerConfig) -> Result<Pacer, PlanError> {
        config.check()?;
        let step_s = Pacer::plan_clock(config).period_s();
        Ok(Pacer {
            config: config.clone(),
            course: Course::new(&config.limits, step_s),
            steps: (config.clock.period_ns() / Pacer::plan_clock(config).period_ns()) as f64,
            period_s: config.clock.period_s(),
            state: PaceState {
                sigma: 0.0,
                w: 1.0,
                u: 0.0,
            },
            ramp: None,
            next: None,
            retimed: None,
            asked: Asked {
                feed: 1.0,
                rapid: 1.0,
            },
            held: false,
            stopping: false,
            patience: 0,
            delay: 0,
            tick: 0,
            past: [Coords::ZERO; 4],
            over: false,
            kept: 0,
        })
    }

    /// Does something from the next sample on.
    ///
    /// # Errors
    /// An override out of its range.
    pub fn act(&mut self, action: Action) -> Result<(), PlanError> {
        action.check()?;
        match action {
            Action::Hold => self.held = true,
            Action::Resume => self.held = false,
            Action::Stop => self.stopping = true,
            Action::Override(part) => self.asked.feed = part,
            Action::Rapid(part) => self.asked.rapid = part,
        }
        self.next = None;
        (self.patience, self.delay) = (0, 0);
        Ok(())
    }

    /// How many samples of the plan, and states of a motion made of them, are held.
    pub fn held_samples(&self) -> usize {
        self.course.held() + self.retimed.as_ref().map_or(0, |retimed| retimed.held())
    }

    /// How often the motion so far is not what it could be, besides what the plan falls short of.
    pub fn shortfalls(&self) -> Shortfalls {
        let now = self.retimed.as_ref().map_or(0, |retimed| retimed.kept());
        Shortfalls {
            kept_windows: self.kept + now,
            ..Shortfalls::default()
        }
    }

    /// Takes the next sample of the plan.
    pub fn push(&mut self, sample: Sample) {
        self.course.push(sample);
    }

    /// The plan has no more samples; false if that was known.
    pub fn finish(&mut self) -> bool {
        !std::mem::replace(&mut self.course.complete, true)
    }

    /// Whether the motion rests because it is held.
    pub fn is_held(&self) -> bool {
        (self.held || self.asked.rests(self.here())) && self.ramp.is_none() && self.state.w == 0.0
    }

    /// The next sample; none while more of the plan has to be known, or at the end.
    pub fn take(&mut self) -> Option<Sample> {
        let end = self.course.end()?;
        // A change of pace may need all of the plan as far as it is looked at.
        if self.over
            || (!self.course.complete
                && end < self.state.sigma + self.course.far() as f64 + MOST_PACE * self.steps)
        {
            return None;
        }
        let sample = Sample {
            tick: self.tick,
            ..self.course.sample(&self.state)?
        };
        self.tick += 1;
        let [_, past @ ..] = if sample.tick == 0 {
            [sample.position; 4]
        } else {
            self.past
        };
        self.past = [past[0], past[1], past[2], sample.position];
        // A stop ends wherever the motion rests, in a dwell of the plan too.
        let rests = self.state.w == 0.0 || self.course.rests(self.state.sigma);
        if self.stopping && self.ramp.is_none() && rests
            || self.course.complete && self.state.sigma >= end
        {
            self.over = true;
        } else {
            self.choose();
            self.advance();
            self.course.forget(self.state.sigma);
        }
        Some(sample)
    }

    /// The state after `cycles` command cycles if nothing changes.
    fn after(&self, cycles: f64) -> Option<PaceState> {
        if let Some(retimed) = &self.retimed {
            return (cycles as usize)
                .checked_sub(1)
                .map_or(Some(self.state), |cycle| retimed.ready(cycle));
        }
        let (mut state, mut left_s) = (self.state, cycles * self.period_s);
        if let Some((ramp, gone_s)) = &self.ramp {
            let (at, over) = ramp.at(gone_s + left_s, self.course.step_s);
            let Some(over_s) = over else { return Some(at) };
            (state, left_s) = (at, over_s);
        }
        // At the pace 1 the samples are those of the plan, to the bit.
        if state.w.to_bits() == 1.0_f64.to_bits() && self.ramp.is_none() {
            state.sigma += cycles * self.steps;
        } else {
            state.sigma = self.steady(state.sigma, state.w, left_s);
        }
        let known = self.course.complete || self.course.end().is_some_and(|end| state.sigma < end);
        known.then_some(state)
    }

    /// Goes on at a steady pace; where the plan stands still for a time (a dwell), that time is not
    /// stretched.
    fn steady(&self, mut sigma: f64, pace: f64, mut left_s: f64) -> f64 {
        while left_s > 0.0 && pace > 0.0 {
            let rate = if self.course.rests(sigma) { 1.0 } else { pace } / self.course.step_s;
            let lasts_s = ((sigma + 1.0).floor() - sigma) / rate;
            if lasts_s >= left_s || self.course.end().is_none_or(|end| sigma >= end) {
                return sigma + left_s * rate;
            }
            (sigma, left_s) = ((sigma + 1.0).floor(), left_s - lasts_s);
        }
        sigma
    }

    fn advance(&mut self) {
        if let Some(retimed) = &mut self.retimed {
            let end = || PaceState {
                sigma: self.course.end().unwrap_or_default(),
                w: 1.0,
                u: 0.0,
            };
            self.state = retimed.next(&self.course).unwrap_or_else(end);
            return;
        }
        let Some(state) = self.after(1.0) else { return };
        self.state = state;
        if let Some((ramp, gone_s)) = &mut self.ramp {
            *gone_s += self.period_s;
            if ramp.lasts_s() <= *gone_s {
                self.ramp = None;
            }
        }
    }
}

/// What a pacer decides from cycle to cycle.
impl Pacer {
    /// The override that counts where the motion is.
    fn here(&self) -> Heeds {
        self.course
            .kinds(self.state.sigma)
            .next()
            .unwrap_or_default()
    }

    /// The steady pace asked for; `None` where it changes on the way, or is more than the plan
    /// leaves.
    fn wanted(&self) -> Option<f64> {
        if self.held || self.stopping || self.asked.rests(self.here()) {
            return Some(0.0);
        }
        let mut caps = self
            .course
            .kinds(self.state.sigma)
            .map(|kind| self.asked.of(kind));
        let first = caps.next().unwrap_or(1.0);
        (first <= 1.0 && caps.all(|cap| cap.to_bits() == first.to_bits())).then_some(first)
    }

    /// Decides on a change of pace.
    fn choose(&mut self) {
        // A change has been found that begins later.
        if let Some(aim) = &mut self.next {
            if aim.wait > 0 {
                aim.wait -= 1;
            } else if let Some(aim) = self.next.take() {
                self.begin(aim.ramp);
            }
            return;
        }
        let (wanted, sure) = (self.wanted(), self.asked.sure());
        // The retimed motion follows what is asked by itself.
        if wanted.is_none()
            && self
                .retimed
                .as_ref()
                .is_some_and(|retimed| retimed.asked == self.asked)
        {
            return;
        }
        let goal = self
            .ramp
            .as_ref()
            .map_or(self.state.w, |(ramp, _)| ramp.end.w);
        // There, or on the way there.
        if self.retimed.is_none()
            && wanted.is_some_and(|wanted| (goal - wanted).abs() <= PACE_SLACK)
        {
            return;
        }
        // Attempts that fail cost time, so they get rarer.
        if self.patience > 0 {
            self.patience -= 1;
            return;
        }
        self.delay = (2 * self.delay).clamp(FIRST_DELAY, LONGEST_DELAY);
        self.patience = self.delay;
        if wanted.is_none() && self.ramp.is_none() && self.retime() {
            return;
        }
        // Failing that, a steady pace within all that is asked, from which the next attempt sets
        // out.
        self.change(wanted.unwrap_or(sure));
    }

    /// Finds a way on at a pace that changes all along.
    fn retime(&mut self) -> bool {
        let [a, b, c, _] = self.past;
        let clock = Pacer::plan_clock(&self.config);
        let found = Retimed::start(
            &self.config,
            clock,
            &self.course,
            &self.state,
            [a, b, c],
            self.asked,
        );
        let is_found = found.is_some();
        if is_found {
            self.kept = self.shortfalls().kept_windows;
            self.retimed = found.map(Box::new);
        }
        is_found
    }

    /// Finds a way to a steady pace.
    fn change(&mut self, pace: f64) {
        let after = |cycles: u32| self.after(f64::from(cycles));
        if let Some(found) = aim(&self.course, pace, self.period_s, &after)
            .filter(|found| self.retimed.is_none() || self.joins(found))
        {
            if found.wait == 0 {
                self.begin(found.ramp);
            } else {
                self.next = Some(Aim {
                    wait: found.wait - 1,
                    ..found
                });
            }
        }
    }

    /// Whether differences of the samples around the change keep the limits: a retimed motion keeps
    /// them from one sample to the next, not all along.
    fn joins(&self, found: &Aim) -> bool {
        let wait = i64::from(found.wait);
        let position = |cycle: i64| {
            let state = match cycle - wait {
                later @ 1.. => {
                    found
                        .ramp
                        .at(later as f64 * self.period_s, self.course.step_s)
                        .0
                }
                _ => self.after(cycle as f64)?,
            };
            self.course.sample(&state).map(|sample| sample.position)
        };
        // Differences over the seam reach back to samples that are out already.
        let around =
            (wait - DIFFERENCE_REACH..=wait + DIFFERENCE_REACH).map(|cycle| match usize::try_from(
                cycle + DIFFERENCE_REACH,
            ) {
                Ok(past) if cycle <= 0 => self.past.get(past).copied(),
                _ => position(cycle),
            });
        let around: Option<Vec<Coords>> = around.collect();
        around.is_some_and(|around| LimitJudge::new(&self.config).keep(&around, SEAM_EXCESS))
    }

    fn begin(&mut self, ramp: Ramp) {
        self.ramp = Some((ramp, 0.0));
        self.kept = self.shortfalls().kept_windows;
        self.retimed = None;
    }
}
