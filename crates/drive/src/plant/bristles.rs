//! LuGre's friction as a series; see [`crate::config::Lugre`] for its equations.

use super::friction::Bristles;
use super::mode::Mass;
use super::params::PlantParams;
use super::series::{Gauss, NOTHING, Series, product};

/// Friction of a mass that moves on bristles in one direction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Brush {
    sign: f64,
    coulomb: f64,
    static_excess: f64,
    speed: f64,
    stiffness: f64,
    damping: f64,
    u: Series,
    gauss: Gauss,
    level: Series,
    ratio: Series,
    /// Speed of the deflection, rad/s.
    pub(super) rate: Series,
    /// Friction torque against the positive direction, N m.
    pub(super) torque: Series,
}

impl Brush {
    pub(super) fn new(params: &PlantParams, mass: Mass, sign: f64, bristles: Bristles) -> Brush {
        let (shape, coulomb) = (params.friction(mass), params.coulomb(mass));
        let stiffness = coulomb / bristles.presliding_rad;
        Brush {
            sign,
            coulomb,
            static_excess: shape.static_factor - 1.0,
            speed: shape.speed_rad_s,
            stiffness,
            damping: stiffness * bristles.damping_s,
            u: NOTHING,
            gauss: Gauss::NEW,
            level: NOTHING,
            ratio: NOTHING,
            rate: NOTHING,
            torque: NOTHING,
        }
    }

    pub(super) fn extend(&mut self, speed: &Series, deflection: &Series, n: usize) {
        self.u[n] = speed[n] / self.speed;
        self.gauss.extend(&self.u, n);
        self.level[n] = self.coulomb * self.static_excess * self.gauss.value[n];
        if n == 0 {
            self.level[0] += self.coulomb;
        }
        // deflection over level, by long division; its own coefficient n is still zero in the
        // product
        self.ratio[n] = (deflection[n] - product(&self.level, &self.ratio, n)) / self.level[0];
        self.rate[n] = speed[n] - self.sign * self.stiffness * product(speed, &self.ratio, n);
        self.torque[n] = self.stiffness * deflection[n] + self.damping * self.rate[n];
    }
}
