//! Numbers of the plant, all at the motor's shaft.

use super::curved::Curved;
use super::friction::FrictionShape;
use super::mode::Mass;
use crate::config::{AxisConfig, ContactLaw};

/// What the plant is made of. SI units, angles in rad at the motor's shaft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlantParams {
    /// Phase resistance, ohm.
    pub resistance_ohm: f64,
    /// Phase inductance, H.
    pub inductance_h: f64,
    /// Back-EMF in q, V s/rad (mechanical).
    pub back_emf_v_s_per_rad: f64,
    /// Torque per i_q, N m/A.
    pub torque_constant_nm_per_a: f64,
    /// Pole pairs.
    pub pole_pairs: f64,
    /// Inertia of the rotor and what turns with it, kg m2.
    pub motor_inertia_kgm2: f64,
    /// Viscous friction at the motor, N m s/rad.
    pub motor_viscous_nm_s_per_rad: f64,
    /// Coulomb friction at the motor, N m.
    pub motor_coulomb_nm: f64,
    /// Inertia of the load, kg m2.
    pub load_inertia_kgm2: f64,
    /// Viscous friction at the load, N m s/rad.
    pub load_viscous_nm_s_per_rad: f64,
    /// Coulomb friction at the load, N m.
    pub load_coulomb_nm: f64,
    /// Constant torque against the positive direction at the load, N m.
    pub load_constant_nm: f64,
    /// Stiffness of the shaft, N m/rad.
    pub stiffness_nm_per_rad: f64,
    /// Damping of the shaft, N m s/rad.
    pub damping_nm_s_per_rad: f64,
    /// Half gap b, rad.
    pub half_gap_rad: f64,
    /// Where the middle of the gap is, in parts of the half gap.
    pub gap_middle: f64,
    /// Law of the contact torque.
    pub contact: ContactLaw,
    /// Law of the motor's Coulomb friction.
    pub motor_friction: FrictionShape,
    /// Law of the load's Coulomb friction.
    pub load_friction: FrictionShape,
    /// What is not linear.
    pub curved: Curved,
    /// Largest current the drive allows, A; only scales the margins of the event search.
    pub current_limit_a: f64,
    /// Length of a step: the current loop's period, s.
    pub period_s: f64,
}

impl PlantParams {
    /// The plant of an axis.
    pub fn new<C>(config: &AxisConfig<C>) -> PlantParams {
        let (motor, load) = (&config.motor, config.reflected_load());
        PlantParams {
            resistance_ohm: motor.phase_resistance_ohm(),
            inductance_h: motor.phase_inductance_h(),
            back_emf_v_s_per_rad: motor.back_emf_v_s_per_rad(),
            torque_constant_nm_per_a: motor.torque_constant_nm_per_a,
            pole_pairs: motor.pole_pairs(),
            motor_inertia_kgm2: config.motor_side_inertia_kgm2(),
            motor_viscous_nm_s_per_rad: motor.viscous_nm_s_per_rad,
            motor_coulomb_nm: motor.coulomb_nm,
            load_inertia_kgm2: load.inertia_kgm2,
            load_viscous_nm_s_per_rad: load.viscous_nm_s_per_rad,
            load_coulomb_nm: load.coulomb_nm,
            load_constant_nm: load.constant_nm,
            stiffness_nm_per_rad: load.stiffness_nm_per_rad,
            damping_nm_s_per_rad: load.damping_nm_s_per_rad,
            half_gap_rad: load.half_gap_rad(),
            gap_middle: config.flanks.middle,
            contact: config.contact,
            motor_friction: FrictionShape::new(&config.friction.motor),
            load_friction: FrictionShape::new(&config.friction.load_at_motor(&config.transmission)),
            curved: Curved::new(config),
            current_limit_a: config.drive.current_limit_a,
            period_s: config.current_period_us() * 1e-6,
        }
    }

    /// Gap angle at which a flank of a sign begins; the middle of the gap for 0. Rad.
    #[inline]
    pub(super) fn flank(&self, sign: f64) -> f64 {
        (self.gap_middle + sign) * self.half_gap_rad
    }

    /// An upper bound of how fast any mode of the plant moves, 1/s: the norm of its system matrix
    /// in balanced units.
    pub(super) fn rate(&self) -> f64 {
        let joint = 1.0 / self.motor_inertia_kgm2 + 1.0 / self.load_inertia_kgm2;
        let electric = self.resistance_ohm / self.inductance_h;
        let electromechanic = (self.torque_constant_nm_per_a * self.back_emf_v_s_per_rad
            / (self.inductance_h * self.motor_inertia_kgm2))
            .sqrt();
        // twice the stiffness: bounded damping doubles the spring
        let spring = (2.0 * self.stiffness_nm_per_rad * joint).sqrt();
        let friction = (self.motor_viscous_nm_s_per_rad + self.fall(Mass::Motor))
            / self.motor_inertia_kgm2
            + (self.load_viscous_nm_s_per_rad + self.fall(Mass::Load)) / self.load_inertia_kgm2;
        electric + electromechanic + spring + self.damping_nm_s_per_rad * joint + friction
    }
}
