//! What to measure on a machine first: how far the contour error moves when a value of the
//! description is off by what it may be off.
//!
//! Every value of every axis that the part moves is put up and down in a run of its own, while what
//! the control is told stays; the five that change the largest contour error most come first. A
//! value may be off by [`MeasureOptions::share`], a gap by `gap_uncertainty` where the axis says it,
//! a guess by a factor of [`MeasureOptions::guess`]. The share of a value is its change squared in
//! the sum of all, as of errors that do not depend on each other. Runs: one, and two for each value.

use crate::error::SimError;
use crate::machine::{Machine, MachineAxis};
use crate::observer::{MotorPoint, Observer};
use crate::options::SimulateOptions;
use crate::program::Program;
use crate::simulation::Simulation;
use crate::testpart::{TestKind, TestOptions, program};
use lostmotion_base::AxisId;
use lostmotion_drive::config::{Gap, Load, Reflected};
use lostmotion_methods::{AxisConfig, Misled, Told, USUAL_SHARE};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// Version of [`Measurements`].
pub const MEASURE_SCHEMA: u32 = 1;

/// How many come first.
const FIRST: usize = 5;

/// Radius of the circle that is run where no part is given, mm: some seconds, with both reversals.
const RADIUS_MM: f64 = 10.0;

/// A value of an axis that a description may have wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Value {
    Told(Told),
    Inertia,
    PositionGain,
    VelocityGain,
}

impl Value {
    const ALL: [Value; 6] = [
        Value::Told(Told::Gap),
        Value::Told(Told::Friction),
        Value::Told(Told::Stiffness),
        Value::Inertia,
        Value::PositionGain,
        Value::VelocityGain,
    ];

    fn name(self) -> &'static str {
        match self {
            Value::Told(told) => told.name(),
            Value::Inertia => "moving mass",
            Value::PositionGain => "position gain",
            Value::VelocityGain => "velocity gain",
        }
    }

    /// How keys of machine files begin that hold it.
    fn stems(self) -> &'static [&'static str] {
        match self {
            Value::Told(Told::Gap) => &["gap_"],
            Value::Told(Told::Friction) => &["coulomb_", "viscous_"],
            Value::Told(_) => &["stiffness_"],
            Value::Inertia => &["mass_kg", "inertia_kgm2"],
            Value::PositionGain => &["position_gain"],
            Value::VelocityGain => &["velocity_gain"],
        }
    }

    /// How it is measured.
    fn how(self) -> &'static str {
        match self {
            Value::Told(Told::Gap) => {
                "a dial gauge at the table, coming from both sides: `axis testpart --for reversal`; or a ballbar: `--for ballbar`"
            }
            Value::Told(Told::Friction) => {
                "a log of `axis testpart --for friction` with the current, then `axis identify`"
            }
            Value::Told(_) => {
                "a log of `axis testpart --for commission` with a scale at the load, then `axis identify`; or a known force against a dial gauge"
            }
            Value::Inertia => {
                "weigh it; or a log of `axis testpart --for commission` with the current, then `axis identify`"
            }
            Value::PositionGain => {
                "read it from the drive; or a log at a steady feed: speed over following error"
            }
            Value::VelocityGain => "read it from the drive, in its units",
        }
    }

    /// The axis with the value times a factor; what its control is told stays.
    fn times(self, axis: &AxisConfig, factor: f64) -> AxisConfig {
        let mut changed = match self {
            Value::Told(what) => Misled { what, factor }.of(axis),
            _ => axis.clone(),
        };
        changed.compensation = axis.compensation.clone();
        // A control that is told nothing by its settings was told the gap of the description.
        let motor_rad = axis.reflected_load().gap_rad;
        changed
            .compensation
            .tell_missing_gap(Gap::MotorRad(motor_rad));
        match self {
            Value::Told(_) => {}
            Value::Inertia => {
                let load = axis.reflected_load();
                changed.load = Load::Reflected(Reflected {
                    inertia_kgm2: load.inertia_kgm2 * factor,
                    ..load
                });
            }
            Value::PositionGain => changed.drive.position_gain_per_s *= factor,
            Value::VelocityGain => changed.drive.velocity_gain_a_s_per_rad *= factor,
        }
        changed
    }

    /// Whether it is known from the control, where a guess is no factor off.
    fn is_gain(self) -> bool {
        matches!(self, Value::PositionGain | Value::VelocityGain)
    }
}

/// What is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasureOptions {
    /// By how much a value may be off that is no guess, as a part of it, below 1.
    pub share: f64,
    /// By what factor a guess may be off, above 1.
    pub guess: f64,
    /// Longest motion that is simulated in all runs together, s.
    pub max_motion_s: f64,
}

impl Default for MeasureOptions {
    fn default() -> MeasureOptions {
        MeasureOptions {
            share: USUAL_SHARE,
            guess: 2.0,
            max_motion_s: 7200.0,
        }
    }
}

/// One value that is worth measuring.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Measurement {
    /// Letter of the axis.
    pub axis: char,
    /// `gap`, `friction`, `stiffness`, `moving mass`, `position gain`, `velocity gain`.
    pub quantity: String,
    /// The value times this, and times its inverse or as far down, was run.
    pub up: f64,
    /// And this.
    pub down: f64,
    /// Whether the file says that it is a guess or of another machine.
    pub guess: bool,
    /// Largest change of the largest contour error on cutting moves, um; `None` if the machine stops
    /// with it.
    pub change_um: Option<f64>,
    /// Largest change of its root mean square, um; `None` if the machine stops with it.
    pub change_rms_um: Option<f64>,
    /// Part of what is uncertain about the verdict, 0 to 1.
    pub share: f64,
    /// How to measure it.
    pub how: String,
}

/// The answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Measurements {
    /// Version of this form, [`MEASURE_SCHEMA`].
    pub schema: u32,
    /// Name of the machine.
    pub machine: String,
    /// Name of the part.
    pub program: String,
    /// Tolerance of the verdict, um.
    pub tolerance_um: f64,
    /// Largest contour error as described, um.
    pub max_um: f64,
    /// Its root mean square, um.
    pub rms_um: f64,
    /// How many runs it took.
    pub runs: u64,
    /// Motion simulated in all of them, s.
    pub motion_s: f64,
    /// The values that matter most, that which matters most first; at most five.
    pub measure: Vec<Measurement>,
    /// How many values were tried.
    pub tried: u64,
}

impl Measurements {
    /// Whether any of them alone can turn the verdict round.
    pub fn turns_verdict(&self, of: &Measurement) -> bool {
        of.change_um
            .is_none_or(|change| change >= (self.tolerance_um - self.max_um).abs())
    }
}

/// The keys of a machine file whose comments say that they are guesses or lent by a preset: on the
/// line, or above the tables of its axis.
pub fn guesses(toml: &str) -> BTreeSet<String> {
    let (mut keys, mut table, mut lent) = (BTreeSet::new(), String::new(), false);
    // As `machine import` writes them.
    let says = |comment: &str| {
        let own = comment.trim_start_matches('#').trim();
        own.contains("guess") || own.starts_with("preset") || own.contains(": preset ")
    };
    for line in toml.lines().map(str::trim) {
        if line.starts_with("# ----") {
            lent = false;
        } else if line.starts_with('#') {
            lent |= says(line);
        } else if let Some(name) = line.strip_prefix('[') {
            table = name.trim_matches(['[', ']']).to_owned();
        } else if let Some((key, rest)) = line.split_once('=') {
            let guess = rest.split_once('#').map_or(lent, |(_, why)| says(why));
            if guess {
                keys.insert(format!("{table}.{}", key.trim()));
            }
        }
    }
    keys
}

fn is_guess(guesses: &BTreeSet<String>, axis: AxisId, value: Value) -> bool {
    let own = format!("axis.{}.", axis.letter().to_ascii_lowercase());
    guesses.iter().any(|key| {
        let last = key.rsplit('.').next().unwrap_or_default();
        let of_motor = key.contains(".motor.");
        key.starts_with(&own)
            && !of_motor
            && value.stems().iter().any(|stem| last.starts_with(stem))
    })
}

/// The measurements that matter most for the verdict on a part; on a circle in both senses if none
/// is given. `guesses` are those of [`guesses`].
///
/// ```
/// use lostmotion_sim::measure::{MeasureOptions, measurements};
/// use lostmotion_sim::{Machine, Program, SimulateOptions};
///
/// let part = Program::from_str("arc.ngc", "G21 G90 G17\nG0 X9 Y0\nG3 I-9 F900\nM2\n");
/// let (machine, options) = (Machine::preset("vmc3")?, SimulateOptions::default());
/// let wanted = MeasureOptions::default();
/// let found = measurements(&machine, Some(&part), &Default::default(), &options, &wanted)?;
/// assert_eq!(found.measure.len(), 5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`Simulation::run`]; options out of range; more motion than is allowed.
pub fn measurements(
    machine: &Machine,
    part: Option<&Program>,
    guesses: &BTreeSet<String>,
    options: &SimulateOptions,
    wanted: &MeasureOptions,
) -> Result<Measurements, SimError> {
    check(wanted)?;
    let own;
    let part = match part {
        Some(part) => part,
        None => {
            own = circle(machine)?;
            &own
        }
    };
    let mut moving = Moving::default();
    let first = Simulation::new(part, machine).options(options.clone());
    let first = first.observer(&mut moving).run()?;
    let described = first
        .first()
        .map(|result| (result.cutting.max, result.cutting.rms));
    let (max_um, rms_um) = described.unwrap_or_default();
    // An axis that stands still has no error that its values could change.
    let axes = machine.axes().iter();
    let axes: Vec<&MachineAxis> = axes.filter(|axis| moving.axes.contains(&axis.id)).collect();
    let most = 1 + 2 * axes.len() * Value::ALL.len();
    let duration = first.plan.duration_s;
    if duration * most as f64 > wanted.max_motion_s {
        return Err(SimError::refused(
            format!(
                "{most} runs of {duration:.0} s are more than {} s of motion",
                wanted.max_motion_s
            ),
            "take a shorter part, or allow more",
        ));
    }
    let mut answer = Measurements {
        schema: MEASURE_SCHEMA,
        machine: machine.name().to_owned(),
        program: part.name().to_owned(),
        tolerance_um: first.tolerance_um,
        max_um,
        rms_um,
        runs: 1,
        motion_s: duration,
        measure: Vec::new(),
        tried: 0,
    };
    let runs = ValueRuns {
        machine,
        part,
        options,
    };
    for axis in axes {
        for value in Value::ALL {
            let guess = is_guess(guesses, axis.id, value);
            let ends = factors(value, axis, guess, wanted);
            let change = runs.change(axis, value, ends, &mut answer)?;
            answer.tried += 1;
            let [up, down] = ends;
            answer.measure.push(Measurement {
                axis: axis.id.letter(),
                quantity: value.name().to_owned(),
                up,
                down,
                guess,
                change_um: change.map(|(max, _)| max),
                change_rms_um: change.map(|(_, rms)| rms),
                share: 0.0,
                how: value.how().to_owned(),
            });
        }
    }
    rank(&mut answer);
    Ok(answer)
}

/// Refuses options out of range.
fn check(wanted: &MeasureOptions) -> Result<(), SimError> {
    if !(wanted.share > 0.0 && wanted.share < 1.0) {
        return Err(SimError::refused(
            format!("a value cannot be off by {} of itself", wanted.share),
            "0.3 is 30 %",
        ));
    }
    if !(wanted.guess > 1.0 && wanted.guess <= 100.0) {
        return Err(SimError::refused(
            format!("a guess cannot be off by a factor of {}", wanted.guess),
            "from above 1 to 100",
        ));
    }
    Ok(())
}

/// The part where none is given: a circle in both senses.
fn circle(machine: &Machine) -> Result<Program, SimError> {
    let circle = TestOptions {
        radius_mm: Some(RADIUS_MM),
        ..TestOptions::default()
    };
    let text = program(machine, TestKind::Ballbar, &circle)?;
    Ok(Program::from_str("a circle of 10 mm in both senses", &text))
}

/// What is run with every value that is off.
struct ValueRuns<'a> {
    machine: &'a Machine,
    part: &'a Program,
    options: &'a SimulateOptions,
}

impl ValueRuns<'_> {
    /// By how much the largest contour error and its root mean square change at most where a value is these times
    /// too large or too small, um; `None` if the machine stops with it. Counts the runs.
    fn change(
        &self,
        axis: &MachineAxis,
        value: Value,
        ends: [f64; 2],
        answer: &mut Measurements,
    ) -> Result<Option<(f64, f64)>, SimError> {
        let mut change = Some((0.0_f64, 0.0_f64));
        for factor in ends {
            let config = value.times(&axis.config, factor);
            // What the description cannot be is no uncertainty of it.
            if config.check().is_err() {
                continue;
            }
            let changed = self.machine.with_axis_config(axis.id, &config);
            let run = Simulation::new(self.part, &changed)
                .options(self.options.clone())
                .run()?;
            answer.runs += 1;
            answer.motion_s += run.plan.duration_s;
            let result = run.first().filter(|result| result.stop.is_none());
            change = match (change, result) {
                (Some((max, rms)), Some(result)) => Some((
                    max.max((result.cutting.max - answer.max_um).abs()),
                    rms.max((result.cutting.rms - answer.rms_um).abs()),
                )),
                _ => None,
            };
        }
        Ok(change)
    }
}

/// The axes that move in a run.
#[derive(Default)]
struct Moving {
    /// Where each reference was first.
    first: BTreeMap<AxisId, f64>,
    axes: BTreeSet<AxisId>,
}

impl Observer for Moving {
    fn wants_motors(&self) -> bool {
        true
    }

    fn motors(&mut self, _: usize, points: &[MotorPoint]) {
        for point in points {
            if *self.first.entry(point.axis).or_insert(point.reference) != point.reference {
                self.axes.insert(point.axis);
            }
        }
    }
}

/// By what a value may be too large and too small.
fn factors(value: Value, axis: &MachineAxis, guess: bool, wanted: &MeasureOptions) -> [f64; 2] {
    if guess && !value.is_gain() {
        return [wanted.guess, 1.0 / wanted.guess];
    }
    let own = axis.config.compensation.gap_uncertainty;
    let share = if value == Value::Told(Told::Gap) && own > 0.0 {
        own
    } else {
        wanted.share
    };
    [1.0 + share, 1.0 - share]
}

/// Shares, and the first ones: what stops the machine, then by the change.
fn rank(answer: &mut Measurements) {
    // A machine that stops has no figure: it counts as the tolerance.
    let weight = |it: &Measurement, tolerance: f64| it.change_um.unwrap_or(tolerance);
    let tolerance = answer.tolerance_um;
    let sum: f64 = answer
        .measure
        .iter()
        .map(|it| weight(it, tolerance) * weight(it, tolerance))
        .sum();
    for it in &mut answer.measure {
        let own = weight(it, tolerance);
        it.share = if sum > 0.0 { own * own / sum } else { 0.0 };
    }
    let key = |it: &Measurement| {
        (
            it.change_um.unwrap_or(f64::INFINITY),
            it.change_rms_um.unwrap_or(f64::INFINITY),
        )
    };
    // Equal ones stay in the order of axes and values.
    answer.measure.sort_by(|a, b| {
        let (a, b) = (key(a), key(b));
        b.0.total_cmp(&a.0).then(b.1.total_cmp(&a.1))
    });
    answer
        .measure
        .retain(|it| it.change_um.is_none_or(|change| change > 0.0));
    answer.measure.truncate(FIRST);
}
