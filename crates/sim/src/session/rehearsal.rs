//! With a memory the control rehearses the start of a program before it begins: the machine as its
//! drives have learned it, without a correction and with it, on the same plan.
//!
//! Nothing but what drives are set up with and have learned enters: loads and gaps are those of their
//! memory. So what the gap of one axis hides of the overshoot of another is known before a corner is
//! cut, and the correction is used as far as the contour is no worse.
//!
//! ```text
//! share    the largest of 1, 0.875, 0.75, 0.625, 0.5, 0.25 with    rms with <= 1.015 rms without    and    peak with <= 1.015 peak without + 0.375 um
//! over     the way on which each axis comes back twice, 10 s at least, 30 s at most
//! ```

use super::bank::Variant;
use super::contours::{Contours, Returns};
use super::guard::Rehearsed;
use super::outputs::Kept;
use super::stepper::Stepper;
use crate::error::SimError;
use crate::machine::Memory;
use crate::method::Choice;
use crate::options::SimulateOptions;
use crate::setup::Setup;
use lostmotion_methods::MethodId;
use std::sync::Arc;

/// The parts of a correction that are tried. A choice: eighths, an eighth of a gap
/// leaves an eighth of the error.
const SHARES: [f64; 6] = [1.0, 0.875, 0.75, 0.625, 0.5, 0.25];
/// RMS and peak with a correction over those without up to which it is used, and what may be on top of
/// the peak, mm. A choice: three quarters of what counts as worse in the study.
const NO_WORSE: (f64, f64) = (1.015, 3.75e-4);
/// How often each axis has to come back, and how long is rehearsed at least and at most, s. A choice:
/// as often as the guard wants; peaks of loads that bounce need some rounds; half a minute is one of most
/// parts.
const REHEARSED: (u32, [f64; 2]) = (2, [10.0, 30.0]);
/// Commands that go through the stages at a time. A choice: rounds of a part take longer.
const CHUNK_SAMPLES: usize = 500;

/// Who rehearses the variants of a run.
pub(crate) struct Rehearser<'a> {
    setup: &'a Setup<'a>,
    variants: &'a [Variant<'a>],
    threads: usize,
}

impl<'a> Rehearser<'a> {
    pub(crate) fn new(
        setup: &'a Setup<'a>,
        variants: &'a [Variant<'a>],
        threads: usize,
    ) -> Rehearser<'a> {
        Rehearser {
            setup,
            variants,
            threads,
        }
    }

    /// Rehearses a variant whose drives know this; `None` where nothing is to be said: no axis has
    /// a gap, the load of one may float, or the program cannot be run.
    pub(crate) fn rehearse(&self, variant: usize, memory: &Memory) -> Option<Rehearsed> {
        let choice = self.variants.get(variant)?.choice()?;
        // A load that may float holds the others back until more is known: nothing can be rehearsed.
        let mut gaps = memory.axis.iter().filter(|(name, axis)| {
            let config = self.setup.machine.drive(name);
            config.is_some_and(|config| axis.has_gap(config))
        });
        let first = gaps.next()?;
        if first.1.learned.floats || gaps.any(|(_, axis)| axis.learned.floats) {
            return None;
        }
        let options = SimulateOptions {
            learned: Some(Arc::new(memory.clone())),
            chunk_samples: CHUNK_SAMPLES,
            // What an operator will do is not known.
            interventions: Vec::new(),
            ..self.setup.options.clone()
        };
        let setup = Setup {
            options: &options,
            kinematics: Arc::clone(&self.setup.kinematics),
            ..*self.setup
        };
        // Mostly the whole correction is no worse: the others are tried where it is.
        let (whole, parts) = SHARES.split_at(1);
        let mut found = self.measure(&setup, choice, whole).ok()?;
        if found.share == 0.0 {
            found = self.measure(&setup, choice, parts).ok()?;
        }
        Some(found)
    }

    /// The largest of these shares with which the contour is no worse.
    fn measure(
        &self,
        setup: &Setup<'_>,
        choice: &Choice,
        shares: &[f64],
    ) -> Result<Rehearsed, SimError> {
        let none = Choice::Registered(MethodId::NONE);
        let mut variants = vec![Variant::rehearsed(&none, 0.0)];
        variants.extend(
            shares
                .iter()
                .map(|share| Variant::rehearsed(choice, *share)),
        );
        let mut stepper = Stepper::new(setup, &variants, self.threads, Kept::default(), None)?;
        let axes = stepper.chunk.outputs.axes().to_vec();
        let clock = setup.machine.cycles().command();
        let mut returns = Returns::new(axes.len());
        let mut contours = vec![Contours::default(); shares.len()];
        let (times, [least_s, most_s]) = REHEARSED;
        let mut time_s = 0.0;
        loop {
            let (_, more) = stepper.step(|_, _| ());
            let more = more?;
            let chunk = &stepper.chunk;
            for frame in chunk.frames.iter().filter(|frame| frame.is_command_tick) {
                let returned = returns.take(&frame.sample, &axes);
                returns.count(returned);
                time_s += clock.period_s();
                let joints = |variant| chunk.outputs.load(variant, frame.servo_sample);
                let without = joints(0);
                for (index, contours) in contours.iter_mut().enumerate() {
                    let pair = [without, joints(index + 1)];
                    contours.measure(
                        &frame.sample,
                        &pair,
                        clock,
                        (&stepper.tracker, &chunk.modes),
                    );
                }
            }
            let measured_s = contours.iter().map(|contours| contours.time_s);
            let seen =
                measured_s.fold(f64::INFINITY, f64::min) >= least_s && returns.came_back(times);
            if seen || time_s >= most_s || !more {
                break;
            }
            let place = stepper.chunk.place();
            stepper.release(place);
        }
        let mean = |contours: &Contours, which: usize| {
            contours.squares[which] / (contours.count as f64).max(1.0)
        };
        let no_worse = |contours: &Contours| {
            let [highest, high] = contours.peaks;
            mean(contours, 1) <= NO_WORSE.0 * NO_WORSE.0 * mean(contours, 0)
                && high <= NO_WORSE.0 * highest + NO_WORSE.1
        };
        let found = shares
            .iter()
            .zip(&contours)
            .find(|(_, contours)| no_worse(contours));
        let first = contours.first();
        Ok(Rehearsed {
            share: found.map_or(0.0, |(share, _)| *share),
            without: first.map_or([0.0; 2], |first| [mean(first, 0), first.peaks[0]]),
        })
    }
}
