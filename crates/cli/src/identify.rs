//! `axis identify`: what a log tells of an axis, a description with the source of every value, and
//! the check of a description against a log.

use crate::fits::rad_per_unit;
use crate::logs::{LogInput, axis_unit};
use crate::options::machine::{axis, axis_files};
use crate::output::{self, DONE, FOUND, Failure};
use clap::{Args, ValueHint};
use lostmotion::drive::config::{AxisUnit, Load};
use lostmotion::identify::body::{
    BodyLog, Figure, Motion, Replayed, RigidBody, ServoGains, fit_body, fit_lost_motion, fit_servo,
    replay,
};
use lostmotion::identify::{BacklashFit, BacklashLog, FitSettings, fit_backlash};
use lostmotion::logs::{AxisLog, DriveSignal};
use lostmotion::methods::AxisConfig;
use lostmotion::report::WriteError;
use lostmotion::sim::machine::axis_to_toml;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

/// How far a described value may be off the measured one, in parts of it, before `--check` says
/// so: data sheets are given to this. The interval of the log has to leave it out, too.
const LEAST_DIFFERENCE: f64 = 0.05;

/// `axis identify`.
#[derive(Debug, Args)]
pub(crate) struct Identify {
    #[command(flatten)]
    pub(crate) log: LogInput,
    /// The axis that was logged: its motor and transmission make forces of currents; what the log
    /// does not tell is taken from it
    #[arg(long, value_name = "FILE.toml|PRESET")]
    pub(crate) axis: Option<String>,
    /// Description of the axis to write, with the source of every value beside it
    #[arg(long, short, value_name = "FILE.toml", requires = "axis", value_hint = ValueHint::FilePath)]
    pub(crate) out: Option<PathBuf>,
    /// CSV to write with the measured and the simulated position and their difference
    #[arg(long, value_name = "FILE.csv", value_hint = ValueHint::FilePath)]
    pub(crate) overlay: Option<PathBuf>,
    /// Compare the description with the log: exit code 1 where a value is certainly another one
    #[arg(long, requires = "axis")]
    pub(crate) check: bool,
}

/// A value of the description that the log tells.
struct Finding {
    /// Table and key in the file of an axis.
    table: &'static str,
    key: &'static str,
    unit: &'static str,
    described: f64,
    measured: Figure,
}

/// Runs the command.
pub(crate) fn run(args: &Identify, quiet: bool) -> Result<u8, Failure> {
    let described = args
        .axis
        .as_deref()
        .map(|name| axis(name, &[]))
        .transpose()?;
    let name = args.log.name();
    for out in [&args.out, &args.overlay].into_iter().flatten() {
        output::refuse_input(out, &args.log.log, "log")?;
        output::refuse_inputs(out, axis_files(args.axis.as_deref()))?;
    }
    if let (Some(out), Some(overlay)) = (&args.out, &args.overlay)
        && out == overlay
    {
        let shown = out.display();
        return Err(Failure::message(format!(
            "--out and --overlay are both {shown}"
        )));
    }
    args.log.exists()?;
    let log = args.log.read(&[], &[], quiet)?;
    let unit = axis_unit(&log);
    if let Some(described) = &described {
        rad_per_unit(described, unit, &name)?;
    }
    let scales = Scales::of(&log, unit, described.as_ref());
    let body_log = scales
        .body_log(&log)
        .map_err(|error| Failure::message(format!("{name}: {error}")))?;
    let motion = Motion::of(&body_log);
    let mut text = scales.motion(&motion, &body_log);
    let mut untold: Vec<String> = Vec::new();
    let mut findings: Vec<Finding> = Vec::new();
    // Lost motion first: it says whether a gap is the right word.
    let mut is_step = true;
    match fit_lost_motion(&body_log) {
        Ok(lost) => {
            let um = 1.0 / scales.small;
            is_step = lost.is_step;
            text += &line("lost motion", lost.total.times(um), scales.small_unit);
            if lost.is_step {
                text += "  a step, as of a gap and wind-up, explains it\n";
            } else {
                let [low, high] = lost.saturates_between.map(|end| figures(end * um));
                text += &format!(
                    "  not a step: 95 % of it comes within {} {u} of travel ({low} to {high} {u}); a gap alone is no model of it\n",
                    figures(lost.saturates_after * um),
                    u = scales.small_unit,
                );
                text += &line("  of it at once", lost.step.times(um), scales.small_unit);
                text += &line(
                    "  of it along the travel",
                    lost.along.times(um),
                    scales.small_unit,
                );
            }
        }
        Err(reason) => untold.push(format!("lost motion: {reason}")),
    }
    match (gap(&log, &scales, described.as_ref(), unit, &name), is_step) {
        (Ok(fit), true) => {
            text += &gap_text(&fit, &scales);
            if let Some(described) = &described {
                findings.extend(gap_findings(&fit, described));
            }
        }
        (Ok(_), false) => {
            untold.push("the gap: position is lost along the travel, not at once".to_owned());
        }
        (Err(reason), _) => untold.push(format!("gap and stiffness: {reason}")),
    }
    let body = fit_body(&body_log, &motion);
    match &body {
        Ok(body) => {
            text += &scales.body(body);
            untold.extend(body.untold.iter().cloned());
            if let Some(described) = &described {
                findings.extend(scales.body_findings(body, described));
            }
        }
        Err(reason) => untold.push(format!("inertia and friction: {reason}")),
    }
    let servo = fit_servo(&body_log, &motion);
    match &servo {
        Ok(servo) => {
            text += &scales.servo(servo);
            untold.extend(servo.untold.iter().cloned());
            if let Some(described) = &described {
                findings.extend(scales.servo_findings(servo, described, &log));
            }
        }
        Err(reason) => untold.push(format!("servo: {reason}")),
    }
    let replayed = match (&body, &servo) {
        (Ok(body), Ok(servo)) => replay(&body_log, body, servo),
        _ => None,
    };
    match &replayed {
        Some(again) => {
            let um = 1.0 / scales.small;
            text += &format!(
                "simulated on the log's command: {} {u} RMS off the record, at most {} {u}\n",
                figures(again.rms * um),
                figures(again.largest * um),
                u = scales.small_unit,
            );
        }
        None if args.overlay.is_some() => {
            return Err(Failure::with_hint(
                format!("{name}: nothing can be simulated for --overlay"),
                "it needs a command, a current and a servo law that the log obeys",
            ));
        }
        None => {}
    }
    for reason in &untold {
        text += &format!("not told: {reason}\n");
    }
    let mut differs = false;
    if args.check {
        for finding in &findings {
            let (words, other) = finding.verdict();
            differs |= other;
            text += &words;
        }
        if findings.is_empty() {
            text += "nothing of the description can be checked with this log\n";
        }
    }
    if let (Some(path), Some(again)) = (&args.overlay, &replayed) {
        write_overlay(path, &body_log, again, &scales)?;
    }
    if let (Some(path), Some(described)) = (&args.out, &described) {
        let base = args.axis.as_deref().unwrap_or_default();
        write_axis(path, described, &findings, &name, base)?;
    }
    output::print(&text)?;
    Ok(if differs { FOUND } else { DONE })
}

/// Three digits, as people read them.
fn figures(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let decimals =
        (2.0 - lostmotion::base::math::log10(value.abs()).floor()).clamp(0.0, 9.0) as usize;
    format!("{value:.decimals$}")
}

fn line(what: &str, figure: Figure, unit: &str) -> String {
    let [low, high] = figure.interval.map(figures);
    format!(
        "{what}: {} {unit} (95 %: {low} to {high})\n",
        figures(figure.value)
    )
}

/// Units of a log in those of the fits and of people.
struct Scales {
    unit: AxisUnit,
    /// m or rad in one unit of the log.
    base: f64,
    /// m or rad in one small unit.
    small: f64,
    small_unit: &'static str,
    /// What drives the axis is multiplied with this.
    drive: f64,
    drive_unit: &'static str,
    /// m or rad at the load for a radian of the motor; 1 where the axis is not given.
    per_rad: f64,
}

impl Scales {
    fn of(log: &AxisLog, unit: AxisUnit, described: Option<&AxisConfig>) -> Scales {
        let (base, small, small_unit) = match unit {
            AxisUnit::Mm => (1e-3, 1e-6, "um"),
            AxisUnit::Deg => (1.0_f64.to_radians(), 1e-3_f64.to_radians(), "mdeg"),
            AxisUnit::Rad => (1.0, 1e-6, "urad"),
        };
        let per_rad = described.map_or(1.0, |axis| axis.transmission.load_per_motor_rad());
        let force = if unit == AxisUnit::Mm { "N" } else { "N m" };
        let (drive, drive_unit) = match (&log.drive, described) {
            (Some(DriveSignal::Current(_)), Some(axis)) => {
                (axis.motor.torque_constant_nm_per_a / per_rad, force)
            }
            (Some(DriveSignal::Torque(_)), Some(_)) => (1.0 / per_rad, force),
            (Some(DriveSignal::Force(_)), _) => (1.0, force),
            (Some(DriveSignal::Torque(_)), None) => (1.0, "N m of the motor"),
            _ => (1.0, "A"),
        };
        Scales {
            unit,
            base,
            small,
            small_unit,
            drive,
            drive_unit,
            per_rad,
        }
    }

    fn body_log(&self, log: &AxisLog) -> Result<BodyLog, lostmotion::identify::FitError> {
        let scaled =
            |values: &[f64], factor: f64| values.iter().map(|value| value * factor).collect();
        let drive = log.drive.as_ref().map_or(&[][..], DriveSignal::values);
        BodyLog::from_rows(
            &log.time_s,
            scaled(&log.motor, self.base),
            scaled(&log.load, self.base),
            scaled(&log.command, self.base),
            scaled(drive, self.drive),
        )
    }

    /// Whether forces at the load are known.
    fn has_force(&self) -> bool {
        matches!(self.drive_unit, "N" | "N m")
    }

    fn motion(&self, motion: &Motion, log: &BodyLog) -> String {
        format!(
            "{} samples every {} ms: {} strokes, {} reversals, {} rests; up to {} {u}/s and {} {u}/s^2\n",
            log.len(),
            figures(1e3 * log.period_s),
            motion.strokes.len(),
            motion.reversals,
            motion.rests,
            figures(motion.top_speed / self.base),
            figures(motion.top_acceleration / self.base),
            u = self.unit.symbol(),
        )
    }

    fn body(&self, body: &RigidBody) -> String {
        let way = if self.unit == AxisUnit::Mm {
            "m"
        } else {
            "rad"
        };
        let drive = self.drive_unit;
        let inertia = match drive {
            "N" => "kg".to_owned(),
            "N m" => "kg m2".to_owned(),
            other => format!("{other} s2/{way}"),
        };
        let mut text = line("inertia, motor and load", body.inertia, &inertia);
        text += &line(
            "viscous friction",
            body.viscous,
            &format!("{drive} s/{way}"),
        );
        if let Some(sided) = &body.sided {
            for (which, figure) in ["  forwards", "  backwards"].into_iter().zip(sided.viscous) {
                text += &line(which, figure, &format!("{drive} s/{way}"));
            }
        }
        text += &line("Coulomb friction", body.coulomb, drive);
        if let Some(stribeck) = &body.stribeck {
            text += &line("breakaway above it (Stribeck)", stribeck.above, drive);
            text += &format!(
                "  falls to 37 % at {} {}/s\n",
                figures(stribeck.speed / self.base),
                self.unit.symbol()
            );
        }
        text += &line("constant force", body.constant, drive);
        text += &format!(
            "  {} % of the force is left unexplained\n",
            figures(100.0 * body.residual_share)
        );
        text
    }

    fn servo(&self, servo: &ServoGains) -> String {
        let mut text = line("lag behind the command", servo.lag_s.times(1e3), "ms");
        let Some(law) = &servo.law else {
            return text;
        };
        let way = if self.unit == AxisUnit::Mm {
            "m"
        } else {
            "rad"
        };
        text += &line("position gain", law.position_gain_per_s, "1/s");
        text += &line(
            "velocity gain",
            law.velocity_gain,
            &format!("{} s/{way}", self.drive_unit),
        );
        match law.integral_time_s {
            Some(time) => {
                text += &format!(
                    "integral time of the velocity loop: {} ms\n",
                    figures(1e3 * time)
                );
            }
            None => text += "the velocity loop has no integral part\n",
        }
        text += &format!(
            "velocity feed-forward {}, measured speed {} ms old; {} % of the current is left unexplained\n",
            figures(law.feedforward),
            figures(1e3 * law.delay_s),
            figures(100.0 * law.residual_share),
        );
        text
    }

    fn body_findings(&self, body: &RigidBody, axis: &AxisConfig) -> Vec<Finding> {
        if !self.has_force() || !body.is_one_body() {
            return Vec::new();
        }
        let r = self.per_rad;
        // What the motor's side has of it, at the load.
        let less = |figure: Figure, own: f64| Figure {
            value: figure.value - own,
            error: figure.error,
            interval: figure.interval.map(|end| end - own),
        };
        let inertia = less(body.inertia, axis.motor_side_inertia_kgm2() / (r * r));
        let viscous = less(body.viscous, axis.motor.viscous_nm_s_per_rad / (r * r));
        let coulomb = less(body.coulomb, axis.motor.coulomb_nm / r);
        let finding = |table, key, unit, described, measured| Finding {
            table,
            key,
            unit,
            described,
            measured,
        };
        match &axis.load {
            Load::Slide(load) => vec![
                finding("load.slide", "mass_kg", "kg", load.mass_kg, inertia),
                finding(
                    "load.slide",
                    "viscous_n_s_per_m",
                    "N s/m",
                    load.viscous_n_s_per_m,
                    viscous,
                ),
                finding("load.slide", "coulomb_n", "N", load.coulomb_n, coulomb),
                finding(
                    "load.slide",
                    "constant_n",
                    "N",
                    load.constant_n,
                    body.constant,
                ),
            ],
            Load::Table(load) => vec![
                finding(
                    "load.table",
                    "inertia_kgm2",
                    "kg m2",
                    load.inertia_kgm2,
                    inertia,
                ),
                finding(
                    "load.table",
                    "viscous_nm_s_per_rad",
                    "N m s/rad",
                    load.viscous_nm_s_per_rad,
                    viscous,
                ),
                finding("load.table", "coulomb_nm", "N m", load.coulomb_nm, coulomb),
                finding(
                    "load.table",
                    "constant_nm",
                    "N m",
                    load.constant_nm,
                    body.constant,
                ),
            ],
            Load::Reflected(load) => vec![
                finding(
                    "load.reflected",
                    "inertia_kgm2",
                    "kg m2",
                    load.inertia_kgm2,
                    inertia.times(r * r),
                ),
                finding(
                    "load.reflected",
                    "viscous_nm_s_per_rad",
                    "N m s/rad",
                    load.viscous_nm_s_per_rad,
                    viscous.times(r * r),
                ),
                finding(
                    "load.reflected",
                    "coulomb_nm",
                    "N m",
                    load.coulomb_nm,
                    coulomb.times(r),
                ),
                finding(
                    "load.reflected",
                    "constant_nm",
                    "N m",
                    load.constant_nm,
                    body.constant.times(r),
                ),
            ],
        }
    }

    fn servo_findings(&self, servo: &ServoGains, axis: &AxisConfig, log: &AxisLog) -> Vec<Finding> {
        let Some(law) = &servo.law else {
            return Vec::new();
        };
        let mut findings = vec![Finding {
            table: "drive",
            key: "position_gain_per_s",
            unit: "1/s",
            described: axis.drive.position_gain_per_s,
            measured: law.position_gain_per_s,
        }];
        // A force asked for by a speed at the load, as a current asked for by one of the motor.
        if matches!(log.drive, Some(DriveSignal::Current(_))) && self.has_force() {
            findings.push(Finding {
                table: "drive",
                key: "velocity_gain_a_s_per_rad",
                unit: "A s/rad",
                described: axis.drive.velocity_gain_a_s_per_rad,
                measured: law.velocity_gain.times(self.per_rad / self.drive),
            });
        }
        findings
    }
}

impl Finding {
    /// Whether the description is certainly another one, in words.
    fn verdict(&self) -> (String, bool) {
        let [low, high] = self.measured.interval;
        let outside = !(low..=high).contains(&self.described);
        let off = (self.described - self.measured.value).abs()
            > LEAST_DIFFERENCE * self.measured.value.abs();
        let differs = outside && off;
        let words = if differs {
            "DIFFERS"
        } else if outside {
            "agrees within 5 %"
        } else {
            "agrees"
        };
        let text = format!(
            "{}.{}: described {} {u}, measured {} (95 %: {} to {}): {words}\n",
            self.table,
            self.key,
            figures(self.described),
            figures(self.measured.value),
            figures(low),
            figures(high),
            u = self.unit,
        );
        (text, differs)
    }
}

/// The gap as `axis fit` finds it.
fn gap(
    log: &AxisLog,
    scales: &Scales,
    described: Option<&AxisConfig>,
    unit: AxisUnit,
    name: &str,
) -> Result<BacklashFit, String> {
    let (Some(axis), Some(DriveSignal::Current(current))) = (described, &log.drive) else {
        return Err("needs the load's position, a current, and --axis".to_owned());
    };
    if log.load.is_empty() {
        return Err("needs the load's position (a linear scale); `axis fit --motor-only` may tell them from a fast log".to_owned());
    }
    let scale = rad_per_unit(axis, unit, name).map_err(|failure| failure.text())?;
    debug_assert!(scales.base > 0.0);
    let scaled = |values: &[f64]| values.iter().map(|value| value * scale).collect();
    BacklashLog::from_rows(
        &log.time_s,
        scaled(&log.motor),
        scaled(&log.load),
        current.clone(),
    )
    .and_then(|log| fit_backlash(&log, &FitSettings::for_axis(axis)))
    .map_err(|error| error.to_string())
}

/// The gap's total and interval, m or rad at the load.
fn gap_figure(fit: &BacklashFit, per_rad: f64) -> Figure {
    Figure {
        value: 2.0 * fit.half_gap_rad * per_rad,
        error: 0.0,
        interval: fit.half_gap_interval_rad.map(|half| 2.0 * half * per_rad),
    }
}

fn gap_text(fit: &BacklashFit, scales: &Scales) -> String {
    let gap = gap_figure(fit, scales.per_rad).times(1.0 / scales.small);
    let mut text = line("gap", gap, scales.small_unit);
    if let Some(reason) = fit.reason.as_ref().filter(|_| !fit.excited) {
        text += &format!("  the log does not tell it from zero: {reason}\n");
    }
    text
}

fn gap_findings(fit: &BacklashFit, axis: &AxisConfig) -> Vec<Finding> {
    if !fit.excited {
        return Vec::new();
    }
    let per_rad = axis.transmission.load_per_motor_rad();
    let gap = gap_figure(fit, per_rad);
    let mut findings = match &axis.load {
        Load::Slide(load) => vec![Finding {
            table: "load.slide",
            key: "gap_um",
            unit: "um",
            described: load.gap_um,
            measured: gap.times(1e6),
        }],
        Load::Table(load) => vec![Finding {
            table: "load.table",
            key: "gap_mdeg",
            unit: "mdeg",
            described: load.gap_mdeg,
            measured: gap.times(1e3 * 1.0_f64.to_degrees()),
        }],
        Load::Reflected(load) => vec![Finding {
            table: "load.reflected",
            key: "gap_rad",
            unit: "rad",
            described: load.gap_rad,
            measured: gap.times(1.0 / per_rad),
        }],
    };
    // At the load: N/m from N m/rad of the motor.
    let told = (fit.stiffness_nm_per_rad, fit.stiffness_interval_nm_per_rad);
    if let (Some(value), [Some(low), Some(high)], Load::Slide(load)) = (told.0, told.1, &axis.load)
    {
        let at_load = Figure {
            value,
            error: 0.0,
            interval: [low, high],
        };
        findings.push(Finding {
            table: "load.slide",
            key: "stiffness_n_per_um",
            unit: "N/um",
            described: load.stiffness_n_per_um,
            measured: at_load.times(1e-6 / (per_rad * per_rad)),
        });
    }
    findings
}

fn write_overlay(
    path: &Path,
    log: &BodyLog,
    again: &Replayed,
    scales: &Scales,
) -> Result<(), Failure> {
    let mut file = output::create(path)?;
    let unwritten = |error| Failure::from(WriteError::io("write", path, error));
    let unit = scales.unit.symbol();
    let mut text = format!("t_s,motor_{unit},simulated_{unit},difference_{unit}\n");
    for (sample, (measured, simulated)) in log.motor.iter().zip(&again.position).enumerate() {
        let (measured, simulated) = (measured / scales.base, simulated / scales.base);
        text += &format!(
            "{:.6},{measured:.9},{simulated:.9},{:.9}\n",
            sample as f64 * log.period_s,
            simulated - measured
        );
        if text.len() > 1 << 16 {
            file.write_all(text.as_bytes()).map_err(unwritten)?;
            text.clear();
        }
    }
    file.write_all(text.as_bytes()).map_err(unwritten)?;
    file.commit()?;
    Ok(())
}

/// Writes the description with what was found, each value with its source.
fn write_axis(
    path: &Path,
    described: &AxisConfig,
    findings: &[Finding],
    log: &str,
    base: &str,
) -> Result<(), Failure> {
    let mut axis = described.clone();
    let mut sources: BTreeMap<(&str, &str), String> = BTreeMap::new();
    for finding in findings {
        // A value that nobody can have, such as friction below that of the motor, is not taken over.
        let told = finding.measured.is_told() && finding.measured.value > 0.0;
        if told && set(&mut axis, finding) {
            let [low, high] = finding.measured.interval.map(figures);
            let source = format!("measured: {log}, 95 %: {low} to {high}");
            sources.insert((finding.table, finding.key), source);
        } else {
            let source = format!("{base}; {log} does not tell it");
            sources.insert((finding.table, finding.key), source);
        }
    }
    axis.check()
        .map_err(|error| Failure::message(format!("{log}: the axis found is none: {error}")))?;
    let plain = axis_to_toml(&axis).map_err(|error| Failure::message(error.to_string()))?;
    let mut text = format!(
        "# From {log} by `lostmotion axis identify`; what it does not tell is from {base}.\n"
    );
    let mut table = String::new();
    for line in plain.lines() {
        text += line;
        if let Some(name) = line.strip_prefix('[') {
            table = name.trim_matches(['[', ']']).to_owned();
        } else if let Some((key, value)) = line.split_once(" = ")
            && !value.ends_with(['[', '{', ','])
        {
            let source = sources
                .get(&(table.as_str(), key))
                .map_or(base, String::as_str);
            text += &format!(" # {source}");
        }
        text.push('\n');
    }
    let mut file = output::create(path)?;
    file.write_all(text.as_bytes())
        .map_err(|error| WriteError::io("write", path, error))?;
    file.commit()?;
    Ok(())
}

/// Sets a value of the description; false where it has none of the kind.
fn set(axis: &mut AxisConfig, finding: &Finding) -> bool {
    let value = finding.measured.value;
    let place = match (finding.key, &mut axis.load) {
        ("position_gain_per_s", _) => &mut axis.drive.position_gain_per_s,
        ("velocity_gain_a_s_per_rad", _) => &mut axis.drive.velocity_gain_a_s_per_rad,
        ("mass_kg", Load::Slide(load)) => &mut load.mass_kg,
        ("viscous_n_s_per_m", Load::Slide(load)) => &mut load.viscous_n_s_per_m,
        ("coulomb_n", Load::Slide(load)) => &mut load.coulomb_n,
        ("constant_n", Load::Slide(load)) => &mut load.constant_n,
        ("gap_um", Load::Slide(load)) => &mut load.gap_um,
        ("stiffness_n_per_um", Load::Slide(load)) => &mut load.stiffness_n_per_um,
        ("inertia_kgm2", Load::Table(load)) => &mut load.inertia_kgm2,
        ("viscous_nm_s_per_rad", Load::Table(load)) => &mut load.viscous_nm_s_per_rad,
        ("coulomb_nm", Load::Table(load)) => &mut load.coulomb_nm,
        ("constant_nm", Load::Table(load)) => &mut load.constant_nm,
        ("gap_mdeg", Load::Table(load)) => &mut load.gap_mdeg,
        ("inertia_kgm2", Load::Reflected(load)) => &mut load.inertia_kgm2,
        ("viscous_nm_s_per_rad", Load::Reflected(load)) => &mut load.viscous_nm_s_per_rad,
        ("coulomb_nm", Load::Reflected(load)) => &mut load.coulomb_nm,
        ("constant_nm", Load::Reflected(load)) => &mut load.constant_nm,
        ("gap_rad", Load::Reflected(load)) => &mut load.gap_rad,
        _ => return false,
    };
    *place = value;
    true
}
