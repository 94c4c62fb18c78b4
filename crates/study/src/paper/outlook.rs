//! The paper's outlook: stiffness and damping estimated while the axis runs, compared with the
//! truth.

use super::motion::Move;
use crate::error::StudyError;
use crate::matrix::{Cell, machine};
use lostmotion_base::Clock;
use lostmotion_drive::{AxisOutput, Setpoint};
use lostmotion_methods::{AxisConfig, MethodId, build_runner};
use lostmotion_report::number::fixed;
use lostmotion_report::svg::{Series, SeriesPicture, series};
use std::fmt::Write;

/// Number of times the move is made there and back: enough for readings to agree. A choice.
const STROKES: usize = 4;
/// An axis of a mill: 20 um of gap, a tenth of the rated torque as friction, twice the motor's
/// inertia.
const MILL: &str = "circle50-f3000-ccw-g20-t10-v0-j2-ideal-steady";
/// Encoders, counts per turn; 0: ideal. A choice: without noise, a fine one, a common one.
const ENCODER_COUNTS: [u32; 3] = [0, 1 << 23, 1 << 20];
/// Methods beside which the estimator runs: one whose load inertia is unknown to it, one that
/// learns it.
const METHODS: [MethodId; 2] = [MethodId::PUBLISHED, MethodId::ADAPTIVE];
/// A point is drawn every this many servo ticks: 10 ms. A choice.
const DRAWN_EVERY_TICKS: usize = 40;

/// One run with its estimates.
#[derive(Clone, Debug)]
pub struct ShaftTrial {
    /// Which axis.
    pub axis: &'static str,
    /// With which method.
    pub method: MethodId,
    /// Counts per turn; 0: ideal.
    pub counts: u32,
    /// True stiffness, N m/rad, and damping, N m s/rad.
    pub truth: [f64; 2],
    /// Time, s, and estimates; NaN until something is known.
    pub estimates: Vec<(f64, [f64; 2])>,
}

impl ShaftTrial {
    /// When an estimate is reported first, s; 0 for the stiffness, 1 for the damping.
    pub fn told_s(&self, which: usize) -> Option<f64> {
        self.estimates
            .iter()
            .find(|(_, value)| value[which].is_finite())
            .map(|(time, _)| *time)
    }

    /// Estimate over truth less 1 at the end; `None` if there is no estimate.
    pub fn off(&self, which: usize) -> Option<f64> {
        let (_, last) = self.estimates.last()?;
        last[which]
            .is_finite()
            .then(|| last[which] / self.truth[which] - 1.0)
    }
}

/// Runs the paper's bench and an axis of a mill with the paper's kind of move, there and back four
/// times.
///
/// # Errors
/// None for the presets.
pub fn shaft_trials() -> Result<Vec<ShaftTrial>, StudyError> {
    let axes = [
        ("the paper's bench", AxisConfig::paper()),
        ("an axis of a mill", machine::axis(&Cell::parse(MILL)?)?),
    ];
    let mut trials = Vec::new();
    for (axis, config) in &axes {
        for counts in ENCODER_COUNTS {
            for method in METHODS {
                trials.push(run(axis, config, counts, method)?);
            }
        }
    }
    Ok(trials)
}

/// Runs one axis with an encoder and a method.
fn run(
    axis: &'static str,
    config: &AxisConfig,
    counts: u32,
    method: MethodId,
) -> Result<ShaftTrial, StudyError> {
    let mut config = config.clone();
    config.drive.encoder_counts_per_rev = (counts > 0).then_some(counts);
    config.compensation.estimate_shaft = true;
    // The move is in motor rad, setpoints are in the axis' unit.
    let per_rad = 1.0 / config.transmission.motor_rad_per_unit();
    let scaled = |point: Setpoint| Setpoint {
        position: point.position * per_rad,
        velocity: point.velocity.map(|value| value * per_rad),
        acceleration: point.acceleration.map(|value| value * per_rad),
        ..point
    };
    let points: Vec<Setpoint> = Move::CHOSEN.setpoints().into_iter().map(scaled).collect();
    let mut runner = build_runner(&config, method, 0.0)?;
    let mut out = AxisOutput::new(true);
    // The move ends where it began: it can be repeated without a jump.
    for _ in 0..STROKES {
        runner.push(&points, &mut out)?;
    }
    let load = config.reflected_load();
    let estimates = out.trace.iter().flatten().zip(0..).map(|(s, tick)| {
        (
            Clock::SERVO.seconds(tick),
            [s.stiffness_estimate, s.damping_estimate],
        )
    });
    Ok(ShaftTrial {
        axis,
        method,
        counts,
        truth: [load.stiffness_nm_per_rad, load.damping_nm_s_per_rad],
        estimates: estimates.collect(),
    })
}

/// The result as Markdown.
pub fn markdown(trials: &[ShaftTrial]) -> String {
    let mut out = "## The outlook: stiffness and damping while the axis runs\n\n".to_owned();
    let _ = writeln!(
        out,
        "From motor position, current and the motor's data alone (`estimate_shaft`), whatever the method; the move above, {STROKES} times there and back. What tells a shaft is a blow or\n\
         a step that makes motor and load swing against each other by some ten steps of the encoder: until then, and where no explanation fits, nothing is told.\n"
    );
    out.push_str("| axis | method | encoder | stiffness, N m/rad | told after, s | at the end off by | damping, N m s/rad | told after, s | at the end off by |\n");
    out.push_str("|---|---|---|--:|--:|--:|--:|--:|--:|\n");
    for trial in trials {
        // Counts are powers of two, and people know encoders by their bits.
        let encoder = if trial.counts == 0 {
            "ideal".to_owned()
        } else {
            format!("2^{}", trial.counts.trailing_zeros())
        };
        let _ = write!(out, "| {} | `{}` | {encoder} |", trial.axis, trial.method);
        for which in [0, 1] {
            let told = trial
                .told_s(which)
                .map_or("not excited".to_owned(), |time| fixed(time, 2));
            let off = trial
                .off(which)
                .map_or("-".to_owned(), |off| format!("{:+.2} %", 100.0 * off));
            let _ = write!(
                out,
                " {} | {told} | {off} |",
                fixed(trial.truth[which], if which == 0 { 0 } else { 3 })
            );
        }
        out.push('\n');
    }
    out.push('\n');
    out
}

/// Estimates over truth, one picture for the stiffness and one for the damping.
pub fn figures(trials: &[ShaftTrial]) -> Vec<(String, String)> {
    ["stiffness", "damping"]
        .iter()
        .enumerate()
        .map(|(which, name)| (format!("outlook_{name}.svg"), figure(trials, which, name)))
        .collect()
}

fn figure(trials: &[ShaftTrial], which: usize, name: &str) -> String {
    let curve = |trial: &ShaftTrial| {
        let point =
            |(time, value): &(f64, [f64; 2])| [*time, 100.0 * value[which] / trial.truth[which]];
        let encoder = if trial.counts == 0 {
            "ideal".to_owned()
        } else {
            format!("2^{}", trial.counts.trailing_zeros())
        };
        Series {
            name: format!(
                "{}, {}, {encoder}",
                if trial.axis.contains("mill") {
                    "mill"
                } else {
                    "bench"
                },
                trial.method
            ),
            points: trial
                .estimates
                .iter()
                .step_by(DRAWN_EVERY_TICKS)
                .map(point)
                .collect(),
        }
    };
    let picture = SeriesPicture {
        title: format!("Outlook: {name} of the shaft, estimated online"),
        x_label: "time, s".to_owned(),
        y_label: "estimate over truth, %".to_owned(),
    };
    // The finest and the coarsest encoder; the one in between would hide both curves.
    let mut curves: Vec<Series> = trials
        .iter()
        .filter(|trial| trial.counts != ENCODER_COUNTS[1] && trial.method == METHODS[1])
        .map(curve)
        .collect();
    // One run with the other method: the estimate does not hang on the compensator.
    curves.extend(trials.iter().find(|trial| trial.counts == 0).map(curve));
    let end = trials
        .iter()
        .filter_map(|trial| trial.estimates.last())
        .map(|(time, _)| *time)
        .fold(0.0, f64::max);
    curves.push(Series {
        name: "truth".to_owned(),
        points: vec![[0.0, 100.0], [end, 100.0]],
    });
    series(&picture, &curves)
}
