//! The axis as it would move without a gap, computed alongside: what its shaft would carry, now and a moment ahead.
//!
//! The drive knows its own loops and its motor's data; the load is described by a [`LoadModel`], told or learned. The twin runs the
//! same cascade on motor, shaft and load, so that what the servo itself does wrong is in it, too: lag without feed-forward, the
//! delay of a reversal against friction. Its shaft torque `T` is what the contact has to carry; the sign of `T` is the
//! flank that has to carry it. One period of the current loop, implicit in the shaft so that no stiffness makes it diverge:
//! ```text
//! r_f = (w_M + h a_M) - (w_L + h a_L)                          (a: accelerations without the shaft, 0 where friction holds)
//! T   = (k (lead + h r_f) + d r_f) / (1 + (h^2 k + h d)(1/J_M + 1/J_L))
//! ```
//! Coulomb friction takes at most the speed that there is; a mass at rest holds until the torque exceeds its friction.

use super::Correction;
use crate::config::AxisConfig;
use crate::plant::{Contact, Friction, Mode, PlantState};
use crate::servo::{Servo, ServoState};
use crate::signal::Reference;
use serde::{Deserialize, Serialize};

/// The load behind the shaft, motor side.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct LoadModel {
    pub(super) inertia: f64,
    pub(super) viscous: f64,
    pub(super) coulomb: f64,
    pub(super) constant: f64,
    pub(super) stiffness: f64,
    pub(super) damping: f64,
}

impl LoadModel {
    /// Torque that it needs to move so, N m; the constant torque alone, within the friction, moves nothing.
    pub(super) fn need(&self, speed: f64, acceleration: f64, standing: f64) -> f64 {
        let sliding = if speed.abs() > standing { self.coulomb * speed.signum() } else { 0.0 };
        self.inertia * acceleration + self.viscous * speed + sliding + self.constant
    }

    /// The load as the description has it.
    pub(super) fn told(config: &AxisConfig) -> LoadModel {
        let load = config.reflected_load();
        LoadModel {
            inertia: load.inertia_kgm2,
            viscous: load.viscous_nm_s_per_rad,
            coulomb: load.coulomb_nm,
            constant: load.constant_nm,
            stiffness: load.stiffness_nm_per_rad,
            damping: load.damping_nm_s_per_rad,
        }
    }
}

/// Motor and drive of the twin.
#[derive(Clone, Debug)]
pub(super) struct Twin {
    servo: Servo,
    period_s: f64,
    torque_constant: f64,
    resistance: f64,
    inductance: f64,
    back_emf: f64,
    inertia: f64,
    viscous: f64,
    coulomb: f64,
}

/// Where the twin is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct TwinState {
    servo: ServoState,
    pub(super) plant: PlantState,
    /// Torque of the shaft on the load, N m.
    pub(super) torque: f64,
    /// Torque of the motor's Coulomb friction on the motor, N m.
    pub(super) motor_friction: f64,
}

impl Twin {
    pub(super) fn new(config: &AxisConfig) -> Twin {
        let mut ideal = config.clone();
        ideal.drive.encoder_counts_per_rev = None;
        let motor = &config.motor;
        Twin {
            servo: Servo::new(&ideal),
            period_s: config.current_period_us() * 1e-6,
            torque_constant: motor.torque_constant_nm_per_a,
            resistance: motor.phase_resistance_ohm(),
            inductance: motor.phase_inductance_h(),
            back_emf: motor.back_emf_v_s_per_rad(),
            inertia: config.motor_side_inertia_kgm2(),
            viscous: motor.viscous_nm_s_per_rad,
            coulomb: motor.coulomb_nm,
        }
    }

    /// Standing still, its shaft and its drive carrying the constant torque that friction cannot hold.
    pub(super) fn initial(&self, position: f64, load: &LoadModel) -> TwinState {
        let held = if load.constant.abs() > load.coulomb { load.constant } else { 0.0 };
        let lead = held / load.stiffness;
        let plant = PlantState {
            current_q: held / self.torque_constant,
            current_d: 0.0,
            gap_angle: lead,
            motor_velocity: 0.0,
            load_velocity: 0.0,
            load_position: position - lead,
            mode: Mode { contact: Contact::Rigid, motor: Friction::None, load: Friction::None },
            events: 0,
            bristles: [0.0; 2],
        };
        TwinState { servo: self.servo.initial(&plant, position), plant, torque: held, motor_friction: 0.0 }
    }

    /// One servo period.
    pub(super) fn step(&self, state: &mut TwinState, reference: &Reference, next: &Reference, load: &LoadModel) {
        self.step_with_gap(state, reference, next, &Correction::NONE, load, 0.0);
    }

    /// One servo period of the axis with a gap and with what a compensator put out.
    pub(super) fn step_with_gap(
        &self,
        state: &mut TwinState,
        reference: &Reference,
        next: &Reference,
        correction: &Correction,
        load: &LoadModel,
        half_gap: f64,
    ) {
        let measured = self.servo.measure(&mut state.servo, &state.plant);
        self.servo.command(&mut state.servo, reference, next, &measured, correction);
        for _ in 0..self.servo.current_steps() {
            let input = self.servo.voltage(&mut state.servo, &state.plant);
            self.advance(state, input.voltage_q, load, half_gap);
        }
    }

    fn advance(&self, state: &mut TwinState, voltage: f64, load: &LoadModel, half_gap: f64) {
        let (x, h) = (&mut state.plant, self.period_s);
        let share = h / self.inductance;
        x.current_q = (x.current_q + share * (voltage - self.back_emf * x.motor_velocity)) / (1.0 + share * self.resistance);
        let drive = self.torque_constant * x.current_q - self.viscous * x.motor_velocity;
        let drag = -load.constant - load.viscous * x.load_velocity;
        let inverse = |inertia: f64, coulomb: f64, speed: f64| if coulomb > 0.0 && speed.abs() <= 0.0 { 0.0 } else { 1.0 / inertia };
        let (of_motor, of_load) =
            (inverse(self.inertia, self.coulomb, x.motor_velocity), inverse(load.inertia, load.coulomb, x.load_velocity));
        let free = x.motor_velocity - x.load_velocity + h * (drive * of_motor - drag * of_load);
        let give = (h * h * load.stiffness + h * load.damping) * (of_motor + of_load);
        let lead = x.gap_angle + h * free;
        let pressed = lead - lead.clamp(-half_gap, half_gap);
        let touches = half_gap <= 0.0 || pressed != 0.0;
        let torque = if touches { (load.stiffness * pressed + load.damping * free) / (1.0 + give) } else { 0.0 };
        let (motor, friction) = slide(x.motor_velocity, h * (drive - torque) / self.inertia, h * self.coulomb / self.inertia);
        let (slid, _) = slide(x.load_velocity, h * (torque + drag) / load.inertia, h * load.coulomb / load.inertia);
        x.motor_velocity = motor;
        x.load_velocity = slid;
        x.gap_angle += h * (motor - slid);
        x.load_position += h * slid;
        state.torque = torque;
        state.motor_friction = friction * self.inertia / h;
    }

    /// Coulomb friction of the motor at a speed, N m against it.
    pub(super) fn motor_coulomb(&self) -> f64 {
        self.coulomb
    }

    /// Torque constant of the motor, N m/A.
    pub(super) fn torque_constant(&self) -> f64 {
        self.torque_constant
    }

    /// Viscous friction of the motor, N m s/rad.
    pub(super) fn motor_viscous(&self) -> f64 {
        self.viscous
    }

    /// Inertia on the motor's side of the gap, kg m2.
    pub(super) fn motor_inertia(&self) -> f64 {
        self.inertia
    }
}

/// Speed after an impulse with friction that takes at most `most`; and what the friction took.
fn slide(speed: f64, gain: f64, most: f64) -> (f64, f64) {
    let free = speed + gain;
    let taken = free.clamp(-most, most);
    // friction acts against the sliding before, so a mass may not come to more than rest within the step
    let stops = speed * (free - taken) < 0.0;
    if stops { (0.0, -free) } else { (free - taken, -taken) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Load;
    use crate::{AxisOutput, Setpoint, build_runner};
    use lostmotion_base::math;

    /// The twin's load beside that of the exact plant without a gap: largest difference, and largest lag of the load behind its reference, rad.
    fn beside_the_plant(coulomb: f64, feedforward: f64) -> [f64; 2] {
        let mut config = AxisConfig::paper().without_gap();
        config.drive.velocity_feedforward = feedforward;
        config.drive.acceleration_feedforward = feedforward;
        config.motor.coulomb_nm = 0.1;
        if let Load::Reflected(load) = &mut config.load {
            load.coulomb_nm = coulomb;
        }
        let at = |t: f64| {
            let (s, c) = math::sin_cos(6.0 * t);
            Setpoint::moving(2.0 - 2.0 * c, 12.0 * s, 72.0 * c)
        };
        let mut runner = build_runner(&config, "none", 0.0).unwrap();
        let mut out = AxisOutput::new(true);
        let points: Vec<Setpoint> = (0..2000).map(|n| at(f64::from(n) * 1e-3)).collect();
        runner.push(&points, &mut out).unwrap();
        let trace = out.trace.unwrap();
        let (twin, load) = (Twin::new(&config), LoadModel::told(&config));
        let mut state = twin.initial(0.0, &load);
        let (mut off, mut lag) = (0.0_f64, 0.0_f64);
        for pair in trace.windows(2) {
            off = off.max((state.plant.load_position - pair[0].load_position).abs());
            lag = lag.max((pair[0].reference.position - pair[0].load_position).abs());
            twin.step(&mut state, &pair[0].reference, &pair[1].reference, &load);
        }
        [off, lag]
    }

    #[test]
    fn it_moves_as_the_exact_plant_without_a_gap() {
        for (coulomb, feedforward) in [(0.0, 0.0), (0.0, 1.0), (1.1, 0.0), (1.1, 1.0)] {
            let [off, lag] = beside_the_plant(coulomb, feedforward);
            assert!(off < 2e-4 && off < 0.06 * lag, "{coulomb} {feedforward}: {off} of {lag} rad");
        }
    }

    #[test]
    fn friction_stops_a_mass_and_then_holds_it() {
        assert_eq!(slide(1.0, 0.0, 0.25), (0.75, -0.25));
        assert_eq!(slide(0.1, 0.0, 0.25).0, 0.0);
        assert_eq!(slide(0.0, 0.2, 0.25), (0.0, -0.2));
        assert_eq!(slide(0.0, -0.3, 0.25).0, -0.3 + 0.25);
    }
}
