//! `lostmotion check-log`: a recorded motion against its program, its limits and its tolerance.

use crate::input;
use crate::logs::{LogRows, open};
use crate::options::part::OnMachine;
use crate::options::{Format, number, show, whole};
use crate::output::{self, DONE, FOUND, Failure};
use crate::parts::{failure, shown, to_json};
use clap::{Args, ValueEnum};
use lostmotion::base::AxisId;
use lostmotion::logs::{
    ColumnSpec, PositionKind, PositionLog, PositionOptions, PositionParts, Unit,
};
use lostmotion::report::text;
use lostmotion::sim::recorded::results::RecordKind;
use lostmotion::sim::recorded::{RecordOptions, Recorded, RecordedAxis, SHARED_ROWS};
use lostmotion::sim::{Machine, SimError, SimulateOptions, Simulation};
use std::path::PathBuf;

/// What a log holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Kind {
    /// Commands of the control: held against the tolerance of G64
    Commanded,
    /// What encoders or scales have read: held against the tolerance of G64 and that of the verdict
    /// together; rapids against the limits alone
    Measured,
}

/// Which positions a log holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Positions {
    /// Of the machine's joints
    #[default]
    Joints,
    /// Of the tool, in the program's axes; on machines whose joints are these it makes no difference
    Tool,
}

/// `check-log`.
#[derive(Debug, Args)]
pub(crate) struct CheckLog {
    /// Log of all axes that move the tool, in any format that is known (`axis log` shows what is in
    /// it); it may begin and end anywhere in the program, by any clock
    pub(crate) log: PathBuf,
    /// Which column is which axis, by its name in the log or its number in the file, from 1 with the
    /// time counted: x=NAME,unit=um,sign=-,scale=2, or time=NAME; names as x_mm, joint.0.pos-cmd and axis.x.pos-cmd are known. May be repeated
    #[arg(long, value_name = "AXIS=NAME", allow_hyphen_values = true)]
    pub(crate) column: Vec<ColumnSpec>,
    /// Unit of lengths where the log does not tell it: mm, um, inch; angles are then in deg
    #[arg(long, value_name = "UNIT")]
    pub(crate) unit: Option<Unit>,
    /// What was recorded; told from the names of the columns, or commanded
    #[arg(long, value_enum)]
    pub(crate) kind: Option<Kind>,
    /// Whose positions were recorded
    #[arg(long, value_enum, default_value_t)]
    pub(crate) positions: Positions,
    /// Accept the coordinates of the machine and of the program alone, not others that fit
    #[arg(long)]
    pub(crate) no_shift: bool,
    #[command(flatten)]
    pub(crate) rows: LogRows,
    /// Tolerance of the contour error of measured positions, um; the machine's, if left out
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = number)]
    pub(crate) tolerance_um: Option<f64>,
    /// How many of the worst blocks to list
    #[arg(long, value_name = "N", default_value_t = 10, allow_negative_numbers = true, value_parser = whole::<usize>)]
    pub(crate) top: usize,
    /// Most moves of a program: half a kilobyte of memory each
    #[arg(long, value_name = "N", default_value_t = 1_000_000, allow_negative_numbers = true, value_parser = whole::<usize>)]
    pub(crate) max_moves: usize,
    /// Form of the answer
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
    #[command(flatten)]
    pub(crate) on: OnMachine,
}

/// Checks a log against its program. Exit code 1 where a limit or the tolerance is certainly exceeded.
pub(crate) fn run(args: &CheckLog, quiet: bool) -> Result<u8, Failure> {
    let voice = args.on.setup.reading.voice(quiet);
    let program = input::program(&args.on.part)?;
    let machine = args.on.machine()?;
    let options = SimulateOptions {
        tolerance_um: args.tolerance_um,
        ..SimulateOptions::default()
    };
    let options = args.on.options(&machine, options)?;
    let mut parts = open_parts(args, &machine)?;
    let mut is_first = true;
    let mut next = || -> Result<Option<(Recorded, usize)>, Stopped> {
        let read = parts
            .next_part()
            .map_err(|error| Stopped::Log(error.into()))?;
        let Some((log, shared)) = read else {
            return Ok(None);
        };
        if std::mem::take(&mut is_first) {
            check_units(args, &machine, &log).map_err(Stopped::Log)?;
            if !quiet && args.kind.is_none() && log.kind.is_none() {
                output::remark(&format!(
                    "{}: taken for commanded positions; for what encoders or scales have read add --kind measured",
                    args.log.display()
                ));
            }
        }
        if !quiet {
            for said in &log.said {
                output::remark(&format!("{}: {said}", args.log.display()));
            }
        }
        Ok(Some((recorded(args, log), shared)))
    };
    let wanted = RecordOptions {
        keep_blocks: args.top,
        max_moves: args.max_moves,
        shifted: !args.no_shift,
    };
    let check = Simulation::new(&program, &machine)
        .options(options)
        .check_record_parts(&mut next, &wanted)
        .map_err(|stopped| match stopped {
            Stopped::Log(failure) => failure,
            Stopped::Check(error) => failure(&program, &error, voice),
        })?;
    let name = args.log.display().to_string();
    let text = text::record_check(&name, &check, &shown());
    show(args.format, &to_json(&check)?, &text)?;
    Ok(if check.is_within() { DONE } else { FOUND })
}

/// What ends a check.
enum Stopped {
    /// The log cannot be read.
    Log(Failure),
    /// It cannot be held against the program.
    Check(SimError),
}

impl From<SimError> for Stopped {
    fn from(error: SimError) -> Stopped {
        Stopped::Check(error)
    }
}

/// A part of the log as the check takes it.
fn recorded(args: &CheckLog, log: PositionLog) -> Recorded {
    let kind = match (args.kind, log.kind) {
        (Some(Kind::Commanded), _) | (None, Some(PositionKind::Commanded) | None) => {
            RecordKind::Commanded
        }
        (Some(Kind::Measured), _) | (None, Some(PositionKind::Measured)) => RecordKind::Measured,
    };
    Recorded {
        time_s: log.time_s,
        axes: log
            .axes
            .into_iter()
            .map(|axis| RecordedAxis {
                axis: axis.axis,
                values: axis.values,
            })
            .collect(),
        kind,
        of_tool: args.positions == Positions::Tool,
    }
}

/// The log, of which one part at a time is in memory.
fn open_parts(args: &CheckLog, machine: &Machine) -> Result<PositionParts<'static>, Failure> {
    let axes: Vec<AxisId> = if args.positions == Positions::Tool {
        AxisId::ALL.to_vec()
    } else {
        machine.axes().iter().map(|axis| axis.id).collect()
    };
    let defaults = PositionOptions::default();
    let part_rows = defaults.max_rows;
    let options = PositionOptions {
        read: args.rows.read_options(),
        columns: args.column.clone(),
        needed: axes
            .iter()
            .copied()
            .filter(|axis| axis.index() < 3)
            .collect(),
        axes,
        unit: args.unit,
        from_s: args.rows.from.unwrap_or(defaults.from_s),
        to_s: args.rows.to.unwrap_or(defaults.to_s),
        max_rows: args.rows.rows.unwrap_or(usize::MAX),
    };
    let name = args.log.display().to_string();
    Ok(PositionParts::new(
        open(&args.log)?,
        &name,
        &options,
        part_rows,
        SHARED_ROWS,
    )?)
}

/// An axis that turns is in degrees, one that does not in millimetres.
fn check_units(args: &CheckLog, machine: &Machine, log: &PositionLog) -> Result<(), Failure> {
    for axis in &log.axes {
        let turns = machine
            .axis(axis.axis)
            .map(lostmotion::sim::machine::MachineAxis::is_rotary);
        if turns.is_some_and(|turns| turns != axis.is_angle) && args.positions == Positions::Joints
        {
            return Err(Failure::with_hint(
                format!(
                    "{}: the position of axis {} is {}, but the axis of the machine is {}",
                    args.log.display(),
                    axis.axis,
                    if axis.is_angle {
                        "an angle"
                    } else {
                        "a length"
                    },
                    if axis.is_angle { "linear" } else { "rotary" },
                ),
                "give its unit: --column a=NAME,unit=deg",
            ));
        }
    }
    Ok(())
}
