//! `lostmotion ballbar`: what a ballbar's sheet tells of a machine's axes, and what a description of
//! the machine would make of the same circle.

use crate::logs::open;
use crate::options::machine::MachineOptions;
use crate::options::{Format, number, show};
use crate::output::{self, DONE, Failure};
use crate::parts::{shown, to_json};
use clap::{Args, ValueEnum, ValueHint};
use lostmotion::base::Plane;
use lostmotion::base::units::{MM_PER_INCH, UM_PER_MM};
use lostmotion::contour::ballbar::{BallbarTrace, sheet};
use lostmotion::contour::{Circle, RadialPoint};
use lostmotion::logs::{BallbarLog, BallbarOptions, ColumnSpec, read_ballbar};
use lostmotion::report::text;
use lostmotion::sim::testpart::{BallbarAnswer, BallbarTest, TestOptions, simulate_ballbar};
use std::path::PathBuf;

/// How far off a whole number of millimetres a mean radius may be to be taken for it, mm.
const WHOLE_MM: f64 = 0.2;

/// How far off a nominal radius the mean may be before other units are thought of, mm.
const DOUBTFUL_MM: f64 = 0.02;

/// Shortest ballbar there is, mm.
const LEAST_BAR_MM: f64 = 45.0;

/// Longest ballbar that is believed, mm. A choice: twice the longest that bars are extended to.
const LONGEST_BAR_MM: f64 = 3000.0;

/// Farthest that a ballbar is believed to travel, mm. A choice: several times what its sensor can.
const MOST_DEVIATION_MM: f64 = 5.0;

/// Plane of a circle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum PlaneName {
    /// X and Y
    #[default]
    Xy,
    /// Z and X
    Zx,
    /// Y and Z
    Yz,
}

/// Sense of rotation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Sense {
    /// Counter-clockwise
    Ccw,
    /// Clockwise
    Cw,
}

/// `ballbar`.
#[derive(Debug, Args)]
pub(crate) struct Ballbar {
    /// Sheets: tables with an angle and a radius or a deviation, one sense of rotation in each file
    /// or both in one
    #[arg(required = true, value_name = "SHEET", num_args = 1..=2, value_hint = ValueHint::FilePath)]
    pub(crate) sheets: Vec<PathBuf>,
    /// Which column is what, by its name or number: angle=NAME,unit=deg, radius=NAME,unit=mm or
    /// deviation=NAME,unit=um,sign=-; may be repeated
    #[arg(long, value_name = "ROLE=NAME", allow_hyphen_values = true)]
    pub(crate) column: Vec<ColumnSpec>,
    /// Nominal radius, mm; of sheets with radii the whole number next to their mean, if left out
    #[arg(long, value_name = "MM", allow_negative_numbers = true, value_parser = number)]
    pub(crate) radius_mm: Option<f64>,
    /// Sense of rotation of each circle in the order of the sheets, for example ccw,cw, where rows are sorted by
    /// their angle; the order of the rows, if left out
    #[arg(long, value_name = "SENSES", value_enum, value_delimiter = ',')]
    pub(crate) sense: Vec<Sense>,
    /// Plane of the circle
    #[arg(long, value_enum, default_value_t)]
    pub(crate) plane: PlaneName,
    /// Feed of the circle with --machine, mm/min; 1000, or less where its limits ask for it, if left
    /// out
    #[arg(long, value_name = "MM_MIN", allow_negative_numbers = true, value_parser = number, requires = "machine")]
    pub(crate) feed: Option<f64>,
    /// Form of the answer
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
    #[command(flatten)]
    pub(crate) on: MachineOptions,
}

/// Says what the sheets tell.
pub(crate) fn run(args: &Ballbar, quiet: bool) -> Result<u8, Failure> {
    let machine = args.on.named()?;
    let options = BallbarOptions {
        columns: args.column.clone(),
        ..BallbarOptions::default()
    };
    let mut logs: Vec<BallbarLog> = Vec::new();
    let mut names = Vec::new();
    for path in &args.sheets {
        let name = path.display().to_string();
        let log = read_ballbar(open(path)?, &name, &options)?;
        if !quiet {
            for said in &log.said {
                output::remark(&format!("{name}: {said}"));
            }
        }
        logs.push(log);
        names.push(name);
    }
    let radius_mm = nominal(args, &logs, &names, quiet)?;
    check_size(radius_mm, &logs, &names)?;
    let traces = traces(args, &logs, radius_mm, &names)?;
    let one_sense = traces.len() > 1
        && traces
            .iter()
            .all(|trace| trace.counterclockwise == traces[0].counterclockwise);
    if traces.len() > 2 || one_sense {
        return Err(Failure::with_hint(
            format!(
                "{}: {} circles, {} of them counter-clockwise",
                names.join(", "),
                traces.len(),
                traces.iter().filter(|trace| trace.counterclockwise).count()
            ),
            "give one circle of each sense at most; where rows are sorted by their angle, say the senses: --sense ccw,cw",
        ));
    }
    let plane = match args.plane {
        PlaneName::Xy => Plane::Xy,
        PlaneName::Zx => Plane::Zx,
        PlaneName::Yz => Plane::Yz,
    };
    let circle = Circle {
        plane,
        center_mm: [0.0; 2],
        radius_mm,
    };
    let said = names.join(", ");
    let judged = |traces: &[BallbarTrace]| {
        sheet(&circle, traces).map_err(|error| Failure::message(format!("{said}: {error}")))
    };
    let mut answer = BallbarAnswer::new(names, judged(&traces)?);
    if let Some(machine) = machine {
        if plane != Plane::Xy {
            return Err(Failure::with_hint(
                "a machine is simulated in the plane XY alone",
                "leave out --machine for sheets of other planes",
            ));
        }
        let refused = |error: lostmotion::SimError| Failure::message(error.to_string());
        let wanted = TestOptions {
            radius_mm: Some(radius_mm),
            feed_mm_min: args.feed,
            ..TestOptions::default()
        };
        let test = BallbarTest::new(&machine, &wanted).map_err(refused)?;
        let simulated = simulate_ballbar(&machine, &test).map_err(refused)?;
        let other = judged(&simulated)?;
        let of = (machine.name(), test.feed_mm_min);
        answer = answer.beside(of, other, (&traces, &simulated));
    }
    show(
        args.format,
        &to_json(&answer)?,
        &text::ballbar(&answer, &shown()),
    )?;
    Ok(DONE)
}

/// The circles of the sheets, their rows in the order in which they were measured.
fn traces(
    args: &Ballbar,
    logs: &[BallbarLog],
    radius_mm: f64,
    names: &[String],
) -> Result<Vec<BallbarTrace>, Failure> {
    let mut traces: Vec<BallbarTrace> = Vec::new();
    let circles: usize = logs.iter().map(|log| log.senses.len()).sum();
    if !args.sense.is_empty() && args.sense.len() != circles {
        return Err(Failure::with_hint(
            format!(
                "{}: {circles} circles, and --sense has {}",
                names.join(", "),
                args.sense.len()
            ),
            "give the sense of each circle in the order of the sheets",
        ));
    }
    for log in logs {
        let zero = if log.is_deviation { 0.0 } else { radius_mm };
        for rows in &log.senses {
            let mut points: Vec<RadialPoint> = rows
                .iter()
                .map(|&(angle_rad, value)| RadialPoint {
                    angle_rad,
                    deviation_mm: value - zero,
                })
                .collect();
            let as_sorted = BallbarTrace::new(points.clone());
            let told = args.sense.get(traces.len());
            traces.push(match told {
                Some(told) if (*told == Sense::Ccw) != as_sorted.counterclockwise => {
                    points.reverse();
                    BallbarTrace::new(points)
                }
                _ => as_sorted,
            });
        }
    }
    Ok(traces)
}

/// Refuses lengths that no ballbar has: they are in another unit.
fn check_size(radius_mm: f64, logs: &[BallbarLog], names: &[String]) -> Result<(), Failure> {
    if radius_mm > LONGEST_BAR_MM {
        return Err(Failure::with_hint(
            format!(
                "{}: a radius of {radius_mm} mm is longer than any ballbar ({LONGEST_BAR_MM} mm)",
                names.join(", ")
            ),
            "radii in micrometres: --column radius=NAME,unit=um",
        ));
    }
    for (log, name) in logs.iter().zip(names) {
        let (role, zero) = if log.is_deviation {
            ("deviation", 0.0)
        } else {
            ("radius", radius_mm)
        };
        let off = |(_, value): &&(f64, f64)| (value - zero).abs() > MOST_DEVIATION_MM;
        if let Some((angle, value)) = log.senses.iter().flatten().find(off) {
            return Err(Failure::with_hint(
                format!(
                    "{name}: at {:.1} deg the radius is {} mm off the nominal {radius_mm} mm, farther than a ballbar travels ({MOST_DEVIATION_MM} mm)",
                    angle.to_degrees(),
                    value - zero
                ),
                format!(
                    "is the unit another one, --column {role}=NAME,unit=um, or the nominal radius, --radius-mm 150?"
                ),
            ));
        }
    }
    Ok(())
}

/// The nominal radius: told, or that of the sheets.
fn nominal(
    args: &Ballbar,
    logs: &[BallbarLog],
    names: &[String],
    quiet: bool,
) -> Result<f64, Failure> {
    if let Some(radius) = args.radius_mm {
        return if radius.is_finite() && radius > 0.0 {
            Ok(radius)
        } else {
            Err(Failure::message(format!(
                "--radius-mm is {radius}; it has to be positive"
            )))
        };
    }
    if let Some((_, name)) = logs.iter().zip(names).find(|(log, _)| log.is_deviation) {
        return Err(Failure::with_hint(
            format!("{name}: deviations alone do not tell the radius of the circle"),
            "give it: --radius-mm 150",
        ));
    }
    let values: Vec<f64> = logs
        .iter()
        .flat_map(|log| log.senses.iter().flatten().map(|(_, value)| *value))
        .collect();
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    let whole = mean.round();
    check_size(mean, &[], names)?;
    if (mean - whole).abs() > WHOLE_MM || whole <= 0.0 {
        return Err(Failure::with_hint(
            format!(
                "{}: the mean radius {mean:.3} mm is near no whole number of millimetres",
                names.join(", ")
            ),
            "give the nominal radius: --radius-mm 150",
        ));
    }
    // A bar's length in inches looks like a small circle in mm, far off its nominal radius.
    let in_inches = mean * MM_PER_INCH;
    if (mean - whole).abs() > DOUBTFUL_MM
        && in_inches > LEAST_BAR_MM
        && (in_inches - in_inches.round()).abs() < (mean - whole).abs()
    {
        return Err(Failure::with_hint(
            format!(
                "{}: the mean radius {mean:.4} is {:.0} um off {whole} mm, and in inches {in_inches:.3} mm",
                names.join(", "),
                UM_PER_MM * (mean - whole)
            ),
            format!(
                "name the unit, --column radius=NAME,unit=in, or if it is mm the radius, --radius-mm {whole}"
            ),
        ));
    }
    if !quiet {
        output::remark(&format!(
            "{}: the nominal radius is taken to be {whole} mm",
            names.join(", ")
        ));
    }
    Ok(whole)
}
