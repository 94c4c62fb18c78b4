//! With a memory the control rehearses a program before it begins, to its end or for ten minutes: the machine as its
//! drives have learned it, without a correction and with it, on the same plan. Without one it does so once
//! the drives have learned enough to correct, from the start up to where the program is and a minute on.
//!
//! Nothing but what drives are set up with and have learned enters: loads and gaps are those of their
//! memory. So what the gap of one axis hides of the overshoot of another is known before a corner is
//! cut, and the correction is used as far as the contour is no worse.
//!
//! ```text
//! whole    1 but in the stretches that are left out (`skips`), of up to ten minutes, where 1 is worse; if that is of no use
//! share    the largest of 1, 0.875, 0.75, 0.625, 0.5, 0.25 with    rms with <= 1.015 rms without    and    peak with <= 1.015 peak without + 0.375 um    (1.011 and 0.275 um while drives learn)
//! over     with a memory the whole program, 600 s at most; else the way on which each axis comes back twice
//! ```

use super::contours::{Contours, Returns};
use super::guard::Rehearsed;
use super::outputs::{AxisInfo, Kept};
use super::skips::{RehearsedCommand, Skips};
use super::stepper::{Chunk, Stepper};
use super::variant::Variant;
use crate::error::SimError;
use crate::machine::Memory;
use crate::method::Choice;
use crate::options::SimulateOptions;
use crate::setup::Setup;
use lostmotion_base::Clock;
use lostmotion_contour::ContourTracker;
use lostmotion_methods::MethodId;
use std::sync::Arc;

/// The parts of a correction that are tried. A choice: eighths, an eighth of a gap
/// leaves an eighth of the error.
const SHARES: [f64; 6] = [1.0, 0.875, 0.75, 0.625, 0.5, 0.25];
/// How much larger RMS and peak may be with a correction: as a part, and what may be on top of the peak, mm.
#[derive(Clone, Copy, Debug)]
struct Leeway {
    /// Up to which the correction is used.
    used: (f64, f64),
    /// At which a correction that leaves stretches out is aimed: less, since one that ends and begins adds
    /// something.
    aimed: (f64, f64),
}

/// With a memory. A choice: three quarters of what counts as worse in the study.
const REMEMBERING: Leeway = Leeway {
    used: (1.015, 3.75e-4),
    aimed: (1.01, 2.5e-4),
};
/// While drives learn. Tuned on looked cells: with the leeway above 20261124-15 is worse, with a fifth of it
/// 818283-23, which gets better, is left alone.
const STILL_LEARNING: Leeway = Leeway {
    used: (1.011, 2.75e-4),
    aimed: (1.005, 1.25e-4),
};
/// While drives learn, how often each axis has to come back, and how long is rehearsed at most, s. A choice:
/// as often as the guard wants; slow programs come back late.
const REHEARSED: (u32, f64) = (2, 120.0);
/// How far beyond where the program is it is rehearsed while drives learn, s. A choice: a lap of most parts; 10 s
/// did not reach the corner in which 20261124-15 is worse.
const AHEAD_S: f64 = 60.0;
/// How often and how long with a memory, and of a correction that leaves stretches out: the whole program, up to ten
/// minutes of it, since the corner that is worse may come once, at its end (275903-22). Where stretches are left out
/// nothing is corrected behind them. A choice: a minute and a half of computing at most.
const WHOLE: (u32, [f64; 2]) = (u32::MAX, [600.0, 600.0]);
/// Rehearsals of such a correction. A choice: stretches double each time.
const ROUNDS: usize = 4;
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

    /// Rehearses a variant whose drives know this, while they learn with the time of the motion so far;
    /// `None` where nothing is to be said: no axis has a gap, the load of one may float, or the program
    /// cannot be run.
    pub(crate) fn rehearse(
        &self,
        variant: usize,
        memory: &Memory,
        so_far_s: Option<f64>,
    ) -> Option<Rehearsed> {
        let of = self.variants.get(variant)?;
        of.choice()?;
        // A load that may float holds the others back until more is known: nothing can be rehearsed.
        let mut gaps = memory.axis.iter().filter(|(name, axis)| {
            let config = self.setup.machine.drive(name);
            config.is_some_and(|config| axis.has_gap(config))
        });
        let first = gaps.next()?;
        if first.1.learned.floats || gaps.any(|(_, axis)| axis.learned.floats) {
            return None;
        }
        // What they have learned by then is as wrong as it is; a memory that they start from is made so.
        let believed = match so_far_s {
            Some(_) => memory.clone(),
            None => of.remembered(memory),
        };
        let options = SimulateOptions {
            learned: Some(Arc::new(believed)),
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
        // Mostly the whole correction is no worse: others are tried where it is.
        let none = Skips::default();
        let leeway = so_far_s.map_or(REMEMBERING, |_| STILL_LEARNING);
        let over = so_far_s.map_or(WHOLE, |so_far_s| {
            let (times, most_s) = REHEARSED;
            let least_s = (so_far_s + AHEAD_S).min(WHOLE.1[1]);
            (times, [least_s, most_s.max(least_s)])
        });
        let (whole, parts) = SHARES.split_at(1);
        let start = self.measure(&setup, of, whole, &none, &over).ok()?;
        if let Some(said) = start.no_worse(leeway) {
            return Some(said);
        }
        let whole = so_far_s.is_none().then_some(start);
        let spared = self.sparing(&setup, of, leeway, whole);
        if spared.is_some() {
            return spared;
        }
        let part = self.measure(&setup, of, parts, &none, &over).ok()?;
        Some(part.no_worse(leeway).unwrap_or_else(|| part.nothing()))
    }

    /// The whole correction but where the contour would be worse, of a program as far as it is
    /// rehearsed; `None` where that is of no use. `whole`: the rehearsal of all of it, if there was one.
    fn sparing(
        &self,
        setup: &Setup<'_>,
        of: &Variant<'_>,
        leeway: Leeway,
        mut whole: Option<Measured>,
    ) -> Option<Rehearsed> {
        let period_s = setup.machine.cycles().command().period_s();
        let mut skips = Skips::default();
        for _ in 0..ROUNDS {
            let measured = match whole.take() {
                Some(measured) => measured,
                None => self.measure(setup, of, &SHARES[..1], &skips, &WHOLE).ok()?,
            };
            if let Some(said) = measured.no_worse(leeway) {
                return Some(said);
            }
            let (part, on_top) = leeway.aimed;
            let most_mm = part * measured.peak_mm() + on_top;
            skips = skips.widened(&measured.steps, most_mm, period_s, measured.is_whole)?;
        }
        None
    }

    /// Runs the machine of a variant as its drives have learned it, without a correction and with these
    /// parts of it, but for some stretches.
    fn measure(
        &self,
        setup: &Setup<'_>,
        of: &Variant<'_>,
        shares: &[f64],
        skips: &Skips,
        &(times, times_s): &(u32, [f64; 2]),
    ) -> Result<Measured, SimError> {
        let none = Choice::Registered(MethodId::NONE);
        let corrected = of.choice().unwrap_or(&none);
        let mut variants = vec![of.rehearsed(&none, 0.0, skips)];
        variants.extend(
            shares
                .iter()
                .map(|share| of.rehearsed(corrected, *share, skips)),
        );
        let mut stepper = Stepper::new(setup, &variants, self.threads, Kept::default(), None)?;
        let axes = stepper.chunk.outputs.axes().to_vec();
        let mut pass = Rehearsal {
            clock: setup.machine.cycles().command(),
            returns: Returns::new(axes.len()),
            axes,
            over: (times, times_s),
            time_s: 0.0,
            measured: Measured {
                shares: shares.to_vec(),
                skips: skips.clone(),
                contours: vec![Contours::default(); shares.len()],
                steps: Vec::new(),
                is_whole: false,
            },
        };
        // The chunk before is measured while the axes take one.
        let mut more = true;
        while more {
            let look = |chunk: &mut Chunk, tracker: &ContourTracker| pass.take(chunk, tracker);
            let (enough, stepped) = stepper.step(None, look);
            if enough == Some(true) {
                return Ok(pass.measured);
            }
            more = stepped?;
            let place = stepper.looked_at(false).place();
            stepper.release(place);
        }
        pass.take(&stepper.chunk, &stepper.tracker);
        Ok(Measured {
            is_whole: true,
            ..pass.measured
        })
    }
}

/// A rehearsal on its way.
struct Rehearsal {
    clock: Clock,
    axes: Vec<AxisInfo>,
    returns: Returns,
    /// How often each axis has to come back, and how long is rehearsed at least and at most, s.
    over: (u32, [f64; 2]),
    time_s: f64,
    measured: Measured,
}

impl Rehearsal {
    /// Measures a chunk; whether that is enough.
    fn take(&mut self, chunk: &Chunk, tracker: &ContourTracker) -> bool {
        for frame in chunk.frames.iter().filter(|frame| frame.is_command_tick) {
            let returned = self.returns.take(&frame.sample, &self.axes, self.clock);
            self.returns.count(returned);
            self.time_s += self.clock.period_s();
            let joints = |variant| chunk.outputs.load(variant, frame.servo_sample);
            let without = joints(0);
            let path = (tracker, &chunk.modes);
            let mut step = RehearsedCommand {
                place: (frame.sample.segment, frame.sample.s),
                squares: [0.0; 2],
                returns: returned != 0,
            };
            for (index, contours) in self.measured.contours.iter_mut().enumerate() {
                let pair = [without, joints(index + 1)];
                let squares = contours.measure(&frame.sample, &pair, self.clock, path);
                if index == 0 {
                    step.squares = squares.unwrap_or_default();
                }
            }
            self.measured.steps.push(step);
        }
        let (times, [least_s, most_s]) = self.over;
        let lengths = self
            .measured
            .contours
            .iter()
            .map(|contours| contours.time_s);
        let seen =
            lengths.fold(f64::INFINITY, f64::min) >= least_s && self.returns.came_back(times);
        seen || self.time_s >= most_s
    }
}

/// A rehearsal: parts of a correction, with what they leave.
struct Measured {
    shares: Vec<f64>,
    skips: Skips,
    /// By part.
    contours: Vec<Contours>,
    /// Of the first part.
    steps: Vec<RehearsedCommand>,
    /// Whether the program ends there.
    is_whole: bool,
}

impl Measured {
    /// The largest part with which the contour is no worse.
    fn no_worse(&self, leeway: Leeway) -> Option<Rehearsed> {
        let (part, on_top) = leeway.used;
        let found = self
            .shares
            .iter()
            .zip(&self.contours)
            .find(|(_, contours)| {
                let ([without, with], [highest, high]) = (mean_squares(contours), contours.peaks);
                with <= part * part * without && high <= part * highest + on_top
            });
        found.map(|(share, _)| Rehearsed {
            share: *share,
            skips: self.skips.clone(),
            ..self.nothing()
        })
    }

    /// Nothing is corrected.
    fn nothing(&self) -> Rehearsed {
        let first = self.contours.first();
        Rehearsed {
            share: 0.0,
            skips: Skips::default(),
            without: first.map_or([0.0; 2], |first| [mean_squares(first)[0], first.peaks[0]]),
        }
    }

    /// Peak without a correction, mm.
    fn peak_mm(&self) -> f64 {
        self.contours.first().map_or(0.0, |first| first.peaks[0])
    }
}

/// Mean squares without a correction and with it, mm2.
fn mean_squares(contours: &Contours) -> [f64; 2] {
    contours
        .squares
        .map(|sum| sum / (contours.count as f64).max(1.0))
}
