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
//! in a servo period; sums are ordered so that what comes late in a period is added last. A servo period
//! in which both slide on is one product with a table (`stride`).

mod law;
mod stride;

pub(crate) use law::{MotorNumbers, Rates, TwinMasses};
use stride::Products;
pub(crate) use stride::{
    Arrival, BOUNDS, Departure, INPUTS, OUTCOMES, Stride, StrideNumbers, Tables,
};

use crate::config::AxisConfig;
use crate::plant::{Contact, Friction, Mode, PlantState};
use crate::servo::{Servo, ServoState};
use crate::signal::{Correction, Reference};
use pulp::Arch;
use serde::{Deserialize, Serialize};

/// Motor and drive of the twin.
#[derive(Clone, Debug)]
pub struct Twin {
    servo: Servo,
    period_s: f64,
    inertia: f64,
    numbers: MotorNumbers<f64>,
    stride: StrideNumbers<f64>,
    /// Whether the command stays over a servo period, as a stride asks for.
    strides: bool,
    arch: Arch,
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
    #[serde(skip)]
    pub(crate) stride: Stride,
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

    /// Load and weight, bit by bit: few ticks bring others.
    #[inline(always)]
    pub(crate) fn bits(&self) -> [u64; 7] {
        let LoadModel {
            inertia,
            viscous,
            coulomb,
            constant,
            stiffness,
            damping,
        } = *self.load;
        [
            inertia,
            viscous,
            coulomb,
            constant,
            stiffness,
            damping,
            self.weight,
        ]
        .map(f64::to_bits)
    }

    /// Whether they are others than these. All are compared: one that ends early is a loop, or a call.
    #[inline(always)]
    pub(crate) fn differs(&self, before: &[u64; 7]) -> bool {
        let mut differs = 0;
        for (before, now) in before.iter().zip(self.bits()) {
            differs |= before ^ now;
        }
        differs != 0
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
        let servo = Servo::new(&ideal);
        Twin {
            stride: StrideNumbers {
                resistance: config.motor.phase_resistance_ohm(),
                back_emf: config.motor.back_emf_v_s_per_rad(),
            },
            strides: servo.current_numbers().is_some(),
            arch: Arch::new(),
            servo,
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
            stride: Stride::default(),
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
        // the axis' own cascade, uncorrected
        let measured = self.servo.measure(&mut state.servo, &state.plant);
        self.servo.command(
            &mut state.servo,
            reference,
            next,
            &measured,
            &Correction::NONE,
        );
        if !self.strides(state, load) {
            self.periods(state, load);
        }
        // nobody asks a twin for its mean current
        state.servo.current.sum = 0.0;
    }

    /// The periods of the current loop all at once, if they can be.
    #[inline(always)]
    fn strides(&self, state: &mut TwinState, load: &LoadModel) -> bool {
        let x = state.plant.masses();
        // at rest nothing is asked that the bounds would deny
        if !self.strides || x.motor == 0.0 || x.load == 0.0 {
            return false;
        }
        let (velocity, current) = (&state.servo.velocity, &mut state.servo.current);
        let departure = Departure {
            command: velocity.current_command,
            integral: current.integral_q,
            pending: current.pending[1],
            integral_d: current.integral_d,
            electric_speed: current.electric_speed,
            back_emf: current.back_emf,
            load_most: self.period_s / load.inertia * load.coulomb,
            load_constant: load.constant,
        };
        let tables = state.stride.tables(self, load);
        let products = |inputs: &[f64; INPUTS]| {
            let (outcomes, [motor, load, current, voltage, ..]) =
                self.arch.dispatch(Products { tables, inputs });
            (outcomes, [motor, load, current, voltage])
        };
        let (goes_on, arrival) = departure.stride(
            (&self.stride, &self.numbers, self.servo.current_loop()),
            &x,
            products,
        );
        if goes_on {
            (current.integral_q, current.pending[1]) = (arrival.integral, arrival.pending);
            state.plant.take(&arrival.masses);
            (state.torque, state.motor_friction) = (arrival.shaft, arrival.motor_friction);
        }
        goes_on
    }

    /// One after the other.
    #[inline(never)]
    fn periods(&self, state: &mut TwinState, load: &LoadModel) {
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

    /// What of drive and motor a stride asks for, for a batch.
    pub(crate) fn stride(&self) -> &StrideNumbers<f64> {
        &self.stride
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
