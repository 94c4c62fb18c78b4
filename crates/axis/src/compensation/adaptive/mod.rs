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

mod disturbance;
mod knowledge;
mod lanes;
mod learning;
mod reading;
mod window;

use super::crossing::{Crossing, CrossingState};
use super::registry::Registered;
use super::twin::LoadModel;
use super::{Compensator, Correction, Knowledge, MethodInfo, Signals};
use crate::config::AxisConfig;
use disturbance::Disturbance;
use knowledge::Knowledge as Known1;
use lanes::Known;
use learning::LearningState;
use reading::{Prior, Reading};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use window::{Recent, Sample, Tick, Window};

/// Encoder noise that is never undercut, rad.
const LEAST_NOISE: f64 = 5e-7;
/// Torque that nothing models, part of the rated one.
const UNMODELLED: f64 = 3e-3;
/// The gap is used below this doubt.
const SURE: f64 = 0.1;
/// Standard deviation over value that a faint contact adds.
const FAINT: f64 = 0.04;
/// Below it a single reading is enough.
const CLEAR: f64 = 0.03;
/// Torque that can be felt behind the motor, and torque of a flank that is surely pressed, parts of the rated torque.
const FELT: f64 = 3e-3;
const PRESSED: f64 = 0.02;
/// Ticks on the new flank that end a window, and from the change of flank on at least.
const ARRIVED: u32 = 40;
const AT_LEAST: u32 = 160;

/// The method `adaptive`.
#[derive(Clone, Debug)]
pub struct Adaptive {
    crossing: Crossing,
    first: LoadModel,
    known: Known,
    motor_coulomb: f64,
    rated_torque: f64,
}

/// What it has learned.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AdaptiveState {
    crossing: CrossingState,
    load: LoadModel,
    learning: LearningState,
    disturbance: Disturbance,
    recent: Recent,
    window: Option<Window>,
    /// Ticks since the change of flank, and those on the new one.
    since: u32,
    arrived: u32,
    engaged: bool,
    current: f64,
    reading: Option<Reading>,
    gap: Known1,
    clear: bool,
    used: f64,
}

impl Registered for Adaptive {
    const INFO: &'static MethodInfo = &MethodInfo {
        name: "adaptive",
        summary: "learns load and gap from the motor alone and crosses the gap on a planned traverse",
        knows: Knowledge { load_scale: false, gap: false, load: false },
        source: "this project",
    };

    fn from_axis(config: &AxisConfig) -> Adaptive {
        let inertia = config.motor_side_inertia_kgm2();
        let count = config.drive.encoder_counts_per_rev.map_or(0.0, |counts| TAU / f64::from(counts));
        let motor = &config.motor;
        Adaptive {
            crossing: Crossing::new(config, config.compensation.adaptive.torque_share, 0.0),
            first: LoadModel { inertia, viscous: 0.0, coulomb: 0.0, constant: 0.0, ..LoadModel::told(config) },
            known: Known {
                torque_constant: motor.torque_constant_nm_per_a,
                inertia,
                viscous: motor.viscous_nm_s_per_rad,
                noise: (count / 12.0_f64.sqrt()).max(LEAST_NOISE),
                unmodelled: UNMODELLED * motor.rated_torque_nm,
            },
            motor_coulomb: motor.coulomb_nm,
            rated_torque: motor.rated_torque_nm,
        }
    }
}

impl Adaptive {
    /// Torque behind the motor as the motor shows it.
    fn observe(&self, state: &mut AdaptiveState, signals: &Signals) -> f64 {
        let known = &self.known;
        let speed = signals.motor_velocity;
        let friction = known.viscous * speed - state.crossing.twin.motor_friction;
        let mean = signals.mean_current;
        state.disturbance.step(known.torque_constant * mean - friction, known.inertia * speed);
        mean
    }

    /// Ends the window and sets out to read it.
    fn close(&self, state: &mut AdaptiveState, flank: i8) {
        let Some(mut window) = state.window.take() else { return };
        window.close();
        let wavered = window.wavered && state.gap.readings > 0;
        if !state.engaged || wavered || window.side == flank || !state.learning.known || window.side == 0 || state.reading.is_some() {
            return;
        }
        let prior = Prior {
            load: state.load,
            covariance: state.learning.covariance(self.known.inertia, self.rated_torque),
            motor_coulomb: self.motor_coulomb,
            rated_torque: self.rated_torque,
            half_gap: if state.gap.doubt() < SURE { state.gap.value } else { 0.0 },
        };
        state.reading = Some(Reading::new(window, prior));
    }

    fn read(&self, state: &mut AdaptiveState) {
        let Some(reading) = &mut state.reading else { return };
        let Some(said) = reading.work(&self.known) else { return };
        state.reading = None;
        if said.misfit < (0.03 * said.without).max(10.0) && said.variance < 0.04 * said.half_gap * said.half_gap {
            let faint = if said.faint { FAINT * said.half_gap } else { 0.0 };
            state.gap.take(said.half_gap, said.variance + faint * faint);
            state.clear = !said.faint && said.misfit < 3.0 && said.variance < CLEAR * CLEAR * said.half_gap * said.half_gap;
        }
        state.used = if state.gap.doubt() < SURE && (state.clear || state.gap.readings >= if said.faint { 3 } else { 2 }) { state.gap.value } else { 0.0 };
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
            learning: LearningState::new(),
            disturbance: Disturbance::default(),
            recent: Recent::default(),
            window: None,
            since: 0,
            arrived: 0,
            engaged: false,
            current: 0.0,
            reading: None,
            gap: Known1::default(),
            clear: false,
            used: 0.0,
        }
    }

    fn step(&self, state: &mut AdaptiveState, signals: &Signals) -> Correction {
        let (start, side) = (state.crossing.twin, state.crossing.side);
        let crossing = state.crossing.crossing();
        let mean = self.observe(state, signals);
        let sample = Sample { position: signals.motor_position, current: mean, fall: state.current - signals.current, ticks: 1 };
        state.current = signals.current;
        state.recent.push(Tick { sample, seen: state.disturbance.torque, stands: start.plant.load_velocity.abs() <= 0.0 });
        let (seen, wanted, carrying) = (state.disturbance.torque, start.torque, f64::from(side));
        let hangs = seen.abs() < FELT * self.rated_torque;
        state.learning.step(&self.crossing.twin, &start, signals, crossing || hangs, &mut state.load, self.rated_torque);
        let mut correction = self.crossing.step(&mut state.crossing, signals, &state.load, state.used);
        let now = f64::from(state.crossing.side);
        let carries = state.disturbance.torque * now > 0.5 * start.torque * now && start.torque * now > 0.0;
        state.arrived = if carries { (state.arrived + 1).min(ARRIVED) } else { state.arrived.saturating_sub(2) };
        state.since = state.since.saturating_add(1);
        state.engaged |= state.arrived >= ARRIVED;
        if let Some(window) = &mut state.window {
            if !window.push(sample) {
                state.window = None;
            } else if state.since >= AT_LEAST && state.arrived >= ARRIVED {
                let flank = state.crossing.side;
                self.close(state, flank);
            }
        }
        if state.crossing.side != side {
            // a flank that never carried the load was none: the crossing goes on
            if state.engaged || state.window.is_none() {
                self.close(state, side);
                let pressed = seen * carrying > (0.5 * wanted * carrying).max(PRESSED * self.rated_torque);
                state.window = if state.engaged || pressed { Window::new(&state.recent, side) } else { None };
                state.since = 0;
            } else if let Some(window) = &mut state.window {
                window.wavered = true;
            }
            self.read(state);
        correction.gap_angle_estimate =
            if state.gap.readings == 0 { f64::NAN } else { f64::from(state.crossing.side) * state.gap.value };
        if state.learning.known {
            correction.inertia_estimate = self.crossing.twin.motor_inertia() + state.load.inertia;
        }
        correction
    }
}
