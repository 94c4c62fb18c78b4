//! A planned motion at another pace: feed hold, resume, feed override and stop at any moment, all within the joints' limits.
//!
//! What was planned stays: the joints go the same way p(sigma), and only how fast its time sigma goes by changes. So the tool never leaves the
//! path of the plan, wherever it is told to stop, inside a blend or a rounded corner too. [`ramp`] brings the pace from one value to another in
//! the shortest time that every joint's velocity, acceleration and jerk allow; [`aim`] finds a place where that can be done, at the latest where the plan
//! itself rests.

mod aim;
mod course;
mod ramp;

use crate::{PlanError, PlannerConfig, Sample};
use aim::{Aim, REACHED, aim};
use course::Course;
use lostmotion_base::{Clock, Tick};
use ramp::{Ramp, State};

/// Longest step of the plan that is gone along, ns.
const FINEST_NS: u64 = 500_000;
/// The plan is known for so many times longer than the slowest joint takes to stop.
const AHEAD: f64 = 4.0;
/// Command cycles from one attempt to get nearer to the pace asked for to the next: at first, and at last.
const SOON: u32 = 2;
const LATE: u32 = 64;

/// What an operator does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    /// Comes to rest on the path as fast as the limits allow, and waits.
    Hold,
    /// Goes on.
    Resume,
    /// Comes to rest in the same way, for good.
    Stop,
    /// Pace of the motion as a part of the planned one, above 0 and up to 1.
    Override(f64),
}

impl Action {
    /// Checks it.
    ///
    /// # Errors
    /// An override that is not above 0 and at most 1.
    pub fn check(self) -> Result<(), PlanError> {
        match self {
            Action::Override(value) if !(value > 0.0 && value <= 1.0) => {
                Err(PlanError::Setting { what: "feed override", value, condition: "above 0 and at most 1" })
            }
            _ => Ok(()),
        }
    }
}

/// Makes samples of a plan at the pace that is asked for.
///
/// Fed with the samples of a planner whose clock is [`Pacer::plan_clock`], it gives out samples at the command cycle. As long as nothing is
/// asked for they are the plan's own to the bit.
#[derive(Clone, Debug)]
pub struct Pacer {
    course: Course,
    /// Steps of the plan in a command cycle.
    steps: f64,
    period_s: f64,
    state: State,
    /// The change of pace under way, and for how long it has been.
    ramp: Option<(Ramp, f64)>,
    /// A change that begins after so many cycles.
    next: Option<Aim>,
    /// Pace asked for while nothing holds the motion.
    pace: f64,
    held: bool,
    stopping: bool,
    /// Cycles until the next attempt, and between the last two.
    patience: u32,
    delay: u32,
    tick: Tick,
    over: bool,
}

impl Pacer {
    /// The clock that the planner has to have for a pacer with these settings: fine enough that nothing is lost between two of its samples.
    pub fn plan_clock(config: &PlannerConfig) -> Clock {
        let period = config.clock.period_ns();
        let whole = (period.div_ceil(FINEST_NS)..=period).find(|steps| period.is_multiple_of(*steps));
        whole.and_then(|steps| Clock::from_nanos(period / steps)).unwrap_or(config.clock)
    }

    /// A pacer at rest at the start of a plan; `config` as for the planner, with the clock of the samples that are wanted.
    ///
    /// # Errors
    /// A setting or limit that makes no sense.
    pub fn new(config: &PlannerConfig) -> Result<Pacer, PlanError> {
        config.check()?;
        let step_s = Pacer::plan_clock(config).period_s();
        Ok(Pacer {
            course: Course::new(&config.limits, step_s),
            steps: (config.clock.period_ns() / Pacer::plan_clock(config).period_ns()) as f64,
            period_s: config.clock.period_s(),
            state: State { sigma: 0.0, w: 1.0, u: 0.0 },
            ramp: None,
            next: None,
            pace: 1.0,
            held: false,
            stopping: false,
            patience: 0,
            delay: 0,
            tick: 0,
            over: false,
        })
    }

    /// Does something from the next sample on.
    ///
    /// # Errors
    /// An override that is not above 0 and at most 1.
    pub fn act(&mut self, action: Action) -> Result<(), PlanError> {
        action.check()?;
        match action {
            Action::Hold => self.held = true,
            Action::Resume => self.held = false,
            Action::Stop => self.stopping = true,
            Action::Override(part) => self.pace = part,
        }
        self.next = None;
        (self.patience, self.delay) = (0, 0);
        Ok(())
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
        self.held && self.ramp.is_none() && self.state.w == 0.0
    }

    /// The next sample; none while more of the plan has to be known, or at the end.
    pub fn take(&mut self) -> Option<Sample> {
        let end = self.course.end()?;
        let far = AHEAD * self.course.stop_s() / self.course.step_s;
        if self.over || (!self.course.complete && end < self.state.sigma + far + self.steps) {
            return None;
        }
        let sample = Sample { tick: self.tick, ..self.course.sample(&self.state)? };
        self.tick += 1;
        let rests = self.state.w == 0.0 || self.course.rests(self.state.sigma);
        if self.stopping && self.ramp.is_none() && rests || self.course.complete && self.state.sigma >= end {
            self.over = true;
        } else {
            self.choose();
            self.advance();
            self.course.forget(self.state.sigma);
        }
        Some(sample)
    }

    /// The pace asked for.
    fn wanted(&self) -> f64 {
        if self.held || self.stopping { 0.0 } else { self.pace }
    }

    /// Decides on a change of pace.
    fn choose(&mut self) {
        if let Some(aim) = &mut self.next {
            if aim.wait > 0 {
                aim.wait -= 1;
                return;
            }
            self.ramp = self.next.take().map(|aim| (aim.ramp, 0.0));
            return;
        }
        let goal = self.ramp.as_ref().map_or(self.state.w, |(ramp, _)| ramp.end.w);
        if (goal - self.wanted()).abs() <= REACHED {
            return;
        }
        if self.patience > 0 {
            self.patience -= 1;
            return;
        }
        self.delay = (2 * self.delay).clamp(SOON, LATE);
        self.patience = self.delay;
        let after = |cycles: u32| self.after(f64::from(cycles));
        if let Some(found) = aim(&self.course, self.wanted(), self.period_s, &after) {
            if found.wait == 0 {
                self.ramp = Some((found.ramp, 0.0));
            } else {
                self.next = Some(Aim { wait: found.wait - 1, ..found });
            }
        }
    }

    /// The state after so many cycles as things are.
    fn after(&self, cycles: f64) -> Option<State> {
        let (mut state, mut left_s) = (self.state, cycles * self.period_s);
        if let Some((ramp, gone_s)) = &self.ramp {
            let (at, over) = ramp.at(gone_s + left_s, self.course.step_s);
            let Some(over_s) = over else { return Some(at) };
            (state, left_s) = (at, over_s);
        }
        if state.w.to_bits() == 1.0_f64.to_bits() && self.ramp.is_none() {
            state.sigma += cycles * self.steps;
        } else {
            state.sigma = self.steady(state.sigma, state.w, left_s);
        }
        let known = self.course.complete || self.course.end().is_some_and(|end| state.sigma < end);
        known.then_some(state)
    }

    /// Goes on at a steady pace; where the plan stands still for a time (a dwell), that time is not stretched.
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
