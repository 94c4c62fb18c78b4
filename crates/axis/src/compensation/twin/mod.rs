//! The axis as it would move without a gap, computed alongside: what its shaft would carry, now and
//! a moment ahead.
//!
//! The drive knows its own loops and its motor's data; the load is described by a [`LoadModel`],
//! told or learned. The twin runs the same cascade on motor, shaft and load, so that what the servo
//! itself does wrong is in it, too: lag without feed-forward, the delay of a reversal against
//! friction. Its shaft torque `T` is what the contact has to carry; the sign of `T` is the flank
//! that has to carry it. One period of the current loop, implicit in the shaft so that no stiffness
//! makes it diverge:
//! ```text
//! r_f = (w_M + h a_M) - (w_L + h a_L)                          (a: accelerations without the shaft, 0 where friction holds)
//! T   = (k (lead + h r_f) + d r_f) / (1 + (h^2 k + h d)(1/J_M + 1/J_L))
//! ```
//! Coulomb friction takes at most the speed that there is; a mass at rest holds until the torque
//! exceeds its friction.

mod load;
mod numbers;

pub(crate) use load::LoadModel;
pub(crate) use numbers::{MotorNumbers, Rates};

use super::Correction;
use crate::config::AxisConfig;
use crate::plant::{Contact, Friction, Mode, PlantState};
use crate::servo::{Servo, ServoState};
use crate::signal::Reference;
use serde::{Deserialize, Serialize};

/// Motor and drive of the twin.
#[derive(Clone, Debug)]
pub(crate) struct Twin {
    servo: Servo,
    period_s: f64,
    inertia: f64,
    numbers: MotorNumbers,
}

/// Where the twin is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct TwinState {
    pub(crate) servo: ServoState,
    pub(crate) plant: PlantState,
    /// Torque of the shaft on the load, N m.
    pub(crate) torque: f64,
    /// Torque of the motor's Coulomb friction on the motor, N m.
    pub(crate) motor_friction: f64,
}

/// What of the twin's state others look at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Shown {
    pub(super) torque: f64,
    pub(super) motor_friction: f64,
    pub(super) motor_velocity: f64,
    pub(super) load_velocity: f64,
    pub(super) load_position: f64,
}

impl TwinState {
    pub(super) fn shown(&self) -> Shown {
        let TwinState {
            plant,
            torque,
            motor_friction,
            ..
        } = self;
        Shown {
            torque: *torque,
            motor_friction: *motor_friction,
            motor_velocity: plant.motor_velocity,
            load_velocity: plant.load_velocity,
            load_position: plant.load_position,
        }
    }
}

/// A compensator's model of its axis that is about to be stepped, with the load it carries over the
/// tick.
#[derive(Debug)]
pub struct Twinned<'a> {
    pub(crate) twin: &'a Twin,
    pub(crate) state: &'a mut TwinState,
    pub(crate) load: LoadModel,
}

impl Twinned<'_> {
    /// Steps it by a servo period.
    pub(crate) fn step(self, reference: &Reference, next: &Reference) {
        self.twin.step(self.state, reference, next, &self.load);
    }
}

impl Twin {
    pub(super) fn new(config: &AxisConfig) -> Twin {
        let mut ideal = config.clone();
        ideal.drive.encoder_counts_per_rev = None;
        let (inertia, h) = (
            config.motor_side_inertia_kgm2(),
            config.current_period_us() * 1e-6,
        );
        let numbers = MotorNumbers::new(config, inertia, h);
        Twin {
            servo: Servo::new(&ideal),
            period_s: h,
            inertia,
            numbers,
        }
    }

    /// Standing still, its shaft and its drive carrying the constant torque that friction cannot
    /// hold.
    pub(super) fn initial(&self, position: f64, load: &LoadModel) -> TwinState {
        let held = if load.constant.abs() > load.coulomb {
            load.constant
        } else {
            0.0
        };
        let lead = held / load.stiffness;
        let plant = PlantState {
            current_q: held / self.numbers.torque_constant,
            current_d: 0.0,
            gap_angle: lead,
            motor_velocity: 0.0,
            load_velocity: 0.0,
            load_position: position - lead,
            mode: Mode {
                contact: Contact::Rigid,
                motor: Friction::None,
                load: Friction::None,
            },
            events: 0,
            bristles: [0.0; 2],
        };
        TwinState {
            servo: self.servo.initial(&plant, position),
            plant,
            torque: held,
            motor_friction: 0.0,
        }
    }

    /// One servo period.
    pub(crate) fn step(
        &self,
        state: &mut TwinState,
        reference: &Reference,
        next: &Reference,
        load: &LoadModel,
    ) {
        let measured = self.servo.measure(&mut state.servo, &state.plant);
        self.servo.command(
            &mut state.servo,
            reference,
            next,
            &measured,
            &Correction::NONE,
        );
        let rates = self.rates(load);
        for _ in 0..self.servo.current_steps() {
            let input = self.servo.voltage(&mut state.servo, &state.plant);
            self.advance(state, input.voltage_q, &rates);
        }
    }

    /// What stays over a servo period.
    pub(crate) fn rates(&self, load: &LoadModel) -> Rates {
        Rates::new(load, self.period_s)
    }

    #[inline]
    fn advance(&self, state: &mut TwinState, voltage: f64, rates: &Rates) {
        let (x, n, h) = (&mut state.plant, &self.numbers, self.period_s);
        x.current_q = (x.current_q + n.current_share * (voltage - n.back_emf * x.motor_velocity))
            * n.current_keep;
        let drive = n.torque_constant * x.current_q - n.viscous * x.motor_velocity;
        let drag = -rates.load_constant - rates.load_viscous * x.load_velocity;
        let held = |coulomb: f64, speed: f64| coulomb > 0.0 && speed.abs() <= 0.0;
        let of_motor = if held(n.coulomb, x.motor_velocity) {
            0.0
        } else {
            n.inverse_motor
        };
        let of_load = if held(rates.load_coulomb, x.load_velocity) {
            0.0
        } else {
            rates.inverse_load
        };
        let free = x.motor_velocity - x.load_velocity + h * (drive * of_motor - drag * of_load);
        let lead = x.gap_angle + h * free;
        let torque = (rates.stiffness * lead + rates.damping * free)
            / (1.0 + rates.give * (of_motor + of_load));
        let (motor, friction) = slide(
            x.motor_velocity,
            n.motor_step * (drive - torque),
            n.motor_most,
        );
        let (slid, _) = slide(
            x.load_velocity,
            rates.load_step * (torque + drag),
            rates.load_most,
        );
        x.motor_velocity = motor;
        x.load_velocity = slid;
        x.gap_angle += h * (motor - slid);
        x.load_position += h * slid;
        state.torque = torque;
        state.motor_friction = friction * n.friction_scale;
    }

    /// The drive's numbers for a batch; none if it is not a plain one.
    pub(crate) fn servo(&self) -> &Servo {
        &self.servo
    }

    /// The motor's numbers for a batch.
    pub(crate) fn numbers(&self) -> &MotorNumbers {
        &self.numbers
    }

    /// Period of the current loop, s.
    pub(crate) fn period_s(&self) -> f64 {
        self.period_s
    }

    /// Coulomb friction of the motor at a speed, N m against it.
    pub(super) fn motor_coulomb(&self) -> f64 {
        self.numbers.coulomb
    }

    /// Torque constant of the motor, N m/A.
    pub(super) fn torque_constant(&self) -> f64 {
        self.numbers.torque_constant
    }

    /// Viscous friction of the motor, N m s/rad.
    pub(super) fn motor_viscous(&self) -> f64 {
        self.numbers.viscous
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
    // friction acts against the sliding before, so a mass may not come to more than rest within the
    // step
    let stops = speed * (free - taken) < 0.0;
    if stops {
        (0.0, -free)
    } else {
        (free - taken, -taken)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Load;
    use crate::{AxisOutput, Setpoint, build_runner};
    use lostmotion_base::math;

    /// The twin's load beside that of the exact plant without a gap: largest difference, and
    /// largest lag of the load behind its reference, rad.
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
            assert!(
                off < 2e-4 && off < 0.06 * lag,
                "{coulomb} {feedforward}: {off} of {lag} rad"
            );
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
