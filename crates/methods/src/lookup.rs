//! Full knowledge: gap, shaft and load are told, the flank is predicted, the gap is crossed on a
//! planned traverse.
//!
//! The best that a drive can do that knows its axis and sees only its motor: the benchmark for
//! methods that have to learn. The told load drives a gapless twin of the axis. Where the torque
//! `T` in its shaft is about to change sign, the motor crosses the told gap on a quintic within a
//! part of the drive's largest torque, with velocity and torque fed forward.
//!
//! ```text
//! side      sign of T half a traverse ahead, where the load model at the reference agrees       T, N m
//! offset    from one side to the other, -+ b, along 10 u^3 - 15 u^4 + 6 u^5                      b, rad
//! T_g       sqrt(5.77 J_M 2 b/torque), s;   wind-up share of T/k on top, rad
//! ```
//! The equations in full are in `crossing`, `traverse` and [`lostmotion_drive::twin`].
//!
//! Signals: reference, next reference (rad, rad/s, rad/s2). Settings: told total gap (um, mdeg or
//! motor rad), part of the drive's torque for a traverse (0 to 1), part of the wind-up T/k that is
//! added to the reference (0 to 1; 0 leaves it as on a machine without a gap), and whether all that is
//! used only from 20 ms after the first change of flank on: no method that learns from the motor can
//! know a gap before the motor has crossed it, so what this leaves is the least that one can leave that starts
//! without a memory. The load's inertia,
//! friction, constant torque, weight ([`lostmotion_drive::config::Gravity`]) and the shaft's
//! stiffness and damping are those of the description.
//!
//! Fails: an error of the gap stays in full, an error of the friction moves the crossing in time. A
//! cutting force that changes the sign of the torque is not foreseen. A load without any friction
//! floats after a landing that is not quite soft: at a feed so slow that the load needs less than
//! some thousandths of the rated torque it can take the whole gap to come back. A jerk that changes
//! within half a traverse makes the crossing early or late.
//!
//! Source: flank by torque sign after Gan, Wang, Huang, Machines 2023, 11(2), 193 (their
//! sign(alpha_ref) is the case without friction) and the controls' sign(v_ref) (the case without
//! inertia); the rest-to-rest quintic is standard in trajectory planning.

use crate::AxisConfig;
use crate::crossing::{Crossing, CrossingState, TORQUE_SHARE};
use crate::registry::{Registered, Settings, told, told_or_true_gap};
use lostmotion_drive::config::check::{AxisConfigError, between};
use lostmotion_drive::config::{Gap, Transmission};
use lostmotion_drive::twin::{LoadModel, Twinned};
use lostmotion_drive::{Compensator, Correction, Knowledge, MethodInfo, Signals};
use serde::{Deserialize, Serialize};

/// Settings of `lookup`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LookupSettings {
    /// Total gap that the drive was told; the machine's true gap if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gap: Option<Gap>,
    /// Part of the drive's largest torque that a traverse of the gap may take, 0 to 1.
    pub torque_share: f64,
    /// Part of the shaft's wind-up that is added to the reference, 0 to 1.
    pub wind_up: f64,
    /// Whether the gap is used only once the load has changed its flank for the first time, as if it had been
    /// learned there.
    pub after_crossing: bool,
}

impl Default for LookupSettings {
    fn default() -> LookupSettings {
        LookupSettings {
            gap: None,
            torque_share: TORQUE_SHARE,
            wind_up: 0.0,
            after_crossing: false,
        }
    }
}

impl Settings for LookupSettings {
    fn check(&self, transmission: &Transmission) -> Result<(), AxisConfigError> {
        told("gap", self.gap, transmission)?;
        between("torque_share", self.torque_share, 0.01, 1.0)?;
        between("wind_up", self.wind_up, 0.0, 1.0)
    }

    fn gaps(&mut self) -> Vec<&mut Option<Gap>> {
        vec![&mut self.gap]
    }
}

/// The method `lookup`.
#[derive(Clone, Debug)]
pub struct Lookup {
    crossing: Crossing,
    load: LoadModel,
    half_gap: f64,
    after_crossing: bool,
}

/// Servo ticks from a change of flank on after which the far flank has been met: 20 ms.
const MET_TICKS: u32 = 80;

/// State of its twin and of its traverse.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LookupState {
    crossing: CrossingState,
    /// Servo ticks since the first change of flank, up to [`MET_TICKS`]; 0 before it.
    since: u32,
}

impl Registered for Lookup {
    const INFO: &'static MethodInfo = &MethodInfo {
        name: "lookup",
        summary: "known gap crossed on a planned traverse where the torque that the known load needs changes sign",
        knows: Knowledge {
            load_scale: false,
            gap: true,
            load: true,
        },
        source: "flank by torque sign after Gan, Wang, Huang, Machines 2023, 11(2), 193; planned traverse",
    };

    fn from_axis(config: &AxisConfig) -> Lookup {
        let settings = &config.compensation.lookup;
        let gap = told_or_true_gap(settings.gap, config);
        let crossing = Crossing::new(config, settings.torque_share, settings.wind_up);
        let crossing = if settings.after_crossing {
            crossing.taking_up()
        } else {
            crossing
        };
        Lookup {
            crossing: crossing.with_weight(config),
            after_crossing: settings.after_crossing,
            load: LoadModel::told(config),
            half_gap: 0.5 * gap,
        }
    }
}

impl Compensator for Lookup {
    type State = LookupState;

    fn info(&self) -> &'static MethodInfo {
        Self::INFO
    }

    fn initial(&self, motor_position: f64) -> LookupState {
        let mut crossing = self.crossing.initial(motor_position, &self.load);
        // its load is the true one
        crossing.trusts_twin = true;
        LookupState { crossing, since: 0 }
    }

    fn step(&self, state: &mut LookupState, signals: &Signals) -> Correction {
        if let Some(twin) = self.begin(state, signals) {
            twin.step(&signals.reference, &signals.next_reference);
        }
        self.finish(state, signals)
    }

    fn begin<'a>(&'a self, state: &'a mut LookupState, _: &Signals) -> Option<Twinned<'a>> {
        Some(self.crossing.begin(&mut state.crossing, &self.load))
    }

    fn finish(&self, state: &mut LookupState, signals: &Signals) -> Correction {
        let known = !self.after_crossing || state.since >= MET_TICKS;
        let half_gap = if known { self.half_gap } else { 0.0 };
        let before = state.crossing.side;
        let correction = self
            .crossing
            .finish(&mut state.crossing, signals, &self.load, half_gap);
        // the first flank is no change
        let changed = before != 0 && state.crossing.side != before;
        if state.since > 0 || changed {
            state.since = (state.since + 1).min(MET_TICKS);
        }
        correction
    }
}
