//! Samples of the plan at the pace that an operator asks for.

use crate::error::SimError;
use crate::options::Intervention;
use crate::results::LateInterventions;
use lostmotion_base::Tick;
use lostmotion_plan::{Action, Pacer, PlannerConfig, Sample, Shortfalls};
use std::collections::VecDeque;

/// Samples of the plan that are read at a time. A choice: few enough to keep memory small.
pub(super) const PLAN_CHUNK_SAMPLES: usize = 256;

/// A pacer, and what is still to be done to it.
#[derive(Debug)]
pub(super) struct Paced {
    pacer: Pacer,
    /// By the first sample that they hold for.
    actions: VecDeque<(Tick, Action)>,
    given: Tick,
    stopped: bool,
    plan: Vec<Sample>,
}

impl Paced {
    /// `None` for a program without interventions.
    pub(super) fn new(
        config: &PlannerConfig,
        interventions: &[Intervention],
    ) -> Result<Option<Paced>, SimError> {
        if interventions.is_empty() {
            return Ok(None);
        }
        let mut last_s = 0.0;
        let mut actions = VecDeque::new();
        for Intervention { at_s, action } in interventions {
            // Actions are taken off the front: their times must not go back.
            if !(at_s.is_finite() && *at_s >= last_s) {
                return Err(SimError::Option {
                    what: "at_s",
                    value: *at_s,
                    condition: "0 or above, and not before the one before it",
                });
            }
            action.check()?;
            last_s = *at_s;
            // To the nearest command cycle: the pacer acts between samples.
            actions.push_back(((at_s / config.clock.period_s()).round() as Tick, *action));
        }
        Ok(Some(Paced {
            pacer: Pacer::new(config)?,
            actions,
            given: 0,
            stopped: false,
            plan: Vec::new(),
        }))
    }

    /// Adds samples, up to `most`, as far as the plan is known; `plan` adds more of it, or nothing at
    /// its end.
    pub(super) fn take(
        &mut self,
        most: usize,
        samples: &mut Vec<Sample>,
        mut plan: impl FnMut(&mut Vec<Sample>) -> Result<(), SimError>,
    ) -> Result<(), SimError> {
        while samples.len() < most && !self.stopped {
            while self
                .actions
                .front()
                .is_some_and(|(tick, _)| *tick <= self.given)
            {
                if let Some((_, action)) = self.actions.pop_front() {
                    self.pacer.act(action)?;
                }
            }
            // Held, and no later intervention resumes it.
            self.stopped = self.pacer.is_held() && self.actions.is_empty();
            // The pacer gives a sample as soon as it knows enough of the plan to brake in time.
            if let Some(sample) = self.pacer.take() {
                samples.push(sample);
                self.given += 1;
                continue;
            }
            // It needs more of the plan, which may end here.
            self.plan.clear();
            plan(&mut self.plan)?;
            self.plan.iter().for_each(|sample| self.pacer.push(*sample));
            if self.plan.is_empty() && !self.pacer.finish() {
                self.stopped = true;
            }
        }
        Ok(())
    }

    /// How often the motion is not what it could be.
    pub(super) fn shortfalls(&self) -> Shortfalls {
        self.pacer.shortfalls()
    }

    /// Those actions whose time has not come.
    pub(super) fn left(&self, period_s: f64) -> Option<LateInterventions> {
        let (first, _) = self.actions.front()?;
        Some(LateInterventions {
            count: self.actions.len() as u64,
            first_s: *first as f64 * period_s,
            // n samples bound n - 1 intervals.
            end_s: self.given.saturating_sub(1) as f64 * period_s,
        })
    }
}
