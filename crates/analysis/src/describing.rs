//! Limit cycles through the gap, by describing function.
//!
//! On a swing of the gap angle `A sin(w t)` the contact torque `k (theta_b -/+ b) + d theta_b'`
//! outside a gap of half width b has the first harmonic `n(A) (k + j w d) A` with
//! ```text
//! n = (2/pi) (pi/2 - a - sin a cos a),   sin a = b/A
//! ```
//! for spring and damper alike: the gap acts as a shaft of n times the stiffness and damping, n
//! from 0 (A = b) to 1. Coulomb friction of motor and load acts as viscous friction `4 T/(pi W)`, W
//! the speed's amplitude. A swing neither grows nor decays where the linear axis with these values
//! has its outermost pole on the unit circle; it is a limit cycle where larger swings decay and
//! smaller ones grow. The servo and its sampling are exact ([`super::model`]), the swings'
//! harmonics are neglected. Source: Nordin and Gutman, *Controlling mechanical systems with
//! backlash: a survey*, Automatica 38 (2002); Gelb and Vander Velde, *Multiple-Input Describing
//! Functions* (1968).

use super::margins::{frequencies, from_minus_one};
use super::model::{Coupling, Feedback, Model};
use super::response::{Complex, StateSpace};
use lostmotion_base::math;
use lostmotion_drive::config::Reflected;
use lostmotion_methods::AxisConfig;
use serde::Serialize;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// The prediction of the describing function.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum LimitCycle {
    /// No swing sustains itself.
    None,
    /// A swing that sustains itself.
    Swing {
        /// Its frequency, Hz.
        frequency_hz: f64,
        /// Amplitude (half of peak to peak) of the gap angle theta_M - theta_L, rad.
        gap_angle_rad: f64,
        /// Amplitude of the load, rad at the motor.
        load_rad: f64,
    },
    /// The axis swings ever more on its flanks: no limit cycle, but an unstable loop.
    Unstable,
}

/// The limit cycle of an axis that has been checked, standing still, with its position loop closed
/// on the motor or on the load.
///
/// Accuracy: on soft flanks a few per cent in frequency and a sixth in amplitude; on stiff ones with
/// lossy contact, where the true swing is a series of impacts, up to twice the frequency and a
/// quarter of the amplitude. It also predicts swings that friction would quench.
pub fn limit_cycle(config: &AxisConfig, feedback: Feedback) -> LimitCycle {
    let load = config.reflected_load();
    if load.half_gap_rad() <= 0.0 {
        return LimitCycle::None;
    }
    // Friction damps: an axis that does not swing without it does not swing with it.
    let free = Balance {
        config,
        feedback,
        load,
        motor_coulomb: 0.0,
        load_coulomb: 0.0,
    };
    let (motor_coulomb, load_coulomb) = (config.motor.coulomb_nm, load.coulomb_nm);
    match free.outermost() {
        LimitCycle::Swing { .. } if motor_coulomb > 0.0 || load_coulomb > 0.0 => Balance {
            motor_coulomb,
            load_coulomb,
            ..free
        }
        .outermost(),
        found => found,
    }
}

/// Harmonic balance of an axis.
struct Balance<'a> {
    config: &'a AxisConfig,
    feedback: Feedback,
    load: Reflected,
    motor_coulomb: f64,
    load_coulomb: f64,
}

impl Balance<'_> {
    /// The limit cycle of the largest amplitude: where swings from 1000 half gaps down to just
    /// beyond one begin to grow.
    fn outermost(&self) -> LimitCycle {
        // From 1000 half gaps down to 1.001, evenly in the logarithm of the excess over one.
        let steps = 60;
        let amplitude = |step: u32| {
            self.load.half_gap_rad()
                * (1.0 + math::pow(10.0, 3.0 - 6.0 * f64::from(step) / f64::from(steps)))
        };
        let mut guess = TAU * 10.0;
        for step in 0..=steps {
            let (grows, frequency) = self.swing(amplitude(step), guess);
            guess = frequency;
            match grows {
                // Growing far beyond the gap: the loop itself is unstable on its flanks.
                true if step == 0 => return LimitCycle::Unstable,
                true => return self.between(amplitude(step), amplitude(step - 1), guess),
                false => {}
            }
        }
        LimitCycle::None
    }

    /// Whether a swing of an amplitude grows, and its frequency, rad/s. Friction depends on the
    /// frequency and the frequency on friction: iterated.
    fn swing(&self, amplitude: f64, guess: f64) -> (bool, f64) {
        // The gap as a shaft of that share of stiffness and damping.
        let share = dead_zone(amplitude / self.load.half_gap_rad());
        let mut frequency = guess;
        let frictionless = self.motor_coulomb == 0.0 && self.load_coulomb == 0.0;
        let mut open = self.open(share, [0.0; 2]);
        // Friction and frequency depend on each other: fixed-point iteration.
        for _ in 0..if frictionless { 0 } else { 6 } {
            let (viscous, _) = self.friction(share, amplitude, frequency);
            open = self.open(share, viscous);
            frequency = critical(&open);
        }
        // Outermost pole beyond the unit circle, rounding apart.
        let grows = open.closed_radius() > 1.0 + 1e-9;
        if grows && frictionless {
            frequency = critical(&open);
        }
        (grows, frequency)
    }

    fn open(&self, share: f64, extra_viscous: [f64; 2]) -> StateSpace {
        Model::new(
            self.config,
            Coupling {
                share,
                extra_viscous,
            },
        )
        .position_loop(self.feedback, 1.0)
    }

    /// Viscous friction that stands for Coulomb friction of motor and load on a swing, and the
    /// amplitude of the load's speed.
    fn friction(&self, share: f64, amplitude: f64, frequency: f64) -> ([f64; 2], f64) {
        let load = &self.load;
        // First harmonic of the contact torque on this swing.
        let contact = Complex {
            re: share * load.stiffness_nm_per_rad,
            im: share * frequency * load.damping_nm_s_per_rad,
        }
        .scaled(amplitude);
        let (inertial, viscous, coulomb) = (
            frequency * load.inertia_kgm2,
            load.viscous_nm_s_per_rad,
            4.0 / PI * self.load_coulomb,
        );
        // (b W + c)^2 + (w J W)^2 = |T|^2
        let impedance = viscous * viscous + inertial * inertial;
        let room = contact.abs() * contact.abs() - coulomb * coulomb;
        // The quadratic equation for W; no solution where friction holds the load.
        let speed = if room > 0.0 {
            ((viscous * coulomb * viscous * coulomb + impedance * room).sqrt() - viscous * coulomb)
                / impedance
        } else {
            0.0
        };
        // A load that its friction holds, as if it were very heavy.
        let held = 1e4 * inertial;
        let of_load = if speed > 0.0 {
            (coulomb / speed).min(held)
        } else {
            held
        };
        // Speeds of load and motor as complex amplitudes; the gap angle is their difference's
        // integral.
        let load_speed = contact.over(Complex {
            re: viscous + of_load,
            im: inertial,
        });
        let motor_speed = load_speed
            .plus(Complex {
                re: 0.0,
                im: frequency * amplitude,
            })
            .abs();
        (
            [
                4.0 / PI * self.motor_coulomb / motor_speed,
                if coulomb > 0.0 { of_load } else { 0.0 },
            ],
            load_speed.abs(),
        )
    }

    /// The limit cycle between an amplitude that grows and one that decays.
    fn between(&self, mut grows: f64, mut decays: f64, guess: f64) -> LimitCycle {
        let mut frequency = guess;
        // Bisection between growth and decay, the frequency carried along as a guess.
        for _ in 0..40 {
            let middle = 0.5 * (grows + decays);
            let (up, at) = self.swing(middle, frequency);
            if up {
                grows = middle;
                frequency = at;
            } else {
                decays = middle;
            }
        }
        let amplitude = 0.5 * (grows + decays);
        let (_, load_speed) = self.friction(
            dead_zone(amplitude / self.load.half_gap_rad()),
            amplitude,
            frequency,
        );
        LimitCycle::Swing {
            frequency_hz: frequency / TAU,
            gap_angle_rad: amplitude,
            load_rad: load_speed / frequency,
        }
    }
}

/// `n` of an amplitude in half gaps.
fn dead_zone(ratio: f64) -> f64 {
    // Part of a quarter swing that is spent within the gap.
    let sine = (1.0 / ratio).min(1.0);
    let angle = math::asin(sine);
    (2.0 / PI * (FRAC_PI_2 - angle - sine * math::cos(angle))).max(f64::MIN_POSITIVE)
}

/// Where the response comes nearest to -1, rad/s.
fn critical(open: &StateSpace) -> f64 {
    let distance = |f: f64| from_minus_one(open.at(f));
    // The upper four decades, every fifth frequency: coarse, then refined around the best.
    let grid: Vec<(f64, f64)> = frequencies(open.nyquist_hz())
        .skip(500)
        .step_by(5)
        .map(|f| (f, distance(f)))
        .collect();
    let nearest = grid
        .iter()
        .enumerate()
        .min_by(|a, b| a.1.1.total_cmp(&b.1.1))
        .map_or(0, |(index, _)| index);
    let at = |index: usize| grid.get(index).or(grid.last()).map_or(1.0, |(f, _)| *f);
    let (mut low, mut high) = (at(nearest.saturating_sub(1)), at(nearest + 1));
    for _ in 0..60 {
        // Ternary search: one minimum is presumed between the neighbours.
        let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if distance(a) < distance(b) {
            high = b;
        } else {
            low = a;
        }
    }
    0.5 * (low + high) * TAU
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dead_zone_is_the_first_harmonic_of_spring_and_damper() {
        for ratio in [1.001, 1.3, 4.0, 100.0] {
            let count = 200_000;
            let (mut spring, mut damper) = (0.0, 0.0);
            for n in 0..count {
                let (s, c) = math::sin_cos(TAU * (f64::from(n) + 0.5) / f64::from(count));
                let out = ratio * s;
                if out.abs() > 1.0 {
                    spring += (out - out.signum()) * s;
                    damper += ratio * c * c;
                }
            }
            let scale = 2.0 / (f64::from(count) * ratio);
            assert!((dead_zone(ratio) - spring * scale).abs() < 1e-8, "{ratio}");
            assert!((dead_zone(ratio) - damper * scale).abs() < 2e-5, "{ratio}");
        }
    }

    #[test]
    fn a_rigid_axis_has_no_limit_cycle() {
        assert_eq!(
            limit_cycle(&AxisConfig::paper().without_gap(), Feedback::Load),
            LimitCycle::None
        );
    }
}
