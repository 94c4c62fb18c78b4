//! The planner: items in, samples out.
//!
//! The work has two halves: `Intake` makes the path that is travelled of the moves, and `Timing` plans the
//! motion along it. What the one gives the other takes, so that both can be at work at the same time.

use crate::chord::Chord;
use crate::intake::Intake;
use crate::machine::Machine;
use crate::piece::PathStep;
use crate::timing::Timing;
use crate::{PlanError, PlanItem, PlannerConfig, Quality, Sample, Shortfalls};
use lostmotion_base::Coords;
use lostmotion_kinematics::Kinematics;
use std::sync::Arc;

/// Plans a program as it comes and outputs samples as they become final.
///
/// Push items, take samples in between, and finish: memory stays within the window of the
/// configuration as long as the samples are taken. The samples do not depend on how pushing and
/// taking interleave.
#[derive(Clone, Debug)]
pub struct Planner {
    intake: Intake,
    timing: Timing,
    /// Steps of the path that the one half gives while the other plans those that wait.
    taken: Vec<PathStep>,
    waiting: Vec<PathStep>,
}

/// The half of a planner that takes items.
#[derive(Debug)]
pub struct ItemsIn<'a> {
    intake: &'a mut Intake,
    steps: &'a mut Vec<PathStep>,
}

/// The half of a planner that plans what the other one took before.
#[derive(Debug)]
pub struct PathIn<'a> {
    timing: &'a mut Timing,
    steps: &'a mut Vec<PathStep>,
    is_last: bool,
}

impl ItemsIn<'_> {
    /// Takes the next item.
    ///
    /// # Errors
    /// As [`Planner::push`].
    pub fn push(&mut self, item: PlanItem) -> Result<(), PlanError> {
        self.intake.push(item, self.steps)
    }

    /// Ends the program.
    pub fn finish(&mut self) {
        self.intake.finish(self.steps);
    }

    /// Pieces of path and stops that wait for the other half.
    pub fn waiting(&self) -> usize {
        self.steps.len()
    }
}

impl PathIn<'_> {
    /// Plans what waits for it.
    ///
    /// # Errors
    /// A pose on a blend that the machine cannot take.
    pub fn plan(self) -> Result<(), PlanError> {
        self.timing.follow(self.steps.drain(..))?;
        if self.is_last {
            self.timing.finish();
        }
        Ok(())
    }
}

impl Planner {
    /// A planner at rest at `start`: program coordinates without a tool offset, mm and rad.
    ///
    /// # Errors
    /// A setting or limit that makes no sense, a start that the machine cannot take.
    pub fn new(
        config: PlannerConfig,
        kinematics: Arc<dyn Kinematics>,
        start: Coords,
    ) -> Result<Planner, PlanError> {
        config.check()?;
        let joints = kinematics
            .inverse(&start, &[0.0; 3])
            .map_err(|source| PlanError::Start(Box::new(source)))?;
        let machine = Machine::new(&config.limits);
        let timing = Timing::new(
            &config,
            Arc::clone(&kinematics),
            start,
            joints,
            machine.clone(),
        );
        let softens = config.quality != Quality::Optimal;
        Ok(Planner {
            intake: Intake::new(config, kinematics, start, machine, softens),
            timing,
            taken: Vec::new(),
            waiting: Vec::new(),
        })
    }

    /// The same for drives that join commands by straight lines of the joints: the tool stays
    /// within the chord's limit of its way.
    #[must_use]
    pub fn with_chord(mut self, chord: Chord) -> Planner {
        self.intake.machine_mut().chord = Some(chord.clone());
        self.timing.keep(chord);
        self
    }

    /// The same at work on so many threads of the pool in force ([`pool`](lostmotion_base::threads::pool)): the
    /// samples do not depend on their number.
    #[must_use]
    pub fn on_threads(mut self, threads: usize) -> Planner {
        self.intake.set_threads(threads);
        self
    }

    /// Takes the next item.
    ///
    /// # Errors
    /// What is wrong with it; the planner is then as before, and can go on with another item or be
    /// finished.
    pub fn push(&mut self, item: PlanItem) -> Result<(), PlanError> {
        self.intake.push(item, &mut self.taken)?;
        self.catch_up()
    }

    /// Ends the program: everything pushed can be taken after it.
    ///
    /// # Errors
    /// A pose on a blend that the machine cannot take.
    pub fn finish(&mut self) -> Result<(), PlanError> {
        self.intake.finish(&mut self.taken);
        self.catch_up()
    }

    /// Both halves, to be at work on two threads: the one takes further items while the other plans what the
    /// one took since the last call. The samples are the same as with [`Planner::push`].
    pub fn halves(&mut self) -> (ItemsIn<'_>, PathIn<'_>) {
        if self.waiting.is_empty() {
            std::mem::swap(&mut self.taken, &mut self.waiting);
        }
        let is_last = self.intake.is_finished() && self.taken.is_empty();
        let items = ItemsIn {
            intake: &mut self.intake,
            steps: &mut self.taken,
        };
        let path = PathIn {
            timing: &mut self.timing,
            steps: &mut self.waiting,
            is_last,
        };
        (items, path)
    }

    /// Whether something was taken by the one half that the other has not planned yet.
    pub fn is_behind(&self) -> bool {
        let waits = !self.taken.is_empty() || !self.waiting.is_empty();
        waits || self.intake.is_finished() && !self.timing.is_finished()
    }

    fn catch_up(&mut self) -> Result<(), PlanError> {
        while self.is_behind() {
            self.halves().1.plan()?;
        }
        Ok(())
    }

    /// Takes up to `max_samples` samples that are final; returns how many.
    pub fn take(&mut self, max_samples: usize, out: &mut Vec<Sample>) -> usize {
        self.timing.take(max_samples, out)
    }

    /// How often the plan so far is not what it could be.
    pub fn shortfalls(&self) -> Shortfalls {
        let [window_stops, kept_windows] = self.timing.stops_and_kept();
        Shortfalls {
            window_stops,
            curve_stops: self.intake.curve_stops(),
            kept_windows,
        }
    }

    /// How many pieces of path are held, waiting to be planned or sampled.
    pub fn held_pieces(&self) -> usize {
        self.taken.len() + self.waiting.len() + self.timing.held_pieces()
    }

    /// How many samples are held to be retimed, or wait to be taken after that: none but for quality
    /// `optimal`.
    pub fn held_samples(&self) -> usize {
        self.timing.held_samples()
    }
}
