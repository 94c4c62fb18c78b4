//! Ours: learns load and gap from the motor alone, predicts the flank, crosses the gap on a planned
//! traverse.
//!
//! 1. Load: inertia, viscous and Coulomb friction and constant torque from what the motor gives
//!    beyond its own need (`learning`).
//! 2. Flank: the sign of the torque in the shaft of a gapless twin that carries this load (`twin`,
//!    `crossing`).
//! 3. Crossings: from where a flank that carried the load gives way, at rest long before another
//!    has to carry it, the motor's measured motion and its current are kept (`watch`, `window`).
//! 4. Gap: with the motor's motion known, the load behind it follows from its own equations for any
//!    gap, and so does the torque that the motor feels (`lanes`). The gap that foresees the motor's
//!    motion best up to just after it met the far flank is read from the window, with its variance
//!    (`reading`, `newton`, `prior`). Load, stiffness and motor friction are free within what is
//!    known of them.
//! 5. What was found is held against other gaps and against one without an end (`said`): it is no
//!    surer than these tell, and counts only where the contact explains the motor far better than
//!    none. Readings outvote each other; through those that agree goes a straight line
//!    (`readings`).
//! 6. Crossing: on the planned traverse of `crossing`, as `lookup` does that is told everything.
//!
//! It does nothing until it is sure: a reading of a contact that shows clearly is enough, of
//! several that contradict each other the least, two that agree otherwise. Where nothing holds the
//! load and it may float, or its motion hardly drives it, it does nothing either (`floating`). At
//! rest the gap of a load that sticks is crossed where the motor's own torque shows that it is
//! about to set out (`crossing`): a learned load foretells that less well than a known one. Servo,
//! references and cutting forces before the crossing do not enter a reading; only the motor's own
//! equation and its data sheet do.
//!
//! Signals: references, motor position (rad), current and its mean over the servo period (A). It
//! knows what a drive is set up with: its own loops, the motor's data sheet (K_t, R, L, rated
//! torque, rotor inertia and friction, screw or pinion with it), stiffness and damping of the shaft
//! within a tenth or so. It is told neither gap nor load inertia nor load friction; the inertia
//! that the drive uses for its feed-forward, right or wrong, enters only as that gain. Tunables:
//! part of the drive's torque for a traverse (0 to 1).
//!
//! Fails: where a load without friction is accelerated so gently, or seen through so coarse an
//! encoder, that its contacts do not show: it then does nothing, or knows the gap to a tenth. Where
//! motion never shows the load's inertia but in its reversals (short ramps at a low feed), or a
//! wide gap keeps the load bouncing from stop to stop, contacts are not explained and not used. Of
//! two axes that make a contour it may know but one, and the contour is then worse than without. A
//! crossing that takes longer than some 16 s is not read. Where a drive that is tuned for a heavy
//! load chatters with the motor alone in the gap, readings scatter. A cutting force that turns the
//! torque around is not foreseen. Its state holds windows of up to 60 kB. Source: this project; the
//! question (gap, load inertia and friction unknown, motor signals only) is that of Gan, Wang,
//! Huang, Machines 2023, 11(2), 193; prediction error method: Ljung, *System Identification*, 1999.

mod bridge;
mod floating;
mod lanes;
mod learning;
mod load_filter;
mod newton;
mod prior;
mod reading;
mod said;
mod watch;
mod window;

use crate::AxisConfig;
use crate::crossing::{Crossing, CrossingState};
use crate::readings::Readings;
use crate::registry::{Registered, Settings};
use floating::Floating;
use lanes::Known;
use learning::{LearningState, Seen};
use lostmotion_base::Clock;
use lostmotion_drive::config::Transmission;
use lostmotion_drive::config::check::{AxisConfigError, between};
use lostmotion_drive::twin::{LoadModel, Twinned};
use lostmotion_drive::{Compensator, Correction, Knowledge, MethodInfo, Signals};
use prior::Prior;
use reading::Reading;
use said::Said;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
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
        AdaptiveSettings { torque_share: 0.5 }
    }
}

impl Settings for AdaptiveSettings {
    fn check(&self, _transmission: &Transmission) -> Result<(), AxisConfigError> {
        between("torque_share", self.torque_share, 0.01, 1.0)
    }
}

/// Encoder noise that is never undercut, rad.
const LEAST_NOISE: f64 = 3e-7;
/// Torque that nothing models, part of the rated one.
const UNMODELLED: f64 = 3e-3;
/// Part of the rated torque below which the load may hang between the flanks; then there is nothing
/// to learn of it.
const HANGS: f64 = 1e-3;
/// A reading counts where the innovations with its gap have no more than this mean square over
/// their variance, or this part of that without a gap and where its standard deviation is below
/// this part of its value.
const EXPLAINED: f64 = 10.0;
const EXPLAINED_PART: f64 = 0.005;
const SHARP: f64 = 0.2;
/// Half gaps are smaller, rad.
const LARGEST: f64 = 0.3;
/// Standard deviation over value that a faint contact adds.
const FAINT: f64 = 0.04;
/// By how much a contact has to explain the motor better than a gap without an end, squares over
/// their variance: to count, and to be beyond doubt.
const SEEN: f64 = 50.0;
const EVIDENT: f64 = 300.0;
/// A contact that shows clearly: misfit and standard deviation over value.
const CLEAR_MISFIT: f64 = 3.0;
const CLEAR: f64 = 0.03;
/// Misfit up to which a reading counts alone: it may be off by a tenth, which is better than
/// nothing.
const ALONE_MISFIT: f64 = 20.0;
/// Standard deviation over value of the inertia from which on a flank that wavers cannot be read.
const UNSURE: f64 = 0.2;

/// The method `adaptive`.
#[derive(Clone, Debug)]
pub struct Adaptive {
    crossing: Crossing,
    first: LoadModel,
    known: Known,
    motor: Motor,
    motor_coulomb: f64,
}

/// What it has learned.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AdaptiveState {
    crossing: CrossingState,
    load: LoadModel,
    learning: LearningState,
    watch: Watch,
    reading: Option<Reading>,
    gap: Readings,
    floating: Floating,
    used: f64,
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
        let noise = (count / 12.0_f64.sqrt()).max(LEAST_NOISE);
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
                unmodelled: UNMODELLED * rated_torque,
            },
            motor: Motor {
                torque_constant,
                inertia,
                viscous,
                rated_torque,
                noise,
            },
            motor_coulomb: config.motor.coulomb_nm,
        }
    }
}

impl Adaptive {
    /// Sets out to read a window, unless there is one under way.
    fn begin_reading(&self, state: &mut AdaptiveState, window: Window) {
        if !state.learning.known || state.reading.is_some() {
            return;
        }
        let prior = Prior {
            load: state.load,
            covariance: state
                .learning
                .covariance(self.motor.inertia, self.motor.rated_torque),
            motor_coulomb: self.motor_coulomb,
            rated_torque: self.motor.rated_torque,
            half_gap: if state.gap.count > 1 {
                state.gap.used()
            } else {
                0.0
            },
            side: f64::from(window.side),
        };
        state.reading = Some(Reading::new(window, prior, self.known.noise));
    }

    /// Goes on reading and takes up what is found.
    fn read(&self, state: &mut AdaptiveState) {
        let Some(said) = state
            .reading
            .as_mut()
            .and_then(|reading| reading.work(&self.known))
        else {
            return;
        };
        state.reading = None;
        let sharp = said.variance < CLEAR * CLEAR * said.half_gap * said.half_gap;
        let unsure = said.wavered && state.learning.inertia_doubt() > UNSURE;
        if counts(&said) && !unsure && (sharp || !said.wavered) {
            let faint = if said.evidence < EVIDENT || said.wavered {
                FAINT * said.half_gap
            } else {
                0.0
            };
            let alone = said.misfit < ALONE_MISFIT && said.evidence > EVIDENT && !said.wavered;
            state.gap.take(
                said.half_gap,
                said.variance + faint * faint,
                said.wavered,
                alone,
            );
        }
        state.used = state.gap.used();
    }
}

fn counts(said: &Said) -> bool {
    let explained = if said.wavered {
        CLEAR_MISFIT
    } else {
        EXPLAINED
    }
    .max(EXPLAINED_PART * said.without);
    said.half_gap < LARGEST
        && said.evidence > SEEN
        && said.misfit < explained
        && said.variance < SHARP * SHARP * said.half_gap * said.half_gap
}

impl Compensator for Adaptive {
    type State = AdaptiveState;

    const LEARNS_LOAD: bool = true;

    fn info(&self) -> &'static MethodInfo {
        Self::INFO
    }

    fn initial(&self, motor_position: f64) -> AdaptiveState {
        AdaptiveState {
            crossing: self.crossing.initial(motor_position, &self.first),
            load: self.first,
            learning: LearningState::new(),
            watch: Watch::default(),
            reading: None,
            gap: Readings::default(),
            floating: Floating::NEVER,
            used: 0.0,
        }
    }

    fn step(&self, state: &mut AdaptiveState, signals: &Signals) -> Correction {
        if let Some(twin) = self.begin(state, signals) {
            twin.step(&signals.reference, &signals.next_reference);
        }
        self.finish(state, signals)
    }

    fn begin<'a>(&'a self, state: &'a mut AdaptiveState, signals: &Signals) -> Option<Twinned<'a>> {
        let before = state.watch.seen();
        state
            .watch
            .observe(&self.motor, signals, &state.crossing.twin);
        let seen = state.watch.seen();
        let disturbed = state.crossing.crossing()
            || seen.abs() < HANGS * self.motor.rated_torque
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

    fn finish(&self, state: &mut AdaptiveState, signals: &Signals) -> Correction {
        let (carried, side) = (state.crossing.before.torque, state.crossing.side);
        let used = if state.floating.floats() {
            0.0
        } else {
            state.used
        };
        let mut correction = self
            .crossing
            .finish(&mut state.crossing, signals, &state.load, used);
        if state.learning.known {
            let friction = state
                .learning
                .most_friction(&state.load, self.motor.rated_torque);
            state.floating.step(
                &signals.reference,
                &state.load,
                friction,
                self.motor.rated_torque,
                state.crossing.side != side,
            );
        }
        if let Some(window) = state.watch.step(
            &self.motor,
            side,
            state.crossing.side,
            carried,
            state.load.coulomb,
        ) {
            self.begin_reading(state, window);
        }
        self.read(state);
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
