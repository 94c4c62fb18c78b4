//! What a pacer decides from cycle to cycle.

use super::Pacer;
use super::aim::{Aim, REACHED, aim};
use super::ramp::Ramp;
use super::retimed::{GOOD, Retimed};
use crate::Heeds;
use crate::optimal::LimitJudge;
use lostmotion_base::Coords;

/// Command cycles from one attempt to get nearer to the pace asked for to the next: at first, and
/// at last.
const SOON: u32 = 2;
const LATE: u32 = 64;
/// Differences of samples reach over so many cycles.
const AROUND: i64 = 3;

impl Pacer {
    /// The override that counts where the motion is.
    pub(super) fn here(&self) -> Heeds {
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
    pub(super) fn choose(&mut self) {
        if let Some(aim) = &mut self.next {
            if aim.wait > 0 {
                aim.wait -= 1;
            } else if let Some(aim) = self.next.take() {
                self.begin(aim.ramp);
            }
            return;
        }
        let (wanted, sure) = (self.wanted(), self.asked.sure());
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
        if self.retimed.is_none() && wanted.is_some_and(|wanted| (goal - wanted).abs() <= REACHED) {
            return;
        }
        if self.patience > 0 {
            self.patience -= 1;
            return;
        }
        self.delay = (2 * self.delay).clamp(SOON, LATE);
        self.patience = self.delay;
        if wanted.is_none() && self.ramp.is_none() && self.retime() {
            return;
        }
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
        self.retimed = found.map(Box::new).or_else(|| self.retimed.take());
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
        let around =
            (wait - AROUND..=wait + AROUND).map(|cycle| match usize::try_from(cycle + AROUND) {
                Ok(past) if cycle <= 0 => self.past.get(past).copied(),
                _ => position(cycle),
            });
        let around: Option<Vec<Coords>> = around.collect();
        around.is_some_and(|around| LimitJudge::new(&self.config).keep(&around, GOOD))
    }

    fn begin(&mut self, ramp: Ramp) {
        self.ramp = Some((ramp, 0.0));
        self.retimed = None;
    }
}
