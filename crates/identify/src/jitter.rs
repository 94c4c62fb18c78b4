//! Rows that were not sampled when the log says.
//!
//! A motor that moves with the speed `v` is read `v delta` too far where its row was sampled
//! `delta` late. Fourth differences of the position leave of a smooth motion next to nothing, and
//! of such errors `sqrt(70) v` times their standard deviation. What they leave where the motor is
//! slow is noise of the position itself and is taken off.

use lostmotion_base::math::quantile;

use crate::{
    contact::MEDIAN_OF_NORMAL,
    log::BacklashLog,
    settings::FitSettings,
    window::{self, WindowSample},
};

/// Share of the largest speed from which on a sample counts. A choice: errors grow with the speed,
/// everything else does not.
const FAST_SHARE: f64 = 0.3;
/// Share of the largest speed up to which a sample shows the noise of the position alone. A choice:
/// jitter leaves there a tenth of what it leaves of the fast ones.
const SLOW_SHARE: f64 = 0.1;
/// Quantile of the speeds that counts as the largest: single jumps, as of a motor that crosses its
/// gap, are no speed.
const FASTEST_QUANTILE: f64 = 0.99;
/// Sum of the squares of 1, -4, 6, -4, 1.
const FOURTH_SQUARES: f64 = 70.0;

/// How much of the noise of the position is taken off. A choice: twice its deviation, since counts
/// of an even motion are not independent.
const FLOOR_FACTOR: f64 = 2.0;
/// Noise of the acceleration from jitter, in parts of the acceleration itself, up to which windows
/// stay as they are. A choice: instruments take it out, but weak ones no longer do.
const NOISE_SHARE: f64 = 0.1;
/// Longest half-width of windows against jitter, s. A choice: strokes last some tenths of a second.
const MAX_HALF_WINDOW_S: f64 = 1e-2;
/// Half-width of the windows that tell the usual acceleration, s.
const CALM_HALF_WINDOW_S: f64 = 1e-2;

/// Standard deviation of the sampling time about the times that the log tells, s; zero where the
/// motor stands.
pub(crate) fn jitter_s(log: &BacklashLog) -> f64 {
    let period_s = log.period_s();
    // Speed and scatter of the position about each sample.
    let scatter: Vec<[f64; 2]> = log
        .motor()
        .windows(5)
        .map(|w| {
            let fourth = w[0] - 4.0 * w[1] + 6.0 * w[2] - 4.0 * w[3] + w[4];
            let deviation = fourth.abs() / (MEDIAN_OF_NORMAL * FOURTH_SQUARES.sqrt());
            [(w[4] - w[0]).abs() / (4.0 * period_s), deviation]
        })
        .collect();
    let speeds = scatter.iter().map(|[speed, _]| *speed).collect();
    let fastest = quantile(speeds, FASTEST_QUANTILE);
    if fastest <= 0.0 {
        return 0.0;
    }
    let fast = || {
        let is_fast = |at: &&[f64; 2]| at[0] > FAST_SHARE * fastest;
        scatter.iter().filter(is_fast)
    };
    let usual = quantile(fast().map(|[speed, _]| *speed).collect(), 0.5);
    let late = quantile(fast().map(|[speed, by]| by / speed).collect(), 0.5);
    // The encoder's counts leave fourth differences, too: a twelfth of a squared step each.
    let counts = log.motor_step_rad() / 12.0_f64.sqrt();
    let slow: Vec<f64> = scatter
        .iter()
        .filter(|[speed, _]| *speed < SLOW_SHARE * fastest)
        .map(|[_, by]| *by)
        .collect();
    let noise = if slow.is_empty() {
        counts
    } else {
        quantile(slow, 0.5).max(counts)
    };
    let floor = FLOOR_FACTOR * noise / usual;
    (late * late - floor * floor).max(0.0).sqrt()
}

/// Half-width of windows in which this jitter leaves the acceleration certain enough, s, at least
/// as given. Second differences over `H` have the noise `sqrt(6) v delta/H^2`.
pub(crate) fn half_window_s(log: &BacklashLog, jitter_s: f64, given_s: f64) -> f64 {
    let half = (CALM_HALF_WINDOW_S / log.period_s()).round().max(1.0) as usize;
    let windows = window::averages(log, &FitSettings::default(), 0.0, half);
    let count = windows.len().max(1) as f64;
    let rms = |of: fn(&WindowSample) -> f64| {
        (windows.iter().map(|w| of(w) * of(w)).sum::<f64>() / count).sqrt()
    };
    let (speed, acceleration) = (rms(|w| w.velocity_rad_s), rms(|w| w.acceleration_rad_s2));
    if acceleration <= 0.0 {
        return given_s;
    }
    let square = 6.0_f64.sqrt() * speed * jitter_s / (NOISE_SHARE * acceleration);
    given_s.max(square.sqrt().min(MAX_HALF_WINDOW_S))
}

#[cfg(test)]
mod tests {
    use super::*;
    use lostmotion_base::{Random, math};

    #[test]
    fn jitter_of_a_sine_is_found_and_none_is_none() {
        let mut random = Random::new(3);
        for jitter in [0.0, 20e-6, 200e-6] {
            let motor: Vec<f64> = (0..5000)
                .map(|n| f64::from(n) * 1e-3 + jitter * random.normal())
                .map(|t| 10.0 * math::sin(6.0 * t))
                .collect();
            let zero = vec![0.0; motor.len()];
            let log = BacklashLog::new(1e-3, motor, zero.clone(), zero).unwrap();
            let found = jitter_s(&log);
            assert!(
                (found - jitter).abs() < 0.05 * jitter + 1e-8,
                "{jitter}: {found}"
            );
            // noise over acceleration: sqrt(6) delta/H^2 v/a, with v/a = 1/6 s
            let half = half_window_s(&log, found, 2.5e-3);
            let wanted = (6.0_f64.sqrt() * jitter / 6.0 / NOISE_SHARE).sqrt();
            let wanted = wanted.clamp(2.5e-3, MAX_HALF_WINDOW_S);
            assert!(
                (half / wanted - 1.0).abs() < 0.03,
                "{jitter}: {half} {wanted}"
            );
        }
    }
    #[test]
    fn noise_of_the_position_and_a_jump_are_no_jitter() {
        let mut random = Random::new(5);
        let motor: Vec<f64> = (0..5000)
            .map(|n| (f64::from(n), math::sin(6e-3 * f64::from(n))))
            .map(|(n, x)| x + 1e-4 * random.normal() + if n < 2000.0 { 0.0 } else { 0.5 })
            .collect();
        let zero = vec![0.0; motor.len()];
        let log = BacklashLog::new(1e-3, motor, zero.clone(), zero).unwrap();
        assert!(jitter_s(&log) < 1e-9, "{}", jitter_s(&log));
    }
}
