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
//! T   = (k (lead + h r_f) + d r_f) / (1 + g (1/J_M + 1/J_L))   (g = h^2 k + h d; 1/J is 0 where friction holds)
//!     = (k lead + (h k + d)(w_M - w_L) + g (a_M - a_L)) / (1 + g (1/J_M + 1/J_L))
//! ```
//! Coulomb friction takes at most the speed that there is; a mass at rest holds until the torque
//! exceeds its friction. The quotient has four values, one for each of who holds, and is taken once
//! in a servo period; sums are ordered so that what comes late in a period is added last.

use crate::config::AxisConfig;
use crate::number::numbers;
use crate::plant::{Contact, Friction, Mode, PlantState};
use crate::servo::{Servo, ServoState};
use crate::signal::{Correction, Reference};
use lostmotion_base::Number;
use serde::{Deserialize, Serialize};

/// Motor and drive of the twin.
#[derive(Clone, Debug)]
pub struct Twin {
    servo: Servo,
    period_s: f64,
    inertia: f64,
    numbers: MotorNumbers<f64>,
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
    /// The load it carries over the tick,
    pub load: &'a LoadModel,
    /// and the torque of its weight where it is, against the positive direction, N m.
    pub weight: f64,
}

impl Twinned<'_> {
    /// Steps it by a servo period.
    pub fn step(self, reference: &Reference, next: &Reference) {
        let load = self.weighed();
        self.twin.step(self.state, reference, next, &load);
    }

    /// The load with its weight.
    #[inline]
    pub(crate) fn weighed(&self) -> LoadModel {
        LoadModel {
            constant: self.load.constant + self.weight,
            ..*self.load
        }
    }
}

impl Twin {
    /// The motor and the drive of an axis, with an ideal encoder.
    pub fn new<C: Clone>(config: &AxisConfig<C>) -> Twin {
        let mut ideal = config.clone();
        // the model reads its own motor, without counts
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
        // a constant torque beyond friction hangs on the shaft
        let held = if load.constant.abs() > load.coulomb {
            load.constant
        } else {
            0.0
        };
        // the shaft is wound up by what it carries, so the load stands off the motor
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
        // a drive's mean current is of one servo period
        state.servo.current.sum = 0.0;
        // the axis' own cascade, uncorrected
        let measured = self.servo.measure(&mut state.servo, &state.plant);
        self.servo.command(
            &mut state.servo,
            reference,
            next,
            &measured,
            &Correction::NONE,
        );
        // the load stays as it is over the servo period
        let rates = self.rates(load);
        for _ in 0..self.servo.current_steps() {
            let input = self.servo.voltage(&mut state.servo, &state.plant);
            self.advance(state, input.voltage_q, &rates);
        }
    }

    /// What stays over a servo period.
    pub(crate) fn rates(&self, load: &LoadModel) -> Rates<f64> {
        Rates::new(load, self.numbers.motor_step, self.period_s)
    }

    #[inline]
    fn advance(&self, state: &mut TwinState, voltage: f64, rates: &Rates<f64>) {
        let x = &mut state.plant;
        let (masses, torques) = self
            .numbers
            .advance(rates, &x.masses(), self.period_s, voltage);
        x.take(&masses);
        state.torque = torques.shaft;
        state.motor_friction = torques.motor_friction;
    }

    /// Its drive.
    pub(crate) fn servo(&self) -> &Servo {
        &self.servo
    }

    /// The motor's numbers for a batch.
    pub(crate) fn numbers(&self) -> &MotorNumbers<f64> {
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

numbers! {
    /// What the motor's equations compute with, over a period h of the current loop.
    MotorNumbers {
        /// Part of the current that a period leaves, 1/(1 + R h/L).
        current_keep,
        /// Current that a voltage adds in a period, A/V.
        current_gain,
        /// Current that the motor's speed takes in a period, A s/rad.
        current_brake,
        /// N m/A.
        torque_constant,
        /// N m s/rad.
        viscous,
        /// Torque that the motor's speed takes, by the current that it takes and by viscous friction, N m s/rad.
        brake,
        /// N m.
        coulomb,
        /// h/J_M.
        motor_step,
        /// What Coulomb friction takes of the speed in a period, rad/s.
        motor_most,
        /// J_M/h: the torque for a change of speed.
        friction_scale,
    }
}

numbers! {
    /// What the load's equations compute with, as long as the load stays the same.
    Rates {
        /// N m.
        load_constant,
        /// N m s/rad.
        load_viscous,
        /// N m.
        load_coulomb,
        /// h/J_L.
        load_step,
        /// What Coulomb friction takes of the speed in a period, rad/s.
        load_most,
        /// N m/rad.
        stiffness,
        /// h k + d: the torque of the shaft for a speed of its ends against each other, N m s/rad.
        by_rate,
        /// g/J_M: its torque for one on the motor.
        by_motor,
        /// g/J_L: its torque for one on the load.
        by_load,
        /// Part of it that is left where its ends give way to it: both,
        both_give,
        /// the motor alone,
        motor_gives,
        /// the load alone.
        load_gives,
    }
}

numbers! {
    /// Where motor, shaft and load of a twin are.
    TwinMasses {
        /// i_q, A.
        current,
        /// Angle of the motor ahead of the load, rad.
        lead,
        /// Speed of the motor, rad/s.
        motor,
        /// Speed of the load, rad/s.
        load,
        /// Position of the load, rad.
        place,
    }
}

impl PlantState {
    /// Where a twin is that keeps its state as a plant's.
    #[inline]
    pub(crate) fn masses(&self) -> TwinMasses<f64> {
        TwinMasses {
            current: self.current_q,
            lead: self.gap_angle,
            motor: self.motor_velocity,
            load: self.load_velocity,
            place: self.load_position,
        }
    }

    /// Puts it there.
    #[inline]
    pub(crate) fn take(&mut self, masses: &TwinMasses<f64>) {
        self.current_q = masses.current;
        self.gap_angle = masses.lead;
        self.motor_velocity = masses.motor;
        self.load_velocity = masses.load;
        self.load_position = masses.place;
    }
}

/// Torques in a period, N m.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TwinTorques<N> {
    /// Of the shaft on the load.
    pub(crate) shaft: N,
    /// Of the motor's Coulomb friction on the motor.
    pub(crate) motor_friction: N,
}

impl<N: Number> MotorNumbers<N> {
    /// One period h of the current loop with a held voltage: see the head of this file.
    #[inline(always)]
    pub(crate) fn advance(
        &self,
        rates: &Rates<N>,
        x: &TwinMasses<N>,
        h: N,
        voltage: N,
    ) -> (TwinMasses<N>, TwinTorques<N>) {
        let (zero, one) = (h.zero(), h.constant(1.0));
        // the winding, implicit in the current, and the motor's torque with it
        let pushed = self.current_keep * x.current + self.current_gain * voltage;
        let current = pushed - self.current_brake * x.motor;
        let drive = self.torque_constant * pushed - self.brake * x.motor;
        let drag = -rates.load_constant - rates.load_viscous * x.load;
        // friction that holds a mass at rest takes whatever torque the shaft puts on it
        let holds = |coulomb: N, speed: N| zero.less(coulomb) & speed.abs().at_most(zero);
        let (motor_holds, load_holds) = (
            holds(self.coulomb, x.motor),
            holds(rates.load_coulomb, x.load),
        );
        let by_motor = N::choose(motor_holds, zero, rates.by_motor);
        let by_load = N::choose(load_holds, zero, rates.by_load);
        let left = N::choose(
            motor_holds,
            N::choose(load_holds, one, rates.load_gives),
            N::choose(load_holds, rates.motor_gives, rates.both_give),
        );
        // the shaft's torque, implicit in the ends' accelerations
        let wound = rates.stiffness * x.lead + rates.by_rate * (x.motor - x.load) - by_load * drag;
        let shaft = (wound + by_motor * drive) * left;
        let free_motor = (x.motor + self.motor_step * drive) - self.motor_step * shaft;
        let free_load = (x.load + rates.load_step * drag) + rates.load_step * shaft;
        let (motor, friction) = slide(x.motor, free_motor, self.motor_most);
        let (load, _) = slide(x.load, free_load, rates.load_most);
        // semi-implicit: positions go on with the new speeds
        let masses = TwinMasses {
            current,
            lead: x.lead + h * (motor - load),
            motor,
            load,
            place: x.place + h * load,
        };
        let torques = TwinTorques {
            shaft,
            motor_friction: friction * self.friction_scale,
        };
        (masses, torques)
    }
}

/// What Coulomb friction that takes at most `most` leaves of the speed that a mass would have without it;
/// and what the friction added.
#[inline(always)]
fn slide<N: Number>(speed: N, free: N, most: N) -> (N, N) {
    let zero = speed.zero();
    let taken = free.clamp(-most, most);
    let left = free - taken;
    // friction acts against the sliding before, so it can stop a mass within the step and not turn
    // it round
    let stops = (speed * left).less(zero);
    (N::choose(stops, zero, left), -N::choose(stops, free, taken))
}

impl MotorNumbers<f64> {
    fn new<C>(config: &AxisConfig<C>, inertia: f64, h: f64) -> MotorNumbers<f64> {
        let motor = &config.motor;
        // implicit Euler in the winding: i' = (i + h/L (u - K_e w)) / (1 + R h/L)
        let share = h / motor.phase_inductance_h();
        let keep = 1.0 / (1.0 + share * motor.phase_resistance_ohm());
        let (gain, viscous) = (share * keep, motor.viscous_nm_s_per_rad);
        let current_brake = gain * motor.back_emf_v_s_per_rad();
        MotorNumbers {
            current_keep: keep,
            current_gain: gain,
            current_brake,
            torque_constant: motor.torque_constant_nm_per_a,
            viscous,
            brake: motor.torque_constant_nm_per_a * current_brake + viscous,
            coulomb: motor.coulomb_nm,
            motor_step: h / inertia,
            motor_most: h / inertia * motor.coulomb_nm,
            friction_scale: inertia / h,
        }
    }
}

impl Rates<f64> {
    #[inline]
    fn new(load: &LoadModel, motor_step: f64, h: f64) -> Rates<f64> {
        let load_step = h / load.inertia;
        let by_rate = h * load.stiffness + load.damping;
        let (by_motor, by_load) = (by_rate * motor_step, by_rate * load_step);
        Rates {
            load_constant: load.constant,
            load_viscous: load.viscous,
            load_coulomb: load.coulomb,
            load_step,
            load_most: load_step * load.coulomb,
            stiffness: load.stiffness,
            by_rate,
            by_motor,
            by_load,
            both_give: 1.0 / (1.0 + by_motor + by_load),
            motor_gives: 1.0 / (1.0 + by_motor),
            load_gives: 1.0 / (1.0 + by_load),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn friction_stops_a_mass_and_then_holds_it() {
        assert_eq!(slide(1.0, 1.0, 0.25), (0.75, -0.25));
        assert_eq!(slide(0.1, 0.1, 0.25).0, 0.0);
        assert_eq!(slide(0.0, 0.2, 0.25), (0.0, -0.2));
        assert_eq!(slide(0.0, -0.3, 0.25).0, -0.3 + 0.25);
    }
}
