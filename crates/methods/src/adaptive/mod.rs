//! This project's method: learns load and gap from the motor alone, predicts the flank, crosses the
//! gap on a planned traverse.
//!
//! 1. Load: inertia, viscous and Coulomb friction and constant torque from what the motor gives beyond
//!    its own need, less what the shaft winds up (`learning`, `stretch`, `load_filter`, `bridge`).
//! 2. Flank: the sign of the torque in the shaft of a gapless twin that carries this load (`crossing`).
//! 3. Observation: from where a flank that carried the load gives way, at rest long before another has
//!    to carry it, the motor's measured motion and its current are recorded (`watch`, `window`).
//! 4. Gap: with the motor's motion known, the load behind it follows from its own equations for any
//!    gap (`load_laws`), and so does the torque that the motor feels (`lanes`). The gap that best predicts the
//!    motor's motion up to just after it met the far flank is the reading, with its variance
//!    (`reading`, `newton`, `prior`). Load, stiffness and motor friction are free within what is known
//!    of them.
//! 5. Confidence: the reading is compared with other gaps and with one without an end (`said`). Its
//!    variance is at least what the cost at these implies, and it counts only where the contact
//!    explains the motor far better than no contact.
//! 6. Consensus: the groups of the last readings that agree; of those that are large enough the one
//!    with the smallest gap, with a straight line through it (`readings`). A reading that explains
//!    its crossing well hands the load that it found back to `learning`, unless a correction was in
//!    use and it finds another inertia.
//! 7. Trust: the gap is used where friction certainly holds the load, the inertia is known where it
//!    matters, as far as the axes that move with it are ready (`trust`), and a part of it until three
//!    readings agree.
//! 8. Crossing: on the planned traverse of `crossing`, as `lookup`, which is told everything.
//!
//! ```text
//! load     T = K_t i - J_M alpha - b_v w - F_M sign(w) = J_L alpha + b_L w + T_f sign(w) + T_const, N m
//! gap      b = argmin sum (theta_M measured - theta_M(b, load, k, F_M))^2/S + prior, rad
//! ```
//!
//! Until it is confident it does nothing: one reading of a clear contact is enough, or one that says again what
//! another one did while the inertia was in doubt; of several that contradict each other the smallest is used;
//! otherwise two have to agree. At rest while others move a single one is enough. Larger ones that come with a correction speak against it. Until readings agree on a load
//! that has moved both ways, at rest the gap of one that sticks is crossed where the motor's own torque
//! shows that it is about to set out: a load that is learned roughly predicts that less well. Servo, references and
//! cutting forces before the crossing do not enter a reading; only the motor's own equation and its
//! data sheet do.
//!
//! Signals: references, motor position (rad), current and its mean over the servo period (A). It
//! knows what a drive is set up with: its own loops, the motor's data sheet (K_t, R, L, rated
//! torque, rotor inertia and friction, screw or pinion with it), stiffness and damping of the shaft
//! within about a tenth. It is told neither gap nor load inertia nor load friction; the inertia
//! that the drive uses for its feed-forward, right or wrong, enters only as that gain. Settings:
//! part of the drive's torque for a traverse (0 to 1).
//!
//! Fails: where motion shows the load's inertia only in its reversals (short ramps at a low feed), or
//! a wide gap keeps the load bouncing from stop to stop, contacts are not explained and not used.
//! A load without friction is left as it is. An axis that never learns its gap keeps those that move
//! with it from being compensated. A crossing that takes longer than some 16 s is not read. Where a drive that is tuned
//! for a heavy load chatters with the motor alone in the gap, readings scatter. A cutting force
//! that changes the sign of the torque is not foreseen. Its state takes 320 kB before the
//! first tick, and no more later.
//!
//! Source: this project; the question (gap, load inertia and friction unknown, motor signals only)
//! is that of Gan, Wang, Huang, Machines 2023, 11(2), 193; prediction error method: Ljung, *System
//! Identification*, 1999.

mod bridge;
mod foresee;
mod lanes;
mod learning;
mod load_filter;
mod load_laws;
mod memory;
mod newton;
mod prior;
mod reading;
mod said;
mod start;
mod stretch;
mod trust;
mod used;
mod watch;
mod window;

use crate::AxisConfig;
use crate::crossing::{Crossing, CrossingState, TORQUE_SHARE};
use crate::memory::{LARGEST_HALF_GAP_RAD, is_started_from, negligible_half_gap_rad};
use crate::readings::{Consensus, Readings};
use crate::registry::{Registered, Settings};
use foresee::Foresee;
use lanes::Known;
use learning::{LearningState, Seen};
use lostmotion_base::Clock;
use lostmotion_drive::config::Transmission;
use lostmotion_drive::config::check::{AxisConfigError, between};
use lostmotion_drive::twin::{LoadModel, Twinned};
use lostmotion_drive::{
    Compensator, Correction, GapReading, Heeded, Knowledge, Learned, Learning, MethodInfo, Signals,
};
use prior::Prior;
use reading::Reading;
use said::Said;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::mem::swap;
pub use trust::LONG_REST_S;
use trust::Trust;
use used::{Kept, used_of};
use watch::{Motor, Watch};
use window::Window;

/// Settings of `adaptive`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AdaptiveSettings {
    /// Part of the drive's largest torque that a traverse of the gap may take, 0 to 1.
    pub torque_share: f64,
}

impl Default for AdaptiveSettings {
    fn default() -> AdaptiveSettings {
        AdaptiveSettings {
            torque_share: TORQUE_SHARE,
        }
    }
}

impl Settings for AdaptiveSettings {
    fn check(&self, _transmission: &Transmission) -> Result<(), AxisConfigError> {
        between("torque_share", self.torque_share, 0.01, 1.0)
    }
}

/// Least standard deviation of a measured position, rad, also with an ideal encoder. Tuned (5e-7
/// before): with less, errors of the model count more.
const LEAST_NOISE_RAD: f64 = 3e-7;
/// Standard deviation of the unmodelled torque over a servo tick, part of the rated torque. A
/// choice: larger blinds the innovations to soft contacts, smaller takes cogging and uneven
/// friction for one.
const UNMODELLED_SHARE: f64 = 3e-3;
/// Observed torque below which the load may be between the flanks, so that nothing is learned of it,
/// part of the rated torque. Decision 66 of the book.
const HANGING_SHARE: f64 = 1e-3;
// A misfit is the mean square of the innovations over their variance, 1 for a perfect model.
/// Largest misfit of a reading that counts. A choice: larger believes readings that the model does
/// not explain, smaller drops good ones with small errors of the model.
const LARGEST_MISFIT: f64 = 10.0;
/// The same as a part of the misfit without a gap, where that is more: decision 62 of the book.
const LARGEST_MISFIT_SHARE: f64 = 0.005;
/// Bound of the latter: beyond it a second contact or a load that bounced was taken for the gap.
/// Tuned on drawn cells of seed 1 and 773109 (no bound before, which let 5 gaps pass).
const LARGEST_MISFIT_BY_SHARE: f64 = 30.0;
/// Part of what is worth compensating that a reading of no gap at all counts as, since deviations are told in parts of the
/// value.
const LEAST_HALF_GAP_SHARE: f64 = 0.1;
/// Largest standard deviation of a reading that counts, part of its value. A choice: a half gap
/// that is off by as much leaves a fifth of the error.
const LARGEST_DOUBT: f64 = 0.2;
/// Standard deviation that a faint contact adds, part of the value. A choice: such a reading weighs
/// about a sixteenth of one that is sure to a per cent.
const FAINT_DOUBT: f64 = 0.04;
/// Evidence (difference of the squares over their variance to a gap without an end) from which on a
/// contact counts: decision 63 of the book.
const LEAST_EVIDENCE: f64 = 50.0;
/// Evidence from which on a contact is beyond doubt. A choice: six times `LEAST_EVIDENCE`; less
/// lets a false contact count alone, more waits for a second one.
const CLEAR_EVIDENCE: f64 = 300.0;
/// Largest misfit of a reading over a wavering flank. A choice: where the flank wavered an earlier
/// contact may be the cause, so more has to be explained.
const CLEAR_MISFIT: f64 = 3.0;
/// Largest standard deviation of a reading over a wavering flank, part of its value: decision 64 of
/// the book.
const CLEAR_DOUBT: f64 = 0.03;
/// Largest misfit of a reading that counts alone: it may be off by a tenth, which is better than no
/// compensation.
const ALONE_MISFIT: f64 = 20.0;
/// Largest standard deviation of the inertia, part of its value, with which a window over a
/// wavering flank can be read. A choice: the way of the load while it was loose is uncertain by
/// about as much.
const LARGEST_INERTIA_DOUBT: f64 = 0.35;

/// Servo ticks between the starts of two readings once the gap is known: 2 s, and twice as long after each that
/// shows the same, up to 16 s; 2 s again after one that does not. A choice: a gap wears in weeks and warms in
/// minutes; shorter follows faster drifts, longer saves the reading, which costs most of what this method computes.
const READING_PAUSE_TICKS: [u32; 4] = [8000, 16_000, 32_000, 64_000];
/// Part of the gap within which a reading shows the same as those before it. A choice: what has drifted between two
/// readings leaves no more; readings are a half to one per cent off.
const SAME_SHARE: f64 = 0.01;
/// Readings that have to agree for that. A choice: half of those that are kept.
const READINGS_TO_PAUSE: u32 = 4;

/// Part of the gap within which a reading agrees with the others, so that the load that it found
/// is one to hold on to.
const AGREEING_SHARE: f64 = 0.1;

/// The method `adaptive`.
#[derive(Clone, Debug)]
pub struct Adaptive {
    crossing: Crossing,
    /// The load before anything is learned: the motor's own inertia, no friction.
    first: LoadModel,
    known: Known,
    motor: Motor,
    motor_coulomb: f64,
    /// Half gap below which there is nothing to compensate, rad.
    negligible: f64,
    /// What it starts from.
    remembered: Option<Learned>,
    /// Servo ticks in a command cycle.
    cycle_ticks: u32,
}

/// How well the load is known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Doubts {
    /// The least and the most by which friction holds it, parts of the rated torque.
    holding: [f64; 2],
    /// Standard deviation over value of its inertia, 0 where readings agree on it.
    inertia: f64,
}

/// What it has learned, and the reading under way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AdaptiveState {
    crossing: CrossingState,
    load: LoadModel,
    learning: LearningState,
    /// As they were with what was learned last.
    doubts: Doubts,
    watch: Watch,
    reading: Option<Reading>,
    /// The window that it reads.
    read: Window,
    /// Servo ticks since the last reading began.
    since_reading: u32,
    /// How many readings in a row showed the same as those before them, as far as that counts for the pause.
    steady: usize,
    /// The smallest half gap of the readings over a wavering flank that did not count for their inertia alone,
    /// rad; 0 for none.
    unsure: f64,
    /// The last reading, for traces.
    last: Option<GapReading>,
    gap: Readings,
    /// Half gap that is used, rad, in motion and at rest; 0 for none.
    used: f64,
    at_rest: f64,
    trust: Trust,
    foresee: Foresee,
    #[serde(skip)]
    kept: Kept,
}

impl Registered for Adaptive {
    const INFO: &'static MethodInfo = &MethodInfo {
        name: "adaptive",
        summary: "learns load and gap from the motor alone and crosses the gap on a planned traverse",
        knows: Knowledge {
            load_scale: false,
            gap: false,
            load: false,
        },
        source: "this project",
    };

    /// The windows and filters count in servo ticks of 250 us.
    fn suits(config: &AxisConfig) -> Result<(), AxisConfigError> {
        if let Some(memory) = &config.compensation.learned {
            memory.check(config)?;
        }
        if config.cycles.servo() == Clock::SERVO {
            return Ok(());
        }
        Err(AxisConfigError::Mismatch {
            key: "cycles.servo_us".to_owned(),
            reason: format!(
                "it is {}, and `adaptive` works at 250 only",
                config.cycles.servo_us
            ),
            hint: "leave servo_us out, or take another method".to_owned(),
        })
    }

    fn from_axis(config: &AxisConfig) -> Adaptive {
        let inertia = config.motor_side_inertia_kgm2();
        let count = config
            .drive
            .encoder_counts_per_rev
            .map_or(0.0, |counts| TAU / f64::from(counts));
        let (torque_constant, viscous) = (
            config.motor.torque_constant_nm_per_a,
            config.motor.viscous_nm_s_per_rad,
        );
        let rated_torque = config.motor.rated_torque_nm;
        let negligible = negligible_half_gap_rad(&config.transmission);
        // rounding to counts: standard deviation count/sqrt(12)
        let noise = (count / 12.0_f64.sqrt()).max(LEAST_NOISE_RAD);
        Adaptive {
            crossing: Crossing::new(config, config.compensation.adaptive.torque_share, 0.0)
                .taking_up(),
            first: LoadModel {
                inertia,
                viscous: 0.0,
                coulomb: 0.0,
                constant: 0.0,
                ..LoadModel::told(config)
            },
            known: Known {
                torque_constant,
                inertia,
                viscous,
                noise,
                unmodelled: UNMODELLED_SHARE * rated_torque,
            },
            motor: Motor {
                torque_constant,
                inertia,
                viscous,
                rated_torque,
                noise,
            },
            motor_coulomb: config.motor.coulomb_nm,
            negligible,
            remembered: config
                .compensation
                .learned
                .map(|memory| memory.learned)
                .filter(|learned| is_started_from(learned, rated_torque, negligible)),
            cycle_ticks: config.cycles.servo_ticks() as u32,
        }
    }
}

impl Adaptive {
    /// Starts to read the window that is complete, unless another one is being read or the load is unknown.
    fn begin_reading(&self, state: &mut AdaptiveState) {
        let pauses = state.gap.count >= READINGS_TO_PAUSE
            && state.learning.is_anchored()
            && state.since_reading < READING_PAUSE_TICKS[state.steady];
        if !state.learning.known || state.reading.is_some() || pauses {
            state.watch.complete.clear();
            return;
        }
        // the two change places: a window's memory is used again and again
        swap(&mut state.watch.complete, &mut state.read);
        state.since_reading = 0;
        state.read.corrected = state.crossing.ahead()[0] != 0.0;
        let prior = Prior {
            load: state.load,
            covariance: state
                .learning
                .covariance(self.motor.inertia, self.motor.rated_torque),
            motor_coulomb: self.motor_coulomb,
            rated_torque: self.motor.rated_torque,
            // a half gap on which readings agree is a candidate of the search, no prior
            half_gap: if state.gap.count > 1 {
                state.gap.used()
            } else {
                0.0
            },
            side: f64::from(state.read.side),
        };
        state.reading = Some(Reading::new(&state.read, prior, self.known.noise));
    }

    /// Continues the reading; its result joins the others.
    fn read(&self, state: &mut AdaptiveState) {
        let Some(said) = state
            .reading
            .as_mut()
            .and_then(|reading| reading.work(&mut state.read, &self.known))
        else {
            return;
        };
        state.reading = None;
        state.kept = Kept::default();
        // A load that touched the far flank, came back and rested was met elsewhere in the end: the contact
        // that tells the gap may be among long samples.
        let hidden = said.wavered && state.read.hides();
        // what was off its flank during the warm-up shows another load
        let settled = !state.read.unsettled;
        let corrected = state.read.corrected;
        state.read.clear();
        // whether it is within this part of what is known
        let within = |part: f64| {
            state.gap.count > 0 && (said.half_gap - state.gap.value).abs() < part * state.gap.value
        };
        let (agrees, same) = (within(AGREEING_SHARE), within(SAME_SHARE));
        // over a wavering flank only sharp readings count, and only with a known inertia
        let sharp = said.variance < CLEAR_DOUBT * CLEAR_DOUBT * said.half_gap * said.half_gap;
        let unsure = said.wavered && state.learning.inertia_doubt() > LARGEST_INERTIA_DOUBT;
        let counts = self.counts(&said) && !hidden && (sharp || !said.wavered);
        state.last = Some(self.reported(state.last, &said, sharp && !hidden && !unsure));
        if counts && unsure {
            state.unsure = if state.unsure > 0.0 {
                said.half_gap.min(state.unsure)
            } else {
                said.half_gap
            };
        }
        if counts && !unsure {
            // contacts that hardly show, or over a wavering flank, are less certain than their
            // variance
            let faint = if said.evidence < CLEAR_EVIDENCE || said.wavered {
                FAINT_DOUBT * said.half_gap
            } else {
                0.0
            };
            // what an unsure one has said before is said twice
            let again = (said.half_gap - state.unsure).abs() < AGREEING_SHARE * said.half_gap;
            let clear =
                said.misfit < ALONE_MISFIT && said.evidence > CLEAR_EVIDENCE && !said.wavered;
            state.steady = if same {
                (state.steady + 1).min(READING_PAUSE_TICKS.len() - 1)
            } else {
                0
            };
            // single readings only count alone over one crossing that is explained and beyond doubt
            state.gap.take_by(
                Consensus::Least { corrected },
                said.half_gap.max(LEAST_HALF_GAP_SHARE * self.negligible),
                said.variance + faint * faint,
                said.wavered,
                clear || again,
            );
        }
        // what explains a crossing so well knows the load behind it, too
        if said.misfit < CLEAR_MISFIT
            && said.evidence > CLEAR_EVIDENCE
            && sharp
            && !hidden
            && settled
        {
            // Where a correction is in use the contact is soft and says little of the inertia, each time off to
            // the same side: it would take what the last one took wrong for known, and go on from there.
            if !corrected
                || state
                    .learning
                    .confirms_inertia(&said.load, self.motor.inertia)
            {
                state
                    .learning
                    .learn(&said.load, self.motor.inertia, self.motor.rated_torque);
            }
            if agrees {
                state.learning.anchor(said.load.0[0] / self.motor.inertia);
                state.crossing.trusts_twin = state.learning.is_anchored()
                    || state.gap.count > 1 && state.trust.moved_both_ways();
            }
        }
        // what is used by hints alone gives way to anything smaller, however little it shows: a traverse that
        // is too long pushes the load, and no contact shows then
        let denied = state.gap.count == 0 && said.half_gap < state.used;
        if !hidden && (hints(&said, self.negligible) || denied) {
            state
                .gap
                .hint(said.half_gap.max(LEAST_HALF_GAP_SHARE * self.negligible));
        }
        // what a memory said stands until a reading counts
        if state.gap.count > 0 {
            let deviation = state.gap.variance.max(0.0).sqrt();
            state.trust.nil = self.is_nil(state.gap.value, deviation);
        }
        (state.used, state.at_rest) = used_of(&state.gap, state.trust.nil);
    }
}

/// Whether a reading is a hint of the gap, though it may not count: a contact beyond doubt, not quite
/// explained, or one that shows and is explained, over a flank that wavered.
fn hints(said: &Said, negligible: f64) -> bool {
    let shows = said.evidence > CLEAR_EVIDENCE && said.misfit < LARGEST_MISFIT_BY_SHARE
        || said.evidence > LEAST_EVIDENCE && said.misfit < CLEAR_MISFIT;
    said.half_gap > negligible
        && shows
        && said.variance < LARGEST_DOUBT * LARGEST_DOUBT * said.half_gap * said.half_gap
}

impl Adaptive {
    /// How well the load is known now.
    fn doubts(&self, state: &AdaptiveState) -> Doubts {
        let (learning, rated_torque) = (&state.learning, self.motor.rated_torque);
        Doubts {
            holding: learning
                .holding_bounds(&state.load, rated_torque, state.trust.deviations())
                .map(|bound| bound / rated_torque),
            inertia: if learning.is_anchored() {
                0.0
            } else {
                learning.inertia_doubt()
            },
        }
    }

    /// Whether a reading counts: the contact shows, the model explains it, and it tells the gap or
    /// that there is none to compensate.
    fn counts(&self, said: &Said) -> bool {
        let explained = if said.wavered {
            CLEAR_MISFIT
        } else {
            LARGEST_MISFIT
        }
        .max((LARGEST_MISFIT_SHARE * said.without).min(LARGEST_MISFIT_BY_SHARE));
        let tells = said.variance < LARGEST_DOUBT * LARGEST_DOUBT * said.half_gap * said.half_gap
            || said.half_gap + 2.0 * said.variance.sqrt() < self.negligible;
        said.half_gap < LARGEST_HALF_GAP_RAD
            && said.evidence > LEAST_EVIDENCE
            && said.misfit < explained
            && tells
    }

    /// Whether a half gap with this standard deviation, rad, is certainly too small to matter.
    fn is_nil(&self, half_gap: f64, deviation: f64) -> bool {
        half_gap + 2.0 * deviation <= self.negligible
    }
}

impl Compensator for Adaptive {
    type State = AdaptiveState;

    const LEARNS_LOAD: bool = true;

    const HEEDS_OTHERS: bool = true;

    fn info(&self) -> &'static MethodInfo {
        Self::INFO
    }

    fn initial(&self, motor_position: f64) -> AdaptiveState {
        if let Some(learned) = &self.remembered {
            return self.remembering(motor_position, learned);
        }
        AdaptiveState {
            crossing: self.crossing.initial(motor_position, &self.first),
            load: self.first,
            learning: LearningState::new(),
            doubts: Doubts::default(),
            watch: Watch::default(),
            reading: None,
            read: Window::default(),
            since_reading: 0,
            steady: 0,
            unsure: 0.0,
            last: None,
            gap: Readings::default(),
            used: 0.0,
            at_rest: 0.0,
            trust: Trust::NONE,
            foresee: Foresee::at(motor_position),
            kept: Kept::default(),
        }
    }

    fn make_room(&self, state: &mut AdaptiveState) {
        state.watch.make_room();
        state.read.make_room();
        state.foresee.make_room();
    }

    fn learned(&self, state: &AdaptiveState) -> Option<Learned> {
        self.memory(state)
    }

    fn learning(&self, state: &AdaptiveState) -> Option<Learning> {
        Some(self.knowledge(state))
    }

    fn step(&self, state: &mut AdaptiveState, signals: &Signals) -> Correction {
        if let Some(twin) = self.begin(state, signals) {
            twin.step(&signals.reference, &signals.next_reference);
        }
        self.finish(state, signals)
    }

    #[inline(always)]
    fn begin<'a>(&'a self, state: &'a mut AdaptiveState, signals: &Signals) -> Option<Twinned<'a>> {
        // learn the load before the twin is stepped with it; not while the load may be without
        // contact
        let before = state.watch.seen();
        state
            .watch
            .observe(&self.motor, signals, &state.crossing.twin);
        let seen = state.watch.seen();
        let disturbed = state.crossing.crossing()
            || seen.abs() < HANGING_SHARE * self.motor.rated_torque
            || seen * before < 0.0;
        let seen = Seen {
            torque: seen,
            disturbed,
        };
        state.learning.step(
            &self.crossing.twin,
            &state.crossing.twin,
            signals,
            seen,
            &self.motor,
            &mut state.load,
        );
        Some(self.crossing.begin(&mut state.crossing, &state.load))
    }

    fn readiness(&self, state: &AdaptiveState) -> Option<f64> {
        state.trust.readiness(state.used)
    }

    fn heed(&self, state: &mut AdaptiveState, heeded: Heeded) {
        state.trust.heed(heeded);
        state.kept = Kept::default();
        state.foresee.clear(state.crossing.before.load_position);
    }

    fn foreseen<'a>(&self, state: &'a AdaptiveState) -> &'a [Option<[f64; 2]>] {
        state.foresee.kept()
    }

    #[inline(always)]
    fn finish(&self, state: &mut AdaptiveState, signals: &Signals) -> Correction {
        // torque and flank before this tick's decision, for the watch
        let (carried, side) = (state.crossing.before.torque, state.crossing.side);
        let (used, known) = self.use_of(state, signals.reference.velocity == 0.0);
        if state.foresee.is_asked() {
            // what only winds up the shaft of a load at rest moves nothing
            let [offset, wound] = state.crossing.ahead();
            state.foresee.step(
                [signals.motor_position - wound, offset - wound],
                known,
                (&state.load, state.learning.known),
                &state.crossing.before,
                self.cycle_ticks,
            );
        }
        let mut correction = self
            .crossing
            .finish(&mut state.crossing, signals, &state.load, used);
        if state.learning.known {
            let news = state.learning.news();
            if news {
                state.doubts = self.doubts(state);
            }
            let Doubts { holding, inertia } = state.doubts;
            let (reference, side) = (&signals.reference, state.crossing.side);
            if news || !state.trust.goes_on(reference, side) {
                state.trust.step(reference, side, holding);
                state.kept = Kept::default();
            }
            let foresees = state.trust.foresees();
            state
                .trust
                .weigh(reference, &state.load, inertia, state.used);
            state.trust.swing(state.crossing.swings);
            if state.trust.foresees() != foresees {
                state.kept = Kept::default();
            }
        }
        state.since_reading = state.since_reading.saturating_add(1);
        // the flank has been decided: open, extend or close the window, then read on
        if state.watch.step(
            &self.motor,
            side,
            state.crossing.side,
            carried,
            state.load.coulomb,
        ) {
            self.begin_reading(state);
        }
        self.read(state);
        // estimates for traces: the consensus, not what is used
        correction.gap_angle_estimate = if state.gap.count == 0 {
            f64::NAN
        } else {
            f64::from(state.crossing.side) * state.gap.value
        };
        if state.learning.known {
            correction.inertia_estimate = self.crossing.twin.motor_inertia() + state.load.inertia;
        }
        correction
    }
}
