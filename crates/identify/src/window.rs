//! From the log to pairs of position difference and contact torque.
//!
//! Motor acceleration is not in the log and must not be obtained by filtering the position alone: a
//! filter on one side of `y = s b + c T + o` and not on the other biases `c` and with it `b`. So
//! both sides are averaged with one triangular window of half-width `H`, `w(t) = (H - |t|)/H^2`.
//! Integrating by parts twice turns the average of the acceleration into the plain difference
//! `(theta(t+H) - 2 theta(t) + theta(t-H))/H^2`, exact whatever the motion, and the average of the
//! velocity, as well as of the rate of the position difference, into the difference of two plain
//! means. Windows are placed one half-width apart: there the triangles add up to one, so every
//! sample counts once and none of the log is lost although it shrinks by that factor.

use crate::{log::BacklashLog, settings::FitSettings};

/// Steps of the motor's encoder that either half of a window has to cover for the direction of the
/// motor to be certain. Derived: a motor at rest toggles between two neighbouring counts.
const LEAST_MOVE_STEPS: f64 = 1.5;

/// Averages over one window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WindowSample {
    /// Mean motor position against the log's first, rad.
    pub position_rad: f64,
    /// Mean of `theta_M - theta_L`, rad.
    pub difference_rad: f64,
    /// Mean rate of `theta_M - theta_L`, rad/s.
    pub rate_rad_s: f64,
    /// Mean acceleration of the motor, rad/s2.
    pub acceleration_rad_s2: f64,
    /// Mean velocity of the motor, rad/s.
    pub velocity_rad_s: f64,
    /// Mean contact torque, N m.
    pub torque_nm: f64,
    /// Whether the motor moved one way through the whole window, so that the direction of its own
    /// friction is certain; true where it has none.
    pub one_way: bool,
    /// Whether no row of the log is missing in it.
    pub whole: bool,
}

/// Half-width of the window in samples, at least 1.
pub fn half_width(settings: &FitSettings, period_s: f64) -> usize {
    let samples = (settings.half_window_s / period_s).round();
    // a float-to-int cast saturates, and a window longer than the log is refused by its caller
    (samples as usize).max(1)
}

/// The log as window averages, one every `half` samples, for a motor of this inertia; empty if the
/// log is shorter than a window.
pub fn averages(
    log: &BacklashLog,
    settings: &FitSettings,
    inertia_kgm2: f64,
    half: usize,
) -> Vec<WindowSample> {
    let span = half.saturating_mul(2).saturating_add(1);
    if log.len() < span {
        return Vec::new();
    }
    let least_move = LEAST_MOVE_STEPS * log.motor_step_rad();
    (0..=(log.len() - span) / half)
        .map(|n| average(log, settings, inertia_kgm2, half, n * half, least_move))
        .collect()
}

fn average(
    log: &BacklashLog,
    settings: &FitSettings,
    inertia_kgm2: f64,
    half: usize,
    start: usize,
    least_move: f64,
) -> WindowSample {
    let motor = &log.motor()[start..=start + 2 * half];
    let load = &log.load()[start..=start + 2 * half];
    let current = &log.current()[start..=start + 2 * half];
    // Sums over the triangle, and over its derivative: the trapezoid rule of two plain means.
    let (mut difference, mut torque_current, mut swing, mut slip) = (0.0, 0.0, 0.0, 0.0);
    let mut place = 0.0;
    let base = log.motor()[0];
    let (middle, between) = (motor[half], motor[half] - load[half]);
    for k in 0..=2 * half {
        let offset = half.abs_diff(k);
        let weight = (half - offset) as f64;
        difference += weight * (motor[k] - load[k]);
        place += weight * (motor[k] - base);
        torque_current += weight * current[k];
        // trapezoid rule over each half; the middle sample falls out
        let trapezoid = if offset == half { 0.5 } else { 1.0 };
        let trapezoid = if k > half { trapezoid } else { -trapezoid };
        swing += trapezoid * (motor[k] - middle);
        slip += trapezoid * (motor[k] - load[k] - between);
    }
    // The triangle's weights add up to half^2 samples.
    let area = (half * half) as f64;
    let width_s = half as f64 * log.period_s();
    let velocity = swing / (area * log.period_s());
    // The exact mean of the acceleration under the triangle, whatever the motion.
    let acceleration = (motor[2 * half] - 2.0 * middle + motor[0]) / (width_s * width_s);
    // A motor that stands still has no direction of friction.
    let coulomb = if velocity == 0.0 {
        0.0
    } else {
        settings.motor_coulomb_nm * velocity.signum()
    };
    let moves = [middle - motor[0], motor[2 * half] - middle];
    let one_way = settings.motor_coulomb_nm <= 0.0
        || moves.iter().all(|by| *by > least_move)
        || moves.iter().all(|by| *by < -least_move);
    WindowSample {
        one_way,
        whole: !log.touches_lost(start..=start + 2 * half),
        position_rad: place / area,
        difference_rad: difference / area,
        rate_rad_s: slip / (area * log.period_s()),
        acceleration_rad_s2: acceleration,
        velocity_rad_s: velocity,
        torque_nm: settings.torque_constant_nm_per_a * torque_current / area
            - inertia_kgm2 * acceleration
            - settings.motor_viscous_nm_s_per_rad * velocity
            - coulomb,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn log(motion: impl Fn(f64) -> (f64, f64, f64)) -> BacklashLog {
        let columns: Vec<_> = (0..101).map(|k| motion(f64::from(k) * 1e-3)).collect();
        let column = |pick: fn(&(f64, f64, f64)) -> f64| columns.iter().map(pick).collect();
        BacklashLog::new(1e-3, column(|c| c.0), column(|c| c.1), column(|c| c.2)).unwrap()
    }

    #[test]
    fn a_parabola_gives_its_own_torque() {
        // theta = 3 + 5 t + 7 t^2: acceleration 14, velocity 5 + 14 t, both exact under a symmetric
        // window
        let log = log(|t| {
            (
                3.0 + 5.0 * t + 7.0 * t * t,
                2.0 + 2.0 * t + 7.0 * t * t,
                2.0,
            )
        });
        let settings = FitSettings {
            motor_viscous_nm_s_per_rad: 0.1,
            motor_coulomb_nm: 0.25,
            ..FitSettings::new(1.5, None)
        };
        for half in [1, 4, 10] {
            let averages = averages(&log, &settings, 0.01, half);
            assert_eq!(averages.len(), 100 / half - 1);
            for (n, sample) in averages.iter().enumerate() {
                let t = ((n + 1) * half) as f64 * 1e-3;
                let torque = 1.5 * 2.0 - 0.01 * 14.0 - 0.1 * (5.0 + 14.0 * t) - 0.25;
                assert!(
                    (sample.torque_nm - torque).abs() < 1e-9,
                    "{} {torque}",
                    sample.torque_nm
                );
                assert!(
                    (sample.difference_rad - 1.0 - 3.0 * t).abs() < 1e-12
                        && (sample.rate_rad_s - 3.0).abs() < 1e-9
                );
                assert!((sample.acceleration_rad_s2 - 14.0).abs() < 1e-7);
            }
        }
    }

    #[test]
    fn windows_share_the_log_out_without_loss() {
        // a spike of one ampere sample weighs 1/half wherever it stands, so long as windows
        // surround it
        for spike in 20..40 {
            let log = log(|t| {
                (
                    0.0,
                    0.0,
                    if (t - f64::from(spike) * 1e-3).abs() < 1e-9 {
                        1.0
                    } else {
                        0.0
                    },
                )
            });
            let sum: f64 = averages(&log, &FitSettings::new(1.0, None), 0.0, 10)
                .iter()
                .map(|sample| sample.torque_nm)
                .sum();
            assert!((sum - 0.1).abs() < 1e-12, "{spike}: {sum}");
        }
    }

    #[test]
    fn a_short_log_has_no_windows() {
        let log = log(|t| (t, t, 0.0));
        assert!(averages(&log, &FitSettings::new(1.0, None), 0.0, 51).is_empty());
        assert!(averages(&log, &FitSettings::new(1.0, None), 0.0, usize::MAX).is_empty());
    }
}
