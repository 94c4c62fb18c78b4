//! A compensator with the shaft's estimator beside it: the corrections are the compensator's own,
//! bit by bit; only the estimates of stiffness and damping are added.

use crate::AxisConfig;
use crate::shaft::{ShaftEstimator, ShaftState};
use lostmotion_drive::{Compensator, Correction, MethodInfo, Signals, Twinned};
use serde::{Deserialize, Serialize};

/// A compensator and an observer of its axis' shaft.
#[derive(Clone, Debug)]
pub struct Observed<C> {
    compensator: C,
    shaft: ShaftEstimator,
    motor_inertia: f64,
}

/// The compensator's state and the estimator's.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ObservedState<S> {
    compensator: S,
    shaft: ShaftState,
}

impl<C: Compensator> Observed<C> {
    /// On an axis whose description has been checked.
    pub fn new(compensator: C, config: &AxisConfig) -> Observed<C> {
        Observed {
            compensator,
            shaft: ShaftEstimator::new(config),
            motor_inertia: config.motor_side_inertia_kgm2(),
        }
    }
}

impl<C: Compensator> Observed<C> {
    /// Adds the estimates of stiffness and damping to a correction.
    fn watch(
        &self,
        state: &mut ShaftState,
        signals: &Signals,
        correction: Correction,
    ) -> Correction {
        // a method that learns the load reports the inertia of motor and load together
        let learned = correction.inertia_estimate - self.motor_inertia;
        let load_inertia = (C::LEARNS_LOAD && learned > 0.0).then_some(learned);
        // the estimator only listens: the correction goes on unchanged but for two estimates
        let found = self.shaft.step(state, signals, load_inertia);
        Correction {
            stiffness_estimate: found.stiffness_nm_per_rad,
            damping_estimate: found.damping_nm_s_per_rad,
            ..correction
        }
    }
}

impl<C: Compensator> Compensator for Observed<C> {
    type State = ObservedState<C::State>;

    const LEARNS_LOAD: bool = C::LEARNS_LOAD;

    fn info(&self) -> &'static MethodInfo {
        self.compensator.info()
    }

    fn initial(&self, motor_position: f64) -> Self::State {
        ObservedState {
            compensator: self.compensator.initial(motor_position),
            shaft: ShaftState::default(),
        }
    }

    fn step(&self, state: &mut Self::State, signals: &Signals) -> Correction {
        let correction = self.compensator.step(&mut state.compensator, signals);
        self.watch(&mut state.shaft, signals, correction)
    }

    fn begin<'a>(&'a self, state: &'a mut Self::State, signals: &Signals) -> Option<Twinned<'a>> {
        self.compensator.begin(&mut state.compensator, signals)
    }

    fn finish(&self, state: &mut Self::State, signals: &Signals) -> Correction {
        let correction = self.compensator.finish(&mut state.compensator, signals);
        self.watch(&mut state.shaft, signals, correction)
    }
}
