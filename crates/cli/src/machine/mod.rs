//! `lostmotion machine`: machines that come with the program, and machine files.

pub(crate) mod keys;
mod make;
mod measure;

use crate::options::machine::{Changes, check, machine_names};
use crate::options::number;
use crate::output::{self, DONE, Failure, stdout_columns, wrapped, write_text};
use crate::parts::to_json;
use clap::{Args, Subcommand, ValueHint};
use lostmotion::analysis::{LimitCycle, LoopAnalysis};
use lostmotion::base::AxisId;
use lostmotion::report::number::{error, percent, plain};
use lostmotion::report::text::{Align, Cell, Table};
use lostmotion::sim::Machine;
use lostmotion::sim::machine::{
    AxisTuning, DEFAULT_MACHINE, axis_preset_toml, axis_presets, presets,
};
use std::path::PathBuf;

/// `machine`.
#[derive(Debug, Subcommand)]
pub(crate) enum MachineCommand {
    /// List the machines and single axes that come with the program
    List,
    /// Print a machine as a file to start from
    Show(ShowMachine),
    /// Say everything that is wrong with a machine file, and how the loops of its axes are tuned
    Check(CheckMachine),
    /// Make a machine file from another program's description: LinuxCNC INI, grbl `$$`, Klipper,
    /// FluidNC, RepRapFirmware, Marlin, Sinumerik, Fanuc, TwinCAT, MTConnect, FreeCAD .fcm, URDF
    Import(make::Import),
    /// Make a machine file with comments from a preset and what is different about your machine
    New(make::New),
    /// List every key of machine files, with type, unit, default, range and meaning
    Keys(keys::Keys),
}

/// `machine show`.
#[derive(Debug, Args)]
pub(crate) struct ShowMachine {
    /// A name from `machine list`
    name: String,
    /// File to write; stdout, if left out or `-`
    #[arg(long, short, value_name = "FILE.toml", value_hint = ValueHint::FilePath)]
    out: Option<PathBuf>,
}

/// `machine check`.
#[derive(Debug, Args)]
pub(crate) struct CheckMachine {
    /// Machine file, or a name from `machine list`
    #[arg(value_name = "FILE.toml|NAME", value_hint = ValueHint::FilePath)]
    file: String,
    /// Say, too, what to measure first: the five values that change the contour error on a part
    /// most when they are off by what they may be off (30 %; a guess a factor of 2); on a circle of
    /// 10 mm if no part is given. One simulation, and two for each of six values of each axis
    /// that moves
    #[arg(long, value_name = "PART", value_hint = ValueHint::FilePath, num_args = 0..=1)]
    measure: Option<Option<PathBuf>>,
    /// Longest motion of all these simulations together, s
    #[arg(long, value_name = "S", default_value_t = 7200.0, requires = "measure", value_parser = number)]
    max_motion_s: f64,
    /// Print what to measure as JSON, and nothing else
    #[arg(long, requires = "measure")]
    json: bool,
    #[command(flatten)]
    changes: Changes,
}

/// Runs the command asked for.
pub(crate) fn run(command: &MachineCommand, quiet: bool) -> Result<u8, Failure> {
    match command {
        MachineCommand::List => output::print(&list())?,
        MachineCommand::Show(args) => {
            let out = args.out.clone().unwrap_or_else(|| PathBuf::from("-"));
            write_text(&out, &show(&args.name)?)?;
        }
        MachineCommand::Check(args) => output::print(&checked(args)?)?,
        MachineCommand::Import(args) => make::import(args, quiet)?,
        MachineCommand::New(args) => make::new(args)?,
        MachineCommand::Keys(args) => keys::keys(args)?,
    }
    Ok(DONE)
}

/// What a sound machine's figures and loops are.
fn checked(args: &CheckMachine) -> Result<String, Failure> {
    let (machine, tuning) = check(&args.file, &args.changes.read()?)?;
    let measure = match &args.measure {
        Some(part) => Some(measure::first(
            &args.file,
            &machine,
            part.as_deref(),
            args.max_motion_s,
        )?),
        None => None,
    };
    if let Some(found) = measure.as_ref().filter(|_| args.json) {
        return to_json(found);
    }
    let measure = measure.map_or_else(String::new, |found| format!("\n{}", measure::shown(&found)));
    Ok(format!(
        "{}: machine \"{}\" is sound\n\n{}\n{}\n{}{measure}",
        args.file,
        machine.name(),
        review(&machine),
        monitoring(&machine),
        loops(&machine, &tuning, stdout_columns())
    ))
}

fn list() -> String {
    let mut table = Table::new(&[("machine", Align::Left), ("", Align::Left)]).folded();
    for preset in presets() {
        let note = if preset.name == DEFAULT_MACHINE {
            " (the one taken if none is named)"
        } else {
            ""
        };
        table.row([
            preset.name.into(),
            format!("{}{note}", preset.summary).into(),
        ]);
    }
    format!(
        "{}\n{}",
        table.render_within(stdout_columns()),
        wrapped(&format!(
            "axes for `axis run` and `axis fit`: {}",
            axis_presets().join(", ")
        ))
    )
}

/// The file of a preset as it came, with its comments; then, as comments too, how its loops are
/// tuned. Axes as files for `axis run --axis`.
fn show(name: &str) -> Result<String, Failure> {
    match presets().iter().find(|preset| preset.name == name) {
        Some(preset) => Ok(format!("{}{}", preset.toml, tuned(name))),
        // Not a machine: it may be an axis; an unknown name is told both lists.
        None => axis_preset_toml(name).ok_or_else(|| match machine_names().refusal(name) {
            Failure::Message { text, hint } => {
                let axes = axis_presets().join(", ");
                Failure::with_hint(text, format!("{hint}; axes: {axes}"))
            }
            failure => failure,
        }),
    }
}

/// Comments at the end of a preset's file.
fn tuned(name: &str) -> String {
    let Ok(machine) = Machine::preset(name) else {
        return String::new();
    };
    // Comments in a file have no terminal's width.
    let table = loops(&machine, &machine.tuning(), usize::MAX);
    let lines: Vec<String> = table
        .lines()
        .map(|line| format!("# {line}").trim_end().to_owned())
        .collect();
    format!(
        "\n# The loops as they are tuned here; `lostmotion machine check FILE` says it for a file.\n{}\n",
        lines.join("\n")
    )
}

/// What the machine's figures mean.
fn review(machine: &Machine) -> String {
    let right = Align::Right;
    let mut table = Table::new(&[
        ("axis", Align::Left),
        ("gap", right),
        ("peak torque", right),
        ("friction", right),
        ("motor 1/min", right),
        ("J load/motor", right),
        ("resonance Hz", right),
        ("velocity loop Hz", right),
        ("Kv 1/s", right),
    ])
    // First to go on a narrow terminal: speed of the motor, ratio of inertias, friction.
    .optional(&[4, 5, 3]);
    let mut remarks = String::new();
    for (axis, figures) in machine.axes().iter().zip(machine.review()) {
        // The gap comes in mm or deg and is shown in um or mdeg.
        let unit = if axis.is_rotary() { "mdeg" } else { "um" };
        table.row([
            axis.id.letter().to_string().into(),
            format!("{} {unit}", error(axis.config.gap_in_unit() * 1e3)).into(),
            percent(figures.peak_torque_ratio).into(),
            percent(figures.friction_ratio).into(),
            format!("{:.0}", figures.motor_rpm).into(),
            format!("{:.2}", figures.inertia_ratio).into(),
            format!("{:.0}", figures.resonance_hz).into(),
            format!("{:.0}", figures.velocity_loop_hz).into(),
            plain(figures.position_gain_per_s).into(),
        ]);
        for remark in figures.remarks() {
            remarks.push_str(&format!("warning: {remark}\n"));
        }
    }
    format!("{}{remarks}", table.render_within(stdout_columns()))
}

/// Past what the machine stops, axis by axis.
fn monitoring(machine: &Machine) -> String {
    let right = Align::Right;
    let mut table = Table::new(&[
        ("stops past", Align::Left),
        ("following error", right),
        ("at rest", right),
        ("overtravel", right),
        ("continuous current", right),
        ("peak current for", right),
    ])
    // The overload goes first on a narrow terminal.
    .optional(&[5, 4]);
    for axis in machine.axes() {
        let limits = axis.monitor_limits();
        let unit = axis.config.unit().symbol();
        let length = |value: f64| format!("{value:.3} {unit}");
        let or_off = |text: Option<String>| Cell::from(text.unwrap_or_else(|| "off".to_owned()));
        // Of the upper end; that of the lower one is the same.
        let end = axis.limits.max * axis.axis_units_per_joint_unit();
        let peak = axis.config.drive.current_limit_a;
        table.row([
            axis.id.letter().to_string().into(),
            or_off(limits.following.map(|limit| length(limit.full_speed))),
            or_off(limits.following.map(|limit| length(limit.standstill))),
            or_off(limits.travel.map(|[_, high]| length(high - end))),
            or_off(
                limits
                    .overload
                    .map(|it| format!("{:.1} A", it.continuous_a)),
            ),
            or_off(limits.overload.map(|it| {
                it.borne_s(peak)
                    .map_or_else(|| "ever".to_owned(), |borne_s| format!("{borne_s:.1} s"))
            })),
        ]);
    }
    table.render_within(stdout_columns())
}

/// A row for each loop of each axis, then a line for each axis' delays and limit cycles.
fn loops(machine: &Machine, tuning: &[AxisTuning], columns: usize) -> String {
    let right = Align::Right;
    let mut table = Table::new(&[
        ("axis", Align::Left),
        ("loop", Align::Left),
        ("", Align::Left),
        ("gain margin dB", right),
        ("phase margin deg", right),
        ("crossover Hz", right),
        ("bandwidth Hz", right),
    ])
    // The margins are what the table is for: crossover and bandwidth go first.
    .optional(&[5, 6]);
    for axis in tuning {
        for at in &axis.loops.loops {
            table.row(row(axis.axis, at));
        }
    }
    let lines: String = tuning
        .iter()
        .map(|axis| format!("axis {}: {}\n", axis.axis, delays_and_cycles(machine, axis)))
        .collect();
    format!("{}{lines}", table.render_within(columns))
}

fn row(axis: AxisId, at: &LoopAnalysis) -> [Cell; 7] {
    // A loop may have no such figure: one that no gain makes oscillate has no gain margin.
    let number = |value: Option<f64>| {
        value
            .map_or("-".to_owned(), |value| format!("{value:.1}"))
            .into()
    };
    let margins = &at.margins;
    [
        axis.letter().to_string().into(),
        at.kind.to_string().into(),
        at.regime.to_string().into(),
        number(margins.gain_margin_db),
        number(margins.phase_margin_deg),
        number(margins.crossover_hz),
        number(margins.bandwidth_hz),
    ]
}

fn delays_and_cycles(machine: &Machine, tuning: &AxisTuning) -> String {
    let delays = &tuning.loops.delays;
    let mut line = format!(
        "dead times {} us (current), {} us (velocity), {} us (position)",
        delays.current_us, delays.velocity_us, delays.position_us
    );
    let Some(axis) = machine.axis(tuning.axis) else {
        return line;
    };
    // Without a gap nothing makes a stable loop swing.
    if axis.config.gap_in_unit() <= 0.0 {
        return line;
    }
    let unit = axis.config.unit().symbol();
    // A describing function tells frequency and amplitude of a limit cycle.
    let swing = |frequency_hz: f64, amplitude: f64| {
        format!("{frequency_hz:.1} Hz, load +-{amplitude:.3e} {unit}")
    };
    let predicted = match &tuning.predicted {
        LimitCycle::None => "none predicted".to_owned(),
        LimitCycle::Swing {
            frequency_hz,
            load_rad,
            ..
        } => {
            format!(
                "{} predicted",
                swing(
                    *frequency_hz,
                    // The analysis counts in radians of the motor, people in the axis' unit.
                    load_rad / axis.config.transmission.motor_rad_per_unit()
                )
            )
        }
        LimitCycle::Unstable => "the loop itself is unstable".to_owned(),
    };
    let simulated = tuning
        .simulated
        .map_or("none simulated".to_owned(), |cycle| {
            format!("{} simulated", swing(cycle.frequency_hz, cycle.amplitude))
        });
    line.push_str(&format!("; limit cycle: {predicted}, {simulated}"));
    line
}
