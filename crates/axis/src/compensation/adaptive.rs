//! Ours: learns load and gap from the motor alone, predicts the flank, crosses the gap on a planned traverse.
//!
//! 1. Load: inertia, viscous and Coulomb friction and constant torque from what the motor gives beyond its own need (`learning`).
//! 2. Flank: the sign of the torque in the shaft of a gapless twin that carries this load (`twin`, `crossing`).
//! 3. Gap: at each change of flank what the drive did is recorded, and afterwards run again on the twin with gaps of many sizes (`replay`).
//!    The median of the last five readings is the gap; every reading stands by itself, so nothing drifts.
//! 4. Crossing: on the planned traverse of `crossing`, as `lookup` does that is told everything.
//!
//! It does nothing until it is sure. A reading counts where the gap explains the motor's motion (what stays unexplained is a tenth of what no gap
//! leaves, and a gap a tenth larger or smaller leaves twice as much power), where the motion stands out from the encoder's
//! steps, where the learned friction has come to rest, and where something holds the load: friction of 0.5 % of the rated torque, or a torque
//! that stands out from the encoder's noise. The gap is used once two readings in a row agree within a tenth; two readings that do not
//! count end its use, and every such end doubles the number of readings for the next.
//!
//! Signals: references, motor position (rad), current (A). It knows what a drive is set up with: its own loops, the motor's data sheet (K_t, R, L,
//! rotor inertia and friction, screw or pinion with it), stiffness and damping of the shaft. It is told neither gap nor load inertia nor load
//! friction; the inertia that the drive uses for its feed-forward, right or wrong, enters only as that gain.
//! Tunables: part of the drive's torque for a traverse (0 to 1).
//!
//! Fails: where a load without friction is accelerated so gently, or seen through so coarse an encoder, that nothing of the above shows: it then
//! does nothing. A crossing that takes longer than the 400 ms of a record is not read, so that a large gap at the slowest feeds is learned only in a
//! faster motion. A stiffness that is wrong by a tenth makes the gap wrong by the same part of the wind-up. Load that changes within seconds, and
//! cutting forces, delay or end its use. Its state holds a record of up to 90 kB.
//! Source: this project; the question (gap, load inertia and friction unknown, motor signals only) is that of Gan, Wang, Huang, Machines 2023, 11(2), 193.

use super::crossing::{Crossing, CrossingState};
use super::learning::LearningState;
use super::registry::Registered;
use super::replay::{Reading, Record};
use super::twin::LoadModel;
use super::{Compensator, Correction, Knowledge, MethodInfo, Signals};
use crate::config::AxisConfig;
use lostmotion_base::Clock;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Unexplained over explained amplitude at most.
const EXPLAINED: f64 = 0.1;
/// Power that a gap a tenth beside has to leave over that of the best.
const SHARP: f64 = 2.0;
/// Power of the motion over that of the encoder's rounding.
const VISIBLE: f64 = 16.0;
/// Encoder noise that is never undercut, rad2.
const LEAST_NOISE: f64 = 1e-14;
/// Change of the learned friction from crossing to crossing, over the largest torque.
const AT_REST: f64 = 0.01;
/// Friction that holds a load, as part of the rated torque.
const HELD: f64 = 5e-3;
/// Torque that holds a load, over that of one encoder count of acceleration.
const HEAVY: f64 = 3.0;
/// Readings of which the median is taken; how near counts as agreeing; readings for the first use and at most.
const READINGS: usize = 5;
const NEAR: f64 = 0.1;
const FIRST_NEED: u32 = 2;
const MOST_NEED: u32 = 64;

/// The method `adaptive`.
#[derive(Clone, Debug)]
pub struct Adaptive {
    crossing: Crossing,
    first: LoadModel,
    /// Mean square of the encoder's rounding, rad2.
    noise: f64,
    held: f64,
    heavy: f64,
}

/// What it has learned.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AdaptiveState {
    crossing: CrossingState,
    load: LoadModel,
    learning: LearningState,
    record: Option<Record>,
    /// Largest torque since the last change of flank, and between that and the one before, N m.
    peak: [f64; 2],
    /// Coulomb friction and constant torque at the last change of flank, N m.
    friction: [f64; 2],
    /// Half gaps, oldest first, rad.
    readings: Vec<f64>,
    half_gap: f64,
    used: f64,
    counting: u32,
    failing: u32,
    needed: u32,
}

impl Registered for Adaptive {
    const INFO: &'static MethodInfo = &MethodInfo {
        name: "adaptive",
        summary: "learns load and gap from the motor alone and crosses the gap on a planned traverse",
        knows: Knowledge { load_scale: false, gap: false, load: false },
        source: "this project",
    };

    fn from_axis(config: &AxisConfig) -> Adaptive {
        let period = Clock::SERVO.period_s();
        let inertia = config.motor_side_inertia_kgm2();
        let count = config.drive.encoder_counts_per_rev.map_or(0.0, |counts| TAU / f64::from(counts));
        Adaptive {
            crossing: Crossing::new(config, config.compensation.adaptive.torque_share, 0.0),
            first: LoadModel { inertia, viscous: 0.0, coulomb: 0.0, constant: 0.0, ..LoadModel::told(config) },
            noise: (count * count / 12.0).max(LEAST_NOISE),
            held: HELD * config.motor.rated_torque_nm,
            heavy: HEAVY * inertia * count / (period * period),
        }
    }
}

impl Adaptive {
    /// Ends the record and takes up what it says.
    fn read(&self, state: &mut AdaptiveState) {
        let friction = [state.load.coulomb, state.load.constant];
        let change: f64 = friction.iter().zip(state.friction).map(|(now, before)| (now - before).abs()).sum();
        state.friction = friction;
        let Some(record) = state.record.take() else { return };
        if !state.learning.known || !record.readable() || change > AT_REST * state.peak[1] {
            return;
        }
        let guess = (state.readings.len() >= 2).then_some(state.half_gap);
        let reading = record.read(&self.crossing.twin, &state.load, guess);
        if !self.counts(&reading) {
            state.fail();
        } else if state.load.coulomb >= self.held || state.peak[1] >= self.heavy {
            state.take(reading.half_gap);
        }
    }

    fn counts(&self, reading: &Reading) -> bool {
        let explained = reading.misfit.sqrt() < EXPLAINED * reading.without.sqrt() + 1.5 * self.noise.sqrt();
        explained && reading.beside > SHARP * reading.misfit && reading.without > VISIBLE * self.noise
    }
}

impl AdaptiveState {
    fn fail(&mut self) {
        self.failing += 1;
        if self.used <= 0.0 {
            self.forget();
        } else if self.failing >= 2 {
            self.needed = (2 * self.needed).min(MOST_NEED);
            self.forget();
        }
    }

    fn take(&mut self, half_gap: f64) {
        self.failing = 0;
        self.counting = self.counting.saturating_add(1);
        if self.readings.len() >= READINGS {
            self.readings.remove(0);
        }
        self.readings.push(half_gap);
        let mut sorted = self.readings.clone();
        sorted.sort_by(f64::total_cmp);
        self.half_gap = sorted[sorted.len() / 2];
        let near = sorted.iter().filter(|reading| (**reading / self.half_gap - 1.0).abs() < NEAR).count();
        if self.counting >= self.needed && near >= 2 && 2 * near > sorted.len() {
            self.used = self.half_gap;
        } else if sorted.len() >= READINGS && 2 * near <= sorted.len() {
            self.forget();
        }
    }

    fn forget(&mut self) {
        self.used = 0.0;
        self.counting = 0;
        self.readings.clear();
    }
}

impl Compensator for Adaptive {
    type State = AdaptiveState;

    fn info(&self) -> &'static MethodInfo {
        Self::INFO
    }

    fn initial(&self, motor_position: f64) -> AdaptiveState {
        AdaptiveState {
            crossing: self.crossing.initial(motor_position, &self.first),
            load: self.first,
            learning: LearningState::default(),
            record: None,
            peak: [0.0; 2],
            friction: [0.0; 2],
            readings: Vec::with_capacity(READINGS),
            half_gap: 0.0,
            used: 0.0,
            counting: 0,
            failing: 0,
            needed: FIRST_NEED,
        }
    }

    fn step(&self, state: &mut AdaptiveState, signals: &Signals) -> Correction {
        let (start, side, offset) = (state.crossing.twin, state.crossing.side, state.crossing.offset());
        let crossing = state.crossing.crossing();
        state.learning.step(&self.crossing.twin, &start, signals, crossing, &mut state.load);
        let mut correction = self.crossing.step(&mut state.crossing, signals, &state.load, state.used);
        state.peak[0] = state.peak[0].max(start.torque.abs());
        if state.crossing.side != side {
            state.peak = [0.0, state.peak[0]];
            self.read(state);
            state.record = Some(Record::new(start, side, offset));
        }
        if let Some(record) = &mut state.record {
            record.push(signals.reference, &correction, signals.motor_position);
            if record.full() {
                self.read(state);
            }
        }
        if state.readings.is_empty() {
            correction.gap_angle_estimate = f64::NAN;
        } else {
            correction.gap_angle_estimate = f64::from(state.crossing.side) * state.half_gap;
        }
        if state.learning.known {
            correction.inertia_estimate = self.crossing.twin.motor_inertia() + state.load.inertia;
        }
        correction
    }
}
