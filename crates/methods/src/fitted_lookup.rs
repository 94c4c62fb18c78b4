//! The predicted flank of `lookup` with the gap that an offline fit of a log found.
//!
//! Law: as `lookup` (`crossing`, `traverse`, twin). The gap is never the machine's true one, so
//! that the result shows what the fit got wrong: it comes from `--fitted AXIS=FILE.json` or from
//! `fitted_lookup.gap` of the machine file. A fit of the motor's signals alone also gives the
//! load's inertia and friction (`fitted_lookup.load`); otherwise those of the description are used.
//! Shaft and weight are always those of the description.
//!
//! **An axis without a fit is left uncompensated**, and the comparison says so.
//!
//! Signals: reference, next reference (rad, rad/s, rad/s2). Settings: fitted total gap (um, mdeg or
//! motor rad), fitted load (SI at the motor), part of the drive's torque for a traverse (0 to 1).
//!
//! Fails: as `lookup`; an error of the fit stays in full, and so does a change of the gap since the
//! log was recorded. Source: as `lookup`; the fit is this project's, crate `lostmotion-identify`.

use crate::AxisConfig;
use crate::crossing::{Crossing, CrossingState, TORQUE_SHARE};
use crate::registry::{Registered, Settings, told};
use lostmotion_drive::config::check::{AxisConfigError, between, finite, not_negative, positive};
use lostmotion_drive::config::{Gap, Transmission};
use lostmotion_drive::twin::LoadModel;
use lostmotion_drive::{Compensator, Correction, Knowledge, MethodInfo, Signals};
use serde::{Deserialize, Serialize};

/// A load as a fit of the motor's signals found it, at the motor's shaft.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ToldLoad {
    /// Inertia, kg m2.
    pub inertia_kgm2: f64,
    /// Viscous friction, N m s/rad.
    pub viscous_nm_s_per_rad: f64,
    /// Coulomb friction, N m.
    pub coulomb_nm: f64,
    /// Constant torque against the positive direction, N m.
    pub constant_nm: f64,
}

impl ToldLoad {
    fn check(&self) -> Result<(), AxisConfigError> {
        positive("inertia_kgm2", self.inertia_kgm2)?;
        not_negative("viscous_nm_s_per_rad", self.viscous_nm_s_per_rad)?;
        not_negative("coulomb_nm", self.coulomb_nm)?;
        finite("constant_nm", self.constant_nm)
    }
}

/// Settings of `fitted-lookup`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FittedLookupSettings {
    /// Total gap that a fit found; without one the axis is left as it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gap: Option<Gap>,
    /// Inertia and friction that it found; those of the description if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub load: Option<ToldLoad>,
    /// Part of the drive's largest torque that a traverse of the gap may take, 0 to 1.
    pub torque_share: f64,
}

impl Default for FittedLookupSettings {
    fn default() -> FittedLookupSettings {
        FittedLookupSettings {
            gap: None,
            load: None,
            torque_share: TORQUE_SHARE,
        }
    }
}

impl Settings for FittedLookupSettings {
    fn check(&self, transmission: &Transmission) -> Result<(), AxisConfigError> {
        told("gap", self.gap, transmission)?;
        self.load
            .map_or(Ok(()), |load| load.check().map_err(|e| e.within("load")))?;
        between("torque_share", self.torque_share, 0.01, 1.0)
    }

    fn gaps(&mut self) -> Vec<&mut Option<Gap>> {
        vec![&mut self.gap]
    }
}

/// The method `fitted-lookup`.
#[derive(Clone, Debug)]
pub struct FittedLookup {
    crossing: Crossing,
    load: LoadModel,
    half_gap: Option<f64>,
}

/// State of its twin and of its traverse.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
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

    const NEEDS_FIT: bool = true;

    fn from_axis(config: &AxisConfig) -> FittedLookup {
        let settings = &config.compensation.fitted_lookup;
        let half_gap = settings
            .gap
            .map(|told| 0.5 * told.motor_rad(&config.transmission));
        // shaft and weight of the description, inertia and friction of the fit where it found them
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
        // without a fit there is nothing to cross
        match self.half_gap {
            Some(half_gap) => self
                .crossing
                .step(&mut state.0, signals, &self.load, half_gap),
            None => Correction::NONE,
        }
    }
}
