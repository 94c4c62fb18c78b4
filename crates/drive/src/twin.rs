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

use crate::config::AxisConfig;
use crate::plant::{Contact, Friction, Mode, PlantState};
use crate::servo::{Servo, ServoState};
use crate::signal::{Correction, Reference};
use serde::{Deserialize, Serialize};

/// Motor and drive of the twin.
#[derive(Clone, Debug)]
pub struct Twin {
    servo: Servo,
    period_s: f64,
    inertia: f64,
    numbers: MotorNumbers,
}

/// Where the twin is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TwinState {
    /// Its drive.
    pub servo: ServoState,
    /// Its motor and load.
    pub plant: PlantState,
    /// Torque of the shaft on the load, N m.
    pub torque: f64,
    /// Torque of the motor's Coulomb friction on the motor, N m.
    pub motor_friction: f64,
}

/// What of the twin's state others look at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Shown {
    /// Torque of the shaft on the load, N m.
    pub torque: f64,
    /// Torque of the motor's Coulomb friction on the motor, N m.
    pub motor_friction: f64,
    /// Speed of the motor, rad/s.
    pub motor_velocity: f64,
    /// Speed of the load, rad/s.
    pub load_velocity: f64,
    /// Position of the load, rad.
    pub load_position: f64,
}

impl TwinState {
    /// What of it others look at.
    pub fn shown(&self) -> Shown {
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
    /// The model.
    pub twin: &'a Twin,
    /// Where it is.
    pub state: &'a mut TwinState,
    /// The load it carries over the tick.
    pub load: LoadModel,
}

impl Twinned<'_> {
    /// Steps it by a servo period.
    pub fn step(self, reference: &Reference, next: &Reference) {
        self.twin.step(self.state, reference, next, &self.load);
    }
}

impl Twin {
    /// The motor and the drive of an axis, with an ideal encoder.
    pub fn new<C: Clone>(config: &AxisConfig<C>) -> Twin {
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
    pub fn initial(&self, position: f64, load: &LoadModel) -> TwinState {
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
    pub fn step(
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
    pub fn motor_coulomb(&self) -> f64 {
        self.numbers.coulomb
    }

    /// Torque constant of the motor, N m/A.
    pub fn torque_constant(&self) -> f64 {
        self.numbers.torque_constant
    }

    /// Viscous friction of the motor, N m s/rad.
    pub fn motor_viscous(&self) -> f64 {
        self.numbers.viscous
    }

    /// Inertia on the motor's side of the gap, kg m2.
    pub fn motor_inertia(&self) -> f64 {
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

/// The load behind the shaft, motor side.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LoadModel {
    /// Inertia, kg m2.
    pub inertia: f64,
    /// Viscous friction, N m s/rad.
    pub viscous: f64,
    /// Coulomb friction, N m.
    pub coulomb: f64,
    /// Constant torque against the positive direction, N m.
    pub constant: f64,
    /// Stiffness of the shaft, N m/rad.
    pub stiffness: f64,
    /// Damping of the shaft, N m s/rad.
    pub damping: f64,
}

impl LoadModel {
    /// Torque that it needs to move so, N m; the constant torque alone, within the friction, moves
    /// nothing.
    pub fn need(&self, speed: f64, acceleration: f64, standing: f64) -> f64 {
        let sliding = if speed.abs() > standing {
            self.coulomb * speed.signum()
        } else {
            0.0
        };
        self.inertia * acceleration + self.viscous * speed + sliding + self.constant
    }

    /// The load as the description has it.
    pub fn told<C>(config: &AxisConfig<C>) -> LoadModel {
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

/// What the motor's equations compute with, over a period `h` of the current loop.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MotorNumbers {
    /// `h/L` and `1/(1 + R h/L)`.
    pub(crate) current_share: f64,
    pub(crate) current_keep: f64,
    pub(crate) back_emf: f64,
    pub(crate) torque_constant: f64,
    pub(crate) viscous: f64,
    pub(crate) coulomb: f64,
    /// `1/J_M`, `h/J_M`, what friction takes of the speed in a period, and the torque for it:
    /// `J_M/h`.
    pub(crate) inverse_motor: f64,
    pub(crate) motor_step: f64,
    pub(crate) motor_most: f64,
    pub(crate) friction_scale: f64,
}

/// What the load's equations compute with, as long as the load stays.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rates {
    pub(crate) load_constant: f64,
    pub(crate) load_viscous: f64,
    pub(crate) load_coulomb: f64,
    pub(crate) inverse_load: f64,
    pub(crate) load_step: f64,
    pub(crate) load_most: f64,
    pub(crate) stiffness: f64,
    pub(crate) damping: f64,
    pub(crate) give: f64,
}

impl MotorNumbers {
    fn new<C>(config: &AxisConfig<C>, inertia: f64, h: f64) -> MotorNumbers {
        let motor = &config.motor;
        let share = h / motor.phase_inductance_h();
        MotorNumbers {
            current_share: share,
            current_keep: 1.0 / (1.0 + share * motor.phase_resistance_ohm()),
            back_emf: motor.back_emf_v_s_per_rad(),
            torque_constant: motor.torque_constant_nm_per_a,
            viscous: motor.viscous_nm_s_per_rad,
            coulomb: motor.coulomb_nm,
            inverse_motor: 1.0 / inertia,
            motor_step: h / inertia,
            motor_most: h / inertia * motor.coulomb_nm,
            friction_scale: inertia / h,
        }
    }
}

impl Rates {
    #[inline]
    fn new(load: &LoadModel, h: f64) -> Rates {
        let inverse = 1.0 / load.inertia;
        Rates {
            load_constant: load.constant,
            load_viscous: load.viscous,
            load_coulomb: load.coulomb,
            inverse_load: inverse,
            load_step: h * inverse,
            load_most: h * inverse * load.coulomb,
            stiffness: load.stiffness,
            damping: load.damping,
            give: h * h * load.stiffness + h * load.damping,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn friction_stops_a_mass_and_then_holds_it() {
        assert_eq!(slide(1.0, 0.0, 0.25), (0.75, -0.25));
        assert_eq!(slide(0.1, 0.0, 0.25).0, 0.0);
        assert_eq!(slide(0.0, 0.2, 0.25), (0.0, -0.2));
        assert_eq!(slide(0.0, -0.3, 0.25).0, -0.3 + 0.25);
    }
}
