//! An hour of motion: does a method that learns stay what it is?
//!
//! One axis of a cell of the matrix makes turns of a circle at the cell's feed, five and a rest,
//! again and again. Beside it run the same axis without compensation and without its gap. A cell
//! that drifts does so over the whole time.

use crate::error::StudyError;
use crate::matrix::factor::{Cell, FEED, SHAPE};
use crate::matrix::machine;
use lostmotion_base::units::UM_PER_MM;
use lostmotion_base::{Clock, math};
use lostmotion_drive::{AxisOutput, AxisRunner, Engagement, Setpoint};
use lostmotion_methods::{AxisConfig, MethodId, build_runner};
use std::f64::consts::TAU;

/// Turns of the circle in a row. A choice.
const TURNS: f64 = 5.0;
/// Rest after them, s: long enough for a load without friction to float away. A choice.
const REST_S: f64 = 0.5;
/// Radius where the cell's motion is no circle, mm. A choice.
const RADIUS_MM: f64 = 25.0;
/// Largest speed over the mean speed of the turns: that of a quintic from rest to rest, 15/8.
const PEAK_OVER_MEAN: f64 = 1.875;
/// Stretches that the time is divided into: five minutes of an hour each. A choice.
pub const STRETCHES: usize = 12;
/// A cell in the middle of the matrix that drifts.
pub const USUAL: &str = "circle50-f3000-ccw-g20-t10-v0-j2-e20-drift";
/// Setpoints that go to the axes at once: 1 s. A choice.
const CHUNK_SETPOINTS: u64 = 1000;

/// What a stretch of the time showed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stretch {
    /// Its end, s.
    pub until_s: f64,
    /// RMS of what the gap adds to the load's place, um: without compensation, with the method.
    pub rms_um: [f64; 2],
    /// Largest of that.
    pub max_um: [f64; 2],
    /// Mean relative error of the estimated half gap while load and motor are in contact; `None`
    /// if the method estimates none.
    pub gap_error: Option<f64>,
}

/// Sums of a stretch.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    squares: [f64; 2],
    max: [f64; 2],
    ticks: u64,
    gap_error: f64,
    gap_ticks: u64,
}

impl Sums {
    /// The figures of the stretch that ends at `until_s`.
    fn stretch(&self, until_s: f64) -> Stretch {
        Stretch {
            until_s,
            rms_um: self
                .squares
                .map(|squares| (squares / self.ticks.max(1) as f64).sqrt()),
            max_um: self.max,
            gap_error: (self.gap_ticks > 0).then(|| self.gap_error / self.gap_ticks as f64),
        }
    }
}

/// Runs an axis of a cell with a method for a time, s; a result for each of [`STRETCHES`] equal
/// stretches.
///
/// # Errors
/// A method that does not suit the axis.
pub fn run(cell: &Cell, method: MethodId, seconds: f64) -> Result<Vec<Stretch>, StudyError> {
    let config = AxisConfig {
        drift: machine::drift(cell, seconds),
        ..machine::axis(cell)?
    };
    // The reference without a gap, the axis left alone, and the method: same setpoints for all
    // three.
    let runners = [
        (config.without_gap(), MethodId::NONE),
        (config.clone(), MethodId::NONE),
        (config.clone(), method),
    ];
    let mut axes = Vec::with_capacity(runners.len());
    for (config, method) in &runners {
        axes.push((build_runner(config, *method, 0.0)?, AxisOutput::new(true)));
    }
    let ticks = (seconds / Clock::CNC.period_s()).ceil() as u64;
    let motion = Motion::of(cell);
    // In chunks, so that memory does not grow with the time.
    let mut stretches = Vec::with_capacity(STRETCHES);
    let (mut sums, mut tick) = (Sums::default(), 0);
    for index in 1..=STRETCHES as u64 {
        let end = ticks * index / STRETCHES as u64;
        while tick < end {
            let until = end.min(tick + CHUNK_SETPOINTS);
            let points: Vec<Setpoint> = (tick..until)
                .map(|tick| motion.at(Clock::CNC.seconds(tick)))
                .collect();
            chunk(&mut axes, &points, &config, tick, &mut sums)?;
            tick = until;
        }
        stretches.push(std::mem::take(&mut sums).stretch(Clock::CNC.seconds(end)));
    }
    Ok(stretches)
}

/// A runner and its output of the present chunk.
type Axis = (Box<dyn AxisRunner>, AxisOutput);

/// Runs all three axes over a chunk and adds up what the gap causes.
fn chunk(
    axes: &mut [Axis],
    points: &[Setpoint],
    config: &AxisConfig,
    from: u64,
    sums: &mut Sums,
) -> Result<(), StudyError> {
    for (runner, out) in axes.iter_mut() {
        out.clear();
        runner.push(points, out)?;
    }
    let [rigid, none, with] = axes else {
        return Ok(());
    };
    let time_s = Clock::CNC.seconds(from);
    // A gap that drifts: the true one at the start of the chunk.
    let half_gap = 0.5
        * config.reflected_load().gap_rad
        * config.drift.gap.map_or(1.0, |change| change.at(time_s));
    let loads = rigid
        .1
        .load
        .iter()
        .zip(none.1.load.iter().zip(&with.1.load));
    for ((rigid, (none, load)), sample) in loads.zip(with.1.trace.iter().flatten()) {
        // Deviation from the axis without a gap: servo lag and planning drop out.
        let off = [none, load].map(|load| UM_PER_MM * (load - rigid));
        for (which, off) in off.into_iter().enumerate() {
            sums.squares[which] += off * off;
            sums.max[which] = sums.max[which].max(off.abs());
        }
        sums.ticks += 1;
        // The gap angle is the half gap only in contact.
        if sample.engagement != Engagement::Gap
            && sample.engagement_estimate != Engagement::Gap
            && sample.gap_angle_estimate.is_finite()
        {
            sums.gap_error += (sample.gap_angle_estimate.abs() / half_gap - 1.0).abs();
            sums.gap_ticks += 1;
        }
    }
    Ok(())
}

/// Turns and rests.
#[derive(Clone, Copy, Debug)]
struct Motion {
    radius_mm: f64,
    turning_s: f64,
}

impl Motion {
    fn of(cell: &Cell) -> Motion {
        let radius_mm = if cell.level_name(SHAPE).starts_with("circle") {
            cell.number(SHAPE)
        } else {
            RADIUS_MM
        };
        Motion {
            radius_mm,
            // So long that the peak speed of the quintic is the feed.
            turning_s: PEAK_OVER_MEAN * TURNS * TAU * radius_mm / (cell.number(FEED) / 60.0),
        }
    }

    /// The setpoint at a time, mm: angles go from rest to rest on a quintic.
    fn at(&self, time_s: f64) -> Setpoint {
        let span = self.turning_s;
        let t = time_s - ((time_s / (span + REST_S)).floor() * (span + REST_S));
        // Quintic of the angle with its first two derivatives, then the circle's x and its chain
        // rule.
        let (u, turns) = ((t / span).min(1.0), TURNS * TAU);
        let angle = turns * u * u * u * (10.0 - u * (15.0 - 6.0 * u));
        let rate = turns / span * 30.0 * u * u * (1.0 - u) * (1.0 - u);
        let change = turns / (span * span) * 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u);
        let (sin, cos) = math::sin_cos(angle);
        let r = self.radius_mm;
        Setpoint::moving(
            r * (1.0 - cos),
            r * sin * rate,
            r * (cos * rate * rate + sin * change),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_motion_is_smooth_and_as_fast_as_the_cell() {
        let motion = Motion::of(&Cell::parse(USUAL).unwrap());
        let points: Vec<Setpoint> = (0..80_000)
            .map(|n| motion.at(1e-3 * f64::from(n)))
            .collect();
        let most = points
            .iter()
            .map(|point| point.velocity.unwrap().abs())
            .fold(0.0, f64::max);
        assert!(most <= 50.0 && most > 0.95 * 50.0, "{most}");
        for pair in points.windows(2) {
            let mean = 0.5e-3 * (pair[0].velocity.unwrap() + pair[1].velocity.unwrap());
            assert!((pair[1].position - pair[0].position - mean).abs() < 1e-6);
        }
    }

    #[test]
    fn minutes_show_a_method_that_learns_and_stays() {
        let stretches = run(&Cell::parse(USUAL).unwrap(), MethodId::ADAPTIVE, 240.0).unwrap();
        assert_eq!(stretches.len(), STRETCHES);
        for stretch in &stretches[1..] {
            assert!(stretch.rms_um[1] < 0.05 * stretch.rms_um[0], "{stretch:?}");
            assert!(stretch.gap_error.unwrap() < 0.015, "{stretch:?}");
        }
    }
}
