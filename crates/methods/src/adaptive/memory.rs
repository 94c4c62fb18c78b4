//! What the method knows as a memory, a start from one, and what it shows of its learning.

use super::foresee::Foresee;
use super::learning::{LARGEST_INERTIA, LearningState};
use super::load_filter::LEAST_INERTIA;
use super::said::Said;
use super::trust::Trust;
use super::watch::Watch;
use super::window::Window;
use super::{Adaptive, AdaptiveState, Doubts, Kept, LARGEST_DOUBT, LEAST_EVIDENCE, used_of};
use crate::memory::LARGEST_HALF_GAP_RAD;
use crate::readings::Readings;
use lostmotion_drive::twin::LoadModel;
use lostmotion_drive::{GapReading, Learned, Learning, ReadingVerdict};

/// Standard deviation of what all readings of a gap are off by together, part of it: errors of the
/// model, which no number of readings averages out; where friction holds the load, and where it may
/// float. Measured on the commissioned axes of 96 drawn machines, whose intervals of 95 % hold the gap
/// without it in 82 and 38 %. With it those of 192 axes drawn with another seed do in 97 and 91 %.
const SHARED_ERROR: [f64; 2] = [0.0125, 0.11];

/// That of a half gap, rad.
fn shared_error(half_gap: f64, floats: bool) -> f64 {
    SHARED_ERROR[usize::from(floats)] * half_gap
}

impl Adaptive {
    /// The state before the first tick of an axis whose load and gap are known.
    pub(super) fn remembering(&self, motor_position: f64, learned: &Learned) -> AdaptiveState {
        let (inertia, rated) = (self.motor.inertia, self.motor.rated_torque);
        // within what learning itself can reach
        let load = LoadModel {
            inertia: learned
                .load_inertia_kgm2
                .clamp(LEAST_INERTIA * inertia, LARGEST_INERTIA * inertia),
            viscous: learned.viscous_nm_s_per_rad,
            coulomb: learned.coulomb_nm,
            constant: learned.constant_nm,
            ..self.first
        };
        let half_gap = learned.half_gap_rad;
        // what its readings had for themselves, as it is learned on
        let (whole, shared) = (
            learned.half_gap_deviation_rad,
            shared_error(half_gap, learned.floats),
        );
        let deviation = (whole * whole - shared * shared).max(0.0).sqrt();
        let gap = if half_gap > 0.0 {
            Readings::known(half_gap, deviation * deviation, learned.gap_readings)
        } else {
            Readings::default()
        };
        let nil = learned.gap_readings > 0 && self.is_nil(half_gap, deviation);
        let (used, at_rest) = used_of(&gap, nil);
        let learning = LearningState::known(&load, &learned.covariance(), inertia, rated);
        let mut crossing = self.crossing.initial(motor_position, &load);
        crossing.trusts_twin = learning.is_anchored();
        crossing.engaged = true;
        AdaptiveState {
            crossing,
            learning,
            doubts: Doubts::default(),
            load,
            watch: Watch::default(),
            reading: None,
            read: Window::default(),
            since_reading: 0,
            steady: 0,
            unsure: 0.0,
            last: None,
            used,
            at_rest,
            gap,
            trust: Trust::remembering(!learned.floats, nil),
            foresee: Foresee::at(motor_position),
            kept: Kept::default(),
        }
    }

    /// What is known of load and gap; `None` while the load is unknown.
    pub(super) fn memory(&self, state: &AdaptiveState) -> Option<Learned> {
        if !state.learning.known {
            return None;
        }
        let load = &state.load;
        // a gap too small to matter is known, too
        let (is_read, is_nil) = (state.gap.count > 0, state.trust.nil);
        let floats = !state.trust.is_held();
        let learned = Learned {
            half_gap_rad: if is_read { state.gap.value } else { 0.0 },
            half_gap_deviation_rad: if is_read {
                let shared = shared_error(state.gap.value, floats);
                (state.gap.variance.max(0.0) + shared * shared).sqrt()
            } else if is_nil {
                0.5 * self.negligible
            } else {
                0.0
            },
            gap_readings: state.gap.count.max(u32::from(is_nil)),
            floats,
            load_inertia_kgm2: load.inertia,
            viscous_nm_s_per_rad: load.viscous,
            coulomb_nm: load.coulomb,
            constant_nm: load.constant,
            ..Learned::default()
        };
        let covariance = state
            .learning
            .covariance(self.motor.inertia, self.motor.rated_torque);
        // figures that a drive could not act on are no memory
        Some(learned.with_covariance(&covariance)).filter(|learned| learned.check().is_ok())
    }

    /// What is known and used now.
    pub(super) fn knowledge(&self, state: &AdaptiveState) -> Learning {
        Learning {
            learned: self.memory(state),
            used_half_gap_rad: self.now_used(state).resting,
            share: state.trust.share(),
            foresees: state.trust.foresees(),
            allowed: state.trust.allowed(),
            reading: state.last,
        }
    }

    /// A reading for traces; `sharp`: sharp enough for a wavering flank, and the inertia known for it.
    pub(super) fn reported(
        &self,
        before: Option<GapReading>,
        said: &Said,
        sharp: bool,
    ) -> GapReading {
        let verdict = if said.evidence <= LEAST_EVIDENCE {
            ReadingVerdict::NoContact
        } else if said.half_gap >= LARGEST_HALF_GAP_RAD {
            ReadingVerdict::TooLarge
        } else if said.wavered && !sharp {
            ReadingVerdict::Wavering
        } else if self.counts(said) {
            ReadingVerdict::Counts
        } else if said.variance.sqrt() >= LARGEST_DOUBT * said.half_gap {
            ReadingVerdict::Vague
        } else {
            ReadingVerdict::Unexplained
        };
        GapReading {
            number: before.map_or(1, |reading| reading.number.saturating_add(1)),
            half_gap_rad: said.half_gap,
            deviation_rad: if said.variance.is_finite() {
                said.variance.sqrt()
            } else {
                0.0
            },
            verdict,
        }
    }
}
