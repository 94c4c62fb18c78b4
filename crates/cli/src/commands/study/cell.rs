//! `lostmotion study cell`.

use super::{failure, methods};
use crate::args::study::Cell as Args;
use crate::commands::DONE;
use crate::failure::Failure;
use crate::output;
use lostmotion::base::Clock;
use lostmotion::drive::AxisSample;
use lostmotion::report::WriteError;
use lostmotion::report::atomic::AtomicFile;
use lostmotion_study::matrix::{Cell, Traced, motion, run_cell, table};
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// Runs one cell; the trace is that of the method.
pub(crate) fn run(args: &Args) -> Result<u8, Failure> {
    let cell = Cell::parse(&args.cell).map_err(|error| failure(&error))?;
    let methods = methods(std::slice::from_ref(&args.method))?;
    if let Some(path) = &args.program {
        let mut file = AtomicFile::create(path)?;
        file.write_all(motion::program(&cell).as_bytes())
            .map_err(|error| WriteError::io("write", path, error))?;
        file.commit()?;
    }
    let result = match &args.out {
        None => run_cell(&cell, &methods, None).map_err(|error| failure(&error))?,
        Some(path) => traced(&cell, &methods, path)?,
    };
    output::print(&table::csv(&[result]))?;
    Ok(DONE)
}

fn traced(
    cell: &Cell,
    methods: &[String],
    path: &Path,
) -> Result<lostmotion_study::matrix::CellResult, Failure> {
    let unwritten = |error| Failure::from(WriteError::io("write", path, error));
    let mut file = BufWriter::new(AtomicFile::create(path)?);
    writeln!(
        file,
        "t_s,error_um,error_without_gap_um,measured{}{}",
        columns("x"),
        columns("y")
    )
    .map_err(unwritten)?;
    let mut written = Ok(());
    let result = run_cell(
        cell,
        methods,
        Some(&mut |row| {
            if written.is_ok() {
                written = write_row(&mut file, row);
            }
        }),
    );
    let result = result.map_err(|error| failure(&error))?;
    written.map_err(unwritten)?;
    let file = file
        .into_inner()
        .map_err(|error| unwritten(error.into_error()))?;
    file.commit()?;
    Ok(result)
}

/// Columns of an axis; angles at the motor.
fn columns(axis: &str) -> String {
    let names = [
        "reference_rad",
        "reference_rad_s",
        "reference_rad_s2",
        "motor_rad",
        "load_rad",
        "torque_nm",
        "engagement",
        "gap_estimate_rad",
        "inertia_estimate_kgm2",
        "engagement_estimate",
        "stiffness_estimate_nm_per_rad",
        "damping_estimate_nm_s_per_rad",
    ];
    names.map(|name| format!(",{axis}_{name}")).concat()
}

fn write_row(out: &mut impl Write, row: &Traced) -> io::Result<()> {
    let [error, without] = row.error_um;
    write!(
        out,
        "{},{error:.4},{without:.4},{}",
        Clock::SERVO.seconds(row.tick),
        u8::from(row.measured)
    )?;
    for sample in &row.axes {
        let AxisSample {
            reference,
            motor_position,
            load_position,
            torque,
            engagement,
            engagement_estimate,
            ..
        } = sample;
        write!(
            out,
            ",{:.9},{:.6},{:.4}",
            reference.position, reference.velocity, reference.acceleration
        )?;
        write!(
            out,
            ",{motor_position:.9},{load_position:.9},{torque:.6},{}",
            engagement.sign()
        )?;
        for estimate in [sample.gap_angle_estimate, sample.inertia_estimate] {
            if estimate.is_finite() {
                write!(out, ",{estimate:.9}")?
            } else {
                write!(out, ",")?
            }
        }
        write!(out, ",{}", engagement_estimate.sign())?;
        for estimate in [sample.stiffness_estimate, sample.damping_estimate] {
            if estimate.is_finite() {
                write!(out, ",{estimate:.4}")?
            } else {
                write!(out, ",")?
            }
        }
    }
    writeln!(out)
}
