//! The predicted flank with the gap that an offline fit found.
//!
//! As `lookup`, whose equations it shares (`crossing`, `traverse`, `twin`), with one difference:
//! the gap is never the machine's true one. It is what a fit of a log told
//! (`compare --fitted AXIS=FILE.json`, or `fitted_lookup.gap` of the machine file), so the result
//! holds what the fit got wrong. The load's inertia and friction are those that a fit of the motor
//! alone found along with it (`fitted_lookup.load`), or else those of the description; the shaft
//! and a weight that turns with the load are always those of the description.
//!
//! **An axis that no fit was given for is left as it is.** `compare` says so.
//!
//! Signals: reference, next reference (rad, rad/s, rad/s2). Tunables: fitted total gap (um, mdeg or
//! motor rad), fitted load (SI at the motor), part of the drive's torque for a traverse (0 to 1).
//! Fails: as `lookup`; an error of the fit stays in full, and a gap that changed since the log was
//! taken, too. Source: as `lookup`; the fit: this project, crate `lostmotion-identify`.

use crate::AxisConfig;
use crate::crossing::{Crossing, CrossingState};
use crate::registry::Registered;
use lostmotion_drive::twin::LoadModel;
use lostmotion_drive::{Compensator, Correction, Knowledge, MethodInfo, Signals};

/// The method `fitted-lookup`.
#[derive(Clone, Debug)]
pub struct FittedLookup {
    crossing: Crossing,
    load: LoadModel,
    half_gap: Option<f64>,
}

/// Its twin and where its traverse is.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(transparent)]
pub struct FittedLookupState(CrossingState);

impl Registered for FittedLookup {
    const INFO: &'static MethodInfo = &MethodInfo {
        name: "fitted-lookup",
        summary: "gap from an offline fit, crossed on a planned traverse where the torque that the load needs changes sign",
        knows: Knowledge {
            load_scale: false,
            gap: true,
            load: true,
        },
        source: "flank by torque sign after Gan, Wang, Huang, Machines 2023, 11(2), 193; gap by convex fit",
    };

    fn from_axis(config: &AxisConfig) -> FittedLookup {
        let settings = &config.compensation.fitted_lookup;
        let half_gap = settings
            .gap
            .map(|told| 0.5 * told.motor_rad(&config.transmission));
        let mut load = LoadModel::told(config);
        if let Some(fitted) = settings.load {
            (load.inertia, load.viscous) = (fitted.inertia_kgm2, fitted.viscous_nm_s_per_rad);
            (load.coulomb, load.constant) = (fitted.coulomb_nm, fitted.constant_nm);
        }
        FittedLookup {
            crossing: Crossing::new(config, settings.torque_share, 0.0).with_weight(config),
            load,
            half_gap,
        }
    }
}

impl Compensator for FittedLookup {
    type State = FittedLookupState;

    fn info(&self) -> &'static MethodInfo {
        Self::INFO
    }

    fn initial(&self, motor_position: f64) -> FittedLookupState {
        FittedLookupState(self.crossing.initial(motor_position, &self.load))
    }

    fn step(&self, state: &mut FittedLookupState, signals: &Signals) -> Correction {
        match self.half_gap {
            Some(half_gap) => self
                .crossing
                .step(&mut state.0, signals, &self.load, half_gap),
            None => Correction::NONE,
        }
    }
}
