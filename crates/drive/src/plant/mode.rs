//! Modes of the plant: in each it is linear and time-invariant.

use crate::signal::Engagement;
use serde::{Deserialize, Serialize};

/// A flank of the gap.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Side {
    /// The motor pushes the load in the negative direction.
    Negative,
    /// The motor pushes the load in the positive direction.
    Positive,
}

impl Side {
    /// -1 or 1.
    pub const fn sign(self) -> f64 {
        match self {
            Side::Negative => -1.0,
            Side::Positive => 1.0,
        }
    }

    /// The side of a number's sign; positive for zero.
    pub(super) fn of(value: f64) -> Side {
        if value < 0.0 {
            Side::Negative
        } else {
            Side::Positive
        }
    }
}

/// State of the contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Contact {
    /// No gap at all: spring and damper in both directions.
    Rigid,
    /// Between the flanks: no torque.
    Gap,
    /// On a flank: spring and damper.
    Spring(Side),
    /// On a flank, the damper's torque bounded to the spring's: twice the spring.
    Doubled(Side),
    /// Past a flank's free position, but separating so fast that the flanks do not touch: no
    /// torque.
    Lifted(Side),
}

/// How the contact enters the equations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Coupling {
    Free,
    Spring,
    Doubled,
}

impl Contact {
    /// Sign of the flank from which penetration counts; 0 where it counts from the middle.
    #[inline]
    pub(super) const fn sign(self) -> f64 {
        match self {
            Contact::Rigid | Contact::Gap => 0.0,
            Contact::Spring(side) | Contact::Doubled(side) | Contact::Lifted(side) => side.sign(),
        }
    }

    #[inline]
    pub(super) const fn coupling(self) -> Coupling {
        match self {
            Contact::Gap | Contact::Lifted(_) => Coupling::Free,
            Contact::Rigid | Contact::Spring(_) => Coupling::Spring,
            Contact::Doubled(_) => Coupling::Doubled,
        }
    }

    /// The engagement as the gap angle shows it. Without a gap it is the side of the wind-up.
    pub fn engagement(self, gap_angle: f64) -> Engagement {
        match self {
            Contact::Gap => Engagement::Gap,
            Contact::Rigid if gap_angle > 0.0 => Engagement::Positive,
            Contact::Rigid if gap_angle < 0.0 => Engagement::Negative,
            Contact::Rigid => Engagement::Gap,
            Contact::Spring(side) | Contact::Doubled(side) | Contact::Lifted(side) => match side {
                Side::Negative => Engagement::Negative,
                Side::Positive => Engagement::Positive,
            },
        }
    }
}

/// State of a Coulomb friction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Friction {
    /// There is none.
    None,
    /// Standing: holds any torque up to its own.
    Stuck,
    /// Sliding in a direction, against it.
    Sliding(Side),
    /// Sliding so slowly that its friction still falls with speed (Stribeck).
    Creeping(Side),
    /// Moving in a direction on bristles (LuGre).
    Bristles(Side),
}

/// One of the two masses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mass {
    Motor,
    Load,
}

impl Friction {
    #[inline]
    pub(super) const fn sign(self) -> f64 {
        match self {
            Friction::None | Friction::Stuck => 0.0,
            Friction::Sliding(side) | Friction::Creeping(side) | Friction::Bristles(side) => {
                side.sign()
            }
        }
    }

    /// What it makes of the equations: 0 sliding or none, 1 stuck, 2 creeping.
    #[inline]
    const fn kind(self) -> usize {
        self.stuck() as usize + 2 * self.creeps() as usize
    }

    #[inline]
    pub(super) const fn creeps(self) -> bool {
        matches!(self, Friction::Creeping(_))
    }

    #[inline]
    pub(super) const fn stuck(self) -> bool {
        matches!(self, Friction::Stuck)
    }
}

/// Mode of the whole plant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Mode {
    /// Contact of the shaft.
    pub contact: Contact,
    /// Coulomb friction at the motor.
    pub motor: Friction,
    /// Coulomb friction at the load.
    pub load: Friction,
}

/// Number of different system matrices: three couplings, each mass sliding, stuck or creeping.
pub(super) const MATRICES: usize = 27;

impl Mode {
    #[inline]
    pub(super) const fn friction(self, mass: Mass) -> Friction {
        match mass {
            Mass::Motor => self.motor,
            Mass::Load => self.load,
        }
    }

    pub(super) fn set_friction(&mut self, mass: Mass, friction: Friction) {
        match mass {
            Mass::Motor => self.motor = friction,
            Mass::Load => self.load = friction,
        }
    }

    /// Index of the mode's system matrix.
    #[inline]
    pub(super) const fn matrix(self) -> usize {
        self.contact.coupling() as usize * 9 + self.motor.kind() * 3 + self.load.kind()
    }

    /// A mode that has the matrix of an index, for building the tables.
    #[inline]
    pub(super) const fn with_matrix(index: usize) -> Mode {
        let contact = match index / 9 {
            0 => Contact::Gap,
            1 => Contact::Rigid,
            // the side does not enter the matrix; one stands for both
            _ => Contact::Doubled(Side::Positive),
        };
        Mode {
            contact,
            motor: friction_of(index / 3 % 3),
            load: friction_of(index % 3),
        }
    }
}

const fn friction_of(kind: usize) -> Friction {
    match kind {
        0 => Friction::None,
        1 => Friction::Stuck,
        _ => Friction::Creeping(Side::Positive),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_matrix_index_has_its_mode() {
        for index in 0..MATRICES {
            assert_eq!(Mode::with_matrix(index).matrix(), index);
        }
    }
}
