//! Coulomb friction of both masses: how much of it there is in each state.

use super::mode::{Friction, Mass, Side};
use super::params::PlantParams;
use crate::config::FrictionLaw;

/// Bristles of LuGre's model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bristles {
    /// Deflection at which they carry the Coulomb friction, rad.
    pub presliding_rad: f64,
    /// Damping over stiffness, s.
    pub damping_s: f64,
}

/// Law of a Coulomb friction, at the motor's shaft. Its size stands apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrictionShape {
    /// Breakaway over Coulomb friction.
    pub static_factor: f64,
    /// Speed from which Coulomb friction alone is left, rad/s; 0 without a fall.
    pub speed_rad_s: f64,
    /// Bristles instead of true stick.
    pub bristles: Option<Bristles>,
}

impl FrictionShape {
    /// The same at every speed.
    pub const PLAIN: FrictionShape = FrictionShape {
        static_factor: 1.0,
        speed_rad_s: 0.0,
        bristles: None,
    };

    /// The law of a description whose speeds and ways are at the motor's shaft.
    pub(super) fn new(law: &FrictionLaw) -> FrictionShape {
        match *law {
            FrictionLaw::Coulomb => FrictionShape::PLAIN,
            FrictionLaw::Stribeck(law) => FrictionShape {
                static_factor: law.static_factor,
                speed_rad_s: law.speed_units_s,
                bristles: None,
            },
            FrictionLaw::Lugre(law) => FrictionShape {
                static_factor: law.static_factor,
                speed_rad_s: law.speed_units_s,
                bristles: Some(Bristles {
                    presliding_rad: law.presliding_units,
                    damping_s: law.damping_s,
                }),
            },
        }
    }

    /// Speed at which a sliding mass begins to creep, rad/s; 0 for one that slides until it stops.
    #[inline]
    pub(super) fn slow_rad_s(&self) -> f64 {
        if self.creeps() { self.speed_rad_s } else { 0.0 }
    }

    /// Whether its friction falls with speed in a straight line.
    #[inline]
    pub(super) fn creeps(&self) -> bool {
        self.static_factor > 1.0 && self.bristles.is_none()
    }
}

impl PlantParams {
    #[inline]
    pub(super) fn friction(&self, mass: Mass) -> &FrictionShape {
        match mass {
            Mass::Motor => &self.motor_friction,
            Mass::Load => &self.load_friction,
        }
    }

    #[inline]
    pub(super) fn coulomb(&self, mass: Mass) -> f64 {
        match mass {
            Mass::Motor => self.motor_coulomb_nm,
            Mass::Load => self.load_coulomb_nm,
        }
    }

    /// The most that friction can hold at rest, N m.
    #[inline]
    pub(super) fn breakaway(&self, mass: Mass) -> f64 {
        self.coulomb(mass) * self.friction(mass).static_factor
    }

    /// Slope at which friction falls with speed while a mass creeps, N m s/rad.
    pub(super) fn fall(&self, mass: Mass) -> f64 {
        let shape = self.friction(mass);
        if shape.creeps() {
            self.coulomb(mass) * (shape.static_factor - 1.0) / shape.speed_rad_s
        } else {
            0.0
        }
    }

    /// Viscous friction of a mass in a state, N m s/rad.
    #[inline]
    pub(super) fn viscous(&self, mass: Mass, state: Friction) -> f64 {
        let viscous = match mass {
            Mass::Motor => self.motor_viscous_nm_s_per_rad,
            Mass::Load => self.load_viscous_nm_s_per_rad,
        };
        if state.creeps() {
            viscous - self.fall(mass)
        } else {
            viscous
        }
    }

    /// The part of a sliding mass' friction torque that does not change with speed, N m.
    #[inline]
    pub(super) fn sliding_torque(&self, mass: Mass, state: Friction) -> f64 {
        let torque = self.coulomb(mass) * state.sign();
        if state.creeps() {
            torque * self.friction(mass).static_factor
        } else {
            torque
        }
    }

    /// Moving from rest in a direction.
    pub(super) fn starting(&self, mass: Mass, side: Side) -> Friction {
        if self.friction(mass).creeps() {
            Friction::Creeping(side)
        } else {
            Friction::Sliding(side)
        }
    }

    /// At rest.
    pub(super) fn resting(&self, mass: Mass) -> Friction {
        match (self.coulomb(mass) > 0.0, self.friction(mass).bristles) {
            (false, _) => Friction::None,
            (true, None) => Friction::Stuck,
            (true, Some(_)) => Friction::Bristles(Side::Positive),
        }
    }
}
