//! Motor, shaft and load as a Kalman filter sees them, with the half gap as one more state.
//!
//! ```text
//! x = (theta_M, w_M, theta_b, w_L, b)              theta_b = theta_M - theta_L,  y = theta_M + noise of the encoder; rad, rad/s
//! theta_M' = w_M            J_M w_M' = K_t i - b_v w_M - T_cM sat(w_M/w_0) - T_c
//! theta_b' = w_M - w_L      J_L w_L' = T_c - b_L w_L - T_f sat(w_L/w_0) - T_const
//! T_c = k (theta_b - s b) + d (w_M - w_L) on flank s, 0 in the gap
//! b' = 0
//! ```
//! Friction is steep below w_0, so that a load that sticks creeps by a negligible amount. With
//! flank and kind of friction given the model is linear; its exact steps over a servo period are
//! computed once for each. Noise: a torque at the motor and one at the load, and the half gap's own
//! random walk, each constant over a period.
//!
//! After Lagerberg and Egardt, IEEE Trans. Control Syst. Technol. 15 (2007), who measure both
//! sides; here only the motor's position is measured.

use crate::AxisConfig;
use lostmotion_drive::Signals;
use lostmotion_drive::config::check::{AxisConfigError, between, not_negative, positive};
use lostmotion_drive::config::{Gap, Transmission};
use lostmotion_drive::twin::LoadModel;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Number of states.
pub(super) const N: usize = 5;
/// A square matrix of the states.
pub(super) type Square = [[f64; N]; N];

const MOTOR_SPEED: usize = 1;
pub(super) const GAP_ANGLE: usize = 2;
const LOAD_SPEED: usize = 3;
pub(super) const HALF_GAP: usize = 4;
/// States, and the torques at motor and load.
const WITH_TORQUES: usize = N + 2;
/// Speed w_0 below which friction is steep, rad/s at the motor. A choice: 160 um/s on a screw of 20
/// mm; higher takes slow sliding for sticking, lower changes the model at every reading's noise.
const STICKING_RAD_S: f64 = 0.05;
/// Bound of the half gap, in standard deviations of its value at the start: far beyond it the prior
/// was wrong, and the filter has diverged. A choice.
const LARGEST_IN_SPREADS: f64 = 5.0;
/// Least standard deviation of an encoder reading, rad: the error of the model itself over a servo
/// period. Tuned (2e-7 before the half gap was a state).
const LEAST_ENCODER_NOISE_RAD: f64 = 1.5e-6;

/// Mean and covariance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Belief {
    pub(super) mean: [f64; N],
    pub(super) covariance: Square,
}

/// Exact step over a servo period with contact and kind of the load's friction given.
#[derive(Clone, Copy, Debug)]
struct FilterStep {
    /// Of the states, with the half gap's column as on flank 1.
    states: Square,
    /// Response to the torques at motor and load.
    torques: [[f64; 2]; N],
}

/// The filter's model: immutable, shared.
#[derive(Clone, Debug)]
pub(super) struct Filter {
    /// By contact and by sliding.
    steps: [[FilterStep; 2]; 2],
    load: LoadModel,
    torque_constant: f64,
    motor_coulomb: f64,
    /// Variances of the torques at motor and load, (N m)^2.
    noise: [f64; 2],
    /// Variance of the half gap's step, rad2.
    wandering: f64,
    /// Variance of the encoder, rad2.
    reading: f64,
    /// Half gap at the start and its standard deviation, rad.
    first: [f64; 2],
    /// Bound of the half gap, rad.
    largest: f64,
}

/// Noises of the filter's model.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Noises {
    /// Standard deviation of the torques, N m.
    pub(crate) torque_nm: f64,
    /// Half gap at the start and its standard deviation, rad.
    pub(crate) first: [f64; 2],
    /// How far the half gap may wander, rad per square root of s.
    pub(crate) wandering: f64,
}

impl Noises {
    /// From settings: the torques' deviation as part of the rated torque, the gap's spread at the
    /// start, its wandering as part of that spread.
    pub(crate) fn new(
        share: f64,
        spread: Option<Gap>,
        wandering: f64,
        config: &AxisConfig,
    ) -> Noises {
        let spread = 0.5 * spread.map_or(TAU / 200.0, |gap| gap.motor_rad(&config.transmission));
        Noises {
            torque_nm: share * config.motor.rated_torque_nm,
            first: [0.0, spread],
            wandering: wandering * spread,
        }
    }
}

/// Checks the settings that [`Noises::new`] takes.
pub(crate) fn check_noises(
    share: f64,
    spread: Option<Gap>,
    wandering: f64,
    transmission: &Transmission,
) -> Result<(), AxisConfigError> {
    between("torque_noise_share", share, 1e-9, 1.0)?;
    if let Some(gap) = spread {
        gap.check(transmission)
            .map_err(|e| e.within("gap_spread"))?;
        positive("gap_spread", gap.motor_rad(transmission))?;
    }
    not_negative("wandering_share", wandering)
}

impl Filter {
    pub(super) fn new(config: &AxisConfig, noises: &Noises) -> Filter {
        let load = LoadModel::told(config);
        let step = |contact: bool, slides: bool| FilterStep::new(config, &load, contact, slides);
        let count = config
            .drive
            .encoder_counts_per_rev
            .map_or(0.0, |counts| TAU / f64::from(counts));
        let variance = noises.torque_nm * noises.torque_nm;
        Filter {
            steps: [
                [step(false, false), step(false, true)],
                [step(true, false), step(true, true)],
            ],
            load,
            torque_constant: config.motor.torque_constant_nm_per_a,
            motor_coulomb: config.motor.coulomb_nm,
            noise: [variance, variance],
            // random walk: variance in proportion to time
            wandering: noises.wandering * noises.wandering * config.servo_period_s(),
            // rounding to counts: a uniform error has variance count^2/12
            reading: count * count / 12.0 + LEAST_ENCODER_NOISE_RAD * LEAST_ENCODER_NOISE_RAD,
            first: noises.first,
            largest: noises.first[0] + LARGEST_IN_SPREADS * noises.first[1],
        }
    }

    /// The load that the model carries.
    pub(super) fn load(&self) -> &LoadModel {
        &self.load
    }

    /// Standing still in the middle of an unknown gap.
    pub(super) fn initial(&self, position: f64) -> Belief {
        let [half_gap, spread] = self.first;
        // nothing is known of where in the gap the load is: the gap angle spreads over it
        let wide = spread * spread + half_gap * half_gap;
        let mut covariance = [[0.0; N]; N];
        for (index, variance) in [self.reading, 1e-6, wide, 1e-6, spread * spread]
            .into_iter()
            .enumerate()
        {
            covariance[index][index] = variance;
        }
        Belief {
            mean: [position, 0.0, 0.0, 0.0, half_gap],
            covariance,
        }
    }

    /// Prediction over one period with a flank (-1, 1) or without contact (0); `current` is the mean
    /// over the period, A.
    pub(super) fn predict(&self, belief: &mut Belief, side: i8, current: f64) {
        let x = &belief.mean;
        // choose the linear model; a load that sticks has its friction as steep damping in the
        // model, one that slides as a constant torque
        let slides = x[LOAD_SPEED].abs() > STICKING_RAD_S;
        let table = &self.steps[usize::from(side != 0)][usize::from(slides)];
        let motor_friction =
            self.motor_coulomb * (x[MOTOR_SPEED] / STICKING_RAD_S).clamp(-1.0, 1.0);
        let load_friction = if slides {
            self.load.coulomb * x[LOAD_SPEED].signum()
        } else {
            0.0
        };
        // known torques at motor and load
        let torques = [
            self.torque_constant * current - motor_friction,
            -load_friction - self.load.constant,
        ];
        // mean: x <- F x + G u
        let step = table.on_flank(side);
        let mut mean = [0.0; N];
        for (to, (row, gains)) in mean.iter_mut().zip(step.iter().zip(&table.torques)) {
            *to = row.iter().zip(x).map(|(a, x)| a * x).sum::<f64>()
                + gains[0] * torques[0]
                + gains[1] * torques[1];
        }
        belief.mean = mean;
        belief.covariance = self.spread(&step, table, &belief.covariance);
    }

    /// Covariance after a step: F P F' + G Q G', and the walk of the half gap.
    fn spread(&self, step: &Square, table: &FilterStep, before: &Square) -> Square {
        let half: Square =
            step.map(|row| std::array::from_fn(|j| (0..N).map(|k| row[k] * before[k][j]).sum()));
        std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let moved: f64 = (0..N).map(|k| half[i][k] * step[j][k]).sum();
                let noise: f64 = (0..2)
                    .map(|k| table.torques[i][k] * table.torques[j][k] * self.noise[k])
                    .sum();
                let wandering = if i == HALF_GAP && j == HALF_GAP {
                    self.wandering
                } else {
                    0.0
                };
                moved + noise + wandering
            })
        })
    }

    /// Update with a reading of the encoder, rad. Returns the logarithm of its likelihood, less a
    /// constant.
    pub(super) fn update(&self, belief: &mut Belief, reading: f64) -> f64 {
        // innovation, its variance, and the Kalman gain K = P h'/S for h = (1, 0, 0, 0, 0)
        let variance = belief.covariance[0][0] + self.reading;
        let innovation = reading - belief.mean[0];
        let gains: [f64; N] = std::array::from_fn(|i| belief.covariance[i][0] / variance);
        // x <- x + K e,   P <- P - K h P
        let row = belief.covariance[0];
        for (i, gain) in gains.into_iter().enumerate() {
            belief.mean[i] += gain * innovation;
            for (j, entry) in row.into_iter().enumerate() {
                belief.covariance[i][j] -= gain * entry;
            }
        }
        // keep P symmetric and positive against rounding, which the short form of the update does
        // not
        for i in 0..N {
            for j in 0..i {
                let mean = 0.5 * (belief.covariance[i][j] + belief.covariance[j][i]);
                (belief.covariance[i][j], belief.covariance[j][i]) = (mean, mean);
            }
            belief.covariance[i][i] = belief.covariance[i][i].max(1e-24);
        }
        // a half gap is not negative; beyond the bound the prior was wrong
        belief.mean[HALF_GAP] = belief.mean[HALF_GAP].clamp(0.0, self.largest);
        -0.5 * (innovation * innovation / variance + lostmotion_base::math::log(variance))
    }

    /// Mean current over the last period by the trapezoidal rule, A.
    pub(super) fn mean_current(before: f64, signals: &Signals) -> f64 {
        0.5 * (before + signals.current)
    }
}

impl Belief {
    /// How far the flank of a side is pressed, rad; negative without contact.
    pub(super) fn pressed(&self, side: i8) -> f64 {
        f64::from(side) * self.mean[GAP_ANGLE] - self.mean[HALF_GAP]
    }

    /// Standard deviation of the half gap, rad.
    pub(super) fn half_gap_spread(&self) -> f64 {
        self.covariance[HALF_GAP][HALF_GAP].max(0.0).sqrt()
    }

    /// Variance of how far a flank is pressed, rad2.
    pub(super) fn pressed_variance(&self, side: i8) -> f64 {
        let p = &self.covariance;
        (p[GAP_ANGLE][GAP_ANGLE] + p[HALF_GAP][HALF_GAP]
            - 2.0 * f64::from(side) * p[GAP_ANGLE][HALF_GAP])
            .max(0.0)
    }

    /// Whether every number is finite.
    pub(super) fn is_finite(&self) -> bool {
        self.mean
            .iter()
            .chain(self.covariance.iter().flatten())
            .all(|x| x.is_finite())
    }
}

impl FilterStep {
    fn new(config: &AxisConfig, load: &LoadModel, contact: bool, slides: bool) -> FilterStep {
        let (motor_inertia, period) = (config.motor_side_inertia_kgm2(), config.servo_period_s());
        // in the gap the shaft carries nothing
        let (stiffness, damping) = if contact {
            (load.stiffness, load.damping)
        } else {
            (0.0, 0.0)
        };
        // T_f/w_0: slope of the friction of a load that sticks
        let sticky = if slides {
            0.0
        } else {
            load.coulomb / STICKING_RAD_S
        };
        let mut rates = [[0.0; WITH_TORQUES]; WITH_TORQUES];
        // kinematics: theta_M' = w_M, theta_b' = w_M - w_L
        rates[0][MOTOR_SPEED] = 1.0;
        rates[GAP_ANGLE][MOTOR_SPEED] = 1.0;
        rates[GAP_ANGLE][LOAD_SPEED] = -1.0;
        // equations of motion; columns: w_M, theta_b, w_L, b on flank 1, torques at motor and load
        let motor = [
            -config.motor.viscous_nm_s_per_rad - damping,
            -stiffness,
            damping,
            stiffness,
            1.0,
            0.0,
        ];
        let of_load = [
            damping,
            stiffness,
            -load.viscous - sticky - damping,
            -stiffness,
            0.0,
            1.0,
        ];
        for column in 1..WITH_TORQUES {
            rates[MOTOR_SPEED][column] = motor[column - 1] / motor_inertia;
            rates[LOAD_SPEED][column] = of_load[column - 1] / load.inertia;
        }
        // inputs constant over the period become states without dynamics: one exponential gives F
        // and G
        let whole = exponential(&rates, period);
        FilterStep {
            states: std::array::from_fn(|i| std::array::from_fn(|j| whole[i][j])),
            torques: std::array::from_fn(|i| [whole[i][N], whole[i][N + 1]]),
        }
    }

    /// The step on one flank: the half gap acts with its sign.
    fn on_flank(&self, side: i8) -> Square {
        let mut step = self.states;
        for row in step.iter_mut().take(HALF_GAP) {
            row[HALF_GAP] *= f64::from(side);
        }
        step
    }
}

/// Exponential of a matrix times a time, by scaling and squaring.
fn exponential<const M: usize>(rates: &[[f64; M]; M], time: f64) -> [[f64; M]; M] {
    let product = |a: &[[f64; M]; M], b: &[[f64; M]; M]| -> [[f64; M]; M] {
        std::array::from_fn(|i| std::array::from_fn(|j| (0..M).map(|k| a[i][k] * b[k][j]).sum()))
    };
    // row-sum norm, which bounds the eigenvalues
    let norm = rates
        .iter()
        .map(|row| row.iter().map(|a| a.abs()).sum::<f64>())
        .fold(0.0, f64::max)
        * time;
    // halved until the norm is below 1/4, where 14 terms of the series are exact to rounding:
    // 0.25^15/15! < 1e-21
    let (mut halvings, mut part) = (0, 1.0);
    while norm * part > 0.25 && halvings < 60 {
        halvings += 1;
        part *= 0.5;
    }
    let short = rates.map(|row| row.map(|a| a * time * part));
    let identity: [[f64; M]; M] =
        std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
    // Horner: I + A (I + A/2 (I + A/3 (...)))
    let mut whole = identity;
    for order in (1..=14).rev() {
        let scaled = product(&short, &whole).map(|row| row.map(|a| a / f64::from(order)));
        whole = std::array::from_fn(|i| std::array::from_fn(|j| identity[i][j] + scaled[i][j]));
    }
    // exp(A) = exp(A/2)^2
    (0..halvings).for_each(|_| whole = product(&whole, &whole));
    whole
}

/// Changes of flank at which the estimates are compared. A choice: the first contact starts from
/// nothing, the second corrects it, the third confirms it.
const COMPARED_CHANGES: usize = 3;
/// Largest spread of the estimates at these changes, as a part of the largest. A choice: narrower
/// waits for more changes of flank, wider uses a half gap that is off by a fifth.
const AGREEMENT_SHARE: f64 = 0.2;
/// Largest standard deviation of a half gap that is used, as a part of it. A choice: a half gap off
/// by as much leaves a fifth of the error.
const LARGEST_DOUBT: f64 = 0.2;

/// When an estimated half gap may be used: after three changes of flank, once the estimates there
/// agree and the filter's own standard deviation is small. Holds the half gaps at the last changes
/// of flank, oldest first, rad.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Trust {
    side: i8,
    readings: [f64; COMPARED_CHANGES],
    seen: u32,
}

impl Trust {
    /// Takes the flank that is pressed now (0 for none) and the estimate with its standard deviation,
    /// rad. Returns the half gap to use, 0 while it is not trusted.
    pub(super) fn step(&mut self, flank: i8, half_gap: f64, spread: f64) -> f64 {
        // the first flank ever pressed is no change: the filter has seen nothing of the gap yet
        if flank != 0 && flank != self.side {
            if self.side != 0 {
                self.readings.rotate_left(1);
                self.readings[COMPARED_CHANGES - 1] = half_gap;
                self.seen = self.seen.saturating_add(1);
            }
            self.side = flank;
        }
        // the present estimate belongs to the group, so that a jump ends the trust at once
        let most = self
            .readings
            .iter()
            .fold(half_gap, |most, reading| most.max(*reading));
        let least = self
            .readings
            .iter()
            .fold(half_gap, |least, reading| least.min(*reading));
        let sure = self.seen >= COMPARED_CHANGES as u32
            && most - least <= AGREEMENT_SHARE * most
            && spread <= LARGEST_DOUBT * half_gap;
        if sure { half_gap } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lostmotion_base::math;

    #[test]
    fn the_exponential_of_an_oscillator_is_its_closed_form() {
        let (w, t) = (1000.0, 3e-3);
        let step = exponential(&[[0.0, 1.0], [-w * w, 0.0]], t);
        let (s, c) = math::sin_cos(w * t);
        for (found, wanted) in [
            (step[0][0], c),
            (step[0][1], s / w),
            (step[1][0], -w * s),
            (step[1][1], c),
        ] {
            assert!(
                (found - wanted).abs() < 1e-10 * wanted.abs().max(1.0),
                "{found} {wanted}"
            );
        }
    }

    #[test]
    fn three_changes_that_agree_are_trusted_and_a_jump_ends_it() {
        let mut trust = Trust::default();
        let mut used = Vec::new();
        for (n, half_gap) in [1.0, 1.0, 0.9, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0]
            .into_iter()
            .enumerate()
        {
            let flank = if n % 2 == 0 { 1 } else { -1 };
            used.push(trust.step(flank, half_gap, 0.1 * half_gap));
        }
        assert_eq!(used, [0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 2.0, 2.0]);
        assert_eq!(trust.step(0, 2.0, 0.5), 0.0);
        assert_eq!(trust.step(0, 2.0, 0.1), 2.0);
    }
}
