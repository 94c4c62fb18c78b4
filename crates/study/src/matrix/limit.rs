//! The physical limit: the load moves on its own while the motor crosses the gap.
//!
//! A motor of inertia J_M that gives tau at most needs `T = 2 sqrt(g J_M/tau)` from rest to rest
//! across the gap g. Meanwhile the load coasts:
//! - where the velocity's sign changes the flank (friction T_f, acceleration a there, rho = a
//!   J_L/T_f <= 1): `e = (a T^2/8) max(1 - rho, rho)`;
//! - elsewhere, at a jerk j: `e = j T^3/12`, the traverse centred on the change.
//!
//! Neither is more than the gap itself. A load without Coulomb friction that needs no torque, at
//! rest or in steady travel, floats: any speed that its last contact left carries it through the
//! gap, and the motor does not see where it is. With full knowledge of the plant it would be no worse
//! there than elsewhere; a method on the motor has no information, and a load that may be anywhere
//! leaves half the gap over the square root of 3 (RMS, uniform distribution) as long as that lasts.
//!
//! These formulae hold for a traverse that is timed and aimed perfectly, and a stiff shaft: one that
//! winds up carries the load while the motor leaves its flank and lands, which has been seen to
//! leave a sixteenth less. Otherwise no compensator on the motor can do better.

use lostmotion_methods::AxisConfig;

/// The time of a traverse of the whole gap from rest to rest with the drive's largest torque, s.
pub fn traverse_s(config: &AxisConfig) -> f64 {
    // Full torque one way, then the other: half the gap in half the time.
    let torque = config.motor.torque_constant_nm_per_a * config.drive.current_limit_a;
    2.0 * (config.reflected_load().gap_rad * config.motor_side_inertia_kgm2() / torque).sqrt()
}

/// An axis as the limits see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Physics {
    /// Inertia of the load, kg m2.
    pub load_inertia_kgm2: f64,
    /// Viscous friction of the load, N m s/rad.
    pub viscous_nm_s_per_rad: f64,
    /// Coulomb friction of the load, N m.
    pub coulomb_nm: f64,
    /// Total gap, rad.
    pub gap_rad: f64,
    /// Shortest traverse, s.
    pub traverse_s: f64,
    /// Rated torque of the motor, N m.
    pub rated_nm: f64,
}

/// Part of the rated torque below which nothing presses a load on a flank: the friction of seals
/// and the ripple of a current are of that size. A choice.
const PRESSING_SHARE: f64 = 3e-3;

impl Physics {
    /// Of an axis.
    pub fn of(config: &AxisConfig) -> Physics {
        let load = config.reflected_load();
        Physics {
            load_inertia_kgm2: load.inertia_kgm2,
            viscous_nm_s_per_rad: load.viscous_nm_s_per_rad,
            coulomb_nm: load.coulomb_nm,
            gap_rad: load.gap_rad,
            traverse_s: traverse_s(config),
            rated_nm: config.motor.rated_torque_nm,
        }
    }

    /// The torque that the load needs, N m, moving in a direction (1 or -1) at rad/s and rad/s2.
    pub fn need_nm(&self, direction: f64, velocity: f64, acceleration: f64) -> f64 {
        self.load_inertia_kgm2 * acceleration
            + self.viscous_nm_s_per_rad * velocity
            + self.coulomb_nm * direction
    }

    /// Whether nothing holds the load and nothing presses it, at rad/s and rad/s2: it floats in the
    /// gap at whatever speed its last contact left it.
    pub fn floats(&self, velocity: f64, acceleration: f64) -> bool {
        self.coulomb_nm <= 0.0
            && self.need_nm(0.0, velocity, acceleration).abs() < PRESSING_SHARE * self.rated_nm
    }

    /// Least error of a change of flank at a reversal of the velocity with some acceleration
    /// (rad/s2), rad.
    pub fn at_reversal_rad(&self, acceleration: f64) -> f64 {
        let a = acceleration.abs();
        // Rho: part of the friction that the deceleration needs; without friction the load coasts
        // through.
        let ratio = if self.coulomb_nm > 0.0 {
            (a * self.load_inertia_kgm2 / self.coulomb_nm).min(1.0)
        } else {
            1.0
        };
        (a * self.traverse_s * self.traverse_s / 8.0 * ratio.max(1.0 - ratio)).min(self.gap_rad)
    }

    /// Least error of a change of flank elsewhere, at some jerk (rad/s3), rad.
    pub fn elsewhere_rad(&self, jerk: f64) -> f64 {
        (jerk.abs() * self.traverse_s * self.traverse_s * self.traverse_s / 12.0).min(self.gap_rad)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_published_examples() {
        // R50, F3000 mm/min with rho = 0 for traverses of 5, 10 and 20 ms: 0.16, 0.63, 2.5 um
        let acceleration = 50.0 * 50.0 / 50.0;
        for (traverse_s, um) in [(0.005, 0.16), (0.010, 0.63), (0.020, 2.5)] {
            let physics = Physics {
                load_inertia_kgm2: 1e-12,
                viscous_nm_s_per_rad: 0.0,
                coulomb_nm: 1.0,
                gap_rad: 1.0,
                traverse_s,
                rated_nm: 10.0,
            };
            let e_um = 1e3 * physics.at_reversal_rad(acceleration);
            assert!((e_um / um - 1.0).abs() < 0.03, "{e_um} {um}");
        }
    }
}
