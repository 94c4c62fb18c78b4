//! What of a plant is not linear within a mode: its numbers, at the motor's shaft.

use super::params::PlantParams;
use crate::config::{AxisConfig, Harmonic, MAX_HARMONICS};
use lostmotion_base::math;
use std::f64::consts::TAU;

/// One harmonic over an angle: `amplitude sin(per_rad theta + phase)`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wave {
    /// Amplitude, in the unit of what it is a part of.
    pub amplitude: f64,
    /// Periods for one rad, times 2 pi.
    pub per_rad: f64,
    /// Phase, rad.
    pub phase_rad: f64,
}

/// A few harmonics over one angle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Waves {
    list: [Wave; MAX_HARMONICS],
    len: usize,
}

/// Wear: the gap is `1 + excess exp(-((x - at)/width)^2)` times as wide at load position x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bell {
    /// By how much the gap is wider at the worst place, in parts of the gap elsewhere.
    pub excess: f64,
    /// The worst place, rad.
    pub at_rad: f64,
    /// Width, rad.
    pub width_rad: f64,
}

/// Everything that is not linear, besides friction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Curved {
    /// Cogging, N m over the motor's angle.
    pub cogging: Waves,
    /// Relative torque ripple over the motor's angle.
    pub ripple: Waves,
    /// Gravity against the positive direction, N m over the load's angle.
    pub gravity: Waves,
    /// Wear of the flanks.
    pub wear: Option<Bell>,
}

impl Waves {
    /// Of a list; more than there is room for is left out.
    pub fn new(waves: impl IntoIterator<Item = Wave>) -> Waves {
        let mut all = Waves::default();
        for wave in waves {
            if let Some(slot) = all.list.get_mut(all.len) {
                *slot = wave;
                all.len += 1;
            }
        }
        all
    }

    /// Torque of an axis' weight against the positive direction over the load's angle, N m and rad
    /// at the motor; none without [`crate::config::Gravity`].
    pub fn gravity<C>(config: &AxisConfig<C>) -> Waves {
        let ratio = config.transmission.load_per_motor_rad();
        Waves::new(config.gravity.map(|gravity| Wave {
            amplitude: gravity.torque_nm * ratio,
            per_rad: ratio,
            phase_rad: -gravity.hangs_at_deg * (TAU / 360.0),
        }))
    }

    fn over_turn(harmonics: &[Harmonic]) -> Waves {
        Waves::new(harmonics.iter().map(|harmonic| Wave {
            amplitude: harmonic.amplitude,
            per_rad: f64::from(harmonic.per_turn),
            phase_rad: harmonic.phase_deg * (TAU / 360.0),
        }))
    }

    /// The harmonics.
    pub fn as_slice(&self) -> &[Wave] {
        self.list.get(..self.len).unwrap_or(&[])
    }

    /// Their sum at an angle, rad.
    pub fn at(&self, angle: f64) -> f64 {
        self.as_slice()
            .iter()
            .map(|wave| wave.amplitude * math::sin(wave.per_rad * angle + wave.phase_rad))
            .sum()
    }

    /// The fastest of them, periods times 2 pi for one rad.
    fn per_rad(&self) -> f64 {
        self.as_slice()
            .iter()
            .fold(0.0, |highest, wave| wave.per_rad.max(highest))
    }
}

impl Bell {
    /// How many times wider the gap is at a load position.
    pub fn at(&self, place: f64) -> f64 {
        let u = (place - self.at_rad) / self.width_rad;
        1.0 + self.excess * math::exp(-(u * u))
    }
}

impl Curved {
    /// That of an axis.
    pub(super) fn new<C>(config: &AxisConfig<C>) -> Curved {
        let factor = config.transmission.motor_rad_per_unit();
        let wear = config.flanks.wear.map(|wear| Bell {
            excess: wear.factor - 1.0,
            at_rad: wear.at_units * factor,
            width_rad: wear.width_units * factor,
        });
        Curved {
            cogging: Waves::over_turn(&config.ripple.cogging),
            ripple: Waves::over_turn(&config.ripple.torque),
            gravity: Waves::gravity(config),
            wear,
        }
    }
}

impl PlantParams {
    /// Whether the equations are not linear within a mode.
    pub(super) fn is_curved(&self) -> bool {
        let bristles = [
            (self.motor_coulomb_nm, self.motor_friction),
            (self.load_coulomb_nm, self.load_friction),
        ];
        self.curved != Curved::default()
            || bristles
                .iter()
                .any(|(coulomb, law)| *coulomb > 0.0 && law.bristles.is_some())
    }

    /// An upper bound of how fast anything moves at these speeds, 1/s.
    pub(super) fn rate_at(&self, motor_speed: f64, load_speed: f64) -> f64 {
        let waves = self
            .curved
            .cogging
            .per_rad()
            .max(self.curved.ripple.per_rad())
            * motor_speed.abs();
        let bend = |bristles: Option<super::friction::Bristles>, speed: f64| {
            bristles.map_or(0.0, |b| speed.abs() / b.presliding_rad)
        };
        self.rate()
            + waves
            + bend(self.motor_friction.bristles, motor_speed)
            + bend(self.load_friction.bristles, load_speed)
    }

    /// Gap angle at which a flank of a sign begins with the load at a place; the middle of the gap
    /// for 0. Rad.
    pub(super) fn flank_at(&self, sign: f64, place: f64) -> f64 {
        match &self.curved.wear {
            None => self.flank(sign),
            Some(wear) => (self.gap_middle + sign) * (self.half_gap_rad * wear.at(place)),
        }
    }
}
